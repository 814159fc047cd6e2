// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/bodies/massless_body.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace cbr {
namespace {

// sum of the products of all entries
double dot(const Points& a, const Points& b) { return a.cwiseProduct(b).sum(); }

std::shared_ptr<const DiagonalForm> modal_of(const std::shared_ptr<const MasslessForm>& form) { return {form, &form->modal}; }

}  // namespace

MasslessBody::MasslessBody(std::string name, std::shared_ptr<const Superelement> superelement,
                           std::shared_ptr<const MasslessForm> form, const Placement& placement, Scheme scheme)
    : modal_(std::move(name), superelement, modal_of(form), placement, scheme),
      superelement_(std::move(superelement)),
      form_(std::move(form)),
      T_(placement.T),
      k_(superelement_->k()),
      rows_(form_->modal.shared.row_table(*superelement_)) {
  assert(scheme != Scheme::newmark);
  for (Vector* g : {&g_, &g_end_, &g_before_}) g->setZero(form_->F.rows());
  eta_before_ = modal_.modal_coordinates();
}

Index MasslessBody::track(const std::vector<Index>& nodes) {
  NodeSet set;
  set.modal = modal_.track(nodes), set.nodes = nodes;
  for (Points* p : {&set.w, &set.w_end, &set.force, &set.force_end, &set.friction, &set.friction_end})
    p->setZero(static_cast<Index>(nodes.size()), 3);
  sets_.push_back(std::move(set));
  return static_cast<Index>(sets_.size()) - 1;
}

Index MasslessBody::track_mean(const std::vector<Index>& nodes) {
  MeanSet set;
  set.modal = modal_.track_mean(nodes);
  set.Vt = form_->modal.shared.mean_rows(form_->modal.V, *rows_, nodes);
  set.F.setZero(form_->F.rows(), 3);
  for (const Index node : nodes)
    for (int d = 0; d < 3; ++d)
      if (row(node, d) >= 0) set.F.col(d) += form_->F.col(row(node, d)) / static_cast<double>(nodes.size());
  means_.push_back(std::move(set));
  return static_cast<Index>(means_.size()) - 1;
}

// u += factor T u_c of the nodes
void MasslessBody::add_rows(const Vector& u_c, double factor, const std::vector<Index>& nodes, Points& u) const {
  if (factor == 0) return;
  for (Index i = 0; i < u.rows(); ++i) {
    Vector3 local = Vector3::Zero();
    for (int d = 0; d < 3; ++d)
      if (const Index r = row(nodes[i], d); r >= 0) local[d] = u_c[r];
    u.row(i) += factor * (T_ * local).transpose();
  }
}

void MasslessBody::positions(Index set, Points& x) const {
  modal_.positions(sets_[set].modal, x);
  x += sets_[set].w;
}

void MasslessBody::predicted_positions(Index set, Points& x) const {
  modal_.predicted_positions(sets_[set].modal, x);
  x += sets_[set].w_end;
}

void MasslessBody::predict(double t, double h) {
  t_ = t, h_ = h, is_pushed_ = false;
  modal_.predict(t, h);
  for (NodeSet& set : sets_) set.w_end.setZero(), set.force_end.setZero(), set.friction_end.setZero();
  g_end_.setZero();
  for (std::size_t l = 0; l < loads_.size(); ++l) {
    loads_end_[l] = loads_[l].history.value(t + h);
    g_end_ += loads_end_[l] * loads_[l].f;
    for (NodeSet& set : sets_) add_rows(loads_[l].Ff, loads_end_[l], set.nodes, set.w_end);
  }
}

// lambda += impulses / h, in all that is kept of it; move: F lambda of the set's nodes.
void MasslessBody::push(Index set, const Points& impulses, const Points& move) {
  NodeSet& its = sets_[set];
  is_pushed_ = true;
  its.w_end += move;
  its.force_end += impulses / h_;
  Vector change;
  if (sets_.size() > 1) change.setZero(g_end_.size());
  for (Index i = 0; i < impulses.rows(); ++i) {
    if (impulses.row(i).isZero(0)) continue;
    const Vector3 local = T_.transpose() * impulses.row(i).transpose() / h_;
    for (int d = 0; d < 3; ++d) {
      const Index r = row(its.nodes[i], d);
      if (r < 0) continue;
      g_end_[r] += local[d];
      if (sets_.size() > 1) change[r] += local[d];
    }
  }
  if (sets_.size() == 1) return;
  const Vector u_c = form_->F * change;
  for (std::size_t other = 0; other < sets_.size(); ++other)
    if (static_cast<Index>(other) != set) add_rows(u_c, 1, sets_[other].nodes, sets_[other].w_end);
}

void MasslessBody::add_impulses(Index set, const Points& impulses, ImpulseKind kind) {
  Points move = Points::Zero(impulses.rows(), 3);
  response(set, h_).add_product(impulses, move);
  push(set, impulses, move);
  if (kind == ImpulseKind::friction) sets_[set].friction_end += impulses / h_;
  modal_.add_end_impulses(sets_[set].modal, impulses, kind);
}

void MasslessBody::add_answered_impulses(Index set, const Points& contact, const Points& friction, const Points& move) {
  push(set, contact + friction, move);
  sets_[set].friction_end += friction / h_;
  modal_.add_end_impulses(sets_[set].modal, contact, ImpulseKind::contact);
  if (!friction.isZero(0)) modal_.add_end_impulses(sets_[set].modal, friction, ImpulseKind::friction);
}

