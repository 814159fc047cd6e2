// SPDX-License-Identifier: GPL-3.0-or-later
// What a run says of contact: resultant, area, centre and nodal pressure against each other and
// against the bodies' motion.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/support/scene_run.hpp"

namespace cbr::contact_results_test {
namespace {

using test::at;

constexpr double area = 0.5 * 0.75;

class ContactResults : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_.add("bar.msh", test::block_mesh({.n = {6, 2, 3}, .size = Vector3(1, 0.5, 0.75)}));
    folder_.add("finer.msh", test::block_mesh({.n = {4, 5, 4}, .size = Vector3(1, 0.5, 0.75)}));
  }

  static std::string scene(const std::string& kind, const std::string& instances,
                           const std::string& contact, double nu = 0, double end = 0.5) {
    return "materials: {m: {youngs_modulus: 100, poissons_ratio: " + test::text(nu) +
           ", density: 1}}\n"
           "components:\n  bar: {mesh: bar.msh, material: m" +
           (kind == "superelement" ? ", reduction: {interface: [x_min, x_max], modes: 20}"
                                   : std::string()) +
           "}\n"
           "  finer: {mesh: finer.msh, material: m}\n"
           "instances: {" +
           instances +
           "}\nwalls: {end: {plane: {point: [2.001, 0, 0], normal: [-1, 0, 0]}}}\ncontact: " +
           contact + "\ntime: {end: " + test::text(end) +
           "}\noutput: {every: 0.02, history: [a.x_max], fields: "
           "[contact_pressure]}\n";
  }

  test::SceneFolder folder_;
};

const std::string head_on =
    "a: {component: bar, velocity: [0.01, 0, 0]}, b: {component: bar, position: [1.001, 0, 0]}";

// nu = 0: the bars' faces stay plane, and their pressure is the same all over, on edges and corners
// too. Not with penalty, whose springs are alike on edges and within: there, pressure times area
// adds up to the force.
TEST_F(ContactResults, PressureIsForceOverAreaWhereBarsMeet) {
  struct Case {
    const char *kind, *contact;
  };
  for (const Case& its :
       {Case{"mesh", "[{between: [a.x_max, b.x_min]}]"}, Case{"mesh", "all"},
        Case{"superelement", "[{between: [b.x_min, a.x_max]}]"}, Case{"superelement", "all"},
        Case{"mesh", "[{between: [a.x_max, b.x_min], enforcement: penalty}]"},
        Case{"mesh", "[{between: [end, b.x_max], adjust: 0.01}, {between: [a.x_max, b.x_min]}]"}}) {
    SCOPED_TRACE(std::string(its.kind) + " " + its.contact);
    const bool is_penalty = std::string(its.contact).find("penalty") != std::string::npos;
    test::Ran ran = folder_.prepare(scene(its.kind, head_on, its.contact));
    Simulation& sim = ran.built.simulation;
    std::vector<std::vector<Vector>> pressures(2);  // by contact body, output
    RunOptions options;
    options.on_output = [&](Index, double) {
      for (std::size_t c = 0; c < 2; ++c) pressures[c].push_back(sim.contact_nodes[c].pressure);
    };
    const RunResult result = run(sim, options);
    double largest = 0;
    for (std::size_t c = 0; c < 2; ++c) {
      const ContactNodes& contact = sim.contact_nodes[c];
      const Points X = sim.bodies[contact.body]->reference_positions();
      for (std::size_t i = 0; i < result.time.size(); ++i) {
        double sum = 0, force = 0;
        for (Index slot = 0; slot < pressures[c][i].size(); ++slot) {
          const double x = X(contact.nodes[slot], 0);
          double expected = 0;
          for (std::size_t p = 0; p < result.pairs.size(); ++p) {
            const double met = sim.pairs[p].wall ? 2.001 : c == 0 ? 1 : 1.001;
            const bool takes_part =
                !sim.pairs[p].wall || sim.pairs[p].slave->body == static_cast<Index>(c);
            if (takes_part && std::abs(x - met) < 1e-9)
              expected += std::abs(at(result.pairs[p]["force"], i)[0]) / area;
          }
          largest = std::max(largest, expected);
          if (!is_penalty) {
            EXPECT_NEAR(pressures[c][i][slot], expected, 1e-9) << "output " << i << " x " << x;
          }
          const double share = std::abs(contact.area_vectors(slot, 0));
          sum += pressures[c][i][slot] * share;
          force += expected * share;
        }
        EXPECT_NEAR(sum, force, 1e-9);  // faces tilt a little on uneven springs
      }
    }
    // rho c v / 2 when a bar hits a bar, rho c v when the second hits the wall
    for (const ContactPair& pair : sim.pairs)
      EXPECT_NEAR(pair.seen().largest_area, pair.name == "a.all - end" ? 0 : area, 1e-6)
          << pair.name;  // of joined surfaces too
    EXPECT_NEAR(largest, (sim.pairs.size() > 1 ? 1 : 0.5) * 10 * 0.01, 0.02);
  }
}

