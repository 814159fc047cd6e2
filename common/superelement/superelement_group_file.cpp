// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <string>

#include "common/base/error.hpp"
#include "common/base/number_text.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/superelement/superelement_check.hpp"
#include "common/superelement/superelement_extras.hpp"
#include "common/superelement/superelement_file.hpp"
#include "common/superelement/superelement_group.hpp"

namespace cbr {
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
  group.provenance = read_provenance(file, "");
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
