// SPDX-License-Identifier: GPL-3.0-or-later
// Writes Exodus II in the 64-bit offset format of netCDF, which every reader of Exodus supports.
#include <algorithm>
#include <set>

#include "common/base/error.hpp"
#include "common/files/netcdf_file.hpp"
#include "common/mesh/io/deck_lines.hpp"
#include "common/mesh/io/exodus_results.hpp"
#include "common/mesh/io/mesh_formats.hpp"

namespace cbr {
namespace {

// "HEX8", of quad4 "SHELL4", of tet4 "TETRA4".
std::string element_word(ElementType type) {
  std::string word = in_capitals(name(type));
  if (word.starts_with("QUAD")) word.replace(0, 4, "SHELL");
  if (word.starts_with("TET")) word.replace(0, 3, "TETRA");
  return word;
}

// Ids in Exodus are positive and unique among blocks, among sidesets, among nodesets: the own one
// where it is free.
template <class Sets>
std::vector<Index> free_ids(const Sets& sets) {
  Index highest = 0;
  for (const auto& set : sets) highest = std::max(highest, set.id);
  std::set<Index> used;
  std::vector<Index> ids;
  for (const auto& set : sets) {
    ids.push_back(set.id >= 1 && !used.count(set.id) ? set.id : ++highest);
    used.insert(ids.back());
  }
  return ids;
}

Index size_of(const Block& block) { return block.connectivity.rows(); }
Index size_of(const Sideset& set) { return static_cast<Index>(set.sides.size()); }
Index size_of(const Nodeset& set) { return static_cast<Index>(set.nodes.size()); }

template <class Sets>
void define_headers(NetcdfWriter& file, const Sets& sets, const std::string& dimension,
                    const std::string& prefix) {
  if (sets.empty()) return;
  file.dimension(dimension, static_cast<Index>(sets.size()));
  file.define_integers(prefix + "_status", {dimension});
  file.define_integers(prefix + "_prop1", {dimension});
  file.attribute(prefix + "_prop1", "name", "ID");
  file.define_text(prefix + "_names", {dimension, "len_name"});
}

template <class Sets>
void write_headers(NetcdfWriter& file, const Sets& sets, const std::string& prefix, Index width) {
  if (sets.empty()) return;
  std::vector<Index> status;
  std::vector<std::string> names;
  for (const auto& set : sets) {
    status.push_back(size_of(set) > 0 ? 1 : 0);
    names.push_back(set.name);
  }
  file.write(prefix + "_status", status);
  file.write(prefix + "_prop1", free_ids(sets));
  file.write(prefix + "_names", names, width);
}

Index name_width(const Mesh& mesh, const ExodusVariables& variables = {}) {
  std::size_t longest = 32;
  for (const auto* names : {&variables.nodal, &variables.element})
    for (const std::string& name : *names) longest = std::max(longest, name.size());
  const auto see = [&](const auto& sets) {
    for (const auto& set : sets) {
      if (set.name.find('\0') != std::string::npos)
        throw InputError("'" + std::string(set.name.c_str()) +
                         "...': Exodus ends a name at its first character of value 0: rename it, "
                         "or write a .msh");
      longest = std::max(longest, set.name.size());
    }
  };
  see(mesh.blocks);
  see(mesh.sidesets);
  see(mesh.nodesets);
  return static_cast<Index>(longest) + 1;
}

std::string nodal_variable(std::size_t v) { return "vals_nod_var" + std::to_string(v + 1); }
std::string element_variable(std::size_t v, std::size_t block) {
  return "vals_elem_var" + std::to_string(v + 1) + "eb" + std::to_string(block + 1);
}

void define(NetcdfWriter& file, const ExodusVariables& variables) {
  if (!variables.nodal.empty()) {
    file.dimension("num_nod_var", static_cast<Index>(variables.nodal.size()));
    file.define_text("name_nod_var", {"num_nod_var", "len_name"});
  }
  for (std::size_t v = 0; v < variables.nodal.size(); ++v)
    file.define_reals(nodal_variable(v), {"time_step", "num_nodes"});
  if (variables.element.empty()) return;
  file.dimension("num_elem_var", static_cast<Index>(variables.element.size()));
  file.define_text("name_elem_var", {"num_elem_var", "len_name"});
  file.define_integers("elem_var_tab", {"num_el_blk", "num_elem_var"});
  for (std::size_t v = 0; v < variables.element.size(); ++v)
    for (std::size_t b = 0; b < variables.of_block.size(); ++b)
      if (v < variables.of_block[b])
        file.define_reals(element_variable(v, b),
                          {"time_step", "num_el_in_blk" + std::to_string(b + 1)});
}

void write_values(NetcdfWriter& file, const ExodusVariables& variables, Index width) {
  if (!variables.nodal.empty()) file.write("name_nod_var", variables.nodal, width);
  if (variables.element.empty()) return;
  file.write("name_elem_var", variables.element, width);
  std::vector<Index> table;
  for (const std::size_t n : variables.of_block)
    for (std::size_t v = 0; v < variables.element.size(); ++v) table.push_back(v < n ? 1 : 0);
  file.write("elem_var_tab", table);
}

struct Head {
  std::string title = exodus_mesh_title;
  Index n_elements = 0, width = 0;
  const ExodusVariables& variables;
};

void define(NetcdfWriter& file, const Mesh& mesh, const Head& head) {
  const Index width = head.width;
  file.attribute("api_version", 5.14F);
  file.attribute("version", 5.14F);
  file.attribute("floating_point_word_size", 8);
  file.attribute("file_size", 1);
  file.attribute("maximum_name_length", static_cast<int>(width - 1));
  file.attribute("int64_status", 0);
  file.attribute("", "title", head.title);
  file.dimension("len_string", 33);
  file.dimension("len_line", 81);
  file.dimension("four", 4);
  file.dimension("len_name", width);
  file.dimension("time_step", 0);
  file.dimension("num_dim", 3);
  file.dimension("num_nodes", mesh.coordinates.rows());
  file.dimension("num_elem", head.n_elements);
  file.define_reals("time_whole", {"time_step"});
  define_headers(file, mesh.blocks, "num_el_blk", "eb");
  define_headers(file, mesh.sidesets, "num_side_sets", "ss");
  define_headers(file, mesh.nodesets, "num_node_sets", "ns");
  for (const char* name : {"coordx", "coordy", "coordz"}) file.define_reals(name, {"num_nodes"});
  file.define_text("coor_names", {"num_dim", "len_name"});
  file.define_integers("node_num_map", {"num_nodes"});
  file.define_integers("elem_num_map", {"num_elem"});
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    const std::string number = std::to_string(b + 1), rows = "num_el_in_blk" + number,
                      columns = "num_nod_per_el" + number;
    if (size_of(mesh.blocks[b]) == 0) continue;
    file.dimension(rows, size_of(mesh.blocks[b]));
    file.dimension(columns, mesh.blocks[b].connectivity.cols());
    file.define_integers("connect" + number, {rows, columns});
    file.attribute("connect" + number, "elem_type", element_word(mesh.blocks[b].type));
  }
  for (std::size_t s = 0; s < mesh.sidesets.size(); ++s) {
    const std::string number = std::to_string(s + 1), n = "num_side_ss" + number;
    if (size_of(mesh.sidesets[s]) == 0) continue;
    file.dimension(n, size_of(mesh.sidesets[s]));
    file.define_integers("elem_ss" + number, {n});
    file.define_integers("side_ss" + number, {n});
  }
  for (std::size_t s = 0; s < mesh.nodesets.size(); ++s) {
    const std::string number = std::to_string(s + 1), n = "num_nod_ns" + number;
    if (size_of(mesh.nodesets[s]) == 0) continue;
    file.dimension(n, size_of(mesh.nodesets[s]));
    file.define_integers("node_ns" + number, {n});
  }
  define(file, head.variables);
  file.end_definitions();
}

void write_values(NetcdfWriter& file, const Mesh& mesh, Index width) {
  write_headers(file, mesh.blocks, "eb", width);
  write_headers(file, mesh.sidesets, "ss", width);
  write_headers(file, mesh.nodesets, "ns", width);
  for (Index c = 0; c < 3; ++c) {
    const Vector column = mesh.coordinates.col(c);
    file.write(std::string("coord") + "xyz"[c], std::vector<double>(column.begin(), column.end()));
  }
  file.write("coor_names", {"x", "y", "z"}, width);
  file.write("node_num_map", mesh.node_ids);
  std::vector<Index> elements, first_of_block;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    const Block& block = mesh.blocks[b];
    first_of_block.push_back(static_cast<Index>(elements.size()) + 1);
    elements.insert(elements.end(), block.element_ids.begin(), block.element_ids.end());
    std::vector<Index> nodes(block.connectivity.data(),
                             block.connectivity.data() + block.connectivity.size());
    for (auto& node : nodes) ++node;
    if (!nodes.empty()) file.write("connect" + std::to_string(b + 1), nodes);
  }
  file.write("elem_num_map", elements);
  for (std::size_t s = 0; s < mesh.sidesets.size(); ++s) {
    std::vector<Index> element, side;
    for (const Side& one : mesh.sidesets[s].sides) {
      element.push_back(first_of_block[one.block] + one.element);
      side.push_back(one.side);
    }
    if (element.empty()) continue;
    file.write("elem_ss" + std::to_string(s + 1), element);
    file.write("side_ss" + std::to_string(s + 1), side);
  }
  for (std::size_t s = 0; s < mesh.nodesets.size(); ++s) {
    auto nodes = mesh.nodesets[s].nodes;
    for (auto& node : nodes) ++node;
    if (!nodes.empty()) file.write("node_ns" + std::to_string(s + 1), nodes);
  }
}

