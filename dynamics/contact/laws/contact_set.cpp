// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/laws/contact_set.hpp"

#include <algorithm>

namespace cbr {
namespace {

PointState state_of(const PointLaw& law, double w, const double* p, const double* gap,
                    double* slide) {
  if (law.law == ContactLaw::tied) return PointState::stick;
  const double tau_n = w * p[0] - gap[0];
  if (!(w > 0) || !(tau_n > 0)) return PointState::open;
  if (law.law == ContactLaw::frictionless) return PointState::normal;
  const double t1 = w * p[1] - gap[1], t2 = w * p[2] - gap[2], length = length_of(t1, t2),
               limit = law.friction * tau_n;
  if (length <= limit) return PointState::stick;
  slide[0] = t1 / length;
  slide[1] = t2 / length;
  // Beyond 1e12 w the tangential impulse across the slip is 0 to round-off.
  slide[2] = w * std::min(1e12, limit > 0 ? (length - limit) / limit : 1e12);
  return PointState::slide;
}

}  // namespace

bool ContactSet::slides_anywhere() const {
  return std::find(states.begin(), states.end(), PointState::slide) != states.end();
}

ContactSet contact_set(const ContactProblem& problem, const Vector& p, const Vector& gap) {
  ContactSet set;
  set.states.resize(problem.n_points());
  set.slides.setZero(problem.n_points(), 3);
  for (Index i = 0; i < problem.n_points(); ++i) {
    const Index row = problem.first[i];
    set.states[i] = state_of(problem.laws[i], problem.w[i], p.data() + row, gap.data() + row,
                             set.slides.row(i).data());
  }
  return set;
}

SetBases set_bases(const ContactProblem& problem, const ContactSet& set) {
  using Triplets = std::vector<Eigen::Triplet<double, Index>>;
  Triplets rows, columns;
  std::vector<double> diagonal;
  SetBases bases;
  Index n = 0, k = 0;  // unknowns, closed rows
  const auto unit = [&](Index closed_row) {
    rows.emplace_back(closed_row, n, 1.0);
    columns.emplace_back(closed_row, n, 1.0);
    diagonal.push_back(0);
    ++n;
  };
  for (Index i = 0; i < problem.n_points(); ++i) {
    const Index row = problem.first[i];
    if (set.states[i] == PointState::open) continue;
    if (set.states[i] != PointState::slide) {
      for (Index d = 0; d < (set.states[i] == PointState::stick ? 3 : 1); ++d)
        if (problem.diagonal[row + d] > 0) {
          bases.rows.push_back(row + d);
          unit(k++);
        }
      continue;
    }
    bases.symmetric = false;
    for (Index d = 0; d < 3; ++d) bases.rows.push_back(row + d);
    const double mu = problem.laws[i].friction, d1 = set.slides(i, 0), d2 = set.slides(i, 1);
    columns.emplace_back(k + 1, n, mu * d1);
    columns.emplace_back(k + 2, n, mu * d2);
    unit(k);
    for (Triplets* list : {&rows, &columns}) {
      list->emplace_back(k + 1, n, -d2);
      list->emplace_back(k + 2, n, d1);
    }
    diagonal.push_back(set.slides(i, 2));
    ++n;
    k += 3;
  }
  bases.R.resize(k, n);
  bases.C.resize(k, n);
  bases.R.setFromTriplets(rows.begin(), rows.end());
  bases.C.setFromTriplets(columns.begin(), columns.end());
  bases.alpha = Eigen::Map<const Vector>(diagonal.data(), n);
  return bases;
}

}  // namespace cbr
