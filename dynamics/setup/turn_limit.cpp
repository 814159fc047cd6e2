// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/turn_limit.hpp"

#include <algorithm>

#include "common/linalg/dense.hpp"
#include "dynamics/run/simulation/run_result.hpp"
#include "dynamics/setup/bodies/turning.hpp"

namespace cbr {
namespace {

// A body of this width and height that leans by their ratio times this loses so much of the moment
// by which its weight sets it upright.
constexpr double weight_share = 0.05;

}  // namespace

double turn_limit(const SceneIndex& index, const Instance& instance, const Points& positions) {
  const Scene& scene = index.scene();
  const Load* gravity = gravity_of(scene);
  const auto is_end = [&](const LinkOptions& link) {
    return link.first.instance == instance.name || link.second.instance == instance.name;
  };
  const bool stands =
      index.may_touch(instance) || std::any_of(scene.links.begin(), scene.links.end(), is_end);
  if (gravity == nullptr || !stands || positions.rows() == 0) return small_rotation;
  const Vector3 up = gravity->value.normalized();
  const Vector height = positions * up;
  const Points level = positions - height * up.transpose();
  const Points arms = level.rowwise() - level.colwise().mean();
  // The narrowest level direction is the second of three: across it is `up`, of extent 0
  const Vector3 across = symmetric_eigen3(arms.transpose() * arms).vectors.col(1);
  const Vector width = arms * across;
  const double tall = height.maxCoeff() - height.minCoeff();
  const double wide = width.maxCoeff() - width.minCoeff();
  return tall > 0 ? std::min(small_rotation, weight_share * wide / tall) : small_rotation;
}

}  // namespace cbr
