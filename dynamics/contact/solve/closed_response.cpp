// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/closed_response.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "common/app/program.hpp"
#include "common/base/row_threads.hpp"
#include "common/linalg/clones.hpp"

namespace cbr {
namespace {

constexpr Index lanes = 16;
typedef float Lanes __attribute__((vector_size(lanes * sizeof(float))));

// From so many rows on (4 MB, a quarter of a millisecond) a second thread gains more than it costs.
constexpr Index threaded_rows = 1400;

Index padded(Index n) { return (n + lanes - 1) / lanes * lanes; }

// y += rows^T x_rows and dot = rows x for P rows of the same length, a multiple of the lanes.
template <int P>
__attribute__((always_inline)) inline void row_product(std::array<const float*, P> row, Index length, const float* x,
                                                       const float (&x_row)[P], float* y, float (&dot)[P]) {
  Lanes sums[P] = {};
  for (Index i = 0; i < length; i += lanes) {
    Lanes x_i, y_i;
    std::memcpy(&x_i, x + i, sizeof(Lanes));
    std::memcpy(&y_i, y + i, sizeof(Lanes));
    for (int k = 0; k < P; ++k) {
      Lanes r;
      std::memcpy(&r, row[k] + i, sizeof(Lanes));
      y_i += r * x_row[k];
      sums[k] += r * x_i;
    }
    std::memcpy(y + i, &y_i, sizeof(Lanes));
  }
  for (int k = 0; k < P; ++k) {
    dot[k] = 0;
    for (Index lane = 0; lane < lanes; ++lane) dot[k] += sums[k][lane];
  }
}

CBR_CLONES void three_rows(std::array<const float*, 3> row, Index length, const float* x, const float (&x_row)[3], float* y,
                           float (&dot)[3]) {
  row_product<3>(row, length, x, x_row, y, dot);
}
CBR_CLONES void one_row(std::array<const float*, 1> row, Index length, const float* x, const float (&x_row)[1], float* y,
                        float (&dot)[1]) {
  row_product<1>(row, length, x, x_row, y, dot);
}

// y += columns x, of three columns of a length that is a multiple of the lanes.
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
  points_.clear(), row_.clear(), start_.clear(), scale_.clear();
  lower_.clear(), diagonal_.clear(), normals_.clear();
  position_.assign(problem.laws.size(), -1);
  point_scale_.resize(problem.laws.size());
  for (Index i = 0; i < problem.n_points(); ++i) point_scale_[i] = problem.w[i] > 0 ? 1 / std::sqrt(problem.w[i]) : 0;
  normal_stride_ = padded(problem.n_points());
}

void ClosedResponse::add(const ContactProblem& problem, Index point) {
  const Index first = n_rows(), n = cbr::n_rows(problem.laws[point].law), length = padded(first + n - 1);
  const double s = point_scale_[point];
  position_[point] = first;
  points_.push_back(point);
  for (Index d = 0; d < n; ++d) {
    const Index row = problem.first[point] + d;
    const double* column = problem.W.dense.col(row).data();
    start_.push_back(static_cast<Index>(lower_.size()));
    lower_.resize(lower_.size() + static_cast<std::size_t>(length), 0.0F);
    float* to = lower_.data() + start_.back();
    for (Index j = 0; j < first; ++j) to[j] = static_cast<float>(s * scale_[j] * column[row_[j]]);
    for (Index j = 0; j < d; ++j) to[first + j] = static_cast<float>(s * s * column[problem.first[point] + j]);
    diagonal_.push_back(static_cast<float>(s * s * column[row]));
    normals_.resize(normals_.size() + static_cast<std::size_t>(normal_stride_), 0.0F);
    float* normal = normals_.data() + (first + d) * normal_stride_;
    for (Index i = 0; i < problem.n_points(); ++i) normal[i] = static_cast<float>(point_scale_[i] * s * column[problem.first[i]]);
  }
  for (Index d = 0; d < n; ++d) row_.push_back(problem.first[point] + d), scale_.push_back(s);
}

void ClosedResponse::keep(const std::vector<char>& kept) {
  const ClosedResponse old = std::move(*this);
  *this = ClosedResponse();
  normal_stride_ = old.normal_stride_, point_scale_ = old.point_scale_;
  position_.assign(old.position_.size(), -1);
  std::vector<Index> from;  // rows of the old one
  for (std::size_t k = 0; k < old.points_.size(); ++k) {
    const Index point = old.points_[k], begin = old.position_[point];
    const Index end = k + 1 < old.points_.size() ? old.position_[old.points_[k + 1]] : old.n_rows();
    if (!kept[point]) continue;
    const Index first = static_cast<Index>(from.size()), length = padded(first + (end - begin) - 1);
    position_[point] = first;
    points_.push_back(point);
    for (Index row = begin; row < end; ++row) {
      const float* source = old.lower_.data() + old.start_[row];
      start_.push_back(static_cast<Index>(lower_.size()));
      lower_.resize(lower_.size() + static_cast<std::size_t>(length), 0.0F);
      float* to = lower_.data() + start_.back();
      for (std::size_t j = 0; j < from.size(); ++j) to[j] = source[from[j]];
      const float* normal = old.normals_.data() + row * normal_stride_;
      normals_.insert(normals_.end(), normal, normal + normal_stride_);
      from.push_back(row);
    }
  }
  for (const Index row : from) {
    row_.push_back(old.row_[row]), scale_.push_back(old.scale_[row]), diagonal_.push_back(old.diagonal_[row]);
  }
}

// Half of the entries are in the rows above n / sqrt(2): where there are many a second thread takes those below.
void ClosedResponse::product(const FloatVector& x, FloatVector& y) const {
  const Index n = n_rows();
  x_.assign(static_cast<std::size_t>(padded(n)), 0.0F), y_.assign(x_.size(), 0.0F);
  for (Index i = 0; i < n; ++i) x_[i] = x[i];
  if (n < threaded_rows) {
    add_rows(0, points_.size(), y_.data());
    y = Eigen::Map<const FloatVector>(y_.data(), n);
    return;
  }
  below_.assign(x_.size(), 0.0F);
  const auto middle = static_cast<std::size_t>(
      std::partition_point(points_.begin(), points_.end(), [&](Index point) { return 2 * position_[point] * position_[point] < n * n; }) -
      points_.begin());
  const int used = std::min(2, n_threads());
  run_kept_threads(used, [&](int t) {
    if (t == 0) add_rows(0, middle, y_.data());
    if (t == used - 1) add_rows(middle, points_.size(), below_.data());
  });
  y = Eigen::Map<const FloatVector>(y_.data(), n) + Eigen::Map<const FloatVector>(below_.data(), n);
}

// Of some of points(), and what they stand for above the diagonal.
void ClosedResponse::add_rows(std::size_t begin, std::size_t past, float* y) const {
  const Index n = n_rows();
  for (std::size_t k = begin; k < past; ++k) {
    const Index first = position_[points_[k]], end = k + 1 < points_.size() ? position_[points_[k + 1]] : n;
    const Index length = padded(end - 1);
    const float* row = lower_.data() + start_[first];
    if (end - first == 3) {
      const float x_row[3] = {x_[first], x_[first + 1], x_[first + 2]};
      float dot[3];
      three_rows({row, row + length, row + 2 * length}, length, x_.data(), x_row, y, dot);
      for (int d = 0; d < 3; ++d) y[first + d] += dot[d] + diagonal_[first + d] * x_row[d];
    } else {
      const float x_row[1] = {x_[first]};
      float dot[1];
      one_row({row}, length, x_.data(), x_row, y, dot);
      y[first] += dot[0] + diagonal_[first] * x_row[0];
    }
  }
}

void ClosedResponse::normal_product(const FloatVector& x, FloatVector& y) const {
  const Index n = n_rows();
  y_.assign(static_cast<std::size_t>(normal_stride_), 0.0F);
  Index i = 0;
  for (; i + 3 <= n; i += 3) add_three(normals_.data() + i * normal_stride_, normal_stride_, x.data() + i, y_.data());
  for (; i < n; ++i)
    for (Index k = 0; k < normal_stride_; ++k) y_[k] += x[i] * normals_[i * normal_stride_ + k];
  y = Eigen::Map<const FloatVector>(y_.data(), static_cast<Index>(point_scale_.size()));
}

}  // namespace cbr
