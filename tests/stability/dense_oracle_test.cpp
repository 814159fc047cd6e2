// SPDX-License-Identifier: GPL-3.0-or-later
// Random scenes against dense arithmetic: reduction matrices, frequencies, responses to impulses, motion under loads, supports and
// against a plane. Seeds as in invariance_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "dynamics/setup/geometry.hpp"
#include "tests/stability/dense_oracle.hpp"
#include "tests/stability/random_scene.hpp"
#include "tests/stability/seeds.hpp"

namespace cbr {
namespace {

using test::DenseBody;
using test::DenseModel;
using test::DenseReduction;
using test::Ran;
using test::RandomBody;
using test::RandomScene;

constexpr double allowed = 1e-9;
constexpr double clear_gap = 1e-5;  // between the last mode that is kept and the next: below it either is right

double difference(const Matrix& A, const Matrix& B, double scale) {
  if (A.rows() != B.rows() || A.cols() != B.cols()) return HUGE_VAL;
  return A.size() == 0 ? 0 : (A - B).cwiseAbs().maxCoeff() / scale;
}
double difference(const Matrix& A, const Matrix& B) {
  return difference(A, B, B.size() > 0 ? std::max(1e-300, B.cwiseAbs().maxCoeff()) : 1);
}

std::vector<BlockProperties> properties(const RandomBody& b) {
  std::vector<BlockProperties> list;
  for (const Block& block : b.mesh.blocks)
    list.push_back({block.name.rfind("low", 0) == 0 ? b.low : b.high, parse_hex8_formulation(b.element)});
  return list;
}

DenseModel model_of(const RandomBody& b) {
  return test::dense_model(b.mesh, properties(b), b.mass == "lumped" ? MassKind::lumped : MassKind::consistent);
}

// Dofs of the model that are the superelement's interface, in its order.
std::vector<Index> interface_of(const Superelement& s, const RandomBody& b, const DenseModel& model) {
  std::vector<Index> dofs;
  for (std::size_t i = 0; i < s.dof_node.size(); ++i) {
    const Index id = s.node_ids[static_cast<std::size_t>(s.dof_node[i])];
    const auto node = std::find(b.mesh.node_ids.begin(), b.mesh.node_ids.end(), id) - b.mesh.node_ids.begin();
    const auto place = std::lower_bound(model.nodes.begin(), model.nodes.end(), node) - model.nodes.begin();
    dofs.push_back(3 * place + s.dof_component[i]);
  }
  return dofs;
}

class Oracle {
 public:
  Oracle(const RandomScene& scene, test::Worst& worst) : scene_(scene), worst_(worst) {
    // What has no dense counterpart here: contact of bodies, friction, springs, curved walls, shells
    scene_.skin.reset();
    const bool plane = !scene.walls.empty() && scene.walls[0].kind == "plane" && scene.integrator != "newmark";
    std::erase_if(scene_.pairs, [&](const auto& pair) { return pair.second != "wall" || !plane; });
    for (auto& pair : scene_.pairs) pair.options.clear();
    if (scene_.pairs.empty()) scene_.walls.clear();
  }

  void compare() {
    ran_ = run_in(folder_, scene_);
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const RandomBody& b = scene_.bodies[i];
      const DenseModel model = model_of(b);
      if (!b.reduced) {
        compare_motion(i, body_of(i, model));
        continue;
      }
      const Superelement s = read_superelement(folder_.folder() / ("c_" + b.name + ".cbr.h5"));
      const DenseReduction reduced = test::dense_reduction(model, interface_of(s, b, model), b.modes, b.pick);
      compare_reduction(s, reduced);
      if (reduced.gap > clear_gap) compare_motion(i, body_of(i, s, reduced));
    }
  }

 private:
  void expect(const std::string& what, double found, double tolerance = allowed) {
    worst_.add(what, found / tolerance, found, scene_.seed);
    EXPECT_LT(found, tolerance) << what << "; " << scene_.text() << "\n  " << test::command(scene_.seed);
  }

