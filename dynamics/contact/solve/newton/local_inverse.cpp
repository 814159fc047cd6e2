// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/newton/local_inverse.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/base/row_threads.hpp"
#include "common/files/state_archive.hpp"
#include "common/linalg/blas_threads.hpp"

namespace cbr {
namespace {

constexpr int most = LocalInverse::most_in_row;
// Smallest pivot of a block relative to its diagonal; below it a row uses its diagonal only.
constexpr double weakest_in_block = 1e-5;
// Points from which a second thread pays.
constexpr Index points_for_threads = 100;

using Unknown = ClosedUnknowns::Unknown;

// r_a^T W r_b for columns of R of two normal unknowns.
struct Normal {
  static double between(const ClosedResponse& closed, const Unknown& a, const Unknown& b) {
    return closed.entry(a.row, b.row);
  }
};

// The same for two tangential unknowns.
struct Tangential {
  static double between(const ClosedResponse& closed, const Unknown& a, const Unknown& b) {
    double sum = 0;
    for (Index i = 1; i < 3; ++i) {
      if (a.c[i] == 0) continue;
      for (Index j = 1; j < 3; ++j)
        if (b.c[j] != 0) sum += a.c[i] * b.c[j] * closed.entry(a.row + i, b.row + j);
    }
    return sum;
  }
};

// Unknowns of a point and of its nearest earlier points, its own last.
struct UnknownBlock {
  int n = 0;
  std::array<Index, most> unknown;

  void add(ClosedUnknowns::Range range) {
    for (Index u = range.first; u < range.last; ++u) unknown[n++] = u;
  }
};

// Cholesky factor of a block's matrix, R^T W R + diag(alpha).
template <typename Kind>
class BlockFactor {
 public:
  BlockFactor(const ClosedResponse& closed, const ClosedUnknowns& unknowns,
              const UnknownBlock& block) {
    for (int j = 0; j < block.n; ++j) {
      const Unknown& u = unknowns[block.unknown[j]];
      for (int k = 0; k <= j; ++k) L_[j][k] = Kind::between(closed, u, unknowns[block.unknown[k]]);
      L_[j][j] += u.alpha;
      for (int k = 0; k < j; ++k) {
        double sum = L_[j][k];
        for (int l = 0; l < k; ++l) sum -= L_[j][l] * L_[k][l];
        L_[j][k] = sum * inverse_[k];
      }
      own_[j] = L_[j][j];
      double pivot = own_[j];
      for (int l = 0; l < j; ++l) pivot -= L_[j][l] * L_[j][l];
      if (regular_ == j && pivot > weakest_in_block * own_[j]) ++regular_;
      inverse_[j] = 1 / std::sqrt(regular_ > j ? pivot : own_[j] > 0 ? own_[j] : 1.0);
    }
  }

  // Last row of the inverse factor of the first n; only its diagonal if they are not regular.
  int last_row(int n, float* y) const {
    if (regular_ < n) {
      y[0] = own_[n - 1] > 0 ? static_cast<float>(1 / std::sqrt(own_[n - 1])) : 1.0F;
      return 1;
    }
    std::array<double, most> x;
    for (int j = n - 1; j >= 0; --j) {
      double sum = j == n - 1 ? 1 : 0;
      for (int k = j + 1; k < n; ++k) sum -= L_[k][j] * x[k];
      x[j] = sum * inverse_[j];
      y[j] = static_cast<float>(x[j]);
    }
    return n;
  }

