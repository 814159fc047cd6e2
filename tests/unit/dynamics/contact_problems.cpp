// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/dynamics/contact_problems.hpp"

#include <algorithm>
#include <cmath>

namespace cbr::test {

Matrix random_matrix(std::mt19937& random, Index rows, Index columns) {
  std::normal_distribution<double> normal;
  return Matrix::NullaryExpr(rows, columns, [&] { return normal(random); });
}

GapResponse dense(Matrix W) {
  GapResponse response;
  response.dense = std::move(W);
  return response;
}

GapResponse sparse(SparseMatrix W) {
  GapResponse response;
  response.is_sparse = true;
  response.sparse = std::move(W);
  return response;
}

std::vector<PointLaw> all(Index n, ContactLaw law, double friction) {
  return std::vector<PointLaw>(n, PointLaw{law, friction});
}

Verdict judge(const GapResponse& W, const std::vector<PointLaw>& laws, const Vector& g,
              const ContactSolution& s) {
  Verdict v;
  const double length = std::max(1e-300, g.lpNorm<Eigen::Infinity>()),
               force = std::max(1e-300, s.p.lpNorm<Eigen::Infinity>());
  const auto blame = [&](double violation) {
    v.law = std::max(v.law, std::isfinite(violation) ? violation : 1e300);
  };
  v.gap = (s.gap - g - apply(W, s.p)).lpNorm<Eigen::Infinity>() / length;
  Index row = 0;
  for (const PointLaw& law : laws) {
    const Vector3 p = law.law == ContactLaw::frictionless ? Vector3(s.p[row], 0, 0)
                                                          : Vector3(s.p.segment<3>(row));
    const Vector3 gap = law.law == ContactLaw::frictionless ? Vector3(s.gap[row], 0, 0)
                                                            : Vector3(s.gap.segment<3>(row));
    row += n_rows(law.law);
    if (law.law == ContactLaw::tied) {
      blame(gap.norm() / length);
      continue;
    }
    blame(-gap[0] / length);
    blame(-p[0] / force);
    blame(std::min(std::abs(gap[0]) / length, std::abs(p[0]) / force));
    if (law.law == ContactLaw::frictionless) continue;
    const double limit = law.friction * std::max(0.0, p[0]), pull = p.tail<2>().norm(),
                 slip = gap.tail<2>().norm();
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

Matrix3 mixing(double x, double y) {
  Matrix3 T = Matrix3::Identity();
  T(0, 1) = 0.2 * std::sin(0.3 * x);
  T(1, 2) = 0.2 * std::cos(0.4 * y);
  T(2, 0) = 0.15 * std::sin(0.2 * (x + y));
  return T;
}

Vector ball_gaps(Index n, ContactLaw law, double radius) {
  const Index rows = n_rows(law);
  Vector g(n * n * rows);
  const double half = 0.5 * static_cast<double>(n - 1), reach = radius * static_cast<double>(n);
  for (Index k = 0; k < n * n; ++k) {
    const double x = static_cast<double>(k % n) - half, y = static_cast<double>(k / n) - half;
    g[k * rows] = 1e-3 * ((x * x + y * y) / (reach * reach) - 1);
    if (rows == 3) {
      g[k * rows + 1] = 2e-4 - 3e-4 * y / reach;
      g[k * rows + 2] = 3e-4 * x / reach;
    }
  }
  return g;
}

Press dense_press(Index n, ContactLaw law, double friction, bool soft, double radius) {
  const Index rows = n_rows(law), m = n * n * rows;
  Press press{{}, all(n * n, law, friction), ball_gaps(n, law, radius)};
  press.W.dense.resize(m, m);
  for (Index j = 0; j < n * n; ++j) {
    const double xj = static_cast<double>(j % n), yj = static_cast<double>(j / n);
    for (Index i = 0; i < n * n; ++i) {
      const double xi = static_cast<double>(i % n), yi = static_cast<double>(i / n),
                   distance = std::hypot(xi - xj, yi - yj);
      const double k = soft ? 1 / std::sqrt(distance * distance + 0.3) : std::exp(-distance);
      press.W.dense.block(i * rows, j * rows, rows, rows) =
          k * (mixing(xi, yi) * mixing(xj, yj).transpose()).topLeftCorner(rows, rows);
    }
  }
  return press;
}

Press sparse_press(Index n, ContactLaw law, double friction, double radius) {
  const Index rows = n_rows(law), m = n * n * rows;
  Press press{{}, all(n * n, law, friction), ball_gaps(n, law, radius)};
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (Index k = 0; k < n * n; ++k) {
    const double x = static_cast<double>(k % n), y = static_cast<double>(k / n);
    const double u = 0.5 + 0.4 * std::sin(x), v = 0.5 + 0.4 * std::cos(y);
    const Matrix3 T = mixing(x, y);
    for (Index d = 0; d < rows; ++d)
      for (Index c = 0; c < 3; ++c) {
        entries.emplace_back(k * rows + d, 3 * k + c, T(d, c));
        for (Index corner = 0; corner < 4; ++corner) {
          const Index node = (k / n + corner / 2) * (n + 1) + k % n + corner % 2;
          const double N = (corner % 2 ? u : 1 - u) * (corner / 2 ? v : 1 - v);
          entries.emplace_back(k * rows + d, 3 * (n * n + node) + c, -1.5 * N * T(d, c));
        }
      }
  }
  SparseMatrix G(m, 3 * (n * n + (n + 1) * (n + 1)));
  G.setFromTriplets(entries.begin(), entries.end());
  press.W.is_sparse = true;
  press.W.sparse = G * SparseMatrix(G.transpose());
  return press;
}

}  // namespace cbr::test
