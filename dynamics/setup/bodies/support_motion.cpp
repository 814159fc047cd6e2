// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/bodies/support_motion.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <numbers>
#include <set>

#include "common/base/error.hpp"

namespace cbr {
namespace {

// Relative difference of the motions of one node by two conditions, due to round-off of the arm.
constexpr double same_motion = 1e-9;

std::array<bool, 3> held_rotations(const BoundaryCondition& condition) {
  // By default a fully constrained node does not rotate
  const bool is_whole = condition.fix[0] && condition.fix[1] && condition.fix[2];
  return condition.fix_rotations.value_or(std::array<bool, 3>{is_whole, is_whole, is_whole});
}

// Constrained displacements of the nodes of a condition, and their rotations.
std::vector<HeldAxis> held_by(const BoundaryCondition& condition, const Instance& instance,
                              const Geometry& geometry) {
  std::vector<HeldAxis> held;
  const auto of_rotations = held_rotations(condition);
  for (const Index node : find_nodes(geometry, instance.name, condition.nodes, condition.source)) {
    for (int c = 0; c < 3; ++c)
      if (condition.fix[c]) held.push_back({node, c});
    const auto rotation = geometry.rotations.find(node);
    for (int c = 0; c < 3 && rotation != geometry.rotations.end(); ++c)
      if (of_rotations[c]) held.push_back({rotation->second, c});
  }
  return held;
}

// Positions of nodes, and which are rotation nodes.
class Places {
 public:
  Places(const Instance& instance, const Geometry& geometry)
      : geometry_(geometry), T_(instance.transformation()), position_(instance.position) {
    for (const auto& [node, rotation] : geometry.rotations) rotations_.insert(rotation);
  }
  bool is_rotation(Index node) const { return rotations_.contains(node); }
  Vector3 at(Index node) const {
    return T_ * geometry_.coordinates.row(node).transpose() + position_;
  }
  Vector3 center(const std::vector<Index>& nodes) const {
    Vector3 sum = Vector3::Zero();
    for (const Index node : nodes) sum += at(node);
    return sum / static_cast<double>(nodes.size());
  }
  // Displacement along the axis by a translation and a rotation about a point.
  double moved(const HeldAxis& held, const Vector3& translation, const Vector3& rotation,
               const Vector3& point) const {
    // A mirrored instance reverses the axes of rotations
    if (is_rotation(held.node)) return T_.determinant() * rotation[held.axis];
    return translation[held.axis] + rotation.cross(at(held.node) - point)[held.axis];
  }

 private:
  const Geometry& geometry_;
  Matrix3 T_;
  Vector3 position_;
  std::set<Index> rotations_;
};

// Time functions of prescribed motions by kind and history, which supports scale. `coasts`: the
// part due to the instance's initial velocity.
class Drives {
 public:
  explicit Drives(const TimeOptions& time) : time_(time) {}
  Index find_or_add(const BoundaryCondition& of, bool coasts) {
    for (std::size_t i = 0; i < known_.size(); ++i) {
      const Known& known = known_[i];
      const bool is_one =
          known.motion == of.motion && known.coasts == coasts && known.history == of.history;
      if (is_one) return static_cast<Index>(i);
    }
    known_.push_back({of.motion, of.history, coasts});
    axes_.emplace_back(of.motion, coasts ? 0 : 1, of.history, coasts ? 1 : 0, time_);
    return static_cast<Index>(known_.size()) - 1;
  }
  const std::vector<DrivenAxis>& axes() const { return axes_; }

