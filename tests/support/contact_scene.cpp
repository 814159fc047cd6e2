// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/contact_scene.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

namespace cbr::test {

Vector3 degrees(const Matrix3& R) {
  const double d = 180 / std::numbers::pi;
  return {d * std::atan2(R(2, 1), R(2, 2)), d * std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0))),
          d * std::atan2(R(1, 0), R(0, 0))};
}

std::string yaml(const ContactScene& scene, const Change& change) {
  std::string materials = "materials:\n", components = "components:\n", instances = "instances:\n",
              contact = "contact:\n", walls;
  const bool mirrored = change.S.determinant() < 0;
  const Matrix3 M = mirrored ? Matrix3(Vector3(-1, 1, 1).asDiagonal()) : Matrix3::Identity();
  for (const BodyPart& b : scene.bodies) {
    materials += "  m_" + b.name + ": {youngs_modulus: " +
                 text(b.youngs_modulus * change.force() / std::pow(change.length, 2)) +
                 ", poissons_ratio: " + text(b.poissons_ratio) +
                 ", density: " + text(b.density * change.mass / std::pow(change.length, 3)) + "}\n";
    components += "  c_" + b.name + ": {mesh: " + b.name + ".exo, material: m_" + b.name;
    if (!b.full) {
      components += ", reduction: {basis: " + b.basis + ", modes: " + std::to_string(b.modes) +
                    ", interface: [";
      for (const auto& set : b.interface_sets)
        components += set + (&set == &b.interface_sets.back() ? "]}" : ", ");
    }
    components += "}\n  ";
    instances += "  " + b.name + ": {component: c_" + b.name +
                 ", as: " + (b.full ? "mesh" : "superelement") +
                 ", velocity: " + text(change.velocity(b.velocity));
    if (!scene.in_place)
      instances += ", position: " + text(change.point(b.position)) +
                   ", rotation: " + text(degrees(change.S * b.rotation * M)) +
                   (mirrored ? ", mirror: x" : "");
    if (!b.angular_velocity.isZero())
      instances += ", angular_velocity: " + text(change.spin(b.angular_velocity));
    instances += "}\n";
    components.resize(components.size() - 2);
  }
  for (const auto& wall : scene.walls)
    walls += "  " + wall.name + ": {sphere: {center: " + text(change.point(wall.center)) +
             ", radius: " + text(change.length * wall.radius) + "}}\n";
  if (!walls.empty()) walls = "walls:\n" + walls;
  for (const auto& pair : scene.pairs) contact += "  - " + pair + "\n";
  std::string history;
  for (const auto& surface : scene.history) history += (history.empty() ? "" : ", ") + surface;
  std::string loads;
  if (!scene.gravity.isZero())
    loads = "loads: [{gravity: " +
            text(Vector3(change.S * scene.gravity * change.speed() / change.time)) + "}]\n";
  const double h = change.time * scene.step * (1 + 1e-10);
  return materials + components + instances + walls + contact + loads +
         "time: {end: " + text(change.time * scene.end) + ", step: " + text(h) +
         ", integrator: " + scene.integrator + (scene.large_rotations ? ", rotations: large" : "") +
         "}\noutput: {every: " + text(change.time * scene.every) + ", history: [" + history +
         "]}\n";
}

Ran run(const ContactScene& scene, const Change& change, const RunOptions& options) {
  SceneFolder folder;
  for (const BodyPart& b : scene.bodies) {
    Mesh mesh = b.mesh;
    mesh.coordinates *= change.length;
    if (scene.in_place)
      mesh.coordinates = ((mesh.coordinates * (change.S * b.rotation).transpose()).rowwise() +
                          change.point(b.position).transpose())
                             .eval();
    folder.add(b.name + ".exo", mesh);
  }
  set_threads(scene.threads);
  return folder.run(yaml(scene, change), options);
}