// A block on a plane with friction 0.1 starts at 0.2 under a gravity of 1, stops at 2 and stays. Of
// elastic blocks single nodes leave the plane for some steps. A step loses half of its change of
// speed: h v / 2 in all.
TEST_F(ContactResults, SlipIsTheWayOverTheOtherSurface) {
  for (const std::string kind : {"rigid", "superelement", "mesh"}) {
    SCOPED_TRACE(kind);
    test::Ran ran = folder_.prepare(
        "materials: {m: {youngs_modulus: 1000, poissons_ratio: 0, density: 1}}\n"
        "components: {bar: {mesh: bar.msh, material: m, reduction: {interface: [z_min], modes: "
        "20}}}\ninstances: {a: {component: bar, as: " +
        kind +
        ", velocity: [0.2, 0, 0]}}\n"
        "walls: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\n"
        "contact: [{between: [a.z_min, floor], friction: 0.1}]\n"
        "loads: [{gravity: [0, 0, -1]}]\n"
        "time: {end: 3, preload: 1" +
        (kind == "rigid" ? ", step: 0.01" : "") +
        "}\n"
        "output: {every: 0.1, history: [a.z_min], fields: [contact_slip]}\n");
    Simulation& sim = ran.built.simulation;
    std::vector<Vector> slips;
    RunOptions options;
    options.on_output = [&](Index, double) { slips.push_back(sim.contact_nodes[0].slip); };
    const RunResult result = run(sim, options);
    for (std::size_t i = 0; i < result.time.size(); ++i) {
      const double t = std::min(2.0, result.time[i]), way = 0.2 * t - 0.05 * t * t;
      EXPECT_NEAR(slips[i].mean(), way, kind == "rigid" ? 1.01e-3 : 2e-3) << result.time[i];
      EXPECT_GE(slips[i].minCoeff(), i > 0 ? slips[i - 1].minCoeff() : 0);
    }
    EXPECT_LT((slips.back() - slips[slips.size() - 2]).norm(), kind == "rigid" ? 1e-12 : 5e-6);
  }
}

TEST_F(ContactResults, ResultantsChangeTheMotion) {
  const std::string apart =
      "a: {component: bar, velocity: [0.01, 0, 0]}, "
      "b: {component: finer, as: mesh, position: [1.0002, 0.2, 0.3]}";
  for (const std::string kind : {"mesh", "superelement"}) {
    for (const char* contact :
         {"[{between: [a.x_max, b.x_min]}]", "[{between: [b.x_min, a.x_max]}]", "all"}) {
      SCOPED_TRACE(kind + " " + contact);
      // At the end the bodies are apart: in contact, momenta are ahead by the force that lasts
      const test::Ran ran = folder_.run(scene(kind, apart, contact, 0.3, 0.8));
      const RunResult::OfPair& pair = ran.result.pairs.at(0);
      // force is that on the first named
      const double side = ran.built.simulation.pairs[0].name.front() == 'a' ? 1 : -1;
      const Vector3 change =
          at(ran.body("a").momentum, ran.result.time.size() - 1) - at(ran.body("a").momentum, 0);
      EXPECT_LT(change[0], -1e-4);
      EXPECT_LT((side * test::integral(ran.result, pair["force"]) - change).norm(),
                1e-12 * change.norm());
      Vector3 twist = Vector3::Zero();
      for (std::size_t i = 1; i < ran.result.time.size(); ++i) {
        const double dt = ran.result.time[i] - ran.result.time[i - 1];
        const Vector3 x = at(pair["center_of_pressure"], i), f = at(pair["force"], i);
        twist += side * dt * x.cross(f);
        if (f.norm() == 0) {
          EXPECT_EQ(x.norm(), 0);
          continue;
        }
        // where the faces overlap
        EXPECT_TRUE(x[1] > 0.19 && x[1] < 0.51 && x[2] > 0.29 && x[2] < 0.76) << x.transpose();
      }
      // Equal but for the tilt of the faces' normals
      const Vector3 turned = at(ran.body("a").angular_momentum, ran.result.time.size() - 1) -
                             at(ran.body("a").angular_momentum, 0);
      EXPECT_LT((twist - turned).norm(), 0.01 * turned.norm());
      EXPECT_GT(*std::max_element(pair["area"].values.begin(), pair["area"].values.end()),
                0.5 * 0.3 * 0.45);
      EXPECT_LE(ran.built.simulation.pairs[0].seen().largest_area, area);
    }
  }
}

TEST_F(ContactResults, AWallTakesWhatTheBodyLoses) {
  const test::Ran ran = folder_.run(
      scene("superelement", "a: {component: bar, position: [1, 0, 0], velocity: [0.01, 0, 0]}",
            "[{between: [end, a.x_max]}]"));
  const Vector3 change =
      at(ran.body("a").momentum, ran.result.time.size() - 1) - at(ran.body("a").momentum, 0);
  EXPECT_LT(change[0], -1.8 * area * 0.01);  // it comes back
  EXPECT_LT((test::integral(ran.result, ran.result.pairs[0]["force"]) - change).norm(),
            1e-12 * change.norm());
  EXPECT_EQ(ran.built.simulation.pairs[0].name, "a.x_max - end");
  const auto last = [&](const char* name) { return ran.result.pairs[0][name].values.back(); };
  EXPECT_EQ(last("impacts"), 1);
  EXPECT_NEAR(last("impulse"), change.norm(), 1e-12 * change.norm());
  double largest = 0;  // of the means between outputs
  for (std::size_t i = 0; i < ran.result.time.size(); ++i)
    largest = std::max(largest, at(ran.result.pairs[0]["force"], i).norm());
  EXPECT_GE(last("peak_force"), largest * (1 - 1e-12));
  EXPECT_LT(last("peak_force"), 4 * largest);
}

}  // namespace
}  // namespace cbr::contact_results_test
