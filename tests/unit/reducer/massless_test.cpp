// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/bases/massless.hpp"
#include "common/linalg/dense.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/linalg/eigen/eigenpairs.hpp"
#include "reducer/bases/reduce.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/reducer/reduced.hpp"

namespace cbr::test::massless_test {
namespace {

ReductionOptions massless(std::vector<std::string> sets, Index modes,
                          MasslessModes of = MasslessModes::free) {
  ReductionOptions options;
  options.basis = Basis::massless;
  options.massless_modes = of;
  options.interface_sets = std::move(sets);
  options.modes = modes;
  return options;
}

// The full model's modes, all of them, and their rows on the superelement's interface.
struct Full {
  Vector lambda;
  Matrix V;
};
Full full_model(const Mesh& mesh, MassKind mass, const Superelement& s) {
  const FiniteElementModel model = assemble(mesh, properties(mesh, soft), mass);
  Eigenpairs pairs = dense_eigenpairs(Matrix(model.K), Matrix(model.M), model.K.rows());
  Full full{pairs.lambda, Matrix(s.c(), model.K.rows())};
  for (Index i = 0; i < s.c(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    const auto node =
        std::find(mesh.node_ids.begin(), mesh.node_ids.end(), s.node_ids[s.dof_node[at]]);
    const Index row = model.row[node - mesh.node_ids.begin()];
    full.V.row(i) = pairs.Phi.row(3 * row + s.dof_component[at]);
  }
  return full;
}

// Compliance at omega^2 of what moves elastically.
Matrix compliance(const Matrix& V_e, const Vector& lambda_e, double omega2) {
  return V_e * (lambda_e.array() - omega2).inverse().matrix().asDiagonal() * V_e.transpose();
}
Matrix compliance(const Superelement& s, double omega2, Index n_rigid = 6) {
  const Index e = s.k() - n_rigid;
  return s.massless.F + compliance(s.massless.V.rightCols(e), s.eigenvalues.tail(e), omega2);
}

class MasslessReduction : public testing::TestWithParam<MassKind> {};
INSTANTIATE_TEST_SUITE_P(Massless, MasslessReduction,
                         testing::Values(MassKind::lumped, MassKind::consistent));

TEST_P(MasslessReduction, FreeModesAndStaticsAreThoseOfTheFullModel) {
  const Mesh mesh = skewed({4, 3, 2});
  for (const char* set : {"x_max", "surface"}) {
    for (const Index modes : {Index{0}, Index{12}}) {
      const Superelement s = reduced(mesh, massless({set}, modes), GetParam());
      const Full full = full_model(mesh, GetParam(), s);
      const Index e = full.lambda.size() - 6;
      EXPECT_EQ(s.k(), modes + 6);
      EXPECT_LT((s.eigenvalues - full.lambda.head(s.k())).cwiseAbs().maxCoeff(),
                1e-10 * full.lambda[s.k() - 1] + 1e-9);
      const Matrix expected = compliance(full.V.rightCols(e), full.lambda.tail(e), 0);
      EXPECT_LT(relative(compliance(s, 0), expected), 1e-9) << set << " " << modes;
      // Rigid part: impulses move the body as they should
      const Matrix rigid = s.massless.V.leftCols(6) * s.massless.V.leftCols(6).transpose();
      EXPECT_LT(relative(rigid, full.V.leftCols(6) * full.V.leftCols(6).transpose()), 1e-8);
    }
  }
}

// Falling off takes nothing from statics and rigid motion, and less from a mode the lower it is.
TEST_P(MasslessReduction, TaperedModesKeepStatics) {
  const Mesh mesh = skewed({4, 3, 2});
  for (const Index modes : {Index{0}, Index{12}}) {
    const Superelement s =
        reduced(mesh, massless({"x_max"}, modes, MasslessModes::tapered), GetParam());
    const Full full = full_model(mesh, GetParam(), s);
    const Index e = full.lambda.size() - 6;
    EXPECT_LT(relative(compliance(s, 0), compliance(full.V.rightCols(e), full.lambda.tail(e), 0)),
              1e-9);
    EXPECT_LT((s.eigenvalues - full.lambda.head(s.k())).cwiseAbs().maxCoeff(),
              1e-10 * full.lambda[s.k() - 1] + 1e-9);
    EXPECT_LT(relative(s.massless.V.leftCols(6) * s.massless.V.leftCols(6).transpose(),
                       full.V.leftCols(6) * full.V.leftCols(6).transpose()),
              1e-8);
    for (Index j = 6; j < s.k(); ++j) {
      const double share = 1 - std::pow(std::sqrt(full.lambda[j]) / s.massless.omega_fall, 3);
      EXPECT_NEAR(s.massless.V.col(j).squaredNorm() / full.V.col(j).squaredNorm(), share, 1e-5)
          << j;
    }
  }
}

// The fall ends at the next axial mode of a bar whose end is kept, whatever bending and torsion
// lies between, at the latest at the last mode that is looked at.
TEST(MasslessFall, EndsAtTheNextModeThatAPressureMoves) {
  const Mesh mesh = box_mesh({{12, 1, 1}, {12, 1.3, 1}});
  int beyond_others = 0;
  for (Index modes = 8; modes <= 20; modes += 2) {
    const Superelement s = reduced(mesh, massless({"x_max"}, modes, MasslessModes::tapered));
    const Full full = full_model(mesh, MassKind::lumped, s);
    const auto is_axial = [&](Index j) {
      double sum = 0;
      for (Index i = 0; i < s.c(); ++i)
        if (s.dof_component[i] == 0) sum += full.V(i, j);
      return std::abs(sum) > 1e-3 * full.V.col(j).norm();
    };
    Index end = s.k();
    while (end < s.k() + (modes + 1) / 2 - 1 && !is_axial(end)) ++end;
    EXPECT_NEAR(s.massless.omega_fall, std::sqrt(full.lambda[end]), 1e-7 * s.massless.omega_fall)
        << modes;
    beyond_others += end > s.k();
  }
  EXPECT_GT(beyond_others, 1);
}

// What the modes leave is of second order in frequency.
TEST_P(MasslessReduction, ComplianceInMotionConverges) {
  const Mesh mesh = skewed({4, 3, 2});
  const Superelement s = reduced(mesh, massless({"x_max"}, 10), GetParam());
  const Full full = full_model(mesh, GetParam(), s);
  const Index e = full.lambda.size() - 6;
  const auto error = [&](double omega2) {
    return relative(compliance(s, omega2),
                    compliance(full.V.rightCols(e), full.lambda.tail(e), omega2));
  };
  const double omega2 = 0.1 * full.lambda[6];
  EXPECT_NEAR(error(omega2) / error(omega2 / 4), 4, 0.4);
  EXPECT_LT(error(omega2), 3e-2);
}

// With the interface held: the largest eigenvalue of diag(lambda) + V^T F^-1 V.
Vector held(const Superelement& s) {
  Matrix K = s.massless.V.transpose() * Cholesky(s.massless.F).solve(s.massless.V);
  K.diagonal() += s.eigenvalues;
  return dense_eigenpairs(K, K.rows()).lambda;
}

TEST(Massless, TheHighestHeldFrequencyOfFreeModesIsTold) {
  const Superelement s = reduced(skewed(), massless({"x_max"}, 15));
  const Vector lambda = held(s);
  EXPECT_NEAR(s.massless.omega_closed, std::sqrt(lambda(lambda.size() - 1)),
              1e-6 * s.massless.omega_closed);
  EXPECT_GT(s.massless.omega_closed, 1.05 * std::sqrt(s.eigenvalues.maxCoeff()));
}

TEST(Massless, ACutoffKeepsAllBelow) {
  ReductionOptions options = massless({"x_max"}, 0);
  const Superelement all = reduced(skewed(), massless({"x_max"}, 30));
  options.modes.reset();
  options.cutoff_hz =
      std::sqrt(0.5 * (all.eigenvalues(20) + all.eigenvalues(21))) / (2 * 3.141592653589793);
  const Superelement s = reduced(skewed(), options);
  EXPECT_EQ(s.k(), 21);
  EXPECT_LT(relative(s.eigenvalues, all.eigenvalues.head(21)), 1e-10);
}

TEST(Massless, TwoPartsHaveTwelveRigidMotions) {
  Mesh mesh = skewed({3, 2, 2});
  const Mesh other = box_mesh({{2, 2, 2}, {5, 4, 3}, {11, 2, 3}, 0.05});
  const Index n = mesh.coordinates.rows();
  mesh.coordinates.conservativeResize(n + other.coordinates.rows(), 3);
  mesh.coordinates.bottomRows(other.coordinates.rows()) = other.coordinates;
  for (const Index id : other.node_ids) mesh.node_ids.push_back(id + 100000);
  const Index e = mesh.blocks[0].connectivity.rows();
  IndexTable joined(e + other.blocks[0].connectivity.rows(), 8);
  joined << mesh.blocks[0].connectivity, (other.blocks[0].connectivity.array() + n).matrix();
  mesh.blocks[0].connectivity = joined;
  for (Index i = e; i < joined.rows(); ++i) mesh.blocks[0].element_ids.push_back(i + 1);
  for (std::size_t set = 0; set < mesh.sidesets.size(); ++set)
    for (auto side : other.sidesets[set].sides) {
      side.element += e;
      mesh.sidesets[set].sides.push_back(side);
    }
  const Superelement s = reduced(mesh, massless({"x_max"}, 30));
  EXPECT_EQ((s.eigenvalues.array() == 0).count(), 12);
  const Full full = full_model(mesh, MassKind::lumped, s);
  const Index elastic = full.lambda.size() - 12;
  EXPECT_LT(relative(compliance(s, 0, 12),
                     compliance(full.V.rightCols(elastic), full.lambda.tail(elastic), 0)),
            1e-9);
}

TEST(Massless, RefusesWhatLeavesNothing) {
  const Mesh mesh = skewed({2, 2, 2});  // 81 dofs, 27 of them on x_max
  const auto message_of = [&](Index k) {
    return refusal_of([&] { reduced(mesh, massless({"x_max"}, k)); });
  };
  const auto cure_of = [&](Index k) {
    const std::string text = message_of(k);
    return text.substr(std::min(text.find("no compliance of its own"), text.size()));
  };
  // What the message names works; one mode more is refused, with the same cure
  const std::string cure = cure_of(75);
  const auto at = cure.find("contact: take modes: ");
  ASSERT_TRUE(at < cure.size() && cure.find("or massless_modes: tapered") < cure.size()) << cure;
  EXPECT_EQ(cure_of(60), cure);
  const Index most = std::stol(cure.substr(at + 21));
  EXPECT_EQ(reduced(mesh, massless({"x_max"}, most)).k(), most + 6);
  EXPECT_EQ(cure_of(most + 1), cure);
  EXPECT_EQ(reduced(mesh, massless({"x_max"}, 60, MasslessModes::tapered)).k(), 66);
  EXPECT_SAYS(message_of(100), "only 75 elastic modes");
}

}  // namespace
}  // namespace cbr::test::massless_test