Difference difference(const Ran& plain, const Ran& changed, const Change& change) {
  const RunResult &a = plain.result, &b = changed.result;
  Difference d;
  if (a.time.size() != b.time.size()) return {1, 1, 1, 1, 1, 1};
  double x = 0, p = 0, l = 0, f = 0, e = 0;       // largest differences
  double xs = 0, ps = 0, ls = 0, fs = 0, es = 0;  // scales
  const double det = change.S.determinant();
  for (std::size_t k = 0; k < a.time.size(); ++k) {
    const Vector3 drift = change.shift + b.time[k] * change.boost;
    const auto back = [&](const Vector3& y, double unit) {
      return Vector3(change.S.transpose() * y / unit);
    };
    for (std::size_t i = 0; i < a.bodies.size(); ++i) {
      const RunResult::OfBody& other = changed.body(plain.built.instances[i].name);
      const double m = plain.built.instances[i].mass,
                   mb = changed.mass(plain.built.instances[i].name);
      const Vector3 P = at(a.bodies[i].momentum, k), C = at(a.bodies[i].center_of_mass, k);
      p = std::max(
          p, (back(at(other.momentum, k) - mb * change.boost, change.mass * change.speed()) - P)
                 .norm());
      x = std::max(x, (back(at(other.center_of_mass, k) - drift, change.length) - C).norm());
      // About the body's own centre of mass, so that neither shift nor boost is in it
      const Vector3 La = at(a.bodies[i].angular_momentum, k) - C.cross(P);
      const Vector3 Lb = at(other.angular_momentum, k) -
                         at(other.center_of_mass, k).cross(Vector3(at(other.momentum, k)));
      l = std::max(l, (det * back(Lb, change.mass * change.speed() * change.length) - La).norm());
      ls = std::max(ls, La.norm());
      ps = std::max(ps, P.norm());
      xs = std::max(xs, (C - at(a.bodies[i].center_of_mass, 0)).norm());
      ps = std::max(ps, m * 1e-12);
      if (change.boost.isZero())
        e = std::max(
            e, std::abs(other.kinetic_energy[k] / change.energy() - a.bodies[i].kinetic_energy[k]));
      e = std::max(
          e, std::abs(other.strain_energy[k] / change.energy() - a.bodies[i].strain_energy[k]));
      es = std::max(es, a.bodies[i].kinetic_energy[k]);
    }
    for (std::size_t i = 0; i < a.monitors.size(); ++i) {
      const RunResult::OfMonitor& other = changed.monitor(plain.built.simulation.monitors[i].name);
      x = std::max(x, (back(at(other.mean_position, k) - drift, change.length) -
                       at(a.monitors[i].mean_position, k))
                          .norm());
      f = std::max(f,
                   (back(at(other.force, k), change.force()) - at(a.monitors[i].force, k)).norm());
      fs = std::max(fs, at(a.monitors[i].force, k).norm());
    }
    for (std::size_t i = 0; i < a.pairs.size(); ++i) {
      // one of all that never met
      if (a.pairs[i].empty() && b.pairs[i].empty()) continue;
      if (a.pairs[i].empty() != b.pairs[i].empty()) return {1, 1, 1, 1, 1, 1};
      d.pairs = std::max(d.pairs,
                         std::abs(a.pairs[i]["active"].values[k] - b.pairs[i]["active"].values[k]));
      d.pairs = std::max(d.pairs, std::abs(a.pairs[i]["penetration"].values[k] -
                                           b.pairs[i]["penetration"].values[k] / change.length));
      d.pairs =
          std::max(d.pairs, std::abs(a.pairs[i]["area"].values[k] -
                                     b.pairs[i]["area"].values[k] / std::pow(change.length, 2)));
      // The force is that on the surface named first
      const double sign =
          plain.built.simulation.pairs[i].name == changed.built.simulation.pairs[i].name ? 1 : -1;
      f = std::max(
          f, (sign * back(at(b.pairs[i]["force"], k), change.force()) - at(a.pairs[i]["force"], k))
                 .norm());
    }
  }
  // Bodies are about a unit long: what turns little is measured by what it could
  d.positions = x / xs;
  d.momenta = p / ps;
  d.angular = l / std::max(ls, 0.1 * ps);
  d.forces = fs > 0 ? f / fs : f;
  d.energies = e / es;
  return d;
}

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
