// SPDX-License-Identifier: GPL-3.0-or-later
// Random scenes against dense arithmetic: reduction matrices, frequencies, responses to impulses,
// motion under loads and supports, in contact with walls and with each other. Seeds as in
// invariance_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "dynamics/setup/components/geometry.hpp"
#include "tests/stability/dense_scene.hpp"
#include "tests/stability/seeds.hpp"

namespace cbr::dense_oracle_test {
namespace {

using test::DenseBody;
using test::DenseModel;
using test::DenseReduction;
using test::Ran;
using test::RandomBody;
using test::RandomPair;
using test::RandomScene;

// In corners: twice the worst of 1000 seeds, 1.5e-9, of springs in 200 steps
constexpr double allowed = 1e-9, allowed_in_corners = 3e-9;
// between the last mode that is kept and the next: below it either is right
constexpr double clear_gap = 1e-5;

// Bodies whose motion is compared, and those where more than one answer is right
constexpr const char *compared = "bodies: compared",
                     *left_out_modes = "bodies: left out, modes tie",
                     *left_out_friction = "bodies: left out, impulses not unique";
constexpr double most_left_out = 0.03, most_left_out_in_corners = 0.06;

double difference(const Matrix& A, const Matrix& B, double scale) {
  if (A.rows() != B.rows() || A.cols() != B.cols()) return HUGE_VAL;
  return A.size() == 0 ? 0 : (A - B).cwiseAbs().maxCoeff() / scale;
}
double difference(const Matrix& A, const Matrix& B) {
  return difference(A, B, B.size() > 0 ? std::max(1e-300, B.cwiseAbs().maxCoeff()) : 1);
}

void drop(std::string& text, const std::string& words) {
  if (const auto at = text.find(words); at != std::string::npos) text.erase(at, words.size());
}

class Oracle {
 public:
  Oracle(const RandomScene& scene, double motion_allowed, test::Worst& worst)
      : scene_(scene), motion_allowed_(motion_allowed), worst_(worst) {
    // What has no dense counterpart here are mortar and corners of faces of second order: nodes
    // meet faces in their place
    for (RandomPair& pair : scene_.pairs) {
      drop(pair.options, ", formulation: mortar");
      pair.options += ", pressures: nodes";
    }
  }

  void compare() {
    // Its search is that of the slave's nodes
    ran_ = run_in(folder_, scene_, {}, false);
    is_clear_.assign(scene_.bodies.size(), 1);
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const RandomBody& b = scene_.bodies[i];
      const DenseModel model = test::dense_model(b);
      if (!b.reduced) {
        bodies_.push_back(test::dense_body(scene_, ran_, i, model));
        continue;
      }
      const Superelement s = read_superelement(folder_.folder() / ("c_" + b.name + ".cbr.h5"));
      const DenseReduction reduced = test::dense_reduction(b, model, s);
      compare_reduction(s, reduced);
      is_clear_[i] = reduced.gap > clear_gap;
      bodies_.push_back(test::dense_body(scene_, ran_, i, s, reduced));
    }
    compare_motion();
  }

 private:
  void expect(const std::string& what, double found, double tolerance = allowed) {
    worst_.add(what, found / tolerance, found, scene_.seed);
    EXPECT_LT(found, tolerance) << what << "; " << scene_.text() << "\n  "
                                << test::command(scene_.seed);
  }

