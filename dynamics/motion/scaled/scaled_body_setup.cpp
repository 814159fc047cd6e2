// SPDX-License-Identifier: GPL-3.0-or-later
// From nodes and loads that were announced to the arrays of a scaled body.

#include <numeric>
#include <utility>

#include "dynamics/motion/scaled/scaled_body.hpp"

namespace cbr {

void ScaledBody::append_load(Load load) {
  loaded_ = true;
  const std::size_t place = load_of_.find_or_add(load.history, loads_.size());
  if (place == loads_.size()) {
    breakpoints_.add(load.history);
    loads_.push_back(std::move(load));
    return;
  }
  Load& other = loads_[place];
  other.rigid += load.rigid;
  if (other.forces.size() == 0) {
    other.forces = std::move(load.forces);
  } else if (load.forces.size() > 0) {
    other.forces += load.forces;
  }
}

void ScaledBody::take_plan(const BodyPlan& plan) {
  contact_step_ = plan.contact_step;
  for (const BodyLoad& of : plan.loads) {
    require_no_modal_forces(of, name());
    Load load;
    load.rigid.setZero();
    load.history = of.history;
    if (of.acceleration) load.rigid.head<3>() = placement_.T.transpose() * *of.acceleration;
    // T^T f of each node
    if (const NodalForces forces = forces_of(of).forces)
      load.forces = forces.on_nodes() * placement_.T;
    append_load(std::move(load));
  }
  scale(plan.clip);
}

// Nodal forces of the loads in the order of V's rows   (n x loads)
Matrix ScaledBody::force_columns() const {
  Matrix F = Matrix::Zero(modes_->V.rows(), static_cast<Index>(loads_.size()));
  for (Index l = 0; l < F.cols(); ++l) {
    const Points& forces = loads_[l].forces;
    for (Index i = 0; i < forces.rows(); ++i)
      for (int d = 0; d < 3; ++d)
        if (modes_->rows(i, d) >= 0) F(modes_->rows(i, d), l) += forces(i, d);
  }
  return F;
}

void ScaledBody::fill_loads() {
  const ScaledModes& modes = *modes_;
  const Index n = n_tracked(), loads = static_cast<Index>(loads_.size());
  const Matrix F = force_columns();
  Matrix rigid(6, loads);
  for (Index l = 0; l < loads; ++l) rigid.col(l) = loads_[l].rigid;
  // V^T (F + M^ R rigid)   (n_kept x loads)
  load_modal_ = modes.V.transpose().lazyProduct(F);
  load_modal_ += modes.E.lazyProduct(rigid);
  if (!modes.part) return;
  const bool held = modes.rigid_gram.size() > 0;
  // S (F + M^ R rigid)   (n x loads)
  Matrix U = loads > 0 ? modes.part->times(F) : Matrix(F.rows(), 0);
  if (held) U += modes.rigid_response.lazyProduct(rigid);
  load_scaled_ = Matrix::Zero(n + loads, loads);
  const auto row = [&](Index i) { return modes.rows(tracked_[i / 3], i % 3); };
  for (Index i = 0; i < n; ++i)
    if (row(i) >= 0) load_scaled_.row(i) = U.row(row(i));
  load_scaled_.bottomRows(loads) = F.transpose().lazyProduct(U);
  if (!held) return;
  // R^T M^ S of the loads   (6 x loads)
  const Matrix momentum =
      modes.rigid_response.transpose().lazyProduct(F) + modes.rigid_gram.lazyProduct(rigid);
  load_scaled_.bottomRows(loads) += rigid.transpose().lazyProduct(momentum);
  rigid_scaled_ = Matrix::Zero(6, n + loads);
  for (Index i = 0; i < n; ++i)
    if (row(i) >= 0) rigid_scaled_.col(i) = modes.rigid_response.row(row(i)).transpose();
  rigid_scaled_.rightCols(loads) = momentum;
}

void ScaledBody::fill_mean(MeanSet& set) const {
  const ScaledModes& modes = *modes_;
  const double share = 1 / static_cast<double>(set.nodes.size());
  Matrix F = Matrix::Zero(modes.V.rows(), 3);  // mean of the nodes' displacements = F^T u
  for (const Index node : set.nodes)
    for (int d = 0; d < 3; ++d)
      if (modes.rows(node, d) >= 0) F(modes.rows(node, d), d) += share;
  set.Vt = modes.V.transpose().lazyProduct(F);
  if (!modes.part) return;
  const Matrix U = modes.part->times(F);  // S F   (n x 3)
  const Index n = n_tracked(), loads = load_modal_.cols();
  set.St = Matrix::Zero(n + loads, 3);
  for (Index i = 0; i < n; ++i)
    if (const Index row = modes.rows(tracked_[i / 3], i % 3); row >= 0) set.St.row(i) = U.row(row);
  if (loads == 0) return;
  set.St.bottomRows(loads) = force_columns().transpose().lazyProduct(U);
  for (Index l = 0; l < loads && modes.rigid_gram.size() > 0; ++l)
    set.St.row(n + l) +=
        loads_[l].rigid.transpose() * modes.rigid_response.transpose().lazyProduct(F);
}

void ScaledBody::scale(double clip) {
  modes_ = model_->clipped(tracked_.empty() ? HUGE_VAL : clip);
  if (modes_->largest_frequency() * contact_step_ > 2.1) contact_step_ = 0;  // forced steps
  if (contact_step_ > 0)
    gain_ = ScaledGain(modes_->omega, modes_->part ? modes_->clip : HUGE_VAL, contact_step_);
  // Free bodies move rigidly by kept modes alone: then the velocity at the start is no load on the
  // scaled part
  if (modes_->rigid_gram.size() == 0 && !loads_.empty() && !loads_.front().is_load)
    loads_.erase(loads_.begin());
  rows_ = modes_->node_rows(tracked_);
  for (NodeSet& set : sets_) {
    set.whole = set.slot.size() == tracked_.size();
    for (std::size_t i = 0; set.whole && i < set.slot.size(); ++i)
      set.whole = set.slot[i] == static_cast<Index>(i);
    if (set.whole) set.rows = rows_;
  }
  fill_loads();
  for (MeanSet& set : means_) fill_mean(set);
  const Index kept = modes_->n_kept(), loads = load_modal_.cols(),
              scaled = modes_->part ? n_tracked() + loads : 0;
  for (ScaledState* state : {&now_, &end_, &part_}) state->set_zero(kept, scaled);
  for (ScaledKick* kick : {&kick_, &friction_, &fresh_}) kick->set_zero(kept, scaled);
  for (ScaledLoad* load : {&f0_, &f1_}) load->set_zero(kept, scaled, loads);
  local_.setZero(n_tracked());
  weighted_.setZero(kept);
  // v = V^T M^ R v0: the rigid motion, or its projection when directions are held; then S takes its
  // share as of an impulse M^ R v0
  now_.v = modes_->E.leftCols(3) * (placement_.T.transpose() * placement_.velocity);
  if (loads > 0 && !loads_.front().is_load) {
    now_.dr[scaled - loads] = 1;
    now_.dy = load_scaled_.col(0);
  }
}

}  // namespace cbr
