// SPDX-License-Identifier: GPL-3.0-or-later
// Reduced matrices from files of other codes. For the .cpp of this folder.
#pragma once

#include <filesystem>
#include <vector>

#include "reducer/exchange/reduced_matrices.hpp"

namespace cbr {

// The table of rows beside exported files, NAME.dofs.csv. Rows of modal coordinates have eigenvalue
// 0; the matrices have the true one. InputError with file and line.
std::vector<ReducedRow> read_rows(const std::filesystem::path& file);

// The matrices of --export in the order of their rows, n x n. `stem`: the files' names up to their
// suffixes. InputError with file and line: a missing or damaged file, an entry of no row or twice,
// another kind of matrix.
ReducedMatrices read_matrix_market(const std::filesystem::path& stem);
ReducedMatrices read_dmig(const std::filesystem::path& stem);
ReducedMatrices read_abaqus(const std::filesystem::path& stem);
ReducedMatrices read_calculix(const std::filesystem::path& stem);
ReducedMatrices read_op4(const std::filesystem::path& stem);  // text or binary, by its first bytes

// Matrices of other programs that name nodes without places: each row has its node and dof, and
// place_rows() does the rest. InputError as above, and: rotations.
//   read_substructure: one file of *SUBSTRUCTURE MATRIX OUTPUT (Abaqus, CalculiX): *USER ELEMENT
//   with stiffness and mass.
//   read_matrix_storage: NAME.sti, NAME.mas, NAME.dof of CalculiX's *FREQUENCY,
//   SOLVER=MATRIXSTORAGE: all dofs of a model, at most 10 000.
ReducedMatrices read_substructure(const std::filesystem::path& file);
ReducedMatrices read_matrix_storage(const std::filesystem::path& stem);

// A superelement of Sierra/SD, netCDF: modes first. InputError: those of
// read_sierra_superelement(); a rotational dof; an interface node without coordinates.
ReducedMatrices read_sierra(const std::filesystem::path& file);

}  // namespace cbr
