// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/enforce/rotating_slip.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/contact/laws/friction_law.hpp"

namespace cbr {
namespace {

// Means of a function's points, weighted by their shares.
struct Mean {
  Index unknown = 0;
  double impulse = 0;
  Vector3 at = Vector3::Zero(), slip = Vector3::Zero();
};

class RotatingSlip {
 public:
  RotatingSlip(const ContactUnknowns& unknowns, const ContactList& list,
               const std::vector<PointLaw>& laws, const std::vector<ContactBody>& bodies,
               const Vector& gap, const Vector& x)
      : unknowns_(unknowns),
        list_(list),
        bodies_(bodies),
        gap_(gap),
        x_(x),
        first_(first_rows(unknowns.laws)),
        factors_(unknowns.friction_factors) {
    for (std::size_t i = 0; i < laws.size(); ++i)
      point_of_row_.insert(point_of_row_.end(), n_rows(laws[i].law), i);
  }

  Vector find() {
    for (Index begin = 0, end = 0; begin < unknowns_.size(); begin = end) {
      means_.clear();
      for (end = begin; end < unknowns_.size() && search(end) == search(begin); ++end) add(end);
      fit();
    }
    return std::move(factors_);
  }

 private:
  Index search(Index u) const { return unknowns_.keys[u].search; }

  // Calls action(share, point, row of the point).
  template <typename Action>
  void each_point(Index u, const Action& action) const {
    for (SparseMatrix::InnerIterator it(unknowns_.A, first_[u]); it; ++it)
      action(it.value(), list_.points[point_of_row_[it.row()]], it.row());
  }

  void add(Index u) {
    const double impulse = x_[first_[u]];
    if (unknowns_.column[first_[u]] < 0 || unknowns_.laws[u].law != ContactLaw::coulomb ||
        !(impulse > 0))
      return;
    Mean& mean = means_.emplace_back(Mean{u, impulse});
    each_point(u, [&](double share, const ContactPoint& point, Index row) {
      mean.at += share * slave_position(list_, point, bodies_);
      mean.slip += share * (point.frame.bottomRows<2>().transpose() * gap_.segment<2>(row + 1));
    });
  }

  void fit() {
    // A share of slips that are uniform: their directions within a function hardly differ
    constexpr double uniform = 1e-4;
    // A share of the face: slips of bodies at rest are round-off
    constexpr double at_rest = 1e-12;
    double impulse = 0, moment = 0, inertia = 0, square = 0;
    Vector3 at = Vector3::Zero(), slip = Vector3::Zero();
    for (const Mean& mean : means_) {
      impulse += mean.impulse;
      at += mean.impulse * mean.at;
      slip += mean.impulse * mean.slip;
    }
    if (means_.empty()) return;
    const SparseMatrix::InnerIterator first(unknowns_.A, first_[means_.front().unknown]);
    const Vector3 normal = list_.points[point_of_row_[first.row()]].normal();
    at /= impulse;
    slip /= impulse;
    for (const Mean& mean : means_) {
      const Vector3 arm = normal.cross(mean.at - at);
      moment += mean.impulse * arm.dot(mean.slip - slip);
      inertia += mean.impulse * arm.squaredNorm();
      square += mean.impulse * mean.slip.squaredNorm();
    }
    const bool rotates =
        moment * moment > uniform * inertia * square && square > at_rest * at_rest * inertia;
    const Vector3 omega = rotates ? Vector3(moment / inertia * normal) : Vector3::Zero();
    for (const Mean& mean : means_) {
      const Index u = mean.unknown;
      if (!slides(x_.segment<3>(first_[u]), unknowns_.laws[u].friction)) continue;
      factors_[u] = rotates ? factor(mean, omega) : 1;
    }
  }

  double factor(const Mean& mean, const Vector3& omega) const {
    // Beyond it the centre of rotation is near, and the resultant of the directions counts
    constexpr double most = 1.1;
    double length = 0;
    Vector3 directions = Vector3::Zero();
    each_point(mean.unknown, [&](double share, const ContactPoint& point, Index) {
      const Vector3 arm = slave_position(list_, point, bodies_) - mean.at,
                    slip = mean.slip + omega.cross(arm);
      length += share * slip.norm();
      directions += share * slip.normalized();
    });
    const double same_power = length / mean.slip.norm();
    return same_power <= most ? same_power : std::max(directions.norm(), 2 * most - same_power);
  }

  const ContactUnknowns& unknowns_;
  const ContactList& list_;
  const std::vector<ContactBody>& bodies_;
  const Vector &gap_, &x_;
  const std::vector<Index> first_;
  std::vector<std::size_t> point_of_row_;
  Vector factors_;
  std::vector<Mean> means_;
};

}  // namespace

Vector friction_factors(const ContactUnknowns& unknowns, const ContactList& list,
                        const std::vector<PointLaw>& laws, const std::vector<ContactBody>& bodies,
                        const Vector& gap, const Vector& x) {
  return RotatingSlip(unknowns, list, laws, bodies, gap, x).find();
}

}  // namespace cbr
