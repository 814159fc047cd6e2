// SPDX-License-Identifier: GPL-3.0-or-later
// Supports of one instance that move unlike each other, or turn, and the reactions of each of them:
// closed forms of bars and shafts, in every integrator and basis; that a motion that is alike gives
// the same by both ways; restarts, refusals.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/refusal.hpp"
#include "tests/support/restarted_run.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::uneven_supports_test {
namespace {

using test::at;
using test::Ran;
using test::SceneFolder;
using test::text;

struct Way {
  std::string as = "superelement", basis = "craig-bampton, modes: 135", time = "static: true";
  std::string mesh = "two.exo", nu = "0", placed = {}, damping = {}, more = {}, mass = "lumped";
  std::string boundary = {}, reactions = "bar.x_min, bar.x_max";
  std::string interface = "[x_min, x_max]";
  double end = 1, every = 0.1;
};

std::string scene(const Way& way) {
  return "materials:\n  soft: {youngs_modulus: 200, poissons_ratio: " + way.nu + ", density: 1" +
         way.damping + "}\ncomponents:\n  bar: {mesh: " + way.mesh +
         ", material: soft, mass: " + way.mass +
         (way.as == "superelement"
              ? ", reduction: {basis: " + way.basis + ", interface: " + way.interface + "}"
              : "") +
         "}\ninstances:\n  bar: {component: bar, as: " + way.as + way.placed + "}\nboundary:\n" +
         way.boundary + way.more + "time: {end: " + text(way.end) + ", " + way.time +
         "}\noutput: {every: " + text(way.every) + ", history: [bar.x_min, bar.x_max]" +
         (way.reactions.empty() ? "" : ", reactions: [" + way.reactions + "]") + "}\n";
}

std::string held(const std::string& set, const std::string& motion = {},
                 const std::string& fix = "[x, y, z]") {
  return "  - {instance: bar, nodes: " + set + ", fix: " + fix + motion + "}\n";
}

const RunResult::OfReaction& reaction(const Ran& ran, const std::string& set) {
  const Simulation& sim = ran.built.simulation;
  for (std::size_t i = 0; i < sim.reactions.size(); ++i)
    if (sim.reactions[i].body->supports()->sets()[sim.reactions[i].set].name == set)
      return ran.result.reactions[i];
  throw std::runtime_error("no reaction of " + set);
}

Vector3 last(const Series3& series) { return at(series, series.values.size() / 3 - 1); }

double largest_difference(const Series3& a, const Series3& b) {
  EXPECT_EQ(a.values.size(), b.values.size());
  double worst = 0, scale = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    worst = std::max(worst, std::abs(a.values[i] - b.values[i]));
    scale = std::max(scale, std::abs(b.values[i]));
  }
  EXPECT_GT(scale, 0);
  return worst / scale;
}

class UnevenSupports : public ::testing::Test {
 protected:
  UnevenSupports() {
    folder.add("two.exo", test::block_mesh({{2, 1, 1}, {1, 1, 1}}));
    folder.add("many.exo", test::block_mesh({{6, 2, 2}, {1, 0.3, 0.2}}));
  }
  std::string refusal(const Way& way) const {
    return test::refusal_of([&] { folder.prepare(scene(way)); });
  }
  SceneFolder folder;
};

// A bar of two elements: k = 2 E A / L on either side of the middle mass, omega^2 = 2 k / m.
constexpr double k = 400, m_middle = 0.5, m_end = 0.25, omega = 40;

