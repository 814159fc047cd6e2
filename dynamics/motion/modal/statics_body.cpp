// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/statics_body.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace cbr {
namespace {

std::shared_ptr<const DiagonalForm> modal_of(const std::shared_ptr<const StaticsForm>& form) {
  return {form, &form->modal};
}

// w(rows)
void take_rows(const Vector& of_all, const std::vector<Index>& rows, double factor, Vector& w) {
  for (std::size_t i = 0; i < rows.size(); ++i)
    w[static_cast<Index>(i)] += factor * of_all[rows[i]];
}

// An interface without mass changes the energy as it lands and lets go. Of a bouncing bar it was
// 1.3e-3 at 0.16 of the critical step and 3.5e-2 at 0.33: docs/decisions/massless.md, "Steps".
constexpr double massless_share = 0.2;

}  // namespace

StaticsBody::StaticsBody(std::string name, std::shared_ptr<const Superelement> superelement,
                         std::shared_ptr<const StaticsForm> form, const Placement& placement,
                         Scheme scheme, const NewmarkOptions& newmark, const Damping& damping)
    : Body({.name = name,
            .scheme = scheme,
            .n_dofs = form->modal.omega.size(),
            .positions = placement.placed(superelement->coordinates),
            .steps_alone = scheme == Scheme::exact,
            .contact_share = form->is_massless ? massless_share : 1,
            .kicks_at_end = form->is_massless}),
      modal_(std::move(name), superelement, modal_of(form), placement, scheme, newmark, damping),
      superelement_(std::move(superelement)),
      form_(std::move(form)),
      T_(placement.T),
      k_(superelement_->k()),
      beta_(damping.material.beta) {
  assert(scheme != Scheme::newmark || !form_->is_massless);
  modal_.kick_at_start();
  if (form_->is_massless) modal_.kick_at_end();
  for (Vector* g : {&g_, &g_end_, &g_before_}) g->setZero(form_->rows.size());
  eta_before_ = modal_.modal_coordinates();
}

Index StaticsBody::own_track(const std::vector<Index>& nodes) {
  NodeSet set;
  set.modal = modal_.track(nodes);
  set.of = form_->of_nodes(modal_.node_rows(set.modal));
  for (Vector* x :
       {&set.w, &set.w_end, &set.force, &set.force_end, &set.rate_before, &set.friction})
    x->setZero(set.of->rows->size());
  if (!g_.isZero(0)) take_rows(*form_->rows.F * g_, set.of->row, 1, set.w);
  sets_.push_back(std::move(set));
  return static_cast<Index>(sets_.size()) - 1;
}

Index StaticsBody::own_track_mean(const std::vector<Index>& nodes) {
  MeanSet set;
  set.modal = modal_.track_mean(nodes);
  const StaticRows& rows = form_->rows;
  FormCache& shared = form_->modal.shared;
  const IndexTable& row = *shared.row_table(*superelement_);
  set.Vt = shared.mean_rows(form_->modal.V, row, nodes);
  if (form_->whole) {
    const auto mean = form_->whole->shared.mean_rows(form_->whole->V, row, nodes);
    const Matrix& quasi_static = form_->quasi_static;
    set.F = quasi_static.transpose() * mean->bottomRows(quasi_static.rows());
  } else {
    set.F.setZero(rows.size(), 3);
    for (const Index node : nodes)
      for (Index j = rows.first[node]; j < rows.first[node + 1]; ++j)
        set.F += rows.F->col(j) * rows.direction.row(j) / static_cast<double>(nodes.size());
  }
  means_.push_back(std::move(set));
  return static_cast<Index>(means_.size()) - 1;
}

// x += T B w of the set's nodes
void StaticsBody::add_rows(const NodeSet& set, const Vector& w, Points& x) const {
  const StaticRows& rows = *set.of->rows;
  for (Index i = 0; i < rows.size(); ++i)
    x.row(rows.node[i]) += (T_ * (w[i] * rows.direction.row(i).transpose())).transpose();
}

void StaticsBody::own_positions(Index set, Points& x) const {
  modal_.positions(sets_[set].modal, x);
  if (has_force_ || !loads_.empty()) add_rows(sets_[set], sets_[set].w, x);
}

