// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/components/half_modes.hpp"
#include "common/linalg/dense.hpp"
#include "common/scene/scene_words.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/error.hpp"
#include "dynamics/output/summary/half_check.hpp"
#include "reducer/bases/reduce.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::half_modes_test {
namespace {

Superelement reduced(Index modes, Basis basis, Pick pick = Pick::frequency,
                     MasslessModes massless = MasslessModes::free) {
  const Mesh mesh = test::block_mesh({{4, 3, 2}, Vector3(1, 0.8, 0.7)});
  ReductionOptions options;
  options.interface_sets = {"x_max"};
  options.modes = modes;
  options.basis = basis;
  options.pick = pick;
  options.massless_modes = massless;
  Report report("test", Verbosity::quiet);
  return reduce(mesh, {BlockProperties{{100, 0.3, 1}, Hex8Formulation::incompatible}},
                MassKind::lumped, options, {}, report);
}

double relative(const Matrix& a, const Matrix& b) { return (a - b).norm() / b.norm(); }

TEST(KeepHalf, IsTheReductionWithHalfOfTheModes) {
  Superelement s = reduced(11, Basis::craig_bampton);
  const Superelement half = reduced(5, Basis::craig_bampton);
  EXPECT_EQ(keep_half(s, HalfBy::frequency), 6);
  EXPECT_FALSE(s.has_diagonal_form());
  EXPECT_LT(relative(s.eigenvalues, half.eigenvalues), 1e-10);
  EXPECT_LT(relative(s.M_kc.cwiseAbs(), half.M_kc.cwiseAbs()), 1e-8);
  EXPECT_EQ(s.K_cc, half.K_cc);
  EXPECT_GT(half.spin_couplings.size(), 0);
  EXPECT_EQ(s.spin_couplings.size(), 0);  // of the stored form's modes
  ASSERT_EQ(s.spin_moments.rows(), s.n());
  EXPECT_LT(relative(s.spin_moments.cwiseAbs(), half.spin_moments.cwiseAbs()), 1e-8);
}

TEST(KeepHalf, IsRefusedBeforeTheRunWhereThereIsNone) {
  Superelement s = reduced(4, Basis::craig_bampton);
  EXPECT_NO_THROW(require_half(s));
  s.basis = "characteristic";
  EXPECT_THROW(require_half(s), InputError);
  EXPECT_THROW(keep_half(s, HalfBy::frequency), InputError);
}

TEST(HalfDifference, OfRoundOffShowsNothing) {
  Simulation none;
  HalfDifference d;
  const auto said = [&] {
    testing::internal::CaptureStderr();
    Report report("test", Verbosity::normal);
    say_half_difference(none, d, 20, 10, report);
    return testing::internal::GetCapturedStderr();
  };
  d.position = 1e-12;
  EXPECT_NE(said().find("take no part"), std::string::npos);
  d.energy = 1e-3;
  EXPECT_EQ(said().find("take no part"), std::string::npos);
  EXPECT_NE(said().find("no bound"), std::string::npos);
}

// At rest in the first run and moving in the second: no share of nothing.
TEST(HalfDifference, OfABodyThatOnlyTheSecondRunMoves) {
  RunResult whole;
  whole.time = {0, 1};
  auto& body = whole.bodies.emplace_back();
  body.center_of_mass.values = body.momentum.values = {0, 0, 0, 0, 0, 0};
  body.kinetic_energy = body.strain_energy = {0, 0};
  EXPECT_EQ(half_difference(whole, whole).largest(), 0);
  RunResult half = whole;
  half.bodies[0].center_of_mass.values[3] = 1e-3;
  EXPECT_TRUE(std::isinf(half_difference(whole, half).bodies[0].center));
  EXPECT_TRUE(std::isinf(half_difference(whole, half).largest()));
}

// As a run sees it: the answer of the interface to a load that swings, whatever the signs of the
// modes.
Matrix compliance(const Superelement& s, double omega2) {
  const Matrix& V = s.massless.V;
  return s.massless.F +
         V * (s.eigenvalues.array() - omega2).inverse().matrix().asDiagonal() * V.transpose();
}

void expect_same(const Superelement& s, const Superelement& half, double tolerance) {
  ASSERT_EQ(s.k(), half.k());
  const double highest = half.massless.omega_closed * half.massless.omega_closed;
  EXPECT_LT((s.eigenvalues - half.eigenvalues).norm(), tolerance * highest);
  EXPECT_LT(relative(s.massless.F, half.massless.F), tolerance);
  EXPECT_LT(relative(s.massless.V.cwiseAbs(), half.massless.V.cwiseAbs()), 10 * tolerance);
  EXPECT_NEAR(s.massless.omega_closed, half.massless.omega_closed,
              tolerance * half.massless.omega_closed);
  const double omega2 = -0.1 * highest;
  EXPECT_LT(relative(compliance(s, omega2), compliance(half, omega2)), tolerance);
}

// Halved more than once, from a file and back.
TEST(KeepHalf, OfBasisMasslessIsTheReductionWithHalfOfTheModes) {
  for (const MasslessModes kind :
       {MasslessModes::free, MasslessModes::tapered, MasslessModes::fixed}) {
    SCOPED_TRACE(word_of(massless_words, kind));
    for (const Index modes : {Index{13}, Index{24}, Index{40}}) {
      Superelement s = reduced(modes, Basis::massless, Pick::frequency, kind);
      const Index half = modes / 2, k = s.k();
      EXPECT_EQ(keep_half(s, HalfBy::frequency), modes - half);
      EXPECT_EQ(s.k(), k - modes + half);
      expect_same(s, reduced(half, Basis::massless, Pick::frequency, kind), 1e-8);
      if (modes < 40) continue;
      check(s, "half");
      keep_half(s, HalfBy::frequency);
      expect_same(s, reduced(10, Basis::massless, Pick::frequency, kind), 1e-8);
    }
  }
}

TEST(KeepHalf, OfFixedModesPickedByParticipationTakesTheBestOfThem) {
  Superelement s = reduced(30, Basis::massless, Pick::participation, MasslessModes::fixed);
  const Superelement craig_bampton = reduced(30, Basis::craig_bampton, Pick::participation);
  const std::vector<Index> best = modes_by_participation(craig_bampton.M_kc, 15);
  keep_half(s, HalfBy::participation);
  // With the interface held its squared frequencies are those of the modes that stay
  const Matrix held = s.massless.V.transpose() * Cholesky(s.massless.F).solve(s.massless.V) +
                      Matrix(s.eigenvalues.asDiagonal());
  const Vector found = symmetric_eigenvalues(held), expected = craig_bampton.eigenvalues(best);
  EXPECT_LT(relative(found, expected), 1e-8);
}

TEST(KeepHalf, OfBasisMasslessIsRefusedWhereItIsNotKnownOrNone) {
  for (const MasslessModes kind : {MasslessModes::tapered, MasslessModes::fixed}) {
    Superelement s = reduced(20, Basis::massless, Pick::frequency, kind);
    EXPECT_NO_THROW(require_half(s));
    s.massless.omega_fall = 0;
    s.massless.rigid_share.resize(0, 0);  // as in a file before 1.5
    EXPECT_THROW(require_half(s), InputError) << word_of(massless_words, kind);
    EXPECT_THROW(keep_half(s, HalfBy::frequency), InputError) << word_of(massless_words, kind);
  }
  EXPECT_THROW(require_half(reduced(11, Basis::massless, Pick::frequency, MasslessModes::fixed)),
               InputError);
  EXPECT_NO_THROW(
      require_half(reduced(0, Basis::massless, Pick::frequency, MasslessModes::tapered)));
}

TEST(KeepHalf, TakesWhatWasPickedByParticipation) {
  Superelement s = reduced(12, Basis::craig_bampton, Pick::participation);
  const std::vector<Index> best = modes_by_participation(s.M_kc, 6);
  const Vector expected = s.eigenvalues(best);
  keep_half(s, HalfBy::participation);
  EXPECT_EQ(s.eigenvalues, expected);
}

TEST(KeepHalf, OfDomainsIsThatOfEach) {
  test::SceneFolder folder;
  folder.add("part.exo", test::block_mesh({{6, 3, 2}, Vector3(1, 0.6, 0.8)}));
  const test::Ran ran = folder.prepare(
      "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
      "components:\n  part: {mesh: part.exo, material: m, reduction: {interface: [x_max], modes: "
      "7, domains: 2}}\n"
      "instances:\n  a: {component: part}\ntime: {end: 0.1, step: 1.0e-3}\n");
  Report report("test", Verbosity::quiet);
  BuildOptions options;
  options.half_modes = true;
  const BuiltScene half = build(ran.scene, report, options);
  EXPECT_EQ(ran.built.instances.at(0).n_modal, 14);
  EXPECT_EQ(half.instances.at(0).n_modal, 6);
  EXPECT_EQ(half.simulation.bodies.at(0)->n_dofs(),
            ran.built.simulation.bodies.at(0)->n_dofs() - 8);
}

}  // namespace
}  // namespace cbr::half_modes_test
