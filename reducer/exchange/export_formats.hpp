// SPDX-License-Identifier: GPL-3.0-or-later
// Text formats of other codes for reduced matrices. For the .cpp of this folder.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "reducer/exchange/reduced_matrices.hpp"

namespace cbr {

// One file of a format: what follows the name that the user gave, and what writes it.
struct ExportFile {
  std::string suffix;  // ".K.mtx"
  void (*write)(const ReducedMatrices& reduced, std::ostream& out);
};

struct ExportFormat {
  std::string name;
  std::string users;  // for messages: the codes that read it
  std::vector<ExportFile> files;
};

// Matrix Market, coordinate real symmetric, 17 digits: SciPy, MATLAB, Julia, Octave.
void write_matrix_market_K(const ReducedMatrices& reduced, std::ostream& out);
void write_matrix_market_M(const ReducedMatrices& reduced, std::ostream& out);

// Nastran bulk data: KAAX and MAAX in large fields (9 to 10 digits), SPOINTs for modal coordinates.
void write_dmig(const ReducedMatrices& reduced, std::ostream& out);

// Abaqus *MATRIX INPUT text, "row node, dof, column node, dof, entry", 17 digits; modal coordinates are dof 1 of nodes of their
// own.
void write_abaqus_K(const ReducedMatrices& reduced, std::ostream& out);
void write_abaqus_M(const ReducedMatrices& reduced, std::ostream& out);

}  // namespace cbr
