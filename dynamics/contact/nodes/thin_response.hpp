// SPDX-License-Identifier: GPL-3.0-or-later
// The answer of a body with few modes, and with directions of nodes that forces move at once.
#pragma once

#include <memory>
#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// Directions of a body's contact nodes that answer forces without inertia: u = B F B^T f, column i
// of B (3 m x s) with direction i on the three dofs of node i.
struct StaticRows {
  std::vector<Index> node;          // s, ascending
  Points direction;                 // s x 3, unit, in the axes of the response
  std::vector<Index> first;         // m + 1: the rows of node i are first[i] .. first[i + 1] - 1
  std::shared_ptr<const Matrix> F;  // s x s, length / force, symmetric, positive semi-definite

  Index size() const { return static_cast<Index>(node.size()); }
  // B^T f of vectors f, which have one more 3-vector for each node (3 m x q)   (s x q)
  void gather(const Matrix& f, Matrix& rows) const;
  // u += B w   (3 m x q)
  void add_spread(const Matrix& w, Matrix& u) const;
};

// Of nodes none of which forces move at once.
std::shared_ptr<const StaticRows> no_static_rows(std::size_t n_nodes);

// S = A^T C A + B F B^T / h   (3 m x 3 m), which is never formed. Instances of a component share
// it.
struct ThinResponse {
  std::shared_ptr<const Matrix> A;  // r x 3 m, the shapes that the nodes move in; r may be 0
  Matrix C;                         // r x r, symmetric: how the shapes answer forces on them
  std::shared_ptr<const StaticRows> rows;
  double h = 0;
  bool C_is_diagonal = false;  // of shapes that are modes: products with C cost nothing then

  Index n_dofs() const { return A->cols(); }
  // C x of columns x   (r x q)
  Matrix weighed(const Matrix& x) const;
};

// What respond() works in, kept by the caller.
struct ThinWork {
  Vector kick;
  Matrix pressed;
  std::vector<Index> columns;
};

// move = S p and its static share: still = F B^T p / h   (s x q), for q = 1 or 2 columns of
// impulses p (3 m x q). `still_is_known`:
// it is given. Returns the bytes of the response that were read.
double respond(const ThinResponse& S, const Matrix& p, Matrix& move, Matrix& still, ThinWork& work,
               bool still_is_known = false);
// still (s x q) = F rows, of rows (s x q); the same choice of what is read.
double press(const StaticRows& rows, const Matrix& pressed, Matrix& still,
             std::vector<Index>& columns);

}  // namespace cbr
