// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/build_steps.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "dynamics/run/simulation/run_result.hpp"
#include "dynamics/setup/bodies/turning.hpp"
#include "dynamics/setup/built/instance_elements.hpp"

namespace cbr {
namespace {

// Relative loss of the restoring moment of the weight, at the limit. The loss is 1 at an angle of
// width over height.
constexpr double weight_share = 0.05;

// The vertical axis is the one nearest to gravity.
double limit_of_weight(const Box& box, const Vector3& gravity) {
  const Vector3 edges = box.upper - box.lower;
  Index up = 0;
  gravity.cwiseAbs().maxCoeff(&up);
  const double wide = std::min(edges[(up + 1) % 3], edges[(up + 2) % 3]);
  return edges[up] > 0 ? weight_share * wide / edges[up] : HUGE_VAL;
}

}  // namespace

std::vector<double> turn_limits(const SceneIndex& index, const BuiltScene& built) {
  const Scene& scene = index.scene();
  const Load* gravity = gravity_of(scene);
  std::set<std::string> linked;
  for (const LinkOptions& link : scene.links) {
    linked.insert(link.first.instance);
    linked.insert(link.second.instance);
  }
  std::vector<double> limits;
  for (std::size_t i = 0; i < built.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const bool could = built.instances[i].why_linear.empty() && !index.plan(instance).turns;
    limits.push_back(could ? small_rotation : HUGE_VAL);
    const bool stands = index.plan(instance).may_touch || linked.count(instance.name) > 0;
    if (!could || gravity == nullptr || !stands) continue;
    const Box box = extents(*built.simulation.bodies[i], built.instances[i]);
    limits.back() = std::min(limits.back(), limit_of_weight(box, gravity->value));
  }
  return limits;
}

}  // namespace cbr
