// SPDX-License-Identifier: GPL-3.0-or-later
// The scripts in meshes/, run with gmsh as users run them.
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <cstdlib>

#include "common/mesh/mesh.hpp"
#include "common/mesh/surface.hpp"
#include "sample_meshes.hpp"

namespace cbr::meshes_test {
namespace {

Mesh generate(const std::string& script, const std::string& options) {
  const test::TemporaryFolder folder;
  const std::string out = (folder / "mesh.msh").string();
  const std::string command =
      "gmsh -3 -v 1 '" CBR_SOURCE_DIR "/meshes/" + script + "' " + options + " -o '" + out + "'";
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  return read_mesh(out);
}

std::size_t n_set(const Mesh& mesh, const std::string& name) {
  return set_nodes(mesh, name).size();
}

double volume(const Mesh& mesh) {
  // By the divergence theorem over `surface`.
  const Surface surface = extract_surface(mesh, mesh.sidesets[find_sideset(mesh, "surface")]);
  double six_v = 0;
  for (Index f = 0; f < surface.n_faces(); ++f)
    for (Index i = 1; i < 3; ++i) {
      const auto p = [&](Index j) -> Vector3 {
        return mesh.coordinates.row(surface.faces(f, j)).transpose();
      };
      six_v += p(0).dot(p(i).cross(p(i + 1)));
    }
  return six_v / 6;
}

// Smallest sine-like Jacobian of three unit edges over all corners.
double worst_corner(const Mesh& mesh) {
  static const int neighbours[8][3] = {{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7},
                                       {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}};
  double worst = 1;
  for (const auto& block : mesh.blocks)
    for (Index e = 0; e < block.connectivity.rows(); ++e)
      for (int i = 0; i < 8; ++i) {
        const auto edge = [&](int j) -> Vector3 {
          return (mesh.coordinates.row(block.connectivity(e, neighbours[i][j])) -
                  mesh.coordinates.row(block.connectivity(e, i)))
              .transpose()
              .normalized();
        };
        worst = std::min(worst, edge(0).cross(edge(1)).dot(edge(2)));
      }
  return worst;
}

TEST(Meshes, blockHasThePapersCounts) {
  const Mesh mesh = generate("block.geo", "");
  EXPECT_EQ(mesh.coordinates.rows(), 3696);
  ASSERT_EQ(mesh.blocks.size(), 1U);
  EXPECT_EQ(mesh.blocks[0].connectivity.rows(), 3000);
  EXPECT_EQ(mesh.blocks[0].type, ElementType::hex8);
  EXPECT_EQ(n_set(mesh, "contact"), 176U);
  EXPECT_EQ(n_set(mesh, "surface"), 1302U);
  EXPECT_NEAR(volume(mesh), 0.0508 * 0.0254 * 0.0381, 1e-15);
  EXPECT_NEAR(worst_corner(mesh), 1, 1e-9);
  for (const Index node : set_nodes(mesh, "contact"))
    EXPECT_NEAR(mesh.coordinates(node, 0), 0.0254, 1e-15);
  const char* names[] = {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"};
  const double half[] = {0.0254, 0.0127, 0.01905};
  for (int i = 0; i < 6; ++i)
    for (const Index node : set_nodes(mesh, names[i]))
      EXPECT_NEAR(mesh.coordinates(node, i / 2), (i % 2 == 0 ? -1 : 1) * half[i / 2], 1e-15)
          << names[i];
}

TEST(Meshes, blockTakesSizesAndOrder) {
  const Mesh cube = generate("block.geo",
                             "-setnumber nx 10 -setnumber ny 10 -setnumber nz 10 -setnumber lx 1 "
                             "-setnumber ly 1 -setnumber lz 1");
  EXPECT_EQ(cube.blocks[0].connectivity.rows(), 1000);
  EXPECT_EQ(n_set(cube, "surface"), 602U);
  EXPECT_NEAR(volume(cube), 1, 1e-12);
  const std::string small = "-setnumber nx 2 -setnumber ny 2 -setnumber nz 2 -setnumber order 2 ";
  EXPECT_EQ(generate("block.geo", small).blocks[0].type, ElementType::hex20);
  EXPECT_EQ(generate("block.geo", small + "-setnumber incomplete 0").blocks[0].type,
            ElementType::hex27);
}

TEST(Meshes, sphereIsRoundAndWellShaped) {
  const Mesh mesh = generate("sphere.geo", "");
  EXPECT_EQ(mesh.blocks[0].connectivity.rows(), 864);
  EXPECT_EQ(mesh.coordinates.rows(), 997);
  const auto nodes = set_nodes(mesh, "surface");
  EXPECT_EQ(nodes.size(), 218U);
  EXPECT_EQ(n_set(mesh, "contact"), 218U);
  for (const Index node : nodes) EXPECT_NEAR(mesh.coordinates.row(node).norm(), 0.0127, 1e-9);
  EXPECT_GT(worst_corner(mesh), 0.6);
  EXPECT_GT(volume(mesh), 0);
  // All nodes are used and none is doubled: interior nodes of the core, three layers of 218.
  EXPECT_EQ(mesh.coordinates.rows(), 7 * 7 * 7 + 3 * 218);
}

TEST(Meshes, loadIsThePairInTheMiddle) {
  for (const std::string options : {"", "-setnumber nx 10 -setnumber ny 5 -setnumber nz 8",
                                    "-setnumber nx 2 -setnumber ny 4 -setnumber nz 4",
                                    "-setnumber nx 2 -setnumber ny 5 -setnumber nz 7"}) {
    SCOPED_TRACE(options);
    const Mesh mesh = generate("loaded_block.geo", options);
    const Index load = find_sideset(mesh, "load");
    ASSERT_GE(load, 0);
    EXPECT_EQ(mesh.sidesets[load].sides.size(), 2U);
    EXPECT_EQ(n_set(mesh, "load"), 6U);
    EXPECT_NEAR(worst_corner(mesh), 1, 1e-9);
    EXPECT_NEAR(volume(mesh), 0.0508 * 0.0254 * 0.0381, 1e-15);
    // Of all faces of x_max none is nearer to the centre than either of the two.
    const Surface end = extract_surface(mesh, mesh.sidesets[find_sideset(mesh, "x_max")]);
    const Surface pair = extract_surface(mesh, mesh.sidesets[load]);
    const auto distances = [&](const Surface& s) {
      std::vector<double> d;
      for (Index f = 0; f < s.n_faces(); ++f) {
        Vector3 c = Vector3::Zero();
        for (Index j = 0; j < 4; ++j) c += 0.25 * mesh.coordinates.row(s.faces(f, j)).transpose();
        EXPECT_NEAR(c.x(), 0.0254, 1e-12);
        d.push_back(c.tail<2>().norm());
      }
      std::sort(d.begin(), d.end());
      return d;
    };
    const auto all = distances(end), two = distances(pair);
    EXPECT_NEAR(two[0], all[0], 1e-12);
    EXPECT_NEAR(two[1], all[1], 1e-12);
  }
  const Mesh coarse =
      generate("loaded_block.geo", "-setnumber nx 10 -setnumber ny 5 -setnumber nz 8");
  EXPECT_EQ(coarse.coordinates.rows(), 594);
  EXPECT_EQ(coarse.blocks[0].connectivity.rows(), 400);
}

}  // namespace
}  // namespace cbr::meshes_test
