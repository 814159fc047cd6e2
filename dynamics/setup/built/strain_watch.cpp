// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/built/strain_watch.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace cbr {
namespace {

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
