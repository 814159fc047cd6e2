// SPDX-License-Identifier: GPL-3.0-or-later
// Quasi-static modes: whose they are, and that their statics are kept. What such a body does
// is compared with its full mesh in tests/cases/ordinary-part.
#include <gtest/gtest.h>

#include <string>

#include "dynamics/motion/modal/forms/residual_compliance.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::truncated_form_test {
namespace {

// A block of 12 x 12 face nodes comes down on a wall; `time`, `more`: of the scene.
struct Fall {
  std::string as = "superelement", time = {}, more = {}, contact = {};
};

std::string scene_of(const Fall& of) {
  return "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.25, density: 1}}\n"
         "components:\n  block: {mesh: block.exo, material: m, mass: lumped, reduction: "
         "{interface: [x_max], modes: 6}}\n"
         "instances:\n  block: {component: block, as: " +
         of.as + ", velocity: [0.05, 0.02, 0]}\n" + of.more +
         "walls: {wall: {plane: {point: [0.6001, 0, 0], normal: [-1, 0, 0]}}}\n"
         "contact: [{between: [block.x_max, wall]" +
         of.contact +
         "}]\n"
         "time: {end: 0.2" +
         of.time + "}\noutput: {every: 0.1}\n";
}

class LargeFace : public ::testing::Test {
 protected:
  LargeFace() { folder_.add("block.exo", test::block_mesh({{5, 11, 11}, Vector3(0.6, 1, 1)})); }

  Index coordinates(const Fall& of) const {
    return folder_.prepare(scene_of(of)).built.simulation.bodies[0]->n_dofs();
  }

  const std::string load_ = "loads: [{instance: block, surface: x_max, force: [1, 0, 0]}]\n";
  test::SceneFolder folder_;
};

TEST_F(LargeFace, LosesTheMassOfItsHighestModesWithAnAutomaticStep) {
  constexpr Index all = 3 * 144 + 6;
  EXPECT_LT(coordinates({}), 2 * all / 3);
  EXPECT_LT(coordinates({.contact = ", friction: 0.3"}), 2 * all / 3);
  EXPECT_EQ(coordinates({.time = ", step: {cfl: 1}"}), all);
  EXPECT_EQ(coordinates({.time = ", step: 1.0e-3"}), all);
  EXPECT_EQ(coordinates({.time = ", integrator: newmark"}), all);
  EXPECT_EQ(coordinates({.contact = ", enforcement: penalty"}), all);
  EXPECT_EQ(coordinates({.more = load_}), all);
}

TEST_F(LargeFace, LosesTheMassOfModesThatLongStepsDoNotShow) {
  const Index half = coordinates({.time = ", step: {cfl: 2}"}),
              third = coordinates({.time = ", step: {cfl: 3}"});
  EXPECT_LT(half, 3 * 144 + 6);
  EXPECT_LT(third, half);
  EXPECT_EQ(coordinates({.time = ", step: {cfl: 2}", .more = load_}), half);
}

// Of any modes: those that move and the statics of the others comply under forces as all of them
// together.
TEST(TruncatedForm, CompliesAsAllModesDo) {
  Superelement s;
  s.node_ids = {1, 2};
  s.coordinates = Points::Random(2, 3);
  for (Index i = 0; i < 6; ++i) {
    s.dof_node.push_back(i / 3);
    s.dof_component.push_back(static_cast<int>(i % 3));
  }
  s.eigenvalues = Vector::Constant(2, 1.0);
  ModalForm all;
  all.omega = Vector::LinSpaced(8, 0, 7);
  all.n_rigid = 1;
  all.V = Matrix::Random(8, 8);
  all.E = Matrix::Zero(8, 6);
  StaticShare forces;
  forces.node = {0, 1, 1};
  forces.direction.resize(3, 3);
  forces.direction << 1, 0, 0, 0, 0.6, 0.8, 0, 0.8, -0.6;
  Matrix B = Matrix::Zero(8, 3);
  for (Index i = 0; i < 3; ++i)
    B.col(i).segment<3>(2 + 3 * forces.node[i]) = forces.direction.row(i).transpose();
  // Displacements of all coordinates, whether forces act there or not
  const auto moved = [&](const RowMatrix& V, const Vector& omega) {
    return Matrix(V.rightCols(omega.size() - 1) *
                  omega.tail(omega.size() - 1).cwiseAbs2().cwiseInverse().asDiagonal() *
                  V.rightCols(omega.size() - 1).transpose() * B);
  };
  const auto form = truncated_form(3.5, std::make_shared<const ModalForm>(all), forces, s);
  const ResidualCompliance& residual = *form->residual;
  EXPECT_EQ(form->omega.size(), 4);
  EXPECT_EQ(residual.omega_limit, 3.5);
  const Matrix whole = moved(all.V, all.omega), part = moved(form->V, form->omega),
               compliance = B.transpose() * whole;
  EXPECT_LT((B.transpose() * part + residual.rows.F.formed() - compliance).norm(),
            1e-13 * compliance.norm());
  for (Index i = 0; i < 3; ++i) {
    const Vector both = part.col(i) + residual.displacements(Vector::Unit(3, i));
    EXPECT_LT((both - whole.col(i)).norm(), 1e-13 * whole.norm());
  }
}

}  // namespace
}  // namespace cbr::truncated_form_test
