// SPDX-License-Identifier: GPL-3.0-or-later
// Our reduction against Sierra/SD's own of the same mesh. The files are not part of the project:
// skipped where they are missing.
#include "common/superelement/sierra_superelement.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>

#include "common/base/error.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "reducer/bases/reduce.hpp"
#include "tests/unit/reducer/reduced.hpp"

namespace cbr::test::sierra_test {
namespace {

std::filesystem::path shared_file(const std::string& name) {
  const char* shared = std::getenv("CBR_SHARED_DATA");
  const std::filesystem::path folder =
      shared != nullptr ? std::filesystem::path(shared)
                        : std::filesystem::path(CBR_SOURCE_DIR) / "../shared/data";
  return folder / "sierra" / name;
}

#define CBR_NEEDS(file)               \
  if (!std::filesystem::exists(file)) \
  GTEST_SKIP() << "no " << (file).string() << ": set CBR_SHARED_DATA"

// Position of each of our interface dofs among Sierra's rows.
std::vector<Index> rows_by_cbmap(const Superelement& ours, const SierraSuperelement& theirs) {
  std::map<std::pair<Index, int>, Index> position;
  for (std::size_t i = 0; i < theirs.dof_node.size(); ++i) {
    position[{theirs.dof_node[i], theirs.dof_component[i]}] =
        theirs.n_modes + static_cast<Index>(i);
  }
  std::vector<Index> rows;
  for (std::size_t i = 0; i < ours.dof_node.size(); ++i) {
    rows.push_back(position.at({ours.node_ids[ours.dof_node[i]], ours.dof_component[i]}));
  }
  return rows;
}

TEST(Sierra, OurSuperelementIsTheirs) {
  const auto mesh_file = shared_file("block_1-eig.exo"),
             their_file = shared_file("block_1-cbr.nc4");
  CBR_NEEDS(mesh_file);
  CBR_NEEDS(their_file);
  const Mesh mesh = read_mesh(mesh_file);
  const SierraSuperelement theirs = read_sierra_superelement(their_file);
  ASSERT_EQ(theirs.n_modes, 30);
  ReductionOptions options;
  options.interface_sets = {mesh.nodesets.at(0).name};
  options.modes = 30;
  options.exact_modes = true;
  Report report("test", Verbosity::quiet);
  const Superelement ours = reduce(mesh, properties(mesh, {70.33e9, 0.33, 2704.32669}),
                                   MassKind::consistent, options, {}, report);
  ASSERT_EQ(ours.n(), theirs.Kr.rows());

  const std::vector<Index> rows = rows_by_cbmap(ours, theirs);
  const Matrix K_cc = theirs.Kr(rows, rows), M_cc = theirs.Mr(rows, rows),
               M_kc = theirs.Mr(Eigen::seqN(0, 30), rows);
  const double error_K = relative(ours.K_cc, K_cc), error_M = relative(ours.M_cc, M_cc);
  const Vector theirs_kk = theirs.Kr.diagonal().head(30);
  const double error_kk =
      ((ours.eigenvalues - theirs_kk).array() / theirs_kk.array()).abs().maxCoeff();
  // M_kc up to the sign of a mode and the rotation of a pair: M_kc^T M_kc and M_kc^T Lambda^-1 M_kc
  // are free of both. The 30th mode is one of a pair whose other half is cut off, so its direction
  // in the pair is anyone's: only its norm counts, equal by symmetry.
  const auto gram = [](const Matrix& M, const Vector& weight) -> Matrix {
    return M.topRows(29).transpose() * weight.head(29).asDiagonal() * M.topRows(29);
  };
  const Vector ones = Vector::Ones(30), norms = M_kc.rowwise().norm();
  const double error_kc =
      std::max({relative(gram(ours.M_kc, ones), gram(M_kc, ones)),
                relative(gram(ours.M_kc, ours.eigenvalues.cwiseInverse()),
                         gram(M_kc, theirs_kk.cwiseInverse())),
                ((ours.M_kc.rowwise().norm() - norms).array() / norms.array()).abs().maxCoeff()});
  const Index n = ours.n();
  const Vector system = dense_eigenpairs(reduced_stiffness(ours), reduced_mass(ours), n).lambda;
  const Vector their_system = dense_eigenpairs(theirs.Kr, theirs.Mr, n).lambda;
  const double error_system =
      ((system - their_system).array() / their_system.array()).tail(n - 6).abs().maxCoeff();

  EXPECT_LT(error_K, 1e-9);
  EXPECT_LT(error_M, 1e-9);
  EXPECT_LT(error_kk, 1e-9);
  EXPECT_LT(error_kc, 1e-9);
  EXPECT_LT(error_system, 1e-9);
  std::cout << "relative differences: K_cc " << error_K << ", M_cc " << error_M << ", K_kk "
            << error_kk << ", M_kc " << error_kc << ", system eigenvalues " << error_system << "\n";
}

TEST(Sierra, ReadsTheOlderFile) {
  const auto file = shared_file("cbr2.ncf");
  CBR_NEEDS(file);
  const SierraSuperelement s = read_sierra_superelement(file);
  EXPECT_EQ(s.Kr.rows(), 22);
  EXPECT_EQ(s.n_modes, 10);
  ASSERT_EQ(s.dof_node.size(), 12u);
  EXPECT_EQ(s.dof_node.front(), 51);
  EXPECT_EQ(s.dof_node.back(), 101);
  EXPECT_EQ(s.dof_component.back(), 5);
  EXPECT_EQ(s.coordinates.rows(), 103);
  EXPECT_EQ(s.output_map.rows(), 6 * static_cast<Index>(s.output_nodes.size()));
  EXPECT_EQ(s.output_map.cols(), 22);
  EXPECT_LT(relative(s.Kr, s.Kr.transpose()), 1e-10);
  std::cout << "largest |K_kc| / |K_cc| "
            << s.Kr.topRightCorner(10, 12).cwiseAbs().maxCoeff() / s.Kr.cwiseAbs().maxCoeff()
            << ", |M_kk - I| "
            << (s.Mr.topLeftCorner(10, 10) - Matrix::Identity(10, 10)).cwiseAbs().maxCoeff()
            << "\n";
}

TEST(Sierra, RefusesWhatIsNoSuperelement) {
  EXPECT_THROW(read_sierra_superelement("no-such-file.nc"), InputError);
  const auto file = shared_file("block_1-eig.exo");
  CBR_NEEDS(file);
  EXPECT_THROW(read_sierra_superelement(file), InputError);
}

}  // namespace
}  // namespace cbr::test::sierra_test
