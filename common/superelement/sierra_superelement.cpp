// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/superelement/sierra_superelement.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/files/netcdf_file.hpp"

namespace cbr {
namespace {

// Additions of these files to the reader of Exodus files.
class SierraFile {
 public:
  explicit SierraFile(const std::filesystem::path& file) : reader_(file) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(reader_.where() + ": " + what);
  }
  bool has(const std::string& variable) const { return reader_.has(variable); }
  Index dimension(const std::string& name) const { return reader_.dimension(name); }
  std::vector<Index> shape(const std::string& variable) const {
    if (!has(variable)) fail("no variable '" + variable + "': not a Sierra/SD superelement");
    return reader_.shape(variable);
  }

  RowMatrix matrix(const std::string& variable) const {
    const auto lengths = shape(variable);
    if (lengths.size() != 2)
      fail("variable '" + variable + "' has " + std::to_string(lengths.size()) +
           " dimensions, not 2");
    const auto values = doubles(variable);
    return Eigen::Map<const RowMatrix>(values.data(), lengths[0], lengths[1]);
  }

  std::vector<double> doubles(const std::string& variable) const {
    shape(variable);
    auto values = reader_.reals(variable);
    for (const double value : values)
      if (!std::isfinite(value)) fail("variable '" + variable + "' has values that are not finite");
    return values;
  }

  std::vector<Index> integers(const std::string& variable) const {
    shape(variable);
    return reader_.integers(variable);
  }

 private:
  NetcdfReader reader_;
};

// Older files: one row per interface dof; newer ones: one per reduced dof, (0, 0) for modes. Told
// by the shape.
void read_dofs(const SierraFile& file, SierraSuperelement& s) {
  const auto map = file.matrix("cbmap");
  const Index n = s.Kr.rows(), n_interface = n - s.n_modes;
  if (map.cols() != 2 || (map.rows() != n && map.rows() != n_interface)) {
    file.fail("variable 'cbmap' is " + std::to_string(map.rows()) + " x " +
              std::to_string(map.cols()) + ", expected " + std::to_string(n) + " x 2 or " +
              std::to_string(n_interface) + " x 2");
  }
  for (Index i = map.rows() - n_interface; i < map.rows(); ++i) {
    if (!(map(i, 1) >= 1 && map(i, 1) <= 6))
      file.fail("cbmap: dof " + number_text(map(i, 1)) + " is none of 1 to 6");
    if (!(std::abs(map(i, 0)) < 1e15))
      file.fail("cbmap: node " + number_text(map(i, 0)) + " is no node's number");
    s.dof_node.push_back(static_cast<Index>(map(i, 0)));
    s.dof_component.push_back(static_cast<int>(map(i, 1)) - 1);
  }
}

void read_nodes(const SierraFile& file, SierraSuperelement& s) {
  s.node_ids = file.integers("node_num_map");
  const auto n = static_cast<Index>(s.node_ids.size());
  if (file.has("coord")) {
    const auto x = file.matrix("coord");
    if (x.rows() != 3 || x.cols() != n) file.fail("variable 'coord' does not fit node_num_map");
    s.coordinates = x.transpose();
    return;
  }
  s.coordinates.resize(n, 3);
  const char* names[] = {"coordx", "coordy", "coordz"};
  for (Index d = 0; d < 3; ++d) {
    const auto x = file.doubles(names[d]);
    if (static_cast<Index>(x.size()) != n)
      file.fail(std::string("variable '") + names[d] + "' does not fit node_num_map");
    s.coordinates.col(d) = Eigen::Map<const Vector>(x.data(), n);
  }
}

}  // namespace

SierraSuperelement read_sierra_superelement(const std::filesystem::path& path) {
  const SierraFile file(path);
  SierraSuperelement s;
  s.Kr = file.matrix("Kr");
  s.Mr = file.matrix("Mr");
  const Index n = s.Kr.rows();
  if (s.Kr.cols() != n || s.Mr.rows() != n || s.Mr.cols() != n)
    file.fail("Kr and Mr are not square matrices of one size");
  s.n_modes = std::max<Index>(0, file.dimension("NumEig"));
  if (s.n_modes > n) file.fail("NumEig is larger than Kr");
  read_dofs(file, s);
  read_nodes(file, s);
  if (file.has("Cr")) {
    const auto damping = file.doubles("Cr");
    s.has_damping =
        std::any_of(damping.begin(), damping.end(), [](double value) { return value != 0; });
  }
  if (file.has("OTM")) {
    s.output_map = file.matrix("OTM");
    s.output_nodes = file.integers("OutMap");
  }
  return s;
}

