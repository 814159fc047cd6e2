// SPDX-License-Identifier: GPL-3.0-or-later
// gmsh itself, through its own writer, is the oracle for what a .msh file means.
#include <gmsh.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <cmath>

#include "common/mesh/mesh.hpp"
#include "common/mesh/surface.hpp"
#include "common/scene/scene.hpp"
#include "sample_meshes.hpp"
#include "tests/support/refusal.hpp"

namespace cbr::gmsh_mesh_test {
namespace {

using test::refusal_of;
using test::TemporaryFolder;

struct Recipe {
  std::string name;
  bool recombine = true;
  int order = 1;
  bool incomplete = false;
  double version = 4.1;
  bool binary = false;
  bool wedges = false;
};

// A box [0,2] x [0,1] x [0,1] in two halves: volumes "left", "right"; surfaces "x_max", "outer"
// (six faces, x_max among them), "inner" (between the halves); curve "edge" and point "corner".
void make_box(const Recipe& recipe, const std::filesystem::path& file) {
  gmsh::initialize(0, nullptr, false);
  gmsh::option::setNumber("General.Terminal", 0);
  gmsh::model::add("box");
  const int p = gmsh::model::geo::addPoint(0, 0, 0);
  gmsh::vectorpair line, area, right;
  gmsh::model::geo::extrude({{0, p}}, 0, 1, 0, line, {2}, {}, recipe.recombine);
  gmsh::model::geo::extrude({line[1]}, 0, 0, 1, area, {2}, {}, recipe.recombine);
  gmsh::vectorpair left;
  gmsh::model::geo::extrude({area[1]}, 1, 0, 0, left, {2}, {}, recipe.recombine || recipe.wedges);
  gmsh::model::geo::extrude({left[0]}, 1, 0, 0, right, {1}, {}, recipe.recombine || recipe.wedges);
  gmsh::model::geo::synchronize();
  const auto group = [](int dim, const std::vector<int>& tags, const std::string& name) {
    gmsh::model::setPhysicalName(dim, gmsh::model::addPhysicalGroup(dim, tags), name);
  };
  group(3, {left[1].second}, "left");
  group(3, {right[1].second}, "right");
  std::vector<int> outer = {area[1].second, right[0].second};
  for (std::size_t i = 2; i < 6; ++i) {
    outer.push_back(left[i].second);
    outer.push_back(right[i].second);
  }
  group(2, {right[0].second}, "x_max");
  group(2, outer, "outer");
  group(2, {left[0].second}, "inner");
  group(1, {line[1].second}, "edge");
  group(0, {p}, "corner");
  gmsh::option::setNumber("Mesh.ElementOrder", recipe.order);
  gmsh::option::setNumber("Mesh.SecondOrderIncomplete", recipe.incomplete ? 1 : 0);
  gmsh::model::mesh::generate(3);
  gmsh::option::setNumber("Mesh.MshFileVersion", recipe.version);
  gmsh::option::setNumber("Mesh.Binary", recipe.binary ? 1 : 0);
  gmsh::write(file.string());
  gmsh::finalize();
}

std::vector<Recipe> recipes() {
  std::vector<Recipe> all;
  for (const double version : {2.2, 4.1})
    for (const bool binary : {false, true}) {
      all.push_back({"hex8", true, 1, false, version, binary});
      all.push_back({"hex20", true, 2, true, version, binary});
      all.push_back({"hex27", true, 2, false, version, binary});
      all.push_back({"tet4", false, 1, false, version, binary});
      all.push_back({"tet10", false, 2, false, version, binary});
    }
  return all;
}

// Mid-side nodes really lie where the Exodus order says.
void expect_straight(const Mesh& mesh, const Block& block) {
  for (Index e = 0; e < block.connectivity.rows(); ++e) {
    Points X(block.connectivity.cols(), 3);
    for (Index i = 0; i < X.rows(); ++i) X.row(i) = mesh.coordinates.row(block.connectivity(e, i));
    EXPECT_LT((test::element_points(block.type, X.topRows(n_corners(block.type))) - X)
                  .cwiseAbs()
                  .maxCoeff(),
              1e-11);
  }
}

// Vector area of all faces of a sideset, from the corners.
Vector3 vector_area(const Mesh& mesh, const Sideset& set) {
  const Surface surface = extract_surface(mesh, set);
  Vector3 area = Vector3::Zero();
  for (Index f = 0; f < surface.n_faces(); ++f)
    for (Index i = 1; i + 1 < n_corners(surface.kind); ++i) {
      const auto p = [&](Index j) -> Vector3 {
        return mesh.coordinates.row(surface.faces(f, j)).transpose();
      };
      area += 0.5 * (p(i) - p(0)).cross(p(i + 1) - p(0));
    }
  return area;
}

TEST(GmshMesh, readsWhatGmshWritesInEveryFormat) {
  const TemporaryFolder folder;
  for (const auto& recipe : recipes()) {
    SCOPED_TRACE(recipe.name + (recipe.binary ? " binary " : " text ") +
                 std::to_string(recipe.version));
    make_box(recipe, folder / "box.msh");
    const Mesh mesh = read_mesh(folder / "box.msh");
    ASSERT_EQ(mesh.blocks.size(), 2U);
    EXPECT_EQ(mesh.blocks[0].name, "left");
    EXPECT_EQ(mesh.blocks[1].name, "right");
    for (const auto& block : mesh.blocks) {
      EXPECT_EQ(name(block.type), recipe.name);
      const Index per_cube = recipe.recombine ? 1 : 6;
      EXPECT_GE(block.connectivity.rows(),
                (block.name == "left" ? 8 : 4) * std::min<Index>(per_cube, 5));
      expect_straight(mesh, block);
    }
    ASSERT_EQ(mesh.sidesets.size(), 3U);
    EXPECT_LT(
        (vector_area(mesh, mesh.sidesets[find_sideset(mesh, "x_max")]) - Vector3(1, 0, 0)).norm(),
        1e-12);
    EXPECT_LT(vector_area(mesh, mesh.sidesets[find_sideset(mesh, "outer")]).norm(), 1e-12);
    EXPECT_NEAR(std::abs(vector_area(mesh, mesh.sidesets[find_sideset(mesh, "inner")]).x()), 1,
                1e-12);
    const auto x_max = set_nodes(mesh, "x_max");
    for (const Index node : x_max) EXPECT_EQ(mesh.coordinates(node, 0), 2);
    EXPECT_EQ(set_nodes(mesh, "edge").size(), recipe.order == 1 ? 3U : 5U);
    const auto corner = set_nodes(mesh, "corner");
    ASSERT_EQ(corner.size(), 1U);
    EXPECT_EQ(mesh.coordinates.row(corner[0]).norm(), 0);
  }
}

TEST(GmshMesh, readsWedgesOfSecondOrder) {
  const TemporaryFolder folder;
  make_box({"wedge15", false, 2, true, 4.1, true, true}, folder / "box.msh");
  const Mesh mesh = read_mesh(folder / "box.msh");
  ASSERT_EQ(name(mesh.blocks.at(0).type), "wedge15");
  for (const auto& block : mesh.blocks) expect_straight(mesh, block);
  EXPECT_LT(
      (vector_area(mesh, mesh.sidesets[find_sideset(mesh, "x_max")]) - Vector3(1, 0, 0)).norm(),
      1e-12);
}

TEST(GmshMesh, everyFormatGivesTheSameMesh) {
  const TemporaryFolder folder;
  make_box({"hex20", true, 2, true, 4.1, false}, folder / "a.msh");
  make_box({"hex20", true, 2, true, 4.1, true}, folder / "b.msh");
  // gmsh writes 16 digits
  test::expect_equal(read_mesh(folder / "a.msh"), read_mesh(folder / "b.msh"), 1e-15);
}

TEST(GmshMesh, writtenAndReadBackIsTheSame) {
  const TemporaryFolder folder;
  Mesh zoo = test::zoo();
  zoo.coordinates *= M_PI / 3;  // no short decimals
  write_mesh(zoo, folder / "zoo.msh");
  test::expect_equal(zoo, read_mesh(folder / "zoo.msh"));
  const std::string first = test::bytes_of(folder / "zoo.msh");
  write_mesh(zoo, folder / "zoo.msh");
  EXPECT_EQ(first, test::bytes_of(folder / "zoo.msh"));
  EXPECT_EQ(folder.n_entries(), 1U);
}

TEST(GmshMesh, gmshReadsWhatWeWrite) {
  const TemporaryFolder folder;
  const Mesh zoo = test::zoo();
  write_mesh(zoo, folder / "zoo.msh");
  gmsh::initialize(0, nullptr, false);
  gmsh::option::setNumber("General.Terminal", 0);
  gmsh::open((folder / "zoo.msh").string());
  std::vector<std::size_t> tags, nodes;
  std::vector<double> coordinates, parametric;
  gmsh::model::mesh::getNodes(tags, coordinates, parametric);
  EXPECT_EQ(static_cast<Index>(tags.size()), zoo.coordinates.rows());
  for (const auto& block : zoo.blocks) {
    SCOPED_TRACE(block.name);
    int type = 0;
    gmsh::model::mesh::getElement(static_cast<std::size_t>(block.element_ids[0]), type, nodes);
    EXPECT_EQ(static_cast<Index>(nodes.size()), block.connectivity.cols());
    // gmsh's own notion of the element: no inverted Jacobian at any point where it looks. Wrong
    // mid-side nodes fold it.
    std::vector<double> jacobians, determinants, points, at, weights;
    gmsh::model::mesh::getIntegrationPoints(type, "Gauss4", at, weights);
    gmsh::model::mesh::getJacobian(static_cast<std::size_t>(block.element_ids[0]), at, jacobians,
                                   determinants, points);
    double volume = 0, least = 1;
    for (std::size_t i = 0; i < determinants.size(); ++i) {
      volume += weights[i] * determinants[i];
      least = std::min(least, determinants[i]);
    }
    EXPECT_GT(least, 0);
    EXPECT_GT(volume, 0);
  }
  gmsh::vectorpair groups;
  gmsh::model::getPhysicalGroups(groups);
  EXPECT_EQ(groups.size(), zoo.blocks.size() + zoo.sidesets.size() + zoo.nodesets.size());
  gmsh::finalize();
}

TEST(GmshMesh, flippedBytesNeverCrash) {
  const TemporaryFolder folder;
  for (const double version : {2.2, 4.1})
    for (const bool binary : {false, true}) {
      make_box({"hex8", true, 1, false, version, binary}, folder / "whole.msh");
      const std::string whole = test::bytes_of(folder / "whole.msh");
      int refused = 0;
      for (std::size_t i = 0; i < whole.size(); i += 19) {
        std::string damaged = whole;
        damaged[i] = static_cast<char>(damaged[i] ^ (i % 2 == 0 ? 0x80 : 0x03));
        test::write_bytes(folder / "d.msh", damaged);
        try {
          read_mesh(folder / "d.msh");
        } catch (const InputError&) {
          ++refused;
        }
      }
      EXPECT_GT(refused, 10);
    }
}

TEST(GmshMesh, overlappingSidesetsAndSkinsSurviveTheRoundTrip) {
  const TemporaryFolder folder;
  Mesh mesh = test::brick(3, 2, 2);
  Sideset both{"both", 7, mesh.sidesets[0].sides};
  both.sides.insert(both.sides.end(), mesh.sidesets[1].sides.begin(), mesh.sidesets[1].sides.end());
  both.sides.push_back({0, 0, 2});  // an inner face, seen from its first element
  both.sides.push_back({0, 4, 4});  // and one seen from its second
  mesh.sidesets.push_back(both);
  mesh.sidesets.push_back({"x_max again", 8, mesh.sidesets[1].sides});
  const Surface contact = extract_surface(mesh, mesh.sidesets[1]);
  mesh.blocks.push_back(
      {"skin.x_max", 20, ElementType::quad4, contact.faces, {101, 102, 103, 104}});
  mesh.nodesets = {{"a", 1, {0, 1, 5}}, {"b", 2, {1, 5, 9}}, {"x_max", 3, {4}}};
  write_mesh(mesh, folder / "brick.msh");
  test::expect_equal(mesh, read_mesh(folder / "brick.msh"));
}

// Two cubes in format 2.2 as other tools write it: all faces carry one geometrical tag, groups
// differ.
std::string old_file() {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 1 \"low\"\n3 5 "
         "\"solid\"\n$EndPhysicalNames\n"
         "$Nodes\n12\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n9 0 "
         "0 2\n10 1 0 2\n11 1 1 2\n12 0 1 "
         "2\n"
         "$EndNodes\n$Elements\n7\n1 3 2 1 1 1 2 3 4\n2 3 2 2 1 9 10 11 12\n3 3 2 2 1 1 2 3 4\n4 3 "
         "2 3 1 5 6 7 8\n"
         "10 5 2 5 1 1 2 3 4 5 6 7 8\n11 5 2 5 1 5 6 7 8 9 10 11 12\n12 5 2 6 1 5 6 7 8 9 10 11 "
         "12\n$EndElements\n";
}

TEST(GmshMesh, format2KeepsTheGroupOfEachElement) {
  const TemporaryFolder folder;
  test::write_bytes(folder / "old.msh", old_file());
  const Mesh mesh = read_mesh(folder / "old.msh");
  ASSERT_EQ(mesh.blocks.size(), 1U);  // the element repeated for group 6 stays in group 5
  EXPECT_EQ(mesh.blocks[0].element_ids, (std::vector<Index>{10, 11}));
  ASSERT_EQ(mesh.sidesets.size(), 3U);
  EXPECT_EQ(mesh.sidesets[find_sideset(mesh, "low")].sides, (std::vector<Side>{{0, 0, 5}}));
  EXPECT_EQ(mesh.sidesets[find_sideset(mesh, "2")].sides,
            (std::vector<Side>{{0, 1, 6}, {0, 0, 5}}));
  // Between the cubes: the face's node order looks up, out of the lower cube.
  EXPECT_EQ(mesh.sidesets[find_sideset(mesh, "surface_3")].sides, (std::vector<Side>{{0, 0, 6}}));
}

std::string replaced(std::string text, const std::string& old, const std::string& by) {
  const auto at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return text.replace(at, old.size(), by);
}

TEST(GmshMesh, refusesByName) {
  const TemporaryFolder folder;
  const auto file = folder / "bad.msh";
  const auto fault = [&](const std::string& text) {
    test::write_bytes(file, text);
    const auto message = refusal_of([&] { read_mesh(file); });
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_EQ(message.rfind(file.string() + ": ", 0), 0U) << message;
    return message;
  };
  const auto has = [](const std::string& message, const std::string& part) {
    EXPECT_SAYS(message, part);
  };
  has(refusal_of([&] { read_mesh(folder / "none.msh"); }), "no such file");
  has(refusal_of([&] { read_mesh(folder / "mesh.stl"); }), ".stl");
  has(fault(""), "empty");
  has(fault("Point(1) = {0,0,0};\n"), "not a gmsh mesh");
  has(fault("\x7f\x45LF\1\2"), "not a gmsh mesh");
  has(fault(old_file() + "$Nodes\n1\n1 0 0 0\n$EndNodes\n"), "section $Nodes appears twice");
  has(fault("$NOD\n1\n1 0 0 0\n$ENDNOD\n"), "format 1");
  for (const char* version : {"1", "3", "4", "5"})
    has(fault(replaced(old_file(), "2.2 0 8", std::string(version) + " 0 8")), "2.2 and 4.1");
  has(fault(replaced(old_file(), "2.2 0 8", "2.2 0 4")), "data size");
  has(fault(replaced(old_file(), "1 3 2 1 1 1 2 3 4", "1 3 2 1 1 1 2 3 99")), "99");
  has(fault(replaced(old_file(), "11 5 2", "10 5 2")), "10 is used twice");
  has(fault(replaced(old_file(), "2 1 0 0\n", "1 1 0 0\n")), "");
  has(fault(replaced(old_file(), "$Nodes\n12", "$Nodes\n14")), "");
  has(fault(replaced(old_file(), "$Nodes\n12", "$Nodes\n99999999999")), "$Nodes");
  has(fault(replaced(old_file(), "$Elements\n7", "$Elements\n8")), "$Elements");
  has(fault(replaced(old_file(), "10 5 2 5 1 1 2 3 4 5 6 7 8", "10 5 2 5 1 1 2 3 4 5 6 7 x")), "x");
  has(fault(replaced(old_file(), "10 5 2 5 1 1 2 3 4 5 6 7 8",
                     "10 13 2 5 1 1 2 3 4 5 6 7 8 9 10 11 12 1 2 3 4 5 6")),
      "Prism 18");
  // Half of a surface on the solid, half not.
  has(fault(replaced(old_file(), "2 3 2 2 1 9 10 11 12", "2 3 2 1 1 9 10 2 12")), "'low'");
  EXPECT_EQ(folder.n_entries(), 1U);
}

TEST(GmshMesh, aByteOrderMarkIsSkipped) {
  const TemporaryFolder folder;
  test::write_bytes(folder / "plain.msh", old_file());
  test::write_bytes(folder / "marked.msh", "\xEF\xBB\xBF" + old_file());
  test::expect_equal(read_mesh(folder / "marked.msh"), read_mesh(folder / "plain.msh"));
  std::vector<std::string> said;
  for (const char* name : {"wide.msh", "wide.inp", "wide.bdf", "wide.unv"}) {
    test::write_bytes(folder / name, std::string("\xFE\xFF\0$", 4));
    said.push_back(refusal_of([&] { read_mesh(folder / name); }));
  }
  said.push_back(refusal_of([&] { read_scene((folder / "wide.msh").string()); }));
  for (const std::string& message : said) EXPECT_SAYS(message, ": is UTF-16: save it as UTF-8");
}

TEST(GmshMesh, cutShortIsAnErrorOrNothingIsMissing) {
  const TemporaryFolder folder;
  std::vector<std::filesystem::path> files;
  for (const double version : {2.2, 4.1})
    for (const bool binary : {false, true}) {
      files.push_back(folder / ("whole" + std::to_string(files.size()) + ".msh"));
      make_box({"hex8", true, 1, false, version, binary}, files.back());
    }
  files.push_back(folder / "ours.msh");
  write_mesh(test::zoo(), files.back());
  for (const auto& file : files) {
    const std::string whole = test::bytes_of(file);
    const Mesh mesh = read_mesh(file);
    int refused = 0;
    for (std::size_t i = 0; i <= 50; ++i) {
      test::write_bytes(folder / "cut.msh", whole.substr(0, whole.size() * i / 51));
      try {
        test::expect_equal(read_mesh(folder / "cut.msh"), mesh);
      } catch (const InputError&) {
        ++refused;
      }
    }
    EXPECT_GE(refused, 45);
  }
}

}  // namespace
}  // namespace cbr::gmsh_mesh_test
