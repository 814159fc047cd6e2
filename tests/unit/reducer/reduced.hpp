// SPDX-License-Identifier: GPL-3.0-or-later
// Superelements of small blocks, and their comparison.
#pragma once

#include "common/app/report.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/superelement/superelement_check.hpp"
#include "reducer/bases/reduce.hpp"
#include "tests/unit/reducer/box_mesh.hpp"

namespace cbr::test {

inline const Material soft = {1000, 0.3, 2};

inline Mesh skewed(std::array<Index, 3> n = {5, 4, 3}) {
  return box_mesh({n, {5, 4, 3}, {1, 2, 3}, 0.08});
}

inline Superelement reduced(const Mesh& mesh, const ReductionOptions& options, MassKind mass,
                            const ReduceSettings& settings, ReductionFigures* figures = nullptr) {
  set_threads(1);  // small matrices, and other tests run beside this one
  Report report("test", Verbosity::quiet);
  Superelement s = reduce(mesh, properties(mesh, soft), mass, options, settings, report, figures);
  check(s, "test");
  return s;
}

inline Superelement reduced(const Mesh& mesh, const ReductionOptions& options,
                            MassKind mass = MassKind::lumped, ReductionFigures* figures = nullptr) {
  return reduced(mesh, options, mass, ReduceSettings(), figures);
}

// Largest difference, as a share of the largest entry.
inline double relative(const Matrix& A, const Matrix& B) {
  return (A - B).cwiseAbs().maxCoeff() / B.cwiseAbs().maxCoeff();
}

}  // namespace cbr::test