void StaticsBody::own_predicted_positions(Index set, Points& x) const {
  modal_.predicted_positions(sets_[set].modal, x);
  if (is_pushed_ || !loads_.empty()) add_rows(sets_[set], sets_[set].w_end, x);
}

void StaticsBody::predict_end() {
  following_ = form_->following(h_, beta_);
  modal_.predict(t_, h_);
  const double left = follow_on(1 - h_ / following_);
  for (NodeSet& set : sets_) {
    set.w_end = left * set.w;
    set.force_end = left * set.force;
  }
  g_end_ = left * g_;
  for (std::size_t l = 0; l < loads_.size(); ++l) {
    const double load = loads_[l].factor * loads_[l].history.value(t_ + h_);
    loads_end_[l] = beta_ > 0 ? (beta_ * loads_now_[l] + h_ * load) / (beta_ + h_) : load;
    const double change = loads_end_[l] - left * loads_now_[l];
    g_end_ += change * loads_[l].f;
    for (NodeSet& set : sets_) take_rows(loads_[l].Ff, set.of->row, change, set.w_end);
  }
}

// What a step leaves of the statics' force: `share`, and nothing once that has died away.
double StaticsBody::follow_on(double share) {
  is_pushed_ = has_force_ && share != 0;
  if (!is_pushed_) return 0;
  still_left_ *= std::abs(share);
  is_pushed_ = still_left_ > 1e-14;
  return is_pushed_ ? share : 0;
}

// B^T T^T impulses / following(h)
void StaticsBody::pressed_by(const NodeSet& set, const Points& impulses, Vector& pressed) const {
  const StaticRows& rows = *set.of->rows;
  pressed.resize(rows.size());
  for (Index i = 0; i < rows.size(); ++i)
    pressed[i] = rows.direction.row(i).dot(
                     (T_.transpose() * impulses.row(rows.node[i]).transpose()).transpose()) /
                 following_;
}

// g += pressed, in all that is kept of it; still: F pressed of the set's rows.
void StaticsBody::push(Index set, const Vector& pressed, const Vector& still) {
  NodeSet& its = sets_[set];
  is_pushed_ = true;
  still_left_ = 1;
  its.w_end += still;
  its.force_end += pressed;
  for (Index i = 0; i < pressed.size(); ++i) g_end_[its.of->row[i]] += pressed[i];
  if (sets_.size() == 1) return;
  Vector change = Vector::Zero(g_end_.size());
  for (Index i = 0; i < pressed.size(); ++i) change[its.of->row[i]] = pressed[i];
  const Vector moved = *form_->rows.F * change;
  for (std::size_t other = 0; other < sets_.size(); ++other)
    if (static_cast<Index>(other) != set)
      take_rows(moved, sets_[other].of->row, 1, sets_[other].w_end);
}

void StaticsBody::kick(Index set, const Points& impulses) {
  if (form_->is_massless) {
    modal_.add_end_impulses(sets_[set].modal, impulses);
  } else {
    modal_.add_impulses(sets_[set].modal, impulses);
  }
}

void StaticsBody::own_take_impulses(Index set, const Impulses& impulses) {
  const NodeSet& its = sets_[set];
  pressed_by(its, impulses.all, pressed_);
  if (impulses.still == nullptr) {
    rows_ = pressed_;
    press(*its.of->rows, rows_, still_, columns_);
  }
  push(set, pressed_, impulses.still != nullptr ? *impulses.still : Vector(still_.col(0)));
  kick(set, impulses.all);
}

// The statics' energy 1/2 g . F g changes by exactly what mean forces do on its displacements. What
// lambda does beyond that is lost, but for what damping takes, beta g' . F g'.
double StaticsBody::own_residual_friction(Index set, const Points& impulses, bool between) {
  NodeSet& its = sets_[set];
  const bool rubs = impulses.rows() > 0;
  if (!rubs && its.friction.isZero(0)) return 0;
  const Vector move = its.w_end - its.w;
  double work = 0.5 * its.friction.dot(move);
  its.friction *= 1 - h_ / following_;
  if (rubs) {
    pressed_by(its, impulses, pressed_);
    its.friction += pressed_;
    const double share = between ? 0.5 : 1;
    work -= share * following_ * pressed_.dot(move) / h_;
    if (between) work -= 0.5 * following_ * pressed_.dot(its.rate_before);
  }
  return work + 0.5 * its.friction.dot(move);
}

