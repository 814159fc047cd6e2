// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/surface.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <map>
#include <set>

#include "common/base/error.hpp"
#include "common/fem/assembly.hpp"
#include "common/mesh/face_weights.hpp"
#include "sample_meshes.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::surface_test {
namespace {

Sideset all_sides(const Mesh& mesh) {
  Sideset all{"all", 9, {}};
  for (Index b = 0; b < static_cast<Index>(mesh.blocks.size()); ++b)
    for (Index e = 0; e < mesh.blocks[b].connectivity.rows(); ++e)
      for (int s = 1; s <= n_sides(mesh.blocks[b].type); ++s) all.sides.push_back({b, e, s});
  return all;
}

Vector3 vector_area(const Points& X, const IndexTable& faces, Index f) {
  const auto p = [&](Index i) -> Vector3 { return X.row(faces(f, i)).transpose(); };
  Vector3 area = Vector3::Zero();
  for (Index i = 1; i + 1 < faces.cols(); ++i) area += 0.5 * (p(i) - p(0)).cross(p(i + 1) - p(0));
  return area;
}

Mesh one_element(ElementType type) {
  Mesh mesh;
  mesh.coordinates = test::element_points(type, test::skew_corners(type));
  Block block{"b", 1, type, IndexTable(1, n_nodes(type)), {7}};
  for (int i = 0; i < n_nodes(type); ++i) {
    block.connectivity(0, i) = i;
    mesh.node_ids.push_back(i + 1);
  }
  mesh.blocks = {block};
  return mesh;
}

TEST(Surface, innerFacesAreSharedTwiceWithOppositeSenses) {
  const Mesh mesh = test::brick(2, 2, 1);
  const Surface surface = extract_surface(mesh, all_sides(mesh));
  ASSERT_EQ(surface.n_faces(), 24);
  std::map<std::set<Index>, std::vector<Index>> shared;
  for (Index f = 0; f < surface.n_faces(); ++f)
    shared[{surface.faces.row(f).begin(), surface.faces.row(f).end()}].push_back(f);
  int inner = 0;
  for (const auto& [nodes, faces] : shared) {
    ASSERT_LE(faces.size(), 2U);
    if (faces.size() == 1) continue;
    ++inner;
    const Vector3 sum = vector_area(mesh.coordinates, surface.faces, faces[0]) +
                        vector_area(mesh.coordinates, surface.faces, faces[1]);
    EXPECT_LT(sum.norm(), 1e-15);
  }
  EXPECT_EQ(inner, 4);
}

TEST(Surface, keepsOrderElementAndSide) {
  const Mesh mesh = test::brick(3, 2, 2);
  const Surface surface = extract_surface(mesh, mesh.sidesets[find_sideset(mesh, "x_max")]);
  ASSERT_EQ(surface.n_faces(), 4);
  EXPECT_EQ(surface.kind, FaceKind::quad4);
  EXPECT_EQ(surface.element, (std::vector<Index>{3, 6, 9, 12}));
  EXPECT_EQ(surface.side, (std::vector<int>{2, 2, 2, 2}));
  for (Index f = 0; f < 4; ++f)
    EXPECT_LT((vector_area(mesh.coordinates, surface.faces, f) - Vector3(1, 0, 0)).norm(), 1e-15);
  EXPECT_EQ(surface_nodes(surface).size(), 9U);
  EXPECT_EQ(surface_nodes(surface), set_nodes(mesh, "x_max"));
}

TEST(Surface, trianglesAmongQuadrilateralsRepeatTheirLastNode) {
  const Mesh mesh = one_element(ElementType::wedge6);
  const Surface surface = extract_surface(mesh, all_sides(mesh));
  EXPECT_EQ(surface.kind, FaceKind::quad4);
  Vector3 sum = Vector3::Zero();
  for (Index f = 0; f < surface.n_faces(); ++f)
    sum += vector_area(mesh.coordinates, surface.faces, f);
  EXPECT_LT(sum.norm(), 1e-14);
  for (const Index f : {3, 4}) EXPECT_EQ(surface.faces(f, 2), surface.faces(f, 3));
}

// A uniform pressure on all sides of a body: its displacements are linear, and the nodal forces
// those of each face's own functions, also where a set has tri6 and quad8.
TEST(Surface, uniformPressureOnMixedFacesStrainsUniformly) {
  for (const auto type : {ElementType::wedge6, ElementType::wedge15, ElementType::hex20}) {
    const Mesh mesh = one_element(type);
    const Surface surface = extract_surface(mesh, all_sides(mesh));
    const double E = 3, nu = 0.25;
    const auto model = assemble(mesh, {{{E, nu, 1}, HexFormulation::full}}, MassKind::lumped);
    const Points n = face_normals(surface, mesh.coordinates),
                 u = -(1 - 2 * nu) / E * mesh.coordinates;
    const Vector force = model.K * Vector(u.reshaped<Eigen::RowMajor>());
    EXPECT_LT((force + Vector(n.reshaped<Eigen::RowMajor>())).norm(), 1e-13 * force.norm())
        << name(type);
    const Vector one = Vector::Ones(n.rows());
    EXPECT_LT((face_mass(surface, mesh.coordinates) * one - face_weights(surface, mesh.coordinates))
                  .norm(),
              1e-14 * n.norm());
  }
}

TEST(Surface, linearFacesCoverTheFace) {
  for (const auto type : {ElementType::tet4, ElementType::tet10, ElementType::wedge15,
                          ElementType::hex8, ElementType::hex20, ElementType::hex27}) {
    SCOPED_TRACE(name(type));
    const Mesh mesh = one_element(type);
    const Surface surface = extract_surface(mesh, all_sides(mesh));
    const LinearFaces linear = linear_faces(surface);
    std::vector<Vector3> area(surface.n_faces(), Vector3::Zero());
    std::set<Index> nodes;
    for (Index f = 0; f < linear.faces.rows(); ++f) {
      area[linear.parent[f]] += vector_area(mesh.coordinates, linear.faces, f);
      nodes.insert(linear.faces.row(f).begin(), linear.faces.row(f).end());
    }
    EXPECT_EQ(nodes.size(), surface_nodes(surface).size());
    for (Index f = 0; f < surface.n_faces(); ++f) {
      IndexTable corners = surface.faces.row(f).leftCols(n_corners(surface.kind));
      EXPECT_LT((area[f] - vector_area(mesh.coordinates, corners, 0)).norm(), 1e-14);
    }
  }
}

// Interface, supports and contact ask for a face's nodes in these ways.
TEST(Surface, faceOfHex27HasEveryNodeThatLiesOnIt) {
  Mesh mesh = test::box_mesh(ElementType::hex27, {2, 4, 3}, Vector3(2, 1, 1));
  std::vector<Index> on;
  for (Index i = 0; i < mesh.coordinates.rows(); ++i)
    if (mesh.coordinates(i, 0) > 2 - 1e-9) on.push_back(i);
  Sideset face{"x_max", 1, {}};
  const Sideset all = all_sides(mesh);
  for (const Side& side : all.sides) {
    const std::vector<Index> nodes = nodes_of_side(mesh, side);
    if (std::all_of(nodes.begin(), nodes.end(),
                    [&](Index i) { return mesh.coordinates(i, 0) > 2 - 1e-9; }))
      face.sides.push_back(side);
  }
  mesh.sidesets = {face};
  ASSERT_EQ(face.sides.size(), 12U);
  ASSERT_EQ(on.size(), 9U * 7U);
  const Surface surface = extract_surface(mesh, face);
  EXPECT_EQ(name(surface.kind), "quad9");
  EXPECT_EQ(set_nodes(mesh, "x_max"), on);
  EXPECT_EQ(surface_nodes(surface), on);
  Surface seen_by_contact;
  seen_by_contact.faces = linear_faces(surface).faces;
  EXPECT_EQ(surface_nodes(seen_by_contact), on);
}

TEST(Surface, refusesFacesOfBothOrdersAndShells) {
  const Mesh zoo = test::zoo();
  EXPECT_THROW(extract_surface(zoo, zoo.sidesets[0]), InputError);
  Mesh shell = one_element(ElementType::quad4);
  EXPECT_THROW(extract_surface(shell, {"s", 1, {{0, 0, 1}}}), InputError);
}

}  // namespace
}  // namespace cbr::surface_test
