// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/connected_parts.hpp"

#include <algorithm>
#include <numeric>
#include <sstream>

namespace cbr {
namespace {

Index root(std::vector<Index>& parent, Index i) {
  while (parent[static_cast<std::size_t>(i)] != i) {
    auto& up = parent[static_cast<std::size_t>(i)];
    up = parent[static_cast<std::size_t>(up)];
    i = up;
  }
  return i;
}

}  // namespace

std::vector<Index> connected_parts(const Mesh& mesh, const FiniteElementModel& model) {
  std::vector<Index> parent(model.nodes.size());
  std::iota(parent.begin(), parent.end(), Index{0});
  for (const auto& element_block : mesh.blocks) {
    if (dimension(element_block.type) != 3) continue;
    for (Index e = 0; e < element_block.connectivity.rows(); ++e) {
      const Index first = root(parent, model.row[static_cast<std::size_t>(element_block.connectivity(e, 0))]);
      for (Index a = 1; a < element_block.connectivity.cols(); ++a) {
        parent[static_cast<std::size_t>(root(parent, model.row[static_cast<std::size_t>(element_block.connectivity(e, a))]))] =
            first;
      }
    }
  }
  std::vector<Index> part(parent.size(), -1), number(parent.size(), -1);
  Index n = 0;
  for (std::size_t i = 0; i < parent.size(); ++i) {
    auto& of_root = number[static_cast<std::size_t>(root(parent, static_cast<Index>(i)))];
    if (of_root < 0) of_root = n++;
    part[i] = of_root;
  }
  return part;
}

std::string unjoined_parts(const Mesh& mesh, const FiniteElementModel& model, const std::vector<Index>& part) {
  const Index n_parts = part.empty() ? 0 : *std::max_element(part.begin(), part.end()) + 1;
  if (n_parts < 2) return {};
  const Points X = mesh.coordinates(model.nodes, Eigen::all);
  const double same = 1e-9 * (X.colwise().maxCoeff() - X.colwise().minCoeff()).norm();
  std::vector<Index> order(part.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::sort(order.begin(), order.end(), [&](Index a, Index b) { return X(a, 0) < X(b, 0) || (X(a, 0) == X(b, 0) && a < b); });
  // Along x: those within `same` are looked at one by one, nearest in y and z first found
  Index n_pairs = 0, first = -1, second = -1;
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && X(order[end], 0) - X(order[begin], 0) <= same) ++end;
    std::sort(order.begin() + static_cast<std::ptrdiff_t>(begin), order.begin() + static_cast<std::ptrdiff_t>(end),
              [&](Index a, Index b) { return X(a, 1) < X(b, 1); });
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t k = i + 1; k < end && X(order[k], 1) - X(order[i], 1) <= same; ++k) {
        const Index a = std::min(order[i], order[k]), b = std::max(order[i], order[k]);
        if (part[static_cast<std::size_t>(a)] == part[static_cast<std::size_t>(b)] || (X.row(a) - X.row(b)).norm() > same) continue;
        ++n_pairs;
        if (first < 0 || a < first) first = a, second = b;
      }
    }
  }
  if (n_pairs == 0) return {};
  const auto id = [&](Index i) { return mesh.node_ids[static_cast<std::size_t>(model.nodes[static_cast<std::size_t>(i)])]; };
  std::ostringstream text;
  text << "the mesh has " << n_parts << " parts that share no node, and " << n_pairs << (n_pairs == 1 ? " pair" : " pairs")
       << " of nodes of different parts at the same place (first " << id(first) << " and " << id(second) << " at " << X(first, 0)
       << ", " << X(first, 1) << ", " << X(first, 2)
       << "): nothing holds these parts together; join the nodes in the mesh (gmsh: Coherence Mesh), or make components of them "
          "and tie them";
  return text.str();
}

}  // namespace cbr
