// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/tumbling_blocks.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cstdio>
#include <vector>

namespace cbr::test {

using Eigen::AngleAxisd;

ContactScene tumbling_blocks(const std::string& options, double speed) {
  ContactScene scene;
  for (int i = 0; i < 2; ++i) {
    BodyPart b;
    b.name = i == 0 ? "a" : "b";
    b.mesh = i == 0 ? block_mesh({{3, 2, 2}}) : block_mesh({{2, 3, 2}, Vector3(1, 0.8, 0.7)});
    b.position = i == 0 ? Vector3(0, 0, 0) : Vector3(1.3, 0.35, 0.25);
    const Vector3 axis = i == 0 ? Vector3(1, 2, -1.5) : Vector3(0.5, -1, 2);
    b.rotation = AngleAxisd(0.2, axis.normalized()).toRotationMatrix();
    b.angular_velocity = speed * axis;
    scene.bodies.push_back(b);
  }
  scene.bodies[0].velocity = speed * Vector3(1, 0.3, -0.2);
  scene.pairs = {"{between: all" + options + "}"};
  scene.history = {"a.x_max", "b.x_min"};
  scene.large_rotations = true;
  scene.step = 0.008;
  scene.every = 0.04;
  scene.end = 0.8;
  return scene;
}

double change_of_a_turned_scene(const ContactScene& scene) {
  const Ran plain = run(scene);
  Change turned;
  turned.S = AngleAxisd(2.5, Vector3(0.3, -0.8, 0.5).normalized()).toRotationMatrix();
  turned.shift = Vector3(3, -2, 1);
  turned.boost = Vector3(0.4, -0.2, 0.3);
  Change mirrored;
  mirrored.S = AngleAxisd(0.7, Vector3(0.9, 0.1, -0.5).normalized()).toRotationMatrix() *
               Vector3(1, -1, 1).asDiagonal();
  double most = 0;
  for (const Change& change : {turned, mirrored}) {
    const double d = difference(plain, run(scene, change), change).largest();
    std::printf("%s: %.1e\n", scene.pairs[0].c_str(), d);
    most = std::max(most, d);
  }
  return most;
}

double order_of_small_rotations(const std::function<ContactScene(double speed)>& blocks) {
  std::vector<double> speeds, differences;
  for (const double speed : {1e-2, 1e-3, 1e-4}) {
    ContactScene scene = blocks(speed);
    for (BodyPart& b : scene.bodies) {
      b.angular_velocity.setZero();
      b.rotation.setIdentity();
    }
    scene.bodies[1].position.x() = 1 + 0.02 * speed;
    const Ran large = run(scene);
    scene.large_rotations = false;
    const Ran small = run(scene);
    const auto last = small.result.time.size() - 1;
    const Vector3 moved = at(large.monitor("b.x_min").mean_position, last) -
                          at(small.monitor("b.x_min").mean_position, last);
    speeds.push_back(speed);
    differences.push_back(moved.norm());
    std::printf("speed %.0e: %.2e\n", speed, moved.norm());
  }
  return observed_order(speeds, differences);
}

}  // namespace cbr::test
