// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/residual_motion.hpp"

#include <cmath>
#include <utility>

#include "common/files/state_archive.hpp"

namespace cbr {
namespace {

// w += factor of_all(rows)
void take_rows(const Vector& of_all, const std::vector<Index>& rows, double factor, Vector& w) {
  for (std::size_t i = 0; i < rows.size(); ++i)
    w[static_cast<Index>(i)] += factor * of_all[rows[i]];
}

// B^T T^T p of the rows of one node
double along(const StaticRows& rows, Index i, const Matrix3& T, const Points& p) {
  return rows.direction.row(i).dot((T.transpose() * p.row(rows.node[i]).transpose()).transpose());
}

}  // namespace

ResidualMotion::ResidualMotion(std::shared_ptr<const ModalForm> form,
                               std::shared_ptr<const IndexTable> rows, const Matrix3& T,
                               double beta)
    : form_(std::move(form)), of_(form_->residual), rows_(std::move(rows)), T_(T), beta_(beta) {
  if (!of_) return;
  for (Vector* g : {&g_, &g_end_, &g_before_}) g->setZero(of_->rows.size());
  eta_before_.setZero(form_->omega.size());
}

double ResidualMotion::critical_frequency() const {
  return of_->is_massless ? cbr::critical_frequency(of_->omega_limit, beta_) : of_->omega_limit;
}

void ResidualMotion::track(const NodeRows& nodes) {
  if (!of_) return;
  NodeSet set;
  set.of = of_->of_nodes(nodes);
  for (Vector* x :
       {&set.w, &set.w_end, &set.force, &set.force_end, &set.rate_before, &set.friction})
    x->setZero(set.of->rows->size());
  if (!g_.isZero(0)) take_rows((of_->rows.F * g_).col(0), set.of->row, 1, set.w);
  sets_.push_back(std::move(set));
}

void ResidualMotion::track_mean(const std::vector<Index>& nodes) {
  if (!of_) return;
  const StaticRows& rows = of_->rows;
  Matrix F = Matrix::Zero(rows.size(), 3);
  if (of_->whole) {
    const auto mean = of_->whole->shared.mean_rows(of_->whole->V, *rows_, nodes);
    const Matrix& quasi_static = of_->quasi_static;
    F = quasi_static.transpose() * mean->bottomRows(quasi_static.rows());
  } else {
    for (const Index node : nodes)
      for (Index j = rows.first[node]; j < rows.first[node + 1]; ++j)
        F.row(j) += rows.direction.row(j) / static_cast<double>(nodes.size());
    F = rows.F * F;
  }
  means_.push_back(std::move(F));
}

// x += T B w of the set's nodes
void ResidualMotion::add_rows(const NodeSet& set, const Vector& w, Points& x) const {
  const StaticRows& rows = *set.of->rows;
  for (Index i = 0; i < rows.size(); ++i)
    x.row(rows.node[i]) += (T_ * (w[i] * rows.direction.row(i).transpose())).transpose();
}

void ResidualMotion::add_positions(Index set, Points& x) const {
  if (has_force_ || !loads_.empty()) add_rows(sets_[set], sets_[set].w, x);
}

void ResidualMotion::add_predicted_positions(Index set, Points& x) const {
  if (is_pushed_ || !loads_.empty()) add_rows(sets_[set], sets_[set].w_end, x);
}

void ResidualMotion::predict(double t, double h, Index n_steps) {
  if (!of_) return;
  is_predicted_ = true;
  n_steps_ = n_steps;
  h_ = h / static_cast<double>(n_steps);
  following_ = of_->following(h_, beta_);
  const double left = left_ = follow_on(1 - h_ / following_, n_steps);
  for (NodeSet& set : sets_) {
    set.w_end = left * set.w;
    set.force_end = left * set.force;
  }
  g_end_ = left * g_;
  for (ResidualLoad& load : loads_) {
    load.end = load_at_end(load, t);
    const double change = load.end - left * load.now;
    g_end_ += change * load.f;
    for (NodeSet& set : sets_) take_rows(load.Ff, set.of->row, change, set.w_end);
  }
}

// The share of the force that the steps leave: share^n, and nothing once that has died away.
double ResidualMotion::follow_on(double share, Index n_steps) {
  is_pushed_ = has_force_ && share != 0;
  if (!is_pushed_) return 0;
  const double left = n_steps == 1 ? share : std::pow(share, static_cast<double>(n_steps));
  still_left_ *= std::abs(left);
  is_pushed_ = still_left_ > 1e-14;
  return is_pushed_ ? left : 0;
}

// Damping lets it follow its history, regular step by regular step.
double ResidualMotion::load_at_end(const ResidualLoad& load, double t) const {
  double end = load.now;
  for (Index i = beta_ > 0 ? 1 : n_steps_; i <= n_steps_; ++i) {
    const double value = load.factor * load.history.value(t + static_cast<double>(i) * h_);
    end = beta_ > 0 ? (beta_ * end + h_ * value) / (beta_ + h_) : value;
  }
  return end;
}

// pressed_ = B^T T^T impulses / following_
void ResidualMotion::press_on(const NodeSet& set, const Points& impulses) {
  const StaticRows& rows = *set.of->rows;
  pressed_.resize(rows.size());
  for (Index i = 0; i < rows.size(); ++i) pressed_[i] = along(rows, i, T_, impulses) / following_;
}

// g += pressed_, in all that is kept of it; still: F pressed_ of the set's rows.
void ResidualMotion::add_force(Index set, const Vector& still) {
  NodeSet& its = sets_[set];
  is_pushed_ = true;
  still_left_ = 1;
  its.w_end += still;
  its.force_end += pressed_;
  for (Index i = 0; i < pressed_.size(); ++i) g_end_[its.of->row[i]] += pressed_[i];
  if (sets_.size() == 1) return;
  Vector change = Vector::Zero(g_end_.size());
  for (Index i = 0; i < pressed_.size(); ++i) change[its.of->row[i]] = pressed_[i];
  const Vector moved = of_->rows.F * change;
  for (std::size_t other = 0; other < sets_.size(); ++other)
    if (static_cast<Index>(other) != set)
      take_rows(moved, sets_[other].of->row, 1, sets_[other].w_end);
}

void ResidualMotion::push(Index set, const Impulses& impulses) {
  if (!of_) return;
  const NodeSet& its = sets_[set];
  press_on(its, impulses.all);
  if (impulses.still != nullptr) return add_force(set, *impulses.still);
  column_ = pressed_;
  press(*its.of->rows, column_, still_, columns_);
  add_force(set, still_.col(0));
}

// The energy 1/2 g . F g changes by exactly the work of mean forces on its displacements. The rest
// of the work of lambda is lost, but for that of damping, beta g' . F g'.
double ResidualMotion::friction(Index set, const Points& impulses, bool between) {
  if (!of_ || !is_predicted_) return 0;
  NodeSet& its = sets_[set];
  const bool rubs = impulses.rows() > 0;
  if (!rubs && its.friction.isZero(0)) return 0;
  const Vector move = its.w_end - its.w;
  double work = 0.5 * its.friction.dot(move);
  its.friction *= n_steps_ == 1 ? 1 - h_ / following_ : left_;
  if (rubs) {
    press_on(its, impulses);
    its.friction += pressed_;
    const double share = between ? 0.5 : 1;
    work -= share * following_ * pressed_.dot(move) / h_;
    if (between) work -= 0.5 * following_ * pressed_.dot(its.rate_before);
  }
  return work + 0.5 * its.friction.dot(move);
}

void ResidualMotion::accept(const Vector& eta) {
  if (!of_) return;
  is_predicted_ = false;
  const double rate = damping_rate(), n = static_cast<double>(n_steps_);
  for (NodeSet& set : sets_) {
    set.rate_before = (set.w_end - set.w) / (n * h_);
    if (is_pushed_ || has_force_) {
      const Vector move = set.w_end - set.w;
      const double damped = rate * move.dot(set.force_end - set.force);
      work_.contact += 0.5 * move.dot(set.force + set.force_end) + damped;
      work_.damping -= damped;
      set.force.swap(set.force_end);
    }
    set.w.swap(set.w_end);
  }
  was_in_contact_ = is_pushed_ || (has_force_ && n_steps_ == 1);
  has_force_ = is_pushed_;
  if (was_in_contact_) {
    if (of_->is_massless) eta_before_ = eta;
    g_before_ = n_steps_ == 1 ? g_ : before_last_step();
  }
  for (ResidualLoad& load : loads_) {
    const double move = load.Ff.dot(g_end_ - g_), damped = rate * move * (load.end - load.now);
    work_.external += 0.5 * move * (load.now + load.end) + damped;
    work_.damping -= damped;
    load.now = load.end;
  }
  g_.swap(g_end_);
}

// What a force g in a step of h dissipates is beta / h |change of g|_F^2. Of a jump these are a
// geometric series.
double ResidualMotion::damping_rate() const {
  const double rate = beta_ / h_, share = 1 - h_ / following_;
  return n_steps_ == 1 ? rate : rate * (1 - share) * (1 + left_) / ((1 + share) * (1 - left_));
}

// g at the start of the last regular step of a jump
Vector ResidualMotion::before_last_step() const {
  const double share = 1 - h_ / following_, n = static_cast<double>(n_steps_);
  Vector free = g_, loaded = Vector::Zero(g_.size());
  for (const ResidualLoad& load : loads_) {
    free -= load.now * load.f;
    loaded += (load.end - (load.end - load.now) / n) * load.f;
  }
  return left_ / share * free + loaded;
}

std::shared_ptr<const ThinResponse> ResidualMotion::response(Index set, const ResponseOf& of,
                                                             const Vector& weight) const {
  return of_->response(sets_[set].of, of, weight, beta_);
}

Matrix ResidualMotion::compliance(Index set) const {
  const StaticRows& rows = *sets_[set].of->rows;
  const auto n = 3 * static_cast<Index>(sets_[set].of->nodes.size());
  Matrix all = Matrix::Zero(n, n);
  const Matrix F = rows.F.formed();
  for (Index j = 0; j < rows.size(); ++j)
    for (Index i = 0; i < rows.size(); ++i)
      all.block<3, 3>(3 * rows.node[i], 3 * rows.node[j]) +=
          F(i, j) * rows.direction.row(i).transpose() * rows.direction.row(j);
  return all;
}

ResidualMotion::ResidualLoad ResidualMotion::load_of(const NodalForces& forces,
                                                     const LoadHistory& history) const {
  const StaticRows& rows = of_->rows;
  ResidualLoad load{Vector::Zero(g_.size()), {}, history};
  const Points on_nodes = forces.on_nodes();
  for (Index i = 0; i < rows.size() && forces; ++i) load.f[i] = along(rows, i, T_, on_nodes);
  load.Ff = rows.F * load.f;
  return load;
}

void ResidualMotion::add_load(const NodalForces& forces, const LoadHistory& history) {
  if (!of_) return;
  ResidualLoad added = load_of(forces, history);
  if (!added.f.isZero(0)) append_load(std::move(added));
}

void ResidualMotion::add_turning_load(const NodalForces& forces, double factor,
                                      const LoadHistory& history) {
  if (!of_) return;
  ResidualLoad load = load_of(forces, history);
  load.factor = load.largest = factor;
  load.turns = true;
  append_load(std::move(load));
}

void ResidualMotion::turn_loads(const Vector& factors, const Vector& largest) {
  Index i = 0;
  for (ResidualLoad& load : loads_)
    if (load.turns) {
      load.factor = factors[i];
      load.largest = largest[i];
      ++i;
    }
}

void ResidualMotion::append_load(ResidualLoad load) {
  load.now = load.end = load.factor * load.history.value(0);
  g_ += load.now * load.f;
  for (NodeSet& set : sets_) take_rows(load.Ff, set.of->row, load.now, set.w);
  loads_.push_back(std::move(load));
}

Vector ResidualMotion::load() const {
  Vector sum = Vector::Zero(g_.size());
  for (const ResidualLoad& load : loads_) sum += load.f;
  return sum;
}

// The interface springs back to the place of its modes once it is let go.
void ResidualMotion::add_bound(Index set, MotionBound& bound) const {
  if (!of_) return;
  const NodeSet& its = sets_[set];
  Vector3 spread = Vector3::Zero();
  Points moved;
  const auto add = [&](const Vector& w) {
    moved.setZero(static_cast<Index>(its.of->nodes.size()), 3);
    add_rows(its, w, moved);
    spread += moved.cwiseAbs().colwise().maxCoeff().transpose();
  };
  if (!its.w.isZero(0)) add(its.w);
  for (const ResidualLoad& load : loads_) {
    Vector w = Vector::Zero(its.w.size());
    take_rows(load.Ff, its.of->row, load.largest * load.history.largest(), w);
    add(w);
  }
  bound.lower -= spread;
  bound.upper += spread;
}

void ResidualMotion::add_mean_motion(Index set, const Matrix& Vt, const Vector& eta,
                                     Vector3& position, Vector3& velocity) const {
  if (!of_) return;
  const Matrix& F = means_[set];
  position += T_ * Vector3(F.transpose() * g_);
  if (!was_in_contact_) return;
  const Vector3 still = F.transpose() * (g_ - g_before_) / h_;
  if (of_->is_massless) {
    velocity = T_ * Vector3(Vt.transpose() * (eta - eta_before_) / h_ + still);
  } else {
    velocity += T_ * still;
  }
}

// 1/2 g . F g
void ResidualMotion::add_strain_energy(double& energy) const {
  for (const NodeSet& set : sets_) energy += 0.5 * set.force.dot(set.w);
  for (const ResidualLoad& load : loads_) energy += 0.5 * load.now * load.Ff.dot(g_);
}

void ResidualMotion::add_coordinates(const Vector& eta, Vector& q, Vector& rates) const {
  if (!of_) return;
  const Index k = q.size() - 3 * rows_->rows();
  if (was_in_contact_ && of_->is_massless) {
    rates.setZero();
    add_to_coordinates(*rows_, form_->V * (eta - eta_before_) / h_, rates);
  }
  const StaticRows& rows = of_->rows;
  const auto spread = [&](const Vector& g, double factor, Vector& x) {
    if (of_->whole) return add_to_coordinates(*rows_, factor * of_->displacements(g), x);
    const Vector w = factor * (rows.F * g);
    for (Index i = 0; i < rows.size(); ++i)
      x.segment<3>(k + 3 * rows.node[i]) += w[i] * rows.direction.row(i).transpose();
  };
  if (!g_.isZero(0)) spread(g_, 1, q);
  if (was_in_contact_) spread(g_ - g_before_, 1 / h_, rates);
}

void ResidualMotion::begin_load_step() {
  for (NodeSet& set : sets_) {
    set.w_start = set.w;
    set.force_start = set.force;
  }
  g_start_ = g_;
  for (ResidualLoad& load : loads_) load.start = load.now;
}

void ResidualMotion::relax(double t, double share) {
  if (!of_) return;
  if (g_start_.size() == 0) {
    // Displacements under loads at the start come with the first load step
    g_.setZero();
    for (NodeSet& set : sets_) set.w.setZero();
    for (ResidualLoad& load : loads_) load.now = 0;
    begin_load_step();
  }
  following_ = 1;  // a force is as it is
  g_end_.setZero();
  for (NodeSet& set : sets_) {
    for (Vector* x : {&set.w_end, &set.force_end}) x->setZero();
  }
  for (ResidualLoad& load : loads_) {
    load.end = share * load.history.value(t);
    g_end_ += load.end * load.f;
    for (NodeSet& set : sets_) take_rows(load.Ff, set.of->row, load.end, set.w_end);
  }
  is_pushed_ = true;
}

void ResidualMotion::settle(Settled& settled) {
  if (!of_) return;
  const Vector change = g_end_ - g_;
  settled.change += change.dot(Vector(of_->rows.F * change));
  settled.energy += g_end_.dot(Vector(of_->rows.F * g_end_));
  for (NodeSet& set : sets_) {
    set.w = set.w_end;
    set.force = set.force_end;
  }
  g_ = g_end_;
  for (ResidualLoad& load : loads_) load.now = load.end;
  has_force_ = true;
}

void ResidualMotion::end_load_step() {
  for (const NodeSet& set : sets_)
    work_.contact += 0.5 * (set.w - set.w_start).dot(set.force_start + set.force);
  for (const ResidualLoad& load : loads_)
    work_.external += 0.5 * (load.start + load.now) * load.Ff.dot(g_ - g_start_);
  begin_load_step();
}

// Forces that last have been followed for long.
void ResidualMotion::start_motion(double h, const Vector& eta) {
  if (g_start_.size() == 0) return;
  work_ = BodyWork();
  h_ = h;
  g_before_ = g_;
  was_in_contact_ = has_force_ = true;
  still_left_ = 1;
  if (of_->is_massless) eta_before_ = eta;
}

void ResidualMotion::keep_state(StateArchive& archive) {
  if (!of_) return;
  archive.expect(static_cast<Index>(sets_.size()));
  archive(g_, g_before_, eta_before_, h_, work_, was_in_contact_, has_force_, still_left_);
  for (ResidualLoad& load : loads_) archive(load.now);
  for (NodeSet& set : sets_) archive(set.w, set.force, set.rate_before, set.friction);
  bool is_still = g_start_.size() > 0;
  archive(is_still);
  if (is_still && archive.restores()) begin_load_step();
}

}  // namespace cbr
