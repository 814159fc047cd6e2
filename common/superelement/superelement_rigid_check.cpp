// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement's parts against one another: what its coordinates and /rigid_body say of rigid
// motions, and what its matrices or modes make of them.
#include <algorithm>
#include <cmath>
#include <string>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/linalg/dense.hpp"
#include "common/superelement/superelement_check.hpp"

namespace cbr {
namespace {

// Far above errors of reductions of thin parts and of other programs' digits; far below a wrong
// file.
constexpr double tolerance = 1e-2;
constexpr double no_force = 1e-6;  // of |K_cc| |R|

class RigidCheck {
 public:
  RigidCheck(const Superelement& superelement, const std::string& where)
      : s_(superelement), where_(where) {
    if (s_.coordinates.rows() > 0)
      size_ =
          (s_.coordinates.rowwise() - s_.rigid_body.center.transpose()).rowwise().norm().maxCoeff();
    R_ = reduced_rigid_modes(s_, s_.rigid_body.center).bottomRows(s_.c());
    // Rotations in units of length
    if (size_ > 0) R_.rightCols(3) /= size_;
    const PivotedQr qr(R_, 1e-6);
    // Few nodes, or nodes with some of their dofs, do not determine all rigid motions of the
    // component
    is_told_ = std::isfinite(size_) && size_ > 0 && all_dofs_are_there() && qr.rank() == 6;
  }

  void check() const {
    if (!is_told_ || s_.fixed.any()) return;
    if (s_.is_massless() && s_.massless.V.size() > 0)
      return check_modes("/massless/V", s_.massless.V, s_.eigenvalues);
    if (s_.is_characteristic() && s_.characteristic.V.size() > 0)
      return check_modes("/characteristic/V", s_.characteristic.V, s_.eigenvalues);
    if (!s_.has_interface_matrices() || is_held_inside(s_)) return;
    if (s_.M_cc.rows() == s_.c()) {
      // R^T M R with R = [0; R_c]   (6 x 6)
      const Matrix6 mass = R_.transpose() * (s_.M_cc * R_);
      compare("/matrices/M_cc", mass);
    } else if (s_.has_diagonal_form()) {
      check_modes("/diagonal/V", s_.V.bottomRows(s_.c()), s_.omega);
    }
    for (const auto& [name, load] : s_.loads) check_load("/loads/" + name + "/force", load);
    for (const auto& recovery : s_.recovery) check_recovery(recovery);
  }

 private:
  // x, y and z of every node, beside any rotations.
  bool all_dofs_are_there() const {
    const auto n_turning = std::count_if(s_.dof_component.begin(), s_.dof_component.end(),
                                         [](int component) { return component > 2; });
    return s_.c() - n_turning == 3 * s_.coordinates.rows();
  }

  [[noreturn]] void fail(const std::string& field, const std::string& what) const {
    throw InputError(
        where_ + ": " + field + ": " + what +
        ": the file has been changed, or was written wrongly (run cbr-reduce --force)");
  }

  void compare(const std::string& field, const Matrix6& found) const {
    Matrix6 mass = Matrix6::Zero();
    mass.topLeftCorner<3, 3>().diagonal().setConstant(s_.rigid_body.mass);
    mass.bottomRightCorner<3, 3>() = s_.rigid_body.inertia / (size_ * size_);
    // Against the larger of the two that the farthest node and the radius of gyration make
    Vector scale = Vector::Constant(6, std::sqrt(s_.rigid_body.mass));
    scale.tail(3).setConstant(
        std::sqrt(std::max(s_.rigid_body.mass, s_.rigid_body.inertia.trace() / (size_ * size_))));
    const Vector inverse = scale.cwiseInverse();
    const double difference =
        (inverse.asDiagonal() * (found - mass) * inverse.asDiagonal()).cwiseAbs().maxCoeff();
    if (found.allFinite() && difference <= tolerance) return;  // not for a NaN
    fail(field,
         "does not agree with /nodes/coordinates and /rigid_body: their rigid motions have another "
         "mass or inertia, by " +
             (std::isfinite(difference) ? number_text(difference) : "far more than 1") +
             " of the mass, allowed 0.01");
  }

  // Modes of frequency 0 are rigid motions of unit mass: V_r E = R_c, and E^T E is their mass.
  template <typename Modes>
  void check_modes(const std::string& field, const Modes& V, const Vector& frequencies) const {
    const Index r = (frequencies.array() == 0).count();
    const Matrix V_r = V.leftCols(r);
    Matrix E = Matrix::Zero(r, 6);
    if (r > 0 && V_r.cwiseAbs().maxCoeff() > 0) E = PivotedQr(V_r).solve(R_);
    const double left = (R_ - V_r * E).cwiseAbs().maxCoeff() / R_.cwiseAbs().maxCoeff();
    if (!E.allFinite() || !(left <= tolerance))
      fail(field, "its " + std::to_string(r) +
                      " modes of frequency 0 do not hold the rigid motions of /nodes/coordinates");
    compare(field, Matrix6(E.transpose() * E));
  }

  // A unit traction along each axis pulls with the area: R_t^T F = A I   (3 x 3)
  void check_load(const std::string& field, const Superelement::InteriorLoad& load) const {
    const Matrix3 pull = R_.leftCols(3).transpose() * load.force.bottomRows(s_.c());
    const double difference = (pull / load.weight - Matrix3::Identity()).cwiseAbs().maxCoeff();
    if (pull.allFinite() && difference <= tolerance) return;
    fail(field, "the forces of a unit traction do not add up to the area in /weight, " +
                    number_text(load.weight));
  }

  // Psi R_c = R_I: the inner nodes and the rotations go along   (3 (n_I + rotations) x 6)
  void check_recovery(const Superelement::Recovery& recovery) const {
    const auto n_rotations = static_cast<Index>(recovery.rotations.size());
    Points X = Points::Zero(recovery.coordinates.rows() + n_rotations, 3);
    X.topRows(recovery.coordinates.rows()) = recovery.coordinates;
    Matrix R_I = rigid_modes(X, s_.rigid_body.center, n_rotations);
    R_I.rightCols(3) /= size_;
    const Matrix difference = recovery.Psi * R_ - R_I;
    if (difference.size() == 0 ||
        (difference.allFinite() &&
         difference.cwiseAbs().maxCoeff() <= tolerance * R_I.cwiseAbs().maxCoeff()))
      return;
    fail("/recovery/Psi",
         "the rigid motions that it makes of the interface's are not those of "
         "/recovery/nodes/coordinates");
  }

  const Superelement& s_;
  const std::string& where_;
  double size_ = 0;  // farthest node from the centre
  Matrix R_;         // c x 6
  bool is_told_ = false;
};

}  // namespace

bool is_held_inside(const Superelement& s) {
  if (!s.has_interface_matrices() || s.c() == 0) return false;
  if (s.K_cc.rows() != s.c()) return s.has_diagonal_form() && (s.omega.array() == 0).count() < 6;
  const Matrix T = reduced_rigid_modes(s, s.rigid_body.center).block(s.k(), 0, s.c(), 3);
  return (s.K_cc * T).norm() > no_force * s.K_cc.norm() * T.norm();
}

void check_rigid_motions(const Superelement& superelement, const std::string& where) {
  RigidCheck(superelement, where).check();
}

}  // namespace cbr
