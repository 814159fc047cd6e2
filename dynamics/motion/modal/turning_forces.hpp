// SPDX-License-Identifier: GPL-3.0-or-later
// Forces on the modes of a body with large rotation, in axes that turn with it.
#pragma once

#include <Eigen/Geometry>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/superelement/superelement.hpp"
#include "dynamics/motion/body.hpp"
#include "dynamics/motion/damping.hpp"
#include "dynamics/motion/loads.hpp"
#include "dynamics/motion/modal/forms/modal_form.hpp"

namespace cbr {

// Work in one flow of the modes between two kicks.
struct FlowWork {
  double external = 0, spin = 0, contact = 0;
  double sum() const { return external + spin + contact; }
};

// H g, each column of H (n x m) times its factor g and its history: first those of the spin on the
// elastic modes, H = V^T spin_moments (n x 6), then those of loads. And the coupling of the modes
// by the spin, in which their velocities v are the momenta p of SpinCoupling.
class TurningForces {
 public:
  // Before the first step. False: the superelement has no moments.
  bool feel_spin(const Superelement& superelement, const ModalForm& form,
                 const ModalRates& damping);
  void add(const Vector& column, const LoadHistory& history);
  // Before each step: g at equal times from its start to its end, linear in between (a row for each
  // column of H; 0 or more than 1 columns).
  void take_factors(Matrix g) { g_ = std::move(g); }
  // Null: the superelement has none.
  const SpinCoupling* coupling() const { return coupling_.get(); }
  // Before each step: the spin at its start and its end, component axes; or none.
  void couple(const Vector3& start, const Vector3& end);
  void uncouple() { pulls_.reset(); }
  // The eta' that coupled modes (m) have beyond p, until the next call; empty: none.
  void take_drift(const Vector& drift, Index n);
  // For motion bounds, until the next call: of each |g|, at most. energy: J, which the coupled
  // modes may get from the spin; below 0: they are not coupled.
  void expect(const Vector& largest, double energy) {
    largest_ = largest;
    energy_of_spin_ = energy;
  }
  Vector spin_shape(const Vector& eta) const {  // H^T eta of a spin, 6
    return H_.leftCols(n_spin_).transpose() * eta;
  }

  bool empty() const { return H_.size() == 0; }
  bool act() const { return g_.cols() > 0; }
  Index n_parts() const { return g_.cols() - 1; }  // of a step
  bool of_spin() const { return act() && n_spin_ > 0; }
  bool of_loads() const { return act() && H_.cols() > n_spin_; }
  // At t in the step h from t_0.
  Vector spin_force(double t, double t_0, double h) const { return force(t, t_0, h, 0, n_spin_); }
  Vector load_force(double t, double t_0, double h) const {
    return force(t, t_0, h, n_spin_, H_.cols() - n_spin_);
  }
  // The largest modal forces at any time, of all and of loads.
  Vector largest_force() const { return H_.cwiseAbs() * largest_; }
  Vector largest_load() const {
    const Index n = H_.cols() - n_spin_;
    return H_.rightCols(n).cwiseAbs() * largest_.tail(n);
  }
  Index n_coupled() const { return energy_of_spin_ >= 0 ? coupling_->size() : 0; }
  double energy_of_spin() const { return energy_of_spin_; }
  const Vector& drift() const { return drift_; }  // n, or empty

  bool couples() const { return pulls_.has_value(); }
  // The modes have changed, otherwise than by pull_at_start().
  void forget_start() {
    if (pulls_) pulls_->is_known = false;
  }
  // Half a step of the coupling, before and after the flow without it.
  void pull_at_start(double t, double h, Vector& eta, Vector& v, FlowWork* work);
  void pull_at_end(double t, double h, Vector& eta, Vector& v, FlowWork* work);
  // The same of a change of the modes.
  void move_at_start(double h, Vector& eta, Vector& v) const;
  void move_at_end(double h, Vector& eta, Vector& v) const;

 private:
  struct Pulls {
    Vector3 w_start;  // component axes
    SpinCoupling::Pull start, end;
    // after the pull at the start of a step h; is_known: for the present state
    Vector eta, v;
    double h;
    bool is_known;
  };
  Vector force(double t, double t_0, double h, Index first, Index count) const;
  double energy(const Vector& eta, const Vector& v) const;
  void book_drift(const Vector& drift, double t, double t_0, double h, const Vector& v,
                  FlowWork& work) const;

  Matrix H_, g_;
  std::vector<LoadHistory> histories_;
  Vector largest_, omega_, damping_;
  Index n_spin_ = 0;
  std::shared_ptr<const SpinCoupling> coupling_;
  std::optional<Pulls> pulls_;
  Vector drift_;
  double energy_of_spin_ = -1;
};

class ModalBody;

// A VectorForce on a body in axes that turn with it: all is linear in the vector b there.
class TurningLoad {
 public:
  // axes: those of the scene at the start. modal: undeformed.
  TurningLoad(const VectorForce& force, const LoadHistory& history, const ModalBody& modal);

  // n x 3: forces on the elastic modes, b = unit vectors
  const Matrix& elastic() const { return elastic_; }
  const LoadHistory& history() const { return history_; }
  // b and the resultant, the latter in the scene's axes, of a history of 1; q: unit quaternion of
  // the turn
  Vector3 vector(const Eigen::Quaterniond& q) const {
    return follows_ ? value_ : q.conjugate() * value_;
  }
  Vector3 resultant(const Eigen::Quaterniond& q) const { return q * (resultant_ * vector(q)); }
  // The moment about the centre of mass, scene axes, of a history of 1. eta: the modal coordinates.
  Vector3 moment(const Eigen::Quaterniond& q, const Vector& eta) const;
  // of the largest of the history; arms of the undeformed body
  double largest_vector() const { return value_.norm() * history_.largest(); }
  double largest_moment() const { return largest_of(moment_); }
  double largest_resultant() const { return largest_of(resultant_); }

 private:
  // of a vector that stays as it is, or points anywhere
  double largest_of(const Matrix3& map) const {
    return history_.largest() * (follows_ ? (map * value_).norm() : map.norm() * value_.norm());
  }
  Vector3 value_;
  bool follows_;
  LoadHistory history_;
  Matrix elastic_;
  Matrix3 resultant_ = Matrix3::Zero(), moment_ = Matrix3::Zero();  // columns: of unit vectors b
  Matrix bend_;  // n x 9: change of moment_ by each modal coordinate, column by column
};

}  // namespace cbr