  void compare_reduction(const Superelement& s, const DenseReduction& reduced) {
    expect("reduction: K_cc", difference(s.K_cc, reduced.K_cc));
    expect("reduction: M_cc", difference(s.M_cc, reduced.M_cc));
    if (reduced.gap > clear_gap) {
      // Modes have no sign, and equal ones no direction: sums over them do not know
      const Matrix& A = s.M_kc;
      const Matrix& B = reduced.M_kc;
      expect("reduction: eigenvalues", difference(sorted(s.eigenvalues), sorted(reduced.eigenvalues)));
      expect("reduction: M_ck M_kc", difference(A.transpose() * A, B.transpose() * B));
      expect("reduction: M_ck L M_kc",
             difference(A.transpose() * s.eigenvalues.asDiagonal() * A, B.transpose() * reduced.eigenvalues.asDiagonal() * B));
      const auto modes = test::dense_modes(reduced.K(), reduced.M());
      expect("frequencies", difference(s.omega.cwiseAbs2(), modes.lambda));
    }
    const Matrix K = reduced_stiffness(s), M = reduced_mass(s);
    expect("diagonal form: V^T M V", difference(s.V.transpose() * M * s.V, Matrix::Identity(s.n(), s.n())));
    expect("diagonal form: V^T K V", difference(s.V.transpose() * K * s.V, s.omega.cwiseAbs2().asDiagonal().toDenseMatrix()));
  }

  static Vector sorted(Vector v) {
    std::sort(v.begin(), v.end());
    return v;
  }

  bool in_contact(std::size_t i) const { return !scene_.pairs.empty() && i == 0; }

  // B: all coordinates to displacements of the visible nodes, component axes; `rigid`: coordinates x 3, translations.
  DenseBody placed(std::size_t i, const Matrix& K, const Matrix& M, const Matrix& B, const Matrix& rigid) const {
    const RandomBody& b = scene_.bodies[i];
    const auto& of = ran_.built.instances[i];
    const Matrix3& T = b.rotation;
    DenseBody body;
    const Index n = of.geometry->coordinates.rows();
    body.X = (of.geometry->coordinates * T.transpose()).rowwise() + b.position.transpose();
    Matrix TB(B.rows(), B.cols());
    for (Index node = 0; node < n; ++node) TB.middleRows(3 * node, 3) = T * B.middleRows(3 * node, 3);
    const std::vector<Index> free = free_coordinates(i, B);
    const auto all = Eigen::all;
    body.K = K(free, free), body.M = M(free, free), body.B = TB(all, free);
    body.velocity = Vector(rigid * (T.transpose() * b.velocity))(free);
    for (const auto& load : scene_.loads) {
      Vector f;
      if (load.kind == "gravity") {
        f = Vector(M * (rigid * (T.transpose() * load.value)))(free);
      } else if (load.instance == b.name) {
        const Vector weights = face_weights(of.geometry->surfaces.at(load.surface), of.geometry->coordinates);
        const RowMatrix forces = weights * (load.kind == "force" ? Vector3(load.value / weights.sum()) : load.value).transpose();
        f = body.B.transpose() * forces.reshaped<Eigen::RowMajor>();
      } else {
        continue;
      }
      body.load.push_back(f);
      body.history.push_back({load.time, load.factor});
    }
    if (in_contact(i)) {
      body.slave = surface_nodes(of.geometry->surfaces.at("x_min"));
      body.normal = scene_.walls[0].direction;
      body.offset = body.normal.dot(scene_.walls[0].point);
    }
    return body;
  }

  std::vector<Index> free_coordinates(std::size_t i, const Matrix& B) const {
    std::vector<char> held(static_cast<std::size_t>(B.cols()), 0);
    for (const std::string& name : scene_.held) {
      if (name.substr(0, name.find('.')) != scene_.bodies[i].name) continue;
      for (const Index node : ran_.built.instances[i].geometry->nodesets.at(name.substr(name.find('.') + 1)))
        for (Index j = 0; j < B.cols(); ++j)
          if (!B.block(3 * node, j, 3, 1).isZero(0)) held[static_cast<std::size_t>(j)] = 1;
    }
    std::vector<Index> free;
    for (Index j = 0; j < B.cols(); ++j)
      if (!held[static_cast<std::size_t>(j)]) free.push_back(j);
    return free;
  }

