// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/formats/raw_superelement.hpp"

#include "common/hdf5_file.hpp"

namespace cbr::test {
namespace {

std::vector<Index> widened(const std::vector<int>& values) { return {values.begin(), values.end()}; }

}  // namespace

RawFile raw_superelement(const Superelement& s) {
  RawFile raw;
  raw.datasets = {{"/matrices/eigenvalues", s.eigenvalues},
                  {"/matrices/K_cc", s.K_cc},
                  {"/matrices/M_cc", s.M_cc},
                  {"/matrices/M_kc", s.M_kc},
                  {"/dofs/node", s.dof_node},
                  {"/dofs/component", widened(s.dof_component)},
                  {"/nodes/id", s.node_ids},
                  {"/nodes/coordinates", Matrix(s.coordinates)},
                  {"/rigid_body/mass", s.rigid_body.mass},
                  {"/rigid_body/center", Vector(s.rigid_body.center)},
                  {"/rigid_body/inertia", Matrix(s.rigid_body.inertia)}};
  raw.attributes = {{{"/", "format"}, std::string("cbr-superelement")},
                    {{"/", "format_version"}, std::string("1.0")},
                    {{"/", "generator"}, std::string("another program")},
                    {{"/", "content_hash"}, s.content_hash},
                    {{"/", "basis"}, s.basis},
                    {{"/", "n_modes"}, s.k()},
                    {{"/", "n_interface"}, s.c()}};
  for (const auto& surface : s.surfaces) {
    const std::string group = "/interface/" + surface.name;
    raw.datasets[group + "/faces"] = surface.faces;
    raw.datasets[group + "/element"] = surface.element;
    raw.datasets[group + "/side"] = widened(surface.side);
    raw.attributes[{group + "/faces", "kind"}] = std::string(surface.kind == FaceKind::tri3 ? "tri3" : "quad4");
  }
  for (const auto& [name, nodes] : s.nodesets) raw.datasets["/nodesets/" + name] = nodes;
  if (s.has_diagonal_form()) {
    raw.datasets["/diagonal/omega"] = s.omega;
    raw.datasets["/diagonal/V"] = s.V;
  }
  for (const auto& recovery : s.recovery) {
    raw.datasets["/recovery/nodes/id"] = recovery.node_ids;
    raw.datasets["/recovery/nodes/coordinates"] = Matrix(recovery.coordinates);
    raw.datasets["/recovery/Psi"] = recovery.Psi;
    raw.datasets["/recovery/Phi"] = recovery.Phi;
    const Block& block = recovery.blocks.at(0);
    const std::string group = "/recovery/blocks/000000";
    raw.datasets[group + "/connectivity"] = block.connectivity;
    raw.datasets[group + "/element_id"] = block.element_ids;
    raw.attributes[{group, "name"}] = block.name;
    raw.attributes[{group, "id"}] = block.id;
    raw.attributes[{group, "type"}] = std::string(name(block.type));
  }
  for (const auto& [key, value] : s.provenance) raw.attributes[{"/provenance", key}] = value;
  return raw;
}

void write_raw(const RawFile& raw, const std::filesystem::path& file) {
  Hdf5Writer writer(file);
  for (const auto& [name, values] : raw.datasets) {
    std::visit([&, dataset = name](const auto& array) { writer.write(dataset, array); }, values);
  }
  for (const auto& [where, value] : raw.attributes) {
    std::visit([&, object = where.first, name = where.second](const auto& single) { writer.attribute(object, name, single); },
               value);
  }
  writer.commit();
}

}  // namespace cbr::test
