// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/contact/contact_setup.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "common/linalg/dense.hpp"
#include "dynamics/motion/joint_body.hpp"

namespace cbr {
namespace {

// Largest number of steps between outputs, and in the run if every step is an output.
constexpr double most_per_output = 1000, most_without_outputs = 1e5;

Matrix6 transport(const Vector3& arm) {
  Matrix6 A = Matrix6::Identity();
  // Displacement of a point at `arm`: d + theta x arm
  A.block<3, 3>(0, 3) << 0, arm[2], -arm[1], -arm[2], 0, arm[0], arm[1], -arm[0], 0;
  return A;
}

// Largest eigenvalue of W K, both symmetric positive semi-definite.
double largest_product(const Matrix6& W, const Matrix6& K) {
  const SymmetricEigen of = symmetric_eigen(W);
  const Matrix6 root = of.vectors * of.values.cwiseMax(0).cwiseSqrt().asDiagonal();
  return std::max(0.0, symmetric_eigenvalues(root.transpose() * K * root)[5]);
}

// A link's end on a rigid body: its translation node among those of contact; the rotation node
// follows.
struct RigidEnd {
  Index body = 0, contact = 0, slot = 0;
};

struct SprungLink {
  const JointBody* joint = nullptr;
  std::vector<RigidEnd> ends;
};

// Mobility of a rigid body with its springs and dashpots, at the first of them.
struct Hung {
  Vector3 at = Vector3::Zero();
  Matrix6 mobility = Matrix6::Zero(), stiffness = Matrix6::Zero(), damping = Matrix6::Zero();

  double square_of_omega() const { return largest_product(mobility, stiffness); }
  double decay() const { return largest_product(mobility, damping); }
};

std::map<Index, SprungLink> sprung_links(const BuiltScene& built) {
  const Simulation& sim = built.simulation;
  std::map<Index, SprungLink> links;
  for (const ContactPair& pair : sim.pairs) {
    if (pair.joint < 0) continue;
    SprungLink& link = links[pair.joint];
    link.joint =
        static_cast<const JointBody*>(sim.bodies[sim.contact_nodes[pair.joint].body].get());
    const std::vector<ContactTerm>& terms = pair.seen().ties.terms;
    const Index of_rotation = terms.back().node;  // the joint's own: 0 or 1
    for (const ContactTerm& term : terms) {
      const Index body = sim.contact_nodes[term.body].body;
      if (body >= static_cast<Index>(built.instances.size()) || !built.instances[body].is_rigid)
        continue;
      const bool is_new = std::none_of(link.ends.begin(), link.ends.end(),
                                       [&](const RigidEnd& end) { return end.body == body; });
      if (is_new) link.ends.push_back({body, term.body, term.node - of_rotation});
    }
  }
  return links;
}

// Velocities of both nodes of the end per unit impulse on them.
Matrix6 mobility_at(const Simulation& sim, const RigidEnd& end) {
  const ContactNodes& nodes = sim.contact_nodes[end.contact];
  const NodeResponse response = sim.bodies[end.body]->response(nodes.set, 1);
  const auto n = static_cast<Index>(nodes.nodes.size());
  Matrix6 W;
  for (Index i = 0; i < 6; ++i) {
    Points p = Points::Zero(n, 3), v = Points::Zero(n, 3);
    p(end.slot + i / 3, i % 3) = 1;
    response.add_product(p, v);
    W.col(i) << v.row(end.slot).transpose(), v.row(end.slot + 1).transpose();
  }
  return 0.5 * (W + W.transpose());
}

}  // namespace

LinkRate fastest_link(const BuiltScene& built) {
  const std::map<Index, SprungLink> links = sprung_links(built);
  std::map<Index, Hung> bodies;
  for (const auto& [contact, link] : links)
    for (const RigidEnd& end : link.ends) {
      const Joint& joint = link.joint->joint();
      const auto [found, is_new] = bodies.try_emplace(end.body);
      Hung& hung = found->second;
      if (is_new) {
        hung.at = joint.at;
        hung.mobility = mobility_at(built.simulation, end);
      }
      const Matrix6 A = transport(joint.at - hung.at);
      hung.stiffness +=
          A.transpose() * link.joint->in_scene_axes(link.joint->largest_stiffness()) * A;
      hung.damping += A.transpose() * link.joint->in_scene_axes(joint.damping) * A;
    }
  LinkRate fastest;
  for (const auto& [contact, link] : links) {
    double square = 0, decay = 0;
    for (const RigidEnd& end : link.ends) {
      square += bodies.at(end.body).square_of_omega();
      decay += bodies.at(end.body).decay();
    }
    const double rate = std::max(std::sqrt(square), decay);
    if (rate > fastest.rate) fastest = {rate, link.joint->name()};
  }
  for (const ContactPair& pair : built.simulation.pairs) {
    if (!pair.driven || !pair.turning || !pair.turning->of_rotations) continue;
    const double rate = pair.driven->motion.largest_speed().norm();
    if (rate > fastest.rate) fastest = {rate, pair.name};
  }
  return fastest;
}

double link_step(const LinkRate& fastest, double every, double end) {
  if (!(fastest.rate > 0)) return 0;
  const double shortest =
      every > 0 ? std::min(every, end) / most_per_output : end / most_without_outputs;
  return std::max(link_step_share / fastest.rate, shortest);
}

}  // namespace cbr