// One end moves by a t^2 / 2. The middle follows half of that, less the swing of its inertia.
TEST_F(UnevenSupports, OneEndOfABarAcceleratesInClosedForm) {
  const double a = 3;
  // Integrals of the middle's displacement and of the end's
  const auto middle = [&](double t) {
    return a * t * t * t / 12 - 0.5 * a / (omega * omega) * (t - std::sin(omega * t) / omega);
  };
  const auto moved = [&](double t) { return a * t * t * t / 6; };
  const auto speed = [&](double t) { return 0.5 * a * t - 0.5 * a / omega * std::sin(omega * t); };
  for (const char* as : {"superelement", "mesh"}) {
    for (const char* time : {"integrator: exact", "integrator: newmark, step: 0.0005",
                             "integrator: central-difference, step: 0.0005"}) {
      Way way{.as = as, .basis = "craig-bampton, modes: 12", .time = time};
      way.boundary = held("x_min") + held("x_max", ", acceleration: [3, 0, 0]");
      const Ran ran = folder.run(scene(way));
      const bool is_exact = way.as == "superelement" && way.time.find("exact") != std::string::npos;
      if (!is_exact && way.time.find("exact") != std::string::npos) continue;
      const double share = is_exact ? 1e-12 : 2e-4;
      const auto &left = reaction(ran, "x_min").force, &right = reaction(ran, "x_max").force;
      for (std::size_t i = 1; i < ran.result.time.size(); ++i) {
        const double t = ran.result.time[i], before = ran.result.time[i - 1], h = t - before;
        EXPECT_NEAR(at(left, i)[0], -k * (middle(t) - middle(before)) / h, k * a * share)
            << as << time;
        EXPECT_NEAR(at(right, i)[0],
                    m_end * a + k * (moved(t) - moved(before) - middle(t) + middle(before)) / h,
                    k * a * share);
        EXPECT_NEAR(at(left, i)[0] + at(right, i)[0], at(ran.body("bar").reaction, i)[0],
                    1e-10 * k * a);
        EXPECT_NEAR(at(ran.body("bar").momentum, i)[0], m_end * a * t + m_middle * speed(t),
                    a * share)
            << as << time;
      }
      EXPECT_LT(test::energy_residual(ran.result), is_exact ? 1e-13 : 1e-11) << as << time;
    }
  }
}

// The end begins with a velocity, and the middle without.
TEST_F(UnevenSupports, OneEndOfABarIsPulledAtConstantVelocity) {
  const double v = 2;
  const auto middle = [&](double t) {  // the integral of its displacement
    return v * t * t / 4 - 0.5 * v / omega * (1 - std::cos(omega * t)) / omega;
  };
  Way way{.basis = "craig-bampton, modes: 12", .time = "integrator: exact"};
  way.boundary = held("x_min") + held("x_max", ", velocity: [2, 0, 0]");
  for (const char* as : {"superelement", "mesh"}) {
    way.as = as;
    way.time =
        way.as == "mesh" ? "integrator: central-difference, step: 0.0002" : "integrator: exact";
    const Ran ran = folder.run(scene(way));
    const double share = way.as == "mesh" ? 1e-3 : 1e-12;
    for (std::size_t i = 1; i < ran.result.time.size(); ++i) {
      const double t = ran.result.time[i], before = ran.result.time[i - 1];
      EXPECT_NEAR(at(reaction(ran, "x_min").force, i)[0],
                  -k * (middle(t) - middle(before)) / (t - before), k * v * share)
          << as;
    }
    EXPECT_LT(test::energy_residual(ran.result), 1e-12) << as;
  }
}

// F = E A d / L at both ends, and the strain energy F d / 2 is the supports' work.
TEST_F(UnevenSupports, ABarIsStretchedInEveryBasis) {
  const double d = 0.01, force = 200 * 0.3 * 0.2 * d;
  for (const char* basis :
       {"craig-bampton, modes: 20", "massless, modes: 12", "characteristic, modes: 30",
        "craig-bampton, modes: 5, domains: 2", "mesh"}) {
    for (const char* time : {"static: true", "integrator: newmark, step: 0.02"}) {
      Way way{.basis = basis, .time = time, .mesh = "many.exo"};
      if (way.basis == "mesh") way.as = "mesh";
      // The held nodes are kept; few shapes are for the other faces
      if (way.basis.find("char") == 0) way.interface = "[x_min, x_max, z_min, z_max]";
      if (way.time != "static: true" && way.basis.find("craig") != 0 && way.as != "mesh")
        way.time = "integrator: exact";
      way.end = 40;
      way.every = 2;
      way.damping = way.time == "static: true" ? "" : ", damping: {beta: 0.02}";
      way.boundary =
          held("x_min") +
          held("x_max", ", displacement: [0.01, 0, 0], history: {time: [0, 20], value: [0, 1]}");
      const Ran ran = folder.run(scene(way));
      const std::string name = way.basis + " " + way.time;
      EXPECT_NEAR(last(reaction(ran, "x_max").force)[0], force, 1e-8 * force) << name;
      EXPECT_NEAR(last(reaction(ran, "x_min").force)[0], -force, 1e-8 * force) << name;
      EXPECT_LT(last(reaction(ran, "x_min").moment).norm(), 1e-8 * force) << name;
      EXPECT_NEAR(ran.result.total.back(), 0.5 * force * d, 1e-8 * force * d) << name;
      EXPECT_LT(test::energy_residual(ran.result), 1e-10) << name;
      EXPECT_NEAR(last(ran.monitor("bar.x_max").mean_position)[0], 1 + d, 1e-12) << name;
    }
  }
}