 private:
  std::array<std::array<double, most>, most> L_;
  std::array<double, most> inverse_, own_;  // of the diagonal of L; the matrix's diagonal
  int regular_ = 0;                         // number of leading regular rows
};

// Unknowns range(point) of a point and of its nearest earlier points with unknowns.
template <typename RangeOf>
UnknownBlock block_of(const std::vector<Index>& nearest, Index point, int wanted,
                      const RangeOf& range) {
  UnknownBlock block;
  for (const Index other : nearest) {
    if (wanted == 0) break;
    const ClosedUnknowns::Range of = range(other);
    if (other > point || of.first == of.last) continue;
    block.add(of);
    --wanted;
  }
  block.add(range(point));
  return block;
}

// Row of G for the block's unknown n - 1.
template <typename Kind>
void set_row(const BlockFactor<Kind>& factor, const UnknownBlock& block, int n,
             LocalInverse::Row& row) {
  row.n = factor.last_row(n, row.value.data());
  for (int k = 0; k < row.n; ++k) row.column[k] = static_cast<int>(block.unknown[n - row.n + k]);
}

void set_tangential_rows(const ClosedResponse& closed, const ClosedUnknowns& unknowns,
                         const std::vector<Index>& nearest, Index point,
                         std::vector<LocalInverse::Row>& rows) {
  const auto range = [&](Index of) { return unknowns.tangential(of); };
  const ClosedUnknowns::Range own = range(point);
  if (own.first == own.last) return;
  const UnknownBlock block = block_of(nearest, point, LocalInverse::tangential_neighbours, range);
  const BlockFactor<Tangential> factor(closed, unknowns, block);
  for (Index u = own.first; u < own.last; ++u)
    set_row(factor, block, block.n - static_cast<int>(own.last - 1 - u), rows[u]);
}

}  // namespace

Neighbours::Neighbours(const ContactProblem& problem) : nearest_(problem.laws.size()) {
  const Index n = problem.n_points();
  const auto count = static_cast<std::size_t>(std::min(most, n - 1));
  std::vector<double> root(static_cast<std::size_t>(n));
  for (Index i = 0; i < n; ++i) {
    const double w = problem.diagonal[problem.first[i]];
    root[i] = w > 0 ? 1 / std::sqrt(w) : 0;
  }
  const int used = n < points_for_threads ? 1 : n_threads();
  run_kept_threads(used, [&](int t) {
    std::vector<std::pair<double, Index>> order(root.size());  // -answer, point
    for (Index i = t; i < n; i += used) {
      const double* column = problem.W.dense.col(problem.first[i]).data();
      for (Index j = 0; j < n; ++j)
        order[j] = {j == i ? HUGE_VAL : -std::abs(column[problem.first[j]]) * root[j], j};
      const auto last = order.begin() + static_cast<std::ptrdiff_t>(count);
      std::nth_element(order.begin(), last, order.end());
      std::sort(order.begin(), last);
      for (auto of = order.begin(); of != last; ++of) nearest_[i].push_back(of->second);
    }
  });
}

void Neighbours::keep_state(StateArchive& archive) { archive(nearest_); }

void LocalInverse::build(const ClosedResponse& closed, const ClosedUnknowns& unknowns,
                         const Neighbours& neighbours) {
  rows_.resize(static_cast<std::size_t>(unknowns.size()));
  const std::vector<Index>& points = closed.points();
  of_normals_.resize(static_cast<std::size_t>(neighbours.n_points()));
  const int used = static_cast<Index>(points.size()) < points_for_threads ? 1 : n_threads();
  run_kept_threads(used, [&](int t) {
    for (std::size_t k = static_cast<std::size_t>(t); k < points.size();
         k += static_cast<std::size_t>(used)) {
      const Index point = points[k];
      const std::vector<Index>& nearest = neighbours.of(point);
      set_normal_row(closed, unknowns, nearest, point);
      set_tangential_rows(closed, unknowns, nearest, point, rows_);
    }
  });
}

void LocalInverse::set_normal_row(const ClosedResponse& closed, const ClosedUnknowns& unknowns,
                                  const std::vector<Index>& nearest, Index point) {
  const ClosedUnknowns::Range own = unknowns.normal(point);
  if (own.first == own.last) return;
  const UnknownBlock block =
      block_of(nearest, point, normal_neighbours, [&](Index of) { return unknowns.normal(of); });
  Row& row = rows_[own.first];
  Kept& kept = of_normals_[point];
  bool same = kept.n_points == block.n;
  for (int k = 0; same && k < block.n; ++k)
    same = kept.points[k] == static_cast<int>(unknowns.point(block.unknown[k]));
  if (!same) {
    set_row(BlockFactor<Normal>(closed, unknowns, block), block, block.n, row);
    kept.n_points = block.n;
    for (int k = 0; k < block.n; ++k)
      kept.points[k] = static_cast<int>(unknowns.point(block.unknown[k]));
    kept.n = row.n;
    std::copy_n(row.value.begin(), row.n, kept.value.begin());
    return;
  }
  row.n = kept.n;
  for (int k = 0; k < row.n; ++k) {
    row.value[k] = kept.value[k];
    row.column[k] = static_cast<int>(block.unknown[block.n - row.n + k]);
  }
}

void LocalInverse::apply(FloatVector& x) const {
  y_.resize(x.size());
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    float sum = 0;
    for (int k = 0; k < row.n; ++k) sum += row.value[k] * x[row.column[k]];
    y_[static_cast<Index>(i)] = sum;
  }
  x.setZero();
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    const float y = y_[static_cast<Index>(i)];
    for (int k = 0; k < row.n; ++k) x[row.column[k]] += row.value[k] * y;
  }
}

}  // namespace cbr
