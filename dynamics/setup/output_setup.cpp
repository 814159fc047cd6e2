// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <utility>

#include "common/base/error.hpp"
#include "common/fem/elements/nodal_stress.hpp"
#include "common/fem/stress_values.hpp"
#include "dynamics/motion/body_points.hpp"
#include "dynamics/setup/build_steps.hpp"
#include "dynamics/setup/built/instance_elements.hpp"
#include "dynamics/setup/contact/points.hpp"

namespace cbr {
namespace {

using Entries = std::vector<Eigen::Triplet<double, Index>>;

// Stresses as rows in terms of the displacements of the instance's nodes (3 N), component axes.
class StressRows {
 public:
  explicit StressRows(const InstanceElements& elements) : elements_(elements) {}

  // Adds six rows per node and material, by ids of nodes and blocks: the mean of the elements'
  // stresses.
  void add_nodes(const std::vector<Index>& nodes, StressWatch& watch) {
    std::vector<std::array<Index, 3>> found;  // node id, block id, place
    for (const Index node : nodes)
      for (Index m = 0; m < elements_.n_materials(); ++m)
        if (const Index place = elements_.place(node, m); place >= 0)
          found.push_back(
              {elements_.node_id(node), elements_.nodal_places()[place].block_id, place});
    std::sort(found.begin(), found.end());
    std::map<Index, Index> row_of_place;
    for (const auto& [id, block, place] : found) {
      row_of_place[place] = 6 * static_cast<Index>(watch.ids.size());
      watch.ids.push_back(id);
      watch.block_ids.push_back(block);
      watch.faces.push_back(elements_.nodal_places()[place].face);
    }
    std::map<Index, double> count;
    for (const auto& group : elements_.groups())
      for (Index e = 0; e < group.nodes.rows(); ++e) add_corners(group, e, row_of_place, count);
    for (auto& entry : entries_)
      entry = {entry.row(), entry.col(), entry.value() / count.at(entry.row() / 6)};
    rows_ = 6 * static_cast<Index>(watch.ids.size());
  }

  // Adds six rows for the stress at an element's centre, of a shell for either face. False: no such
  // element.
  bool add_element(Index id, StressWatch& watch) {
    const Index before = rows_;
    for (const auto& group : elements_.groups()) {
      const auto found = std::find(group.element_ids.begin(), group.element_ids.end(), id);
      if (found == group.element_ids.end()) continue;
      const Index e = found - group.element_ids.begin();
      each_motion(group, e, [&](Index column, const Points& motion) {
        add(rows_, column, elements_.centre_stress(group, e, motion).row(0));
      });
      watch.ids.push_back(id);
      watch.faces.push_back(group.face);
      rows_ += 6;
    }
    return rows_ > before;
  }

  // 6 m x 3 N, rotated to the scene's axes by T.
  SparseMatrix matrix(const Matrix3& T) const {
    SparseMatrix S(rows_, 3 * elements_.n_nodes()), turn(rows_, rows_);
    S.setFromTriplets(entries_.begin(), entries_.end());
    // column j: for a unit component j
    const Matrix of_one = turned_stress(Matrix::Identity(6, 6), T).transpose();
    Entries blocks;
    for (Index row = 0; row < rows_; row += 6)
      for (Index i = 0; i < 6; ++i)
        for (Index j = 0; j < 6; ++j) blocks.emplace_back(row + i, row + j, of_one(i, j));
    turn.setFromTriplets(blocks.begin(), blocks.end());
    return turn * S;
  }

 private:
  template <typename Action>
  void each_motion(const InstanceElements::Group& group, Index e, const Action& action) const {
    const std::vector<Index> nodes = elements_.moving_nodes(group, e);
    Points u = Points::Zero(static_cast<Index>(nodes.size()), 3);
    for (Index b = 0; b < u.rows(); ++b) {
      for (Index d = 0; d < 3; ++d) {
        u(b, d) = 1;
        action(3 * nodes[b] + d, u);
        u(b, d) = 0;
      }
    }
  }

  template <typename Stress>
  void add(Index row, Index column, const Stress& stress) {
    for (Index j = 0; j < 6; ++j)
      if (stress[j] != 0) entries_.emplace_back(row + j, column, stress[j]);
  }