// A square shaft whose ends may warp: T = G J theta / L, J = 0.1405770 a^4 (Saint-Venant), as fine
// as its mesh. Its ends are held in y and z alone, so that it is free along x.
TEST_F(UnevenSupports, ATwistedShaftHasTheTorqueOfSaintVenant) {
  const double a = 0.5, L = 1, theta = 2 * std::numbers::pi / 180, G = 200 / (2 * 1.3);
  double series = 0;
  for (int n = 1; n < 60; n += 2) series += std::tanh(0.5 * n * std::numbers::pi) / std::pow(n, 5);
  const double J = std::pow(a, 4) * (1.0 / 3 - 64 * series / std::pow(std::numbers::pi, 5));
  const double expected = G * J * theta / L;
  const std::string motion = ", rotation: [2, 0, 0], history: {time: [0, 1], value: [0, 1]}";
  std::vector<double> sizes, errors;
  for (const Index n : {4, 8, 12}) {
    const std::string mesh = "shaft" + std::to_string(n) + ".exo";
    folder.add(mesh, test::block_mesh({{3, n, n}, {L, a, a}}));
    Way way{.as = "mesh", .mesh = mesh, .nu = "0.3"};
    way.boundary = held("x_min", "", "[y, z]") + held("x_max", motion, "[y, z]");
    const Ran ran = folder.run(scene(way));
    const Vector3 torque = last(reaction(ran, "x_max").moment);
    EXPECT_NEAR(last(reaction(ran, "x_min").moment)[0], -torque[0], 1e-9 * expected);
    EXPECT_LT(std::hypot(torque[1], torque[2]), 1e-9 * expected);
    EXPECT_LT(last(reaction(ran, "x_max").force).norm(), 1e-8 * expected);
    EXPECT_NEAR(ran.result.total.back(), 0.5 * torque[0] * theta, 1e-9 * expected);
    sizes.push_back(1.0 / static_cast<double>(n));
    errors.push_back(torque[0] / expected - 1);
  }
  std::printf("torque of G J theta / L: %.4f %.4f %.4f\n", 1 + errors[0], 1 + errors[1],
              1 + errors[2]);
  EXPECT_LT(std::abs(errors.back()), 0.01);
  EXPECT_NEAR(test::observed_order(sizes, errors), 2, 0.2);
}

// A slender beam with clamped ends, one of which moves aside by d: 12 E I d / L^3 (1 + phi) and
// half of that times L at both ends; then it turns by theta instead: 6 E I theta / L^2 and
// (4 + phi) E I theta / L, each over 1 + phi (Timoshenko, kappa = 5/6).
TEST_F(UnevenSupports, OneEndOfAClampedBeamMovesAsideOrTurns) {
  const double L = 2, b = 0.1, EI = 200 * std::pow(b, 4) / 12, G = 100,
               phi = 12 * EI / (5.0 / 6 * G * b * b * L * L);
  folder.add("beam.exo", test::block_mesh({{40, 2, 2}, {L, b, b}}));
  Way way{.mesh = "beam.exo"};
  way.basis = "craig-bampton, modes: 0";
  const std::string history = ", history: {time: [0, 1], value: [0, 1]}";
  way.boundary = held("x_min") + held("x_max", ", displacement: [0, 0.01, 0]" + history);
  const Ran aside = folder.run(scene(way));
  const double force = 12 * EI * 0.01 / (L * L * L) / (1 + phi);
  EXPECT_NEAR(last(reaction(aside, "x_max").force)[1], force, 0.01 * force);
  EXPECT_NEAR(last(reaction(aside, "x_max").moment)[2], -force * L / 2, 0.005 * force * L);
  EXPECT_NEAR(last(reaction(aside, "x_min").moment)[2], -force * L / 2, 0.005 * force * L);
  const double theta = std::numbers::pi / 180;
  way.boundary = held("x_min") + held("x_max", ", rotation: [0, 0, 1]" + history);
  const Ran turned = folder.run(scene(way));
  const double shear = 6 * EI * theta / (L * L) / (1 + phi),
               moment = (4 + phi) * EI * theta / L / (1 + phi);
  EXPECT_NEAR(last(reaction(turned, "x_max").force)[1], -shear, 0.01 * shear);
  EXPECT_NEAR(last(reaction(turned, "x_max").moment)[2], moment, 0.01 * moment);
  EXPECT_NEAR(last(reaction(turned, "x_min").moment)[2], moment * (2 - phi) / (4 + phi),
              0.01 * moment);
  // About another point the same rotation moves the end aside, too
  way.boundary =
      held("x_min") + held("x_max", ", rotation: [0, 0, 1], about: [0, 0.05, 0.05]" + history);
  const Ran about = folder.run(scene(way));
  EXPECT_NEAR(last(about.monitor("bar.x_max").mean_position)[1], 0.05 + theta * L, 1e-12);
  // The energy is that of a rotation and of a way aside
  EXPECT_NEAR(about.result.total.back(), 0.5 * theta * last(reaction(about, "x_max").moment)[2],
              1e-9 * moment * theta);
}

