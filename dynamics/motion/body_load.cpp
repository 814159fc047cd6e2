// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/body_load.hpp"

#include <utility>

#include "common/base/error.hpp"

namespace cbr {

NodalForces::NodalForces(const Points& forces) : n_(forces.rows()) {
  for (Index i = 0; i < n_; ++i)
    if (!forces.row(i).isZero(0)) nodes_.push_back(i);
  forces_ = forces(nodes_, Eigen::all);
}

Points NodalForces::on_nodes() const {
  Points all = Points::Zero(n_, 3);
  all(nodes_, Eigen::all) = forces_;
  return all;
}

void NodalForces::add_to(Eigen::Matrix<double, Eigen::Dynamic, 3>& f, double factor) const {
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    f.row(nodes_[i]) += factor * forces_.row(static_cast<Index>(i));
}

BodyLoad force_load(const Points& forces, LoadHistory history) {
  return {.fixed = {forces}, .history = std::move(history)};
}

BodyLoad gravity_load(const Vector3& acceleration, LoadHistory history) {
  return {.acceleration = acceleration, .history = std::move(history)};
}

ForcePattern forces_of(const BodyLoad& load) {
  if (!load.vector) return load.fixed;
  Points forces = load.fixed.forces.on_nodes();
  Vector modal = load.fixed.modal;
  for (Index a = 0; a < 3; ++a) {
    const ForcePattern& pattern = load.vector->patterns[a];
    const double b = load.vector->value[a];
    const Points of_pattern = pattern.forces.on_nodes();
    if (forces.rows() == 0) forces.setZero(of_pattern.rows(), 3);
    if (b == 0) continue;
    if (of_pattern.rows() > 0) forces += b * of_pattern;
    if (pattern.modal.size() == 0) continue;
    if (modal.size() == 0) modal.setZero(pattern.modal.size());
    modal += b * pattern.modal;
  }
  return {forces, modal};
}

void require_no_modal_forces(const BodyLoad& load, const std::string& name) {
  bool any = load.fixed.modal.size() > 0;
  if (load.vector)
    for (const ForcePattern& pattern : load.vector->patterns) any |= pattern.modal.size() > 0;
  if (!any) return;
  throw InputError("instance '" + name +
                   "': a load on faces inside the part acts on superelements of basis "
                   "craig-bampton only: take the faces into the interface");
}

}  // namespace cbr
