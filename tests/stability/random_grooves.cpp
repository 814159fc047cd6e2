// SPDX-License-Identifier: GPL-3.0-or-later
// What random scenes of two bodies become with a hollow face on the one and a nose on the other.
#include <algorithm>
#include <cmath>

#include "tests/stability/random_dice.hpp"
#include "tests/stability/random_scene.hpp"

namespace cbr::test {
namespace {

// How far out of the plane x = 1 a groove along z is, or a pit of four faces (slope_z > 0); the
// nose is the same upside down.
struct Hollow {
  double slope_y = 0, slope_z = 0;
  double operator()(const Vector3& p) const {
    return slope_y * std::abs(p[1] - 0.5) + slope_z * std::abs(p[2] - 0.5);
  }
};

// Moves what is at x = end (0 or 1) by `hollow`, what is at the other end not at all.
void bend(RandomBody& b, const Hollow& hollow, double end) {
  b.shape.n[1] = 2;
  if (hollow.slope_z > 0) b.shape.n[2] = 2;
  b.shape.map = [warp = b.shape.map, hollow, end](const Vector3& p) {
    return Vector3(warp(p) + Vector3(hollow(p) * (1 - std::abs(p[0] - end)), 0, 0));
  };
  b.mesh = lattice_mesh(b.shape);
  b.modes = std::min(b.modes, interior_dofs(b));
}

}  // namespace

bool make_groove(RandomScene& scene) {
  if (scene.bodies.size() < 2) return false;
  Dice dice(scene.seed ^ 0x7f4a7c15U);
  RandomBody &a = scene.bodies.front(), &b = scene.bodies.back();
  const bool pit = dice.once_in(3);
  constexpr double slopes[] = {0.2, 0.4, 0.7, 1};
  const Hollow hollow{slopes[dice.below(4)], pit ? slopes[dice.below(3)] : 0};
  // Not so sharp that elements of the nose turn over
  const double deepest = 0.5 * (hollow.slope_y + hollow.slope_z),
               sharper = std::min(dice.uniform(0.8, 1.5), 0.7 / deepest);
  bend(a, hollow, 1);
  bend(b, {sharper * hollow.slope_y, sharper * hollow.slope_z}, 0);
  b.position.tail<2>() *= 0.5;
  b.velocity += dice.vector(0.5);
  b.velocity[0] = -dice.uniform(0.8, 1.6);
  // In front of the hollow, as near as the warp of the two leaves safe
  const double gap = dice.uniform(0.05, 0.09);
  for (int iteration = 0; iteration < 3; ++iteration) {
    double nearest = HUGE_VAL;
    for (const Index node : set_nodes(b.mesh, "x_min")) {
      const Vector3 x =
          a.rotation.transpose() *
          (b.rotation * b.mesh.coordinates.row(node).transpose() + b.position - a.position);
      nearest = std::min(nearest, x[0] - 1 - hollow(x));
    }
    b.position[0] += gap - nearest;
  }
  return true;
}

}  // namespace cbr::test
