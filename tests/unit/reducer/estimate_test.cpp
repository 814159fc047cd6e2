// SPDX-License-Identifier: GPL-3.0-or-later
// What --estimate says against what a reduction has, and the paper's formulas against cubes that
// are cut into cubes.
#include "reducer/estimate/estimate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "common/base/error.hpp"
#include "reducer/bases/reduce.hpp"
#include "reducer/command.hpp"
#include "reducer/domains/decomposition.hpp"
#include "reducer/domains/domains.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/reducer/box_mesh.hpp"

namespace cbr::test::estimate_test {
namespace {

constexpr Index no_limit = 1000000;

Mesh cube(Index N) { return box_mesh({{N, N, N}, {0.0191, 0.0191, 0.0191}, {0, 0, 0}, 0}); }

ReductionOptions options_of(const std::string& interface, Index modes, Index domains = 1) {
  ReductionOptions options;
  options.interface_sets = {interface};
  options.modes = modes;
  options.domains = domains;
  return options;
}

// Domain of each hex of a cube that is cut into `parts` parts along each edge, in the order of
// box_mesh.
std::vector<Index> cut_into_cubes(Index N, Index parts) {
  std::vector<Index> domain;
  const Index edge = N / parts;
  for (Index k = 0; k < N; ++k)
    for (Index j = 0; j < N; ++j)
      for (Index i = 0; i < N; ++i)
        domain.push_back(i / edge + parts * (j / edge + parts * (k / edge)));
  return domain;
}

std::vector<Index> one_domain(const Mesh& mesh) {
  return std::vector<Index>(mesh.blocks[0].element_ids.size(), 0);
}

Estimate estimate_cube(Index N, Index parts, const std::string& interface = "surface",
                       Index modes = 0) {
  const Mesh mesh = cube(N);
  return estimate(mesh, properties(mesh, paper_steel()),
                  options_of(interface, modes, parts * parts * parts), cut_into_cubes(N, parts),
                  no_limit);
}

TEST(Estimate, FormulasAreExactForACubeCutIntoCubes) {
  for (const auto& [N, parts] :
       std::vector<std::pair<Index, Index>>{{4, 1}, {8, 1}, {8, 2}, {12, 2}, {12, 3}, {12, 4}}) {
    const Estimate e = estimate_cube(N, parts);
    const CubeFormulas f = equivalent_cube(e.n_nodes, static_cast<Index>(e.domains.size()));
    EXPECT_NEAR(f.n_elements_per_line, static_cast<double>(N), 1e-9);
    EXPECT_NEAR(f.n_cuts + 1, static_cast<double>(parts), 1e-12);
    EXPECT_NEAR(f.n_nodes(), static_cast<double>(e.n_nodes), 1e-6);
    EXPECT_NEAR(f.n_domains(), static_cast<double>(e.domains.size()), 1e-9);
    EXPECT_TRUE(e.is_cube_of_hexes);
    for (const auto& d : e.domains) {
      // Eq 8
      EXPECT_NEAR(std::pow(f.n_nodes_per_domain_line(), 3), static_cast<double>(d.n_nodes), 1e-6);
      // Eq 9
      EXPECT_NEAR(f.interface_dofs_of_domain(), d.c(), 1e-6);
      // Eq 16
      EXPECT_LE(d.mesh_nonzeros, f.mesh_nonzeros_of_domain());
    }
    EXPECT_LE(e.mesh_nonzeros, f.mesh_nonzeros_cube() * (1 + 1e-12));  // Eq 15
    EXPECT_LE(e.mesh_nonzeros, f.mesh_nonzeros_in_all());              // Eq 17
    // A structured cube's node has (3 N + 1)^3 neighbours in all.
    EXPECT_EQ(e.mesh_nonzeros, 9 * std::pow(3 * static_cast<double>(N) + 1, 3));
  }
}

// Eqs 10-14 hold for large domains, with an error of the order of one over the nodes per edge; with
// 36 in the place of 324 they do not.
TEST(Estimate, ApproximateFormulasApproachTheCount) {
  for (const Index parts : {1, 2}) {
    double last = 1;
    for (const Index N : {8, 16, 32}) {
      const Estimate e = estimate_cube(N, parts);
      const CubeFormulas f = equivalent_cube(e.n_nodes, static_cast<Index>(e.domains.size()));
      const double c = e.domains[0].c(), n = f.n_nodes_per_domain_line();
      double squares = 0;
      for (const auto& d : e.domains) squares += d.c() * d.c();
      EXPECT_NEAR(f.interface_dofs_of_domain_by_N() / c, 1, 1 / (n * n) + 0.01);
      EXPECT_NEAR(f.interface_dofs_of_domain_by_dofs() / c, 1, 3 / n);
      EXPECT_NEAR(f.interface_dofs_in_all() / e.total(&DomainEstimate::c), 1, 3 / n);
      const double error = f.nonzeros_of_domain(324) / (c * c) - 1;
      EXPECT_NEAR(error, 0, 7 / n);
      EXPECT_LT(error, 0.7 * last);
      EXPECT_NEAR(f.nonzeros_in_all(324) / squares, 1 + error, 1e-9);
      EXPECT_LT(f.nonzeros_in_all(36), 0.2 * squares);
      last = error;
    }
  }
}

TEST(Estimate, IsWhatAReductionHas) {
  for (const Index N : {8, 12}) {
    for (const char* interface : {"x_max", "surface"}) {
      const Mesh mesh = cube(N);
      const auto material = properties(mesh, paper_steel());
      const Estimate e =
          estimate(mesh, material, options_of(interface, 6), one_domain(mesh), no_limit);
      Report report("test", Verbosity::quiet);
      ReductionFigures figures;
      ReduceSettings settings;
      settings.diagonal_limit = 500;
      const Superelement s = reduce(mesh, material, MassKind::lumped, options_of(interface, 6),
                                    settings, report, &figures);
      ASSERT_EQ(e.domains.size(), 1u);
      const DomainEstimate& d = e.domains[0];
      EXPECT_EQ(d.c(), static_cast<double>(s.c()));
      EXPECT_EQ(d.k(), static_cast<double>(s.k()));
      EXPECT_EQ(d.n_interior(), static_cast<double>(figures.n_interior));
      EXPECT_EQ(d.block_nonzeros(), static_cast<double>(s.K_cc.size() + s.M_cc.size() +
                                                        s.M_kc.size() + s.eigenvalues.size()));
      if (s.has_diagonal_form()) {
        EXPECT_EQ(e.diagonal_nonzeros(), static_cast<double>(s.V.size() + s.omega.size()));
      }
      // Ordered by nodes instead of dofs: not the same factor to the last entry.
      EXPECT_NEAR(d.factor_nonzeros / figures.factor_nonzeros, 1, 0.1);
      EXPECT_NEAR(d.factor_flops / figures.factor_flops, 1, 0.2);
    }
  }
}

// By sparse solves alone and by dense matrices; what the scene says of contact decides on the
// statics.
TEST(Estimate, OfFewShapesIsWhatTheReductionHas) {
  for (const Index N : {6, 23}) {
    for (const bool friction : {false, true}) {
      const Mesh mesh = box_mesh({{N, N, 3}, {0.1, 0.1, 0.03}, {0, 0, 0}, 0});
      const auto material = properties(mesh, paper_steel());
      ReductionOptions options = options_of("z_min", 8);
      options.basis = Basis::characteristic;
      options.characteristic.is_default_modes = true;
      options.characteristic.needs.touching["z_min"] = friction;
      const Estimate e = estimate(mesh, material, options, one_domain(mesh), no_limit);
      ASSERT_TRUE(e.few_shapes);
      EXPECT_EQ(e.few_shapes->is_sparse, N == 23);
      Report report("test", Verbosity::quiet);
      const Superelement s =
          reduce(mesh, material, MassKind::lumped, options, ReduceSettings(), report);
      EXPECT_EQ(e.n_final(), static_cast<double>(s.eigenvalues.size()));
      EXPECT_EQ(e.few_shapes->n_static, s.characteristic.statics.size());
      EXPECT_EQ(e.shapes_nonzeros(),
                static_cast<double>(s.eigenvalues.size() + s.characteristic.V.size() +
                                    s.characteristic.statics.F.size()));
    }
  }
}

// The same cut: decompose() is deterministic.
TEST(Estimate, IsWhatADecompositionHas) {
  for (const Index N : {8, 12}) {
    for (const Index D : {2, 4, 8}) {
      for (const char* interface : {"x_max", "surface"}) {
        const Mesh mesh = cube(N);
        const auto material = properties(mesh, paper_steel());
        const ReductionOptions options = options_of(interface, 10, D);
        ReduceSettings settings;
        settings.diagonal_limit = 500;
        const Estimate e =
            estimate(mesh, material, options, decompose(mesh, D).domain, settings.diagonal_limit);
        Report report("test", Verbosity::quiet);
        GroupFigures figures;
        const SuperelementGroup group =
            reduce_domains(mesh, material, MassKind::lumped, options, settings, report, &figures);
        ASSERT_EQ(e.domains.size(), group.domains.size());
        Index nonzeros = group.V.size() + group.omega.size();
        for (std::size_t i = 0; i < group.domains.size(); ++i) {
          const Superelement& s = group.domains[i];
          const DomainEstimate& d = e.domains[i];
          EXPECT_EQ(d.n_elements, figures.domains[i].n_elements);
          EXPECT_EQ(d.c(), static_cast<double>(s.c()));
          EXPECT_EQ(d.k(), static_cast<double>(s.k()));
          EXPECT_EQ(d.n_interior_dofs, figures.domains[i].reduction.n_interior);
          EXPECT_NEAR(d.factor_nonzeros, figures.domains[i].reduction.factor_nonzeros,
                      0.15 * d.factor_nonzeros + 1);
          nonzeros += s.K_cc.size() + s.M_cc.size() + s.M_kc.size() + s.eigenvalues.size();
        }
        EXPECT_EQ(e.n_joined_nodes, static_cast<Index>(join_nodes(group).node_ids.size()));
        EXPECT_EQ(e.has_diagonal_form, group.has_diagonal_form());
        EXPECT_EQ(e.file_nonzeros(), static_cast<double>(nonzeros));
      }
    }
  }
}

TEST(Estimate, MeshNonZerosAreThoseOfK) {
  const Mesh mesh = box_mesh({{5, 3, 2}, {5, 3, 2}, {0, 0, 0}, 0.05});
  const auto material = properties(mesh, paper_steel());
  const Estimate e = estimate(mesh, material, options_of("x_max", 3), one_domain(mesh), no_limit);
  EXPECT_EQ(e.mesh_nonzeros,
            static_cast<double>(assemble(mesh, material, MassKind::lumped).K.nonZeros()));
  EXPECT_FALSE(e.is_cube_of_hexes);
}

// The joined interface of two cubes in a row, dense by domain: (A, S), (S, B) with S between; A and
// B meet only through S.
TEST(Estimate, JoinedFactorOfTwoDomains) {
  const Mesh mesh = box_mesh({{4, 2, 2}, {4, 2, 2}, {0, 0, 0}, 0});
  std::vector<Index> domain;
  for (Index e = 0; e < 16; ++e) domain.push_back(e % 4 / 2);
  const Estimate e = estimate(mesh, properties(mesh, paper_steel()), options_of("surface", 0, 2),
                              domain, no_limit);
  // 5 x 3 x 3 nodes, all but two of the three on the axis inside; the plane between has 9, each
  // side 2 x 9 - 1.
  EXPECT_EQ(e.n_joined_nodes, 43);
  EXPECT_EQ(e.n_interface_nodes, 42);
  const double S = 27, A = 51;
  EXPECT_EQ(e.joined_factor_nonzeros, 2 * (A * (A + 1) / 2 + A * S) + S * (S + 1) / 2);
}

TEST(Estimate, CutoffCountsByWeylsLaw) {
  const Mesh mesh = cube(8);
  ReductionOptions options = options_of("x_max", 0);
  options.modes.reset();
  Report report("test", Verbosity::quiet);
  ReductionOptions counted = options_of("x_max", 100);
  const Superelement s =
      reduce(mesh, properties(mesh, paper_steel()), MassKind::lumped, counted, {}, report);
  options.cutoff_hz = std::sqrt(s.eigenvalues(99)) / (2 * M_PI);
  const Estimate e =
      estimate(mesh, properties(mesh, paper_steel()), options, one_domain(mesh), no_limit);
  EXPECT_TRUE(e.modes_are_estimated);
  // Leading order: surfaces add to it, and a mesh's high modes are its own.
  EXPECT_GT(e.domains[0].n_modes, 30);
  EXPECT_LT(e.domains[0].n_modes, 170);
}

TEST(Estimate, ToleranceTakesWhatBlocksNeed) {
  const Mesh mesh = cube(8);
  ReductionOptions options = options_of("x_max", 0);
  options.modes.reset();
  Index before = 0;
  for (const double tolerance : {0.1, 1e-2, 1e-3}) {
    options.tolerance = tolerance;
    const Estimate e =
        estimate(mesh, properties(mesh, paper_steel()), options, one_domain(mesh), no_limit);
    EXPECT_TRUE(e.modes_are_of_tolerance);
    EXPECT_GT(e.domains[0].n_modes, before);
    EXPECT_GE(e.domains[0].n_candidates, e.domains[0].n_modes);
    before = e.domains[0].n_modes;
  }
}

TEST(Estimate, WrongInputIsNamed) {
  const Mesh mesh = cube(2);
  const auto message = [&](const ReductionOptions& options) -> std::string {
    return test::refusal_of([&] {
      estimate(mesh, properties(mesh, paper_steel()), options, one_domain(mesh), no_limit);
    });
  };
  EXPECT_SAYS(message(options_of("nowhere", 3)), "nowhere");
  EXPECT_SAYS(message(options_of("corner", 3)), "not three that are off one line");
  EXPECT_SAYS(message(options_of("x_max", 55)), "only 54 dofs");
  EXPECT_EQ(message(options_of("x_max", 54)), "no error");
}

TEST(Estimate, TableHasEveryEquation) {
  const Estimate e = estimate_cube(4, 2, "surface", 5);
  std::ostringstream out;
  print_estimate(e, 4e9, "# title", out);
  for (int equation = 5; equation <= 17; ++equation) {
    EXPECT_SAYS(out.str(), "\n| " + std::to_string(equation) + " ") << equation;
  }
  EXPECT_EQ(out.str().find("nan"), std::string::npos);
  EXPECT_EQ(out.str().find("inf "), std::string::npos);
}

}  // namespace
}  // namespace cbr::test::estimate_test
