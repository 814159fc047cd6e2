// SPDX-License-Identifier: GPL-3.0-or-later
#include "skinner/skin.hpp"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <map>
#include <set>

#include "skinner/placed_mesh.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/common/mesh/sample_meshes.hpp"

namespace cbr::skin_test {
namespace {

using test::refusal_of;
using test::TemporaryFolder;

Vector3 vector_area(const Points& X, const IndexTable& faces, Index f, int corners) {
  const auto p = [&](Index i) -> Vector3 { return X.row(faces(f, i)).transpose(); };
  Vector3 area = Vector3::Zero();
  for (int i = 1; i + 1 < corners; ++i) area += 0.5 * (p(i) - p(0)).cross(p(i + 1) - p(0));
  return area;
}

Vector3 vector_area(const Points& X, const Block& shells) {
  Vector3 area = Vector3::Zero();
  for (Index f = 0; f < shells.connectivity.rows(); ++f)
    area += vector_area(X, shells.connectivity, f, n_corners(shells.type));
  return area;
}

const Block& block(const Mesh& mesh, const std::string& name) {
  const Index found = find_block(mesh, name);
  EXPECT_GE(found, 0) << name;
  return mesh.blocks[std::max<Index>(found, 0)];
}

Sideset all_sides(const Mesh& mesh, Index b) {
  Sideset set{"all", 1, {}};
  for (int s = 1; s <= n_sides(mesh.blocks[b].type); ++s) set.sides.push_back({b, 0, s});
  return set;
}

// A brick with sidesets of its six faces is enough of a component; 2 x 1 x 1.
struct World {
  TemporaryFolder folder;
  Scene scene;

