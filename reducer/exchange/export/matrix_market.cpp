// SPDX-License-Identifier: GPL-3.0-or-later
// Boisvert, Pozo, Remington 1996, NISTIR 5935: the coordinate form of a symmetric matrix is its
// lower triangle.
#include <ostream>

#include "common/base/format_text.hpp"
#include "reducer/exchange/export/export_formats.hpp"

namespace cbr {
namespace {

void write(const Matrix& A, const char* what, std::ostream& out) {
  Index count = 0;
  for (Index j = 0; j < A.cols(); ++j) count += (A.col(j).tail(A.rows() - j).array() != 0).count();
  out << "%%MatrixMarket matrix coordinate real symmetric\n"
      << "% " << what << " of a superelement of cbr; rows: the table beside this file\n"
      << A.rows() << ' ' << A.cols() << ' ' << count << '\n';
  for (Index j = 0; j < A.cols(); ++j) {
    for (Index i = j; i < A.rows(); ++i) {
      if (A(i, j) != 0)
        out << i + 1 << ' ' << j + 1 << ' ' << format_text("%.17g", A(i, j)) << '\n';
    }
  }
}

}  // namespace

void write_matrix_market_K(const ReducedMatrices& reduced, std::ostream& out) {
  write(reduced.K, "stiffness", out);
}

void write_matrix_market_T(const ReducedMatrices& reduced, std::ostream& out) {
  const Matrix& T = reduced.T;
  out << "%%MatrixMarket matrix array real general\n"
      << "% T of a superelement of cbr, u = T q; rows: NAME.interface.csv\n"
      << T.rows() << ' ' << T.cols() << '\n';
  for (const double value : T.reshaped()) out << format_text("%.17g\n", value);
}

void write_matrix_market_M(const ReducedMatrices& reduced, std::ostream& out) {
  write(reduced.M, "mass", out);
}

}  // namespace cbr
