// SPDX-License-Identifier: GPL-3.0-or-later
// Superelements that share nodes put together, and the file of a group.
#include "common/superelement/superelement_group.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/superelement/superelement_check.hpp"
#include "common/superelement/superelement_file.hpp"

namespace cbr {
namespace {

// A triangle in a set of quads repeats its last nodes, as extract_surface() has it.
void widen_to_quads(Surface& surface) {
  if (n_corners(surface.kind) == 4) return;
  const bool is_linear = surface.kind == FaceKind::tri3;
  surface.kind = is_linear ? FaceKind::quad4 : FaceKind::quad8;
  if (is_linear)
    surface.faces = surface.faces(Eigen::all, std::array{0, 1, 2, 2}).eval();
  else
    surface.faces = surface.faces(Eigen::all, std::array{0, 1, 2, 2, 3, 4, 2, 5}).eval();
}

// Faces of one name; `more` indexes the joined nodes already.
void append(Surface& surface, Surface more) {
  if (surface.kind != more.kind) {
    const std::string kinds = "faces of kind " + std::string(name(more.kind)) + " in one domain, " +
                              std::string(name(surface.kind)) + " in another";
    widen_to_quads(surface);
    widen_to_quads(more);
    if (surface.kind != more.kind)
      throw InputError("/interface/" + surface.name + ": " + kinds +
                       ": only tri3 and quad4, or tri6 and quad8, go together");
  }
  const Index n = surface.n_faces();
  surface.faces.conservativeResize(n + more.n_faces(), Eigen::NoChange);
  surface.faces.bottomRows(more.n_faces()) = more.faces;
  surface.element.insert(surface.element.end(), more.element.begin(), more.element.end());
  surface.side.insert(surface.side.end(), more.side.begin(), more.side.end());
}

void join_surfaces(const SuperelementGroup& group, JoinedNodes& joined) {
  std::map<std::string, Surface> by_name;
  for (std::size_t d = 0; d < group.domains.size(); ++d) {
    for (Surface surface : group.domains[d].surfaces) {
      for (Index& node : surface.faces.reshaped()) node = joined.place[d][node];
      const auto [place, is_new] = by_name.try_emplace(surface.name, surface);
      if (!is_new) append(place->second, std::move(surface));
    }
  }
  for (auto& [name, surface] : by_name) joined.surfaces.push_back(std::move(surface));
}

void join_nodesets(const SuperelementGroup& group, JoinedNodes& joined) {
  std::map<std::string, std::set<Index>> by_name;
  for (std::size_t d = 0; d < group.domains.size(); ++d) {
    for (const auto& [name, nodes] : group.domains[d].nodesets) {
      auto& all = by_name[name];
      for (const Index node : nodes) all.insert(joined.place[d][node]);
    }
  }
  for (const auto& [name, nodes] : by_name)
    joined.nodesets[name].assign(nodes.begin(), nodes.end());
}

// Per dof of the domain its number among the joined ones, 3 node + component.
std::vector<Index> joined_dofs(const Superelement& domain, const std::vector<Index>& place) {
  std::vector<Index> dofs;
  for (std::size_t i = 0; i < domain.dof_node.size(); ++i) {
    dofs.push_back(3 * place[domain.dof_node[i]] + domain.dof_component[i]);
  }
  return dofs;
}

// Domains that were read without their matrices give a whole without them.
bool has_matrices(const SuperelementGroup& group) {
  return std::all_of(group.domains.begin(), group.domains.end(), [](const Superelement& s) {
    return s.K_cc.rows() == s.c() && s.M_kc.cols() == s.c();
  });
}

void join_matrices(const SuperelementGroup& group, const JoinedNodes& joined, Superelement& whole) {
  const Index c = whole.c();
  whole.K_cc = Matrix::Zero(c, c);
  whole.M_cc = Matrix::Zero(c, c);
  whole.M_kc = Matrix::Zero(whole.k(), c);
  Index first = 0;
  for (std::size_t d = 0; d < group.domains.size(); ++d) {
    const Superelement& s = group.domains[d];
    const std::vector<Index> dofs = joined_dofs(s, joined.place[d]);
    for (Index j = 0; j < s.c(); ++j) {
      const Index column = dofs[j];
      for (Index i = 0; i < s.c(); ++i) {
        const Index row = dofs[i];
        whole.K_cc(row, column) += s.K_cc(i, j);
        whole.M_cc(row, column) += s.M_cc(i, j);
      }
      whole.M_kc.col(column).segment(first, s.k()) = s.M_kc.col(j);
    }
    first += s.k();
  }
}

}  // namespace

JoinedNodes join_nodes(const SuperelementGroup& group) {
  std::map<Index, Index> row;  // id -> row
  for (const auto& domain : group.domains) {
    for (const Index id : domain.node_ids) row.try_emplace(id, 0);
  }
  JoinedNodes joined;
  for (auto& [id, i] : row) {
    i = static_cast<Index>(joined.node_ids.size());
    joined.node_ids.push_back(id);
  }
  joined.coordinates.resize(static_cast<Index>(row.size()), 3);
  for (const auto& domain : group.domains) {
    auto& place = joined.place.emplace_back();
    for (std::size_t i = 0; i < domain.node_ids.size(); ++i) {
      place.push_back(row.at(domain.node_ids[i]));
      joined.coordinates.row(place.back()) = domain.coordinates.row(static_cast<Index>(i));
    }
  }
  join_surfaces(group, joined);
  join_nodesets(group, joined);
  return joined;
}

Superelement join(const SuperelementGroup& group) {
  JoinedNodes joined = join_nodes(group);
  Superelement whole;
  if (!group.domains.empty()) whole.basis = group.domains.front().basis;
  whole.content_hash = group.content_hash;
  whole.provenance = group.provenance;
  whole.rigid_body = group.rigid_body;
  Index k = 0;
  for (const auto& domain : group.domains) k += domain.k();
  whole.eigenvalues.resize(k);
  k = 0;
  for (const auto& domain : group.domains) {
    whole.eigenvalues.segment(k, domain.k()) = domain.eigenvalues;
    k += domain.k();
  }
  for (Index i = 0; i < 3 * static_cast<Index>(joined.node_ids.size()); ++i) {
    whole.dof_node.push_back(i / 3);
    whole.dof_component.push_back(static_cast<int>(i % 3));
  }
  if (has_matrices(group)) join_matrices(group, joined, whole);
  whole.node_ids = std::move(joined.node_ids);
  whole.coordinates = std::move(joined.coordinates);
  whole.surfaces = std::move(joined.surfaces);
  whole.nodesets = std::move(joined.nodesets);
  whole.omega = group.omega;
  whole.V = group.V;
  return whole;
}

namespace {

constexpr double same_place = 1e-12;  // of the group's size
constexpr double same_mass = 1e-9;    // of the mass
constexpr const char* domains = "/domains";

std::string domain_path(std::size_t d) {
  return std::string(domains) + "/" + std::to_string(d + 1);
}

class GroupChecker {
 public:
  GroupChecker(const SuperelementGroup& group, const std::string& where)
      : group_(group), where_(where) {}