  void add_corners(const InstanceElements::Group& group, Index e,
                   const std::map<Index, Index>& row_of_place, std::map<Index, double>& count) {
    std::vector<std::pair<Index, Index>> wanted;  // node of the element, row
    for (Index a = 0; a < group.nodes.cols(); ++a) {
      const auto found = row_of_place.find(elements_.place(group.nodes(e, a), group.material));
      if (found == row_of_place.end()) continue;
      wanted.emplace_back(a, found->second);
      count[found->second / 6] += 1;
    }
    if (wanted.empty()) return;
    each_motion(group, e, [&](Index column, const Points& motion) {
      const Matrix stress = elements_.corner_stress(group, e, motion);
      for (const auto& [a, row] : wanted) add(row, column, stress.row(a));
    });
  }

  const InstanceElements& elements_;
  Entries entries_;
  Index rows_ = 0;
};

// Rows in terms of the body's coordinates.
void take_rows(const InstanceElements& elements, const SparseMatrix& S, StressWatch& watch) {
  if (elements.is_mesh()) {
    watch.sparse_rows = S;
    return;
  }
  std::vector<char> is_used(static_cast<std::size_t>(elements.n_nodes()), 0);
  for (Index column = 0; column < S.cols(); ++column)
    if (SparseMatrix::InnerIterator(S, column)) is_used[column / 3] = 1;
  std::vector<Index> nodes;
  for (Index node = 0; node < elements.n_nodes(); ++node)
    if (is_used[node] != 0) nodes.push_back(node);
  SparseMatrix compressed(S.rows(), 3 * static_cast<Index>(nodes.size()));
  Entries entries;
  for (Index i = 0; i < static_cast<Index>(nodes.size()); ++i)
    for (Index d = 0; d < 3; ++d)
      for (SparseMatrix::InnerIterator it(S, 3 * nodes[i] + d); it; ++it)
        entries.emplace_back(it.row(), 3 * i + d, it.value());
  compressed.setFromTriplets(entries.begin(), entries.end());
  watch.rows = compressed * elements.dense_rows(nodes);
}

StressWatch watch_of_set(const InstanceElements& elements, const StressOptions& stress,
                         const Matrix3& T) {
  StressWatch watch;
  watch.name = stress.instance + "." + stress.set;
  watch.of_nodes = true;
  StressRows rows(elements);
  const std::vector<Index> nodes = elements.nodes_of_set(stress.set);
  rows.add_nodes(nodes, watch);
  if (watch.ids.empty()) {
    const std::vector<std::string> names = elements.set_names();
    throw InputError(stress.source.text() + ": output.stress: '" + watch.name +
                     "' has no node of a recovered element" + nearest_name(stress.set, names) +
                     " (sets: " + (names.empty() ? "none" : join(names)) + ")");
  }
  take_rows(elements, rows.matrix(T), watch);
  return watch;
}

StressWatch watch_of_elements(const InstanceElements& elements, const StressOptions& stress,
                              const Matrix3& T) {
  StressWatch watch;
  watch.name = stress.instance;
  StressRows rows(elements);
  for (const Index id : stress.elements)
    if (!rows.add_element(id, watch))
      throw InputError(stress.source.text() + ": output.stress: instance '" + stress.instance +
                       "' has no element " + std::to_string(id) +
                       (elements.is_mesh() ? "" : " among those of its recovery data"));
  take_rows(elements, rows.matrix(T), watch);
  return watch;
}

StressScan scan_of(std::shared_ptr<const InstanceElements> elements, const StressOptions& stress,
                   const Matrix3& T) {
  StressScan scan;
  scan.name = stress.instance;
  scan.n_worst = std::min(stress.worst, elements->n_elements());
  scan.envelope = stress.envelope;
  for (const auto& group : elements->groups()) {
    scan.element_ids.insert(scan.element_ids.end(), group.element_ids.begin(),
                            group.element_ids.end());
    scan.element_faces.insert(scan.element_faces.end(), group.element_ids.size(), group.face);
  }
  for (const auto& place : elements->nodal_places()) {
    scan.node_ids.push_back(elements->node_id(place.node));
    scan.node_block_ids.push_back(place.block_id);
    scan.node_faces.push_back(place.face);
  }
  scan.stresses = [elements, T, envelope = stress.envelope](const Vector& q, Matrix& of_elements,
                                                            Matrix& of_nodes) {
    const Points u = elements->displacements(q);
    of_elements = stress_values(turned_stress(elements->element_stresses(u), T));
    if (envelope) of_nodes = stress_values(turned_stress(elements->nodal_stresses(u), T));
  };
  return scan;
}

// Rows and reference of the monitor of an interior set.
void watch_inside(const SceneIndex& index, const SurfaceName& set, const BuiltScene::OfInstance& of,
                  Monitor& monitor) {
  const InstanceElements elements(index.scene(), of, set.source);
  const std::vector<Index> nodes = elements.nodes_of_set(set.surface);
  const Matrix rows = elements.dense_rows(nodes);
  const auto n = static_cast<double>(nodes.size());
  Matrix mean = Matrix::Zero(3, rows.cols());
  Vector3 X = Vector3::Zero();
  for (Index i = 0; i < static_cast<Index>(nodes.size()); ++i) {
    mean += rows.middleRows(3 * i, 3) / n;
    X += elements.position(nodes[i]) / n;
  }
  monitor.rows = of.placement.T * mean;
  monitor.reference = of.placement.T * X + of.placement.position;
}

}  // namespace

void add_stress(const SceneIndex& index, BuiltScene& built) {
  const Scene& scene = index.scene();
  std::map<Index, std::shared_ptr<const InstanceElements>> known;
  for (const StressOptions& stress : scene.output.stress) {
    const Index body = index.place(stress.instance);
    const BuiltScene::OfInstance& of = built.instances[body];
    auto& elements = known[body];
    if (!elements) elements = std::make_shared<InstanceElements>(scene, of, stress.source);
    const Matrix3& T = of.placement.T;
    const auto add = [&](StressWatch watch) {
      watch.body = body;
      built.simulation.watches.push_back(std::move(watch));
    };
    if (!stress.set.empty()) add(watch_of_set(*elements, stress, T));
    if (!stress.elements.empty()) add(watch_of_elements(*elements, stress, T));
    if (stress.worst == 0 && !stress.envelope) continue;
    built.simulation.scans.push_back(scan_of(elements, stress, T));
    built.simulation.scans.back().body = body;
  }
}

void add_monitors(const SceneIndex& index, BuiltScene& built) {
  Simulation& sim = built.simulation;
  std::vector<Index> contact_of_body(sim.bodies.size(), -1);
  for (std::size_t c = 0; c < sim.contact_nodes.size(); ++c)
    contact_of_body[sim.contact_nodes[c].body] = static_cast<Index>(c);
  for (const SurfaceName& surface : index.scene().output.history) {
    Monitor monitor;
    monitor.name = surface.text();
    monitor.body = index.place(surface.instance);
    if (point_of(index.scene(), surface.instance, surface.surface) != nullptr) {
      monitor.has_point = true;
      monitor.point = point_place(index, surface.instance, surface.surface);
      sim.monitors.push_back(std::move(monitor));
      continue;
    }
    const BuiltScene::OfInstance& of = built.instances[monitor.body];
    if (is_inside(*of.geometry, surface.surface)) {
      watch_inside(index, surface, of, monitor);
      sim.monitors.push_back(std::move(monitor));
      continue;
    }
    const auto nodes = find_nodes(*of.geometry, surface.instance, surface.surface, surface.source);
    monitor.mean_set = sim.bodies[monitor.body]->track_mean(nodes);
    monitor.contact = contact_of_body[monitor.body];
    if (monitor.contact >= 0) {
      const auto& contact = sim.contact_nodes[monitor.contact].nodes;
      for (std::size_t slot = 0; slot < contact.size(); ++slot)
        if (std::binary_search(nodes.begin(), nodes.end(), contact[slot]))
          monitor.contact_slots.push_back(static_cast<Index>(slot));
    }
    sim.monitors.push_back(std::move(monitor));
  }
}

}  // namespace cbr