// A moment on the nodes of a nodeset, as a load: the clamp has it, and no force; the tip turns by
// M L / (E I) beside what the last elements do under forces that vary linearly over the section.
TEST_F(UnevenSupports, AMomentOnANodesetIsTheClamps) {
  const double L = 2, b = 0.1, EI = 200 * std::pow(b, 4) / 12, M = 1e-4;
  Mesh mesh = test::block_mesh({{40, 2, 2}, {L, b, b}});
  Nodeset tip{"tip", 1, {}};
  for (Index i = 0; i < mesh.coordinates.rows(); ++i)
    if (mesh.coordinates(i, 0) > L - 1e-9) tip.nodes.push_back(i);
  mesh.nodesets.push_back(tip);
  folder.add("tipped.exo", mesh);
  for (const char* as : {"mesh", "superelement"}) {
    Way way{.as = as, .basis = "craig-bampton, modes: 0", .mesh = "tipped.exo"};
    way.interface = "[x_min, x_max, tip]";
    way.reactions = "bar.x_min";
    way.boundary = held("x_min");
    way.more = "loads:\n  - {instance: bar, surface: tip, moment: [0, 0, 1.0e-4]}\n";
    const Ran ran = folder.run(scene(way));
    EXPECT_NEAR(last(reaction(ran, "x_min").moment)[2], -M, 1e-9 * M) << as;
    EXPECT_LT(last(reaction(ran, "x_min").force).norm(), 1e-8 * M / b) << as;
    // Strain energy M theta / 2
    EXPECT_NEAR(2 * ran.result.total.back() / M, M * L / EI, 0.01 * M * L / EI) << as;
    EXPECT_NEAR(last(ran.monitor("bar.x_max").mean_position)[1] - b / 2, M * L * L / (2 * EI),
                0.01 * M * L * L / (2 * EI))
        << as;
  }
}

// Superelements with all modes move as their mesh, placed in any way; sets turn about points and
// swing, with damping, loads and gravity.
TEST_F(UnevenSupports, EveryBodyMovesAlike) {
  for (const char* placed : {"", ", rotation: [0, 90, 0]", ", rotation: [20, 30, 40], mirror: y"}) {
    for (const char* mass : {"lumped", "consistent"}) {
      Way way{.as = "mesh",
              .time = "integrator: newmark, step: 0.002",
              .mesh = "many.exo",
              .nu = "0.3",
              .placed = placed,
              .damping = ", damping: {beta: 0.001}",
              .mass = mass};
      way.end = 0.2;
      way.every = 0.02;
      way.boundary =
          held("x_min", ", angular_velocity: [1, -2, 3], history: {sine: {frequency_hz: 7}}") +
          held("x_max",
               ", velocity: [0.3, 0, 0.2], angular_velocity: [0.5, 2, 1], about: [1, 2, 3], "
               "history: {time: [0, 0.1, 0.2], value: [0, 1, 0]}");
      way.more =
          "loads:\n  - {gravity: [0, 1, -2]}\n  - {instance: bar, surface: x_max, force: [1, 2, "
          "3], history: {time: [0, 1], value: [0, 1]}}\n";
      const Ran mesh = folder.run(scene(way));
      EXPECT_LT(test::energy_residual(mesh.result), 1e-11);
      std::vector<Ran> others;
      way.as = "superelement";
      others.push_back(folder.run(scene(way)));
      folder.diagonal_limit = 0;
      others.push_back(folder.run(scene(way)));
      folder.diagonal_limit.reset();
      for (const Ran& ran : others) {
        EXPECT_LT(test::energy_residual(ran.result), 1e-10);
        for (const char* set : {"x_min", "x_max"}) {
          EXPECT_LT(largest_difference(reaction(ran, set).force, reaction(mesh, set).force), 1e-8)
              << placed << mass;
          EXPECT_LT(largest_difference(reaction(ran, set).moment, reaction(mesh, set).moment),
                    1e-8);
        }
        EXPECT_LT(
            largest_difference(ran.body("bar").angular_momentum, mesh.body("bar").angular_momentum),
            1e-8);
      }
      // The sum of all sets is what the instance's momentum says
      for (std::size_t i = 1; i < mesh.result.time.size(); ++i)
        EXPECT_LT((at(reaction(mesh, "x_min").force, i) + at(reaction(mesh, "x_max").force, i) -
                   at(mesh.body("bar").reaction, i))
                      .norm(),
                  1e-9 * at(mesh.body("bar").reaction, i).norm() + 1e-12);
    }
  }
}