  World() {
    write_mesh(test::brick(2, 1, 1), folder / "brick.msh");
    scene.materials["steel"] = {1, 0.3, 1};
    Component component;
    component.name = "brick";
    component.mesh = folder / "brick.msh";
    component.material = "steel";
    component.reduction.emplace();
    component.reduction->interface_sets = {"x_max"};
    scene.components["brick"] = component;
    scene.skin.emplace();
    scene.skin->surfaces = {"x_max"};
    scene.skin->source = {"world.yaml", 9};
  }
  Instance& add(const std::string& name, InstanceKind as) {
    Instance instance;
    instance.name = name;
    instance.component = "brick";
    instance.as = as;
    scene.instances.push_back(instance);
    return scene.instances.back();
  }
};

TEST(Skin, shellsShareTheNodesOfTheSidesAndLookOutwards) {
  const Mesh zoo = test::zoo();
  const std::map<ElementType, std::vector<ElementType>> expected = {
      {ElementType::tet4, {ElementType::tri3}},
      {ElementType::tet10, {ElementType::tri6}},
      {ElementType::hex8, {ElementType::quad4}},
      {ElementType::hex20, {ElementType::quad8}},
      {ElementType::hex27, {ElementType::quad9}},
      {ElementType::wedge6, {ElementType::quad4, ElementType::tri3}},
      {ElementType::wedge15, {ElementType::quad8, ElementType::tri6}},
      {ElementType::pyramid5, {ElementType::quad4, ElementType::tri3}}};
  for (const auto& [type, shells] : expected) {
    SCOPED_TRACE(name(type));
    Mesh mesh = zoo;
    const Index b = find_block(mesh, "block of " + std::string(name(type)));
    const Sideset set = all_sides(mesh, b);
    const auto added = add_skin(mesh, extract_surface(mesh, set), "skin.all");
    ASSERT_EQ(added.size(), shells.size());
    ASSERT_EQ(mesh.blocks.size(), zoo.blocks.size() + shells.size());
    EXPECT_EQ(mesh.coordinates.rows(), zoo.coordinates.rows());
    EXPECT_NO_THROW(check_mesh(mesh, "skinned"));
    Vector3 closed = Vector3::Zero();
    Index n = 0;
    for (std::size_t i = 0; i < shells.size(); ++i) {
      const Block& skin = mesh.blocks[zoo.blocks.size() + i];
      EXPECT_EQ(skin.type, shells[i]);
      EXPECT_EQ(skin.connectivity.rows(), added[i].n_shells);
      closed += vector_area(mesh.coordinates, skin);
      n += skin.connectivity.rows();
      Vector3 center = Vector3::Zero();
      for (const Index node : mesh.blocks[b].connectivity.reshaped())
        center += mesh.coordinates.row(node).transpose() /
                  static_cast<double>(mesh.blocks[b].connectivity.cols());
      for (Index f = 0; f < skin.connectivity.rows(); ++f) {
        const Vector3 out = mesh.coordinates.row(skin.connectivity(f, 0)).transpose() - center;
        EXPECT_GT(
            vector_area(mesh.coordinates, skin.connectivity, f, n_corners(skin.type)).dot(out), 0);
      }
    }
    EXPECT_EQ(n, n_sides(type));
    EXPECT_LT(closed.norm(), 1e-14);
  }
}

TEST(Skin, ofAMeshSurvivesBothFormats) {
  const TemporaryFolder folder;
  const SkinnedMesh skinned = skin_mesh(test::brick(3, 2, 2), {"x_max", "x_min"});
  ASSERT_EQ(skinned.blocks.size(), 2U);
  EXPECT_EQ(skinned.blocks[0].name, "skin.x_max");
  EXPECT_EQ(skinned.blocks[0].n_shells, 4);
  EXPECT_EQ(skinned.blocks[0].n_nodes, 9);
  for (const char* name : {"s.msh", "s.exo"}) {
    write_mesh(skinned.mesh, folder / name);
    test::expect_equal(skinned.mesh, read_mesh(folder / name));
  }
}

TEST(Skin, refusesWhatIsNotThereAndWhatIsTwice) {
  const auto fault = [](const std::vector<std::string>& names) {
    return refusal_of([&] { skin_mesh(test::brick(1, 1, 1), names); });
  };
  EXPECT_SAYS(fault({"x_mx"}), "did you mean 'x_max'? (available: x_min, x_max)");
  EXPECT_SAYS(fault({"x_max", "x_max"}), "twice");
  Mesh once = skin_mesh(test::brick(1, 1, 1), {"x_max"}).mesh;
  EXPECT_SAYS(refusal_of([&] { skin_mesh(once, {"x_max"}); }), "already");
  Mesh empty = test::brick(1, 1, 1);
  empty.sidesets[0].sides.clear();
  EXPECT_SAYS(refusal_of([&] { skin_mesh(empty, {"x_min"}); }), "empty");
}

TEST(Place, mirroredElementsKeepPositiveVolumeAndSidesTheirFaces) {
  const Mesh zoo = test::zoo();
  for (const std::string mirror : {"", "x", "y", "z"}) {
    Instance instance;
    instance.mirror = mirror;
    instance.rotation_degrees = {20, -50, 130};
    instance.position = {3, -2, 1};
    const Mesh placed = place(zoo, instance);
    const Matrix3 T = instance.transformation();
    for (Index b = 0; b < static_cast<Index>(zoo.blocks.size()); ++b) {
      if (dimension(zoo.blocks[b].type) != 3) continue;
      SCOPED_TRACE(mirror + " " + zoo.blocks[b].name);
      // Each face goes where the map takes it, with its outward area vector: T a, whatever the
      // handedness.
      const Surface before = extract_surface(zoo, {"f", 1, {{b, 0, 1}}});
      Mesh moved = zoo;
      moved.sidesets = {{"f", 1, {{b, 0, 1}}}};
      moved = place(moved, instance);
      const Surface after = extract_surface(moved, moved.sidesets[0]);
      const int corners = n_corners(before.kind);
      EXPECT_EQ(surface_nodes(before), surface_nodes(after));
      EXPECT_LT((T * vector_area(zoo.coordinates, before.faces, 0, corners) -
                 vector_area(moved.coordinates, after.faces, 0, corners))
                    .norm(),
                1e-13);
      // Positive volume: the outward faces of the reordered element enclose its centre.
      const Block& element = placed.blocks[b];
      Points X(element.connectivity.cols(), 3);
      for (Index i = 0; i < X.rows(); ++i)
        X.row(i) = placed.coordinates.row(element.connectivity(0, i));
      EXPECT_LT((test::element_points(element.type, X.topRows(n_corners(element.type))) - X).norm(),
                1e-12);
      const Vector3 center = X.colwise().mean().transpose();
      for (int s = 1; s <= n_sides(element.type); ++s) {
        const Surface side = extract_surface(placed, {"s", 1, {{b, 0, s}}});
        const Vector3 out = placed.coordinates.row(side.faces(0, 0)).transpose() - center;
        EXPECT_GT(vector_area(placed.coordinates, side.faces, 0, n_corners(side.kind)).dot(out), 0);
      }
    }
  }
}

TEST(SkinScene, putsEveryInstanceInItsPlace) {
  World world;
  world.add("left", InstanceKind::superelement).position = {-5, 0, 0};
  auto& right = world.add("right", InstanceKind::mesh);
  right.mirror = "x";
  right.position = {5, 0, 0};
  const SkinnedMesh result = skin_scene(world.scene);
  const Mesh& mesh = result.mesh;
  EXPECT_NO_THROW(check_mesh(mesh, "system"));
  EXPECT_EQ(mesh.coordinates.rows(), 4 + 12);  // the interface of the one, all nodes of the other
  EXPECT_EQ(block(mesh, "right.solid").connectivity.rows(), 2);
  EXPECT_EQ(find_block(mesh, "left.solid"), -1);
  EXPECT_EQ(set_nodes(mesh, "left.x_max").size(), 4U);
  EXPECT_EQ(set_nodes(mesh, "right.x_max").size(), 4U);
  const Block& left_skin = block(mesh, "skin.left.x_max");
  const Block& right_skin = block(mesh, "skin.right.x_max");
  EXPECT_LT((vector_area(mesh.coordinates, left_skin) - Vector3(1, 0, 0)).norm(), 1e-15);
  EXPECT_LT((vector_area(mesh.coordinates, right_skin) - Vector3(-1, 0, 0)).norm(), 1e-15);
  for (const Index node : left_skin.connectivity.reshaped())
    EXPECT_EQ(mesh.coordinates(node, 0), -3);
  for (const Index node : right_skin.connectivity.reshaped())
    EXPECT_EQ(mesh.coordinates(node, 0), 3);
  // The right one's shells are on its solid's own nodes.
  const auto right_nodes = set_nodes(mesh, "right.x_max");
  EXPECT_EQ(std::set<Index>(right_nodes.begin(), right_nodes.end()),
            std::set<Index>(right_skin.connectivity.data(),
                            right_skin.connectivity.data() + right_skin.connectivity.size()));
  ASSERT_EQ(result.notes.size(), 1U);
  EXPECT_EQ(result.notes[0], "instance right: node ids raised by 100");
}

TEST(SkinScene, idsStayReadableAndUnique) {
  World world;
  for (const char* name : {"a", "b", "c"})
    world.add(name, InstanceKind::mesh).position = {0, 0, static_cast<double>(name[0])};
  const SkinnedMesh result = skin_scene(world.scene);
  EXPECT_NO_THROW(check_mesh(result.mesh, "system"));
  for (Index i = 0; i < 12; ++i)
    for (Index copy = 0; copy < 3; ++copy)
      EXPECT_EQ(result.mesh.node_ids[copy * 12 + i], 100 * copy + i + 1);
  EXPECT_EQ(block(result.mesh, "c.solid").element_ids, (std::vector<Index>{21, 22}));
  EXPECT_EQ(result.blocks.size(), 3U);
}

TEST(SkinScene, skinsOnlyWhatTheInterfaceKeepsAndSaysSo) {
  World world;
  world.add("part", InstanceKind::superelement);
  world.add("whole", InstanceKind::mesh);
  world.scene.skin->surfaces = {"x_max", "x_min"};
  const SkinnedMesh result = skin_scene(world.scene);
  EXPECT_GE(find_block(result.mesh, "skin.part.x_max"), 0);
  EXPECT_EQ(find_block(result.mesh, "skin.part.x_min"), -1);
  EXPECT_GE(find_block(result.mesh, "skin.whole.x_min"), 0);
  bool said = false;
  for (const auto& note : result.notes)
    said = said || note.find("part: surface x_min is left out") != std::string::npos;
  EXPECT_TRUE(said);
  world.scene.skin->surfaces = {"part.x_max"};
  EXPECT_EQ(skin_scene(world.scene).blocks.size(), 1U);
}

TEST(SkinScene, refusesByFileLineAndName) {
  World world;
  world.add("part", InstanceKind::superelement);
  world.scene.skin->surfaces = {"x_mux"};
  const auto message = refusal_of([&] { skin_scene(world.scene); });
  for (const char* piece : {"world.yaml:9", "'x_mux'", "did you mean 'x_max'", "x_max, x_min"})
    EXPECT_SAYS(message, piece);
  world.scene.skin->surfaces = {"x_min"};
  EXPECT_SAYS(refusal_of([&] { skin_scene(world.scene); }), "reduction: interface");
  world.scene.skin->surfaces = {"x_max"};
  world.scene.components["brick"].reduction->interface_sets = {"tip"};
  EXPECT_SAYS(refusal_of([&] { skin_scene(world.scene); }), "'tip'");
}

}  // namespace
}  // namespace cbr::skin_test
