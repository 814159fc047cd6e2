// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/newton/closed_unknowns.hpp"

namespace cbr {

void ClosedUnknowns::build(const ContactProblem& problem, const ContactSet& set,
                           const ClosedResponse& closed) {
  unknowns_.clear();
  point_.clear();
  normal_.assign(problem.laws.size(), {});
  tangential_.assign(problem.laws.size(), {});
  const auto add = [&](Index point, const Unknown& unknown) {
    unknowns_.push_back(unknown);
    point_.push_back(point);
  };
  for (Index i = 0; i < problem.n_points(); ++i) {
    normal_[i].first = normal_[i].last = size();
    if (set.states[i] == PointState::open || !(problem.diagonal[problem.first[i]] > 0)) continue;
    Unknown unknown{closed.first_row(i), {1, 0, 0}};
    if (set.states[i] == PointState::slide)
      for (int d = 0; d < 2; ++d) unknown.friction[d] = problem.laws[i].friction * set.slides(i, d);
    add(i, unknown);
    normal_[i].last = size();
  }
  n_normals_ = size();
  for (Index i = 0; i < problem.n_points(); ++i) {
    tangential_[i].first = tangential_[i].last = size();
    const PointState state = set.states[i];
    if (state == PointState::open || state == PointState::normal) continue;
    const Index row = closed.first_row(i);
    if (state == PointState::slide) {
      add(i,
          {row, {0, -set.slides(i, 1), set.slides(i, 0)}, {0, 0}, set.slides(i, 2) / problem.w[i]});
    } else {
      if (problem.diagonal[problem.first[i] + 1] > 0) add(i, {row, {0, 1, 0}});
      if (problem.diagonal[problem.first[i] + 2] > 0) add(i, {row, {0, 0, 1}});
    }
    tangential_[i].last = size();
  }
}

template <typename V>
void ClosedUnknowns::expand(const V& x, V& p) const {
  using Scalar = typename V::Scalar;
  p.setZero();
  for (Index i = 0; i < n_normals_; ++i) {
    const Unknown& u = unknowns_[i];
    p[u.row] = x[i];
    if (u.friction[0] == 0 && u.friction[1] == 0) continue;
    p[u.row + 1] = static_cast<Scalar>(u.friction[0]) * x[i];
    p[u.row + 2] = static_cast<Scalar>(u.friction[1]) * x[i];
  }
  for (Index i = n_normals_; i < size(); ++i) {
    const Unknown& u = unknowns_[i];
    p[u.row + 1] += static_cast<Scalar>(u.c[1]) * x[i];
    p[u.row + 2] += static_cast<Scalar>(u.c[2]) * x[i];
  }
}

template <typename V>
void ClosedUnknowns::equations(const V& gap, const V& x, V& r) const {
  using Scalar = typename V::Scalar;
  r.resize(size());
  for (Index i = 0; i < n_normals_; ++i) r[i] = gap[unknowns_[i].row];
  for (Index i = n_normals_; i < size(); ++i) {
    const Unknown& u = unknowns_[i];
    const auto c1 = static_cast<Scalar>(u.c[1]), c2 = static_cast<Scalar>(u.c[2]),
               alpha = static_cast<Scalar>(u.alpha);
    r[i] = c1 * gap[u.row + 1] + c2 * gap[u.row + 2] + alpha * x[i];
  }
}

template void ClosedUnknowns::expand(const Vector&, Vector&) const;
template void ClosedUnknowns::expand(const FloatVector&, FloatVector&) const;
template void ClosedUnknowns::equations(const Vector&, const Vector&, Vector&) const;
template void ClosedUnknowns::equations(const FloatVector&, const FloatVector&, FloatVector&) const;

Vector ClosedUnknowns::of_impulses(const Vector& p) const {
  Vector x(size());
  for (Index i = 0; i < size(); ++i) {
    const Unknown& u = unknowns_[i];
    x[i] = i < n_normals_ ? p[u.row] : u.c[1] * p[u.row + 1] + u.c[2] * p[u.row + 2];
  }
  return x;
}

}  // namespace cbr
