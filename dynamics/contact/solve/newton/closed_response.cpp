// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/newton/closed_response.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/base/row_threads.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/kernels/clones.hpp"

namespace cbr {
namespace {

constexpr Index lanes = 16;
typedef float Lanes __attribute__((vector_size(lanes * sizeof(float))));

// Rows (1.4 MB, a tenth of a millisecond) from which a second thread pays.
constexpr Index threaded_rows = 800;
constexpr std::size_t threaded_points = 16;
// Inactive rows are dropped above this fraction.
constexpr double most_resting = 0.4;

Index padded(Index n) { return (n + lanes - 1) / lanes * lanes; }

__attribute__((always_inline)) inline float sum(const Lanes& a) {
  float part[lanes];
  std::memcpy(part, &a, sizeof(Lanes));
  for (Index half = lanes / 2; half > 0; half /= 2)
    for (Index i = 0; i < half; ++i) part[i] += part[i + half];
  return part[0];
}

// y += rows^T x_rows and dot = rows x for P consecutive rows of one length, a multiple of the
// lanes.
template <int P>
__attribute__((always_inline)) inline void row_product(const float* rows, Index length,
                                                       const float* x, const float* x_rows,
                                                       float* y, float* dot) {
  Lanes sums[P] = {};
  for (Index i = 0; i < length; i += lanes) {
    Lanes x_i, y_i;
    std::memcpy(&x_i, x + i, sizeof(Lanes));
    std::memcpy(&y_i, y + i, sizeof(Lanes));
    for (int k = 0; k < P; ++k) {
      Lanes r;
      std::memcpy(&r, rows + k * length + i, sizeof(Lanes));
      y_i += r * x_rows[k];
      sums[k] += r * x_i;
    }
    std::memcpy(y + i, &y_i, sizeof(Lanes));
  }
  for (int k = 0; k < P; ++k) dot[k] = sum(sums[k]);
}

// The same for n rows, in blocks of eight, three and one.
CBR_CLONES void some_rows(const float* rows, Index n, Index length, const float* x,
                          const float* x_rows, float* y, float* dot) {
  Index i = 0;
  for (; i + 8 <= n; i += 8) row_product<8>(rows + i * length, length, x, x_rows + i, y, dot + i);
  for (; i + 3 <= n; i += 3) row_product<3>(rows + i * length, length, x, x_rows + i, y, dot + i);
  for (; i < n; ++i) row_product<1>(rows + i * length, length, x, x_rows + i, y, dot + i);
}

// y += columns x, for three columns whose length is a multiple of the lanes.
CBR_CLONES void add_three(const float* column, Index length, const float* x, float* y) {
  for (Index i = 0; i < length; i += lanes) {
    Lanes y_i;
    std::memcpy(&y_i, y + i, sizeof(Lanes));
    for (int k = 0; k < 3; ++k) {
      Lanes c;
      std::memcpy(&c, column + k * length + i, sizeof(Lanes));
      y_i += c * x[k];
    }
    std::memcpy(y + i, &y_i, sizeof(Lanes));
  }
}

}  // namespace

void ClosedResponse::begin(const ContactProblem& problem) {
  points_.clear();
  row_.clear();
  start_.clear();
  scale_.clear();
  lower_.clear();
  diagonal_.clear();
  normals_.clear();
  position_.assign(problem.laws.size(), -1);
  rests_.assign(problem.laws.size(), 0);
  n_serving_ = end_ = 0;
  point_scale_.resize(problem.laws.size());
  for (Index i = 0; i < problem.n_points(); ++i)
    point_scale_[i] = problem.w[i] > 0 ? 1 / std::sqrt(problem.w[i]) : 0;
  normal_stride_ = padded(problem.n_points());
}

void ClosedResponse::add(const ContactProblem& problem, const std::vector<Index>& points) {
  const std::size_t begin = points_.size();
  for (const Index point : points) {
    ++n_serving_;
    if (rests_[point]) {
      rests_[point] = 0;
    } else {
      append(problem, point);
    }
  }
  lower_.resize(static_cast<std::size_t>(end_), 0.0F);
  const std::size_t n_new = points_.size() - begin;
  const int used = n_new < threaded_points ? 1 : n_threads();
  run_kept_threads(used, [&](int t) {
    for (std::size_t k = begin + static_cast<std::size_t>(t); k < points_.size();
         k += static_cast<std::size_t>(used))
      fill(problem, k);
  });
}

// Appends a point, without entries.
void ClosedResponse::append(const ContactProblem& problem, Index point) {
  const Index first = n_rows(), n = cbr::n_rows(problem.laws[point].law),
              length = padded(first + n - 1);
  position_[point] = first;
  points_.push_back(point);
  for (Index d = 0; d < n; ++d) {
    start_.push_back(end_);
    end_ += length;
    const Index row = problem.first[point] + d;
    row_.push_back(row);
    scale_.push_back(point_scale_[point]);
    diagonal_.push_back(
        static_cast<float>(point_scale_[point] * point_scale_[point] * problem.W.dense(row, row)));
  }
}

// Fills the rows of points()[k].
void ClosedResponse::fill(const ContactProblem& problem, std::size_t k) {
  const Index first = position_[points_[k]],
              end = k + 1 < points_.size() ? position_[points_[k + 1]] : n_rows();
  for (Index i = first; i < end; ++i) {
    const double* column = problem.W.dense.col(row_[i]).data();
    float* to = lower_.data() + start_[i];
    for (Index j = 0; j < i; ++j)
      to[j] = static_cast<float>(scale_[i] * scale_[j] * column[row_[j]]);
  }
}

void ClosedResponse::fill_normals(const ContactProblem& problem) const {
  const auto known = static_cast<Index>(normals_.size()) / normal_stride_;
  normals_.resize(static_cast<std::size_t>(n_rows() * normal_stride_), 0.0F);
  const int used = n_rows() - known < threaded_rows ? 1 : n_threads();
  run_kept_threads(used, [&](int t) {
    for (Index i = known + t; i < n_rows(); i += used) {
      const double* column = problem.W.dense.col(row_[i]).data();
      float* normal = normals_.data() + i * normal_stride_;
      for (Index of = 0; of < problem.n_points(); ++of)
        normal[of] = static_cast<float>(point_scale_[of] * scale_[i] * column[problem.first[of]]);
    }
  });
}

void ClosedResponse::keep(const std::vector<char>& kept) {
  n_serving_ = 0;
  for (const Index point : points_) {
    rests_[point] = !kept[point] || rests_[point];
    n_serving_ += !rests_[point];
  }
  const auto n = static_cast<double>(points_.size());
  if (n - static_cast<double>(n_serving_) > most_resting * n) drop(std::vector<char>(rests_));
}

// In place: rows only move forward, so that unread entries are not overwritten.
void ClosedResponse::drop(const std::vector<char>& dropped) {
  std::vector<Index> from;  // old row indices
  std::size_t n_kept = 0;
  Index to_start = 0, known_kept = 0;
  const auto known = static_cast<Index>(normals_.size()) / normal_stride_;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const Index point = points_[k], begin = position_[point];
    const Index end = k + 1 < points_.size() ? position_[points_[k + 1]] : n_rows();
    position_[point] = -1;
    rests_[point] = 0;
    if (dropped[point]) continue;
    const auto first = static_cast<Index>(from.size()), length = padded(first + (end - begin) - 1);
    position_[point] = first;
    points_[n_kept++] = point;
    for (Index row = begin; row < end; ++row) {
      const float* source = lower_.data() + start_[row];
      float* to = lower_.data() + to_start;
      const auto n = static_cast<Index>(from.size());
      for (Index j = 0; j < n; ++j) to[j] = source[from[j]];
      std::fill(to + n, to + length, 0.0F);
      if (row < known) {
        const float* normal = normals_.data() + row * normal_stride_;
        std::copy(normal, normal + normal_stride_, normals_.data() + n * normal_stride_);
        known_kept = n + 1;
      }
      start_[n] = to_start;
      row_[n] = row_[row];
      scale_[n] = scale_[row];
      diagonal_[n] = diagonal_[row];
      to_start += length;
      from.push_back(row);
    }
  }
  points_.resize(n_kept);
  start_.resize(from.size());
  row_.resize(from.size());
  scale_.resize(from.size());
  diagonal_.resize(from.size());
  end_ = to_start;
  lower_.resize(static_cast<std::size_t>(end_));
  normals_.resize(static_cast<std::size_t>(known_kept * normal_stride_));
}