Vector3 MasslessBody::add_velocities(Index, const Points&, const Vector3&) {
  assert(false && "an interface without mass has no velocity to change");
  return Vector3::Zero();
}

Points MasslessBody::nodal_masses(Index set) const { return Points::Zero(static_cast<Index>(sets_[set].nodes.size()), 3); }

// The statics' energy 1/2 g . F g changes by exactly what mean forces do on its displacements.
void MasslessBody::accept() {
  for (NodeSet& set : sets_) {
    if (is_pushed_ || has_force_) {
      const double all = 0.5 * dot(set.force + set.force_end, set.w_end - set.w);
      const double friction = 0.5 * dot(set.friction + set.friction_end, set.w_end - set.w);
      work_.friction += friction, work_.contact += all - friction;
      set.force.swap(set.force_end), set.friction.swap(set.friction_end);
    }
    set.w.swap(set.w_end);
  }
  for (std::size_t l = 0; l < loads_.size(); ++l)
    work_.external += 0.5 * (loads_now_[l] + loads_end_[l]) * loads_[l].Ff.dot(g_end_ - g_);
  loads_now_.swap(loads_end_);
  was_in_contact_ = is_pushed_ || has_force_;
  has_force_ = is_pushed_;
  if (was_in_contact_) eta_before_ = modal_.modal_coordinates(), g_before_ = g_;
  g_.swap(g_end_);
  modal_.accept();
}

NodeResponse MasslessBody::response(Index set, double h) const {
  NodeResponse response;
  response.block = form_->response(*rows_, sets_[set].nodes, h);
  response.axes = T_;
  return response;
}

void MasslessBody::add_force(const Points& forces, const LoadHistory& history) {
  modal_.add_force(forces, history);
  StaticLoad load{Vector::Zero(g_.size()), {}, history};
  for (Index i = 0; i < forces.rows(); ++i) {
    const Vector3 local = T_.transpose() * forces.row(i).transpose();
    for (int d = 0; d < 3; ++d)
      if (row(i, d) >= 0) load.f[row(i, d)] += local[d];
  }
  load.Ff = form_->F * load.f;
  const double now = history.value(t_);
  g_ += now * load.f;
  for (NodeSet& set : sets_) add_rows(load.Ff, now, set.nodes, set.w);
  loads_.push_back(std::move(load));
  loads_now_.push_back(now), loads_end_.push_back(now);
}

MotionBound MasslessBody::motion_bound(Index set) const { return with_statics(modal_.motion_bound(sets_[set].modal), set); }
MotionBound MasslessBody::quick_motion_bound(Index set) const {
  return with_statics(modal_.quick_motion_bound(sets_[set].modal), set);
}

// The interface springs back to where its modes are once it is let go.
MotionBound MasslessBody::with_statics(MotionBound bound, Index set) const {
  const NodeSet& its = sets_[set];
  Vector3 spread = its.w.cwiseAbs().colwise().maxCoeff().transpose();
  for (const StaticLoad& load : loads_) {
    const double largest = load.history.largest();
    Points w = Points::Zero(its.w.rows(), 3);
    add_rows(load.Ff, largest, its.nodes, w);
    spread += w.cwiseAbs().colwise().maxCoeff().transpose();
  }
  bound.lower -= spread, bound.upper += spread;
  return bound;
}

// What contact holds follows what it meets: its velocity is that of the last step, not of the modes.
void MasslessBody::mean_motion(Index set, Vector3& position, Vector3& velocity) const {
  const MeanSet& its = means_[set];
  modal_.mean_motion(its.modal, position, velocity);
  position += T_ * Vector3(its.F.transpose() * g_);
  if (!was_in_contact_) return;
  const Vector3 moved = its.Vt->transpose() * (modal_.modal_coordinates() - eta_before_) + its.F.transpose() * (g_ - g_before_);
  velocity = T_ * (moved / h_);
}

BodyState MasslessBody::state() const {
  BodyState state = modal_.state();
  // 1/2 g . F g
  for (const NodeSet& set : sets_) state.strain_energy += 0.5 * dot(set.force, set.w);
  for (std::size_t l = 0; l < loads_.size(); ++l) state.strain_energy += 0.5 * loads_now_[l] * loads_[l].Ff.dot(g_);
  return state;
}

BodyWork MasslessBody::work() const {
  BodyWork work = modal_.work();
  work.external += work_.external, work.contact += work_.contact, work.friction += work_.friction;
  return work;
}

void MasslessBody::coordinates(Vector& q, Vector& rates) const {
  modal_.coordinates(q, rates);
  const Vector u_c = form_->F * g_;
  Vector moved;  // in the last step   (k + c)
  if (was_in_contact_) {
    moved = form_->modal.V * (modal_.modal_coordinates() - eta_before_) / h_;
    moved.tail(g_.size()) += form_->F * (g_ - g_before_) / h_;
    rates.head(k_) = moved.head(k_);
  }
  for (Index i = 0; i < reference_positions().rows(); ++i) {
    for (int d = 0; d < 3; ++d) {
      const Index r = row(i, d);
      if (r < 0) continue;
      q[k_ + 3 * i + d] += u_c[r];
      if (was_in_contact_) rates[k_ + 3 * i + d] = moved[k_ + r];
    }
  }
}

void MasslessBody::displacements(Points& u, Points& v) const {
  Vector q, rates;
  coordinates(q, rates);
  const Index n = reference_positions().rows();
  u = Eigen::Map<const Points>(q.data() + k_, n, 3) * T_.transpose();
  v = Eigen::Map<const Points>(rates.data() + k_, n, 3) * T_.transpose();
}

}  // namespace cbr
