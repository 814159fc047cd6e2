// SPDX-License-Identifier: GPL-3.0-or-later
// Nodal stress where it is largest: a hole in a plate under tension (Kirsch 1898), NAFEMS LE10
// (thick elliptic plate under pressure; The Standard NAFEMS Benchmarks, 1990), a cantilever's root.
#include <gtest/gtest.h>

#include <cmath>

#include "dynamics/setup/built/instance_elements.hpp"
#include "tests/support/solve.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::test::stress_concentration_test {
namespace {

// K u = f with u given where `fixed`; model's nodes.
Points solve(const Mesh& mesh, const FiniteElementModel& model, const Support& fixed,
             const Points& given, const Points& force) {
  const std::vector<Index> dofs = free_dofs(mesh, model, fixed);
  Vector u = Eigen::Map<const Vector>(given.data(), given.size());
  for (const Index dof : dofs) u[dof] = 0;
  const Vector f = Eigen::Map<const Vector>(force.data(), force.size()) - model.K * u;
  const SparseCholesky factor(submatrix(model.K, dofs));
  const Matrix inside = factor.solve(Matrix(f(dofs)));
  u(dofs) = inside.col(0);
  return Eigen::Map<const Points>(u.data(), given.rows(), 3);
}

struct Part {
  Part(Mesh of, const Material& material) : mesh(std::move(of)) {
    properties.material = material;
    model = assemble(mesh, {properties}, MassKind::lumped);
    instance.geometry = std::make_shared<Geometry>(geometry_of(mesh, model));
    instance.mesh = std::make_shared<Mesh>(mesh);
    instance.properties = {properties};
    instance.body_node = model.row;
  }
  // At the node nearest to x.
  Vector stress_at(const Vector3& x, const Points& u) const {
    const InstanceElements elements({}, instance, {});
    const Matrix stress = elements.nodal_stresses(u);
    Index nearest = 0;
    for (Index i = 0; i < mesh.coordinates.rows(); ++i)
      if ((mesh.coordinates.row(i).transpose() - x).norm() <
          (mesh.coordinates.row(nearest).transpose() - x).norm())
        nearest = i;
    EXPECT_LT((mesh.coordinates.row(nearest).transpose() - x).norm(), 1e-9);
    return stress.row(elements.place(nearest, 0)).transpose();
  }

