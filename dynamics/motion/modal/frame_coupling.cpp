// SPDX-License-Identifier: GPL-3.0-or-later
// The coupling of the rotation of a body with its modes and its loads over a step.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "dynamics/motion/modal/frame.hpp"
#include "dynamics/motion/modal/modal_body.hpp"

namespace cbr {
namespace {

constexpr double largest_part = 0.1;  // rad
// The series converges up to a radian and more: 0.1^15 is below round-off.
constexpr int highest_order = 14;

// Of a part of `angle` at most: angle^(order + 1) is 1e-17, below round-off.
int order_of(double angle) {
  constexpr double digits = 17;
  if (!(angle > 0)) return 2;  // keeps values that are not finite
  const double n = std::ceil(digits / -std::log10(std::min(angle, largest_part)));
  return static_cast<int>(std::clamp(n, 2.0, static_cast<double>(highest_order)));
}

// rad, the most that a body turns in a part of a step. Forces that turn with it are linear in time
// there, with an error of the square of this angle / 12: small beside the terms of second order in
// the strain, which are neglected. Moments of loads act at the ends of a part, and need smaller
// ones.
constexpr double largest_turn = 0.1, largest_turn_of_loads = 0.02;
// rad: beyond it a step has millions of parts, and the scene is wrong.
constexpr double largest_turn_of_step = 1e4;

// The coupling of modes acts at the ends of a step: it turns by this at most, and the phase of the
// highest coupled mode by that, rad.
constexpr double largest_turn_of_coupling = 0.1, largest_phase = 2;

}  // namespace

FreeTurn::FreeTurn(const TurnInertia& of)
    : TurnInertia{0.5 * (of.J + of.J.transpose()), of.inner},
      J_inverse(J.inverse()),
      rate_per_momentum(J_inverse.norm()) {}

FreeTurn FreeTurn::between(const TurnInertia& from, const TurnInertia& to, double share) {
  return FreeTurn(TurnInertia{(1 - share) * from.J + share * to.J,
                              (1 - share) * from.inner + share * to.inner});
}

Vector3 FreeTurn::angular_velocity(const Eigen::Quaterniond& q, const Vector3& L) const {
  return q * Vector3(J_inverse * (q.conjugate() * L - inner));
}

Vector3 FreeTurn::change(const Eigen::Quaterniond& q, const Vector3& change_of_L) const {
  return q * Vector3(J_inverse * (q.conjugate() * change_of_L));
}

double FreeTurn::energy(const Eigen::Quaterniond& q, const Vector3& L) const {
  return 0.5 * (L - q * inner).dot(angular_velocity(q, L));
}

Eigen::Quaterniond FreeTurn::turned(const Eigen::Quaterniond& q, const Vector3& L, double h) const {
  const double angle = rate_per_momentum * (L.norm() + inner.norm()) * h;
  if (angle == 0) return q;
  const double n_parts = std::ceil(std::abs(angle) / largest_part);
  const double part = h / n_parts;
  const int order = order_of(std::abs(angle) / n_parts);
  Eigen::Quaterniond now = q;
  for (double i = 0; i < n_parts; ++i) {
    // l = sum l_n t^n, w = J^-1 l, l' = l x w; q = q_0 sum e_n t^n, e' = e w / 2   (n = 0 .. order)
    std::array<Vector3, highest_order + 1> l, w;
    std::array<Eigen::Vector4d, highest_order + 1> e;  // x y z, then the scalar
    l[0] = now.conjugate() * L;
    e[0] << 0, 0, 0, 1;
    Eigen::Vector4d sum = e[0];
    double power = 1;
    for (int n = 0; n < order; ++n) {
      w[n] = J_inverse * (n > 0 ? l[n] : Vector3(l[n] - inner));
      Vector3 l_rate = Vector3::Zero();
      Eigen::Vector4d e_rate = Eigen::Vector4d::Zero();
      for (int k = 0; k <= n; ++k) {
        const Vector3 v = e[k].head<3>();
        l_rate += l[k].cross(w[n - k]);
        e_rate.head<3>() += e[k][3] * w[n - k] + v.cross(w[n - k]);
        e_rate[3] -= v.dot(w[n - k]);
      }
      l[n + 1] = l_rate / (n + 1);
      e[n + 1] = e_rate / (2 * (n + 1));
      power *= part;
      sum += power * e[n + 1];
    }
    // L stays in the scene's axes, so l is always taken from q: no error of l is carried on
    now = (now * Eigen::Quaterniond(sum)).normalized();
  }
  return now;
}

// J, an upper bound of the energy of coupled modes from the spin: all of it but that of the same
// momentum about the axis of the largest inertia, which oscillates. momentum: at most, with loads.
double Frame::energy_for_modes(double momentum) const {
  const double all =
      loads_.empty() ? spin_energy(now_) : 0.5 * momentum * momentum * now_.rate_per_momentum;
  const double left = loads_.empty() ? 0.5 * L_.squaredNorm() / (1.1 * largest_inertia_) : 0;
  return std::max(0.0, all - left);
}

// J_0 + 2 (tr S 1 - S): the inertia of the deformed body, first order; shape: S, component axes,
// as xx, yy, zz, xy, yz, xz.
Matrix3 Frame::inertia(const Vector& shape) const {
  Matrix3 S;
  S << shape[0], shape[3], shape[5], shape[3], shape[1], shape[4], shape[5], shape[4], shape[2];
  return J_0_ +
         2 * (S.trace() * Matrix3::Identity() - modal_.axes() * S * modal_.axes().transpose());
}

// An axial vector of the component's axes in those of the body, and back.
Vector3 Frame::axial(const Vector3& of_component) const {
  return modal_.axes().determinant() * (modal_.axes() * of_component);
}

Vector3 Frame::in_component(const Vector3& axial) const {
  return modal_.axes().determinant() * (modal_.axes().transpose() * axial);
}

// Of the deformed body, where the modes have the forces of the spin.
TurnInertia Frame::present_turn(SpinCoupling::Shape& shape) const {
  const Matrix3 J = inertia(modal_.flow_.turning().spin_shape(modal_.modal_coordinates()));
  if (!is_coupled()) return {J};
  shape = coupling_->shape(modal_.modal_coordinates(), modal_.modal_velocities());
  return with(J, shape);
}

TurnInertia Frame::predicted_turn() const {
  const Matrix3 J =
      inertia(modal_.flow_.turning().spin_shape(modal_.predicted_modal_coordinates()));
  if (!is_coupled()) return {J};
  return with(J, coupling_->shape(modal_.predicted_modal_coordinates(),
                                  modal_.predicted_modal_velocities()));
}

TurnInertia Frame::with(const Matrix3& J, const SpinCoupling::Shape& shape) const {
  return {J + modal_.axes() * shape.inertia * modal_.axes().transpose(), axial(shape.momentum)};
}

void Frame::take_drift(const SpinCoupling::Shape& shape) {
  modal_.flow_.turning().take_drift(
      is_coupled()
          ? Vector(shape.drift * in_component(q_.conjugate() * now_.angular_velocity(q_, L_)))
          : Vector(),
      modal_.n_dofs());
}

// Of the forces that turn with the body: of the spin, and of each load its vector, for the elastic
// modes, and its resultant, for the centre of mass. w: scene axes.
Vector Frame::factors(const Eigen::Quaterniond& q, const Vector3& w) const {
  const Index n_spin = feels_ ? 6 : 0;
  Vector g(n_spin + 6 * static_cast<Index>(loads_.size()));
  if (feels_) g.head(6) = centrifugal(modal_.axes().transpose() * (q.conjugate() * w));
  for (std::size_t l = 0; l < loads_.size(); ++l)
    g.segment<6>(n_spin + 6 * static_cast<Index>(l)) << loads_[l].vector(q), loads_[l].resultant(q);
  return g;
}

// A part of the step, from t = from to `to`: a moment changes the momentum at either end by its
// integral with the weight of a hat that is 1 there. `share` of the step has gone at this end.
void Frame::add_moments_of_loads(double from, double to, double share, bool at_end,
                                 const FreeTurn& turn, TurnAtEnd& end) const {
  const Vector eta = (1 - share) * eta_start_ + share * eta_end_;
  Vector3 sum = Vector3::Zero();
  for (const TurningLoad& load : loads_) {
    const double rising = load.history().rising_integral(from, to);
    sum += load.moment(end.q, eta) * (at_end ? rising : load.history().integral(from, to) - rising);
  }
  end.work += sum.dot(turn.angular_velocity(end.q, end.L + 0.5 * sum));
  end.L += sum;
}

// From here, with L, while the inertia changes from its present value to that of `last`.
Frame::TurnAtEnd Frame::turn_at_end(Vector3 L, const TurnInertia& last) const {
  double momentum = L.norm();
  for (const TurningLoad& load : loads_) momentum += load.largest_moment() * h_;
  const double most = loads_.empty() ? largest_turn : largest_turn_of_loads;
  const double angle = now_.rate_per_momentum * momentum * h_;
  if (!(angle < largest_turn_of_step))
    throw RunError(
        format_text("instance '%s' turns by %.3g rad in a step of %.3g s at t = %.4g s: "
                    "look at the loads and their units, or at the step",
                    modal_.name().c_str(), angle, h_, t_));
  const auto n = std::max<Index>(1, static_cast<Index>(std::ceil(angle / most)));
  const auto part = 1 / static_cast<double>(n);
  const auto at = [&](double share) { return FreeTurn::between(now_, last, share); };
  TurnAtEnd end{q_, L, 0, {}, Vector3::Zero()};
  for (Index i = 0; i <= n; ++i) {
    const double share = static_cast<double>(i) * part;
    if (i > 0) {
      const double before = share - part, from = t_ + before * h_, to = t_ + share * h_;
      if (!loads_.empty()) add_moments_of_loads(from, to, before, false, at(before), end);
      end.q = at(share - 0.5 * part).turned(end.q, end.L, h_ * part);
      if (!loads_.empty()) add_moments_of_loads(from, to, share, true, at(share), end);
    }
    end.w = at(share).angular_velocity(end.q, end.L);
    const Vector g = factors(end.q, end.w);
    if (i == 0) end.g.resize(g.size(), n + 1);
    end.g.col(i) = g;
  }
  return end;
}

void Frame::turn_modes(const TurnInertia& last) {
  TurnAtEnd to = turn_at_end(L_, last);
  if (is_coupled())
    modal_.flow_.turning().couple(in_component(q_.conjugate() * now_.angular_velocity(q_, L_)),
                                  in_component(to.q.conjugate() * to.w));
  if (!loads_.empty()) {
    const auto n = static_cast<Index>(loads_.size());
    Vector of_loads(3 * n), largest(3 * n);
    for (Index l = 0; l < n; ++l) {
      const Index row = (feels_ ? 6 : 0) + 6 * l;
      of_loads.segment<3>(3 * l) = to.g.col(to.g.cols() - 1).segment<3>(row);
      largest.segment<3>(3 * l).setConstant(loads_[l].largest_vector());
    }
    modal_.residual_.turn_loads(of_loads, largest);
  }
  modal_.flow_.turning().take_factors(std::move(to.g));
}

// s, of a step in which the ends may stand for all of it.
double Frame::longest_part() const {
  const Index highest = coupling_->first() + coupling_->size() - 1;
  const double w = now_.angular_velocity(q_, L_).norm();
  return std::min(largest_phase / modal_.form().omega[highest], largest_turn_of_coupling / w);
}

}  // namespace cbr
