// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/output/xdmf.hpp"

#include <algorithm>
#include <iomanip>
#include <ostream>

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

std::string item(const std::filesystem::path& heavy, const std::string& dataset, Index rows, Index columns, bool integer) {
  return std::string("<DataItem Format=\"HDF\" NumberType=\"") + (integer ? "Int" : "Float") + "\" Precision=\"8\" Dimensions=\"" +
         std::to_string(rows) + ' ' + std::to_string(columns) + "\">" + escaped(heavy.string()) + ':' + dataset + "</DataItem>";
}

}  // namespace

std::string step_group(std::size_t step) { return "/steps/" + std::to_string(step) + "/"; }
std::string grid_group(std::size_t grid) { return "/grids/" + std::to_string(grid) + "/"; }

void write_xdmf(std::ostream& out, const std::filesystem::path& heavy, const std::vector<double>& times,
                const std::vector<FieldGrid>& grids, const std::vector<std::string>& fields) {
  const auto wanted = [&](const std::string& field) { return std::find(fields.begin(), fields.end(), field) != fields.end(); };
  out << std::setprecision(17)
      << "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n<Grid Name=\"time\" GridType=\"Collection\" "
         "CollectionType=\"Temporal\">\n";
  for (std::size_t step = 0; step < times.size(); ++step) {
    out << "<Grid Name=\"scene\" GridType=\"Collection\" CollectionType=\"Spatial\">\n<Time Value=\"" << times[step] << "\"/>\n";
    for (std::size_t g = 0; g < grids.size(); ++g) {
      const FieldGrid& grid = grids[g];
      const Index n = grid.points.rows(), e = grid.cells.rows();
      out << "<Grid Name=\"" << escaped(grid.name) << "\" GridType=\"Uniform\">\n<Topology TopologyType=\"" << grid.topology
          << "\" NumberOfElements=\"" << e << "\">" << item(heavy, grid_group(g) + "cells", e, grid.cells.cols(), true)
          << "</Topology>\n<Geometry GeometryType=\"XYZ\">" << item(heavy, grid_group(g) + "points", n, 3, false)
          << "</Geometry>\n";
      for (const std::string field : {"displacement", "velocity", "stress", "contact_pressure"}) {
        const bool stress = field == "stress", scalar = field == "contact_pressure";
        if (!wanted(field) || (stress && !grid.block)) continue;
        out << "<Attribute Name=\"" << field << "\" AttributeType=\""
            << (stress   ? "Tensor6"
                : scalar ? "Scalar"
                         : "Vector")
            << "\" Center=\"" << (stress ? "Cell" : "Node") << "\">"
            << item(heavy, step_group(step) + std::to_string(g) + "/" + field, stress ? e : n,
                    stress   ? 6
                    : scalar ? 1
                             : 3,
                    false)
            << "</Attribute>\n";
      }
      out << "</Grid>\n";
    }
    out << "</Grid>\n";
  }
  out << "</Grid>\n</Domain>\n</Xdmf>\n";
}

}  // namespace cbr
