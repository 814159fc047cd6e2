// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes of bodies in contact, which can be rotated, mirrored, scaled and set in motion as a whole.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/support/scene_run.hpp"

namespace cbr::test {

// x' = length * (S x) + shift, S orthogonal with determinant 1 or -1; velocities get a boost. Units
// of other quantities follow.
struct Change {
  Matrix3 S = Matrix3::Identity();
  Vector3 shift = Vector3::Zero(), boost = Vector3::Zero();
  double length = 1, mass = 1, time = 1;
  Vector3 spin(const Vector3& w) const { return S.determinant() * (S * w) / time; }
  double speed() const { return length / time; }
  double force() const { return mass * length / (time * time); }
  double energy() const { return force() * length; }
  Vector3 point(const Vector3& x) const { return length * (S * x) + shift; }
  Vector3 direction(const Vector3& n) const { return S * n; }
  Vector3 velocity(const Vector3& v) const { return speed() * (S * v) + boost; }
};

struct BodyPart {
  std::string name;
  Mesh mesh;
  bool full = true;  // as: mesh
  double youngs_modulus = 100, poissons_ratio = 0.3, density = 1;
  std::vector<std::string> interface_sets{"x_min", "x_max"};
  Index modes = 12;
  std::string basis = "craig-bampton";
  Matrix3 rotation = Matrix3::Identity();
  Vector3 position = Vector3::Zero(), velocity = Vector3::Zero();
  Vector3 angular_velocity = Vector3::Zero();  // for scenes with large rotation
};

struct ContactScene {
  std::vector<BodyPart> bodies;
  std::vector<std::string> pairs;  // "{between: [a.x_max, b.x_min], enforcement: ...}"
  struct Ball {
    std::string name;
    Vector3 center;
    double radius;
  };
  std::vector<Ball> walls;
  std::vector<std::string> history;  // "a.x_max", ...
  Vector3 gravity = Vector3::Zero();
  double end = 1, every = 0.1, step = 0.01;
  std::string integrator = "exact";
  bool large_rotations = false;
  int threads = 1;
  bool in_place = false;  // meshes are placed at their instances' positions
};

// [rx, ry, rz] in degrees of a rotation: about the fixed x, then y, then z axis.
Vector3 degrees(const Matrix3& R);

std::string yaml(const ContactScene& scene, const Change& change);

Ran run(const ContactScene& scene, const Change& change = {}, const RunOptions& options = {});

// Differences of two runs of one scene after undoing the change of the second. The largest
// difference of each quantity, relative to its largest value in the run. Bodies and surfaces are
// matched by name, pairs by index.
struct Difference {
  double positions = 0, momenta = 0, angular = 0, forces = 0, energies = 0, pairs = 0;
  double largest() const {
    return std::max({positions, momenta, angular, forces, energies, pairs});
  }
};

Difference difference(const Ran& plain, const Ran& changed, const Change& change);

// Two oblique blocks as full meshes with nonmatching faces. The first flies with spin into the
// second, which spins too. Wave speeds are about 10. `options`: further contact options, ",
// friction: 0.3".
ContactScene tumbling_blocks(const std::string& options, double speed);

// Change of a scene under rotation, translation and boost, or rotation and reflection, relative to
// its values.
double change_of_a_turned_scene(const ContactScene& scene);

// Blocks with slow impacts and small rotations: the order in the speed of the difference between
// runs with large rotation and linear ones.
double order_of_small_rotations(const std::function<ContactScene(double speed)>& blocks);

}  // namespace cbr::test
