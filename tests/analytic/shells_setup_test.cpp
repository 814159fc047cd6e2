// SPDX-License-Identifier: GPL-3.0-or-later
// Shells as parts of a mesh: their sets, hinges that are told, and what is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "common/fem/shell_model.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/shelled_scene.hpp"

namespace cbr::shells_setup_test {
namespace {

using namespace test::shelled;
using test::Faces;

// A fin on one line of a solid is hinged, which is told; a ring of shells, or a cover, is not.
TEST_F(Shells, HingesOnSolidsAreTold) {
  Mesh mesh = test::block_mesh({{2, 1, 1}});
  const Index n = mesh.coordinates.rows();
  const std::vector<Index> top = set_nodes(mesh, "z_max");
  std::vector<Index> line;
  for (const Index node : top)
    if (mesh.coordinates(node, 1) == 0) line.push_back(node);
  ASSERT_EQ(line.size(), 3u);
  mesh.coordinates.conservativeResize(n + 3, 3);
  Block fin{"fin", 9, ElementType::quad4, IndexTable(2, 4), {91, 92}};
  for (Index i = 0; i < 3; ++i) {
    mesh.coordinates.row(n + i) = mesh.coordinates.row(line[i]);
    mesh.coordinates(n + i, 2) += 0.5;
    mesh.node_ids.push_back(1000 + i);
  }
  fin.connectivity << line[0], line[1], n + 1, n, line[1], line[2], n + 2, n + 1;
  mesh.blocks.push_back(fin);
  FiniteElementModel model;
  number_nodes(mesh, model);
  EXPECT_EQ(hinged_shells(mesh, model), "");  // no thickness: no shells
  mesh.blocks.back().thickness = 0.1;
  number_nodes(mesh, model);
  EXPECT_EQ(model.n_rotations, 6);
  const std::string text = hinged_shells(mesh, model);
  EXPECT_EQ(text.find("shells of block 'fin' share 3 nodes with solids, all on one line"), 0u)
      << text;
  mesh = covered_bar(1);
  for (Block& block : mesh.blocks)
    if (dimension(block.type) == 2) block.thickness = 0.1;
  number_nodes(mesh, model);
  EXPECT_EQ(hinged_shells(mesh, model), "");
}

// Faces of a block are surfaces of both senses, and sidesets of edges are nodesets.
TEST_F(Shells, FacesAndEdgesAreSets) {
  Mesh mesh = plate(Faces::quads, 2, 1, 2, 1);
  mesh.sidesets.push_back({"rim", 7, {{0, 0, 3}, {0, 1, 3}}});
  mesh.sidesets.push_back({"half", 8, {{0, 1, 2}}});
  folder.add("plate.exo", mesh);
  Component component;
  component.name = "part";
  component.mesh = folder.folder() / "plate.exo";
  component.blocks["plate"].thickness = t;
  const Mesh read = read_mesh(component);
  EXPECT_EQ(read.blocks[0].thickness, t);
  ASSERT_EQ(read.sidesets.size(), 3u);
  EXPECT_LT(find_sideset(read, "rim"), 0);
  ASSERT_GE(find_nodeset(read, "rim"), 0);
  EXPECT_EQ(set_nodes(read, "rim"), (std::vector<Index>{0, 1, 2}));
  const auto sides = [&](const std::string& name) {
    return read.sidesets[find_sideset(read, name)].sides;
  };
  EXPECT_EQ(sides("plate"), (std::vector<Side>{{0, 0, 1}, {0, 1, 1}}));
  EXPECT_EQ(sides("plate.back"), (std::vector<Side>{{0, 0, 2}, {0, 1, 2}}));
  EXPECT_EQ(sides("half"), (std::vector<Side>{{0, 1, 2}}));
  component.blocks.clear();
  EXPECT_EQ(read_mesh(component).sidesets.size(), 2u);
}

// Rotations inside leave a hinge where the mesh is clamped, which is said by its word.
TEST_F(Shells, ACondensedEdgeIsAHinge) {
  folder.add("plate.exo", plate(Faces::quads, 4, 2, 1, 0.5));
  Shelled scene{.reduction = "interface: [x_0, x_1], condense_rotations: true, modes: 4"};
  const std::string run = "time: {end: 1e-3}\n";
  scene.more = "boundary:\n" + held("x_0", "[x, y, z]", "[x, y, z]") + run;
  EXPECT_SAYS(refusal(scene),
              "reduction.condense_rotations: true put the rotations of its shells inside");
  const auto warns = [&] {
    Report told("test", Verbosity::quiet);
    build(folder.prepare(yaml(scene)).scene, told);
    const std::vector<std::string>& all = told.warnings();
    return std::count_if(all.begin(), all.end(), [](const std::string& text) {
      return text.find("is a hinge, as reduction.condense_rotations") != std::string::npos;
    });
  };
  scene.more = "boundary:\n" + held("x_0", "[x, y, z]", "") + run;
  EXPECT_EQ(warns(), 1);
  scene.more = "boundary:\n" + held("x_0", "[x, y, z]", "") + held("x_1", "[z]", "") + run;
  scene.reduction = "interface: [x_0, x_1], modes: 4";
  EXPECT_EQ(warns(), 0);
}

TEST_F(Shells, WhatCannotBeIsRefusedByName) {
  Mesh mesh = plate(Faces::quads, 4, 4, 1, 1);
  folder.add("plate.exo", mesh);
  folder.add("bar.exo", covered_bar(2));
  const auto expect = [&](const Shelled& scene, const std::vector<std::string>& words) {
    const std::string found = refusal(scene);
    for (const std::string& word : words) EXPECT_SAYS(found, word);
  };
  const std::string run = "time: {end: 1, step: 1, static: true}\n";
  Shelled scene{.more = run};
  const auto with = [&](const auto& change) {
    Shelled changed = scene;
    change(changed);
    return changed;
  };
  expect(with([](Shelled& s) {
           s.mesh = "bar.exo";
           s.blocks = "block: {thickness: 1}";
         }),
         {"components.part.blocks.block.thickness", "hex8", "only tri3 and quad4"});
  expect(with([](Shelled& s) { s.blocks = "plate: {element: hex8}"; }),
         {"blocks.plate", "quad4", "add thickness"});
  expect(with([](Shelled& s) { s.blocks = "plat: {thickness: 1}"; }), {"no block 'plat'", "plate"});
  expect(with([](Shelled& s) { s.reduction = "interface: x_0, modes: 4, domains: 2"; }),
         {"domains", "does not know shells", "domains: 1"});
  expect(
      with([](Shelled& s) { s.reduction = "interface: x_0, condense_rotations: true, modes: 4"; }),
      {"not three that are off one line", "condense_rotations: false"});
  expect(with([](Shelled& s) {
           s.mesh = "bar.exo";
           s.blocks = "block: {element: hex8}";
           s.reduction = "interface: x_min, condense_rotations: true, modes: 4";
         }),
         {"condense_rotations", "no shells"});
  expect(with([&](Shelled& s) {
           s.mesh = "bar.exo";
           s.blocks = "block: {element: hex8}";
           s.more = "boundary:\n" + held("x_min", "[x]", "[y]") + run;
         }),
         {"boundary.rotations", "'x_min'", "leave it out"});
  expect(with([&](Shelled& s) {
           s.more =
               "skin: {surfaces: [plate], youngs_modulus: 1, poissons_ratio: 0, density: 1, "
               "thickness: 1, mesh: skinned.exo}\n" +
               run;
         }),
         {"skin", "nodes with rotations"});
}

}  // namespace
}  // namespace cbr::shells_setup_test