  DenseBody body_of(std::size_t i, const DenseModel& model) const {
    const Index n = model.K.rows();
    DenseBody body = placed(i, model.K, model.M, Matrix::Identity(n, n), Matrix3::Identity().replicate(n / 3, 1));
    body.scheme = scene_.integrator == "newmark" ? DenseBody::Scheme::newmark : DenseBody::Scheme::central;
    return body;
  }

  DenseBody body_of(std::size_t i, const Superelement& s, const DenseReduction& reduced) const {
    const Index n_nodes = static_cast<Index>(s.node_ids.size());
    Matrix B = Matrix::Zero(3 * n_nodes, s.n()), rigid = Matrix::Zero(s.n(), 3);
    for (Index j = 0; j < s.c(); ++j) {
      B(3 * s.dof_node[static_cast<std::size_t>(j)] + s.dof_component[static_cast<std::size_t>(j)], s.k() + j) = 1;
      rigid(s.k() + j, s.dof_component[static_cast<std::size_t>(j)]) = 1;
    }
    DenseBody body = placed(i, reduced.K(), reduced.M(), B, rigid);
    body.scheme = scene_.integrator == "exact"     ? DenseBody::Scheme::exact
                  : scene_.integrator == "newmark" ? DenseBody::Scheme::newmark
                                                   : DenseBody::Scheme::central;
    body.lasting = in_contact(i) && body.scheme == DenseBody::Scheme::exact;
    return body;
  }

  void compare_motion(std::size_t i, const DenseBody& body) {
    const RandomBody& b = scene_.bodies[i];
    const TimePlan& plan = ran_.built.simulation.plan;
    if (in_contact(i)) compare_response(i, body, plan.h);
    const auto n_outputs = static_cast<Index>(ran_.result.time.size());
    const test::DenseMotion motion = test::dense_motion(body, plan.h, n_outputs, plan.steps_per_output);
    double way = 0, worst = 0, force = 0, largest = 0;
    for (const char* surface : {"x_min", "x_max"}) {
      const auto nodes = surface_nodes(ran_.built.instances[i].geometry->surfaces.at(surface));
      const auto& monitor = ran_.monitor(b.name + "." + surface);
      for (std::size_t k = 0; k < motion.x.size(); ++k) {
        const Vector3 mean = motion.x[k](nodes, Eigen::all).colwise().mean().transpose();
        worst = std::max(worst, (mean - test::at(monitor.mean_position, k)).norm());
        way = std::max(way, (mean - test::at(monitor.mean_position, 0)).norm());
        if (!in_contact(i) || surface[2] != 'm' || surface[3] != 'i' || k == 0) continue;
        const double time = ran_.result.time[k] - ran_.result.time[k - 1];
        force = std::max(force, (motion.impulse[k] / time - test::at(monitor.force, k)).norm());
        largest = std::max(largest, (motion.impulse[k] / time).norm());
      }
    }
    expect(in_contact(i) ? "motion with contact" : "motion", worst / std::max(way, 1e-3));
    if (largest > 0) expect("force of contact", force / largest);
  }

  // W is made of these
  void compare_response(std::size_t i, const DenseBody& body, double h) {
    const Matrix S = test::dense_response(body, h);
    const Simulation& sim = ran_.built.simulation;
    for (const ContactNodes& nodes : sim.contact_nodes) {
      if (nodes.body != static_cast<Index>(i)) continue;
      std::vector<Index> dofs;
      for (const Index node : nodes.nodes)
        for (Index c = 0; c < 3; ++c) dofs.push_back(3 * node + c);
      expect("response", difference(sim.bodies[i]->response(nodes.set, h).dense(), S(dofs, dofs)));
    }
  }

  RandomScene scene_;
  test::Worst& worst_;
  test::SceneFolder folder_;
  Ran ran_;
};

TEST(RandomScenes, AgreeWithDenseArithmetic) {
  const test::Seeds seeds = test::seeds();
  test::Worst worst;
  for (unsigned seed = seeds.first; seed < seeds.first + seeds.count; ++seed) {
    const RandomScene scene = test::random_scene(seed);
    try {
      Oracle(scene, worst).compare();
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what() << "; " << scene.text() << "\n  " << test::command(seed);
    }
  }
  worst.print();
}

}  // namespace
}  // namespace cbr
