// SPDX-License-Identifier: GPL-3.0-or-later
// Contact of faces of second order: a uniform pressure is carried, shown and measured as what it
// is, in statics, at rest in motion, and momentum is kept where bodies strike each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/app/report.hpp"
#include "tests/support/restarted_run.hpp"
#include "tests/support/scene_run.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::second_order_contact_test {
namespace {

using test::Ran;
using test::text;
using enum ElementType;

constexpr double E = 1000, pressure = 2;

// A box with sidesets low and top, normal to z.
Mesh box(ElementType type, const std::array<Index, 3>& cells) {
  return test::box_with_faces(type, cells, Vector3(1, 1, 0.5), "low", "top");
}

struct Case {
  ElementType type = hex20;
  std::array<Index, 3> lower{0, 0, 0}, upper{3, 3, 2};  // no lower one: a wall
  std::string formulation = "node-face", as = "mesh", more = {};
  bool matches() const { return lower[0] == 0 || lower[0] == upper[0]; }
};

std::string name(const Case& its) {
  return std::string(cbr::name(its.type)) + " " + its.formulation + " " + its.as +
         (its.lower[0] == 0 ? " on a wall"
          : its.matches()   ? ""
                            : ", not matching") +
         its.more;
}

std::string yaml(const Case& its, const std::string& time) {
  const bool on_wall = its.lower[0] == 0;
  const std::string reduction =
      its.as == "mesh" ? "" : ", reduction: {interface: [low, top], modes: 5}";
  return "materials: {m: {youngs_modulus: " + text(E) +
         ", poissons_ratio: 0, density: 1}}\ncomponents:\n  upper: {mesh: upper.exo, material: m" +
         reduction + "}\n" +
         (on_wall ? "" : "  lower: {mesh: lower.exo, material: m" + reduction + "}\n") +
         "instances:\n  u: {component: upper, as: " + its.as + ", position: [0, 0, 0.5]}\n" +
         (on_wall ? "" : "  l: {component: lower, as: " + its.as + "}\n") +
         "walls: {floor: {plane: {point: [0, 0, 0.5], normal: [0, 0, 1]}}}\ncontact: [{between: "
         "[u.low, " +
         (on_wall ? "floor" : "l.top") + "]" +
         (on_wall ? "" : ", formulation: " + its.formulation) + its.more + "}]\nboundary:\n" +
         "  - {instance: u, nodes: top, fix: [x, y]}\n" +
         (on_wall ? "" : "  - {instance: l, nodes: low, fix: [x, y, z]}\n") +
         "loads: [{instance: u, surface: top, traction: [0, 0, " + text(-pressure) + "]}]\n" +
         "time: {" + time + "}\noutput: {history: [u.top], fields: [contact_pressure]}\n";
}

Ran run(const Case& its, const std::string& time) {
  test::SceneFolder folder;
  folder.add("upper.exo", box(its.type, its.upper));
  if (its.lower[0] > 0) folder.add("lower.exo", box(its.type, its.lower));
  return folder.run(yaml(its, time));
}

// Of all contact nodes of the meeting faces the largest difference from the pressure; and of their
// displacements from those of a uniform strain, both as shares.
struct Errors {
  double pressure = 0, displacement = 0;
};

Errors errors(const Ran& ran, const Case& its) {
  Errors largest;
  const double bottom = its.lower[0] == 0 ? 0.5 : 0;
  for (const ContactNodes& contact : ran.built.simulation.contact_nodes) {
    Body& body = *ran.built.simulation.bodies[contact.body];
    const Points X = body.reference_positions();
    Points u, v;
    body.displacements(u, v);
    for (Index i = 0; i < X.rows(); ++i)
      largest.displacement =
          std::max(largest.displacement,
                   std::abs(u(i, 2) + pressure / E * (X(i, 2) - bottom)) / (pressure / E));
    for (std::size_t i = 0; i < contact.nodes.size(); ++i)
      if (std::abs(X(contact.nodes[i], 2) - 0.5) < 1e-9)
        largest.pressure = std::max(
            largest.pressure, std::abs(contact.pressure[static_cast<Index>(i)] / pressure - 1));
  }
  return largest;
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const ElementType type : {hex20, hex27, tet10})
    for (const char* as : {"mesh", "superelement"}) {
      all.push_back({type, {0, 0, 0}, {1, 1, 2}, "node-face", as});
      all.push_back({type, {0, 0, 0}, {3, 3, 2}, "node-face", as});
      all.push_back({type, {2, 2, 2}, {2, 2, 2}, "node-face", as});
      all.push_back({type, {2, 2, 2}, {2, 2, 2}, "node-face", as, ", friction: 0.3"});
      all.push_back({type, {2, 2, 2}, {2, 2, 2}, "mortar", as});
      all.push_back({type, {2, 2, 2}, {3, 3, 2}, "auto", as});
    }
  return all;
}