 private:
  struct Known {
    SupportMotion motion;
    History history;
    bool coasts;
  };
  const TimeOptions& time_;
  std::vector<Known> known_;
  std::vector<DrivenAxis> axes_;
};

// Motion of a condition's nodes: a multiple of a time function.
struct Part {
  Index drive = 0;
  Vector3 translation = Vector3::Zero(), rotation = Vector3::Zero();
};

std::vector<Part> parts_of(const BoundaryCondition& condition, const Instance& instance,
                           Drives& drives) {
  std::vector<Part> parts;
  if (condition.motion == SupportMotion::none) return parts;
  Part part, coast;
  for (int c = 0; c < 3; ++c) {
    if (!condition.fix[c] || condition.value[c] == 0) continue;
    part.translation[c] = condition.value[c];
    if (condition.motion != SupportMotion::velocity) coast.translation[c] = instance.velocity[c];
  }
  const bool is_angle = condition.motion == SupportMotion::displacement;
  part.rotation = (is_angle ? std::numbers::pi / 180 : 1) * condition.turn;
  if (!part.translation.isZero(0) || !part.rotation.isZero(0)) {
    part.drive = drives.find_or_add(condition, false);
    parts.push_back(part);
  }
  if (!coast.translation.isZero(0)) {
    coast.drive = drives.find_or_add(condition, true);
    parts.push_back(coast);
  }
  return parts;
}

// For each constrained axis its multiples of the time functions.
void take_drives(const SceneIndex& index, const Instance& instance, const Geometry& geometry,
                 const std::vector<HeldAxis>& held, SupportShapesWanted& wanted) {
  const Places places(instance, geometry);
  Drives drives(*index.scene().time);
  std::vector<std::vector<Part>> parts;
  for (const BoundaryCondition* condition : index.plan(instance).boundary)
    parts.push_back(parts_of(*condition, instance, drives));
  wanted.drives = drives.axes();
  const auto m = static_cast<Index>(wanted.drives.size());
  wanted.motion.setZero(static_cast<Index>(held.size()), m);
  std::vector<const BoundaryCondition*> first(held.size(), nullptr);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const BoundaryCondition& condition = *index.plan(instance).boundary[i];
    const Vector3 about = condition.about.value_or(
        places.center(find_nodes(geometry, instance.name, condition.nodes, condition.source)));
    for (const HeldAxis& axis : held_by(condition, instance, geometry)) {
      const auto at = std::lower_bound(held.begin(), held.end(), axis) - held.begin();
      Vector moved = Vector::Zero(m);
      for (const Part& part : parts[i])
        moved[part.drive] += places.moved(axis, part.translation, part.rotation, about);
      const BoundaryCondition*& of = first[at];
      if (of == nullptr) {
        of = &condition;
        wanted.motion.row(at) = moved.transpose();
        continue;
      }
      const Vector known = wanted.motion.row(at).transpose();
      // With reactions alone there are no drives, and no largest entry
      const double scale =
          std::max(moved.lpNorm<Eigen::Infinity>(), known.lpNorm<Eigen::Infinity>());
      if ((moved - known).lpNorm<Eigen::Infinity>() > same_motion * scale)
        throw InputError(condition.source.text() + ": boundary: '" + condition.nodes +
                         "' of instance '" + instance.name + "' moves unlike '" + of->nodes +
                         "' along " + "xyz"[axis.axis] +
                         (places.is_rotation(axis.node) ? " (a rotation)" : "") +
                         ", and they share nodes: give both the same motion there, or leave the "
                         "axis out of one 'fix'");
    }
  }
}

// Six rigid motions of the constrained axes of a set's nodes.
void take_set(const SceneIndex& index, const Instance& instance, const Geometry& geometry,
              const SurfaceName& set, const std::vector<HeldAxis>& held,
              SupportShapesWanted& wanted) {
  const Places places(instance, geometry);
  std::set<Index> members;
  Vector3 point = Vector3::Zero();
  const std::vector<Index> nodes = find_nodes(geometry, set.instance, set.surface, set.source);
  point = places.center(nodes);
  for (const BoundaryCondition* condition : index.plan(instance).boundary)
    if (condition->nodes == set.surface && condition->about) point = *condition->about;
  for (const Index node : nodes) {
    members.insert(node);
    if (const auto found = geometry.rotations.find(node); found != geometry.rotations.end())
      members.insert(found->second);
  }
  const Index first = wanted.motion.cols();
  wanted.motion.conservativeResize(Eigen::NoChange, first + 6);
  wanted.motion.rightCols(6).setZero();
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (!members.contains(held[i].node)) continue;
    for (int d = 0; d < 3; ++d) {
      const auto row = static_cast<Index>(i);
      const Vector3 zero = Vector3::Zero(), unit = Vector3::Unit(d);
      wanted.motion(row, first + d) = places.moved(held[i], unit, zero, point);
      wanted.motion(row, first + 3 + d) = places.moved(held[i], zero, unit, point);
    }
  }
  wanted.sets.push_back({set.surface, point});
}

}  // namespace

std::string why_hinged(const Scene& scene, const Instance& instance) {
  const Component& component = component_of(scene, instance);
  const bool has_shells =
      std::any_of(component.blocks.begin(), component.blocks.end(),
                  [](const auto& block) { return block.second.thickness.has_value(); });
  if (instance.as != InstanceKind::superelement || !component.reduction || !has_shells) return {};
  if (component.reduction->condenses_rotations)
    return "as reduction.condense_rotations: true put the rotations of its shells inside: set it "
           "to false and run cbr-reduce";
  return component.reduction->has_hinges() ? "as basis: massless has the rotations of its shells "
                                             "inside: take another basis and run cbr-reduce"
                                           : "";
}

std::vector<HeldAxis> held_axes(const SceneIndex& index, const Instance& instance,
                                const Geometry& geometry) {
  std::set<HeldAxis> held;
  for (const BoundaryCondition* condition : index.plan(instance).boundary) {
    bool any = false;
    for (const HeldAxis& axis : held_by(*condition, instance, geometry)) held.insert(axis);
    for (const Index node :
         find_nodes(geometry, instance.name, condition->nodes, condition->source))
      any |= geometry.rotations.contains(node);
    const bool wants_any =
        condition->fix_rotations.value_or(std::array<bool, 3>()) != std::array<bool, 3>();
    const std::string hinged = why_hinged(index.scene(), instance);
    if (wants_any && !any && !hinged.empty())
      throw InputError(condition->source.text() + ": boundary.rotations: '" + condition->nodes +
                       "' of instance '" + instance.name + "' has no rotations, " + hinged);
    if (wants_any && !any)
      throw InputError(condition->source.text() + ": boundary.rotations: no node of '" +
                       condition->nodes + "' of instance '" + instance.name +
                       "' has rotations, only those of shells and points have: leave it out");
  }
  return {held.begin(), held.end()};
}

DrivenMotion support_motion(const SceneIndex& index, const Instance& instance) {
  DrivenMotion motion;
  if (!index.plan(instance).moves_alike) return motion;
  for (int axis = 0; axis < 3; ++axis) {
    for (const BoundaryCondition* condition : index.plan(instance).boundary) {
      if (!condition->fix[axis]) continue;
      if (condition->moves(axis))
        motion.axes[axis].emplace_back(condition->motion, condition->value[axis],
                                       condition->history, instance.velocity[axis],
                                       *index.scene().time);
      break;
    }
  }
  return motion;
}

SupportShapesWanted support_shapes_wanted(const SceneIndex& index, const Instance& instance,
                                          const Geometry& geometry) {
  const std::vector<HeldAxis> held = held_axes(index, instance, geometry);
  SupportShapesWanted wanted;
  take_drives(index, instance, geometry, held, wanted);
  for (const SurfaceName& set : index.scene().output.reactions)
    if (set.instance == instance.name) take_set(index, instance, geometry, set, held, wanted);
  return wanted;
}

}  // namespace cbr
