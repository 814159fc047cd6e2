// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of reducer/exchange/export: superelements for other codes: one file a format.
//
// cbr-reduce --export: a superelement for another code.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "reducer/exchange/reduced_matrices.hpp"

namespace cbr {

std::vector<std::string> export_format_names();

// Exports the superelement `file` as FORMAT: `target` with the format's suffixes, and
// `target`.dofs.csv, the table of rows. All files are whole or none is there. `first_modal_node` as
// of reduced_matrices(). InputError: another format; a file that is no superelement, or whose basis
// or domains have no such matrices; one of the files to write is `file` itself. RunError: of the
// disk.
void export_superelement(const std::string& format, const std::filesystem::path& file,
                         const std::filesystem::path& target, Index first_modal_node,
                         Report& report);

// --- for the .cpp of this folder: the formats ---

// One file of a format: the suffix of the user's name, and its writer.
struct ExportFile {
  std::string suffix;  // ".K.mtx"
  // To `file`, which is put in place of NAME.suffix when all are whole. `name`: NAME without its
  // folder.
  std::function<void(const ReducedMatrices& reduced, const std::filesystem::path& file,
                     const std::string& name)>
      write;
  // How one that exists is recognised as ours (FileKind::start). Formats without comments have no
  // mark of their own: the table of rows must be beside them.
  std::string start;
  bool has_mark = true;
  bool is_modal = false;  // only of bases whose interface follows modes
};

struct ExportFormat {
  std::string name;
  std::string users;  // for messages: the codes that read it
  std::vector<ExportFile> files;
  bool takes_modal = false;  // has a form of u = T q
};

// Matrix Market, coordinate real symmetric, 17 digits: SciPy, MATLAB, Julia, Octave.
void write_matrix_market_K(const ReducedMatrices& reduced, std::ostream& out);
void write_matrix_market_M(const ReducedMatrices& reduced, std::ostream& out);
void write_matrix_market_T(const ReducedMatrices& reduced, std::ostream& out);

// Nastran bulk data: KAAX and MAAX in large fields (9 to 10 digits), SPOINTs for modal coordinates;
// u = T q as MPC cards of set 1. InputError: a number of more than eight digits.
void write_dmig(const ReducedMatrices& reduced, std::ostream& out);

// Abaqus *MATRIX INPUT text, "row node, dof, column node, dof, entry", 17 digits; modal coordinates
// are dof 1 of nodes of their own.
void write_abaqus_K(const ReducedMatrices& reduced, std::ostream& out);
void write_abaqus_M(const ReducedMatrices& reduced, std::ostream& out);

// CalculiX's *MATRIX ASSEMBLE, with the nodes, for files NAME.K.ccx.mtx and NAME.M.ccx.mtx of
// Abaqus's lines. CalculiX makes room for entries by the stiffness alone: it has zeros where the
// mass has entries. u = T q as *EQUATION.
inline constexpr const char *calculix_K = ".K.ccx.mtx", *calculix_M = ".M.ccx.mtx";
void write_calculix_stiffness(const ReducedMatrices& reduced, std::ostream& out);
void write_calculix_input(const ReducedMatrices& reduced, const std::string& name,
                          std::ostream& out);

// Nastran's OUTPUT4, dense, real double precision: KAAX and MAAX, and T as TCAX; text with 17
// digits, or little-endian records of Fortran.
void write_op4(const ReducedMatrices& reduced, std::ostream& out);
void write_op4_binary(const ReducedMatrices& reduced, std::ostream& out);

// A superelement of Sierra/SD, netCDF, in the newer or older layout: modes first. `where` stands
// for the file in messages.
void write_sierra(const ReducedMatrices& reduced, bool is_newer, const std::filesystem::path& file,
                  const std::string& where);

}  // namespace cbr
