// SPDX-License-Identifier: GPL-3.0-or-later
// What must not change the answer of a random scene. Seeds: CBR_SEEDS=FIRST:COUNT (default 1:20 and
// fewer; `make stress` takes thousands); a scene that fails is named with the command that repeats
// it.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>

#include "tests/stability/random_scene.hpp"
#include "tests/stability/seeds.hpp"

namespace cbr::invariance_test {
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
// METIS cuts graphs by the order of their nodes: with few modes, other domains are another model.
bool may_be_renumbered(const RandomScene& scene) { return !scene.keeps_numbers; }
bool is_craig_bampton(const RandomBody& b) { return b.reduced && b.basis == "craig-bampton"; }
bool is_reduced(const RandomScene& scene) {
  return std::any_of(scene.bodies.begin(), scene.bodies.end(), is_craig_bampton);
}

Matrix3 turn(unsigned seed) {
  return Eigen::AngleAxisd(2.1 + seed, Vector3(1 + seed % 3, -2, 0.7 - seed % 5).normalized())
      .toRotationMatrix();
}

const Variant variants[] = {
    {"renumbered", may_be_renumbered,
     [](RandomScene& scene, Change&) {
       for (RandomBody& b : scene.bodies) b.mesh = test::renumbered_any(b.mesh, scene.seed + 17);
     }},
    {"turned", always,
     [](RandomScene& scene, Change& change) {
       change.S = turn(scene.seed);
       change.shift = Vector3(3, -2, 5);
     }},
    {"mirrored", always,
     [](RandomScene& scene, Change& change) {
       change.S = turn(scene.seed) * Vector3(1, 1, -1).asDiagonal();
     }},
    {"moving", is_free, [](RandomScene&, Change& change) { change.boost = Vector3(2, -1, 3); }},
    {"in millimetres and tonnes", always,
     [](RandomScene&, Change& change) {
       change.length = 1e3;
       change.mass = 1e-3;
     }},
    {"scaled by 1e6", always,
     [](RandomScene&, Change& change) {
       change.length = 1e6;
       change.mass = 1e6;
       change.time = 1e-6;
     }},
    {"named the other way", always,
     [](RandomScene& scene, Change&) {
       std::reverse(scene.bodies.begin(), scene.bodies.end());
       for (auto& pair : scene.pairs) std::swap(pair.first, pair.second);
     }},
    {"meshed in place", always, [](RandomScene& scene, Change&) { scene.in_place = true; }},
    {"on two threads", always, [](RandomScene& scene, Change&) { scene.threads = 2; }},
};

// Every mode kept, in one piece and in several, which may be reduced again.
void keep_all(RandomScene& scene, Index domains, bool again = false) {
  for (RandomBody& b : scene.bodies) {
    if (!is_craig_bampton(b)) continue;
    b.modes = test::interior_dofs(b);
    b.pick = "frequency";
    b.domains = domains;
    b.second_modes.reset();
    if (again) b.second_modes = b.modes;
  }
}

// Nearly all stay below 1e-12; what mortar's quadrature leaves, 1e-10, grows where points begin to
// slide.
constexpr double allowed = 5e-9;

void compare(const char* what, const RandomScene& scene, const Ran& plain, const Ran& other,
             const Change& change, test::Worst& worst) {
  const Difference d = test::difference(plain, other, change);
  worst.add(what, d.largest() / allowed, d.largest(), scene.seed);
  EXPECT_LT(d.largest(), allowed) << what << ": positions " << d.positions << " momenta "
                                  << d.momenta << " angular " << d.angular << " forces " << d.forces
                                  << " energies " << d.energies << " pairs " << d.pairs << "; "
                                  << scene.text() << "\n  " << test::command(scene.seed);
}

void try_variant(const Variant& variant, const RandomScene& scene, const Ran& plain,
                 test::Worst& worst) {
  if (!variant.applies(scene)) return;
  RandomScene changed = scene;
  Change change;
  variant.change(changed, change);
  compare(variant.name, scene, plain, run(changed, change), change, worst);
}

void try_domains(const RandomScene& scene, test::Worst& worst) {
  if (!is_reduced(scene) || scene.loads_inside) return;
  RandomScene one = scene, several = scene;
  keep_all(one, 1);
  keep_all(several, 2);
  compare("in two domains", scene, run(one), run(several), {}, worst);
}

// With every mode nothing is lost by reducing domains again, nor by leaving the faces that loads
// act on out of the interface.
void try_bases(const RandomScene& scene, test::Worst& worst) {
  if (!is_reduced(scene)) return;
  RandomScene one = scene, other = scene;
  if (scene.loads_inside) {
    for (const test::RandomLoad& load : scene.loads)
      for (RandomBody& b : other.bodies)
        if (load.instance == b.name && is_craig_bampton(b) && load.surface[0] != 'x')
          b.interface_sets.push_back(load.surface);
    keep_all(one, 1);
    keep_all(other, 1);
    compare("loads inside, on the interface", scene, run(one), run(other), {}, worst);
  } else {
    keep_all(one, 1);
    keep_all(other, 2, true);
    compare("two domains, reduced again", scene, run(one), run(other), {}, worst);
  }
}

bool touches(const Ran& ran) {
  return std::any_of(ran.result.active.begin(), ran.result.active.end(),
                     [](double n) { return n > 0; }) ||
         ran.result.contact_steps > 0;
}

// `more`: comparisons beside the variants.
void try_all(const test::Seeds& seeds, RandomScene (*make)(unsigned),
             void (*more)(const RandomScene&, test::Worst&)) {
  test::Worst worst;
  for (unsigned seed = seeds.first; seed < seeds.first + seeds.count; ++seed) {
    const RandomScene scene = make(seed);
    try {
      const Ran plain = run(scene);
      worst.add(touches(plain) ? "with contact" : "without contact", 0, 0, seed);
      worst.add("energy", test::energy_residual(plain.result) / 1e-10,
                test::energy_residual(plain.result), seed);
      EXPECT_LT(test::energy_residual(plain.result), 1e-10)
          << scene.text() << "\n  " << test::command(seed);
      // Of many seeds each is changed in three ways of all
      for (std::size_t i = 0; i < std::size(variants); ++i)
        if (seeds.thorough || (i + seed) % 3 == 0) try_variant(variants[i], scene, plain, worst);
      if (seeds.thorough || seed % 3 == 0) more(scene, worst);
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what() << "; " << scene.text() << "\n  " << test::command(seed);
    }
  }
  worst.print();
}

TEST(RandomScenes, DoNotDependOnHowTheyAreToldOf) {
  try_all(test::seeds(20), test::random_scene, try_domains);
}

TEST(RandomScenes, OfGroovesDoNotDependOnHowTheyAreToldOf) {
  const auto grooves = [](unsigned seed) {
    RandomScene scene = test::random_scene(seed);
    test::make_groove(scene);
    return scene;
  };
  try_all(test::seeds(10), grooves, try_domains);
}

TEST(RandomScenes, OfOtherBasesDoNotDependOnHowTheyAreToldOf) {
  const test::Seeds seeds = test::seeds(8);
  try_all(seeds, test::random_scene_of_bases, try_bases);
  if (seeds.thorough) return;
  // Shear in two directions of the mesh's axes; fixed modes by a Cholesky factor; nodes beyond
  // sharp corners, seen by some axes only
  for (const unsigned once_wrong : {10U, 24U, 117U})
    try_all({once_wrong, 1, true}, test::random_scene_of_bases, try_bases);
}

}  // namespace
}  // namespace cbr::invariance_test
