// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/built/watches.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "dynamics/setup/built/surface_distance.hpp"

namespace cbr {
namespace {

constexpr std::size_t most_pairs = 20, most_samples = 40;

Points contact_points(const Simulation& simulation, const ContactSurface& surface) {
  const ContactNodes& contact = simulation.contact_nodes[surface.body];
  return simulation.bodies[contact.body]->reference_positions()(contact.nodes, Eigen::all);
}

constexpr double much_strain = 0.1, much_displacement = 1;

std::vector<std::array<Index, 2>> edges_of(const Geometry& geometry,
                                           const std::vector<Index>& place) {
  std::set<std::array<Index, 2>> edges;
  for (const auto& [name, surface] : geometry.surfaces) {
    const IndexTable faces = linear_faces(surface).faces;
    for (Index f = 0; f < faces.rows(); ++f)
      for (Index k = 0; k < 4; ++k) {
        const auto [a, b] = std::minmax(place[faces(f, k)], place[faces(f, (k + 1) % 4)]);
        if (a != b) edges.insert({a, b});
      }
  }
  return {edges.begin(), edges.end()};
}

// Without rotation nodes of points and shells.
std::vector<Index> nodes_with_displacements(const Geometry& geometry, Index n) {
  std::set<Index> rotations;
  for (const auto& [node, rotation] : geometry.rotations) rotations.insert(rotation);
  std::vector<Index> nodes;
  for (Index i = 0; i < n; ++i)
    if (rotations.count(i) == 0) nodes.push_back(i);
  return nodes;
}

std::optional<StrainWatch::Worst> above(double limit, const StrainWatch::Worst& worst) {
  return worst.value > limit ? std::optional(worst) : std::nullopt;
}

}  // namespace

GapWatch::Side GapWatch::side_of(Simulation& simulation, const ContactSurface& surface) const {
  Side side;
  const ContactNodes& contact = simulation.contact_nodes[surface.body];
  side.body = contact.body;
  std::vector<Index> nodes, sample;
  for (const Index slot : surface.nodes) nodes.push_back(contact.nodes[slot]);
  const std::size_t stride = (nodes.size() + most_samples - 1) / most_samples;
  for (std::size_t i = 0; i < nodes.size(); i += stride) sample.push_back(nodes[i]);
  Body& body = *simulation.bodies[side.body];
  side.sample = body.reference_positions()(sample, Eigen::all);
  side.start = body.reference_positions()(nodes, Eigen::all).colwise().mean().transpose();
  side.mean_set = body.track_mean(nodes);
  return side;
}

void GapWatch::start(Simulation& simulation) {
  const bool few = simulation.pairs.size() <= most_pairs;
  for (std::size_t p = 0; p < simulation.pairs.size() && watched_.size() < most_pairs; ++p) {
    const ContactPair& pair = simulation.pairs[p];
    if (pair.law.law == ContactLaw::tied || (pair.of_all && !few)) continue;
    Watched watched;
    watched.pair = static_cast<Index>(p);
    watched.slave = side_of(simulation, *pair.slave);
    if (!pair.wall) watched.master = side_of(simulation, *pair.master);
    watched.least = HUGE_VAL;
    watched_.push_back(std::move(watched));
  }
}

void GapWatch::look(const Simulation& simulation) {
  for (Watched& watched : watched_) {
    if (simulation.pairs[watched.pair].seen().has_touched) continue;
    if (const auto& wall = simulation.pairs[watched.pair].wall)
      watched.master.shift = wall->shift().end;
    for (Side* side : {&watched.slave, &watched.master}) {
      if (side->body < 0) continue;
      Vector3 position, velocity;
      simulation.bodies[side->body]->mean_motion(side->mean_set, position, velocity);
      side->shift = position - side->start;
    }
    const double least = sampled(simulation, watched);
    if (!(least < watched.least)) continue;
    watched.least = least;
    watched.slave_shift = watched.slave.shift;
    watched.master_shift = watched.master.shift;
  }
}

double GapWatch::sampled(const Simulation& simulation, const Watched& watched) {
  const ContactPair& pair = simulation.pairs[watched.pair];
  const Points x = watched.slave.sample.rowwise() + watched.slave.shift.transpose();
  double least = HUGE_VAL;
  for (Index i = 0; i < x.rows(); ++i) {
    if (pair.wall) {
      least = std::min(least, pair.wall->distance(x.row(i).transpose() - watched.master.shift));
      continue;
    }
    const Eigen::RowVector3d at = x.row(i) - watched.master.shift.transpose();
    least =
        std::min(least, (watched.master.sample.rowwise() - at).rowwise().squaredNorm().minCoeff());
  }
  return least;
}

double GapWatch::distance(const Simulation& simulation, const Watched& watched,
                          const Vector3& slave_shift, const Vector3& master_shift) {
  const ContactPair& pair = simulation.pairs[watched.pair];
  const Points slave = contact_points(simulation, *pair.slave);
  if (!pair.wall) {
    const Points master = contact_points(simulation, *pair.master);
    return distance_between({*pair.slave, slave, slave_shift},
                            {*pair.master, master, master_shift});
  }
  double least = HUGE_VAL;
  for (const Index node : pair.slave->nodes)
    least = std::min(least,
                     pair.wall->distance(slave.row(node).transpose() + slave_shift - master_shift));
  return std::max(least, 0.0);
}

const GapWatch::Watched* GapWatch::find(Index pair) const {
  const auto found = std::find_if(watched_.begin(), watched_.end(),
                                  [&](const Watched& watched) { return watched.pair == pair; });
  return found != watched_.end() ? &*found : nullptr;
}

std::optional<double> GapWatch::initial(const Simulation& simulation, Index pair) const {
  const Watched* watched = find(pair);
  if (watched == nullptr) return std::nullopt;
  return distance(simulation, *watched, Vector3::Zero(), Vector3::Zero());
}

std::optional<double> GapWatch::nearest(const Simulation& simulation, Index pair) const {
  const Watched* watched = find(pair);
  if (watched == nullptr) return std::nullopt;
  return distance(simulation, *watched, watched->slave_shift, watched->master_shift);
}

void StrainWatch::add(Simulation& simulation, Index body, double size, const Geometry& geometry) {
  Body& of = *simulation.bodies[body];
  std::vector<Index> nodes = nodes_with_displacements(geometry, of.n_nodes());
  if (nodes.empty()) return;
  std::vector<Index> place(static_cast<std::size_t>(of.n_nodes()), 0);
  for (std::size_t i = 0; i < nodes.size(); ++i) place[nodes[i]] = static_cast<Index>(i);
  const Index set = of.track(nodes);
  watched_.push_back({body, set, size, std::move(nodes), edges_of(geometry, place)});
}

void StrainWatch::look(const Simulation& simulation, double t) {
  if (!simulation.is_static && t > 0) return;
  const auto note = [&](Index body, double value, Worst& worst) {
    if (value > worst.value) worst = {body, value, t};
  };
  for (const Watched& watched : watched_) {
    const Body& body = *simulation.bodies[watched.body];
    const Points X = body.reference_positions()(watched.nodes, Eigen::all);
    Points u(X.rows(), 3);
    body.positions(watched.set, u);
    u -= X;
    const double apart = (u.colwise().maxCoeff() - u.colwise().minCoeff()).norm();
    if (watched.size > 0) note(watched.body, apart / watched.size, displacement_);
    double strain = 0;
    for (const auto& [a, b] : watched.edges) {
      const Eigen::RowVector3d edge = X.row(b) - X.row(a);
      strain = std::max(strain, std::abs((u.row(b) - u.row(a)).dot(edge)) / edge.squaredNorm());
    }
    note(watched.body, strain, strain_);
  }
}

std::optional<StrainWatch::Worst> StrainWatch::strain() const {
  return above(much_strain, strain_);
}

std::optional<StrainWatch::Worst> StrainWatch::displacement() const {
  return above(much_displacement, displacement_);
}

}  // namespace cbr
