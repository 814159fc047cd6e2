// SPDX-License-Identifier: GPL-3.0-or-later

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/error.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "reducer/domains/domains.hpp"
#include "tests/unit/reducer/cut_meshes.hpp"
#include "tests/unit/reducer/reduced.hpp"

namespace cbr::test::second_reduction_test {
namespace {

constexpr Index all_modes = 1000000;

ReductionOptions options_of(Index domains, Index modes, Index second) {
  ReductionOptions options;
  options.interface_sets = {"x_min"};
  options.modes = modes;
  options.domains = domains;
  if (domains > 1) options.second_modes = second;
  options.recovery = true;
  return options;
}

Superelement again(const Mesh& mesh, const ReductionOptions& options,
                   MassKind mass = MassKind::lumped, ReductionFigures* figures = nullptr) {
  Report report("test", Verbosity::quiet);
  const SuperelementGroup group =
      reduce_domains(mesh, properties(mesh, soft), mass, options, {}, report);
  EXPECT_FALSE(group.has_diagonal_form());
  return reduce_again(group, component_interface(mesh, options.interface_sets), options, {}, report,
                      figures);
}

Superelement once(const Mesh& mesh, Index modes, MassKind mass = MassKind::lumped) {
  Report report("test", Verbosity::quiet);
  ReductionOptions options = options_of(1, modes, 0);
  options.exact_modes = true;
  return reduce(mesh, properties(mesh, soft), mass, options, {}, report);
}

// Rows of a recovery by node id.
Matrix rows_in_order(const Superelement::Recovery& of, const std::vector<Index>& ids,
                     const Matrix& values) {
  Matrix rows(3 * std::ssize(ids), values.cols());
  for (Index i = 0; i < std::ssize(ids); ++i) {
    const Index at =
        std::find(of.node_ids.begin(), of.node_ids.end(), ids[i]) - of.node_ids.begin();
    rows.middleRows(3 * i, 3) = values.middleRows(3 * at, 3);
  }
  return rows;
}

class SecondReduction : public testing::TestWithParam<MassKind> {};
INSTANTIATE_TEST_SUITE_P(Masses, SecondReduction,
                         testing::Values(MassKind::lumped, MassKind::consistent));

TEST_P(SecondReduction, OfAllModesIsOneReductionOfTheWhole) {
  for (const Mesh& mesh : {box_mesh({{5, 4, 3}, {5, 4, 3}, {1, 2, 3}, 0.1}),
                           mixed_mesh({4, 3, 2}, 0.06), comb_mesh(3, 4)}) {
    const Superelement one = once(mesh, 12, GetParam());
    for (const Index n : {2, 5}) {
      const Superelement s = again(mesh, options_of(n, all_modes, 12), GetParam());
      check(s, "second");
      ASSERT_EQ(s.node_ids, one.node_ids);
      EXPECT_LT(relative(s.K_cc, one.K_cc), 1e-9);
      EXPECT_LT(relative(s.M_cc, one.M_cc), 1e-9);
      EXPECT_LT(
          (s.eigenvalues - one.eigenvalues).cwiseQuotient(one.eigenvalues).cwiseAbs().maxCoeff(),
          1e-9);
      EXPECT_LT(relative(s.M_kc.rowwise().norm(), one.M_kc.rowwise().norm()), 1e-7);
      // The interior moves as it does in one reduction: Psi is unique, Phi up to its sign.
      const auto &a = s.recovery.front(), &b = one.recovery.front();
      ASSERT_EQ(a.node_ids.size(), b.node_ids.size());
      EXPECT_LT(relative(rows_in_order(a, b.node_ids, a.Psi), b.Psi), 1e-9);
      const Matrix Phi = rows_in_order(a, b.node_ids, a.Phi);
      EXPECT_LT(relative(Phi.cwiseAbs(), b.Phi.cwiseAbs()), 1e-6);
      EXPECT_EQ(a.blocks.size(), b.blocks.size());
    }
  }
}

TEST_P(SecondReduction, StaticallyIsExactWhateverTheModes) {
  const Mesh mesh = box_mesh({{5, 4, 3}, {5, 4, 3}, {1, 2, 3}, 0.1});
  const Superelement one = once(mesh, 0, GetParam()),
                     s = again(mesh, options_of(4, 0, 0), GetParam());
  EXPECT_LT(relative(s.K_cc, one.K_cc), 1e-11);
  EXPECT_LT(relative(s.M_cc, one.M_cc), 1e-11);
  EXPECT_EQ(s.k(), 0);
}

TEST(SecondReduction, KeepsEverythingWithAllModesOfIts) {
  const Mesh mesh = box_mesh({{4, 3, 3}, {4, 3, 3}, {1, 2, 3}, 0.1});
  const FiniteElementModel model = assemble(mesh, properties(mesh, soft), MassKind::lumped);
  const Vector full = dense_eigenpairs(Matrix(model.K), Matrix(model.M), model.K.rows()).lambda;
  const Superelement s = again(mesh, options_of(3, all_modes, model.K.rows() - 3 * 16));
  ASSERT_EQ(s.n(), model.K.rows());
  const Vector lambda = dense_eigenpairs(reduced_stiffness(s), reduced_mass(s), s.n()).lambda;
  for (Index j = 6; j < lambda.size(); ++j) EXPECT_NEAR(lambda(j), full(j), 1e-9 * full(j)) << j;
}

TEST(SecondReduction, RecoversElementsOfTheWholeMesh) {
  const Mesh mesh = mixed_mesh({4, 3, 2}, 0.06);
  const Superelement s = again(mesh, options_of(4, 5, 3));
  const auto& recovery = s.recovery.front();
  std::vector<Index> ids = s.node_ids;
  ids.insert(ids.end(), recovery.node_ids.begin(), recovery.node_ids.end());
  for (const Block& block : recovery.blocks) {
    const Block& whole = mesh.blocks[find_block(mesh, block.name)];
    ASSERT_EQ(block.connectivity.rows(), whole.connectivity.rows());
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      const auto row =
          std::find(whole.element_ids.begin(), whole.element_ids.end(), block.element_ids[e]) -
          whole.element_ids.begin();
      for (Index a = 0; a < block.connectivity.cols(); ++a)
        EXPECT_EQ(ids[block.connectivity(e, a)], mesh.node_ids[whole.connectivity(row, a)]);
    }
  }
  // A rigid motion of the interface is one of all: Psi R_c = R_I.
  const Matrix R = reduced_rigid_modes(s, Vector3(1, 2, 3)).bottomRows(s.c());
  EXPECT_LT(relative(recovery.Psi * R, rigid_modes(recovery.coordinates, Vector3(1, 2, 3))), 1e-11);
}

TEST(SecondReduction, CutoffKeepsEveryModeBelowIt) {
  const Mesh mesh = box_mesh({{5, 4, 3}, {5, 4, 3}, {1, 2, 3}, 0.1});
  const Vector all = again(mesh, options_of(3, 10, 40)).eigenvalues;
  ReductionOptions options = options_of(3, 10, 0);
  options.second_modes.reset();
  options.second_cutoff_hz = std::sqrt(0.5 * (all(16) + all(17))) / (2 * M_PI);
  ReductionFigures figures;
  EXPECT_EQ(again(mesh, options, MassKind::lumped, &figures).k(), 17);
  EXPECT_NEAR(figures.highest_frequency, std::sqrt(all(16)) / (2 * M_PI),
              1e-9 * std::sqrt(all(16)));
}

TEST(SecondReduction, RefusesMoreModesThanThereAreAndWhatFloats) {
  const Mesh box = box_mesh({{4, 3, 2}, {4, 3, 2}, {0, 0, 0}, 0});
  EXPECT_THROW(again(box, options_of(2, 2, 1000)), InputError);
  // A part that is two domains holds itself together, but the component's interface does not hold
  // it.
  const Mesh two = both(box, box_mesh({{8, 4, 4}, {4, 3, 2}, {50, 0, 0}, 0}));
  EXPECT_NO_THROW({
    Report report("test", Verbosity::quiet);
    ReductionOptions options = options_of(4, 2, 2);
    const Superelement one =
        join(reduce_domains(two, properties(two, soft), MassKind::lumped, options, {}, report));
  });
  EXPECT_THROW(again(two, options_of(4, 2, 2)), InputError);
}

}  // namespace
}  // namespace cbr::test::second_reduction_test
