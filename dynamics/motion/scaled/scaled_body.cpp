// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/scaled/scaled_body.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "common/base/error.hpp"

namespace cbr {
namespace {

// From here on a product is worth BLAS with its threads.
constexpr Index large_product = 1 << 20;

}  // namespace

ScaledBody::ScaledBody(std::string name, std::shared_ptr<ScaledModel> model,
                       const Placement& placement)
    : Body({.name = std::move(name),
            .scheme = Scheme::exact,
            .n_dofs = model->n_modes(),
            .positions = placement.placed(model->superelement().coordinates),
            .scales = true}),
      model_(std::move(model)),
      placement_(placement) {
  slot_of_.assign(static_cast<std::size_t>(own_nodes().rows()), -1);
  if (placement_.velocity.isZero(0)) return;
  Load start;
  start.rigid.setZero();
  start.rigid.head<3>() = placement_.T.transpose() * placement_.velocity;
  start.is_load = false;
  loads_.push_back(std::move(start));
}

double ScaledBody::largest_frequency() const {
  return modes_ ? modes_->largest_frequency() : model_->largest_frequency();
}

void ScaledBody::require_plan(bool is_there) const {
  if (is_there != (modes_ != nullptr))
    throw std::logic_error("ScaledBody '" + name() +
                           "': nodes are tracked before prepare(), the rest is asked after it");
}

Index ScaledBody::own_track(const std::vector<Index>& nodes) {
  require_plan(false);
  NodeSet set;
  set.nodes = nodes;
  set.X = own_nodes()(nodes, Eigen::all);
  for (const Index node : nodes) {
    if (slot_of_[node] < 0) {
      slot_of_[node] = static_cast<Index>(tracked_.size());
      tracked_.push_back(node);
    }
    set.slot.push_back(slot_of_[node]);
  }
  sets_.push_back(std::move(set));
  return static_cast<Index>(sets_.size()) - 1;
}

Index ScaledBody::own_track_mean(const std::vector<Index>& nodes) {
  require_plan(false);
  means_.push_back({nodes, own_nodes()(nodes, Eigen::all).colwise().mean().transpose(), {}, {}});
  return static_cast<Index>(means_.size()) - 1;
}

void ScaledBody::write_positions(const NodeSet& set, const ScaledState& state, Points& x) const {
  x = set.X;
  if (!modes_) return;
  const Matrix& Vt = rows_->Vt;
  const bool by_blas = set.whole && Vt.size() >= large_product;
  if (by_blas) local_.noalias() = Vt.transpose() * state.eta;
  for (std::size_t i = 0; i < set.slot.size(); ++i) {
    const Index at = 3 * set.slot[i];
    Vector3 u = Vector3::Zero();
    if (by_blas) {
      u = local_.segment<3>(at);
    } else if (state.eta.size() > 0) {
      u << Vt.col(at).dot(state.eta), Vt.col(at + 1).dot(state.eta), Vt.col(at + 2).dot(state.eta);
    }
    if (rows_->S) u += state.y.segment<3>(at);
    x.row(static_cast<Index>(i)) += (placement_.T * u).transpose();
  }
}

void ScaledBody::own_positions(Index set, Points& x) const { write_positions(sets_[set], now_, x); }
void ScaledBody::own_predicted_positions(Index set, Points& x) const {
  write_positions(sets_[set], end_, x);
}

void ScaledBody::own_mean_motion(Index set, Vector3& position, Vector3& velocity) const {
  const MeanSet& s = means_[set];
  position = s.X;
  velocity.setZero();
  Vector3 u = Vector3::Zero(), v = u;
  for (int c = 0; modes_ && c < 3; ++c) {
    if (s.Vt.size() > 0) {
      u[c] = s.Vt.col(c).dot(now_.eta);
      v[c] = s.Vt.col(c).dot(now_.v);
    }
    if (s.St.size() > 0) {
      u[c] += s.St.col(c).dot(now_.r);
      v[c] += s.St.col(c).dot(now_.dr);
    }
  }
  if (!modes_) v = placement_.T.transpose() * placement_.velocity;
  position += placement_.T * u;
  velocity = placement_.T * v;
}

void ScaledBody::load_amplitudes(double t, ScaledLoad& load) const {
  for (std::size_t l = 0; l < loads_.size(); ++l)
    load.a[l] = loads_[l].is_load ? loads_[l].history.value(t) : 0;
  load.f.setZero();
  load.Sa.setZero();
  for (Index l = 0; l < load.a.size(); ++l) {
    load.f += load.a[l] * load_modal_.col(l);
    if (load.Sa.size() > 0) load.Sa += load.a[l] * load_scaled_.col(l);
  }
}

const ScaledStep& ScaledBody::step_of(double h) const {
  if (regular_.h == h) return regular_;
  std::swap(regular_, other_);
  if (regular_.h != h) regular_ = scaled_step(modes_->omega, modes_->clip, h, loaded_);
  return regular_;
}

// From t_ to t_ + h_ with loads, cut at the histories' breakpoints so that each part is linear in
// time.
void ScaledBody::propagate(const ScaledState& start, ScaledState& end, double& external_work) {
  external_work = 0;
  if (!loaded_) return propagate_free(step_of(h_), start, end);
  end = start;
  breakpoints_.cut(t_, h_, [&](double from, double to, bool whole) {
    const ScaledStep shorter =
        whole ? ScaledStep{} : scaled_step(modes_->omega, modes_->clip, to - from, true);
    const ScaledStep& step = whole ? step_of(h_) : shorter;
    part_ = end;
    load_amplitudes(from, f0_);
    load_amplitudes(to, f1_);
    propagate_free(step, part_, end);
    add_load(step, f0_, f1_, end);
    external_work += load_work(step, part_, end, f0_, f1_);
  });
}

void ScaledBody::predict_end() {
  if (!modes_) scale(HUGE_VAL);
  kick_.any = friction_.any = false;
  propagate(now_, end_, step_work_);
}

// What contact_gain() makes of modal impulses and of those on the tracked dofs.
void ScaledBody::apply_gain(ScaledKick& kick) const {
  if (gain_.kept.size() > 0) kick.f.array() *= gain_.kept.array();
  kick.p *= gain_.scaled;
}

// fresh_ <- what impulses on a set do: V^T p, p, S p, with their gains.
void ScaledBody::local_kick(const NodeSet& set, const Points& impulses) {
  const Matrix& Vt = rows_->Vt;
  const Index n = n_tracked(), loads = fresh_.p.size() - n;
  const bool scaled = rows_->S != nullptr;
  Index touched = 0;
  for (Index i = 0; i < impulses.rows(); ++i) touched += impulses.row(i).isZero(0) ? 0 : 1;
  const bool large = 2 * 3 * touched >= n && n * n >= large_product;
  const bool modal_by_blas = large && Vt.size() >= large_product;
  fresh_.f.setZero();
  fresh_.p.setZero();
  fresh_.Sp.setZero();
  local_.setZero();
  for (Index i = 0; i < impulses.rows(); ++i) {
    if (impulses.row(i).isZero(0)) continue;
    const Vector3 p = placement_.T.transpose() * impulses.row(i).transpose();
    const Index at = 3 * set.slot[i];
    local_.segment<3>(at) += p;
    if (!modal_by_blas && Vt.size() > 0)
      fresh_.f += p[0] * Vt.col(at) + p[1] * Vt.col(at + 1) + p[2] * Vt.col(at + 2);
    if (!scaled || large) continue;
    const Matrix& S = *rows_->S;
    fresh_.Sp.head(n) += p[0] * S.col(at) + p[1] * S.col(at + 1) + p[2] * S.col(at + 2);
  }
  if (modal_by_blas) fresh_.f.noalias() = Vt * local_;
  if (scaled) fresh_.p.head(n) = local_;
  apply_gain(fresh_);
  if (!scaled) return;
  local_ = fresh_.p.head(n);
  fresh_.Sp.head(n) *= gain_.scaled;
  if (large) fresh_.Sp.head(n).noalias() = rows_->S->selfadjointView<Eigen::Lower>() * local_;
  for (Index l = 0; l < loads; ++l) fresh_.Sp[n + l] = load_scaled_.col(l).head(n).dot(local_);
}

void ScaledBody::own_take_impulses(Index set, const Impulses& impulses) {
  // Near a multiple of pi the scaled part's move says nothing
  if (impulses.move != nullptr && rows_->S && sets_[set].whole && modes_->clip * h_ < 2.8 &&
      !kick_.any)
    return take_known_moves(impulses);
  impulses.each([&](const Points& p, ImpulseKind kind) {
    local_kick(sets_[set], p);
    kick_.add(fresh_);
    if (kind == ImpulseKind::friction) friction_.add(fresh_);
    add_kick(step_of(h_), fresh_, end_);
  });
}

// y takes what the move has beyond the kept modes: S p = (move - V diag(sin(omega h)/omega) V^T p)
// clip / sin(clip h)
void ScaledBody::take_known_moves(const Impulses& impulses) {
  const auto& [contact, friction, move, still] = impulses;
  const ScaledStep& step = step_of(h_);
  const double weight = step.scaled.s[0];
  const Matrix& Vt = rows_->Vt;
  const Index n = n_tracked(), loads = fresh_.p.size() - n;
  const bool by_blas = Vt.size() >= large_product;
  const auto modal = [&](const Points& p, ScaledKick& kick) {
    kick.f.setZero();
    kick.p.setZero();
    for (Index i = 0; i < p.rows(); ++i) {
      if (p.row(i).isZero(0)) continue;
      const Vector3 local = placement_.T.transpose() * p.row(i).transpose();
      kick.p.segment<3>(3 * i) = local;
      if (!by_blas && Vt.size() > 0)
        kick.f +=
            local[0] * Vt.col(3 * i) + local[1] * Vt.col(3 * i + 1) + local[2] * Vt.col(3 * i + 2);
    }
    if (by_blas) kick.f.noalias() = Vt * kick.p.head(n);
    apply_gain(kick);
    kick.any = true;
  };
  modal(contact, kick_);
  if (!friction.isZero(0)) {
    modal(friction, friction_);
    kick_.f += friction_.f;
    kick_.p += friction_.p;
  }
  weighted_.array() = step.kept.s.array() * kick_.f.array();
  if (by_blas) local_.noalias() = Vt.transpose() * weighted_;
  for (Index i = 0; i < move->rows(); ++i) {
    Vector3 kept = Vector3::Zero();
    if (by_blas) {
      kept = local_.segment<3>(3 * i);
    } else if (Vt.size() > 0) {
      kept << Vt.col(3 * i).dot(weighted_), Vt.col(3 * i + 1).dot(weighted_),
          Vt.col(3 * i + 2).dot(weighted_);
    }
    kick_.Sp.segment<3>(3 * i) =
        (placement_.T.transpose() * move->row(i).transpose() - kept) / weight;
  }
  for (Index l = 0; l < loads; ++l)
    kick_.Sp[n + l] = load_scaled_.col(l).head(n).dot(kick_.p.head(n));
  add_kick(step, kick_, end_);
}

void ScaledBody::own_accept() {
  if (kick_.any) {
    const double all = kick_.work(kick_, now_),
                 rubbed = friction_.any ? kick_.work(friction_, now_, gain_) : 0;
    work_.contact += all - rubbed;
    work_.friction += rubbed;
    if (loaded_) {
      add_kick(kick_, now_);
      propagate(now_, end_, step_work_);
    }
  }
  work_.external += step_work_;
  std::swap(now_, end_);
  t_ += h_;
}

}  // namespace cbr
