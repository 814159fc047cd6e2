// SPDX-License-Identifier: GPL-3.0-or-later
// Outputs of a coupled body, its response, and Rayleigh's damping, C = alpha M + beta K.
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <utility>

#include "common/files/state_archive.hpp"
#include "common/linalg/dense.hpp"
#include "dynamics/motion/coupled/coupled_body.hpp"

namespace cbr {

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
