// SPDX-License-Identifier: GPL-3.0-or-later
// How a coupled body is advanced.
#include "dynamics/motion/coupled/coupled_body.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

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
      damping_(damping),
      newmark_(newmark, operators()) {
  assert(scheme != Scheme::exact);
  for (Vector* x : {&u_, &u_end_, &p_end_, &work_vector_, &room_, &Ku_, &v_now_})
    x->setZero(system_->n());
  // The rigid motion, or its projection when directions are held.
  p_.noalias() =
      system_->rigid_momentum().leftCols(3) * (placement_.T.transpose() * placement_.velocity);
  system_->drop_held(p_);
  solve_for_velocities();
}

// Central differences move velocities, too.
void CoupledBody::solve_for_velocities() {
  if (scheme() == Scheme::newmark) return;
  v_ = p_;
  system_->factor(0).solve(v_);
  v_end_ = v_;
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
  lasting_.resize(0);
  kick_.clear();
  velocity_kick_.clear();
  if (scheme() == Scheme::central_difference) {
    predict_central(h_);
  } else {
    newmark_.predict(t_, h_, loads_, u_, p_, u_end_);
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

// A step multiplies with K once: at its end, which is the start of the next.
NewmarkOperators CoupledBody::operators() {
  NewmarkOperators of;
  of.stiffness = [this](const Vector&, Vector& Ku) { Ku = stiffness_force(); };
  of.stiffness_of_move = [this](const Vector&, const Vector& u_end, Vector& K_move) {
    Ku_end_.resize(u_end.size());
    system_->multiply_stiffness(u_end, Ku_end_);
    system_->drop_held(Ku_end_);
    K_move = Ku_end_ - stiffness_force();
  };
  of.solve_mass = [this](Vector& f) { system_->factor(0).solve(f); };
  of.solve = [this](double h, Vector& f) {
    system_->factor(theta(h)).solve(f);
    f *= h / mass_factor(h);
  };
  if (!is_damped()) return of;
  of.damping = [this](const Vector& p, Vector& Cv) {
    room_ = p;
    system_->factor(0).solve(room_);
    damping_force(p, room_, Cv);
  };
  of.damping_of_move = [this](const Vector& move, Vector& Cd) {
    system_->multiply_mass(move, room_);
    system_->drop_held(room_);
    damping_force(room_, move, Cd);
  };
  of.energy = [this](const Vector& u, const Vector& p, bool at_end) {
    room_ = p;
    system_->factor(0).solve(room_);
    return 0.5 * (p.dot(room_) + u.dot(at_end ? Ku_end_ : stiffness_force()));
  };
  return of;
}

// Central differences: velocities between two steps are those under them.
void CoupledBody::own_expect_forces(Index set, const Points& forces) {
  v_now_is_current_ = scheme() == Scheme::newmark && v_now_is_current_;
  lasting_.resize(0);
  if (scheme() == Scheme::newmark) return;
  if (forces.rows() == 0) return;
  spread(sets_[set], forces, lasting_);
}

void CoupledBody::own_take_impulses(Index set, const Impulses& of) {
  if (of.all.isZero(0)) return;
  Vector& dp = work_vector_;
  spread(sets_[set], of.all, dp);
  kick_.add(dp);
  system_->factor(theta(h_)).solve(dp);
  dp /= mass_factor(h_);
  if (scheme() == Scheme::central_difference) {
    v_end_ += dp;
    u_end_ += h_ * dp;
  } else {
    dp *= 0.5 * h_;
    newmark_.push(dp, u_, u_end_);
  }
}

Vector3 CoupledBody::own_add_velocities(Index set, const Points& velocities,
                                        const Vector3& momentum) {
  assert(scheme() == Scheme::central_difference && !is_damped());
  const auto& nodes = sets_[set];
  const auto MR = system_->rigid_momentum().leftCols(3);
  // Momentum of the velocities, and of a uniform velocity of the set's nodes: T MR_i^T P_i T^T of
  // each node   (3 x 3)
  Vector dv, uniform;
  spread(nodes, velocities, dv);
  Matrix all(system_->n(), 3);
  for (int a = 0; a < 3; ++a) {
    spread(nodes, Points::Identity(3, 3).row(a).replicate(velocities.rows(), 1), uniform);
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

void CoupledBody::accept_central() {
  // The leapfrog's own energy answers to forces with the average of v- and v+.
  v_now_ = 0.5 * (v_ + v_end_);
  if (kick_) work_.contact += kick_.sum().dot(v_now_);
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

void CoupledBody::own_accept() {
  v_now_is_current_ = false;
  if (scheme() == Scheme::central_difference) {
    accept_central();
    Ku_is_current_ = false;
  } else {
    arrive_newmark();
    newmark_.accept();
    p_.swap(p_end_);
    Ku_.swap(Ku_end_);
  }
  u_.swap(u_end_);
  t_ += h_;
}

void CoupledBody::arrive_newmark() {
  if (!newmark_.has_arrived())
    newmark_.arrive(!loads_.empty(), kick_, u_, p_, u_end_, p_end_, work_);
}

void CoupledBody::own_end_velocities(Index set, Points& v) {
  arrive_newmark();
  v_now_ = p_end_;
  system_->factor(0).solve(v_now_);
  const auto& nodes = sets_[set];
  v.resize(static_cast<Index>(nodes.size()), 3);
  for (Index i = 0; i < v.rows(); ++i)
    v.row(i) = (placement_.T * displacement(v_now_, nodes[i])).transpose();
}

// Precondition: end_velocities() has been asked for in this step.
void CoupledBody::own_add_end_impulses(Index set, const Points& impulses) {
  Vector& dp = work_vector_;
  spread(sets_[set], impulses, dp);
  newmark_.feel_end(dp);
  p_end_ += dp;
  Vector& dv = room_;
  dv = dp;
  system_->factor(0).solve(dv);
  work_.contact += v_now_.dot(dp) + 0.5 * dp.dot(dv);
  v_now_ += dv;
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

Index CoupledBody::own_track(const std::vector<Index>& nodes) {
  sets_.push_back(nodes);
  return static_cast<Index>(sets_.size()) - 1;
}

Index CoupledBody::own_track_mean(const std::vector<Index>& nodes) {
  means_.push_back(nodes);
  return static_cast<Index>(means_.size()) - 1;
}

void CoupledBody::gather(const Vector& u, const std::vector<Index>& nodes, Points& x) const {
  x.resize(static_cast<Index>(nodes.size()), 3);
  for (Index i = 0; i < x.rows(); ++i)
    x.row(i) = own_nodes().row(nodes[i]) + (placement_.T * displacement(u, nodes[i])).transpose();
}

void CoupledBody::spread(const std::vector<Index>& nodes, const Points& forces, Vector& f) const {
  f.setZero(system_->n());
  for (Index i = 0; i < forces.rows(); ++i)
    f.segment<3>(system_->n_modal() + 3 * nodes[i]) +=
        placement_.T.transpose() * forces.row(i).transpose();
  system_->drop_held(f);
}

void CoupledBody::own_positions(Index set, Points& x) const { gather(u_, sets_[set], x); }
void CoupledBody::own_predicted_positions(Index set, Points& x) const {
  gather(u_end_, sets_[set], x);
}

void CoupledBody::own_mean_motion(Index set, Vector3& position, Vector3& velocity) const {
  const Vector& present = present_velocities();
  position.setZero();
  velocity.setZero();
  for (const Index node : means_[set]) {
    position += own_nodes().row(node).transpose() + placement_.T * displacement(u_, node);
    velocity += placement_.T * displacement(present, node);
  }
  const double n = static_cast<double>(means_[set].size());
  position /= n;
  velocity /= n;
}

// Newmark: at the end of the last step. Central differences: the mid-step momentum, half a step on
// under the internal forces and loads: second order at t_.
const Vector& CoupledBody::present_velocities() const {
  if (v_now_is_current_) return v_now_;
  if (scheme() == Scheme::central_difference && last_h_ == 0) {
    v_now_ = v_;
  } else {
    v_now_ = p_;
    if (scheme() == Scheme::central_difference) {
      loads_.sum(t_, work_vector_);
      if (lasting_.size() > 0) work_vector_ += lasting_;
      v_now_ += 0.5 * last_h_ * (work_vector_ - stiffness_force());
      if (is_damped()) {
        damping_force(Vector::Zero(v_.size()), v_, room_);  // beta K v- alone
        v_now_ = (v_now_ - 0.5 * last_h_ * room_) / (1 + 0.5 * last_h_ * damping_.alpha);
      }
    }
    system_->factor(0).solve(v_now_);
  }
  v_now_is_current_ = true;
  return v_now_;
}

// A lumped mesh answers node by node: the mass of a node is the same in all directions, and its row
// of M R is that mass.
NodeResponse CoupledBody::mass_response(const std::vector<Index>& nodes, double weight) const {
  NodeResponse response;
  bool node_by_node = system_->factor(0).diagonal().size() > 0;
  for (std::size_t i = 0; node_by_node && i < nodes.size(); ++i)
    node_by_node = !system_->is_held(nodes[i]);
  if (!node_by_node) {
    response.set_block(weight * system_->factor(0).nodal_inverse(nodes, placement_.T));
    return response;
  }
  const Index n_modal = system_->n_modal();
  response.diagonal.resize(3 * static_cast<Index>(nodes.size()));
  for (std::size_t i = 0; i < nodes.size(); ++i)
    response.diagonal.segment<3>(3 * static_cast<Index>(i))
        .setConstant(weight / system_->rigid_momentum()(n_modal + 3 * nodes[i], 0));
  return response;
}

// h M^-1, or h / 2 A^-1 (schemes.hpp).
NodeResponse CoupledBody::own_response(Index set, double h) const {
  if (scheme() == Scheme::central_difference) return mass_response(sets_[set], h / mass_factor(h));
  NodeResponse response;
  response.set_block(0.5 * h / mass_factor(h) *
                     system_->factor(theta(h)).nodal_inverse(sets_[set], placement_.T));
  return response;
}

NodeResponse CoupledBody::own_velocity_response(Index set) const {
  return mass_response(sets_[set], 1);
}

Points CoupledBody::nodal_masses(Index set) const {
  const auto& nodes = sets_[set];
  Points masses(static_cast<Index>(nodes.size()), 3);
  for (Index i = 0; i < masses.rows(); ++i) {
    const Vector3 of_node =
        system_->rigid_momentum().block<3, 3>(system_->n_modal() + 3 * nodes[i], 0).diagonal();
    masses.row(i) = (placement_.T.cwiseAbs2() * of_node).transpose();
  }
  return masses;
}

void CoupledBody::append_load(Vector force, const LoadHistory& history) {
  system_->drop_held(force);
  loads_.add(force, history);
}

void CoupledBody::add_loads(const std::vector<BodyLoad>& loads) {
  for (const BodyLoad& load : loads) {
    const auto [of_nodes, modal] = forces_of(load);
    if (of_nodes || modal.size() > 0) {
      const Points forces = of_nodes.on_nodes();
      Vector f = Vector::Zero(system_->n());
      f.head(modal.size()) = modal;
      for (Index i = 0; i < forces.rows(); ++i)
        f.segment<3>(system_->n_modal() + 3 * i) =
            placement_.T.transpose() * forces.row(i).transpose();
      append_load(std::move(f), load.history);
    }
    // M R_t g
    if (load.acceleration)
      append_load(
          system_->rigid_momentum().leftCols(3) * (placement_.T.transpose() * *load.acceleration),
          load.history);
  }
}

void CoupledBody::add_start_impulse(const Vector& impulse) {
  p_ += impulse;
  system_->drop_held(p_);
  solve_for_velocities();
}

BodyState CoupledBody::own_state() const {
  const Matrix& MR = system_->rigid_momentum();
  const Vector &Ku = stiffness_force(), &present = present_velocities();
  BodyState state =
      placement_.state(system_->model().rigid_body, MR.transpose() * u_, MR.transpose() * present);
  if (scheme() == Scheme::central_difference) {
    // 1/2 v- M v+ with v+ of the internal forces alone: what leapfrog conserves together with the
    // strain energy
    state.kinetic_energy = 0.5 * v_.dot(p_) - 0.5 * last_h_ * v_.dot(Ku);
  } else {
    state.kinetic_energy = 0.5 * present.dot(p_);
  }
  state.strain_energy = 0.5 * u_.dot(Ku);
  return state;
}

void CoupledBody::own_coordinates(Vector& q, Vector& rates) const {
  q = u_;
  rates = present_velocities();
}

void CoupledBody::own_displacements(Points& u, Points& v) const {
  const Index n_modal = system_->n_modal(), n = own_nodes().rows();
  u = Eigen::Map<const Points>(u_.data() + n_modal, n, 3) * placement_.T.transpose();
  v = Eigen::Map<const Points>(present_velocities().data() + n_modal, n, 3) *
      placement_.T.transpose();
}

void CoupledBody::own_keep_state(StateArchive& archive) {
  archive.expect(u_.size());
  archive(u_, p_, v_, t_, last_h_, work_);
  archive(newmark_, statics_, lasting_);
  if (archive.restores()) Ku_is_current_ = v_now_is_current_ = false;
}

// f = alpha p + beta K v, p = M v, on the free directions.
void CoupledBody::damping_force(const Vector& p, const Vector& v, Vector& f) const {
  if (damping_.beta == 0) {
    f = damping_.alpha * p;
    return;
  }
  f.resize(v.size());
  system_->multiply_stiffness(v, f);
  system_->drop_held(f);
  f = damping_.alpha * p + damping_.beta * f;
}

// The mean of v- and v+ (v_now_) times the damping's impulse. p_end_ does not have the kicks yet.
void CoupledBody::book_central_damping() {
  const double alpha = damping_.alpha;
  const Vector p_end = kick_ ? Vector(p_end_ + kick_.sum() / mass_factor(h_)) : p_end_;
  work_.damping -=
      0.5 * alpha * v_now_.dot(last_h_ * p_ + h_ * p_end) + 0.5 * (last_h_ + h_) * v_now_.dot(Cv_);
}

}  // namespace cbr
