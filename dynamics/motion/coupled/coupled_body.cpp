// SPDX-License-Identifier: GPL-3.0-or-later
// How a coupled body is advanced.
#include "dynamics/motion/coupled/coupled_body.hpp"

#include <cassert>
#include <utility>

#include "common/files/state_archive.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {

CoupledBody::CoupledBody(std::string name, std::shared_ptr<CoupledSystem> system,
                         const Placement& placement, Scheme scheme, const NewmarkOptions& newmark,
                         const MaterialDamping& damping)
    : Body({.name = std::move(name),
            .scheme = scheme,
            .n_dofs = system->n_free(),
            .positions = placement.placed(system->model().coordinates)}),
      system_(std::move(system)),
      placement_(placement),
      kick_(system_->n()),
      damping_(damping) {
  assert(scheme != Scheme::exact);
  for (Vector* x : {&u_, &u_end_, &p_end_, &work_vector_, &Ku_, &v_now_}) x->setZero(system_->n());
  // The rigid motion, or its projection when directions are held.
  p_.noalias() =
      system_->rigid_momentum().leftCols(3) * (placement_.T.transpose() * placement_.velocity);
  system_->drop_held(p_);
  if (is_damped())
    for (Vector* x : {&damping_room_, &Cv_}) x->setZero(system_->n());
  newmark_.numbers = newmark;
  if (scheme == Scheme::newmark) newmark_.resize(system_->n());
  solve_for_velocities();
}

void CoupledBody::Newmark::resize(Index n) {
  for (Vector* x : {&move, &F, &Ma, &f0, &f1}) x->setZero(n);
  if (numbers.alpha != 0)
    for (Vector* x : {&a, &last_change_of_Ku, &last_change_of_f}) x->setZero(n);
}

void CoupledBody::Newmark::keep_state(StateArchive& archive) {
  archive(has_started, has_arrived, F, Ma, f0, a, last_change_of_Ku, last_change_of_f, a0_Ma0);
}

// Of the momenta at the start, where the scheme or the damping needs them.
void CoupledBody::solve_for_velocities() {
  const bool is_central = scheme() == Scheme::central_difference;
  if (!is_central && !is_damped()) return;
  v_ = p_;
  system_->factor(0).solve(v_);
  if (is_central) {
    v_end_ = v_;
  } else {
    damping_force(p_, v_, Cv_);
  }
}

const Vector& CoupledBody::stiffness_force() const {
  if (!Ku_is_current_) {
    system_->multiply_stiffness(u_, Ku_);
    system_->drop_held(Ku_);
  }
  Ku_is_current_ = true;
  return Ku_;
}

void CoupledBody::predict_end() {
  kicks_.clear();
  lasting_.resize(0);
  kick_.clear();
  velocity_kick_.clear();
  if (scheme() == Scheme::central_difference) {
    predict_central(h_);
  } else {
    predict_newmark(h_);
  }
}

// Leapfrog: (1 + alpha h / 2) p+ = (1 - alpha h- / 2) p- + (h- + h)/2 (f - K u - beta K v-), u+ = u
// + h M^-1 p+. At the start p- is half a step before t = 0.
void CoupledBody::predict_central(double h) {
  Vector& F = work_vector_;
  if (loads_.empty()) {
    F = -stiffness_force();
  } else {
    loads_.sum(t_, F);
    F -= stiffness_force();
  }
  if (last_h_ == 0) begin_central(h, F);
  if (is_damped()) {
    damping_force(Vector::Zero(p_.size()), v_, Cv_);
    F -= Cv_;
  }
  p_end_ = (1 - 0.5 * last_h_ * damping_.alpha) * p_ + 0.5 * (last_h_ + h) * F;
  p_end_ /= mass_factor(h);
  v_end_ = p_end_;
  system_->factor(0).solve(v_end_);
  u_end_ = u_ + h * v_end_;
}

