// SPDX-License-Identifier: GPL-3.0-or-later
// W over the points that are closed or were lately: what a Krylov method reads in every product.
#pragma once

#include <vector>

#include "dynamics/contact/laws/contact_laws.hpp"

namespace cbr {

using FloatVector = Eigen::VectorXf;

// A part of a dense W in single precision, scaled to s W s with one s = 1 / sqrt(w) for each point:
// the rows and columns of `points`, one triangle packed row by row, and beside it the normal rows
// of all points. Points are added at the end. A point that rests keeps its rows for the time when
// it is added again, but no product reads them.
class ClosedResponse {
 public:
  // Of this problem, no point yet.
  void begin(const ContactProblem& problem);
  bool of(const ContactProblem& problem) const { return position_.size() == problem.laws.size(); }
  // w > 0 at these points, and none of them serves yet.
  void add(const ContactProblem& problem, const std::vector<Index>& points);
  // Points without an entry in `kept` rest from now on, or are dropped where many would rest. One
  // entry for each point of the problem.
  void keep(const std::vector<char>& kept);

  // in the order of their rows, with those that rest
  const std::vector<Index>& points() const { return points_; }
  Index n_rows() const { return static_cast<Index>(row_.size()); }
  // here; -1: not there, or resting
  Index first_row(Index point) const { return rests_[point] ? -1 : position_[point]; }
  // points() that do not rest
  Index n_serving() const { return n_serving_; }
  const std::vector<Index>& rows() const { return row_; }  // of W, for each row here
  double scale(Index row) const { return scale_[row]; }    // s, for each row here

  // y = s W s x   (n_rows()); x is 0 in the rows of points that rest, y is not set there
  void product(const FloatVector& x, FloatVector& y) const;
  // y = s W_n s x over the normal rows of all points (0 where w = 0). Their entries are taken from
  // the problem when they are first asked for.
  void normal_product(const ContactProblem& problem, const FloatVector& x, FloatVector& y) const;
  // Entry of s W s, i and j rows here.
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
  std::vector<char> rests_;  // for each point of the problem
  Index n_serving_ = 0;
  Index end_ = 0;  // of lower_
  std::vector<double> scale_, point_scale_;
  std::vector<float> lower_;     // left of the diagonal, rows padded with zeros
  std::vector<float> diagonal_;  // n_rows()
  // for the first rows here, as many as were asked for: the normal rows of all points, padded
  mutable std::vector<float> normals_;
  Index normal_stride_ = 0;
  mutable std::vector<float> x_, y_, below_;
};

}  // namespace cbr