void StaticsBody::own_accept() {
  const double rate = beta_ / h_;
  for (NodeSet& set : sets_) {
    set.rate_before = (set.w_end - set.w) / h_;
    if (is_pushed_ || has_force_) {
      const Vector move = set.w_end - set.w;
      const double damped = rate * move.dot(set.force_end - set.force);
      work_.contact += 0.5 * move.dot(set.force + set.force_end) + damped;
      work_.damping -= damped;
      set.force.swap(set.force_end);
    }
    set.w.swap(set.w_end);
  }
  for (std::size_t l = 0; l < loads_.size(); ++l) {
    const double move = loads_[l].Ff.dot(g_end_ - g_),
                 damped = rate * move * (loads_end_[l] - loads_now_[l]);
    work_.external += 0.5 * move * (loads_now_[l] + loads_end_[l]) + damped;
    work_.damping -= damped;
  }
  loads_now_.swap(loads_end_);
  was_in_contact_ = is_pushed_ || has_force_;
  has_force_ = is_pushed_;
  if (was_in_contact_) {
    if (form_->is_massless) eta_before_ = modal_.modal_coordinates();
    g_before_ = g_;
  }
  g_.swap(g_end_);
  modal_.accept();
}

NodeResponse StaticsBody::own_response(Index set, double h) const {
  ResponseOf of;
  of.h = h;
  Vector weight;
  if (!form_->is_massless) of = modal_.response_of(h, weight);
  NodeResponse response;
  response.thin = form_->response(sets_[set].of, of, weight, beta_);
  response.axes = T_;
  return response;
}

NodeResponse StaticsBody::own_velocity_response(Index set) const {
  NodeResponse response;
  response.thin =
      form_->response(sets_[set].of, {ResponseOf::Weight::velocity}, Vector::Ones(n_dofs()), beta_);
  response.axes = T_;
  return response;
}

StaticsBody::StaticLoad StaticsBody::static_load_of(const Points& forces,
                                                    const LoadHistory& history) const {
  const StaticRows& rows = form_->rows;
  StaticLoad load{Vector::Zero(g_.size()), {}, history};
  for (Index i = 0; i < rows.size(); ++i)
    load.f[i] = rows.direction.row(i).dot(
        (T_.transpose() * forces.row(rows.node[i]).transpose()).transpose());
  load.Ff = *rows.F * load.f;
  return load;
}

void StaticsBody::add_turning_statics(const Points& forces, double factor,
                                      const LoadHistory& history) {
  StaticLoad load = static_load_of(forces, history);
  load.factor = load.largest = factor;
  load.turns = true;
  append_load(std::move(load));
}

void StaticsBody::turn_statics(const Vector& factors, const Vector& largest) {
  Index i = 0;
  for (StaticLoad& load : loads_)
    if (load.turns) {
      load.factor = factors[i];
      load.largest = largest[i];
      ++i;
    }
}

void StaticsBody::take_plan(const BodyPlan& plan) {
  modal_.prepare(plan);
  add_statics(plan.loads);
}

void StaticsBody::add_statics(const std::vector<BodyLoad>& loads) {
  for (const BodyLoad& load : loads) {
    const NodalForces forces = forces_of(load).forces;
    if (!forces) continue;
    StaticLoad added = static_load_of(forces.on_nodes(), load.history);
    if (!added.f.isZero(0)) append_load(std::move(added));
  }
}

void StaticsBody::append_load(StaticLoad load) {
  const double now = load.factor * load.history.value(t_);
  g_ += now * load.f;
  for (NodeSet& set : sets_) take_rows(load.Ff, set.of->row, now, set.w);
  loads_.push_back(std::move(load));
  loads_now_.push_back(now);
  loads_end_.push_back(now);
}