// The half kick back is booked as work of the loads and of damping, so that the energy balance
// starts from the given velocity.
void CoupledBody::begin_central(double h, const Vector& F) {
  last_h_ = h;
  v_end_ = F;
  system_->factor(0).solve(v_end_);
  const double of_loads = 0.5 * h * F.dot(0.25 * h * v_end_ - v_);
  work_.external += of_loads;
  if (!is_damped()) {
    p_ -= 0.5 * h * F;
    v_ -= 0.5 * h * v_end_;
    return;
  }
  damping_force(p_, v_, Cv_);
  const double given = p_.dot(v_);
  p_ -= 0.5 * h * (F - Cv_);
  v_ = p_;
  system_->factor(0).solve(v_);
  work_.damping += 0.5 * (p_.dot(v_) - given) - of_loads;
}

// Of the move d = u_1 - u_0, the velocity at the end being taken from it with damping: 2 d / h -
// v_0. So C is a stiffness 2 C / h more:
//   (M + theta (K + 2 C / h)) d = h p_0 + h^2 ((1/2 - beta) M a_0 + beta e),
//   e = (1 + alpha) f_1 - alpha f_0 - K u_0 + (1 + 2 alpha) C v_0.
// The small move, not the end, is solved for: stiff modes then lose no digits.
void CoupledBody::predict_newmark(double h) {
  const double alpha = newmark_.numbers.alpha, beta = newmark_.numbers.beta();
  if (!newmark_.has_started) {
    loads_.sum(t_, newmark_.f0);
    newmark_.F = newmark_.f0 - stiffness_force();
    if (is_damped()) newmark_.F -= Cv_;
    newmark_.Ma = newmark_.F;
    if (alpha != 0 && !is_damped()) {
      newmark_.a = newmark_.Ma;
      system_->factor(0).solve(newmark_.a);
      newmark_.a0_Ma0 = newmark_.a.dot(newmark_.Ma);
    }
    newmark_.has_started = true;
  }
  Vector& e = work_vector_;
  e = -stiffness_force();
  if (is_damped()) e += (1 + 2 * alpha) * Cv_;
  newmark_.move = h * p_ + h * h * ((0.5 - beta) * newmark_.Ma + beta * e);
  if (!loads_.empty()) {
    loads_.sum(t_ + h, newmark_.f1);
    newmark_.move += (h * h * beta) * ((1 + alpha) * newmark_.f1 - alpha * newmark_.f0);
  }
  system_->factor(theta(h)).solve(newmark_.move);
  newmark_.move /= mass_factor(h);
  u_end_ = u_ + newmark_.move;
}

// Central differences: velocities between two steps are those under them.
void CoupledBody::own_expect_forces(Index set, const Points& forces) {
  v_now_is_current_ = scheme() == Scheme::newmark && v_now_is_current_;
  lasting_.resize(0);
  if (scheme() == Scheme::newmark) return;
  if (forces.rows() == 0) return;
  lasting_.setZero(u_.size());
  for (Index i = 0; i < forces.rows(); ++i)
    lasting_.segment<3>(system_->n_modal() + 3 * sets_[set][i]) +=
        placement_.T.transpose() * forces.row(i).transpose();
  system_->drop_held(lasting_);
}

void CoupledBody::own_take_impulses(Index set, const Impulses& of) {
  const Points& impulses = of.all;
  const auto& nodes = sets_[set];
  Vector& dp = work_vector_;
  dp.setZero();
  bool any = false;
  for (Index i = 0; i < impulses.rows(); ++i) {
    if (impulses.row(i).isZero(0)) continue;
    any = true;
    const Vector3 p = placement_.T.transpose() * impulses.row(i).transpose();
    kicks_.push_back({nodes[i], p});
    dp.segment<3>(system_->n_modal() + 3 * nodes[i]) += p;
  }
  if (!any) return;
  system_->drop_held(dp);
  kick_.add(dp);
  system_->factor(theta(h_)).solve(dp);
  dp /= mass_factor(h_);
  if (scheme() == Scheme::central_difference) {
    v_end_ += dp;
    u_end_ += h_ * dp;
  } else {
    newmark_.move += 0.5 * h_ * dp;
    u_end_ = u_ + newmark_.move;
  }
}

