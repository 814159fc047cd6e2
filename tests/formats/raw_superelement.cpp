// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/formats/raw_superelement.hpp"

#include <set>

#include "common/files/hdf5_file.hpp"

namespace cbr::test {
namespace {

std::vector<Index> widened(const std::vector<int>& values) {
  return {values.begin(), values.end()};
}

}  // namespace

RawFile raw_superelement(const Superelement& s, const std::string& prefix) {
  const std::string root = prefix.empty() ? "/" : prefix;
  RawFile raw;
  raw.datasets = {{prefix + "/matrices/eigenvalues", s.eigenvalues},
                  {prefix + "/matrices/K_cc", s.K_cc},
                  {prefix + "/matrices/M_cc", s.M_cc},
                  {prefix + "/matrices/M_kc", s.M_kc},
                  {prefix + "/dofs/node", s.dof_node},
                  {prefix + "/dofs/component", widened(s.dof_component)},
                  {prefix + "/nodes/id", s.node_ids},
                  {prefix + "/nodes/coordinates", Matrix(s.coordinates)},
                  {prefix + "/rigid_body/mass", s.rigid_body.mass},
                  {prefix + "/rigid_body/center", Vector(s.rigid_body.center)},
                  {prefix + "/rigid_body/inertia", Matrix(s.rigid_body.inertia)}};
  raw.attributes = {{{root, "format"}, std::string("cbr-superelement")},
                    {{root, "format_version"}, std::string("1.0")},
                    {{root, "generator"}, std::string("another program")},
                    {{root, "content_hash"}, s.content_hash},
                    {{root, "basis"}, s.basis},
                    {{root, "n_modes"}, s.k()},
                    {{root, "n_interface"}, s.c()}};
  for (const auto& surface : s.surfaces) {
    const std::string group = prefix + "/interface/" + surface.name;
    raw.datasets[group + "/faces"] = surface.faces;
    raw.datasets[group + "/element"] = surface.element;
    raw.datasets[group + "/side"] = widened(surface.side);
    raw.attributes[{group + "/faces", "kind"}] =
        std::string(surface.kind == FaceKind::tri3 ? "tri3" : "quad4");
  }
  for (const auto& [name, nodes] : s.nodesets) raw.datasets[prefix + "/nodesets/" + name] = nodes;
  if (s.has_diagonal_form()) {
    raw.datasets[prefix + "/diagonal/omega"] = s.omega;
    raw.datasets[prefix + "/diagonal/V"] = Matrix(s.V);
  }
  for (const auto& recovery : s.recovery) {
    raw.datasets[prefix + "/recovery/nodes/id"] = recovery.node_ids;
    raw.datasets[prefix + "/recovery/nodes/coordinates"] = Matrix(recovery.coordinates);
    raw.datasets[prefix + "/recovery/Psi"] = recovery.Psi;
    raw.datasets[prefix + "/recovery/Phi"] = recovery.Phi;
    const Block& block = recovery.blocks.at(0);
    const std::string group = prefix + "/recovery/blocks/000000";
    raw.datasets[group + "/connectivity"] = block.connectivity;
    raw.datasets[group + "/element_id"] = block.element_ids;
    raw.attributes[{group, "name"}] = block.name;
    raw.attributes[{group, "id"}] = block.id;
    raw.attributes[{group, "type"}] = std::string(name(block.type));
  }
  for (const auto& [key, value] : s.provenance)
    raw.attributes[{prefix + "/provenance", key}] = value;
  return raw;
}

RawFile raw_group(const SuperelementGroup& group) {
  RawFile raw;
  raw.datasets = {{"/rigid_body/mass", group.rigid_body.mass},
                  {"/rigid_body/center", Vector(group.rigid_body.center)},
                  {"/rigid_body/inertia", Matrix(group.rigid_body.inertia)}};
  if (group.has_diagonal_form()) {
    raw.datasets["/diagonal/omega"] = group.omega;
    raw.datasets["/diagonal/V"] = Matrix(group.V);
  }
  std::set<Index> nodes;
  Index n_modes = 0;
  for (const auto& domain : group.domains) {
    nodes.insert(domain.node_ids.begin(), domain.node_ids.end());
    n_modes += domain.k();
  }
  raw.attributes = {{{"/", "format"}, std::string("cbr-superelement-group")},
                    {{"/", "format_version"}, std::string("1.0")},
                    {{"/", "generator"}, std::string("another program")},
                    {{"/", "content_hash"}, group.content_hash},
                    {{"/", "basis"}, group.domains[0].basis},
                    {{"/", "n_domains"}, static_cast<Index>(group.domains.size())},
                    {{"/", "n_modes"}, n_modes},
                    {{"/", "n_interface"}, static_cast<Index>(3 * nodes.size())}};
  for (std::size_t d = 0; d < group.domains.size(); ++d) {
    RawFile domain = raw_superelement(group.domains[d], "/domains/" + std::to_string(d + 1));
    raw.datasets.merge(domain.datasets);
    raw.attributes.merge(domain.attributes);
  }
  for (const auto& [key, value] : group.provenance) raw.attributes[{"/provenance", key}] = value;
  return raw;
}

void write_raw(const RawFile& raw, const std::filesystem::path& file) {
  Hdf5Writer writer(file);
  for (const auto& [name, values] : raw.datasets) {
    std::visit([&, dataset = name](const auto& array) { writer.write(dataset, array); }, values);
  }
  for (const auto& [where, value] : raw.attributes) {
    std::visit([&, object = where.first, name = where.second](
                   const auto& single) { writer.attribute(object, name, single); },
               value);
  }
  writer.commit();
}

bool is_integer(const RawDataset& values) {
  return std::holds_alternative<std::vector<Index>>(values) ||
         std::holds_alternative<IndexTable>(values);
}

RawDataset with_first(RawDataset values, double entry) {
  std::visit(
      [&](auto& array) {
        using Array = std::decay_t<decltype(array)>;
        if constexpr (std::is_same_v<Array, double>) {
          array = entry;
        } else {
          array.data()[0] = static_cast<typename std::decay_t<decltype(array.data()[0])>>(entry);
        }
      },
      values);
  return values;
}

// One row more and one row less.
std::vector<RawDataset> wrong_lengths(const RawDataset& values) {
  const auto resized = [&](Index change) {
    return std::visit(
        [&](auto array) -> RawDataset {
          using Array = std::decay_t<decltype(array)>;
          if constexpr (std::is_same_v<Array, double>) {
            return Vector(Vector::Constant(1 + change, array));
          } else if constexpr (std::is_same_v<Array, std::vector<Index>>) {
            array.resize(array.size() + static_cast<std::size_t>(change), array.back() + 1000);
            return array;
          } else {
            const Array whole = array;
            array.setZero(whole.rows() + change, whole.cols());
            const Index rows = std::min(whole.rows(), array.rows());
            array.topRows(rows) = whole.topRows(rows);
            return array;
          }
        },
        values);
  };
  return {resized(1), resized(-1)};
}

RawDataset of_other_rank(const RawDataset& values) {
  return std::visit(
      [&](const auto& array) -> RawDataset {
        using Array = std::decay_t<decltype(array)>;
        if constexpr (std::is_same_v<Array, double>) return Matrix(Matrix::Constant(1, 1, array));
        if constexpr (std::is_same_v<Array, Vector>) return Matrix(array);
        if constexpr (std::is_same_v<Array, Matrix>) return Vector(array.reshaped());
        if constexpr (std::is_same_v<Array, std::vector<Index>>)
          return IndexTable(IndexTable::Zero(static_cast<Index>(array.size()), 1));
        if constexpr (std::is_same_v<Array, IndexTable>)
          return std::vector<Index>(array.data(), array.data() + array.size());
      },
      values);
}

RawDataset of_other_type(const RawDataset& values) {
  return std::visit(
      [&](const auto& array) -> RawDataset {
        using Array = std::decay_t<decltype(array)>;
        if constexpr (std::is_same_v<Array, double>) return std::vector<Index>{1};
        if constexpr (std::is_same_v<Array, Vector>)
          return std::vector<Index>(static_cast<std::size_t>(array.size()), 1);
        if constexpr (std::is_same_v<Array, Matrix>)
          return IndexTable(array.template cast<Index>());
        if constexpr (std::is_same_v<Array, std::vector<Index>>)
          return Vector(Vector::Zero(static_cast<Index>(array.size())));
        if constexpr (std::is_same_v<Array, IndexTable>)
          return Matrix(array.template cast<double>());
      },
      values);
}

}  // namespace cbr::test
