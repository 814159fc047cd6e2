// SPDX-License-Identifier: GPL-3.0-or-later
// W over the points that are, or were recently, closed: the matrix of Krylov products.
#pragma once

#include <vector>

#include "dynamics/contact/laws/contact_laws.hpp"

namespace cbr {

using FloatVector = Eigen::VectorXf;

// A part of a dense W in single precision, scaled to s W s with s = 1 / sqrt(w) per point. It has
// the rows and columns of `points`, one triangle packed by rows, and the normal rows of all points.
// Points are appended. An inactive (resting) point keeps its rows for reuse, but products skip
// them.
class ClosedResponse {
 public:
  // For this problem, without points.
  void begin(const ContactProblem& problem);
  bool of(const ContactProblem& problem) const { return position_.size() == problem.laws.size(); }
  // Precondition: these points have w > 0 and are not active.
  void add(const ContactProblem& problem, const std::vector<Index>& points);
  // Makes points without an entry in `kept` inactive, or drops them if many would be inactive. One
  // entry per point of the problem.
  void keep(const std::vector<char>& kept);

  // in the order of their rows, including inactive ones
  const std::vector<Index>& points() const { return points_; }
  Index n_rows() const { return static_cast<Index>(row_.size()); }
  // local index; -1: absent or inactive
  Index first_row(Index point) const { return rests_[point] ? -1 : position_[point]; }
  // number of active points()
  Index n_serving() const { return n_serving_; }
  const std::vector<Index>& rows() const { return row_; }  // row of W per local row
  double scale(Index row) const { return scale_[row]; }    // s per local row

  // y = s W s x   (n_rows()). x must be 0 in rows of inactive points, where y is not set
  void product(const FloatVector& x, FloatVector& y) const;
  // y = s W_n s x over the normal rows of all points (0 where w = 0). Reads their entries from the
  // problem at the first call.
  void normal_product(const ContactProblem& problem, const FloatVector& x, FloatVector& y) const;
  // Entry of s W s for local rows i and j.
  float entry(Index i, Index j) const {
    return i == j ? diagonal_[i] : i > j ? lower_[start_[i] + j] : lower_[start_[j] + i];
  }
  // s of any point; 0 where w = 0
  double point_scale(Index point) const { return point_scale_[point]; }

 private:
  void add_rows(std::size_t begin, std::size_t past, float* y) const;
  void add_normals(Index begin, Index past, const float* x, float* y) const;
  void drop(const std::vector<char>& dropped);
  void append(const ContactProblem& problem, Index point);
  void fill(const ContactProblem& problem, std::size_t k);
  void fill_normals(const ContactProblem& problem) const;

  std::vector<Index> points_, position_, row_, start_;
  std::vector<char> rests_;  // inactive, per point of the problem
  Index n_serving_ = 0;
  Index end_ = 0;  // of lower_
  std::vector<double> scale_, point_scale_;
  std::vector<float> lower_;     // left of the diagonal, rows padded with zeros
  std::vector<float> diagonal_;  // n_rows()
  // normal rows of all points for the first local rows, as many as requested, padded
  mutable std::vector<float> normals_;
  Index normal_stride_ = 0;
  mutable std::vector<float> x_, y_, below_;
};

}  // namespace cbr
