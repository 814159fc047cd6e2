// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes with a skin: shells without modulus and density are none; the paper's change nothing that
// matters; real ones act as plates and membranes do, and keep momentum and energy.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "tests/support/scene_run.hpp"

namespace cbr::shell_skin_test {
namespace {

using test::at;
using test::Ran;
using test::SceneFolder;
using test::text;

const std::string all_sides = "x_min, x_max, y_min, y_max, z_min, z_max";

std::string skin(const std::string& surfaces, double E, double rho, double t) {
  return "skin: {surfaces: [" + surfaces + "], youngs_modulus: " + text(E) +
         ", poissons_ratio: 0.3, density: " + text(rho) + ", thickness: " + text(t) + "}\n";
}

double largest_difference(const Series3& a, const Series3& b) {
  EXPECT_EQ(a.values.size(), b.values.size());
  double worst = 0, scale = 0;
  for (std::size_t i = 0; 3 * i < a.values.size(); ++i) {
    worst = std::max(worst, (at(a, i) - at(b, i)).norm());
    scale = std::max(scale, (at(b, i) - at(b, 0)).norm());
  }
  return worst / scale;
}

// The paper's block under a short load on the middle of its face x_max, on a coarse mesh.
struct SharpLoad {
  std::string kind = "mesh", integrator = "central-difference", step = "{cfl: 0.8}", skin,
              interface = "x_max";
  int modes = 60;
  std::string yaml() const {
    return "materials:\n  steel: {youngs_modulus: 5.17e12, poissons_ratio: 0.3, density: 7836}\n"
           "components:\n  block: {mesh: block.exo, material: steel, reduction: {interface: [" +
           interface + "], modes: " + std::to_string(modes) +
           "}}\ninstances:\n  block: {component: block, as: " + kind +
           ", position: [-0.0508, 0, 0]}\n" + skin +
           "loads:\n  - {instance: block, surface: x_max, traction: [-1, 0, 0], "
           "history: {time: [0, 3e-7, 6e-7], value: [0, 6.9e8, 0]}}\n"
           "time: {end: 3e-6, step: " +
           step + ", integrator: " + integrator +
           "}\n"
           "output: {every: 1e-7, history: [block.x_max]}\n";
  }
};

Mesh paper_block() { return test::block_mesh({{6, 3, 4}, {0.0508, 0.0254, 0.0381}}); }

struct Runs {
  std::string kind, integrator, step, interface, surfaces;
};
const std::vector<Runs> every_way = {
    {"mesh", "central-difference", "8e-8", "x_max", all_sides},
    {"mesh", "newmark", "2e-8", "x_max", all_sides},
    {"superelement", "central-difference", "8e-8", "x_max", "x_max"},
    {"superelement", "newmark", "2e-8", "x_max", "x_max"},
    {"superelement", "exact", "2e-8", all_sides, all_sides}};

TEST(Skin, WithoutModulusAndDensityChangesNoBit) {
  SceneFolder folder;
  folder.add("block.exo", paper_block());
  for (const Runs& way : every_way) {
    SharpLoad scene{way.kind, way.integrator, way.step, "", way.interface};
    const Ran without = folder.run(scene.yaml());
    for (const auto& [E, rho, t] : {std::array{0.0, 0.0, 2.5e-4}, std::array{6.9e3, 0.11, 0.0}}) {
      scene.skin = skin(way.surfaces, E, rho, t);
      const Ran with = folder.run(scene.yaml());
      EXPECT_EQ(with.monitor("block.x_max").mean_position.values,
                without.monitor("block.x_max").mean_position.values);
      EXPECT_EQ(with.result.total, without.result.total);
      EXPECT_EQ(with.result.steps, without.result.steps);
    }
  }
}

// The paper's eight settings. Measured: see docs/verification.md.
TEST(Skin, ThePapersShellsHaveNoInfluence) {
  SceneFolder folder;
  folder.add("block.exo", paper_block());
  double worst = 0;
  for (const Runs& way : every_way) {
    SharpLoad scene{way.kind, way.integrator, way.step, "", way.interface};
    const Ran without = folder.run(scene.yaml());
    for (const double E : {6.9e3, 6.9e-5})
      for (const double rho : {0.11, 1.1e-5})
        for (const double t : {2.5e-10, 2.5e-4}) {
          scene.skin = skin(way.surfaces, E, rho, t);
          const Ran with = folder.run(scene.yaml());
          const double change = largest_difference(with.monitor("block.x_max").mean_position,
                                                   without.monitor("block.x_max").mean_position);
          EXPECT_LE(change, 1e-4) << way.kind << ' ' << way.integrator << ' ' << E << ' ' << rho
                                  << ' ' << t;
          worst = std::max(worst, change);
          EXPECT_LE(test::energy_residual(with.result), 1e-9) << way.kind << ' ' << way.integrator;
        }
  }
  RecordProperty("largest_change", text(worst));
  EXPECT_GT(worst, 0);  // they are there
}

// A bar of one element across with shells on its four sides, held at one end, pulled at the other
// by a pulse: with nu = 0 a bar of E A and rho A in sum. d'Alembert: u(L, t) = c / (E A) (I(t) - 2
// I(t - 2 L / c) + 2 I(t - 4 L / c) - ...), I the pulse's impulse.
struct SkinnedBar {
  static constexpr double b = 0.1, L = 1, E = 100, rho = 1, E_s = 3000, rho_s = 8, t_s = 0.005,
                          pulse = 0.2, force = 0.01;
  static constexpr double EA = E * b * b + 4 * E_s * b * t_s,
                          rhoA = rho * b * b + 4 * rho_s * b * t_s;
  static double impulse(double t) {
    const double half = pulse / 2, s = std::max(t, 0.0);
    if (s >= pulse) return force * half;
    return s < half ? force * s * s / (2 * half)
                    : force * (half - (pulse - s) * (pulse - s) / (2 * half));
  }
  static double tip(double t) {
    const double c = std::sqrt(EA / rhoA);
    return c / EA * (impulse(t) - 2 * impulse(t - 2 * L / c) + 2 * impulse(t - 4 * L / c));
  }
};

double bar_error(Index n, const std::string& kind, const std::string& integrator) {
  using S = SkinnedBar;
  SceneFolder folder;
  folder.add("bar.exo", test::block_mesh({{n, 1, 1}, {S::L, S::b, S::b}}));
  const Ran ran = folder.run(
      "materials:\n  soft: {youngs_modulus: 100, poissons_ratio: 0, density: 1}\n"
      "components:\n  bar: {mesh: bar.exo, material: soft, reduction: {interface: [y_min, y_max], "
      "modes: 0}}\n"
      "instances:\n  bar: {component: bar, as: " +
      kind +
      "}\n"
      "skin: {surfaces: [y_min, y_max, z_min, z_max], youngs_modulus: " +
      text(S::E_s) + ", poissons_ratio: 0, density: " + text(S::rho_s) +
      ", thickness: " + text(S::t_s) +
      "}\n"
      "boundary:\n  - {instance: bar, nodes: x_min, fix: [x, y, z]}\n"
      "loads:\n  - {instance: bar, surface: x_max, force: [1, 0, 0], history: {time: [0, 0.1, "
      "0.2], value: [0, 0.01, 0]}}\n"
      "time: {end: 0.27, step: " +
      text(0.02 / static_cast<double>(n)) + ", integrator: " + integrator +
      "}\n"
      "output: {every: 0.01, history: [bar.x_max]}\n");
  EXPECT_NEAR(ran.mass("bar") / (S::rhoA * S::L), 1, 1e-12);
  EXPECT_LE(test::energy_residual(ran.result), 1e-9);
  const double scale = SkinnedBar::tip(SkinnedBar::pulse);
  return test::rms(ran.result, ran.monitor("bar.x_max").mean_position,
                   [](double t) {
                     return Vector3(SkinnedBar::L + SkinnedBar::tip(t), SkinnedBar::b / 2,
                                    SkinnedBar::b / 2);
                   }) /
         scale;
}

TEST(Skin, StiffHeavyShellsOnABarAreABar) {
  for (const std::string kind : {"mesh", "superelement"})
    for (const std::string integrator : {"central-difference", "newmark"}) {
      const double coarse = bar_error(16, kind, integrator), fine = bar_error(32, kind, integrator);
      RecordProperty(kind + "_" + integrator, text(fine));
      EXPECT_LE(fine, 0.002) << kind << ' ' << integrator;
      EXPECT_GE(std::log2(coarse / fine), 1.8) << kind << ' ' << integrator;
    }
}

// A cantilever with a soft core between two stiff faces (at the core's surfaces), its tip loaded
// slowly, so that it comes to rest but for a small swing:
//   w = P L^3 / (3 D) + P L / S,  D = E_c b h^3 / 12 + E_f b t (h^2 / 2 + t^2 / 6),  S = G_c b h
//   (faces stiff, core in pure shear).
TEST(Skin, SandwichStripBends) {
  const double L = 1, b = 0.1, h = 0.1, E_c = 100, E_f = 1e4, t = 0.004, P = 1e-4;
  const double D = E_c * b * h * h * h / 12 + E_f * b * t * (h * h / 2 + t * t / 6),
               S = E_c / 2 * b * h;
  const double exact = P * (L * L * L / (3 * D) + L / S);
  SceneFolder folder;
  folder.add("strip.exo", test::block_mesh({{20, 2, 4}, {L, b, h}}));
  // kind, integrator, the faces' density: 0 condenses their rotations
  using Way = std::array<std::string, 3>;
  for (const auto& [kind, integrator, density] :
       {Way{"mesh", "newmark", "8"}, Way{"mesh", "newmark", "0"},
        Way{"superelement", "newmark", "8"}, Way{"superelement", "exact", "8"}}) {
    const Ran ran = folder.run(
        "materials:\n  soft: {youngs_modulus: 100, poissons_ratio: 0, density: 1}\n"
        "components:\n  strip: {mesh: strip.exo, material: soft, reduction: {interface: [z_min, "
        "z_max, x_min, x_max], modes: 20}}\n"
        "instances:\n  strip: {component: strip, as: " +
        kind +
        "}\n"
        "skin: {surfaces: [z_min, z_max], youngs_modulus: " +
        text(E_f) + ", poissons_ratio: 0, density: " + density + ", thickness: " + text(t) +
        "}\n"
        "boundary:\n  - {instance: strip, nodes: x_min, fix: [x, y, z]}\n"
        "loads:\n  - {instance: strip, surface: x_max, force: [0, 0, 1], history: {time: [0, 8], "
        "value: [0, " +
        text(P) +
        "]}}\n"
        "time: {end: 11.2, step: 0.02, integrator: " +
        integrator +
        "}\n"
        "output: {every: 0.02, history: [strip.x_max]}\n");
    // Two periods of the first mode, about 1.6 each, are averaged.
    const Series3& x = ran.monitor("strip.x_max").mean_position;
    double mean = 0;
    for (std::size_t i = ran.result.time.size() - 160; i < ran.result.time.size(); ++i)
      mean += (at(x, i)(2) - h / 2) / 160;
    RecordProperty(kind + "_" + integrator + "_" + density, text(mean / exact));
    EXPECT_NEAR(mean / exact, 1, 0.002) << kind << ' ' << integrator << ' ' << density;
    EXPECT_LE(test::energy_residual(ran.result), 1e-8) << kind << ' ' << integrator;
  }
}

// Two free blocks with skins collide off their axes.
std::string collision(const std::string& kind, const std::string& integrator,
                      const std::string& step, double E, double rho) {
  return "materials:\n  steel: {youngs_modulus: 2.1e11, poissons_ratio: 0.3, density: 7850}\n"
         "components:\n  block: {mesh: block.exo, material: steel, reduction: {interface: [x_min, "
         "x_max], modes: 30}}\n"
         "instances:\n  left: {component: block, as: " +
         kind +
         ", velocity: [5, 0.3, 0]}\n"
         "  right: {component: block, as: " +
         kind + ", position: [0.05081, 0.004, 0.006], velocity: [-5, 0, 0.2]}\n" +
         skin("x_min, x_max", E, rho, 1e-3) +
         "contact:\n  - {between: [left.x_max, right.x_min], enforcement: impulse}\n"
         "time: {end: 3e-5, step: " +
         step + ", integrator: " + integrator + "}\noutput: {every: 1e-6, history: [left.x_max]}\n";
}

TEST(Skin, MomentumAndEnergyBalance) {
  SceneFolder folder;
  folder.add("block.exo", paper_block());
  for (const Runs& way : every_way)
    for (const auto& [E, rho] : {std::array{2.1e11, 7850.0}, {2.1e11, 0.0}, {0.0, 7850.0}}) {
      const std::string what =
          way.kind + " " + way.integrator + ", E " + text(E) + ", rho " + text(rho);
      const Ran ran = folder.run(collision(
          way.kind, way.integrator, way.integrator == "newmark" ? "5e-7" : "{cfl: 0.8}", E, rho));
      const auto &left = ran.body("left"), &right = ran.body("right");
      const double scale = at(left.momentum, 0).norm();
      double worst = 0, turned = 0;
      for (std::size_t i = 0; i < ran.result.time.size(); ++i) {
        worst = std::max(worst, (at(left.momentum, i) + at(right.momentum, i) -
                                 at(left.momentum, 0) - at(right.momentum, 0))
                                    .norm());
        turned = std::max(turned, (at(left.momentum, i) - at(left.momentum, 0)).norm());
      }
      EXPECT_LE(worst, 1e-12 * scale) << what;
      EXPECT_GE(turned, 0.5 * scale) << what << ": they should meet";
      EXPECT_NEAR(ran.mass("left") / (0.0254 * 0.0381 * (7850 * 0.0508 + rho * 0.002)), 1, 1e-12)
          << what;
      EXPECT_NEAR(at(left.momentum, 0)(0) / (5 * ran.mass("left")), 1, 1e-12) << what;
      EXPECT_LE(test::energy_residual(ran.result), 1e-10) << what;
    }
}

// Rotations turn, and are mirrored, with the instance.
TEST(Skin, TurnsWithTheInstance) {
  SceneFolder folder;
  folder.add("block.exo", paper_block());
  const auto scene = [](const std::string& kind, const std::string& integrator,
                        const std::string& place, const Vector3& traction) {
    return "materials:\n  steel: {youngs_modulus: 2.1e11, poissons_ratio: 0.3, density: 7850}\n"
           "components:\n  block: {mesh: block.exo, material: steel, reduction: {interface: "
           "[x_min, x_max], modes: 30}}\n"
           "instances:\n  block: {component: block, as: " +
           kind + ", " + place + "}\n" + skin("x_max", 2.1e11, 7850, 2e-3) +
           "loads:\n  - {instance: block, surface: x_max, traction: " + text(traction) +
           ", history: {time: [0, 1e-6, 5e-6], value: [0, 1e8, 0]}}\ntime: {end: 2e-5, step: 1e-7, "
           "integrator: " +
           integrator + "}\noutput: {every: 1e-6, history: [block.x_max]}\n";
  };
  const double angle = 0.7;
  const Vector3 traction(-1, 0.4, 0.3);
  const std::vector<std::pair<std::string, Matrix3>> places = {
      {"rotation: [0, 0, " + text(angle * 180 / std::numbers::pi) + "]",
       Eigen::AngleAxisd(angle, Vector3::UnitZ()).toRotationMatrix()},
      {"mirror: y", Vector3(1, -1, 1).asDiagonal()}};
  for (const auto& [kind, integrator] : {std::array<std::string, 2>{"mesh", "central-difference"},
                                         {"superelement", "newmark"},
                                         {"superelement", "exact"}}) {
    const Ran straight = folder.run(scene(kind, integrator, "position: [0, 0, 0]", traction));
    for (const auto& [place, T] : places) {
      const Ran turned = folder.run(scene(kind, integrator, place, T * traction));
      const Series3 &x = straight.monitor("block.x_max").mean_velocity,
                    &y = turned.monitor("block.x_max").mean_velocity;
      double worst = 0, scale = 0;
      for (std::size_t i = 0; i < straight.result.time.size(); ++i) {
        worst = std::max(worst, (T * at(x, i) - at(y, i)).norm());
        scale = std::max(scale, at(x, i).norm());
      }
      EXPECT_LE(worst, 1e-9 * scale) << kind << ' ' << integrator << ' ' << place;
    }
  }
}

}  // namespace
}  // namespace cbr::shell_skin_test