Vector StaticsBody::static_load() const {
  Vector sum = Vector::Zero(form_->rows.size());
  for (const StaticLoad& load : loads_) sum += load.f;
  return sum;
}

// The interface springs back to where its modes are once it is let go.
MotionBound StaticsBody::own_motion_bound(Index set, bool quick) const {
  MotionBound bound = modal_.motion_bound(sets_[set].modal, quick);
  const NodeSet& its = sets_[set];
  Vector3 spread = Vector3::Zero();
  Points moved;
  const auto add = [&](const Vector& w) {
    moved.setZero(static_cast<Index>(its.of->nodes.size()), 3);
    add_rows(its, w, moved);
    spread += moved.cwiseAbs().colwise().maxCoeff().transpose();
  };
  if (!its.w.isZero(0)) add(its.w);
  for (const StaticLoad& load : loads_) {
    Vector w = Vector::Zero(its.w.size());
    take_rows(load.Ff, its.of->row, load.largest * load.history.largest(), w);
    add(w);
  }
  bound.lower -= spread;
  bound.upper += spread;
  return bound;
}

// What contact holds follows what it meets: without mass its velocity is that of the last step, not
// of the modes.
void StaticsBody::own_mean_motion(Index set, Vector3& position, Vector3& velocity) const {
  const MeanSet& its = means_[set];
  modal_.mean_motion(its.modal, position, velocity);
  position += T_ * Vector3(its.F.transpose() * g_);
  if (!was_in_contact_) return;
  const Vector3 still = its.F.transpose() * (g_ - g_before_) / h_;
  if (form_->is_massless) {
    velocity =
        T_ * Vector3(its.Vt->transpose() * (modal_.modal_coordinates() - eta_before_) / h_ + still);
  } else {
    velocity += T_ * still;
  }
}

BodyState StaticsBody::own_state() const {
  BodyState state = modal_.state();
  // 1/2 g . F g
  for (const NodeSet& set : sets_) state.strain_energy += 0.5 * set.force.dot(set.w);
  for (std::size_t l = 0; l < loads_.size(); ++l)
    state.strain_energy += 0.5 * loads_now_[l] * loads_[l].Ff.dot(g_);
  return state;
}

BodyWork StaticsBody::own_work() const {
  BodyWork work = modal_.work();
  work.external += work_.external;
  work.contact += work_.contact;
  work.damping += work_.damping;
  return work;
}

void StaticsBody::own_coordinates(Vector& q, Vector& rates) const {
  modal_.coordinates(q, rates);
  const auto add = [&](const Vector& moved, Vector& x) {  // k + c
    const IndexTable& row = *form_->modal.shared.row_table(*superelement_);
    x.head(k_) += moved.head(k_);
    for (Index i = 0; i < row.rows(); ++i)
      for (int d = 0; d < 3; ++d)
        if (row(i, d) >= 0) x[k_ + 3 * i + d] += moved[row(i, d)];
  };
  if (was_in_contact_ && form_->is_massless) {
    rates.setZero();
    add(form_->modal.V * (modal_.modal_coordinates() - eta_before_) / h_, rates);
  }
  const StaticRows& rows = form_->rows;
  const auto spread = [&](const Vector& g, double factor, Vector& x) {
    if (form_->whole) return add(factor * form_->displacements(g), x);
    const Vector w = factor * (*rows.F * g);
    for (Index i = 0; i < rows.size(); ++i)
      x.segment<3>(k_ + 3 * rows.node[i]) += w[i] * rows.direction.row(i).transpose();
  };
  if (!g_.isZero(0)) spread(g_, 1, q);
  if (was_in_contact_) spread(g_ - g_before_, 1 / h_, rates);
}

void StaticsBody::own_displacements(Points& u, Points& v) const {
  Vector q, rates;
  own_coordinates(q, rates);
  const Index n = own_nodes().rows();
  u = Eigen::Map<const Points>(q.data() + k_, n, 3) * T_.transpose();
  v = Eigen::Map<const Points>(rates.data() + k_, n, 3) * T_.transpose();
}

}  // namespace cbr
