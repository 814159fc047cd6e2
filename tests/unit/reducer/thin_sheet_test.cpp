// SPDX-License-Identifier: GPL-3.0-or-later
// Sheets so thin that K_II loses most of its digits: rigid motions stay exact, and frequencies as
// good as round-off lets them.
#include <gtest/gtest.h>

#include "common/base/error.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "reducer/bases/reduce.hpp"
#include "reducer/domains/domains.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/reducer/box_mesh.hpp"

namespace cbr::test::thin_sheet_test {
namespace {

const Material steel = {2.1e11, 0.3, 7850};

Mesh sheet(Index n, double thickness) { return box_mesh({{n, n, 1}, {1, 1, thickness}}); }

ReductionOptions held_at_an_edge(Index modes) {
  ReductionOptions options;
  options.interface_sets = {"x_min"};
  options.modes = modes;
  options.recovery = true;
  options.loads = {"x_max"};
  return options;
}

Superelement reduced(const Mesh& mesh, const ReductionOptions& options, MassKind mass,
                     ReductionFigures* figures = nullptr) {
  Report report("test", Verbosity::quiet);
  return reduce(mesh, properties(mesh, steel), mass, options, {}, report, figures);
}

Superelement reduced_again(const Mesh& mesh, ReductionOptions options, MassKind mass,
                           ReductionFigures* figures) {
  Report report("test", Verbosity::quiet);
  options.domains = 2;
  options.second_modes = options.modes;
  options.loads.clear();
  const SuperelementGroup group =
      reduce_domains(mesh, properties(mesh, steel), mass, options, {}, report);
  return reduce_again(group, component_interface(mesh, options.interface_sets), options, {}, report,
                      figures);
}

// Largest entry of A - B, of rigid motions of length 1 about the centre of mass.
double mass_error(const Superelement& s) {
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center);
  Matrix whole = Matrix::Zero(6, 6);
  whole.diagonal().head(3).setConstant(s.rigid_body.mass);
  whole.bottomRightCorner(3, 3) = s.rigid_body.inertia;
  const Vector scale = whole.diagonal().cwiseSqrt().cwiseInverse();
  return (scale.asDiagonal() * (R.transpose() * (reduced_mass(s) * R) - whole) * scale.asDiagonal())
      .cwiseAbs()
      .maxCoeff();
}

double force_error(const Superelement& s) {
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c());
  return (s.K_cc * R).cwiseAbs().maxCoeff() / s.K_cc.cwiseAbs().rowwise().sum().maxCoeff();
}

// Psi R_C against R_I
double recovery_error(const Superelement& s) {
  const auto& recovery = s.recovery.front();
  const Matrix R_C = reduced_rigid_modes(s, s.rigid_body.center).bottomRows(s.c());
  return (recovery.Psi * R_C - rigid_modes(recovery.coordinates, s.rigid_body.center))
      .cwiseAbs()
      .maxCoeff();
}

class ThinSheet : public testing::TestWithParam<std::pair<MassKind, double>> {};
INSTANTIATE_TEST_SUITE_P(MassesAndThicknesses, ThinSheet,
                         testing::Values(std::pair{MassKind::lumped, 1e-1},
                                         std::pair{MassKind::lumped, 1e-2},
                                         std::pair{MassKind::lumped, 1e-3},
                                         std::pair{MassKind::consistent, 1e-2},
                                         std::pair{MassKind::consistent, 1e-3}));

TEST_P(ThinSheet, InteriorFollowsRigidMotionsExactly) {
  const auto [mass, t] = GetParam();
  const Mesh mesh = sheet(8, t);
  // Entries of Psi are 1 / t, and round-off of M_cc is of the squares of that
  const double lost = 1e-14 / t, lost_mass = 1e-15 / (t * t);
  for (const bool again : {false, true}) {
    ReductionFigures figures;
    const Superelement s = again ? reduced_again(mesh, held_at_an_edge(20), mass, &figures)
                                 : reduced(mesh, held_at_an_edge(20), mass, &figures);
    EXPECT_LT(mass_error(s), lost_mass) << again;
    EXPECT_LT(figures.rigid.mass, lost_mass) << again;
    EXPECT_LT(force_error(s), 1e-14) << again;
    EXPECT_LT(recovery_error(s), lost) << again;
    const double right = t <= 1e-3 ? 1e3 : 0;  // there is something to put right
    EXPECT_GE(figures.rigid.lag, right * figures.rigid.mass);
  }
}