  void compare_reduction(const Superelement& s, const DenseReduction& reduced) {
    expect("reduction: K_cc", difference(s.K_cc, reduced.K_cc));
    expect("reduction: M_cc", difference(s.M_cc, reduced.M_cc));
    const Matrix K = reduced_stiffness(s), M = reduced_mass(s);
    if (reduced.gap > clear_gap) {
      // Modes have no sign, and equal ones no direction: sums over them do not know
      const Matrix& A = s.M_kc;
      const Matrix& B = reduced.M_kc;
      expect("reduction: eigenvalues",
             difference(sorted(s.eigenvalues), sorted(reduced.eigenvalues)));
      expect("reduction: M_ck M_kc", difference(A.transpose() * A, B.transpose() * B));
      expect("reduction: M_ck L M_kc",
             difference(A.transpose() * s.eigenvalues.asDiagonal() * A,
                        B.transpose() * reduced.eigenvalues.asDiagonal() * B));
      const Vector lambda = test::dense_modes(reduced.K(), reduced.M()).lambda;
      expect("frequencies", difference(test::dense_modes(K, M).lambda, lambda));
      if (s.has_diagonal_form()) {
        expect("diagonal form: frequencies", difference(s.omega.cwiseAbs2(), lambda));
      }
    }
    // A component whose instances are all held stores none: cbr-dyn moves it from its matrices
    if (!s.has_diagonal_form()) {
      return;
    }
    expect("diagonal form: V^T M V",
           difference(s.V.transpose() * M * s.V, Matrix::Identity(s.n(), s.n())));
    expect("diagonal form: V^T K V",
           difference(s.V.transpose() * K * s.V, s.omega.cwiseAbs2().asDiagonal().toDenseMatrix()));
  }

  static Vector sorted(Vector v) {
    std::sort(v.begin(), v.end());
    return v;
  }

  void compare_motion() {
    const std::vector<test::DensePair> pairs = test::dense_pairs(scene_, ran_);
    const TimePlan& plan = ran_.built.simulation.plan;
    // What one body may do otherwise, those that it meets may
    for (const RandomPair& pair : scene_.pairs)
      for (std::size_t i = 0; pair.second != "wall" && i < is_clear_.size(); ++i)
        is_clear_[i] = is_clear_.front() && is_clear_.back();
    const Index n_outputs = ran_.result.time.size();
    const test::DenseMotion motion =
        test::dense_motion(bodies_, pairs, plan.h, n_outputs, plan.steps_per_output);
    // What curved faces and turning normals leave: twice the worst of 300 seeds, 3.7e-3
    if (motion.depth > 0) expect("depth of nodes in faces", motion.depth, 7e-3);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      worst_.add(!is_clear_[i]       ? left_out_modes
                 : !motion.is_unique ? left_out_friction
                                     : compared,
                 0, 0, scene_.seed);
      if (!is_clear_[i]) continue;
      compare_response(i, plan.h);
      const double omega =
          std::sqrt(test::dense_modes(bodies_[i].K, bodies_[i].M).lambda.maxCoeff());
      expect("highest frequency",
             std::abs(ran_.built.simulation.bodies[i]->largest_frequency() / omega - 1));
      if (motion.is_unique) compare_motion_of(i, motion);
    }
  }

  // "sphere, penalty, friction": what the body meets, or nothing
  std::string meets(std::size_t i, const test::DenseMotion& motion) const {
    std::string what;
    for (std::size_t p = 0; p < scene_.pairs.size(); ++p) {
      const RandomPair& pair = scene_.pairs[p];
      if (!is_of(pair, scene_.bodies[i])) continue;
      if (!what.empty()) return "of two pairs";
      what = pair.second == "wall" ? scene_.walls.front().kind : "bodies";
      for (const char* word : {"newmark", "penalty", "two-way", "friction"})
        if ((pair.options + scene_.integrator).find(word) != std::string::npos)
          what += std::string(", ") + word;
      if (motion.n_pushes[p] == 0) what = "not touched";
    }
    return what;
  }

