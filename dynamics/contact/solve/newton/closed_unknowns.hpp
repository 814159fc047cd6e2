// SPDX-License-Identifier: GPL-3.0-or-later
// Unknowns of a Newton step over the rows of a ClosedResponse.
#pragma once

#include <array>
#include <vector>

#include "dynamics/contact/laws/contact_set.hpp"
#include "dynamics/contact/solve/newton/closed_response.hpp"

namespace cbr {

// As SetBases (contact_set.hpp), with the rows and scale of a ClosedResponse: p = C x, equations
// R^T gap + alpha x = 0. Normal unknowns first, then tangential ones, each in the order of points.
class ClosedUnknowns {
 public:
  struct Unknown {
    Index row = 0;              // the point's first local row
    std::array<double, 3> c{};  // column of R in the point's rows
    // additional tangential entries of the column of C: mu d
    std::array<double, 2> friction{};
    double alpha = 0;  // scaled by s^2
  };
  // Precondition: `closed` has every point that is not open in `set`.
  void build(const ContactProblem& problem, const ContactSet& set, const ClosedResponse& closed);

  Index size() const { return static_cast<Index>(unknowns_.size()); }
  Index n_normals() const { return n_normals_; }
  const Unknown& operator[](Index i) const { return unknowns_[i]; }
  // Unknowns [first, last) of a point of the problem: normal, and tangential.
  struct Range {
    Index first = 0, last = 0;
  };
  Range normal(Index point) const { return normal_[point]; }
  Range tangential(Index point) const { return tangential_[point]; }
  Index point(Index unknown) const { return point_[unknown]; }

  // V: vectors in single or double precision.
  template <typename V>
  void expand(const V& x, V& p) const;  // p = C x
  template <typename V>
  void equations(const V& gap, const V& x, V& r) const;  // r = R^T gap + alpha x
  Vector of_impulses(const Vector& p) const;             // R^T p

 private:
  std::vector<Unknown> unknowns_;
  std::vector<Range> normal_, tangential_;
  std::vector<Index> point_;
  Index n_normals_ = 0;
};

}  // namespace cbr
