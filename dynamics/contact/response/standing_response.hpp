// SPDX-License-Identifier: GPL-3.0-or-later
// W of few unknowns while the rows of their points stand, in the coordinates of the bodies.
#pragma once

#include <memory>
#include <vector>

#include "dynamics/contact/nodes/dense_panels.hpp"
#include "dynamics/contact/response/response.hpp"

namespace cbr {

// p = A x with A = N Y + E Z: shares of combinations N of points, and what rows of single points
// (E: unit columns of `rows`) differ by from these.
struct Combinations {
  std::vector<Index> rows;
  SparseMatrix Y, Z;
};

// The static answer of thin responses, as far as it is known: still of each body (s).
struct StaticAnswers {
  std::vector<Index> body;
  std::vector<Vector> still;
};

// G S G^T with S = V^T C V + B F B^T / h of each body: G V^T is formed once for the points. The
// responses of V and F are formed once for each combination, when an unknown first has a share of
// it, and for each unknown.
class StandingResponse {
 public:
  bool empty() const { return parts_.empty(); }
  void clear() { *this = {}; }
  // Of bodies none of which answers node by node. N: rows of the points x k. in_body_axes: as in
  // rows_of_bodies().
  void start(const ContactList& list, const std::vector<PointLaw>& laws,
             const std::vector<ContactBody>& bodies, const SparseMatrix& N,
             bool in_body_axes = false);
  // The columns of A are those of the unknowns; column u was column from[u] of the last call, or is
  // another one: -1.
  void take(Combinations of, const std::vector<Index>& from);
  // A^T G S G^T A, of the A of take(); `old`: what it was before, of which the entries of columns
  // that stayed are taken; null where none have.
  Matrix form(const std::vector<Index>& from, const Matrix* old) const;
  // What static rows answer A x.
  StaticAnswers statics(const Vector& x) const;

 private:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  struct Part {
    Index body = 0;
    std::shared_ptr<const ThinResponse> thin;  // or null: S itself is in the place of F
    StaticCompliance F;                        // s x s
    double share = 1;                          // of F: 1 / h
    RowMajorSparse H;                          // rows of the points x s: G B
    Matrix X;                                  // r x rows of the points: V G^T
    Matrix X_of_N, F_of_N;                     // X N and F H^T N / h
    Matrix X_of_A, F_of_A;                     // X A, and of the mixed columns of A F H^T A / h
    // Entries of H in the single rows
    std::vector<Index> single_row, single_column;
    std::vector<double> single_value;
    std::vector<RowWeight> pressed(const std::vector<RowWeight>& rows) const;
    // Columns `fresh` of X_of_N and F_of_N.
    void combine(const SparseMatrix& N, const std::vector<Index>& fresh);
    void fill_statics(const Combinations& of, Index u, double* f) const;
    void add_to_rows(const StandingResponse& all, Index u, double* rows) const;
    void take(const Combinations& of, const std::vector<Index>& from,
              const std::vector<Index>& mixed, const std::vector<Index>& mixed_from);
  };
  void form_combinations(const Combinations& of);
  Matrix columns(const std::vector<Index>& some) const;
  // A column of one row of a point has the statics of that row: they are not kept.
  bool is_mixed(Index u) const { return mixed_[u] >= 0; }

  std::vector<Part> parts_;
  SparseMatrix N_;
  std::vector<char> has_;    // of each combination: whether its responses are formed; else 0
  Matrix of_N_, rows_of_N_;  // N^T and all rows (transposed) of the statics of N: k x k, k x rows
  Combinations of_;
  std::vector<Index> mixed_;  // of each unknown: its column of F_of_A, or -1
};

}  // namespace cbr
