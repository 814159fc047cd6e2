// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "reducer/domains/decomposition.hpp"
#include "reducer/partition/graph_partition.hpp"

namespace cbr {
namespace {

// Per mesh node the domains that use it, ascending.
std::vector<std::vector<Index>> domains_of_nodes(const Mesh& mesh,
                                                 const Decomposition& decomposition) {
  std::vector<std::vector<Index>> domains(mesh.node_ids.size());
  const ElementNodes elements = element_nodes(mesh);
  for (Index e = 0; e < elements.size(); ++e) {
    for (const Index node : elements.of(e)) {
      auto& of = domains[node];
      const Index d = decomposition.domain[e];
      const auto place = std::lower_bound(of.begin(), of.end(), d);
      if (place == of.end() || *place != d) of.insert(place, d);
    }
  }
  return domains;
}

// Where an element of the whole went.
struct Place {
  Index domain = -1, block = -1, row = -1;
};

void take_elements(const Mesh& mesh, const Decomposition& decomposition,
                   std::vector<Domain>& domains, std::vector<std::vector<Place>>& places) {
  Index element = 0;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    const Block& block = mesh.blocks[b];
    places[b].resize(block.connectivity.rows());
    if (dimension(block.type) != 3) continue;
    std::vector<std::vector<Index>> rows(domains.size());
    for (Index e = 0; e < block.connectivity.rows(); ++e, ++element) {
      const Index d = decomposition.domain[element];
      auto& of = rows[d];
      places[b][e] = {d, static_cast<Index>(domains[d].mesh.blocks.size()),
                      static_cast<Index>(of.size())};
      of.push_back(e);
    }
    for (std::size_t d = 0; d < domains.size(); ++d) {
      if (rows[d].empty()) continue;
      Block part{block.name, block.id, block.type, block.connectivity(rows[d], Eigen::all), {}};
      for (const Index e : rows[d]) part.element_ids.push_back(block.element_ids[e]);
      domains[d].mesh.blocks.push_back(std::move(part));
      domains[d].block.push_back(static_cast<Index>(b));
    }
  }
}

// Nodes in the order of the whole mesh; connectivity and interface in the domain's own numbers.
void take_nodes(const Mesh& mesh, const std::vector<std::vector<Index>>& domains_of,
                const std::vector<Index>& interface, std::vector<Domain>& domains) {
  std::vector<bool> kept(mesh.node_ids.size(), false);
  for (const Index node : interface) kept[node] = true;
  for (std::size_t node = 0; node < domains_of.size(); ++node) {
    for (const Index d : domains_of[node]) {
      Domain& domain = domains[d];
      const auto i = static_cast<Index>(domain.node.size());
      domain.node.push_back(static_cast<Index>(node));
      domain.mesh.node_ids.push_back(mesh.node_ids[node]);
      if (kept[node] || domains_of[node].size() > 1) domain.interface.push_back(i);
    }
  }
  std::vector<Index> local(mesh.node_ids.size(), -1);  // of one domain after the other
  for (Domain& domain : domains) {
    domain.mesh.coordinates = mesh.coordinates(domain.node, Eigen::all);
    for (std::size_t i = 0; i < domain.node.size(); ++i)
      local[domain.node[i]] = static_cast<Index>(i);
    for (Block& block : domain.mesh.blocks) {
      for (Index& node : block.connectivity.reshaped()) node = local[node];
    }
  }
}

bool is_wanted(const std::vector<std::string>& sets, const std::string& name) {
  return std::find(sets.begin(), sets.end(), name) != sets.end();
}

void take_sidesets(const Mesh& mesh, const std::vector<std::vector<Place>>& places,
                   const std::vector<std::string>& sets, std::vector<Domain>& domains) {
  for (const Sideset& sideset : mesh.sidesets) {
    if (!is_wanted(sets, sideset.name)) continue;
    std::vector<Sideset> parts(domains.size(), Sideset{sideset.name, sideset.id, {}});
    for (const Side& side : sideset.sides) {
      const Place& place = places[side.block][side.element];
      if (place.domain >= 0)
        parts[place.domain].sides.push_back({place.block, place.row, side.side});
    }
    for (std::size_t d = 0; d < domains.size(); ++d) {
      if (!parts[d].sides.empty()) domains[d].mesh.sidesets.push_back(std::move(parts[d]));
    }
  }
}

void take_nodesets(const Mesh& mesh, const std::vector<std::string>& sets,
                   std::vector<Domain>& domains) {
  for (const Nodeset& nodeset : mesh.nodesets) {
    if (!is_wanted(sets, nodeset.name)) continue;
    for (Domain& domain : domains) {
      Nodeset part{nodeset.name, nodeset.id, {}};
      for (const Index node : nodeset.nodes) {
        const auto place = std::lower_bound(domain.node.begin(), domain.node.end(), node);
        if (place != domain.node.end() && *place == node)
          part.nodes.push_back(place - domain.node.begin());
      }
      if (!part.nodes.empty()) domain.mesh.nodesets.push_back(std::move(part));
    }
  }
}

}  // namespace

std::vector<Index> shared_nodes(const Mesh& mesh, const Decomposition& decomposition) {
  const auto domains = domains_of_nodes(mesh, decomposition);
  std::vector<Index> shared;
  for (std::size_t node = 0; node < domains.size(); ++node) {
    if (domains[node].size() > 1) shared.push_back(static_cast<Index>(node));
  }
  return shared;
}

std::vector<Domain> split(const Mesh& mesh, const Decomposition& decomposition,
                          const std::vector<Index>& interface,
                          const std::vector<std::string>& sets) {
  std::vector<Domain> domains(decomposition.n_domains);
  std::vector<std::vector<Place>> places(mesh.blocks.size());
  take_elements(mesh, decomposition, domains, places);
  take_nodes(mesh, domains_of_nodes(mesh, decomposition), interface, domains);
  take_sidesets(mesh, places, sets, domains);
  take_nodesets(mesh, sets, domains);
  return domains;
}

}  // namespace cbr