Vector3 CoupledBody::own_add_velocities(Index set, const Points& velocities,
                                        const Vector3& momentum) {
  assert(scheme() == Scheme::central_difference && !is_damped());
  const auto& nodes = sets_[set];
  const Index n_modal = system_->n_modal();
  const auto MR = system_->rigid_momentum().leftCols(3);
  // Momentum of the velocities, and of a uniform velocity of the set's nodes: T MR_i^T P_i T^T of
  // each node   (3 x 3)
  Vector dv = Vector::Zero(system_->n()), uniform = dv;
  for (Index i = 0; i < velocities.rows(); ++i)
    dv.segment<3>(n_modal + 3 * nodes[i]) =
        placement_.T.transpose() * velocities.row(i).transpose();
  system_->drop_held(dv);
  Matrix all = Matrix::Zero(system_->n(), 3);
  for (int a = 0; a < 3; ++a) {
    uniform.setZero();
    for (const Index node : nodes)
      uniform.segment<3>(n_modal + 3 * node) = placement_.T.row(a).transpose();
    system_->drop_held(uniform);
    all.col(a) = uniform;
  }
  const Matrix3 mass = placement_.T * (MR.transpose() * all);
  const Vector3 missing = momentum - placement_.T * (MR.transpose() * dv);
  const Vector3 extra = solve_semidefinite(mass, missing).value_or(Vector3::Zero());
  dv += all * extra;
  system_->multiply_mass(dv, work_vector_);
  system_->drop_held(work_vector_);
  velocity_kick_.add(work_vector_);
  v_end_ += dv;
  u_end_ += h_ * dv;
  return extra;
}

// Kicks work with a mean velocity: of those before and after them, or of the step.
void CoupledBody::book_kicks(const Vector& mean_velocity) {
  for (const NodeKick& kick : kicks_)
    work_.contact += kick.impulse.dot(displacement(mean_velocity, kick.node));
}

void CoupledBody::accept_central() {
  // The leapfrog's own energy answers to forces with the average of v- and v+.
  v_now_ = 0.5 * (v_ + v_end_);
  book_kicks(v_now_);
  if (velocity_kick_) work_.contact += velocity_kick_.sum().dot(v_now_);
  if (!loads_.empty()) {
    loads_.sum(t_, work_vector_);
    work_.external += 0.5 * (last_h_ + h_) * work_vector_.dot(v_now_);
  }
  // Its energy holds a term -h/2 v . K u: a change of h brings (h - h-)/4 K u . (v+ - v-).
  if (h_ != last_h_) work_.numerical += 0.25 * (h_ - last_h_) * stiffness_force().dot(v_end_ - v_);
  if (is_damped()) book_central_damping();
  if (kick_) p_end_ += kick_.sum() / mass_factor(h_);
  if (velocity_kick_) p_end_ += velocity_kick_.sum();
  last_h_ = h_;
  p_.swap(p_end_);
  v_.swap(v_end_);
}

// What belongs to the end follows from the move that contact has left: F_1 = f_1 - K u_1, M a_1 =
// (1 + alpha) F_1 - alpha F_0 and p_1 = p_0 + h ((1 - gamma) M a_0 + gamma M a_1) + the impulses,
// which are no part of a (schemes.hpp).
void CoupledBody::accept_newmark() {
  if (is_damped()) return accept_newmark_damped();
  const double alpha = newmark_.numbers.alpha, gamma = newmark_.numbers.gamma();
  if (kick_) {
    v_now_ = newmark_.move / h_;
    book_kicks(v_now_);
    p_ += kick_.sum();
  }
  Vector& change_of_Ku = work_vector_;
  change_of_Ku = -stiffness_force();
  u_.swap(u_end_);
  Ku_is_current_ = false;
  change_of_Ku += stiffness_force();
  p_ += h_ * (1 - gamma) * newmark_.Ma;
  newmark_.Ma = -alpha * newmark_.F;
  if (loads_.empty()) {
    newmark_.F = -stiffness_force();
  } else {
    work_.external += 0.5 * newmark_.move.dot(newmark_.f0 + newmark_.f1);
    newmark_.F = newmark_.f1 - stiffness_force();
  }
  newmark_.Ma += (1 + alpha) * newmark_.F;
  system_->drop_held(newmark_.Ma);
  p_ += h_ * gamma * newmark_.Ma;
  if (alpha != 0) book_scheme(change_of_Ku);
  if (!loads_.empty()) newmark_.f0.swap(newmark_.f1);
}

