// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/output/field_formats.hpp"

#include <algorithm>
#include <iomanip>
#include <limits>
#include <map>
#include <numeric>
#include <ostream>
#include <set>
#include <sstream>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/files/output_file.hpp"
#include "common/mesh/io/exodus_results.hpp"

namespace cbr {
namespace {

// Makes the ids of all lists unique and readable: adds a multiple, the list's number, of a power of
// ten above all ids. A list with repeated ids (an element with two faces) is numbered from 1. If
// ids get too large, all are numbered consecutively.
std::vector<std::vector<Index>> told_apart(std::vector<std::vector<Index>> lists) {
  Index highest = 0;
  for (auto& ids : lists) {
    if (std::set<Index>(ids.begin(), ids.end()).size() < ids.size())
      std::iota(ids.begin(), ids.end(), Index{1});
    for (const Index id : ids) highest = std::max(highest, id);
  }
  Index offset = 10;
  while (offset <= highest) offset *= 10;
  const bool fits = static_cast<Index>(lists.size()) * offset <= std::numeric_limits<int>::max();
  Index next = 1;
  for (std::size_t i = 0; i < lists.size(); ++i)
    for (Index& id : lists[i]) id = fits ? id + static_cast<Index>(i) * offset : next++;
  return lists;
}

// Grids of one mesh have the same points, which the file stores once.
class ExodusGrids {
 public:
  explicit ExodusGrids(const std::vector<FieldGrid>& grids) : grids_(grids) {
    for (std::size_t g = 0; g < grids.size(); ++g) {
      if (g == 0 || !has_points_of(grids[g], grids[g - 1])) {
        first_point_.push_back(n_points_);
        owner_.push_back(g);
        n_points_ += grids[g].points.rows();
      }
      set_of_.push_back(owner_.size() - 1);
    }
  }

  Mesh mesh() const {
    Mesh mesh;
    mesh.coordinates.resize(n_points_, 3);
    std::vector<std::vector<Index>> node_ids, element_ids;
    for (std::size_t s = 0; s < owner_.size(); ++s) {
      const FieldGrid& grid = grids_[owner_[s]];
      mesh.coordinates.middleRows(first_point_[s], grid.points.rows()) = grid.points;
      node_ids.push_back(grid.node_ids);
    }
    for (const auto& ids : told_apart(node_ids))
      mesh.node_ids.insert(mesh.node_ids.end(), ids.begin(), ids.end());
    element_ids.resize(owner_.size());
    for (std::size_t g = 0; g < grids_.size(); ++g) {
      auto& ids = element_ids[set_of_[g]];
      ids.insert(ids.end(), grids_[g].element_ids.begin(), grids_[g].element_ids.end());
    }
    element_ids = told_apart(element_ids);
    std::vector<std::size_t> used(owner_.size(), 0);
    std::set<std::string> names;
    for (std::size_t g = 0; g < grids_.size(); ++g) {
      const FieldGrid& grid = grids_[g];
      Block block;
      block.name = names.insert(grid.name).second ? grid.name : grid.name + "." + grid.topology;
      block.id = static_cast<Index>(g) + 1;
      block.type = std::find_if(xdmf_words.begin(), xdmf_words.end(), [&](const auto& entry) {
                     return entry.second == grid.topology;
                   })->first;
      block.connectivity = vtk_order(grid.cells, block.type).array() + first_point_[set_of_[g]];
      const auto first =
          element_ids[set_of_[g]].begin() + static_cast<std::ptrdiff_t>(used[set_of_[g]]);
      block.element_ids.assign(first, first + grid.cells.rows());
      used[set_of_[g]] += static_cast<std::size_t>(grid.cells.rows());
      mesh.blocks.push_back(std::move(block));
    }
    return mesh;
  }

  // Values of all points at a step, one vector per component.
  std::vector<std::vector<double>> nodal(const Hdf5Reader& heavy, std::size_t step,
                                         const std::string& field) const {
    std::vector<std::vector<double>> columns;
    for (std::size_t s = 0; s < owner_.size(); ++s) {
      const RowMatrix values =
          heavy.read_row_matrix(step_group(step) + std::to_string(owner_[s]) + "/" + field);
      columns.resize(static_cast<std::size_t>(values.cols()));
      for (Index c = 0; c < values.cols(); ++c)
        for (Index i = 0; i < values.rows(); ++i) columns[c].push_back(values(i, c));
    }
    return columns;
  }

 private:
  static bool has_points_of(const FieldGrid& a, const FieldGrid& b) {
    return a.instance == b.instance && a.part == b.part;
  }