  Mesh mesh;
  BlockProperties properties;
  FiniteElementModel model;
  BuiltScene::OfInstance instance;
};

// A quarter of a ring round a hole of radius 1 in a wide plate under tension along x, in plane
// strain; displacements of Kirsch's solution are given at the outer radius.
constexpr double radius = 4, tension = 1;

Vector3 kirsch(const Vector3& x, const Material& m) {
  const double G = m.youngs_modulus / (2 * (1 + m.poissons_ratio)),
               kappa = 3 - 4 * m.poissons_ratio;
  const double r = std::hypot(x[0], x[1]), angle = std::atan2(x[1], x[0]), q = 1 / r;
  const double s = tension / (8 * G);
  const double ux = s * (r * (kappa + 1) * std::cos(angle) +
                         2 * q * ((1 + kappa) * std::cos(angle) + std::cos(3 * angle)) -
                         2 * q * q * q * std::cos(3 * angle));
  const double uy = s * (r * (kappa - 3) * std::sin(angle) +
                         2 * q * ((1 - kappa) * std::sin(angle) + std::sin(3 * angle)) -
                         2 * q * q * q * std::sin(3 * angle));
  return {ux, uy, 0};
}

// Stress along the edge over the tension far away, where the hole is widest. Exactly 3.
double concentration(ElementType type, Index n) {
  const Material material = {200, 0.3, 1};
  const Part part(box_mesh(type, {n, n, 1}, Vector3(1, 1, 0.2),
                           [](const Vector3& x) -> Vector3 {
                             const double r = std::pow(radius, x[0]),
                                          angle = 0.5 * std::numbers::pi * x[1];
                             return Vector3(r * std::cos(angle), r * std::sin(angle), x[2]);
                           }),
                  material);
  // Mid-side nodes stand on chords in box_mesh: those of the hole's edge are moved onto it
  Mesh mesh = part.mesh;
  for (Index i = 0; i < mesh.coordinates.rows(); ++i) {
    auto x = mesh.coordinates.row(i);
    const double r = std::hypot(x[0], x[1]), wanted = r < 1 ? 1 : r;
    x[0] *= wanted / r;
    x[1] *= wanted / r;
  }
  const Part round(mesh, material);
  Points given = Points::Zero(mesh.coordinates.rows(), 3);
  for (Index i = 0; i < given.rows(); ++i)
    given.row(i) = kirsch(mesh.coordinates.row(i).transpose(), material).transpose();
  const auto fixed = [&](const Vector3& x, int c) {
    if (c == 2) return true;
    const double r = std::hypot(x[0], x[1]);
    return r > 0.97 * radius || (c == 0 && x[0] < 1e-9) || (c == 1 && x[1] < 1e-9);
  };
  const Points u = solve(mesh, round.model, fixed, given, Points::Zero(given.rows(), 3));
  return round.stress_at(Vector3(0, 1, 0), u)[0] / tension;
}

TEST(PlateWithAHole, HasThreeTimesTheStressAtItsEdge) {
  std::vector<double> linear, quadratic;
  for (const Index n : {16, 32, 64}) linear.push_back(concentration(ElementType::hex8, n) - 3);
  for (const Index n : {6, 12, 24}) quadratic.push_back(concentration(ElementType::hex20, n) - 3);
  std::printf("hex8: errors %.4f %.4f %.4f of 3; hex20: %.4f %.4f %.4f\n", linear[0], linear[1],
              linear[2], quadratic[0], quadratic[1], quadratic[2]);
  EXPECT_LT(std::abs(linear[2]), 0.015);
  EXPECT_LT(std::abs(linear[2]), 0.7 * std::abs(linear[1]));
  EXPECT_LT(std::abs(quadratic[2]), 0.005);
  EXPECT_GT(std::log2(quadratic[1] / quadratic[2]), 1.5);
}

// Pressure 1 MPa on the top of a quarter of an elliptic plate, 0.6 m thick, E 210 GPa, nu 0.3:
// sigma_yy at D on the top's inner edge is -5.38 MPa. n x 1.5 n x n / 2 elements.
double le10(ElementType type, std::array<Index, 3> n) {
  const Part part(box_mesh(type, n, Vector3(1, 1, 0.6),
                           [](const Vector3& x) -> Vector3 {
                             const double angle = 0.5 * std::numbers::pi * x[1], s = x[0];
                             return Vector3((2 + 1.25 * s) * std::cos(angle),
                                            (1 + 1.75 * s) * std::sin(angle), x[2]);
                           }),
                  {210e9, 0.3, 8000});
  const Mesh& mesh = part.mesh;
  // Held: the outer surface in x and y, and its middle line in z; symmetry
  const auto on_outside = [](const Vector3& x) {
    return std::pow(x[0] / 3.25, 2) + std::pow(x[1] / 2.75, 2) > 0.975;
  };
  const auto fixed = [&](const Vector3& x, int c) {
    if (c == 2) return on_outside(x) && std::abs(x[2] - 0.3) < 1e-9;
    return on_outside(x) || (c == 0 && x[0] < 1e-9) || (c == 1 && x[1] < 1e-9);
  };
  Sideset top{"top", 1, {}};
  for (Index e = 0; e < mesh.blocks[0].connectivity.rows(); ++e)
    for (int side = 1; side <= 6; ++side) {
      bool is_top = true;
      for (const Index node : nodes_of_side(mesh, {0, e, side}))
        is_top = is_top && mesh.coordinates(node, 2) > 0.6 - 1e-9;
      if (is_top) top.sides.push_back({0, e, side});
    }
  const Points force = -1e6 * face_normals(extract_surface(mesh, top), mesh.coordinates);
  const Points u = solve(mesh, part.model, fixed, Points::Zero(mesh.coordinates.rows(), 3), force);
  return part.stress_at(Vector3(2, 0, 0.6), u)[1];
}

TEST(ThickPlate, Le10) {
  const double coarse = le10(ElementType::hex20, {4, 6, 2}),
               fine = le10(ElementType::hex20, {8, 12, 4});
  std::printf("LE10: sigma_yy %.3f MPa, %.3f MPa with half the size; target -5.38\n", coarse / 1e6,
              fine / 1e6);
  EXPECT_NEAR(coarse, -5.38e6, 0.05 * 5.38e6);
  EXPECT_NEAR(fine, -5.38e6, 0.02 * 5.38e6);
}

// Bending of a slender cantilever by a couple at its end: sigma_xx = M c / I at the root, without
// Poisson's effect.
TEST(Cantilever, RootHasTheStressOfABeam) {
  const double L = 10, h = 1, b = 0.5, stress = 3;
  const Part part(box_mesh(ElementType::hex8, {20, 4, 2}, Vector3(L, h, b)), {1000, 0, 1});
  const Mesh& mesh = part.mesh;
  // Linear tractions sigma y / (h / 2) on the end's faces, consistent: integrated as the elements'
  // linear shapes are
  Points force = Points::Zero(mesh.coordinates.rows(), 3);
  for (Index e = 0; e < mesh.blocks[0].connectivity.rows(); ++e) {
    for (int side = 1; side <= 6; ++side) {
      const std::vector<Index> nodes = nodes_of_side(mesh, {0, e, side});
      if (std::any_of(nodes.begin(), nodes.end(),
                      [&](Index i) { return mesh.coordinates(i, 0) < L - 1e-9; }))
        continue;
      const double height = h / 4, width = b / 2;
      for (const Index i : nodes)
        for (const Index j : nodes) {
          const double same_y =
              std::abs(mesh.coordinates(i, 1) - mesh.coordinates(j, 1)) < 1e-9 ? 2 : 1;
          const double same_z =
              std::abs(mesh.coordinates(i, 2) - mesh.coordinates(j, 2)) < 1e-9 ? 2 : 1;
          force(i, 0) += height / 6 * same_y * width / 6 * same_z * stress *
                         (mesh.coordinates(j, 1) - h / 2) / (h / 2);
        }
    }
  }
  const auto fixed = [](const Vector3& x, int) { return x[0] < 1e-9; };
  const Points u = solve(mesh, part.model, fixed, Points::Zero(mesh.coordinates.rows(), 3), force);
  EXPECT_NEAR(part.stress_at(Vector3(0, h, 0), u)[0], stress, 1e-9);
  EXPECT_NEAR(part.stress_at(Vector3(L / 2, 0, b), u)[0], -stress, 1e-9);
}

}  // namespace
}  // namespace cbr::test::stress_concentration_test
