// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/connected_parts.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <sstream>
#include <unordered_map>
#include <utility>

#include "common/base/format_text.hpp"

namespace cbr {
namespace {

Index root(std::vector<Index>& parent, Index i) {
  while (parent[i] != i) {
    auto& up = parent[i];
    up = parent[up];
    i = up;
  }
  return i;
}

// Per model node: a node nearer than a thousandth of the shortest edge of its elements is at the
// same place, but for round-off.
std::vector<double> near_enough(const Mesh& mesh, const FiniteElementModel& model) {
  constexpr double share = 1e-3;
  std::vector<double> near(model.n_translations(), std::numeric_limits<double>::infinity());
  for (const auto& block : mesh.blocks) {
    if (!is_structure(block)) continue;
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      double shortest = std::numeric_limits<double>::infinity();
      for (Index a = 0; a < block.connectivity.cols(); ++a)
        for (Index b = 0; b < a; ++b)
          shortest = std::min(shortest, (mesh.coordinates.row(block.connectivity(e, a)) -
                                         mesh.coordinates.row(block.connectivity(e, b)))
                                            .norm());
      for (const Index node : block.connectivity.row(e)) {
        double& of_node = near[model.row[node]];
        of_node = std::min(of_node, share * shortest);
      }
    }
  }
  return near;
}

std::uint64_t key_of(const Vector3& cell) {
  std::uint64_t key = 0;
  for (const double c : cell) {
    key = (key ^ std::bit_cast<std::uint64_t>(c + 0.0)) * 0x9e3779b97f4a7c15u;
    key ^= key >> 32;
  }
  return key;
}

}  // namespace

std::vector<Index> connected_parts(const Mesh& mesh, const FiniteElementModel& model) {
  std::vector<Index> parent = first_numbers(model.nodes.size());
  for (const auto& element_block : mesh.blocks) {
    if (!is_structure(element_block)) continue;
    for (Index e = 0; e < element_block.connectivity.rows(); ++e) {
      const Index first = root(parent, model.row[element_block.connectivity(e, 0)]);
      for (Index a = 1; a < element_block.connectivity.cols(); ++a) {
        parent[root(parent, model.row[element_block.connectivity(e, a)])] = first;
      }
    }
  }
  for (Index i = model.n_translations(); i < static_cast<Index>(model.nodes.size()); ++i) {
    const Index node = model.nodes[i];
    parent[i] = root(parent, model.row[node]);
  }
  std::vector<Index> part(parent.size(), -1), number(parent.size(), -1);
  Index n = 0;
  for (std::size_t i = 0; i < parent.size(); ++i) {
    auto& of_root = number[root(parent, static_cast<Index>(i))];
    if (of_root < 0) of_root = n++;
    part[i] = of_root;
  }
  return part;
}

std::vector<NearNodes> near_nodes(const Mesh& mesh, const FiniteElementModel& model,
                                  const std::vector<Index>& part) {
  const std::vector<double> near = near_enough(mesh, model);
  const Points X = mesh.coordinates(model.nodes, Eigen::all);
  const Vector3 low = X.colwise().minCoeff();
  std::map<int, std::vector<std::size_t>> of_level;  // cells of 2^level
  for (std::size_t i = 0; i < near.size(); ++i)
    if (near[i] > 0) of_level[std::ilogb(near[i]) + 1].push_back(i);
  std::vector<NearNodes> found;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells;
  // From the coarsest on: a node is looked for by the finer of two, among those whose own distance
  // is as long
  std::vector<std::size_t> known;
  for (auto level = of_level.rbegin(); level != of_level.rend(); ++level) {
    const double size = std::ldexp(1.0, level->first);
    const auto cell = [&](std::size_t i) -> Vector3 {
      return ((Vector3(X.row(static_cast<Index>(i))) - low) / size).array().floor();
    };
    known.insert(known.end(), level->second.begin(), level->second.end());
    cells.clear();
    for (const std::size_t i : known) cells[key_of(cell(i))].push_back(i);
    for (const std::size_t i : level->second) {
      for (int shift = 0; shift < 27; ++shift) {
        const auto at =
            cells.find(key_of(cell(i) + Vector3(shift % 3 - 1, shift / 3 % 3 - 1, shift / 9 - 1)));
        if (at == cells.end()) continue;
        for (const std::size_t j : at->second) {
          if (part[i] == part[j] || (std::ilogb(near[j]) + 1 == level->first && j < i)) continue;
          const double apart = (X.row(static_cast<Index>(i)) - X.row(static_cast<Index>(j))).norm();
          if (apart <= std::min(near[i], near[j]))
            found.push_back(
                {static_cast<Index>(std::min(i, j)), static_cast<Index>(std::max(i, j)), apart});
        }
      }
    }
  }
  // Cells of unlike places may have one key: each pair once
  std::sort(found.begin(), found.end(), [](const NearNodes& a, const NearNodes& b) {
    return std::pair(a.first, a.second) < std::pair(b.first, b.second);
  });
  found.erase(std::unique(found.begin(), found.end(),
                          [](const NearNodes& a, const NearNodes& b) {
                            return a.first == b.first && a.second == b.second;
                          }),
              found.end());
  return found;
}

std::string how_near(double apart) {
  if (apart == 0) return "at the same place";
  return format_text("only %.2g apart", apart);
}

Index n_parts(const std::vector<Index>& part) {
  return part.empty() ? 0 : *std::max_element(part.begin(), part.end()) + 1;
}

std::string unjoined_parts(const Mesh& mesh, const FiniteElementModel& model,
                           const std::vector<Index>& part) {
  if (n_parts(part) < 2) return {};
  const std::vector<NearNodes> pairs = near_nodes(mesh, model, part);
  if (pairs.empty()) return {};
  const auto id = [&](Index i) { return mesh.node_ids[model.nodes[i]]; };
  double farthest = 0;
  for (const NearNodes& pair : pairs) farthest = std::max(farthest, pair.apart);
  const Vector3 x = mesh.coordinates.row(model.nodes[pairs[0].first]);
  std::ostringstream text;
  text << "the mesh has " << n_parts(part) << " parts that share no node, and " << pairs.size()
       << (pairs.size() == 1 ? " pair" : " pairs") << " of nodes of different parts "
       << how_near(farthest) << " (first " << id(pairs[0].first) << " and " << id(pairs[0].second)
       << " at " << x(0) << ", " << x(1) << ", " << x(2)
       << "): nothing holds these parts together; join the nodes in the mesh (gmsh: Coherence Mesh"
       << (farthest > 0 ? ", with a tolerance above that" : "")
       << "), or make components of them and tie them";
  return text.str();
}

std::string several_parts(const Mesh& mesh, const FiniteElementModel& model,
                          const std::vector<Index>& part) {
  const Index n = n_parts(part);
  if (n < 2) return {};
  std::vector<Index> first(n, -1);
  for (std::size_t i = part.size(); i-- > 0;) first[part[i]] = mesh.node_ids[model.nodes[i]];
  std::string nodes;
  constexpr Index most = 6;
  for (Index p = 0; p < std::min(n, most); ++p)
    nodes += (p > 0 ? ", " : "") + std::to_string(first[p]);
  return std::to_string(n) + " parts that share no node (first node ids " + nodes +
         (n > most ? ", ..." : "") + "): each moves on its own";
}

}  // namespace cbr
