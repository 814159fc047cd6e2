// SPDX-License-Identifier: GPL-3.0-or-later
// What must not change the answer of a random scene. Seeds: CBR_SEEDS=FIRST:COUNT (default 1:100; `make stress` takes thousands); a
// scene that fails is named with the command that repeats it.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cstdio>

#include "tests/stability/random_scene.hpp"
#include "tests/stability/seeds.hpp"

namespace cbr {
namespace {

using test::Change;
using test::Difference;
using test::Ran;
using test::RandomBody;
using test::RandomScene;

struct Variant {
  const char* name;
  bool (*applies)(const RandomScene&);
  void (*change)(RandomScene&, Change&);
};

bool always(const RandomScene&) { return true; }
bool is_free(const RandomScene& scene) { return scene.walls.empty() && scene.held.empty(); }
bool is_reduced(const RandomScene& scene) {
  return std::any_of(scene.bodies.begin(), scene.bodies.end(), [](const RandomBody& b) { return b.reduced; });
}

Matrix3 turn(unsigned seed) {
  return Eigen::AngleAxisd(2.1 + seed, Vector3(1 + seed % 3, -2, 0.7 - seed % 5).normalized()).toRotationMatrix();
}

const Variant variants[] = {
    {"renumbered", always,
     [](RandomScene& scene, Change&) {
       for (RandomBody& b : scene.bodies) b.mesh = test::renumbered_any(b.mesh, scene.seed + 17);
     }},
    {"turned", always, [](RandomScene& scene, Change& change) { change.S = turn(scene.seed), change.shift = Vector3(3, -2, 5); }},
    {"mirrored", always, [](RandomScene& scene, Change& change) { change.S = turn(scene.seed) * Vector3(1, 1, -1).asDiagonal(); }},
    {"moving", is_free, [](RandomScene&, Change& change) { change.boost = Vector3(2, -1, 3); }},
    {"in millimetres and tonnes", always, [](RandomScene&, Change& change) { change.length = 1e3, change.mass = 1e-3; }},
    {"scaled by 1e6", always, [](RandomScene&, Change& change) { change.length = 1e6, change.mass = 1e6, change.time = 1e-6; }},
    {"named the other way", always,
     [](RandomScene& scene, Change&) {
       std::reverse(scene.bodies.begin(), scene.bodies.end());
       for (auto& pair : scene.pairs) std::swap(pair.first, pair.second);
     }},
    {"meshed in place", always, [](RandomScene& scene, Change&) { scene.in_place = true; }},
    {"on two threads", always, [](RandomScene& scene, Change&) { scene.threads = 2; }},
};

// Every mode kept, in one piece and in several.
void keep_all(RandomScene& scene, Index domains) {
  for (RandomBody& b : scene.bodies) {
    if (!b.reduced) continue;
    std::vector<char> kept(static_cast<std::size_t>(b.mesh.coordinates.rows()), 0);
    for (const auto& set : b.interface_sets)
      for (const Index node : set_nodes(b.mesh, set)) kept[static_cast<std::size_t>(node)] = 1;
    b.modes = 3 * std::count(kept.begin(), kept.end(), 0);
    b.pick = "frequency", b.domains = domains;
  }
}

// Nearly all stay below 1e-12; what mortar's quadrature leaves, 1e-10, grows where points begin to slide.
constexpr double allowed = 5e-9;

double largest(const Difference& d) { return std::max({d.positions, d.momenta, d.angular, d.forces, d.energies}); }

void compare(const char* what, const RandomScene& scene, const Ran& plain, const Ran& other, const Change& change,
             test::Worst& worst) {
  const Difference d = test::difference(plain, other, change);
  worst.add(what, largest(d) / allowed, largest(d), scene.seed);
  EXPECT_LT(largest(d), allowed) << what << ": positions " << d.positions << " momenta " << d.momenta << " angular " << d.angular
                                 << " forces " << d.forces << " energies " << d.energies << "; " << scene.text() << "\n  "
                                 << test::command(scene.seed);
}

void try_variant(const Variant& variant, const RandomScene& scene, const Ran& plain, test::Worst& worst) {
  if (!variant.applies(scene)) return;
  RandomScene changed = scene;
  Change change;
  variant.change(changed, change);
  compare(variant.name, scene, plain, run(changed, change), change, worst);
}

void try_domains(const RandomScene& scene, test::Worst& worst) {
  if (!is_reduced(scene)) return;
  RandomScene one = scene, several = scene;
  keep_all(one, 1), keep_all(several, 2);
  compare("in two domains", scene, run(one), run(several), {}, worst);
}

bool touches(const Ran& ran) {
  return std::any_of(ran.result.active.begin(), ran.result.active.end(), [](double n) { return n > 0; }) ||
         ran.result.contact_steps > 0;
}

TEST(RandomScenes, DoNotDependOnHowTheyAreToldOf) {
  const test::Seeds seeds = test::seeds();
  test::Worst worst;
  for (unsigned seed = seeds.first; seed < seeds.first + seeds.count; ++seed) {
    const RandomScene scene = test::random_scene(seed);
    try {
      const Ran plain = run(scene);
      worst.add(touches(plain) ? "with contact" : "without contact", 0, 0, seed);
      worst.add("energy", test::energy_residual(plain.result) / 1e-10, test::energy_residual(plain.result), seed);
      EXPECT_LT(test::energy_residual(plain.result), 1e-10) << scene.text() << "\n  " << test::command(seed);
      // Of many seeds each is changed in three ways of all
      for (std::size_t i = 0; i < std::size(variants); ++i)
        if (seeds.thorough || (i + seed) % 3 == 0) try_variant(variants[i], scene, plain, worst);
      if (seeds.thorough || seed % 3 == 0) try_domains(scene, worst);
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what() << "; " << scene.text() << "\n  " << test::command(seed);
    }
  }
  worst.print();
}

}  // namespace
}  // namespace cbr
