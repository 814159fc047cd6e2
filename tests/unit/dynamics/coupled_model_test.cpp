// SPDX-License-Identifier: GPL-3.0-or-later
// Coupled models and their factor against dense algebra on the whole matrices.
#include "dynamics/motion/coupled/coupled_model.hpp"
#include "common/linalg/dense.hpp"

#include <gtest/gtest.h>

#include <random>

#include "common/base/error.hpp"
#include "dynamics/motion/coupled/coupled_system.hpp"
#include "tests/unit/dynamics/bricks.hpp"
#include "tests/unit/dynamics/coupled_parts.hpp"

namespace cbr::coupled_model_test {
namespace {

using test::chain;
using test::chain_with_shells;
using test::some_held;
using test::whole_free_basis;

Vector random_vector(Index n) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  return Vector::NullaryExpr(n, [&] { return normal(random); });
}

CoupledModel lumped_mesh(MassKind mass = MassKind::lumped) {
  const test::Brick b = test::make_brick({3, 2, 2}, Vector3(1, 0.6, 0.5), {100, 0.3, 2}, mass);
  return coupled_model(b.fe, b.geometry.coordinates);
}

std::vector<CoupledModel> all_models() {
  std::vector<CoupledModel> models{chain(1, 5).model(), chain(3, 4).model(),
                                   chain(2, 0).model(), chain_with_shells(3),
                                   lumped_mesh(),       lumped_mesh(MassKind::consistent)};
  return models;
}

TEST(CoupledModel, RigidMotionsAreFreeAndHaveTheRigidBodysMass) {
  for (const CoupledModel& model : all_models()) {
    const Matrix R = rigid_motions(model), K = test::whole_stiffness(model),
                 M = test::whole_mass(model);
    EXPECT_LT((K - K.transpose()).norm() + (M - M.transpose()).norm(), 1e-13 * K.norm());
    EXPECT_LT((K * R).norm(), 1e-12 * K.norm() * R.norm());
    Matrix expected = Matrix::Zero(6, 6);
    expected.diagonal().head(3).setConstant(model.rigid_body.mass);
    expected.bottomRightCorner(3, 3) = model.rigid_body.inertia;
    EXPECT_LT((R.transpose() * M * R - expected).norm(), 1e-12 * expected.norm());
  }
}

TEST(CoupledModel, AllModesOfTheDomainsAreTheWholeBody) {
  // Three nodes a side less the interface leave 6 interior nodes: 18 modes. The joined lattices,
  // unreduced:
  const test::Chain c = chain(2, 18);
  const CoupledModel model = c.model();
  const ModalForm form = modal_form(model, {}, "test");
  const test::Lattice a = test::lattice({3, 2, 3}, 0.1, 2e3, 0.3),
                      b = test::lattice({3, 2, 3}, 0.1, 4e3, 0.5);
  // Nodes of a at x plane 2 are those of b at plane 0: number the planes 0 .. 4
  const auto dofs = [](Index first_plane) {
    std::vector<Index> dof;
    for (Index node = 0; node < 18; ++node)
      for (Index d = 0; d < 3; ++d)
        dof.push_back(3 * (6 * (first_plane + node % 3) + node / 3) + d);
    return dof;
  };
  Matrix K = Matrix::Zero(90, 90), M = K;
  K(dofs(0), dofs(0)) += a.K;
  K(dofs(2), dofs(2)) += b.K;
  for (const Index i : dofs(0)) M(i, i) += 0.3;
  for (const Index i : dofs(2)) M(i, i) += 0.5;
  const Vector lambda = generalized_eigen(K, M).values;
  ASSERT_EQ(form.omega.size(), 90);
  EXPECT_LT((form.omega.cwiseAbs2() - lambda).cwiseAbs().maxCoeff(), 1e-11 * lambda.maxCoeff());
}

TEST(CoupledModel, ModalFormDiagonalises) {
  for (const CoupledModel& model : all_models()) {
    for (const bool hold : {false, true}) {
      const auto held = hold ? some_held() : std::vector<HeldDirection>{};
      const ModalForm form = modal_form(model, held, "test");
      const Matrix K = test::whole_stiffness(model), M = test::whole_mass(model), V = form.V;
      const Index n = form.omega.size();
      ASSERT_EQ(n, model.n() - static_cast<Index>(held.size()));
      EXPECT_LT((V.transpose() * M * V - Matrix::Identity(n, n)).cwiseAbs().maxCoeff(), 1e-11);
      const Matrix off = V.transpose() * K * V - Matrix(form.omega.cwiseAbs2().asDiagonal());
      EXPECT_LT(off.cwiseAbs().maxCoeff(), 1e-11 * form.omega.cwiseAbs2().maxCoeff());
      EXPECT_EQ(form.n_rigid, hold ? 0 : 6);
      EXPECT_LT((form.E - V.transpose() * M * rigid_motions(model)).norm(), 1e-11 * form.E.norm());
      for (const HeldDirection& h : held)
        EXPECT_LT((h.direction.transpose() * V.middleRows(model.n_modal() + 3 * h.node, 3)).norm(),
                  1e-12 * V.norm());
    }
  }
}

TEST(CoupledModel, FactorSolvesTheWholeSystem) {
  for (const CoupledModel& model : all_models()) {
    for (const bool hold : {false, true}) {
      for (const double theta : {0.0, 1e-4, 3.0}) {
        const auto held = hold ? some_held() : std::vector<HeldDirection>{};
        const FreeDofs free = free_dofs(model, held);
        EXPECT_EQ(free.is_all, !hold);
        const CoupledFactor factor(model, free, theta, "test");
        const Matrix Z = whole_free_basis(model, held);
        const Matrix A =
            Z.transpose() * (test::whole_mass(model) + theta * test::whole_stiffness(model)) * Z;
        const Vector f = random_vector(model.n());
        Vector x = f;
        factor.solve(x);
        const Vector expected = Z * Ldlt(A).solve(Z.transpose() * f);
        EXPECT_LT((x - expected).norm(), 1e-11 * expected.norm());
        // Forces on nodes, answers of nodes
        const Index n_free = free.Z.cols();
        Matrix Y = Matrix::Identity(n_free, n_free);
        factor.solve_free(Y);
        EXPECT_LT((Y - Lu(A).inverse().bottomRightCorner(n_free, n_free)).norm(), 1e-11 * Y.norm());
      }
    }
  }
}

TEST(CoupledModel, LumpedMassOfAMeshIsDividedBy) {
  const CoupledModel model = lumped_mesh();
  const FreeDofs free = free_dofs(model, some_held());
  EXPECT_EQ(CoupledFactor(model, free, 0, "test").diagonal().size(), free.Z.cols());
  EXPECT_EQ(CoupledFactor(model, free, 0.1, "test").diagonal().size(), 0);
}

TEST(CoupledModel, DofsThatASuperelementHasNotAreLeftOut) {
  // A superelement that knows one node only along x and y.
  const test::Lattice body = test::lattice({3, 3, 3}, 0.1, 2e3, 0.3);
  Superelement s = test::reduce(body, test::x_nodes(body, true, true), 4);
  std::vector<Index> keep;
  for (Index i = 0; i < s.c(); ++i)
    if (s.dof_node[i] != 5 || s.dof_component[i] != 2) keep.push_back(i);
  s.K_cc = Matrix(s.K_cc(keep, keep));
  s.M_cc = Matrix(s.M_cc(keep, keep));
  s.M_kc = Matrix(s.M_kc(Eigen::all, keep));
  std::vector<Index> node;
  std::vector<int> component;
  for (const Index i : keep) {
    node.push_back(s.dof_node[i]);
    component.push_back(s.dof_component[i]);
  }
  s.dof_node = node;
  s.dof_component = component;
  const Matrix K = reduced_stiffness(s), M = reduced_mass(s);
  const CoupledModel model = coupled_model(std::make_shared<Superelement>(s));
  EXPECT_EQ(free_dofs(model, {}).Z.cols(), s.c());
  const Vector lambda = generalized_eigen(K, M).values;
  const ModalForm form = modal_form(model, {}, "test");
  EXPECT_LT((form.omega.cwiseAbs2() - lambda).cwiseAbs().maxCoeff(), 1e-11 * lambda.maxCoeff());
  // What is held obliquely in the plane x z is held along x: z is not there.
  const FreeDofs held = free_dofs(model, {{5, Vector3(1, 0, 1).normalized()}});
  ASSERT_EQ(held.Z.cols(), s.c() - 1);
  EXPECT_EQ((Matrix(held.Z).middleRows(15, 3).rowwise().norm().array() > 1e-12).count(), 1);
}

TEST(CoupledModel, ModalBodyTakesItsModalForm) {
  const CoupledModel model = chain_with_shells(3);
  const auto form = std::make_shared<const ModalForm>(modal_form(model, {}, "test"));
  const auto nodes = std::make_shared<const Superelement>(nodes_only(model));
  Placement placement;
  placement.velocity = Vector3(1, -2, 0.5);
  ModalBody body("b", nodes, form, placement, Scheme::exact);
  ASSERT_EQ(body.n_nodes(), model.coordinates.rows());
  EXPECT_LT((body.state().momentum - model.rigid_body.mass * placement.velocity).norm(),
            1e-12 * body.state().momentum.norm());
  const Index set = body.track({1, 9});
  const NodeResponse response = body.response(set, 1e-7);
  // A short step: the response is h M^-1
  const Matrix M_inverse = Lu(test::whole_mass(model)).inverse();
  std::vector<Index> rows;
  for (const Index node : {1, 9})
    for (Index c = 0; c < 3; ++c) rows.push_back(model.n_modal() + 3 * node + c);
  EXPECT_LT((response.dense() / 1e-7 - M_inverse(rows, rows)).norm(),
            1e-8 * response.dense().norm() / 1e-7);
  Points p = Points::Zero(2, 3);
  p.row(0) << 1, 2, 3;
  const Vector3 before = body.state().momentum;
  body.predict(0, 0.01);
  body.add_impulses(set, p);
  body.accept();
  EXPECT_LT((body.state().momentum - before - Vector3(1, 2, 3)).norm(), 1e-12 * before.norm());
}

TEST(CoupledModel, AMassThatIsNotPositiveIsRefused) {
  const test::Chain c = chain(2, 3);
  auto s = std::make_shared<Superelement>(*c.domains[0]);
  s->M_kc *= 10;
  const CoupledModel model = coupled_model({s, c.domains[1]}, c.coordinates, c.place, c.body);
  EXPECT_THROW(CoupledFactor(model, free_dofs(model, {}), 0, "test"), RunError);
  EXPECT_THROW(modal_form(model, {}, "test"), RunError);
}

}  // namespace
}  // namespace cbr::coupled_model_test