// Supports that do move alike give the same by shapes, which reactions ask for, as in axes that
// move with them: in contact with a wall and by friction, in motion and in statics.
TEST_F(UnevenSupports, AlikeMotionIsTheSameByBothWays) {
  for (const char* as : {"superelement", "mesh"}) {
    for (const char* time : {"integrator: exact", "integrator: central-difference, step: 0.002",
                             "integrator: newmark, step: 0.002", "static: true, step: 0.1"}) {
      for (const char* basis :
           {"craig-bampton, modes: 12", "massless, modes: 12", "characteristic, modes: 12"}) {
        Way way{.as = as, .basis = basis, .time = time, .mesh = "many.exo"};
        const bool is_plain = way.basis.find("craig") == 0;
        if (!is_plain && (way.as == "mesh" || way.time.find("newmark") != std::string::npos))
          continue;
        way.end = 2;
        way.boundary = held("x_min",
                            ", displacement: [0.3, 0.1, 0], history: {time: [0, 1.5], "
                            "value: [0, 1]}");
        way.more =
            "walls:\n  stop: {plane: {point: [1.1, 0, 0], normal: [-1, 0, 0]}}\ncontact:\n  - "
            "{between: [bar.x_max, stop], friction: 0.2}\n";
        way.reactions = "";
        const Ran alike = folder.run(scene(way));
        way.reactions = "bar.x_min";
        const Ran ran = folder.run(scene(way));
        const std::string name = way.as + " " + way.time + " " + way.basis;
        const bool is_still = way.time.find("static") != std::string::npos;
        // Statics stop where a step is round-off of the energy
        EXPECT_LT(largest_difference(ran.monitor("bar.x_max").mean_position,
                                     alike.monitor("bar.x_max").mean_position),
                  is_still ? 1e-8 : 1e-9)
            << name;
        EXPECT_LT(largest_difference(reaction(ran, "x_min").force, alike.body("bar").reaction),
                  is_plain ? 1e-6 : 0.2)
            << name;
        EXPECT_LT(test::energy_residual(ran.result), 1e-10) << name;
      }
    }
  }
}

TEST_F(UnevenSupports, RestartsGoOnBitForBit) {
  for (const char* as : {"superelement", "mesh"})
    for (const char* time :
         {"integrator: exact", "integrator: newmark, step: 0.002", "static: true, step: 0.02"}) {
      Way way{.as = as, .time = time, .mesh = "many.exo"};
      way.boundary = held("x_min") +
                     held("x_max", ", rotation: [3, 0, 1], history: {time: [0, 1], value: [0, 1]}");
      test::expect_same_bits(test::restarted(folder, scene(way), 0.45), std::string(as) + time);
    }
}

// Points with six dofs at the ends: their rotations turn with them, as rigid faces do; placed in a
// mirror, too.
TEST_F(UnevenSupports, PointsOfTheInterfaceTurn) {
  for (const char* placed : {"", ", rotation: [20, 30, 40], mirror: y"}) {
    Way faces{.time = "integrator: newmark, step: 0.01",
              .mesh = "many.exo",
              .nu = "0.3",
              .placed = placed};
    const std::string motion =
        ", displacement: [0.01, 0.02, 0], rotation: [1, -2, 3], history: {time: [0, 1], value: "
        "[0, 1]}";
    faces.boundary = held("x_min") + held("x_max", motion);
    const Ran of_faces = folder.run(scene(faces));
    const std::string points =
        "materials:\n  soft: {youngs_modulus: 200, poissons_ratio: 0.3, density: 1}\ncomponents:\n "
        " bar: {mesh: many.exo, material: soft, mass: lumped, points: {left: {surface: x_min, "
        "coupling: rigid}, right: {surface: x_max, coupling: rigid}}, reduction: {modes: 135, "
        "points: [left, right], superelement: points.h5}}\ninstances:\n  bar: {component: bar" +
        std::string(placed) + "}\nboundary:\n" + held("left") + held("right", motion) +
        "time: {end: 1, integrator: newmark, step: 0.01}\noutput: {every: 0.1, reactions: "
        "[bar.left, bar.right]}\n";
    const Ran of_points = folder.run(points);
    for (const bool is_left : {true, false}) {
      const auto &a = reaction(of_points, is_left ? "left" : "right"),
                 &b = reaction(of_faces, is_left ? "x_min" : "x_max");
      EXPECT_LT(largest_difference(a.force, b.force), 1e-8) << placed;
      EXPECT_LT(largest_difference(a.moment, b.moment), 1e-8) << placed;
    }
    EXPECT_LT(test::energy_residual(of_points.result), 1e-10);
  }
}