// With [.] the change over a step and [.]' that over the step before, the energy changes beyond the
// loads' [u] . (f_0 + f_1) / 2 by
//   loads:   -k [u] . ([f] - [f]'),   k = alpha (1/2 + alpha)
//   scheme:  k [u] . ([K u] - [K u]') - alpha^2 h^2 / 4 (1/2 [a . M a] - alpha [a] . M [a]) -
//   alpha^2 h / 4 impulses . [a].
void CoupledBody::book_scheme(const Vector& change_of_Ku) {
  const double alpha = newmark_.numbers.alpha, k = alpha * (0.5 + alpha),
               quarter = 0.25 * alpha * alpha * h_ * h_;
  if (!loads_.empty()) {
    work_.external -= k * (newmark_.move.dot(newmark_.f1) - newmark_.move.dot(newmark_.f0) -
                           newmark_.move.dot(newmark_.last_change_of_f));
    newmark_.last_change_of_f = newmark_.f1 - newmark_.f0;
  }
  work_.numerical +=
      k * (newmark_.move.dot(change_of_Ku) - newmark_.move.dot(newmark_.last_change_of_Ku));
  newmark_.last_change_of_Ku = change_of_Ku;
  Vector& a_1 = v_now_;
  a_1 = newmark_.Ma;
  system_->factor(0).solve(a_1);
  const double a1_Ma1 = a_1.dot(newmark_.Ma), a0_Ma1 = newmark_.a.dot(newmark_.Ma);
  work_.numerical -= quarter * (0.5 * (a1_Ma1 - newmark_.a0_Ma0) -
                                alpha * (a1_Ma1 - 2 * a0_Ma1 + newmark_.a0_Ma0));
  if (kick_) work_.numerical -= quarter / h_ * (kick_.sum().dot(a_1) - kick_.sum().dot(newmark_.a));
  newmark_.a0_Ma0 = a1_Ma1;
  newmark_.a.swap(a_1);
}

void CoupledBody::own_accept() {
  v_now_is_current_ = false;
  if (scheme() == Scheme::central_difference) {
    accept_central();
    u_.swap(u_end_);
    Ku_is_current_ = false;
  } else {
    arrive_newmark();
    newmark_.has_arrived = false;
  }
  t_ += h_;
}

void CoupledBody::arrive_newmark() {
  if (!newmark_.has_arrived) accept_newmark();
  newmark_.has_arrived = true;
}

void CoupledBody::own_end_velocities(Index set, Points& v) {
  arrive_newmark();
  v_now_ = p_;
  system_->factor(0).solve(v_now_);
  const auto& nodes = sets_[set];
  v.resize(static_cast<Index>(nodes.size()), 3);
  for (Index i = 0; i < v.rows(); ++i)
    v.row(i) = (placement_.T * displacement(v_now_, nodes[i])).transpose();
}

// Precondition: end_velocities() has been asked for in this step.
void CoupledBody::own_add_end_impulses(Index set, const Points& impulses) {
  const auto& nodes = sets_[set];
  Vector& dv = work_vector_;
  dv.setZero();
  for (Index i = 0; i < impulses.rows(); ++i)
    dv.segment<3>(system_->n_modal() + 3 * nodes[i]) +=
        placement_.T.transpose() * impulses.row(i).transpose();
  system_->drop_held(dv);
  p_ += dv;
  work_.contact += v_now_.dot(dv);
  Vector& dp = newmark_.move;  // which has served
  dp = dv;
  system_->factor(0).solve(dv);
  work_.contact += 0.5 * dp.dot(dv);
  v_now_ += dv;
  if (is_damped()) {
    damping_force(dp, dv, damping_room_);
    newmark_.Ma -= damping_room_;
    Cv_ += damping_room_;
    v_ += dv;
  }
}

std::unique_ptr<Body> coupled_body(std::string name, std::shared_ptr<const CoupledModel> model,
                                   const Placement& placement,
                                   const std::vector<HeldDirection>& held, Scheme scheme,
                                   const NewmarkOptions& newmark) {
  const std::string where = "instance '" + name + "'";
  auto system = std::make_shared<CoupledSystem>(std::move(model), held, where);
  return std::make_unique<CoupledBody>(std::move(name), std::move(system), placement, scheme,
                                       newmark);
}

}  // namespace cbr
