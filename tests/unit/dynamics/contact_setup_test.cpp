// SPDX-License-Identifier: GPL-3.0-or-later
// From the contact section of a scene to pairs: who meets whom, with which faces.
#include "dynamics/setup/contact/contact_setup.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <filesystem>
#include <fstream>

#include "common/base/error.hpp"
#include "dynamics/setup/build.hpp"
#include "dynamics/setup/components/contact_faces.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/dynamics/bricks.hpp"

namespace cbr::contact_setup_test {
namespace {

// A brick whose whole boundary is in six sidesets, and parts of it in two more.
Mesh boxed_brick(std::array<Index, 3> n, const Vector3& size) {
  Mesh mesh = test::brick(n, size);
  std::vector<Sideset> six;
  for (const char* name : {"y_min", "x_max", "y_max", "x_min", "z_min", "z_max"})
    six.push_back({name, static_cast<Index>(six.size()) + 1, {}});
  Index e = 0;
  for (Index k = 0; k < n[2]; ++k)
    for (Index j = 0; j < n[1]; ++j)
      for (Index i = 0; i < n[0]; ++i, ++e) {
        const bool on[] = {j == 0, i == n[0] - 1, j == n[1] - 1, i == 0, k == 0, k == n[2] - 1};
        for (int side = 0; side < 6; ++side)
          if (on[side]) six[side].sides.push_back({0, e, side + 1});
      }
  Sideset ends{"ends", 7, six[1].sides};
  ends.sides.insert(ends.sides.end(), six[3].sides.begin(), six[3].sides.end());
  mesh.sidesets = six;
  mesh.sidesets.push_back(ends);
  mesh.sidesets.push_back({"x_max again", 8, six[1].sides});
  mesh.sidesets.back().sides.push_back(six[1].sides.front());
  return mesh;
}

class ContactSetup : public ::testing::Test {
 protected:
  ContactSetup() {
    write_mesh(boxed_brick({3, 2, 2}, Vector3(1.5, 1, 1)), folder_ / "coarse.msh");
    write_mesh(boxed_brick({4, 4, 4}, Vector3(1, 1, 1)), folder_ / "fine.msh");
    Mesh bare = test::brick({1, 1, 1}, Vector3(1, 1, 1));
    bare.sidesets.clear();
    write_mesh(bare, folder_ / "bare.msh");
  }

  std::string scene(const std::string& contact, const std::string& instances,
                    const std::string& walls = "") const {
    const std::filesystem::path file = folder_ / "scene.yaml";
    std::ofstream(file)
        << "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.25, density: 1}}\n"
           "components:\n"
        << "  coarse: {mesh: coarse.msh, material: m}\n  fine: {mesh: fine.msh, material: m}\n"
        << "  bare: {mesh: bare.msh, material: m}\n"
        << "instances: {" << instances << "}\n"
        << walls << "contact: " << contact << "\ntime: {end: 1}\n";
    return file.string();
  }

  BuiltScene built(const std::string& contact, const std::string& instances,
                   const std::string& walls = "") const {
    Report report("test", Verbosity::quiet);
    return build(read_scene(scene(contact, instances, walls)), report);
  }

  void expect_refused(const std::string& contact, const std::string& instances,
                      const std::string& part) const {
    EXPECT_SAYS(test::refusal_of([&] { built(contact, instances); }), part, "scene.yaml:7: ");
  }

