// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement with statics in equilibrium: modes as ever, and what forces do at once.
#include "common/files/state_archive.hpp"
#include "dynamics/motion/modal/statics_body.hpp"

namespace cbr {
namespace {

// B F B^T of a set's nodes   (3 m x 3 m)
Matrix formed(const StaticRows& rows, Index n_nodes) {
  Matrix all = Matrix::Zero(3 * n_nodes, 3 * n_nodes);
  for (Index j = 0; j < rows.size(); ++j)
    for (Index i = 0; i < rows.size(); ++i)
      all.block<3, 3>(3 * rows.node[i], 3 * rows.node[j]) +=
          (*rows.F)(i, j) * rows.direction.row(i).transpose() * rows.direction.row(j);
  return all;
}

}  // namespace

void StaticsBody::keep_load_step() {
  load_step_.w.clear();
  load_step_.force.clear();
  for (const NodeSet& set : sets_) {
    load_step_.w.push_back(set.w);
    load_step_.force.push_back(set.force);
  }
  load_step_.g = g_;
  load_step_.loads = loads_now_;
}

void StaticsBody::own_relax(double t, double share) {
  if (load_step_.g.size() == 0) {
    // The statics of loads that take_plan() found at the start come with the first load step
    g_.setZero();
    for (NodeSet& set : sets_) set.w.setZero();
    std::fill(loads_now_.begin(), loads_now_.end(), 0.0);
    keep_load_step();
  }
  modal_.relax(t, share);
  following_ = 1;  // a force is as it is
  g_end_.setZero();
  for (NodeSet& set : sets_) {
    for (Vector* x : {&set.w_end, &set.force_end}) x->setZero();
  }
  for (std::size_t l = 0; l < loads_.size(); ++l) {
    loads_end_[l] = share * loads_[l].history.value(t);
    g_end_ += loads_end_[l] * loads_[l].f;
    for (NodeSet& set : sets_)
      for (std::size_t i = 0; i < set.of->row.size(); ++i)
        set.w_end[static_cast<Index>(i)] += loads_end_[l] * loads_[l].Ff[set.of->row[i]];
  }
  is_pushed_ = true;
}

NodeResponse StaticsBody::massless_static_response(const NodeSet& set, const ResponseOf& of,
                                                   const Vector& weight) const {
  NodeResponse response;
  response.set_block(*modal_.node_rows(set.modal).response(of, weight) +
                     formed(*set.of->rows, static_cast<Index>(set.of->nodes.size())));
  response.axes = T_;
  return response;
}

Matrix StaticsBody::own_floating_motions(Index set) const {
  return modal_.floating_motions(sets_[set].modal);
}

FloatingForces StaticsBody::floating_forces() const { return modal_.floating_forces(); }

void StaticsBody::float_by(const Vector& move) { modal_.float_by(move); }

NodeResponse StaticsBody::own_static_response(Index set) const {
  Vector weight;
  const ResponseOf of = modal_.static_response_of(weight);
  if (form_->is_massless) return massless_static_response(sets_[set], of, weight);
  NodeResponse response;
  response.thin = form_->response(sets_[set].of, of, weight, beta_);
  response.axes = T_;
  return response;
}

void StaticsBody::own_add_static_forces(Index set, const Points& forces) {
  NodeSet& its = sets_[set];
  pressed_by(its, forces, pressed_);
  rows_ = pressed_;
  press(*its.of->rows, rows_, still_, columns_);
  push(set, pressed_, still_.col(0));
  modal_.add_static_forces(its.modal, forces);
}

Settled StaticsBody::own_settle() {
  Settled settled = modal_.settle();
  const Vector change = g_end_ - g_;
  settled.change += change.dot(*form_->rows.F * change);
  settled.energy += g_end_.dot(*form_->rows.F * g_end_);
  for (NodeSet& set : sets_) {
    set.w = set.w_end;
    set.force = set.force_end;
  }
  g_ = g_end_;
  loads_now_ = loads_end_;
  has_force_ = true;
  return settled;
}

void StaticsBody::own_end_load_step() {
  modal_.end_load_step();
  for (std::size_t s = 0; s < sets_.size(); ++s) {
    const Vector move = sets_[s].w - load_step_.w[s];
    work_.contact += 0.5 * move.dot(load_step_.force[s] + sets_[s].force);
  }
  for (std::size_t l = 0; l < loads_.size(); ++l)
    work_.external +=
        0.5 * (load_step_.loads[l] + loads_now_[l]) * loads_[l].Ff.dot(g_ - load_step_.g);
  keep_load_step();
}

// Forces that last have been followed for long.
void StaticsBody::own_start_motion(double h, const std::vector<BodyLoad>& loads) {
  add_statics(loads);
  if (load_step_.g.size() == 0) return modal_.start_motion(h, loads);
  work_ = BodyWork();
  h_ = h;
  g_before_ = g_;
  was_in_contact_ = has_force_ = true;
  still_left_ = 1;
  if (form_->is_massless) {
    eta_before_ = modal_.modal_coordinates();
    modal_.start_late_motion(h, loads);
  } else {
    modal_.start_motion(h, loads);
  }
}

void StaticsBody::own_keep_state(StateArchive& archive) {
  modal_.keep_state(archive);
  archive.expect(static_cast<Index>(sets_.size()));
  archive(g_, g_before_, eta_before_, loads_now_, t_, h_, work_, was_in_contact_, has_force_,
          still_left_);
  for (NodeSet& set : sets_) archive(set.w, set.force, set.rate_before, set.friction);
  bool is_still = load_step_.g.size() > 0;
  archive(is_still);
  if (is_still && archive.restores()) keep_load_step();
}

}  // namespace cbr
