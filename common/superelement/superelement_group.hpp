// SPDX-License-Identifier: GPL-3.0-or-later
// A decomposed component: superelements that share nodes. Equal node ids join them; nothing is
// tied.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/superelement/superelement.hpp"

namespace cbr {

// Each domain is a whole superelement on the mesh's node ids; its interface is the component's
// interface inside it and the nodes that it shares with other domains. Its surfaces and nodesets
// are those of the component's interface, as far as they lie in it.
struct SuperelementGroup {
  std::string content_hash;
  std::vector<Superelement> domains;
  RigidBody rigid_body;  // of the whole component
  // Optional diagonal form of join(): as Superelement::omega and V, in its order of coordinates.
  Vector omega;
  RowMatrix V;
  std::optional<Conditioning> conditioning;  // optional, of the joined domains
  std::map<std::string, std::string> provenance;

  bool has_diagonal_form() const { return omega.size() > 0; }
};

// The nodes of all domains, each once, ascending by id, with their data.
struct JoinedNodes {
  std::vector<Index> node_ids;            // n
  Points coordinates;                     // n x 3
  std::vector<std::vector<Index>> place;  // per domain and node of it: its row above
  // the domains' faces of one name, one after the other
  std::vector<Surface> surfaces;
  std::map<std::string, std::vector<Index>> nodesets;  // ascending, unique
};
JoinedNodes join_nodes(const SuperelementGroup& group);

// The group as one superelement, dense: k = the domains' modes one after the other, c = 3 n dofs of
// the joined nodes (x, y, z of each). Exact: its K_kc is 0 and its M_kk I as every superelement's.
// With the group's diagonal form when it has one.
Superelement join(const SuperelementGroup& group);

// File: format "cbr-superelement-group" (docs/formats.md). InputErrors as of read_superelement,
// naming the domain.
bool is_superelement_group(const std::filesystem::path& file);
SuperelementGroup read_superelement_group(const std::filesystem::path& file,
                                          const SuperelementParts& parts = {});
void write_superelement_group(const SuperelementGroup& group, const std::filesystem::path& file);

}  // namespace cbr