  void compare_motion_of(std::size_t i, const test::DenseMotion& motion) {
    const RandomBody& b = scene_.bodies[i];
    const auto& of = motion.bodies[i];
    double way = 0, worst = 0, force = 0, largest = 0;
    for (const char* surface : {"x_min", "x_max"}) {
      const auto nodes = surface_nodes(ran_.built.instances[i].geometry->surfaces.at(surface));
      const auto& monitor = ran_.monitor(b.name + "." + surface);
      for (std::size_t k = 0; k < of.x.size(); ++k) {
        const Vector3 mean = of.x[k](nodes, Eigen::all).colwise().mean().transpose();
        worst = std::max(worst, (mean - test::at(monitor.mean_position, k)).norm());
        way = std::max(way, (mean - test::at(monitor.mean_position, 0)).norm());
        if (k == 0) continue;
        const double time = ran_.result.time[k] - ran_.result.time[k - 1];
        const Vector3 mean_force =
            of.impulse[k](nodes, Eigen::all).colwise().sum().transpose() / time;
        force = std::max(force, (mean_force - test::at(monitor.force, k)).norm());
        largest = std::max(largest, mean_force.norm());
      }
    }
    const bool shells = scene_.skin && scene_.skin->rfind(b.name + ".", 0) == 0;
    const std::string met = meets(i, motion);
    if (shells)
      expect(met.empty() || met == "not touched" ? "motion with shells"
                                                 : "motion with shells, in contact",
             worst / std::max(way, 1e-3));
    const std::string what = met;
    expect(what.empty() ? "motion" : "motion: " + what, worst / std::max(way, 1e-3),
           motion_allowed_);
    if (largest > 0) expect("force: " + what, force / largest, motion_allowed_);
  }

  // W is made of these
  void compare_response(std::size_t i, double h) {
    Matrix S;
    const Simulation& sim = ran_.built.simulation;
    for (const ContactNodes& nodes : sim.contact_nodes) {
      if (nodes.body != static_cast<Index>(i)) continue;
      if (S.size() == 0) S = test::dense_response(bodies_[i], h);
      std::vector<Index> dofs;
      for (const Index node : nodes.nodes)
        for (Index c = 0; c < 3; ++c) dofs.push_back(3 * node + c);
      expect("response", difference(sim.bodies[i]->response(nodes.set, h).dense(), S(dofs, dofs)));
    }
  }

  RandomScene scene_;
  double motion_allowed_;
  test::Worst& worst_;
  test::SceneFolder folder_;
  Ran ran_;
  std::vector<DenseBody> bodies_;
  std::vector<char> is_clear_;  // of each body: which modes are its own does not hang on rounding
};

// `change`: what is done to a scene, false where it does not apply.
void compare_all(const test::Seeds& seeds, bool (*change)(RandomScene&),
                 double most = most_left_out, double motion_allowed = allowed) {
  test::Worst worst;
  std::vector<unsigned> numbers;
  for (unsigned seed = seeds.first; seed < seeds.first + seeds.count; ++seed)
    numbers.push_back(seed);
  // Once wrong: springs of a held mesh; a node in a valley between faces, come off for a step;
  // hollow edges that are bent flat
  if (!seeds.thorough) numbers.insert(numbers.end(), {1005, 1132, 3141547, 3141552});
  for (const unsigned seed : numbers) {
    RandomScene scene = test::random_scene(seed);
    if (!change(scene)) continue;
    try {
      Oracle(scene, motion_allowed, worst).compare();
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what() << "; " << scene.text() << "\n  " << test::command(seed);
    }
  }
  worst.print();
  const int left_out = worst.count(left_out_modes) + worst.count(left_out_friction);
  if (seeds.count >= 40) {
    EXPECT_LE(left_out, most * (left_out + worst.count(compared)));
  }
}

TEST(RandomScenes, AgreeWithDenseArithmetic) {
  compare_all(test::seeds(), [](RandomScene&) { return true; });
}

// What goes over from one face of a hollow corner to the other, and into corners of four
TEST(RandomScenes, OfGroovesAgreeWithDenseArithmetic) {
  compare_all(test::seeds(), test::make_groove, most_left_out_in_corners, allowed_in_corners);
}

}  // namespace
}  // namespace cbr::dense_oracle_test