TEST(SecondOrderContact, AUniformPressureIsOneInStatics) {
  for (const Case& its : cases()) {
    SCOPED_TRACE(name(its));
    const Ran ran = run(its, "static: true, end: 1, step: 1");
    const Errors of = errors(ran, its);
    EXPECT_LT(of.pressure, 1e-8);
    EXPECT_LT(of.displacement, 1e-8);
    EXPECT_NEAR(ran.built.simulation.pairs[0].seen().step.area, 1, 1e-12);
    EXPECT_EQ(ran.built.simulation.pairs[0].formulation == Formulation::mortar,
              its.formulation == "mortar" || !its.matches());
  }
}

TEST(SecondOrderContact, ATieCarriesAUniformPressure) {
  for (const ElementType type : {hex20, hex27, tet10})
    for (const char* as : {"mesh", "superelement"}) {
      const Case its{type, {2, 2, 2}, {3, 3, 2}, "auto", as, ", tied: true"};
      SCOPED_TRACE(name(its));
      EXPECT_LT(errors(run(its, "static: true, end: 1, step: 1"), its).displacement, 1e-8);
    }
}

// Bodies that strike meet by nodes and edges, also where faces meet later. Faces that match keep
// their nodes.
TEST(SecondOrderContact, MortarIsForUnlikeFacesThatMeetAndStay) {
  struct Choice {
    Formulation formulation;
    bool warns;
    bool operator==(const Choice&) const = default;
  };
  const auto choice = [](const Case& its, const std::string& time, const std::string& z = "0.5") {
    test::SceneFolder folder;
    folder.add("upper.exo", box(its.type, its.upper));
    folder.add("lower.exo", box(its.type, its.lower));
    std::string scene = yaml(its, time);
    scene.replace(scene.find("0, 0, 0.5]}"), 9, "0, 0, " + z);
    Report told("test", Verbosity::quiet);
    const BuiltScene built = build(folder.prepare(scene).scene, told);
    const std::vector<std::string>& all = told.warnings();
    return Choice{built.simulation.pairs[0].formulation,
                  std::any_of(all.begin(), all.end(), [](const std::string& text) {
                    return text.find("take formulation: mortar") != std::string::npos;
                  })};
  };
  const Choice nodes{Formulation::node_face, false}, uneven{Formulation::node_face, true},
      mortar{Formulation::mortar, false};
  const std::string statics = "static: true, end: 1, step: 1", motion = "end: 1";
  const Case unlike{hex20, {2, 2, 2}, {3, 3, 2}, "auto"};
  EXPECT_EQ(choice(unlike, statics), mortar);
  EXPECT_EQ(choice(unlike, "preload: 1, end: 1"), mortar);
  EXPECT_EQ(choice(unlike, motion), uneven);
  EXPECT_EQ(choice({hex20, {2, 2, 2}, {3, 3, 2}, "node-face"}, statics), uneven);
  EXPECT_EQ(choice(unlike, statics, "0.6"), nodes);
  EXPECT_EQ(choice({hex20, {2, 2, 2}, {2, 2, 2}, "node-face"}, statics), nodes);
  EXPECT_EQ(choice({hex8, {2, 2, 2}, {3, 3, 2}, "auto"}, statics), nodes);
  EXPECT_EQ(choice({hex20, {2, 2, 2}, {3, 3, 2}, "auto", "mesh", ", pressures: nodes"}, statics),
            uneven);
}

