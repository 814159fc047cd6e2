// SPDX-License-Identifier: GPL-3.0-or-later
// What contact must keep. Momentum: to rounding. Angular momentum: bodies are linear, so that an
// impulse turns them about the arms of the undeformed body while it acts where the surfaces are;
// what two bodies get then differs by the impulse times the difference of those arms, which grows
// with the strains and rotations: the drift, as a share of the angular momentum exchanged, is of
// first order in the speed of the impact. Work of contact: booked to rounding, never positive for
// hard contact.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cstdio>

#include "tests/support/contact_scene.hpp"

namespace cbr::contact_momentum_test {
namespace {

using test::at;
using test::BodyPart;
using test::ContactScene;
using test::Ran;

struct Way {
  const char* name;
  std::string options;
  bool full1, full2;
};

// Blocks with faces that do not match, which touch at rim and face; c is about 10.
ContactScene oblique(const Way& way, double speed) {
  ContactScene scene;
  for (int i = 0; i < 2; ++i) {
    BodyPart b;
    b.name = i == 0 ? "a" : "b";
    b.full = i == 0 ? way.full1 : way.full2;
    b.mesh = i == 0 ? test::block_mesh({{3, 3, 4}})
                    : test::block_mesh({{3, 2, 3}, Vector3(1, 0.8, 0.7)});
    b.position = i == 0 ? Vector3(0, 0, 0) : Vector3(1 + 0.02 * speed, 0.35, 0.25);
    scene.bodies.push_back(b);
  }
  scene.bodies[0].velocity = speed * Vector3(1, 0.3, -0.2);
  scene.pairs = {"{between: [a.x_max, b.x_min]" + way.options + "}"};
  scene.history = {"a.x_max", "b.x_min"};
  scene.step = 0.008;
  scene.every = 0.04;
  scene.end = 1;
  return scene;
}

struct Drift {
  double momentum = 0, angular = 0;  // as shares of what the bodies exchange
  // largest work of contact and friction so far, as a share of the energy
  double gained = 0;
};

Drift drift(const Ran& ran) {
  const RunResult& r = ran.result;
  Drift d;
  d.momentum = test::largest_change(r, &RunResult::OfBody::momentum);
  d.angular = test::largest_change(r, &RunResult::OfBody::angular_momentum);
  double exchanged = 0, turned = 0, highest = 0;
  for (std::size_t k = 0; k < r.time.size(); ++k) {
    exchanged =
        std::max(exchanged, (at(r.bodies[1].momentum, k) - at(r.bodies[1].momentum, 0)).norm());
    turned = std::max(
        turned, (at(r.bodies[1].angular_momentum, k) - at(r.bodies[1].angular_momentum, 0)).norm());
    const double work = r.work_contact[k] + r.work_friction[k];
    highest = std::max(highest, work);
  }
  EXPECT_GT(exchanged, 0);
  d.momentum /= exchanged;
  d.angular /= turned;
  d.gained = highest / r.total[0];
  return d;
}

TEST(ContactMomentum, AngularMomentumDriftsWithTheStrains) {
  for (const Way& way :
       {Way{"impulse, meshes", "", true, true}, Way{"impulse, superelements", "", false, false},
        Way{"impulse, friction", ", friction: 0.3", true, false},
        Way{"mortar", ", formulation: mortar", false, true},
        Way{"mortar, friction", ", formulation: mortar, friction: 0.3", true, true},
        Way{"penalty", ", enforcement: penalty", true, true},
        Way{"two-way, friction", ", enforcement: penalty, formulation: two-way, friction: 0.3",
            false, true}}) {
    std::vector<double> speeds, drifts;
    for (const double speed : {1e-2, 1e-4, 1e-6, 1e-9}) {
      const Ran ran = run(oblique(way, speed));
      const Drift d = drift(ran);
      std::printf(
          "%-24s speed %.0e: momentum %.1e, angular momentum %.1e, energy balance %.1e, gained "
          "%.1e\n",
          way.name, speed, d.momentum, d.angular, test::energy_residual(ran.result), d.gained);
      EXPECT_LT(d.momentum, 1e-10) << way.name;
      EXPECT_LT(test::energy_residual(ran.result), 1e-10) << way.name;
      EXPECT_LT(d.gained, 1e-12) << way.name;
      speeds.push_back(speed);
      drifts.push_back(d.angular);
    }
    // At 1e-2 every step of the superelements is searched, below their searches stand
    const std::vector<double> slow(speeds.begin() + 1, speeds.end()),
        of_slow(drifts.begin() + 1, drifts.end());
    EXPECT_NEAR(test::observed_order(slow, of_slow), 1, 0.05) << way.name;
    EXPECT_LT(drifts.back(), 1e-10) << way.name;
  }
}

// A body of few faces, which bends by 30 to 50 degrees from one to the next, falls on a plate:
// neither does contact add energy, as pushes along other directions than that in which gaps close
// do, and faces that join when they are deep; nor is it sent sideways.
TEST(ContactMomentum, CoarseRoundBodiesBounceAsFromAPlate) {
  const auto rounded = [](const Vector3& x) {
    const Vector3 y = 2 * x - Vector3::Ones();
    return Vector3(0.5 * y * (0.4 + 0.6 * y.lpNorm<Eigen::Infinity>() / std::max(1e-9, y.norm())));
  };
  for (const Index n : {2, 3, 4}) {
    for (const Index n_plate : {3, 9}) {
      for (const bool plate_first : {false, true}) {
        ContactScene scene;
        BodyPart ball, plate;
        ball.name = "ball";
        ball.mesh = test::block_mesh({{n, n, n}, Vector3::Ones(), rounded});
        Sideset all{"surface", 99, {}};
        for (const Sideset& face : ball.mesh.sidesets)
          all.sides.insert(all.sides.end(), face.sides.begin(), face.sides.end());
        ball.mesh.sidesets.push_back(all);
        plate.name = "plate";
        plate.mesh = test::block_mesh({{1, n_plate, n_plate}, Vector3(0.6, 1.6, 1.6)});
        ball.rotation =
            Eigen::AngleAxisd(0.4, Vector3(0.3, -0.8, 0.5).normalized()).toRotationMatrix();
        ball.position = Vector3(-0.56, 0.83, 0.77);
        ball.velocity = Vector3(0.5, 0, 0);
        scene.bodies = {ball, plate};
        const std::string faces = "ball.surface, plate.x_min";
        scene.pairs = {std::string("{between: [") +
                       (plate_first ? "plate.x_min, ball.surface" : faces) +
                       "], formulation: mortar}"};
        scene.step = 0.004;
        scene.every = 0.05;
        scene.end = 1.5;
        const RunResult result = run(scene).result;
        const Vector3 before = at(result.bodies[0].momentum, 0),
                      after = at(result.bodies[0].momentum, result.time.size() - 1);
        EXPECT_LT(after[0], 0.2 * before[0]) << n << " " << n_plate;  // it has hit
        const double most =
            *std::max_element(result.total.begin(), result.total.end()) / result.total[0] - 1;
        EXPECT_LT(most, 0.01) << n << " " << n_plate << " " << plate_first;
        EXPECT_LT(after.tail<2>().norm(), 0.05 * before.norm())
            << n << " " << n_plate << " " << plate_first;
        std::printf("%d %d: energy gained %.1e, sideways %.1e of the momentum\n",
                    static_cast<int>(n), static_cast<int>(n_plate), most,
                    after.tail<2>().norm() / before.norm());
      }
    }
  }
}

}  // namespace
}  // namespace cbr::contact_momentum_test