Index count_elements(const Mesh& mesh, const std::string& where) {
  Index n = 0;
  for (const auto& block : mesh.blocks) n += size_of(block);
  if (n == 0 || mesh.coordinates.rows() == 0)
    throw InputError(where + ": a mesh without elements cannot be written");
  return n;
}

}  // namespace

void write_exodus(const Mesh& mesh, const std::filesystem::path& file, const std::string& where) {
  const ExodusVariables none;
  const Head head{
      .n_elements = count_elements(mesh, where), .width = name_width(mesh), .variables = none};
  NetcdfWriter writer(file, where);
  define(writer, mesh, head);
  write_values(writer, mesh, head.width);
  writer.close();
}

struct ExodusResults::State {
  NetcdfWriter file;
  Index n_steps = 0;
};

ExodusResults::ExodusResults(const Mesh& mesh, const ExodusVariables& variables,
                             const std::string& title, const std::filesystem::path& file,
                             const std::string& where)
    : state_(new State{{file, where}}) {
  const Head head{title, count_elements(mesh, where), name_width(mesh, variables), variables};
  define(state_->file, mesh, head);
  write_values(state_->file, mesh, head.width);
  write_values(state_->file, variables, head.width);
}

ExodusResults::~ExodusResults() = default;

void ExodusResults::begin_step(double t) {
  state_->file.write_record("time_whole", state_->n_steps++, {t});
}

void ExodusResults::write_nodal(std::size_t variable, const std::vector<double>& values) {
  state_->file.write_record(nodal_variable(variable), state_->n_steps - 1, values);
}

void ExodusResults::write_element(std::size_t variable, std::size_t block,
                                  const std::vector<double>& values) {
  state_->file.write_record(element_variable(variable, block), state_->n_steps - 1, values);
}

void ExodusResults::close() { state_->file.close(); }

}  // namespace cbr
