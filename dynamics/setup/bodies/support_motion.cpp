// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/bodies/support_motion.hpp"

#include "common/base/error.hpp"

namespace cbr {
namespace {

bool moves(const BoundaryCondition& condition, int axis) {
  return condition.motion != SupportMotion::none && condition.value[axis] != 0;
}

bool move_alike(const BoundaryCondition& a, const BoundaryCondition& b, int axis) {
  if (!moves(a, axis) && !moves(b, axis)) return true;
  return a.motion == b.motion && a.value[axis] == b.value[axis] &&
         a.history.time == b.history.time && a.history.value == b.history.value;
}

}  // namespace

DrivenMotion support_motion(const SceneIndex& index, const Instance& instance) {
  DrivenMotion motion;
  for (int axis = 0; axis < 3; ++axis) {
    const BoundaryCondition* first = nullptr;
    for (const BoundaryCondition* condition : index.boundary(instance)) {
      if (!condition->fix[axis]) continue;
      if (first == nullptr) first = condition;
      if (!move_alike(*first, *condition, axis))
        throw InputError(condition->source.text() + ": boundary: '" + condition->nodes +
                         "' of instance '" + instance.name + "' moves unlike '" + first->nodes +
                         "' along " + "xyz"[axis] +
                         ": supports of one instance move together along an axis; give both the "
                         "same motion, or leave the axis out "
                         "of one 'fix'");
    }
    if (first == nullptr || !moves(*first, axis)) continue;
    motion.axes[axis].emplace_back(first->motion, first->value[axis], first->history,
                                   instance.velocity[axis], index.scene().time->end);
  }
  return motion;
}

}  // namespace cbr
