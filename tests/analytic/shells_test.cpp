// SPDX-License-Identifier: GPL-3.0-or-later
// Shells as parts of a mesh, alone and on solids: closed forms, and superelements against meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "common/files/hdf5_file.hpp"
#include "dynamics/output/fields.hpp"
#include "tests/support/shelled_scene.hpp"

namespace cbr::shells_test {
namespace {

using namespace test::shelled;
using std::numbers::pi;
using test::at;
using test::Faces;
using test::Ran;
using test::text;

// Square plates: pi^2 (m^2 + n^2) of simple supports, 35.985 and 73.394 clamped (Leissa 1973, doi
// 10.1016/S0022-460X(73)80371-2). Both masses.
TEST_F(Shells, PlatesHaveTheirFrequencies) {
  for (const Faces kind : {Faces::quads, Faces::triangles}) {
    folder.add("plate.exo", plate(kind, 20, 20, 1, 1));
    for (const std::string& mass : {std::string("consistent"), std::string("lumped")}) {
      Shelled scene{.mass = mass};
      scene.more = "boundary:\n" + held("edges", "[x, y, z]", "none") + "time: {end: 1}\n";
      const Vector simple = frequencies(scene, 4);
      const double bound = mass == "lumped" ? 0.02 : 0.01;
      EXPECT_NEAR(simple(0) / hz(2 * pi * pi, 1), 1, bound) << testing::PrintToString(kind) << mass;
      EXPECT_NEAR(simple(1) / hz(5 * pi * pi, 1), 1, 2 * bound)
          << testing::PrintToString(kind) << mass;
      EXPECT_NEAR(simple(2) / simple(1), 1, 1e-10);
      EXPECT_NEAR(simple(3) / hz(8 * pi * pi, 1), 1, 3 * bound)
          << testing::PrintToString(kind) << mass;
      scene.more = "boundary:\n" + held("edges", "[x, y, z]", "") + "time: {end: 1}\n";
      const Vector clamped = frequencies(scene, 2);
      EXPECT_NEAR(clamped(0) / hz(35.985, 1), 1, bound) << testing::PrintToString(kind) << mass;
      EXPECT_NEAR(clamped(1) / hz(73.394, 1), 1, 2 * bound) << testing::PrintToString(kind) << mass;
    }
  }
}

// Folded at the middle by a right angle.
Mesh folded_plate(Faces kind) {
  Mesh mesh;
  add_grid(
      kind, 6, 4,
      [](double x, double y) {
        const double s = 2 * x - 1;
        return s < 0 ? Vector3(s, y, 0) : Vector3(0, y, s);
      },
      "plate", mesh);
  return mesh;
}

// A free folded plate: six motions cost nothing, and none besides; mass, centre and inertia.
TEST_F(Shells, AFoldedPlateIsFree) {
  folder.add("plate.exo", folded_plate(Faces::mixed));
  Shelled scene{.blocks = "plate: {thickness: 0.01}, plate_tri: {thickness: 0.01}",
                .instance = ", rotation: [10, 20, 30], mirror: y"};
  scene.more = "time: {end: 1}\n";
  const Vector free = frequencies(scene, 8);
  EXPECT_EQ((free.array() == 0).count(), 6);
  EXPECT_GT(free(6), 1);
  const Ran ran = folder.prepare(yaml(scene));
  EXPECT_NEAR(ran.mass("a"), 2 * rho * t, 1e-12 * rho * t);
}

// A strip, no contraction: F L^3 / (3 E I) + F L / (kappa G A).
TEST_F(Shells, AStripBendsAsABeam) {
  const double L = 1, b = 0.1, force = 10, I = b * t * t * t / 12;
  const double bending = force * L * L * L / (3 * E * I),
               shear = force * L / (5.0 / 6 * E / 2 * b * t);
  for (const Faces kind : {Faces::quads, Faces::triangles})
    for (const std::string& time :
         {std::string("step: 1, static: true"), std::string("integrator: newmark")}) {
      const bool is_static = time.ends_with("true");
      if (!is_static && kind == Faces::triangles) continue;
      folder.add("plate.exo", plate(kind, 20, 1, L, b));
      Shelled scene{.nu = "0", .output = "history: [a.x_1, a.x_0]"};
      scene.more = "boundary:\n" + held("x_0", "[x, y, z]", "") +
                   "loads:\n  - {instance: a, surface: x_1, force: [0, 0, 10], history: {time: [0, "
                   "20], value: [0, 1]}}\ntime: {end: 20, " +
                   (is_static ? "step: 20, static: true" : time + ", step: 0.1") + "}\n";
      const Ran ran = folder.run(yaml(scene));
      EXPECT_NEAR(moved(ran, "a.x_1", 2), bending + shear,
                  (is_static ? (kind == Faces::quads ? 2e-11 : 1e-3) : 5e-3) * bending)
          << testing::PrintToString(kind) << time;
      EXPECT_EQ(moved(ran, "a.x_0", 2), 0);
      EXPECT_NEAR(last(ran.body("a").reaction, 2), -10, is_static ? 1e-9 : 0.1);
    }
}

// A hinge turns, a clamp does not: the strip on two supports sags by 5 q L^4 / (384 E I), and
// clamped by a fifth of it. About one axis alone it is a hinge, too.
TEST_F(Shells, RotationsAreHeldAsTheSceneSays) {
  const double L = 1, b = 0.1, I = b * t * t * t / 12, q = rho * b * t * 10;
  folder.add("plate.exo", plate(Faces::quads, 20, 2, L, b));
  const auto sag = [&](const std::string& rotations) {
    Shelled scene{.nu = "0", .output = "history: [a.y_0]"};
    scene.more = "boundary:\n" + held("x_0", "[x, y, z]", rotations) +
                 held("x_1", "[x, y, z]", rotations) +
                 "loads:\n  - {gravity: [0, 0, -10]}\ntime: {end: 1, step: 1, static: true}\n";
    return -moved(folder.run(yaml(scene)), "a.y_0", 2) * 21 / 20;  // of 20 intervals
  };
  // The mean of the sag along the strip: q L^4 / (120 E I) hinged and / (720 E I) clamped
  const double hinged = q * std::pow(L, 4) / (120 * E * I), clamped = hinged / 6;
  EXPECT_NEAR(sag("none"), hinged, 0.01 * hinged);
  EXPECT_NEAR(sag("[x, z]"), hinged, 0.01 * hinged);
  EXPECT_NEAR(sag(""), clamped, 0.02 * clamped);
  EXPECT_NEAR(sag("[y]"), clamped, 0.02 * clamped);
}

TEST_F(Shells, PlatesOnASolidPullAndBendWithIt) {
  folder.add("bar.exo", covered_bar(4));
  Shelled scene{.mesh = "bar.exo",
                .nu = "0",
                .blocks = "top: {thickness: 0.05}, bottom: {thickness: 0.05}",
                .output = "history: [a.x_max]"};
  const auto tip = [&](const std::string& force, int axis) {
    scene.more = "boundary:\n" + held("x_min", "[x, y, z]", "") +
                 "loads:\n  - {instance: a, surface: x_max, force: " + force +
                 "}\ntime: {end: 1, step: 1, static: true}\n";
    return moved(folder.run(yaml(scene)), "a.x_max", axis);
  };
  // Shells share the solid's strain along their edges: uniform tension of A = 1 + 2 t
  // (the force is spread over the solid's face alone, which the ends see: 1 %)
  EXPECT_NEAR(tip("[1.0e6, 0, 0]", 0), 1e6 * 4 / (E * 1.1), 0.01 * 1e6 * 4 / (E * 1.1));
  // Bending: I = 1 / 12 + 2 (t / 4 + t^3 / 12), the plates in the solid's faces; shear of the solid
  const double I = 1.0 / 12 + 2 * (0.05 / 4 + std::pow(0.05, 3) / 12), G = E / 2;
  const double expected = 64.0 / (3 * E * I) + 4 / (G * 5 / 6);
  EXPECT_NEAR(tip("[0, 0, 1]", 2), expected, 0.03 * expected);
}

// With all modes a superelement is its mesh, its rotations kept or condensed.
TEST_F(Shells, SuperelementsWithAllModesAreTheMesh) {
  folder.add("plate.exo", plate(Faces::triangles, 5, 3, 1, 0.7));
  folder.add("bar.exo", covered_bar(2));
  for (const bool on_solid : {false, true})
    for (const std::string& rotations : {std::string(), std::string(", condense_rotations: true")})
      for (const bool is_held : {false, true}) {
        Shelled mesh{.mass = on_solid ? "lumped" : "consistent"};
        if (on_solid) {
          mesh.mesh = "bar.exo";
          mesh.blocks = "top: {thickness: 0.05}, bottom: {thickness: 0.01}";
        }
        const std::string ends = on_solid ? "[x_min, x_max]" : "[x_0, y_1]";
        if (is_held && !rotations.empty()) continue;  // nothing holds what is inside
        mesh.more = (is_held ? "boundary:\n" + held(on_solid ? "x_min" : "x_0", "[x, y, z]", "")
                             : std::string()) +
                    "time: {end: 1}\n";
        // Dofs inside: 15 nodes of the plate; 63 of the bar, 42 of which have rotations. On the
        // interface 9 and 12 nodes have rotations.
        const int inside = on_solid ? 63 * 3 + 42 * 3 : 15 * 6, kept = 3 * (on_solid ? 12 : 9);
        Shelled reduced = mesh;
        reduced.reduction = "interface: " + ends + rotations + ", modes: " +
                            std::to_string(rotations.empty() ? inside : inside + kept);
        const Vector expected = frequencies(mesh, 20), found = frequencies(reduced, 20);
        for (Index j = 0; j < 20; ++j)
          EXPECT_NEAR(found(j), expected(j), 1e-9 * expected(19)) << on_solid << rotations << j;
      }
}

// A plate on a shaken support under a pulse: mesh and superelement with all modes, in every
// integrator that both have, and in statics.
TEST_F(Shells, SuperelementsMoveAsTheMesh) {
  folder.add("plate.exo", plate(Faces::mixed, 5, 3, 1, 0.7));
  for (const std::string& time :
       {std::string("end: 0.01, integrator: newmark, step: 1.0e-4"),
        std::string("end: 2.0e-3, integrator: central-difference, step: 1.0e-6"),
        std::string("end: 0.01, step: 5.0e-3, static: true")}) {
    Shelled mesh{.blocks = "plate: {thickness: 0.01}, plate_tri: {thickness: 0.02}",
                 .output = "every: 5.0e-4, history: [a.corner, a.x_0]"};
    const std::string shaken = time.ends_with("true")
                                   ? ""
                                   : ", acceleration: [0, 0, 5], history: {time: [0, 1.0e-2], "
                                     "value: [0, 1]}";
    mesh.more =
        "boundary:\n  - {instance: a, nodes: x_0, fix: [x, y, z]" + shaken +
        "}\nloads:\n  - {instance: a, surface: plate, traction: [0, 0, -1000], history: {time: [0, "
        "1.0e-3, 2.0e-3], value: [0, 1, 0.5]}}\n  - {instance: a, surface: corner, force: "
        "[10, 20, 30]}\n  - {gravity: [0, 0, -9.81]}\ntime: {" +
        time + "}\n";
    Shelled reduced = mesh;
    reduced.reduction = "interface: [x_0, corner], modes: 114";
    const Ran a = folder.run(yaml(mesh)), b = folder.run(yaml(reduced));
    ASSERT_EQ(a.result.time.size(), b.result.time.size());
    const Series3 &expected = a.monitor("a.corner").mean_position,
                  &found = b.monitor("a.corner").mean_position;
    double worst = 0, scale = 0;
    for (std::size_t i = 0; i < a.result.time.size(); ++i) {
      worst = std::max(worst, (at(found, i) - at(expected, i)).norm());
      scale = std::max(scale, (at(expected, i) - at(expected, 0)).norm());
    }
    EXPECT_GT(scale, 1e-6) << time;
    EXPECT_LT(worst, 1e-9 * scale) << time;
    EXPECT_LT(test::energy_residual(a.result), 1e-12) << time;
    EXPECT_LT(test::energy_residual(b.result), 1e-12) << time;
  }
}

// A tilted plate falls on a wall and on another plate; momentum, energy and restart.
TEST_F(Shells, PlatesTouch) {
  folder.add("plate.exo", plate(Faces::quads, 6, 4, 1, 0.7));
  for (const std::string& time :
       {std::string("integrator: exact"), std::string("integrator: newmark, step: 2.0e-5")}) {
    Shelled scene{.mass = "lumped", .output = "every: 1.0e-4, history: [a.plate, b.plate]"};
    scene.instance =
        ", position: [0, 0, 0.06], rotation: [2, 3, 0], velocity: [0, 0, -10]}\n  b: {component: "
        "part, velocity: [0, 0, 1]";
    scene.more =
        "walls:\n  floor: {plane: {point: [0, 0, -0.005], normal: [0, 0, 1]}}\n"
        "contact:\n  - {between: [a.plate.back, b.plate], friction: 0.2}\n"
        "  - {between: [b.plate.back, floor]}\ntime: {end: 0.01, " +
        time + "}\n";
    const test::RestartedRun both = test::restarted(folder, yaml(scene), 0.004);
    const Ran& ran = both.whole;
    EXPECT_LT(test::energy_residual(ran.result), 1e-12) << time;
    double lowest = 1;
    for (std::size_t i = 0; i < ran.result.time.size(); ++i)
      lowest = std::min(lowest, at(ran.monitor("b.plate").mean_position, i)[2]);
    EXPECT_GT(lowest, -0.005 - 1e-9);
    // a was thrown back
    EXPECT_GT(last(ran.body("a").momentum, 2), ran.mass("a"));
    const auto &whole = ran.monitor("a.plate").mean_position.values,
               &rest = both.rest.monitor("a.plate").mean_position.values;
    ASSERT_GE(whole.size(), rest.size());
    EXPECT_TRUE(std::equal(rest.rbegin(), rest.rend(), whole.rbegin())) << time;
  }
}

// A free superelement turns by any angle: angular momentum and energy stay.
TEST_F(Shells, SuperelementsTurn) {
  folder.add("plate.exo", plate(Faces::quads, 6, 4, 1, 0.7));
  for (const std::string& rotations : {std::string(), std::string(", condense_rotations: true")}) {
    Shelled scene{.reduction = "interface: [x_0, x_1], modes: 10" + rotations,
                  .instance = ", angular_velocity: [3, 5, 7]",
                  .output = "every: 0.02, history: [a.x_0]"};
    scene.more = "time: {end: 0.1, rotations: large}\n";
    const Ran ran = folder.run(yaml(scene));
    const Series3& L = ran.body("a").angular_momentum;
    const std::size_t n = ran.result.time.size();
    EXPECT_LT((at(L, n - 1) - at(L, 0)).norm(), 1e-9 * at(L, 0).norm());
    // Of a rectangle about axes in its plane; about its normal the drilling rotations add to it
    const double m = 0.7 * rho * t;
    EXPECT_NEAR(at(L, 0)[0], 3 * m * (0.7 * 0.7 + t * t) / 12, 1e-9);
    EXPECT_NEAR(at(L, 0)[1], 5 * m * (1 + t * t) / 12, 1e-9);
    EXPECT_LT(test::energy_residual(ran.result), 1e-12);
  }
}

// A free mesh turns by any angle, too: angular momentum stays, energy to second order of the step,
// and it turns as a superelement of the same mass. Beginning again it is the same to the bit.
TEST_F(Shells, MeshesTurn) {
  folder.add("plate.exo", folded_plate(Faces::quads));
  Shelled scene{.mass = "lumped",
                .instance = ", rotation: [10, 20, 30], angular_velocity: [6, 10, 14]"};
  const auto run = [&](const std::string& kind, double h) {
    Shelled of = scene;
    if (kind != "mesh") of.reduction = "interface: [x_0, x_1], modes: 30";
    of.instance += ", as: " + kind + ", mirror: x";
    of.output = "every: 0.02, history: [a.x_0]";
    of.more = "time: {end: 0.1, step: " + text(h) + ", rotations: large}\n";
    return test::restarted(folder, yaml(of), 0.05);
  };
  const test::RestartedRun coarse = run("mesh", 1e-5), fine = run("mesh", 5e-6),
                           reduced = run("superelement", 1e-5);
  const Series3& L = fine.whole.body("a").angular_momentum;
  const std::size_t n = fine.whole.result.time.size() - 1;
  EXPECT_LT((at(L, n) - at(L, 0)).norm(), 1e-11 * at(L, 0).norm());
  EXPECT_LT((at(reduced.whole.body("a").angular_momentum, 0) - at(L, 0)).norm(),
            1e-9 * at(L, 0).norm());
  const auto off = [](const Ran& ran) {
    double most = 0;
    for (const double work : ran.result.work_numerical) most = std::max(most, std::abs(work));
    return most / ran.result.total.front();
  };
  EXPECT_LT(off(fine.whole), 1e-5);
  EXPECT_NEAR(off(coarse.whole) / off(fine.whole), 4, 1);
  EXPECT_LT(test::energy_residual(fine.whole.result), 1e-12);
  const auto turn = [](const Ran& ran) {
    const std::vector<double>& q = ran.body("a").orientation;
    return Eigen::Map<const Eigen::Vector4d>(q.data() + q.size() - 4);
  };
  EXPECT_GT(std::abs((turn(fine.whole).dot(turn(reduced.whole)))), 1 - 1e-5);
  EXPECT_EQ(turn(fine.rest), turn(fine.whole));
  // The strain energy of the spin
  EXPECT_NEAR(
      fine.whole.body("a").strain_energy.back() / reduced.whole.body("a").strain_energy.back(), 1,
      0.1);
}

// A turning mesh strikes a wall as the linear one does, while it turns little.
TEST_F(Shells, ATurningMeshStrikes) {
  folder.add("plate.exo", plate(Faces::quads, 6, 4, 1, 0.7));
  const auto run = [&](const std::string& rotations) {
    Shelled scene{.mass = "lumped", .output = "every: 1.0e-4, history: [a.plate]"};
    scene.instance = ", position: [0, 0, 0.06], rotation: [2, 3, 0], velocity: [0, 0, -2]";
    scene.more =
        "walls:\n  floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}\ncontact:\n"
        "  - {between: [a.plate.back, floor], friction: 0.2}\nloads:\n  - {gravity: [0, 0, "
        "-10]}\ntime: {end: 0.008, rotations: " +
        rotations + "}\n";
    return folder.run(yaml(scene));
  };
  const Ran linear = run("small"), turning = run("large");
  const std::size_t n = linear.result.time.size() - 1;
  const Vector3 p = at(linear.body("a").momentum, n), p_0 = at(linear.body("a").momentum, 0);
  EXPECT_GT((p - p_0).norm(), 0.03 * p_0.norm());
  EXPECT_LT((at(turning.body("a").momentum, n) - p).norm(), 0.05 * (p - p_0).norm());
  EXPECT_LT(test::energy_residual(turning.result), 1e-12);
  EXPECT_FALSE(turning.body("a").orientation.empty());
}

// A rigid plate has the inertia of the shells, and falls.
TEST_F(Shells, ARigidPlateFalls) {
  folder.add("plate.exo", plate(Faces::quads, 6, 4, 1, 0.7));
  Shelled scene{.instance = ", as: rigid", .output = "history: [a.x_0], every: 0.1"};
  scene.more = "loads:\n  - {gravity: [0, 0, -10]}\ntime: {end: 0.1, step: 1.0e-3}\n";
  const Ran ran = folder.run(yaml(scene));
  EXPECT_NEAR(moved(ran, "a.x_0", 2), -0.05, 1e-12);
  EXPECT_NEAR(ran.mass("a"), 0.7 * rho * t, 1e-11);
}

// A moment on one node bends a strip by M L^2 / (2 E I), as mesh and as superelement, turned and
// mirrored; a link to the ground clamps that node.
TEST_F(Shells, APointOnOneNodeHasItsRotations) {
  const double L = 1, b = 0.1, I = b * t * t * t / 12;
  folder.add("plate.exo", plate(Faces::quads, 20, 2, L, b));
  for (const std::string& kind : {std::string(), std::string("interface: [x_0, tip], modes: 4")})
    for (const std::string& place : {std::string(), std::string(", mirror: y")}) {
      Shelled scene{.nu = "0", .reduction = kind, .instance = place, .output = "history: [a.end]"};
      scene.blocks = "plate: {thickness: 0.01}}, points: {end: {surface: tip}";
      scene.more =
          "boundary:\n" + held("x_0", "[x, y, z]", "") +
          "loads:\n  - {instance: a, point: end, moment: [0, 10, 0]}\ntime: {end: 1, step: "
          "1, static: true}\n";
      const Ran ran = folder.run(yaml(scene));
      const double sag = 10 * L * L / (2 * E * I), angle = 10 * L / (E * I);
      EXPECT_NEAR(moved(ran, "a.end", 2), -sag, 2e-3 * sag) << kind << place;
      EXPECT_NEAR(last(ran.monitor("a.end").rotation, 1), angle, 0.1 * angle) << kind << place;
      scene.more = "links:\n  - {between: [a.end, ground]}\nboundary:\n" +
                   held("x_0", "[x, y, z]", "") +
                   "loads:\n  - {gravity: [0, 0, -10]}\ntime: {end: 1, step: 1, static: true}\n";
      const Ran welded = folder.run(yaml(scene));
      EXPECT_NEAR(last(welded.monitor("a.end").rotation, 1), 0, 1e-12);
      EXPECT_NEAR(moved(welded, "a.end", 2), 0, 1e-12);
    }
}

// A moment about the edge that it acts on: M L^2 / (2 E I), spread over the rotations of the nodes;
// across the edge it is forces alone. On a set, its point and one node; of superelements, too.
TEST_F(Shells, AMomentActsOnAnEdge) {
  const double length = 1, width = 0.2, M = 10, EI = E * width * t * t * t / 12;
  folder.add("plate.exo", plate(Faces::quads, 10, 2, length, width));
  const std::string run = "time: {end: 1, step: 1, static: true}\n",
                    clamped = "boundary:\n" + held("x_0", "[x, y, z]", "");
  for (const std::string& kind : {std::string(), std::string("interface: [x_0, x_1], modes: 4")})
    for (const std::string& mirror : {std::string(), std::string(", mirror: y")}) {
      Shelled scene{.nu = "0", .output = "history: [a.x_1]"};
      scene.reduction = kind;
      scene.instance = (kind.empty() ? ", as: mesh" : ", as: superelement") + mirror;
      scene.more = clamped + "loads: [{instance: a, surface: x_1, moment: [0, -10, 0]}]\n" + run;
      const double w = moved(folder.run(yaml(scene)), "a.x_1", 2);
      EXPECT_NEAR(w, M * length * length / (2 * EI), 1e-3 * w) << kind << mirror;
      scene.more = clamped + "loads: [{instance: a, surface: x_1, moment: [0, 0, 1000]}]\n" + run;
      const double v = moved(folder.run(yaml(scene)), "a.x_1", 1);
      EXPECT_NEAR(v, 1000 / (2 * E * t * std::pow(width, 3) / 12), 0.15 * v) << kind << mirror;
    }
  // One node, and a point that turns as its edge does
  Shelled scene{.nu = "0", .instance = ", as: mesh", .output = "history: [a.x_1, a.edge]"};
  std::string text = yaml(scene);
  const std::string point = ", points: {edge: {surface: x_1}}, mass: ";
  text.replace(text.find(", mass: "), 8, point);
  const auto with = [&](const std::string& load) {
    std::string whole = text;
    return folder.run(whole.insert(whole.find("output:"),
                                   clamped + "loads: [{instance: a, " + load + "}]\n" + run));
  };
  const double theta = M * length / EI;
  for (const char* load :
       {"point: edge, moment: [0, -10, 0]", "surface: x_1, moment: [0, -10, 0]"}) {
    const Ran ran = with(load);
    const double found = -last(ran.monitor("a.edge").rotation, 1);
    EXPECT_NEAR(found, theta, 0.01 * theta) << load;  // a nodeset's corners weigh as much as others
    EXPECT_NEAR(2 * ran.result.total.back(), M * found, 1e-9 * M * theta) << load;
  }
  // The middle of the edge turns further than the mean of its nodes
  const double of_node =
      -last(with("surface: tip, moment: [0, -10, 0]").monitor("a.edge").rotation, 1);
  EXPECT_NEAR(of_node, theta, 0.05 * theta);
}

// sigma = 6 M / (b t^2) of a bent strip, on either face, and F / (b t) of a pulled one: in axes of
// the scene, on quads and triangles.
TEST_F(Shells, FieldsHaveTheStressOfTheOuterFace) {
  const double width = 0.2, bent = 6 * 10 / (width * t * t), pulled = 3000 / (width * t);
  for (const Faces kind : {Faces::quads, Faces::triangles}) {
    folder.add("plate.exo", plate(kind, 8, 2, 1, width));
    Shelled scene{.nu = "0", .instance = ", as: mesh, rotation: [0, 0, 90]"};
    for (const auto& [load, sigma] :
         {std::pair("moment: [10, 0, 0]", bent), std::pair("force: [0, 3000, 0]", pulled)}) {
      scene.more = "boundary:\n" + held("x_0", "[x, y, z]", "") +
                   "loads: [{instance: a, surface: x_1, " + load +
                   "}]\ntime: {end: 1, step: 1, static: true}\n";
      scene.output = "fields: [stress]";
      const Ran ran = folder.run(yaml(scene));
      const auto results = folder.folder() / "r.h5";
      FieldWriter fields(ran.scene, ran.built, results, report);
      fields.add(1);
      fields.commit();
      const Hdf5Reader file(folder.folder() / "r.fields.h5");
      const Matrix yy = file.read_matrix("/steps/0/0/stress_yy"),
                   von_mises = file.read_matrix("/steps/0/0/stress_von_mises");
      ASSERT_EQ(yy.rows(), kind == Faces::quads ? 16 : 32);
      // In the middle: corners of the edge take as much as other nodes
      const Index n = yy.rows() / 16;
      for (Index e = 0; e < yy.rows(); ++e) {
        const Index i = e / n % 8;
        if (i < 3 || i > 4) continue;
        EXPECT_NEAR(std::abs(yy(e, 0)), sigma, 0.01 * sigma) << load << e;
        EXPECT_NEAR(von_mises(e, 0), sigma, 0.01 * sigma) << load << e;
      }
    }
  }
}

// A strip in pure bending, M about its width: sigma = 6 M / (b t^2) at the top, its opposite at the
// bottom, at elements, nodes, in the scan and in the fields. A pulled one has F / (b t) on both.
// Meshes, and superelements with rotations kept or inside, turned and mirrored.
TEST_F(Shells, TopAndBottomHaveTheirStress) {
  const double width = 0.2, bent = 6 * 10 / (width * t * t), pulled = 3000 / (width * t);
  folder.add("plate.exo", plate(Faces::quads, 8, 2, 1, width));
  const std::string reduced = "interface: [x_0, x_1], modes: 10, recovery: true";
  for (const std::string& reduction :
       {std::string(), reduced,
        std::string("interface: [x_0, x_1, y_0], modes: 10, recovery: true, basis: characteristic, "
                    "characteristic: {keep: x_1}"),
        std::string("interface: [x_0, x_1], modes: 10, recovery: [tip, corner]")})
    for (const std::string& place : {std::string(", rotation: [0, 0, 90]"),
                                     std::string(", rotation: [0, 0, 90], mirror: z")}) {
      Shelled scene{.nu = "0", .reduction = reduction, .instance = place};
      const bool is_whole = !reduction.ends_with("]");
      const auto run = [&](const std::string& load) {
        scene.more = "boundary:\n" + held("x_0", "[x, y, z]", "") +
                     "loads: [{instance: a, surface: x_1, " + load +
                     "}]\ntime: {end: 1, step: 1, static: true}\n";
        scene.output =
            std::string("fields: [stress, nodal_stress], stress: [a.tip") +
            (is_whole ? ", {instance: a, elements: [4], worst: 3, envelope: true}" : "") + "]";
        return folder.run(yaml(scene));
      };
      // Shells turn about the scene's x by a moment: tension where their normal, z, points to
      const double up = place.ends_with("z") ? -1 : 1;
      const Ran ran = run("moment: [10, 0, 0]");
      const StressWatch& tip = ran.built.simulation.watches.front();
      ASSERT_EQ(tip.ids.size(), 2u) << reduction;
      EXPECT_EQ(tip.faces, (std::vector<Index>{1, -1}));
      const auto yy = [&](const Ran& of, std::size_t watch, std::size_t i) {
        const std::vector<double>& all = of.result.watches[watch];
        return all[all.size() - 6 * (2 - i) + 1];
      };
      // The tip's element is at the end, whose corners take as much as other nodes
      EXPECT_NEAR(yy(ran, 0, 0), -up * bent, 0.15 * bent) << reduction << place;
      EXPECT_NEAR(yy(ran, 0, 1), -yy(ran, 0, 0), 1e-9 * bent) << reduction << place;
      if (!is_whole) continue;
      EXPECT_NEAR(yy(ran, 1, 0), -up * bent, 0.01 * bent) << reduction << place;
      EXPECT_NEAR(yy(ran, 1, 1), -yy(ran, 1, 0), 1e-9 * bent) << reduction << place;
      const StressScan& scan = ran.built.simulation.scans.front();
      EXPECT_EQ(scan.element_ids.size(), 32u);
      EXPECT_EQ(std::count(scan.element_faces.begin(), scan.element_faces.end(), -1), 16);
      const auto results = folder.folder() / "r.h5";
      FieldWriter fields(ran.scene, ran.built, results, report);
      fields.add(1);
      fields.commit();
      const Hdf5Reader file(folder.folder() / "r.fields.h5");
      Index grid = 0;
      while (file.read_string("/grids/" + std::to_string(grid), "name") != "a.plate") ++grid;
      const auto field = [&](const std::string& name, Index i) {
        return file.read_matrix("/steps/0/" + std::to_string(grid) + "/" + name)(i, 0);
      };
      EXPECT_NEAR(field("stress_top_yy", 3), -up * bent, 0.01 * bent);
      EXPECT_NEAR(field("stress_bottom_yy", 3), up * bent, 0.01 * bent);
      EXPECT_NEAR(field("stress_von_mises", 3), bent, 0.01 * bent);
      EXPECT_NEAR(field("nodal_stress_top_von_mises", 0), bent, 0.05 * bent);
      const Ran pull = run("force: [0, 3000, 0]");
      EXPECT_NEAR(yy(pull, 1, 0), pulled, 0.01 * pulled) << reduction << place;
      EXPECT_NEAR(yy(pull, 1, 1), pulled, 0.01 * pulled) << reduction << place;
    }
}

}  // namespace
}  // namespace cbr::shells_test
