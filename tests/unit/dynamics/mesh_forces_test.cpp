// SPDX-License-Identifier: GPL-3.0-or-later
// K u by shared element matrices, by an assembled matrix and by threads: one answer; and the body
// that moves by it.
#include "dynamics/motion/nodal/mesh_forces.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/unit/dynamics/bricks.hpp"

namespace cbr::mesh_forces_test {
namespace {

const Material steel{200, 0.3, 2};

Points random_points(std::mt19937& random, Index n, double scale) {
  std::uniform_real_distribution<double> value(-scale, scale);
  return Points::NullaryExpr(n, 3, [&](Index, Index) { return value(random); });
}

// K u by nodes.
Points product(const MeshForces& forces, const Points& u, int n_threads) {
  Field x(u.rows(), 3), y = Field::Constant(u.rows(), 3, NAN);
  for (Index i = 0; i < u.rows(); ++i) x.row(i) = u.row(forces.order()[i]);
  RowThreads threads(n_threads);
  MeshForces::Work work;
  // the second time on rooms that the first one has used
  for (int repeat = 0; repeat < 2; ++repeat)
    forces.each(x, threads, work, [&](Index begin, Index end, const double* f, Index stride) {
      for (int c = 0; c < 3; ++c)
        for (Index i = begin; i < end; ++i) y(i, c) = f[c * stride + i - begin];
    });
  Points f(u.rows(), 3);
  for (Index i = 0; i < u.rows(); ++i) f.row(forces.order()[i]) = y.row(i);
  return f;
}

void expect_product(const FiniteElementModel& fe, const MeshForces& forces) {
  std::mt19937 random(1);
  const Points u = random_points(random, forces.rows(), 1);
  const Vector expected = fe.K * Eigen::Map<const Vector>(u.data(), u.size());
  const Points one = product(forces, u, 1);
  EXPECT_LT((Eigen::Map<const Vector>(one.data(), one.size()) - expected).cwiseAbs().maxCoeff(),
            1e-14 * expected.cwiseAbs().maxCoeff());
  for (const int n_threads : {2, 3, 7}) EXPECT_EQ(product(forces, u, n_threads), one);
}

TEST(MeshForces, SharedAndAssembledAreTheProductOfK) {
  for (const auto& n : {std::array<Index, 3>{20, 10, 15}, {3, 9, 4}, {8, 1, 1}, {4, 7, 2}}) {
    const test::Brick b = test::make_brick(n, Vector3(1, 0.7, 0.9), steel);
    for (const auto variant : {MeshForces::Variant::assembled, MeshForces::Variant::shared,
                               MeshForces::Variant::automatic})
      expect_product(b.fe,
                     MeshForces(b.fe, b.mesh, {{steel, HexFormulation::incompatible}}, variant));
  }
}

TEST(MeshForces, AllElementsOfABlockAreShared) {
  for (const auto formulation :
       {HexFormulation::full, HexFormulation::incompatible, HexFormulation::hourglass}) {
    const Mesh mesh = test::brick({20, 10, 15}, Vector3(0.0381, 0.0254, 0.0381));
    const FiniteElementModel fe = assemble(mesh, {{steel, formulation}}, MassKind::lumped);
    const MeshForces forces(fe, mesh, {{steel, formulation}});
    EXPECT_EQ(forces.n_shared_elements(), 3000);
    expect_product(fe, forces);
  }
}

TEST(MeshForces, WhatIsNotSharedIsAssembled) {
  Mesh mesh = test::brick({12, 6, 8}, Vector3(1, 0.7, 0.9));
  // A bulge on one face, and a second material at the other end
  for (Index i = 0; i < mesh.coordinates.rows(); ++i)
    if (mesh.coordinates(i, 0) > 0.99) mesh.coordinates(i, 0) += 0.02 * mesh.coordinates(i, 1);
  Block& block = mesh.blocks[0];
  Block other = block;
  other.name = "other";
  other.id = 2;
  const Index n_other = 2 * 12 * 6;
  other.connectivity = IndexTable(block.connectivity.topRows(n_other));
  other.element_ids.resize(n_other);
  block.connectivity =
      IndexTable(block.connectivity.bottomRows(block.connectivity.rows() - n_other));
  block.element_ids.erase(block.element_ids.begin(), block.element_ids.begin() + n_other);
  mesh.blocks.push_back(other);
  mesh.sidesets.clear();
  const std::vector<BlockProperties> properties{{steel, HexFormulation::incompatible},
                                                {{70, 0.2, 1}, HexFormulation::full}};
  const FiniteElementModel fe = assemble(mesh, properties, MassKind::lumped);
  const MeshForces forces(fe, mesh, properties);
  EXPECT_EQ(forces.n_shared_elements(), 11 * 6 * 8);
  expect_product(fe, forces);
}

TEST(MeshForces, NothingIsSharedOfADistortedMesh) {
  Mesh mesh = test::brick({6, 5, 4}, Vector3(1, 0.7, 0.9));
  std::mt19937 random(3);
  mesh.coordinates += random_points(random, mesh.coordinates.rows(), 0.01);
  const std::vector<BlockProperties> properties{{steel, HexFormulation::incompatible}};
  const FiniteElementModel fe = assemble(mesh, properties, MassKind::lumped);
  const MeshForces forces(fe, mesh, properties);
  EXPECT_EQ(forces.n_shared_elements(), 0);
  expect_product(fe, forces);
}

// The half of the matrix that is stored, with numbers of nodes that have nothing to do with their
// places: rows reach over several threads' parts, and with 7 threads parts are shorter than the
// reach.
TEST(MeshForces, HalfOfTheMatrixServesAnyNumbering) {
  Mesh mesh = test::brick({9, 5, 4}, Vector3(1, 0.7, 0.9));
  std::mt19937 random(4);
  mesh.coordinates += random_points(random, mesh.coordinates.rows(), 0.01);
  std::vector<Index> place = first_numbers(mesh.coordinates.rows());
  std::shuffle(place.begin(), place.end(), random);
  const Points X = mesh.coordinates;
  for (std::size_t i = 0; i < place.size(); ++i)
    mesh.coordinates.row(place[i]) = X.row(static_cast<Index>(i));
  for (Index& node : mesh.blocks[0].connectivity.reshaped()) node = place[node];
  mesh.sidesets.clear();
  const std::vector<BlockProperties> properties{{steel, HexFormulation::incompatible}};
  const FiniteElementModel fe = assemble(mesh, properties, MassKind::lumped);
  expect_product(fe, MeshForces(fe, mesh, properties));
  expect_product(fe, MeshForces(fe.K));
}

TEST(MeshForces, ATranslationMakesNoForceToTheLastBit) {
  const test::Brick b = test::make_brick({9, 4, 5}, Vector3(1, 0.7, 0.9), steel);
  const MeshForces forces(b.fe, b.mesh, {{steel, HexFormulation::incompatible}});
  ASSERT_GT(forces.n_shared_elements(), 0);
  const Points u = Vector3(3, -2, 1e6).transpose().replicate(forces.rows(), 1);
  EXPECT_EQ(product(forces, u, 2), Points(Points::Zero(forces.rows(), 3)));
}

// The same motion, whatever the forces are formed by and however many threads form them.
TEST(MeshForces, BodiesMoveAlike) {
  const test::Brick b = test::make_brick({20, 10, 15}, Vector3(1, 0.7, 0.9), steel);
  const std::vector<BlockProperties> properties{{steel, HexFormulation::incompatible}};
  const auto model = [&](MeshForces::Variant variant) {
    return std::make_shared<MeshModel>(mesh_model(b.fe, b.geometry.coordinates, true,
                                                  MeshForces(b.fe, b.mesh, properties, variant)));
  };
  const auto shared = model(MeshForces::Variant::shared),
             assembled = model(MeshForces::Variant::assembled);
  EXPECT_NEAR(shared->largest_frequency / assembled->largest_frequency, 1, 1e-6);
  std::vector<HeldDirection> held;
  for (Index i = 0; i < b.geometry.coordinates.rows(); ++i)
    if (b.geometry.coordinates(i, 0) == 0) held.push_back({i, Vector3(0.6, 0.8, 0)});
  Placement placement;
  placement.position = Vector3(1, 2, 3);
  placement.velocity = Vector3(0.2, -0.1, 0.4);
  placement.T << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  MeshBody first("a", assembled, placement, held, std::make_shared<RowThreads>(1));
  MeshBody second("b", shared, placement, held, std::make_shared<RowThreads>(1));
  MeshBody third("c", shared, placement, held, std::make_shared<RowThreads>(2));
  const double h = 1.8 / assembled->largest_frequency;
  Points x[3];
  int k = 0;
  for (MeshBody* body : {&first, &second, &third}) {
    std::mt19937 random(5);
    const std::vector<Index> nodes{5, 100, 3000};
    const Index set = body->track(nodes);
    body->prepare({.loads = {force_load(random_points(random, body->n_nodes(), 1e-3)),
                             gravity_load(Vector3(0, 0, -1))}});
    for (int step = 0; step < 60; ++step) {
      body->predict(step * h, h);
      if (step % 7 == 3) body->add_impulses(set, random_points(random, 3, 1e-3));
      body->accept();
      if (step % 10 == 4) body->state();
    }
    Points v;
    body->displacements(x[k++], v);
  }
  const double size = x[0].cwiseAbs().maxCoeff();
  EXPECT_LT((x[1] - x[0]).cwiseAbs().maxCoeff(), 1e-12 * size);
  EXPECT_EQ(x[2], x[1]);
  const BodyState a = first.state(), c = third.state();
  EXPECT_NEAR(a.strain_energy, c.strain_energy, 1e-11 * a.strain_energy);
  EXPECT_NEAR(a.kinetic_energy, c.kinetic_energy, 1e-12 * a.kinetic_energy);
  EXPECT_LT((a.momentum - c.momentum).norm(), 1e-12 * a.momentum.norm());
  EXPECT_LT((a.angular_momentum - c.angular_momentum).norm(), 1e-12 * a.angular_momentum.norm());
  EXPECT_NEAR(first.work().external, third.work().external,
              1e-11 * std::abs(first.work().external));
  EXPECT_NEAR(first.work().contact, third.work().contact, 1e-11 * std::abs(first.work().contact));
}

}  // namespace
}  // namespace cbr::mesh_forces_test