  test::TemporaryFolder folder_;
};

std::vector<std::string> names(const BuiltScene& built) {
  std::vector<std::string> list;
  for (const ContactPair& pair : built.simulation.pairs) list.push_back(pair.name);
  return list;
}

const std::string three =
    "a: {component: coarse}, b: {component: fine, position: [2, 0, 0]}, "
    "c: {component: coarse, position: [9, 0, 0], rotation: [20, 30, 40], mirror: y}";
const std::string two_walls =
    "walls: {floor: {plane: {point: [0, 0, -1], normal: [0, 0, 1]}}, "
    "ball: {sphere: {center: [0, 0, 9], radius: 1}}}\n";

// Sum of area vectors, and volume by the divergence theorem.
std::pair<Vector3, double> area_and_volume(const BuiltScene& built, const ContactSurface& surface) {
  const ContactNodes& contact = built.simulation.contact_nodes[surface.body];
  const Points X =
      built.simulation.bodies[contact.body]->reference_positions()(contact.nodes, Eigen::all);
  Vector3 area = Vector3::Zero();
  double volume = 0;
  for (Index f = 0; f < surface.faces.rows(); ++f) {
    const FaceCorners x = corners(surface, f, X);
    const Vector3 a = 0.5 * (x[2] - x[0]).cross(x[3] - x[1]);
    area += a;
    volume += a.dot(x[0] + x[1] + x[2] + x[3]) / 12;
  }
  return {area, volume};
}

TEST_F(ContactSetup, allJoinsTheSurfacesOfEveryInstanceAndMeetsEveryOther) {
  const BuiltScene scene = built("all", three);
  EXPECT_EQ(names(scene),
            (std::vector<std::string>{"a.all - b.all", "a.all - c.all", "b.all - c.all"}));
  // What is not a pair's own is there once
  EXPECT_EQ(scene.simulation.pairs[0].master, scene.simulation.pairs[1].slave);
  EXPECT_EQ(scene.simulation.pairs[0].source, scene.simulation.pairs[2].source);
  for (const ContactPair& pair : scene.simulation.pairs) {
    EXPECT_FALSE(pair.has_state());
    for (const ContactSurface* surface : {pair.slave.get(), pair.master.get()}) {
      const bool fine = surface->name == "b.all";
      EXPECT_EQ(surface->faces.rows(), fine ? 96 : 32) << surface->name;  // each once
      EXPECT_EQ(surface->nodes.size(), fine ? 98u : 34u) << surface->name;
      const auto [area, volume] = area_and_volume(scene, *surface);
      EXPECT_LT(area.norm(), 1e-13) << surface->name;
      EXPECT_NEAR(volume, fine ? 1 : 1.5, 1e-13) << surface->name;  // outward, mirrored or not
    }
    EXPECT_LE(pair.slave->size, pair.master->size * (1 + 1e-6));
    EXPECT_EQ(pair.slave_is_first, pair.slave->name == pair.name.substr(0, 5));
  }
}

TEST_F(ContactSetup, optionsHoldForAllAndGiveWayToAnExplicitEntry) {
  const BuiltScene scene = built(
      "[{between: [b.x_min, a.ends], enforcement: penalty, formulation: two-way, damping: 0.5}, "
      "{between: all, enforcement: penalty, damping: 0.25, adjust: 0.125}]",
      three);
  EXPECT_EQ(names(scene),
            (std::vector<std::string>{"b.x_min - a.ends", "a.all - c.all", "b.all - c.all"}));
  for (const ContactPair& pair : scene.simulation.pairs) {
    const bool is_explicit = &pair == &scene.simulation.pairs[0];
    EXPECT_EQ(pair.enforcement, Enforcement::penalty);
    EXPECT_EQ(pair.formulation, is_explicit ? Formulation::two_way : Formulation::node_face);
    EXPECT_EQ(pair.penalty.damping, is_explicit ? 0.5 : 0.25);
    EXPECT_EQ(pair.adjust.value_or(-1), is_explicit ? -1 : 0.125);
  }
  const ContactPair& pair = scene.simulation.pairs[0];
  EXPECT_EQ(pair.slave->name, "b.x_min");  // the finer
  EXPECT_TRUE(pair.slave_is_first);
  EXPECT_EQ(pair.master->faces.rows(), 8);
  // The nodes of one body are tracked once: those of its joined surfaces
  EXPECT_EQ(scene.simulation.contact_nodes.size(), 3u);
}

TEST_F(ContactSetup, bodiesOnTheWrongSideOfAWallAreRefusedOrLeftOut) {
  const std::string wrong = "walls: {floor: {plane: {point: [0, 0, 50], normal: [0, 0, 1]}}}\n";
  const BuiltScene all = built("all", three, wrong);
  for (const ContactPair& pair : all.simulation.pairs)
    EXPECT_FALSE(pair.wall != nullptr) << pair.name;
  ASSERT_FALSE(all.notes.empty());
  EXPECT_SAYS(all.notes.front(), "deep in the wall");
  EXPECT_SAYS(test::refusal_of([&] { built("[{between: [floor, b.z_min]}]", three, wrong); }),
              "normal", "scene.yaml:");
}

TEST_F(ContactSetup, wallsArePartnersAndMeetAllInstances) {
  const BuiltScene scene = built(
      "[{between: [floor, b.z_min], friction: 0}, {between: all, adjust: 0.25}]", three, two_walls);
  EXPECT_EQ(names(scene),
            (std::vector<std::string>{"b.z_min - floor", "a.all - b.all", "a.all - c.all",
                                      "a.all - floor", "a.all - ball", "b.all - c.all",
                                      "b.all - ball", "c.all - floor", "c.all - ball"}));
  for (const ContactPair& pair : scene.simulation.pairs) {
    const bool is_explicit = &pair == &scene.simulation.pairs[0];
    EXPECT_EQ(pair.wall != nullptr, pair.name.ends_with("floor") || pair.name.ends_with("ball"))
        << pair.name;
    EXPECT_EQ(pair.adjust.value_or(0), is_explicit ? 0 : 0.25);
    if (!pair.wall) continue;
    EXPECT_EQ(pair.wall->name(), pair.master->name);
    EXPECT_EQ(pair.master->body, pair.slave->body);
    EXPECT_EQ(pair.master->faces.rows(), 0);
    EXPECT_EQ(pair.master->size, pair.slave->size);
    EXPECT_TRUE(pair.slave_is_first);
  }
  EXPECT_EQ(names(built("all", "a: {component: fine}", two_walls)).size(), 2u);
}

// Of three blocks two touch: those are tied, the third flies by itself, and no two of it is an
// error.
TEST_F(ContactSetup, allTiesWhatLiesTogether) {
  const std::string pair = "a: {component: coarse}, b: {component: fine, position: [1.5, 0, 0]}",
                    far = ", c: {component: fine, position: [9, 0, 0], velocity: [1, 0, 0]}";
  BuiltScene scene = built("[{between: all, tied: true}]", pair + far);
  EXPECT_EQ(scene.simulation.pairs.size(), 3u);
  RunOptions options;
  const RunResult result = run(scene.simulation, options);
  // the finer side's nodes on the face
  EXPECT_EQ(scene.simulation.pairs[0].seen().ties.points.size(), 25u);
  EXPECT_FALSE(scene.simulation.pairs[1].has_state() || scene.simulation.pairs[2].has_state());
  EXPECT_NEAR(test::row(result.bodies[2].center_of_mass, result.time.size() - 1)[0], 10.5, 1e-9);
  for (const char* tied :
       {"[{between: all, tied: true}]", "[{between: [b.x_min, c.x_max], tied: true}]"}) {
    BuiltScene none = built(tied, "b: {component: fine}" + far);
    EXPECT_SAYS(test::refusal_of([&] { run(none.simulation); }), "scene.yaml:7: contact",
                "give adjust a length");
  }
}

TEST_F(ContactSetup, tiedInstancesMeetByWhatIsNotTied) {
  const std::string touching =
      "a: {component: coarse}, b: {component: fine, position: [1.5, 0, 0]}";
  const BuiltScene scene =
      built("[{between: [a.x_max, b.x_min], tied: true}, {between: all}]", touching);
  ASSERT_EQ(names(scene), (std::vector<std::string>{"a.x_max - b.x_min", "a.all - b.all"}));
  const ContactPair& pair = scene.simulation.pairs[1];
  for (const ContactSurface* surface : {pair.slave.get(), pair.master.get()}) {
    const bool fine = surface->name == "b.all";
    EXPECT_EQ(surface->faces.rows(), fine ? 80 : 28);
    EXPECT_EQ(surface->nodes.size(), fine ? 73u : 25u);
    EXPECT_EQ(surface->ridge->nodes.size(), fine ? 28u : 16u);  // edges but for those of the tie
  }
  // Pulled together, or in contact by surfaces that are named: nothing else meets
  EXPECT_EQ(built("[{between: [a.x_max, b.x_min], friction: 0.1}, {between: all}]", touching)
                .simulation.pairs.size(),
            1u);
}

TEST_F(ContactSetup, facesThatASidesetNamesTwiceAreThereOnce) {
  const BuiltScene scene = built("[{between: ['a.x_max again', b.x_min]}]", three);
  EXPECT_EQ(scene.simulation.pairs[0].master->faces.rows(), 4);
  EXPECT_FALSE(scene.simulation.pairs[0].slave_is_first);
}

TEST_F(ContactSetup, surfacesOfOneInstanceMayMeetUnlessTheyShareNodes) {
  const BuiltScene scene = built("[{between: [a.x_min, a.x_max]}]", three);
  EXPECT_EQ(scene.simulation.contact_nodes.size(), 1u);
  EXPECT_EQ(scene.simulation.pairs[0].slave->body, scene.simulation.pairs[0].master->body);
  expect_refused("[{between: [a.x_min, a.y_max]}]", three,
                 "a.x_min and a.y_max: the surfaces share 3 nodes of one instance");
  expect_refused("[{between: [a.x_min, a.ends]}]", three, "share 9 nodes");
}

TEST_F(ContactSetup, whatAllCannotPairIsRefused) {
  expect_refused("all", "a: {component: fine}",
                 "contact: all finds no pair: 1 instances with surfaces and 0 rigid walls");
  expect_refused("all", "a: {component: fine}, b: {component: bare}", "1 instances with surfaces");
  expect_refused("[{between: [a.x_mix, b.x_min]}]", three, "instance 'a' has no surface 'x_mix'");
  EXPECT_EQ(built("all", three + ", d: {component: bare}").simulation.pairs.size(), 3u);
}

}  // namespace
}  // namespace cbr::contact_setup_test