TEST_P(ThinSheet, ModesAndLoadsAreOfTheSamePsi) {
  const auto [mass, t] = GetParam();
  const Mesh mesh = sheet(8, t);
  const Superelement s = reduced(mesh, held_at_an_edge(20), mass);
  const FiniteElementModel model = assemble(mesh, properties(mesh, steel), mass);
  const Partition p = partition(model, interface_nodes(mesh, model, {"x_min"}));
  const Matrix R = rigid_modes(mesh.coordinates, s.rigid_body.center),
               R_C = R(dofs_of(p.interface_nodes), Eigen::all);
  const Matrix P_I = Matrix(model.M * R)(dofs_of(p.interior_nodes), Eigen::all);
  const Matrix expected = s.recovery.front().Phi.transpose() * P_I;
  EXPECT_LT((s.M_kc * R_C - expected).cwiseAbs().maxCoeff(),
            1e-14 / t * expected.cwiseAbs().maxCoeff());
  // A unit traction along x, y, z on the face at x = 1
  const Matrix sums = R_C.transpose() * s.loads.at("x_max").force.bottomRows(s.c());
  EXPECT_LT((sums.topRows(3) - t * Matrix3::Identity()).cwiseAbs().maxCoeff(),
            1e-14 * std::max(1.0, 1e-2 / t));
}

TEST_P(ThinSheet, FrequenciesAreThoseOfTheFullModel) {
  const auto [mass, t] = GetParam();
  const Mesh mesh = sheet(4, t);
  const Index n_interior = 4 * 5 * 2 * 3;
  const FiniteElementModel model = assemble(mesh, properties(mesh, steel), mass);
  const Vector full = dense_eigenpairs_beside(Matrix(model.K), Matrix(model.M),
                                              rigid_modes(mesh.coordinates, {0.5, 0.5, 0}))
                          .lambda.segment(6, 4);
  ReductionOptions options = held_at_an_edge(n_interior);  // nothing but round-off is lost
  options.loads.clear();
  ReductionFigures figures;
  const Superelement s = reduced(mesh, options, mass, &figures);
  ASSERT_TRUE(s.has_diagonal_form());
  const Vector found = s.omega.segment(6, 4).cwiseAbs2();
  // The assembled K itself is known to 1e-16 of its largest eigenvalue, which grows as 1 / t^4
  // beside the lowest
  const double known =
      1e-16 * model.K.diagonal().maxCoeff() / model.M.diagonal().minCoeff() / full(0);
  // 0.6 to 5.3 times that is measured
  EXPECT_LT((found - full).cwiseQuotient(full).cwiseAbs().maxCoeff(), 20 * known + 1e-11) << known;
}

TEST(ThinSheets, OfSeveralPartsEachFollowsItsOwn) {
  Mesh mesh = sheet(5, 1e-3);
  const Mesh other = box_mesh({{4, 3, 1}, {1, 0.7, 2e-3}, {0, 0, 3}});
  const Index n = mesh.coordinates.rows(), elements = mesh.blocks[0].connectivity.rows();
  mesh.coordinates.conservativeResize(n + other.coordinates.rows(), Eigen::NoChange);
  mesh.coordinates.bottomRows(other.coordinates.rows()) = other.coordinates;
  for (const Index id : other.node_ids) mesh.node_ids.push_back(id + 100000);
  Block& block = mesh.blocks[0];
  block.connectivity.conservativeResize(elements + other.blocks[0].connectivity.rows(),
                                        Eigen::NoChange);
  block.connectivity.bottomRows(other.blocks[0].connectivity.rows()) =
      other.blocks[0].connectivity.array() + n;
  for (const Index id : other.blocks[0].element_ids) block.element_ids.push_back(id + elements);
  for (std::size_t f = 0; f < other.sidesets.size(); ++f)
    for (const auto& side : other.sidesets[f].sides)
      mesh.sidesets[f].sides.push_back({0, side.element + elements, side.side});
  mesh.nodesets.clear();
  ReductionOptions options = held_at_an_edge(20);
  options.loads.clear();
  ReductionFigures figures;
  const Superelement s = reduced(mesh, options, MassKind::lumped, &figures);
  EXPECT_LT(figures.rigid.mass, 1e-9);
  const double whole = 7850 * 1e-3, second = 7850 * 0.7 * 2e-3;
  for (const bool first : {true, false}) {
    Vector z = Vector::Zero(s.n());
    for (Index i = 0; i < s.c(); ++i)
      if (s.dof_component[i] == 2 && (s.coordinates(s.dof_node[i], 2) < 2) == first)
        z(s.k() + i) = 1;
    const double expected = first ? whole : second;
    EXPECT_NEAR(z.dot(reduced_mass(s) * z), expected, 1e-9 * expected);
    EXPECT_LT((reduced_stiffness(s) * z).cwiseAbs().maxCoeff(),
              1e-14 * s.K_cc.cwiseAbs().maxCoeff());
  }
  EXPECT_EQ(figures.condition.n_rigid, 12);
}

TEST(ThinSheets, TooThinIsRefusedByNode) {
  Report report("test", Verbosity::quiet);
  const Mesh mesh = sheet(8, 1e-5);
  const std::string text = test::refusal_of([&] {
    reduce(mesh, properties(mesh, steel), MassKind::lumped, held_at_an_edge(10), {}, report);
  });
  EXPECT_SAYS(text, "thin", "node id");
}

}  // namespace
}  // namespace cbr::test::thin_sheet_test