  // The domains themselves have passed check_parts().
  void check(const SuperelementParts& parts) const {
    if (group_.domains.empty())
      fail("attribute 'n_domains'", "is 0: a group has at least one domain");
    for (std::size_t d = 0; d < group_.domains.size(); ++d) check_domain(d);
    check_coordinates();
    const Superelement whole = described();
    check_mass(whole);
    // Common to a superelement and a group: shapes of /diagonal, the rigid body, consistent faces.
    check_parts(whole, {false, parts.diagonal, false}, where_);
    check_conditioning(group_.conditioning, whole.n(), where_);
    if (group_.has_diagonal_form() && parts.matrices)
      check_parts(join(group_), {true, true, false}, where_);
  }

 private:
  [[noreturn]] void fail(const std::string& field, const std::string& what) const {
    throw InputError(where_ + ": " + field + ": " + what);
  }

  void check_domain(std::size_t d) const {
    const Superelement& s = group_.domains[d];
    if (s.basis != group_.domains.front().basis) {
      fail(domain_path(d), "attribute 'basis' is '" + s.basis + "', '" +
                               group_.domains.front().basis + "' in " + domain_path(0));
    }
    if (!s.has_interface_matrices())
      fail(domain_path(d),
           "attribute 'basis' is '" + s.basis + "', which cannot be that of a domain");
    // A dof that some domain does not have would be one without mass in the whole, or a hinge.
    if (s.c() != 3 * static_cast<Index>(s.node_ids.size())) {
      fail(domain_path(d) + "/dofs/node", std::to_string(s.c()) + " dofs for " +
                                              std::to_string(s.node_ids.size()) +
                                              " nodes: in a group each node has x, y and z");
    }
  }

  void check_coordinates() const {
    std::map<Index, std::pair<std::size_t, Vector3>> first;  // id -> domain and place
    double size = 0;
    for (const auto& s : group_.domains) {
      if (s.coordinates.rows() > 0)
        size = std::max(
            size, (s.coordinates.colwise().maxCoeff() - s.coordinates.colwise().minCoeff()).norm());
    }
    for (std::size_t d = 0; d < group_.domains.size(); ++d) {
      const Superelement& s = group_.domains[d];
      for (std::size_t i = 0; i < s.node_ids.size(); ++i) {
        const Vector3 x = s.coordinates.row(static_cast<Index>(i));
        const auto [other, is_new] = first.try_emplace(s.node_ids[i], d, x);
        if (is_new || (other->second.second - x).norm() <= same_place * size) continue;
        fail(domain_path(d) + "/nodes/coordinates", "node id " + std::to_string(s.node_ids[i]) +
                                                        " is elsewhere in " +
                                                        domain_path(other->second.first));
      }
    }
  }

