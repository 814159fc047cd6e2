// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes of shells, alone and on solids, and scenes with them.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "dynamics/setup/modal/scene_modes.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/restarted_run.hpp"
#include "tests/support/scene_run.hpp"
#include "tests/support/shell_mesh.hpp"

namespace cbr::test::shelled {

// Blocks `name` (and name_tri for mixed grids), with nodesets of the grid's edges x_0, x_1, y_0,
// y_1 and of its corner.
inline void add_grid(Faces kind, Index n_x, Index n_y,
                     const std::function<Vector3(double, double)>& map, const std::string& name,
                     Mesh& mesh) {
  const ShellMesh grid = shell_grid(kind, n_x, n_y, map);
  const Index first = mesh.coordinates.rows();
  mesh.coordinates.conservativeResize(first + grid.X.rows(), 3);
  mesh.coordinates.bottomRows(grid.X.rows()) = grid.X;
  for (Index i = 0; i < grid.X.rows(); ++i) mesh.node_ids.push_back(first + i + 1);
  Index element = 0;
  for (const Block& block : mesh.blocks) element += block.connectivity.rows();
  Block quads{name, static_cast<Index>(mesh.blocks.size()) + 1, ElementType::quad4, {}, {}};
  Block triangles{
      name + (kind == Faces::mixed ? "_tri" : ""), quads.id + 1, ElementType::tri3, {}, {}};
  for (Index f = 0; f < grid.faces.rows(); ++f) {
    const bool is_triangle = grid.faces(f, 2) == grid.faces(f, 3);
    Block& block = is_triangle ? triangles : quads;
    const Index row = block.connectivity.rows(), n = is_triangle ? 3 : 4;
    block.connectivity.conservativeResize(row + 1, n);
    block.connectivity.row(row) = grid.faces.row(f).head(n).array() + first;
    block.element_ids.push_back(++element);
  }
  for (Block& block : {std::ref(quads), std::ref(triangles)})
    if (block.connectivity.rows() > 0) mesh.blocks.push_back(block);
  const auto add_set = [&](const std::string& set, const auto& is_in) {
    Nodeset nodes{set, static_cast<Index>(mesh.nodesets.size()) + 1, {}};
    for (Index j = 0; j <= n_y; ++j)
      for (Index i = 0; i <= n_x; ++i)
        if (is_in(i, j)) nodes.nodes.push_back(first + j * (n_x + 1) + i);
    mesh.nodesets.push_back(nodes);
  };
  add_set("x_0", [&](Index i, Index) { return i == 0; });
  add_set("x_1", [&](Index i, Index) { return i == n_x; });
  add_set("y_0", [&](Index, Index j) { return j == 0; });
  add_set("y_1", [&](Index, Index j) { return j == n_y; });
  add_set("edges", [&](Index i, Index j) { return i % n_x == 0 || j % n_y == 0; });
  add_set("corner", [&](Index i, Index j) { return i == n_x && j == n_y; });
  add_set("tip", [&](Index i, Index j) { return i == n_x && 2 * j == n_y; });
}

inline Mesh plate(Faces kind, Index n_x, Index n_y, double l_x, double l_y) {
  Mesh mesh;
  add_grid(
      kind, n_x, n_y, [&](double x, double y) { return Vector3(l_x * x, l_y * y, 0); }, "plate",
      mesh);
  return mesh;
}

// Steel, 10 mm thick.
inline constexpr double E = 2.1e11, nu = 0.3, rho = 7850, t = 0.01;
inline const double D = E * t * t * t / 12 / (1 - nu * nu);

struct Shelled {
  std::string mesh = "plate.exo", thickness = text(t), mass = "consistent", nu = "0.3";
  std::string blocks = {}, reduction = {}, instance = {}, more = {}, output = {};
};

inline std::string yaml(const Shelled& scene) {
  const std::string blocks =
      scene.blocks.empty() ? "plate: {thickness: " + scene.thickness + "}" : scene.blocks;
  return "materials:\n  m: {youngs_modulus: 2.1e11, poissons_ratio: " + scene.nu +
         ", density: 7850}\ncomponents:\n  part: {mesh: " + scene.mesh +
         ", material: m, mass: " + scene.mass + ", blocks: {" + blocks + "}" +
         (scene.reduction.empty() ? "" : ", reduction: {" + scene.reduction + "}") +
         "}\ninstances:\n  a: {component: part" + scene.instance + "}\n" + scene.more +
         (scene.output.empty() ? "" : "output: {" + scene.output + "}\n");
}

class Shells : public ::testing::Test {
 protected:
  Vector frequencies(const Shelled& scene, Index n) {
    return scene_modes(folder.prepare(yaml(scene)).scene, n, report).instances.at(0).frequency_hz;
  }
  std::string refusal(const Shelled& scene) {
    return refusal_of([&] { folder.run(yaml(scene)); });
  }

  SceneFolder folder;
  Report report{"test", Verbosity::quiet};
};

inline double hz(double lambda, double side) {
  return lambda / (2 * std::numbers::pi * side * side) * std::sqrt(D / (rho * t));
}

inline std::string held(const std::string& set, const std::string& fix,
                        const std::string& rotations) {
  return "  - {instance: a, nodes: " + set + ", fix: " + fix +
         (rotations.empty() ? "" : ", rotations: " + rotations) + "}\n";
}

inline double last(const Series3& series, int axis) {
  return series.values[series.values.size() - 3 + static_cast<std::size_t>(axis)];
}

inline double moved(const Ran& ran, const std::string& set, int axis) {
  const Series3& series = ran.monitor(set).mean_position;
  return last(series, axis) - at(series, 0)[axis];
}

// A solid bar with plates on two of its faces. The shells share nodes with the solid and have
// material and thickness of their own.
inline Mesh covered_bar(Index n) {
  Mesh mesh = block_mesh({{4 * n, n, n}, {4, 1, 1}});
  Index element = mesh.blocks[0].connectivity.rows(), id = 2;
  for (const std::string& face : {std::string("z_min"), std::string("z_max")}) {
    const Sideset& set = mesh.sidesets[find_sideset(mesh, face)];
    Block cover{face == "z_max" ? "top" : "bottom", id++, ElementType::quad4, {}, {}};
    cover.connectivity.resize(static_cast<Index>(set.sides.size()), 4);
    for (Index f = 0; f < cover.connectivity.rows(); ++f) {
      const std::vector<Index> nodes = nodes_of_side(mesh, set.sides[f]);
      for (Index i = 0; i < 4; ++i) cover.connectivity(f, i) = nodes[i];
      cover.element_ids.push_back(++element);
    }
    mesh.blocks.push_back(cover);
  }
  return mesh;
}

}  // namespace cbr::test::shelled