// Rows above n / sqrt(2) have half of the entries. If there are many, a second thread takes the
// others.
void ClosedResponse::product(const FloatVector& x, FloatVector& y) const {
  const Index n = n_rows();
  x_.assign(static_cast<std::size_t>(padded(n)), 0.0F);
  y_.assign(x_.size(), 0.0F);
  for (Index i = 0; i < n; ++i) x_[i] = x[i];
  if (n < threaded_rows) {
    add_rows(0, points_.size(), y_.data());
    y = Eigen::Map<const FloatVector>(y_.data(), n);
    return;
  }
  below_.assign(x_.size(), 0.0F);
  const auto middle = static_cast<std::size_t>(
      std::partition_point(
          points_.begin(), points_.end(),
          [&](Index point) { return 2 * position_[point] * position_[point] < n * n; }) -
      points_.begin());
  const int used = std::min(2, n_threads());
  run_kept_threads(used, [&](int t) {
    if (t == 0) add_rows(0, middle, y_.data());
    if (t == used - 1) add_rows(middle, points_.size(), below_.data());
  });
  y = Eigen::Map<const FloatVector>(y_.data(), n) + Eigen::Map<const FloatVector>(below_.data(), n);
}

// Products with some of points() and their transpose. Consecutive active points with rows of one
// length are processed together.
void ClosedResponse::add_rows(std::size_t begin, std::size_t past, float* y) const {
  const auto end_of = [&](std::size_t k) {
    return k + 1 < points_.size() ? position_[points_[k + 1]] : n_rows();
  };
  const auto length_of = [&](std::size_t k) { return padded(end_of(k) - 1); };
  constexpr Index most = lanes + 2;  // rows of one length, and the last point's beyond
  float dot[most];
  for (std::size_t k = begin; k < past;) {
    if (rests_[points_[k]]) {
      ++k;
      continue;
    }
    const Index first = position_[points_[k]], length = length_of(k);
    Index end = end_of(k);
    for (++k; k < past && !rests_[points_[k]] && length_of(k) == length; ++k) end = end_of(k);
    some_rows(lower_.data() + start_[first], end - first, length, x_.data(), x_.data() + first, y,
              dot);
    for (Index i = first; i < end; ++i) y[i] += dot[i - first] + diagonal_[i] * x_[i];
  }
}

