// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement as other makers write them: nodes inside are clamped, so that it has no rigid
// motions.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/superelement/superelement_check.hpp"
#include "dynamics/motion/modal/modal_body.hpp"
#include "reducer/bases/reduce.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::held_inside_test {
namespace {

// x_max the interface, eight modes, x = 0 clamped.
Superelement clamped() {
  const Mesh mesh = test::block_mesh(
      {{4, 3, 2}, Vector3(1, 0.8, 0.7), [](const Vector3& x) -> Vector3 { return x; }});
  const std::vector<BlockProperties> properties = {{{100, 0.3, 1}, Hex8Formulation::incompatible}};
  ReductionOptions options;
  options.interface_sets = {"x_max"};
  options.modes = 8;
  Report report("test", Verbosity::quiet);
  Superelement s = reduce(mesh, properties, MassKind::consistent, options, {}, report);
  const FiniteElementModel model = assemble(mesh, properties, MassKind::consistent);
  const Partition p = partition(model, interface_nodes(mesh, model, {"x_max"}));
  std::vector<Index> I;
  for (std::size_t i = 0; i < p.interior_nodes.size(); ++i)
    if (mesh.coordinates(model.nodes[p.interior_nodes[i]], 0) > 1e-6)
      for (Index d = 0; d < 3; ++d) I.push_back(3 * static_cast<Index>(i) + d);
  const Matrix K_II = Matrix(p.K_II)(I, I), M_II = Matrix(p.M_II)(I, I),
               K_IC = Matrix(p.K_IC)(I, Eigen::all), M_IC = Matrix(p.M_IC)(I, Eigen::all);
  const Matrix Psi = -Cholesky(K_II).solve(K_IC), Y = M_IC + M_II * Psi;
  const Eigenpairs modes = dense_eigenpairs(K_II, M_II, 8);
  s.K_cc = Matrix(p.K_CC) + K_IC.transpose() * Psi;
  s.M_cc = Matrix(p.M_CC) + Psi.transpose() * Y + M_IC.transpose() * Psi;
  s.K_cc = (0.5 * (s.K_cc + s.K_cc.transpose())).eval();
  s.M_cc = (0.5 * (s.M_cc + s.M_cc.transpose())).eval();
  s.M_kc = modes.Phi.transpose() * Y;
  s.eigenvalues = modes.lambda;
  s.omega.resize(0);
  s.V.resize(0, 0);
  s.accuracy.reset();
  s.conditioning.reset();
  return s;
}

SymmetricEigen reference(const Superelement& s) {
  return generalized_eigen(reduced_stiffness(s), reduced_mass(s));
}

TEST(HeldInside, IsReadAndHasNoRigidMotions) {
  Superelement s = clamped();
  EXPECT_TRUE(is_held_inside(s));
  EXPECT_EQ(resisted_rigid_motions(s).rows(), 6);
  check(s, "s.h5");
  check_rigid_motions(s, "s.h5");  // throws if it asks for the rigid motions that there are not
  const auto dense = reference(s);
  const Vector omega = dense.values.cwiseSqrt();
  const Matrix E =
      dense.vectors.transpose() * reduced_mass(s) * reduced_rigid_modes(s, s.rigid_body.center);
  const ModalForm form = free_modal_form(s, "s.h5");
  EXPECT_EQ(form.n_rigid, 0);
  EXPECT_LT((form.omega - omega).cwiseQuotient(omega).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((form.E.transpose() * form.E - E.transpose() * E).norm(), 1e-9 * E.squaredNorm());
  // The maker's own diagonal form, with and without the matrices beside it
  for (const bool with_matrices : {true, false}) {
    Superelement stored = clamped();
    stored.omega = omega;
    stored.V = dense.vectors;
    if (!with_matrices) {
      stored.K_cc.resize(0, 0);
      stored.M_cc.resize(0, 0);
      stored.M_kc.resize(0, 0);
    }
    EXPECT_TRUE(is_held_inside(stored));
    check_rigid_motions(stored, "s.h5");
    const ModalForm of_file = free_modal_form(stored, "s.h5");
    EXPECT_EQ(of_file.n_rigid, 0);
    EXPECT_LT((of_file.E - E).norm(), 1e-9 * E.norm());
  }
}

// All of it starts with one velocity: half a period of the lowest mode later, against all modes of
// the dense matrices.
TEST(HeldInside, SwingsAsItsMatricesSay) {
  const auto s = std::make_shared<Superelement>(clamped());
  const auto dense = reference(*s);
  const Vector omega = dense.values.cwiseSqrt();
  Placement placement;
  placement.velocity = Vector3(0.3, -1, 0.5);
  Vector start = Vector::Zero(s->n());
  for (Index i = 0; i < s->c(); ++i) start(s->k() + i) = placement.velocity[s->dof_component[i]];
  const Vector rates = dense.vectors.transpose() * reduced_mass(*s) * start;
  Superelement copy = *s;
  const auto form = std::make_shared<ModalForm>(free_modal_form(copy, "s.h5"));
  for (const Scheme scheme : {Scheme::exact, Scheme::central_difference, Scheme::newmark}) {
    ModalBody body("body", s, form, placement, scheme);
    const double end = std::numbers::pi / omega(0);
    const auto steps = static_cast<int>(std::ceil(end * omega(omega.size() - 1) / 0.05));
    const double h = end / steps;
    std::vector<Index> nodes(body.n_nodes());
    for (Index i = 0; i < body.n_nodes(); ++i) nodes[i] = i;
    const Index set = body.track(nodes);
    double difference = 0, size = 0;
    for (int step = 0; step < steps; ++step) {
      body.predict(step * h, h);
      body.accept();
      if (step % 10 != 9) continue;
      const double t = (step + 1) * h;
      const Vector q =
          dense.vectors *
          rates.cwiseProduct(omega.unaryExpr([&](double w) { return std::sin(w * t) / w; }));
      Points x;
      body.positions(set, x);
      const Points u = x - body.reference_positions();
      for (Index i = 0; i < s->c(); ++i) {
        difference =
            std::max(difference, std::abs(u(s->dof_node[i], s->dof_component[i]) - q(s->k() + i)));
        size = std::max(size, std::abs(q(s->k() + i)));
      }
    }
    EXPECT_LT(difference, (scheme == Scheme::exact ? 1e-9 : 5e-3) * size)
        << static_cast<int>(scheme);
    EXPECT_GT(size, 0.1 / omega(0));
  }
}

// One node held beside: a free body could still turn about it.
TEST(HeldInside, MoreDirectionsHeldLeaveNoRigidMotions) {
  const Superelement s = clamped();
  const std::vector<HeldDirection> held = {
      {0, Vector3::UnitX()}, {0, Vector3::UnitY()}, {0, Vector3::UnitZ()}};
  std::vector<Index> left;
  for (Index i = 0; i < s.n(); ++i)
    if (i < s.k() || s.dof_node[i - s.k()] != 0) left.push_back(i);
  const Matrix K = reduced_stiffness(s)(left, left), M = reduced_mass(s)(left, left);
  const Vector dense = generalized_eigen(K, M).values;
  const Vector omega = dense.cwiseSqrt();
  const ModalForm form = held_modal_form(s, held, "s.h5");
  EXPECT_EQ(form.n_rigid, 0);
  ASSERT_EQ(form.omega.size(), omega.size());
  EXPECT_LT((form.omega - omega).cwiseQuotient(omega).cwiseAbs().maxCoeff(), 1e-9);
}

// Coordinates that are not those of the matrices are resisted in rotation, and still refused.
TEST(HeldInside, IsNotWhatWrongCoordinatesMake) {
  const Mesh mesh = test::block_mesh(
      {{4, 3, 2}, Vector3(1, 0.8, 0.7), [](const Vector3& x) -> Vector3 { return x; }});
  ReductionOptions options;
  options.interface_sets = {"x_max"};
  options.modes = 8;
  Report report("test", Verbosity::quiet);
  Superelement s = reduce(mesh, {{{100, 0.3, 1}, Hex8Formulation::incompatible}}, MassKind::lumped,
                          options, {}, report);
  EXPECT_FALSE(is_held_inside(s));
  EXPECT_EQ(resisted_rigid_motions(s).rows(), 0);
  s.coordinates.col(1) *= 1.3;
  EXPECT_FALSE(is_held_inside(s));
  EXPECT_GT(resisted_rigid_motions(s).rows(), 0);
  EXPECT_THROW(check_rigid_motions(s, "s.h5"), InputError);
}

}  // namespace
}  // namespace cbr::held_inside_test