  void check_mass(const Superelement& whole) const {
    double mass = 0;
    for (const auto& s : group_.domains) mass += s.rigid_body.mass;
    if (std::abs(mass - whole.rigid_body.mass) <= same_mass * mass) return;
    fail("/rigid_body/mass",
         number_text(whole.rigid_body.mass) + " is not the domains' sum " + number_text(mass));
  }

  // join() without matrices, which may be large.
  Superelement described() const {
    SuperelementGroup light;
    for (const auto& s : group_.domains) {
      Superelement& copy = light.domains.emplace_back();
      copy.basis = s.basis;
      copy.eigenvalues = s.eigenvalues;
      copy.dof_node = s.dof_node;
      copy.dof_component = s.dof_component;
      copy.node_ids = s.node_ids;
      copy.coordinates = s.coordinates;
      copy.surfaces = s.surfaces;
      copy.nodesets = s.nodesets;
    }
    light.rigid_body = group_.rigid_body;
    light.omega = group_.omega;
    light.V = group_.V;
    try {
      return join(light);
    } catch (const InputError& error) {
      throw InputError(where_ + ": " + error.what());
    }
  }

  const SuperelementGroup& group_;
  const std::string& where_;
};

Index n_modes(const SuperelementGroup& group) {
  Index k = 0;
  for (const auto& domain : group.domains) k += domain.k();
  return k;
}

}  // namespace

bool is_superelement_group(const std::filesystem::path& path) {
  try {
    const Hdf5Reader file(path);
    return file.has_attribute("/", "format") &&
           file.read_string("/", "format") == superelement_group_format;
  } catch (const InputError&) {
    return false;
  }
}

SuperelementGroup read_superelement_group(const std::filesystem::path& path,
                                          const SuperelementParts& parts) {
  const Hdf5Reader file(path);
  check_format(file, "", superelement_group_format);
  SuperelementGroup group;
  group.content_hash = file.read_string("/", "content_hash");
  const std::string basis = file.read_string("/", "basis");
  const auto n_domains = file.has(domains) ? static_cast<Index>(file.children(domains).size()) : 0;
  check_count(file, "", "n_domains", n_domains, domains);
  for (std::size_t d = 0; d < static_cast<std::size_t>(n_domains); ++d) {
    group.domains.push_back(
        read_superelement_at(file, domain_path(d), {parts.matrices, false, parts.recovery}));
  }
  group.rigid_body = read_rigid_body(file, "");
  if (parts.diagonal && file.has("/diagonal")) {
    group.omega = file.read_vector("/diagonal/omega");
    group.V = file.read_row_matrix("/diagonal/V");
  }
  group.conditioning = read_conditioning(file, "");
  group.provenance = file.texts("/provenance");
  GroupChecker(group, path.string()).check(parts);
  if (basis != group.domains.front().basis) {
    throw InputError(path.string() + ": attribute 'basis' is '" + basis + "', '" +
                     group.domains.front().basis + "' in the domains");
  }
  check_count(file, "", "n_modes", n_modes(group), domains);
  check_count(file, "", "n_interface", 3 * static_cast<Index>(join_nodes(group).node_ids.size()),
              domains);
  return group;
}

void write_superelement_group(const SuperelementGroup& group, const std::filesystem::path& path) {
  for (std::size_t d = 0; d < group.domains.size(); ++d)
    cbr::check(group.domains[d], path.string() + ": " + domain_path(d));
  GroupChecker(group, path.string()).check({});
  Hdf5Writer file(path);
  file.add_checksums();
  write_format(file, "", superelement_group_format, superelement_group_version);
  file.attribute("/", "content_hash", group.content_hash);
  file.attribute("/", "basis", group.domains.front().basis);
  file.attribute("/", "n_domains", static_cast<Index>(group.domains.size()));
  file.attribute("/", "n_modes", n_modes(group));
  file.attribute("/", "n_interface", 3 * static_cast<Index>(join_nodes(group).node_ids.size()));
  for (std::size_t d = 0; d < group.domains.size(); ++d)
    write_superelement_at(file, domain_path(d), group.domains[d]);
  write_rigid_body(file, "", group.rigid_body);
  if (group.has_diagonal_form()) {
    file.write("/diagonal/omega", group.omega);
    file.write("/diagonal/V", group.V);
  }
  write_conditioning(file, "", group.conditioning);
  for (const auto& [key, value] : group.provenance) file.attribute("/provenance", key, value);
  file.commit();
}

}  // namespace cbr