// Nodes against faces of another mesh load it unevenly: the pressure's sum is right.
TEST(SecondOrderContact, NodesOnOtherFacesCarryTheForce) {
  for (const ElementType type : {hex20, hex27, tet10}) {
    const Case its{type, {2, 2, 2}, {3, 3, 2}, "auto", "mesh", ", pressures: nodes"};
    SCOPED_TRACE(name(its));
    const Ran ran = run(its, "static: true, end: 1, step: 1");
    EXPECT_NEAR(test::at(ran.result.pairs[0]["force"], ran.result.time.size() - 1)[2], pressure,
                1e-9);
  }
}

TEST(SecondOrderContact, WhatStaticsPressStaysSoInMotion) {
  for (const char* integrator : {"exact", "central-difference", "newmark"})
    for (const Case& its : cases()) {
      if (its.upper[0] == 1) continue;
      SCOPED_TRACE(integrator + (" " + name(its)));
      const Ran ran =
          run(its, "preload: 1, end: 0.02, step: " +
                       std::string(std::string(integrator) == "newmark" ? "0.005" : "{cfl: 0.5}") +
                       ", integrator: " + integrator);
      const Errors of = errors(ran, its);
      EXPECT_LT(of.pressure, 1e-7);
      EXPECT_LT(of.displacement, 1e-8);
      EXPECT_NEAR(ran.built.simulation.pairs[0].seen().step.area, 1, 1e-12);
      EXPECT_LT(ran.body("u").kinetic_energy.back(), 1e-12 * ran.result.total.back());
    }
}

std::string collision(const std::string& as, const std::string& contact, const std::string& more) {
  const std::string reduction =
      as == "mesh" ? "" : ", reduction: {interface: [low, top], modes: 20}";
  return "materials: {m: {youngs_modulus: 1000, poissons_ratio: 0.3, density: 1}}\ncomponents:\n"
         "  upper: {mesh: upper.exo, material: m" +
         reduction + "}\n  lower: {mesh: lower.exo, material: m" + reduction +
         "}\ninstances:\n"
         "  u: {component: upper, as: " +
         as + ", position: [0.05, 0.02, 0.51], rotation: [0.2, 0.1, 0], velocity: [0.2, 0, -1]}\n" +
         "  l: {component: lower, as: " + as + "}\n" + "contact: [{between: [u.low, l.top]" +
         contact + "}]\ntime: {end: 0.1" + more +
         "}\noutput: {every: 0.001, history: [u.low], fields: [contact_pressure]}\n";
}

TEST(SecondOrderContact, BodiesThatStrikeKeepMomentumAndBringNoEnergy) {
  for (const ElementType type : {hex20, hex27, tet10}) {
    test::SceneFolder folder;
    folder.add("upper.exo", box(type, {3, 3, 2}));
    folder.add("lower.exo", box(type, {2, 2, 2}));
    for (const char* as : {"mesh", "superelement"})
      for (const char* law : {"", ", friction: 0.2", ", formulation: mortar"}) {
        SCOPED_TRACE(std::string(cbr::name(type)) + " " + as + law);
        const Ran ran = folder.run(collision(as, law, ", rotations: large"));
        EXPECT_GT(ran.built.simulation.pairs[0].seen().largest_area, 0);
        EXPECT_LT(test::largest_change(ran.result, &RunResult::OfBody::momentum), 1e-12);
        EXPECT_LT(test::largest_change(ran.result, &RunResult::OfBody::angular_momentum), 1e-11);
        EXPECT_LT(ran.result.total.back(), ran.result.total.front());
      }
  }
}

TEST(SecondOrderContact, ARestartGoesOnWithTheSameBits) {
  test::SceneFolder folder;
  folder.add("upper.exo", box(hex20, {3, 3, 2}));
  folder.add("lower.exo", box(hex20, {2, 2, 2}));
  for (const char* as : {"mesh", "superelement"})
    for (const char* law : {", friction: 0.2", ", formulation: mortar"})
      for (const char* integrator : {"exact", "newmark"}) {
        const test::RestartedRun runs = test::restarted(
            folder, collision(as, law, std::string(", integrator: ") + integrator), 0.03);
        EXPECT_EQ(runs.whole.body("u").momentum.values, runs.rest.body("u").momentum.values);
        EXPECT_EQ(runs.whole.built.simulation.contact_nodes[0].pressure,
                  runs.rest.built.simulation.contact_nodes[0].pressure);
      }
}

}  // namespace
}  // namespace cbr::second_order_contact_test
