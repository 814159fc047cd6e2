// SPDX-License-Identifier: GPL-3.0-or-later
// Pretensions: the length by which ties pull two surfaces together.
#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/run/equilibrium.hpp"

namespace cbr {

// The mean outward normal of the slave.
void Equilibrium::add_bolts() {
  for (const Index p : pairs_) {
    ContactPair& pair = sim_.pairs[p];
    if (!pair.pretension) continue;
    Bolt bolt;
    bolt.pair = p;
    bolt.body = static_cast<Index>(state_.bodies.size());
    bolt.normal = pair.slave->area_vectors.colwise().sum().transpose().normalized();
    ContactBody body;
    body.start = body.end = body.impulses = body.friction = Points::Zero(1, 3);
    state_.bodies.push_back(std::move(body));
    ContactList with;
    for (ContactPoint point : pair.state().ties.points) {
      const auto first = pair.state().ties.terms.begin() + point.first_term;
      point.first_term = static_cast<Index>(with.terms.size());
      with.terms.insert(with.terms.end(), first, first + point.n_terms);
      with.terms.push_back({bolt.body, 0, -1});
      ++point.n_terms;
      with.points.push_back(point);
    }
    pair.state().ties = std::move(with);
    bolts_.push_back(bolt);
  }
}

// Of both surfaces under a pull that is spread over their nodes, and a hundred times as much.
void Equilibrium::find_compliance(Bolt& bolt, double hold) {
  const ContactPair& pair = sim_.pairs[bolt.pair];
  for (const ContactSurface* side : {pair.slave.get(), pair.master.get()}) {
    const ContactNodes& nodes = sim_.contact_nodes[side->body];
    const NodeResponse S = statics_of(*sim_.bodies[nodes.body]).static_response(nodes.set, hold);
    Points pull = Points::Zero(static_cast<Index>(nodes.nodes.size()), 3), moved = pull;
    const auto n = static_cast<double>(side->nodes.size());
    for (const Index node : side->nodes) pull.row(node) = bolt.normal.transpose() / n;
    S.add_product(pull, moved);
    for (const Index node : side->nodes)
      bolt.compliance += 100 / n * moved.row(node).dot(bolt.normal);
  }
}

// A given length is where it is to be; a given force pulls as far as what is missing of it goes.
void Equilibrium::predict_bolts(double share) {
  for (Bolt& bolt : bolts_) {
    const Pretension& pretension = *sim_.pairs[bolt.pair].pretension;
    ContactBody& body = state_.bodies[bolt.body];
    bolt.length_before = bolt.length;
    if (pretension.force) {
      if (bolt.compliance == 0) find_compliance(bolt, 1);
      body.response.set_block(bolt.compliance * bolt.normal * bolt.normal.transpose());
      bolt.length += bolt.compliance * share * *pretension.force;
    } else {
      body.response.set_block(Matrix::Zero(3, 3));
      bolt.length = share * *pretension.shortening;
    }
    body.start = bolt.length_before * bolt.normal.transpose();
    body.end = bolt.length * bolt.normal.transpose();
  }
}

// With the solution's tension they are as long as they are now.
double Equilibrium::change_of_bolts() {
  double change = 0;
  missing_pull_ = 0;
  for (Bolt& bolt : bolts_) {
    if (bolt.compliance == 0) continue;
    bolt.length -= bolt.compliance * bolt.force;
    const double missing = std::abs(bolt.length - bolt.length_before) / bolt.compliance;
    if (missing > 0)
      missing_pull_ = std::max(missing_pull_, missing / std::max(std::abs(bolt.force), missing));
    change += std::pow(bolt.length - bolt.length_before, 2) / bolt.compliance;
  }
  return change;
}

// The ties keep the length.
void Equilibrium::lock_bolts() {
  for (const Bolt& bolt : bolts_) {
    ContactPair& pair = sim_.pairs[bolt.pair];
    pair.pretension->length = bolt.length;
    PairState& now = pair.state();
    now.tie_offset.rowwise() += bolt.length * bolt.normal.transpose();
    ContactList without;
    for (ContactPoint point : now.ties.points) {
      const auto first = now.ties.terms.begin() + point.first_term;
      point.first_term = static_cast<Index>(without.terms.size());
      --point.n_terms;
      without.terms.insert(without.terms.end(), first, first + point.n_terms);
      without.points.push_back(point);
    }
    now.ties = std::move(without);
  }
  if (!bolts_.empty()) state_.islands.clear();
  state_.bodies.resize(sim_.contact_nodes.size());
  bolts_.clear();
}

}  // namespace cbr
