// SPDX-License-Identifier: GPL-3.0-or-later
// CalculiX takes a superelement with *MATRIX ASSEMBLE (from 2.21 on): Dhondt, CalculiX CrunchiX
// User's Manual. Its matrices have the lines of Abaqus's *MATRIX INPUT.
#include <ostream>

#include "common/base/format_text.hpp"
#include "reducer/exchange/export/export_formats.hpp"

namespace cbr {

void write_calculix_input(const ReducedMatrices& reduced, const std::string& name,
                          std::ostream& out) {
  out << "** A Craig-Bampton superelement: *INCLUDE this file in the model. Nodes without a place "
         "of their own are modal\n"
      << "** coordinates; their dof is 1. A *FREQUENCY or *DYNAMIC step needs a material with a "
         "*DENSITY in the model.\n*NODE, NSET=CBR\n";
  Index last = -1;
  for (const ReducedRow& row : reduced.rows) {
    if (row.node == last) continue;
    last = row.node;
    out << row.node
        << format_text(", %.17g, %.17g, %.17g\n", row.position(0), row.position(1),
                       row.position(2));
  }
  out << "*MATRIX ASSEMBLE, NAME=CBR, STIFFNESS FILE=" << name << calculix_K
      << ", MASS FILE=" << name << calculix_M << '\n';
}

}  // namespace cbr
