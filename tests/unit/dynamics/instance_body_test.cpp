// SPDX-License-Identifier: GPL-3.0-or-later
// Which body an instance becomes, and what cannot be.
#include <gtest/gtest.h>

#include <string>

#include "common/base/error.hpp"
#include "dynamics/motion/coupled/coupled_body.hpp"
#include "dynamics/motion/modal/modal_body.hpp"
#include "dynamics/motion/nodal/mesh_body.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::instance_body_test {
namespace {

const std::string skin =
    "skin: {surfaces: [x_max], youngs_modulus: 10, poissons_ratio: 0.3, density: 2, thickness: "
    "0.1}\n";
const std::string idle_skin =
    "skin: {surfaces: [x_max], youngs_modulus: 0, poissons_ratio: 0.3, density: 0, thickness: "
    "0.1}\n";
const std::string held = "boundary: [{instance: a, nodes: x_min, fix: [x]}]\n";

struct Case {
  std::string as, integrator, more, reduction;
  std::optional<Index> diagonal_limit;
};

// `more`: further keys of a and of b; both are blocks on a tilted wall.
test::Ran place(const std::string& a, const std::string& b, const std::string& as = "mesh") {
  test::SceneFolder folder;
  folder.add("part.exo", test::block_mesh({{2, 2, 2}, Vector3(1, 0.6, 0.8)}));
  return folder.prepare(
      "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
      "components: {part: {mesh: part.exo, material: m, reduction: {interface: [z_min, z_max], "
      "modes: 5}}}\n"
      "instances:\n  a: {component: part, as: " +
      as + ", " + a + "}\n  b: {component: part, as: " + as + ", " + b +
      "}\nwalls: {floor: {plane: {point: [0, 0, -2], normal: [0, 3, 4]}}, ball: {sphere: {center: "
      "[0, 0, 0], radius: 1}}}\ntime: {end: 0.1, step: 1.0e-3}\noutput: {every: 0.05}\n");
}

double smallest(const test::Ran& ran, Index body, const Vector3& point, const Vector3& normal) {
  const Points& x = ran.built.simulation.bodies[body]->reference_positions();
  return ((x.rowwise() - point.transpose()) * normal).minCoeff();
}

TEST(Place, GivesTheGapToAWallAndToAFlatSurface) {
  const Vector3 n(0, 0.6, 0.8);
  for (const char* as : {"mesh", "superelement", "rigid"}) {
    const test::Ran ran = place(
        "position: [5, 1, 1], rotation: [30, 0, 10], mirror: x, place: {on: floor, gap: 0.01}",
        "position: [0.2, 0, 0], place: {on: a.z_max, gap: 0.5}", as);
    EXPECT_NEAR(smallest(ran, 0, Vector3(0, 0, -2), n), 0.01, 1e-14) << as;
    // The far face of a is 0.8 along its turned z axis
    const Matrix3 T = ran.scene.instances[0].transformation();
    const Points& x = ran.built.simulation.bodies[0]->reference_positions();
    const Vector3 up = T.col(2);
    EXPECT_NEAR(smallest(ran, 1, Vector3::Zero(), up) - (x * up).maxCoeff(), 0.5, 1e-13) << as;
    // Along the wall a stays where its position puts it
    EXPECT_NEAR(x.col(0).mean(), (T * Vector3(0.5, 0.3, 0.4))[0] + 5, 1e-9) << as;
  }
}

TEST(Place, BadPlacesAreRefused) {
  const auto refusal = [](const std::string& a, const std::string& b = "position: [5, 0, 0]") {
    return test::refusal_of([&] { place(a, b); });
  };
  const auto expect = [](const std::string& found, const std::string& words) {
    EXPECT_SAYS(found, words, "scene.yaml:");
  };
  expect(refusal("place: {on: flor}"), "'flor' found, expected a plane of 'walls'");
  expect(refusal("place: {on: a.z_max}"), "INSTANCE.SURFACE of another instance");
  expect(refusal("place: {on: b.top}"), "has no surface 'top'");
  expect(refusal("place: {on: ball}"), "is no plane");
  expect(refusal("place: {on: b.z_max}", "place: {on: floor}"), "list instance 'b' before");
  expect(refusal("place: {on: floor, gap: -1}"), "gap");
  expect(refusal("place: {gap: 1}"), "on");
}

test::Ran prepare(const Case& c) {
  test::SceneFolder folder;
  folder.diagonal_limit = c.diagonal_limit;
  folder.add("part.exo", test::block_mesh({{4, 2, 2}, Vector3(1, 0.6, 0.8)}));
  return folder.prepare(
      "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
      "components:\n  part: {mesh: part.exo, material: m, reduction: {interface: [x_min, x_max], "
      "modes: 5" +
      c.reduction + "}}\ninstances:\n  a: {component: part, as: " + c.as +
      "}\n  b: {component: part, as: " + c.as + ", position: [3, 0, 0]}\n" + c.more +
      "time: {end: 0.1, step: 1.0e-3, integrator: " + c.integrator + "}\noutput: {every: 0.05}\n");
}

std::string kind(const Body& body) {
  const std::string scheme = body.scheme() == Scheme::exact     ? "exact"
                             : body.scheme() == Scheme::newmark ? "newmark"
                                                                : "central";
  if (dynamic_cast<const ModalBody*>(&body)) return "superelement " + scheme;
  if (dynamic_cast<const CoupledBody*>(&body)) return "coupled " + scheme;
  return dynamic_cast<const MeshBody*>(&body) ? "mesh " + scheme : "?";
}

TEST(InstanceBody, IsWhatTheIntegratorAndWhatIsOnItAskFor) {
  const struct {
    Case of;
    std::string body;
  } cases[] = {
      {{"superelement", "exact", "", "", {}}, "superelement exact"},
      {{"superelement", "exact", held, "", {}}, "superelement exact"},
      {{"superelement", "exact", skin, "", {}}, "superelement exact"},
      {{"superelement", "exact", skin + held, ", domains: 2", {}}, "superelement exact"},
      {{"superelement", "exact", "", ", domains: 2", 0}, "superelement exact"},
      {{"superelement", "central-difference", "", "", {}}, "superelement central"},
      {{"superelement", "central-difference", "", "", 0}, "coupled central"},
      {{"superelement", "central-difference", held, "", 0}, "coupled central"},
      {{"superelement", "central-difference", skin, "", {}}, "coupled central"},
      {{"superelement", "central-difference", idle_skin, "", {}}, "superelement central"},
      {{"superelement", "newmark", held, "", {}}, "superelement newmark"},
      {{"superelement", "newmark", "", ", domains: 2", {}}, "superelement newmark"},
      {{"superelement", "newmark", "", ", domains: 2", 0}, "coupled newmark"},
      {{"mesh", "exact", "", "", {}}, "mesh central"},
      {{"mesh", "exact", skin, "", {}}, "coupled central"},
      {{"mesh", "exact", idle_skin + held, "", {}}, "mesh central"},
      {{"mesh", "central-difference", skin + held, "", {}}, "coupled central"},
      {{"mesh", "newmark", "", "", {}}, "coupled newmark"},
  };
  for (const auto& [of, body] : cases) {
    const test::Ran ran = prepare(of);
    for (const auto& is : ran.built.simulation.bodies)
      EXPECT_EQ(kind(*is), body) << is->name() << " as " << of.as << ", " << of.integrator
                                 << of.reduction << "\n"
                                 << of.more;
  }
}

// Shells on one instance weigh there and nowhere else: density x thickness x area.
TEST(InstanceBody, ShellsWeighOnTheirOwnInstance) {
  for (const std::string as : {"superelement", "mesh"}) {
    for (const std::string integrator : {"exact", "central-difference", "newmark"}) {
      std::string on_b = skin;
      on_b.replace(on_b.find("[x_max]"), 7, "[b.x_max]");
      const test::Ran ran = prepare({as, integrator, on_b, "", {}});
      const double volume = 0.6 * 0.8;
      EXPECT_NEAR(ran.mass("a"), volume, 1e-12);
      EXPECT_NEAR(ran.mass("b"), volume + 2 * 0.1 * 0.6 * 0.8, 1e-12);
      const auto& bodies = ran.built.simulation.bodies;
      EXPECT_GT(bodies[1]->n_dofs(), bodies[0]->n_dofs()) << "the rotations of the shells";
    }
  }
}

TEST(InstanceBody, WhatCannotBeIsRefusedWithItsPlace) {
  const auto message = [](const Case& c) -> std::string {
    return test::refusal_of([&] { prepare(c); });
  };
  const auto expect = [&](const Case& c, const std::vector<std::string>& words) {
    const std::string text = message(c);
    for (const std::string& word : words) EXPECT_SAYS(text, word) << word << " in: " << text;
  };
  const auto contact = [](const std::string& enforcement) {
    return "contact: [{between: [a.x_max, b.x_min], enforcement: " + enforcement + "}]\n";
  };
  expect({"superelement", "newmark", contact("penalty"), "", {}},
         {"yaml:7: instance 'a'", "penalty", "newmark", "enforcement: impulse"});
  expect({"superelement", "exact", skin + contact("nodal"), "", {}},
         {"yaml:8: instance 'a'", "nodal", "skin", "central-difference"});
  std::string elsewhere = skin;
  elsewhere.replace(elsewhere.find("[x_max]"), 7, "[z_max]");
  expect({"superelement", "exact", elsewhere, "", {}}, {"yaml:7: skin", "z_max", "interface"});
}

}  // namespace
}  // namespace cbr::instance_body_test