namespace {

constexpr Index name_length = 256, string_length = 33;

// Common to both layouts.
void define_sizes(NetcdfWriter& out, Index n, Index n_modes, Index n_nodes) {
  out.attribute("floating_point_word_size", 8);
  out.attribute("file_size", 1);
  out.attribute("", "title", "cbr model");
  const std::pair<const char*, Index> sizes[] = {{"time_step", 0},
                                                 {"num_dim", 3},
                                                 {"num_nodes", n_nodes},
                                                 {"num_elem", 1},
                                                 {"num_el_blk", 1},
                                                 {"num_node_sets", 1},
                                                 {"num_el_in_blk1", 1},
                                                 {"num_nod_per_el1", n_nodes},
                                                 {"NumDof", n},
                                                 {"two", 2},
                                                 {"NumConstraints", n - n_modes},
                                                 {"NumInterfaceNodes", n_nodes},
                                                 {"NumEig", n_modes},
                                                 {"four", 4},
                                                 {"len_string", string_length},
                                                 {"num_nod_ns1", n_nodes}};
  for (const auto& [name, size] : sizes)
    if (size > 0 || std::string(name) == "time_step") out.dimension(name, size);
  out.define_reals("time_whole", {"time_step"});
  for (const std::string prefix : {"eb", "ns"}) {
    const std::string count = prefix == "eb" ? "num_el_blk" : "num_node_sets";
    out.define_integers(prefix + "_status", {count});
    out.define_integers(prefix + "_prop1", {count});
    out.attribute(prefix + "_prop1", "name", "ID");
  }
  out.define_integers("connect1", {"num_el_in_blk1", "num_nod_per_el1"});
  out.attribute("connect1", "elem_type", "SUPER");
  out.define_integers("node_num_map", {"num_nodes"});
  out.define_integers("node_ns1", {"num_nod_ns1"});
  out.define_reals("dist_fact_ns1", {"num_nod_ns1"});
}

void define_newer(NetcdfWriter& out) {
  out.attribute("api_version", 8.17F);
  out.attribute("version", 8.17F);
  out.attribute("maximum_name_length", 32);
  out.attribute("int64_status", 0);
  out.dimension("len_name", name_length);
  out.dimension("num_qa_rec", 1);
  out.define_text("eb_names", {"num_el_blk", "len_name"});
  out.define_text("ns_names", {"num_node_sets", "len_name"});
  for (const char* name : {"coordx", "coordy", "coordz"}) out.define_reals(name, {"num_nodes"});
  out.define_text("coor_names", {"num_dim", "len_name"});
  for (const char* name : {"Kr", "Mr", "Cr"}) out.define_reals(name, {"NumDof", "NumDof"});
  out.define_integers("cbmap", {"NumDof", "two"});
  out.define_text("qa_records", {"num_qa_rec", "four", "len_string"});
}

void define_older(NetcdfWriter& out, Index n) {
  out.attribute("api_version", 4.21F);
  out.attribute("version", 3.01F);
  out.dimension("NumCols", n);
  out.define_reals("coord", {"num_dim", "num_nodes"});
  out.define_text("coor_names", {"num_dim", "len_string"});
  for (const char* name : {"Kr", "Mr"}) out.define_reals(name, {"NumCols", "NumCols"});
  out.define_integers("cbmap", {"NumConstraints", "two"});
}

void write_matrix(NetcdfWriter& out, const std::string& name, const RowMatrix& A) {
  out.write(name, std::vector<double>(A.data(), A.data() + A.size()));
}

// Only in the newer layout, but for cbmap.
void write_newer(NetcdfWriter& out, const SierraSuperelement& s) {
  for (const char* name : {"eb_names", "ns_names"})
    out.write(name, std::vector<std::string>{""}, name_length);
  for (Index d = 0; d < 3; ++d) {
    const Vector x = s.coordinates.col(d);
    out.write(std::string("coord") + "xyz"[d], std::vector<double>(x.begin(), x.end()));
  }
  out.write("coor_names", {"coordx", "coordy", "coordz"}, name_length);
  write_matrix(out, "Cr", Matrix::Zero(s.Kr.rows(), s.Kr.rows()));
  // no date: the same superelement, the same bytes
  out.write("qa_records", {"cbr-reduce", "", "", ""}, string_length);
}

void write_older(NetcdfWriter& out, const SierraSuperelement& s) {
  write_matrix(out, "coord", s.coordinates.transpose());
  out.write("coor_names", {"x", "y", "z"}, string_length);
}

}  // namespace

void write_sierra_superelement(const SierraSuperelement& s, SierraLayout layout,
                               const std::filesystem::path& file, const std::string& where) {
  const bool is_newer = layout == SierraLayout::newer;
  const Index n = s.Kr.rows(), n_nodes = static_cast<Index>(s.node_ids.size());
  NetcdfWriter out(file, where);
  define_sizes(out, n, s.n_modes, n_nodes);
  is_newer ? define_newer(out) : define_older(out, n);
  out.end_definitions();
  for (const char* name : {"eb_status", "eb_prop1", "ns_status", "ns_prop1"})
    out.write(name, std::vector<Index>{1});
  is_newer ? write_newer(out, s) : write_older(out, s);
  std::vector<Index> nodes(n_nodes), map(is_newer ? 2 * static_cast<std::size_t>(s.n_modes) : 0, 0);
  std::iota(nodes.begin(), nodes.end(), Index{1});
  for (const char* name : {"connect1", "node_ns1"}) out.write(name, nodes);
  write_matrix(out, "Kr", s.Kr);
  write_matrix(out, "Mr", s.Mr);
  for (std::size_t i = 0; i < s.dof_node.size(); ++i)
    map.insert(map.end(), {s.dof_node[i], Index{s.dof_component[i]} + 1});
  out.write("cbmap", map);
  out.write("node_num_map", s.node_ids);
  out.write("dist_fact_ns1", std::vector<double>(n_nodes, 1.0));
  out.close();
}

}  // namespace cbr