TEST_F(UnevenSupports, ReactionsOfSupportsAtRestThatShareNodesBalanceLoads) {
  Way way{.as = "mesh", .mesh = "many.exo", .reactions = "bar.x_min"};
  way.boundary = held("x_min") + held("y_min", "", "[y]");
  way.more = "loads: [{instance: bar, surface: x_max, force: [1, 2, 3]}]\n";
  const Vector3 force = last(reaction(folder.run(scene(way)), "x_min").force);
  EXPECT_NEAR(force[0], -1, 1e-9);
  EXPECT_NEAR(force[2], -3, 1e-9);
}

// A rigid body turns with its supports: the moment is that of its inertia about the point.
TEST_F(UnevenSupports, ARigidBodyIsTurned) {
  Way way{.as = "rigid", .time = "integrator: exact", .mesh = "many.exo", .mass = "lumped"};
  way.reactions = "bar.x_min";
  way.boundary = held("x_min", ", angular_acceleration: [0, 0, 0.1], about: [0, 0.15, 0.1]");
  const Ran ran = folder.run(scene(way));
  const double mass = ran.mass("bar"), inertia = mass * (1.0 / 3 + 0.09 / 12);
  for (std::size_t i = 1; i < ran.result.time.size(); ++i) {
    EXPECT_NEAR(at(reaction(ran, "x_min").moment, i)[2], 0.1 * inertia, 1e-12);
    EXPECT_NEAR(at(reaction(ran, "x_min").force, i)[1], 0.1 * mass * 0.5, 1e-12);
  }
  EXPECT_NEAR(last(ran.monitor("bar.x_max").mean_position)[1], 0.15 + 0.05, 1e-12);
  EXPECT_LT(test::energy_residual(ran.result), 1e-12);
  way.boundary = held("x_min") + held("x_max", ", acceleration: [1, 0, 0]");
  EXPECT_SAYS(refusal(way), "a rigid body, move it as one");
}

TEST_F(UnevenSupports, WhatCannotBeIsRefusedByName) {
  const auto expect = [&](const Way& way, const std::string& what) {
    EXPECT_SAYS(refusal(way), what);
  };
  Way way{.time = "integrator: exact"};
  way.reactions = "";
  way.boundary = held("x_min") + held("y_min", ", acceleration: [1, 0, 0]");
  way.as = "mesh";
  expect(way, "moves unlike 'x_min' along x, and they share nodes");
  way.boundary = held("x_min", ", rotation: [1, 0, 0]");
  expect(way, "needs a history");
  way.boundary = held("x_min", ", angular_velocity: [1, 0, 0]", "[x]");
  expect(way, "turns about x, and 'fix' leaves y and z free");
  way.boundary = held("x_min", ", velocity: [1, 0, 0], angular_acceleration: [1, 0, 0]");
  expect(way, "expected 'angular_velocity' there");
  way.boundary = held("x_min", ", velocity: [1, 0, 0], about: [1, 0, 0]");
  expect(way, "is the point of a rotation, and there is none");
  way.boundary = held("x_min");
  way.reactions = "bar.x_max";
  expect(way, "'x_max' of instance 'bar' is not held: expected a set that boundary names (x_min)");
  way.reactions = "bar.x_min";
  way.more =
      "walls:\n  w: {plane: {point: [2, 0, 0], normal: [-1, 0, 0]}}\n"
      "contact:\n  - {between: [bar.x_max, w], enforcement: nodal}\n";
  way.time = "integrator: central-difference";
  expect(way, "enforcement: nodal does not go with supports that move unlike each other");
}

}  // namespace
}  // namespace cbr::uneven_supports_test
