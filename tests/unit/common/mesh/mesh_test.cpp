// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/mesh.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "common/base/error.hpp"
#include "sample_meshes.hpp"
#include "tests/support/refusal.hpp"

namespace cbr::mesh_test {
namespace {

using test::refusal_of;

TEST(Mesh, findsByNameAndByNumberOfAnUnnamedSet) {
  Mesh mesh = test::brick(1, 1, 1);
  EXPECT_EQ(find_sideset(mesh, "x_max"), 1);
  EXPECT_EQ(find_sideset(mesh, "2"), -1);
  mesh.sidesets[1].name = "surface_2";
  EXPECT_EQ(find_sideset(mesh, "2"), 1);
  EXPECT_EQ(find_nodeset(mesh, "2"), -1);
  mesh.nodesets = {{"nodelist_7", 7, {3}}};
  EXPECT_EQ(find_nodeset(mesh, "7"), 0);
  EXPECT_EQ(set_nodes(mesh, "7"), std::vector<Index>{3});
}

TEST(Mesh, namesWhatThereIsWhenASetIsMissing) {
  Mesh mesh = test::brick(1, 1, 1);
  mesh.nodesets = {{"clamp", 7, {3}}};
  const auto message = refusal_of([&] { set_nodes(mesh, "x_mx"); });
  for (const char* part :
       {"'x_mx'", "did you mean 'x_max'", "x_min, x_max (sidesets)", "clamp (nodesets)"})
    EXPECT_SAYS(message, part);
}

TEST(Mesh, sidesOfShellsAreFacesAndEdges) {
  const Mesh zoo = test::zoo();
  const Index b = find_block(zoo, "block of quad8");
  const Index first = zoo.blocks[b].connectivity(0, 0);
  EXPECT_EQ(nodes_of_side(zoo, {b, 0, 1}).size(), 8U);
  EXPECT_EQ(nodes_of_side(zoo, {b, 0, 2}).size(), 8U);
  EXPECT_EQ(nodes_of_side(zoo, {b, 0, 6}), (std::vector<Index>{first + 3, first, first + 7}));
  EXPECT_THROW(nodes_of_side(zoo, {b, 0, 7}), InputError);
  EXPECT_EQ(nodes_of_side(zoo, {find_block(zoo, "block of quad9"), 0, 1}).size(), 9U);
}

TEST(Mesh, checkNamesTheFault) {
  EXPECT_NO_THROW(check_mesh(test::zoo(), "zoo"));
  const auto fault = [](const std::function<void(Mesh&)>& damage) {
    Mesh mesh = test::zoo();
    damage(mesh);
    return refusal_of([&] { check_mesh(mesh, "zoo.msh"); });
  };
  EXPECT_SAYS(fault([](Mesh& m) { m.node_ids[3] = m.node_ids[1]; }),
              "zoo.msh: node id 8 is used twice");
  EXPECT_SAYS(fault([](Mesh& m) { m.blocks[1].element_ids[0] = 1000; }), "element id 1000");
  EXPECT_SAYS(
      fault([](Mesh& m) { m.coordinates(4, 1) = std::numeric_limits<double>::quiet_NaN(); }),
      "node 17");
  EXPECT_SAYS(fault([](Mesh& m) { m.blocks[10].connectivity(0, 3) = 5000; }), "hex8");
  EXPECT_SAYS(fault([](Mesh& m) { m.sidesets[0].sides[0].side = 9; }), "'all sides': side 9");
  EXPECT_SAYS(fault([](Mesh& m) { m.nodesets[0].nodes[0] = -1; }), "'corners'");
  EXPECT_SAYS(fault([](Mesh& m) { m.sidesets[1].name = "all sides"; }), "two sidesets");
}

}  // namespace
}  // namespace cbr::mesh_test
