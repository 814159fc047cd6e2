// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/modal/scene_modes.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

#include "dynamics/setup/components/superelement_alone.hpp"

namespace cbr {
namespace {

// Least number of modes of joined meshes, so that one is elastic: it determines the shift.
constexpr Index fewest_modes = 7;

// Groups of bodies joined by ties, ordered by their first.
std::vector<std::vector<Index>> groups_of(const ModalScene& scene) {
  std::vector<Index> first = first_numbers(scene.bodies.size());
  const auto root = [&](Index b) {
    while (first[b] != b) b = first[b];
    return b;
  };
  for (const TieRow& tie : scene.ties)
    for (const auto& [body, sum] : tie.of_bodies) {
      const Index a = root(body), b = root(tie.of_bodies.front().first);
      first[std::max(a, b)] = std::min(a, b);
    }
  std::vector<std::vector<Index>> groups;
  std::vector<Index> place(scene.bodies.size(), -1);
  for (Index b = 0; b < static_cast<Index>(scene.bodies.size()); ++b) {
    Index& of = place[root(b)];
    if (of < 0) {
      of = static_cast<Index>(groups.size());
      groups.emplace_back();
    }
    groups[of].push_back(b);
  }
  return groups;
}

// Of a body that nothing joins: its own.
AssembledModes modes_of_one(const BodyModes& body, Index count) {
  const Vector lambda = body.omega().cwiseAbs2();
  std::vector<Index> order =
      order_by(lambda.size(), [&](Index a, Index b) { return lambda[a] < lambda[b]; });
  order.resize(static_cast<std::size_t>(std::min(count, static_cast<Index>(lambda.size()))));
  Matrix shapes = Matrix::Zero(lambda.size(), static_cast<Index>(order.size()));
  for (std::size_t j = 0; j < order.size(); ++j) shapes(order[j], static_cast<Index>(j)) = 1;
  return {lambda(order), body.damping_rates()(order), {std::move(shapes)}};
}

// Meshes use their mode shapes as coordinates.
AssembledModes modes_of_joined(ModalScene& scene, const std::vector<Index>& bodies, Index count,
                               Report& report) {
  AssembledModes of = assembled_modes(scene, bodies, count,
                                      [&](double share) { report.progress("frequencies", share); });
  report.end_progress();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    BodyModes& body = scene.bodies[bodies[i]];
    if (body.mesh() == nullptr || body.mesh()->is_complete()) continue;
    body.take_shapes(of.shapes[i]);
    of.shapes[i] = Matrix::Identity(of.lambda.size(), of.lambda.size());
  }
  return of;
}

InstanceModes of_group(ModalScene& scene, const std::vector<Index>& bodies, Index count,
                       Report& report) {
  InstanceModes of;
  std::vector<std::string> names;
  for (const Index b : bodies) {
    if (scene.bodies[b].is_joint()) continue;
    of.bodies.push_back(b);
    names.push_back(scene.built.instances[b].name);
  }
  of.instance = names.front();
  for (std::size_t i = 1; i < names.size(); ++i) of.instance += "+" + names[i];
  const bool is_joined = std::any_of(scene.ties.begin(), scene.ties.end(), [&](const TieRow& tie) {
    return std::find(bodies.begin(), bodies.end(), tie.of_bodies.front().first) != bodies.end();
  });
  AssembledModes modes = is_joined ? modes_of_joined(scene, bodies, count, report)
                                   : modes_of_one(scene.bodies[bodies.front()], count);
  const Vector omega = modes.lambda.cwiseSqrt();
  of.frequency_hz = omega / (2 * std::numbers::pi);
  of.damping_ratio = Vector::Zero(omega.size());
  for (Index j = 0; j < omega.size(); ++j)
    if (omega[j] > 0) of.damping_ratio[j] = modes.c[j] / (2 * omega[j]);
  modes.shapes.resize(of.bodies.size());  // joints come last
  of.shapes = std::move(modes.shapes);
  return of;
}

}  // namespace

SceneModes scene_modes(const Scene& scene_of_run, Index n, Report& report) {
  const Scene scene = with_options_of_files(scene_of_run);
  const bool is_joined = has_ties(scene);
  const MeshModesWanted wanted{is_joined ? std::max(n, fewest_modes) : n, 0, is_joined};
  SceneModes modes;
  modes.scene = modal_scene(scene, wanted, false, report);
  const auto phase = report.phase("modes");
  for (const std::vector<Index>& bodies : groups_of(*modes.scene))
    modes.instances.push_back(of_group(*modes.scene, bodies, n, report));
  return modes;
}

}  // namespace cbr