  const std::vector<FieldGrid>& grids_;
  Index n_points_ = 0;
  std::vector<Index> first_point_;           // of each set of points
  std::vector<std::size_t> owner_, set_of_;  // first grid of each set; set of each grid
};

ExodusVariables variables_of(const std::vector<FieldGrid>& grids,
                             const std::vector<std::string>& fields) {
  ExodusVariables variables;
  const bool has_shells =
      std::any_of(grids.begin(), grids.end(), [](const FieldGrid& g) { return g.is_shell(); });
  for (const std::string& field : fields) {
    if (field == "stress") variables.element = datasets_of(field, has_shells);
    if (field.starts_with("contact_")) variables.nodal.push_back(field);
    if (field == "displacement" || field == "velocity")
      for (const char axis : {'x', 'y', 'z'}) variables.nodal.push_back(field + "_" + axis);
  }
  for (const FieldGrid& grid : grids)
    variables.of_block.push_back(variables.element.empty() || grid.block == nullptr
                                     ? 0
                                     : datasets_of("stress", grid.is_shell()).size());
  return variables;
}

void write_step(const Hdf5Reader& heavy, std::size_t step, const ExodusGrids& exodus,
                const ExodusVariables& variables, const std::vector<std::string>& fields,
                ExodusResults& out) {
  std::size_t variable = 0;
  for (const std::string& field : fields) {
    if (field == "stress") continue;
    for (const auto& column : exodus.nodal(heavy, step, field)) out.write_nodal(variable++, column);
  }
  for (std::size_t g = 0; g < variables.of_block.size(); ++g) {
    for (std::size_t v = 0; v < variables.of_block[g]; ++v) {
      const RowMatrix values =
          heavy.read_row_matrix(step_group(step) + std::to_string(g) + "/" + variables.element[v]);
      out.write_element(v, g, {values.data(), values.data() + values.size()});
    }
  }
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

std::string item(const std::filesystem::path& heavy, const std::string& dataset, Index rows,
                 Index columns, bool integer) {
  return std::string("<DataItem Format=\"HDF\" NumberType=\"") + (integer ? "Int" : "Float") +
         "\" Precision=\"8\" Dimensions=\"" + std::to_string(rows) + ' ' + std::to_string(columns) +
         "\">" + escaped(heavy.string()) + ':' + dataset + "</DataItem>";
}

}  // namespace

void write_exodus_fields(const std::filesystem::path& heavy, const std::vector<double>& times,
                         const std::vector<FieldGrid>& grids,
                         const std::vector<std::string>& fields,
                         const std::filesystem::path& target) {
  const Hdf5Reader reader(heavy);
  const ExodusGrids exodus(grids);
  const ExodusVariables variables = variables_of(grids, fields);
  TemporaryFile temporary(target);
  ExodusResults out(exodus.mesh(), variables, std::string(exodus_title) + " " + version(),
                    temporary.path(), target.string());
  for (std::size_t step = 0; step < times.size(); ++step) {
    out.begin_step(times[step]);
    write_step(reader, step, exodus, variables, fields, out);
  }
  out.close();
  temporary.commit();
}

std::string step_group(std::size_t step) { return "/steps/" + std::to_string(step) + "/"; }
std::string grid_group(std::size_t grid) { return "/grids/" + std::to_string(grid) + "/"; }

namespace {

class XdmfText {
 public:
  XdmfText(std::ostream& out, std::filesystem::path heavy, const std::vector<FieldGrid>& grids,
           const std::vector<std::string>& fields)
      : out_(out), heavy_(std::move(heavy)), grids_(grids), fields_(fields) {}

  // A single grid is not put in a collection: some readers accept series of single grids only.
  void add_step(std::size_t step, double time) {
    std::ostringstream text;
    text << std::setprecision(17) << "<Time Value=\"" << time << "\"/>\n";
    if (grids_.size() == 1) return add_grid(step, 0, text.str());
    out_ << "<Grid Name=\"scene\" GridType=\"Collection\" CollectionType=\"Spatial\">\n"
         << text.str();
    for (std::size_t g = 0; g < grids_.size(); ++g) add_grid(step, g, "");
    out_ << "</Grid>\n";
  }

 private:
  bool wanted(const std::string& field) const {
    return std::find(fields_.begin(), fields_.end(), field) != fields_.end();
  }

  void add_grid(std::size_t step, std::size_t g, const std::string& time) {
    const FieldGrid& grid = grids_[g];
    const Index n = grid.points.rows(), e = grid.cells.rows();
    out_ << "<Grid Name=\"" << escaped(grid.name) << "\" GridType=\"Uniform\">\n"
         << time << "<Topology TopologyType=\"" << grid.topology << "\" NumberOfElements=\"" << e
         << "\">" << item(heavy_, grid_group(g) + "cells", e, grid.cells.cols(), true)
         << "</Topology>\n<Geometry GeometryType=\"XYZ\">"
         << item(heavy_, grid_group(g) + "points", n, 3, false) << "</Geometry>\n";
    const std::string group = step_group(step) + std::to_string(g) + "/";
    for (const std::string field : {"displacement", "velocity", "stress", "nodal_stress",
                                    "contact_pressure", "contact_slip"}) {
      const bool of_cells = field == "stress",
                 vector = field == "displacement" || field == "velocity";
      if (!wanted(field) || (is_stress(field) && !grid.block)) continue;
      for (const std::string& dataset : datasets_of(field, grid.is_shell())) {
        out_ << "<Attribute Name=\"" << dataset << "\" AttributeType=\""
             << (vector ? "Vector" : "Scalar") << "\" Center=\"" << (of_cells ? "Cell" : "Node")
             << "\">" << item(heavy_, group + dataset, of_cells ? e : n, vector ? 3 : 1, false)
             << "</Attribute>\n";
      }
    }
    out_ << "</Grid>\n";
  }

  std::ostream& out_;
  const std::filesystem::path heavy_;
  const std::vector<FieldGrid>& grids_;
  const std::vector<std::string>& fields_;
};

}  // namespace

void write_xdmf(std::ostream& out, const std::filesystem::path& heavy,
                const std::vector<double>& times, const std::vector<FieldGrid>& grids,
                const std::vector<std::string>& fields) {
  out << "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n<Grid Name=\"time\" "
         "GridType=\"Collection\" "
         "CollectionType=\"Temporal\">\n";
  XdmfText text(out, heavy, grids, fields);
  for (std::size_t step = 0; step < times.size(); ++step) text.add_step(step, times[step]);
  out << "</Grid>\n</Domain>\n</Xdmf>\n";
}

}  // namespace cbr
