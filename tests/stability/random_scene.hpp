// SPDX-License-Identifier: GPL-3.0-or-later
// Random scenes by seed: bodies of all element types, reduced or not, constrained, loaded, in
// contact with walls and each other.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/fem/elements/shell.hpp"
#include "tests/stability/lattice_mesh.hpp"
#include "tests/support/contact_scene.hpp"

namespace cbr::test {

struct RandomBody {
  std::string name;
  LatticeShape shape;
  Mesh mesh;
  Material low, high;  // of the blocks low_..., high_...
  std::string element = "hex8-incompatible", mass = "lumped", pick = "frequency";
  bool reduced = false;
  Index modes = 0, domains = 1;
  std::vector<std::string> interface_sets;
  // Other than Craig-Bampton: `reduction` has further keys of the scene, "massless_modes: free";
  // second_modes: of domains that are reduced again
  std::string basis = "craig-bampton", reduction;
  std::optional<Index> second_modes;
  Matrix3 rotation = Matrix3::Identity();
  Vector3 position = Vector3::Zero(), velocity = Vector3::Zero();
};

struct RandomWall {
  std::string name, kind;  // plane | sphere | cylinder
  Vector3 point, direction;
  double radius = 0;
};

struct RandomLoad {
  std::string instance, surface, kind;  // traction | force | gravity
  Vector3 value;
  std::vector<double> time, factor;  // empty: constant
};

struct RandomPair {
  std::string first, second, options;
};

inline const ShellProperties random_skin{{50, 0.25, 0.5}, 0.05};

struct RandomScene {
  unsigned seed = 0;
  std::vector<RandomBody> bodies;
  std::vector<RandomWall> walls;
  std::vector<RandomLoad> loads;
  std::vector<RandomPair> pairs;
  std::vector<std::string> held;    // "a.end"
  std::optional<std::string> skin;  // "a.x_max"
  std::string integrator = "exact";
  double cfl = 0.7, every = 0, end = 0;
  bool loads_inside = false;   // on surfaces that a reduced body does not retain
  bool keeps_numbers = false;  // another order of elements gives another model
  // Allowed changes of the scene
  bool in_place = false;
  int threads = 1;

  bool has(const std::string& option) const;  // in the options of any pair
  std::string text() const;                   // description of the contents
};

// The same seed gives the same scene. Surfaces that shall meet are close and approach each other in
// general positions. So contact does not depend on round-off.
RandomScene random_scene(unsigned seed);

// The same with bodies of other bases, domains, second reductions, loads inside reduced parts, and
// steps above the critical one. From a separate random stream, so that random_scene() stays the
// same.
RandomScene random_scene_of_bases(unsigned seed);

// Makes x_max of the first body a groove or a pit, and of the second a nose that enters it, from
// any side. False, without a change, for a scene of one body.
bool make_groove(RandomScene& scene);

// 3 per node that is in no interface set.
Index interior_dofs(const RandomBody& body);

// The scene with a change of axes, units or common motion, as YAML; and its run.
std::string yaml(const RandomScene& scene, const Change& change = {});
Ran run(const RandomScene& scene, const Change& change = {});
// both_sides: DetectionOptions::both_sides.
Ran run_in(SceneFolder& folder, const RandomScene& scene, const Change& change = {},
           bool both_sides = true);

}  // namespace cbr::test
