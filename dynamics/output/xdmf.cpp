// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/output/xdmf.hpp"

#include <algorithm>
#include <iomanip>
#include <ostream>
#include <sstream>
#include <utility>

namespace cbr {
namespace {

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