void ClosedResponse::normal_product(const ContactProblem& problem, const FloatVector& x,
                                    FloatVector& y) const {
  fill_normals(problem);
  const Index n = n_rows();
  y_.assign(static_cast<std::size_t>(normal_stride_), 0.0F);
  const auto result = [&](const std::vector<float>& from) {
    return Eigen::Map<const FloatVector>(from.data(), static_cast<Index>(point_scale_.size()));
  };
  if (n < threaded_rows) {
    add_normals(0, n, x.data(), y_.data());
    y = result(y_);
    return;
  }
  below_.assign(y_.size(), 0.0F);
  const Index middle = n / 6 * 3;
  const int used = std::min(2, n_threads());
  run_kept_threads(used, [&](int t) {
    if (t == 0) add_normals(0, middle, x.data(), y_.data());
    if (t == used - 1) add_normals(middle, n, x.data(), below_.data());
  });
  y = result(y_) + result(below_);
}

// For local rows [begin, past).
void ClosedResponse::add_normals(Index begin, Index past, const float* x, float* y) const {
  Index i = begin;
  for (; i + 3 <= past; i += 3) {
    if (x[i] == 0 && x[i + 1] == 0 && x[i + 2] == 0) continue;
    add_three(normals_.data() + i * normal_stride_, normal_stride_, x + i, y);
  }
  for (; i < past; ++i)
    for (Index k = 0; k < normal_stride_; ++k) y[k] += x[i] * normals_[i * normal_stride_ + k];
}

}  // namespace cbr
