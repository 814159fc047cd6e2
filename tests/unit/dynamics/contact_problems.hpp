// SPDX-License-Identifier: GPL-3.0-or-later
// Problems of contact impulses for tests and benchmarks, and a judge of their solutions that shares no code with the solver.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "dynamics/contact/contact_solver.hpp"

namespace cbr::test {

inline Matrix random_matrix(std::mt19937& random, Index rows, Index columns) {
  std::normal_distribution<double> normal;
  return Matrix::NullaryExpr(rows, columns, [&] { return normal(random); });
}

inline GapResponse dense(Matrix W) {
  GapResponse response;
  response.dense = std::move(W);
  return response;
}

inline GapResponse sparse(SparseMatrix W) {
  GapResponse response;
  response.is_sparse = true;
  response.sparse = std::move(W);
  return response;
}

inline std::vector<PointLaw> all(Index n, ContactLaw law, double friction = 0) {
  return std::vector<PointLaw>(n, PointLaw{law, friction});
}

struct Verdict {
  double law = 0;  // largest violation, lengths as a share of |g|, impulses as a share of the largest
  double gap = 0;  // |gap - (g + W p)| as a share of |g|
  Index open = 0, stick = 0, slide = 0;
};

// Each law in its own words; a point slides when its tangential impulse is within 1e-9 of the cone's edge.
inline Verdict judge(const GapResponse& W, const std::vector<PointLaw>& laws, const Vector& g, const ContactSolution& s) {
  Verdict v;
  const double length = std::max(1e-300, g.lpNorm<Eigen::Infinity>()), force = std::max(1e-300, s.p.lpNorm<Eigen::Infinity>());
  const auto blame = [&](double violation) { v.law = std::max(v.law, std::isfinite(violation) ? violation : 1e300); };
  v.gap = (s.gap - g - apply(W, s.p)).lpNorm<Eigen::Infinity>() / length;
  Index row = 0;
  for (const PointLaw& law : laws) {
    const Vector3 p = law.law == ContactLaw::frictionless ? Vector3(s.p[row], 0, 0) : Vector3(s.p.segment<3>(row));
    const Vector3 gap = law.law == ContactLaw::frictionless ? Vector3(s.gap[row], 0, 0) : Vector3(s.gap.segment<3>(row));
    row += n_rows(law.law);
    if (law.law == ContactLaw::tied) {
      blame(gap.norm() / length);
      continue;
    }
    blame(-gap[0] / length), blame(-p[0] / force);
    blame(std::min(std::abs(gap[0]) / length, std::abs(p[0]) / force));
    if (law.law == ContactLaw::frictionless) continue;
    const double limit = law.friction * std::max(0.0, p[0]), pull = p.tail<2>().norm(), slip = gap.tail<2>().norm();
    blame((pull - limit) / force);
    if (p[0] <= 1e-9 * force) {
      ++v.open;
    } else if (pull < limit - 1e-9 * force) {
      ++v.stick;
      blame(slip / length);
    } else {
      ++v.slide;
      // Dissipates as much as it can: slip . p_t = -|slip| mu p_n
      blame((p.tail<2>().dot(gap.tail<2>()) + slip * limit) / (force * length));
    }
  }
  return v;
}

}  // namespace cbr::test
