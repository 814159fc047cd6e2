// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of reducer/exchange/import: superelements of matrices from other codes: one file a
// format.
//
// cbr-reduce --import: a superelement file from the files of another code.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/base/types.hpp"
#include "common/mesh/mesh.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/exchange/reduced_matrices.hpp"

namespace cbr {

struct ImportOptions {
  std::string format;           // one of import_format_names()
  std::filesystem::path file;   // see import_matrices()
  std::filesystem::path faces;  // a mesh that has the interface's nodes and faces; empty: none
  std::filesystem::path target;
  // with `faces`: the diagonal form is stored for up to this many coordinates
  Index diagonal_limit = 0;
};

// Writes `target`, whole or not at all. Warns of the file's limits without `faces`. InputErrors:
// those of import_matrices(), superelement_of() and add_faces(); `target` is one of the files that
// are read, or a file of another kind. RunError: of the disk.
void import_superelement(const ImportOptions& options, Report& report);

std::vector<std::string> import_format_names();

struct ImportedMatrices {
  ReducedMatrices reduced;                   // rows in the files' order
  std::vector<std::filesystem::path> files;  // all that were read
  std::string users;                         // for messages: the codes that write them
  bool needs_mesh = false;                   // rows have no positions: see place_rows()
};

// `file`: the superelement of Sierra/SD, the file of a substructure; of other formats one of the
// files of one name, or their names' common beginning. InputError: another format; a file that is
// missing, damaged or of another kind, with its line.
ImportedMatrices import_matrices(const std::string& format, const std::filesystem::path& file);

// --- for the .cpp of this folder: a reader a format ---

// The table of rows beside exported files, NAME.dofs.csv. Rows of modal coordinates have eigenvalue
// 0; the matrices have the true one. InputError with file and line.
std::vector<ReducedRow> read_rows(const std::filesystem::path& file);

// Instead of it, of Nastran's EXTSEOUT(ASMBULK,EXTBULK): the first that there is.
inline constexpr std::array<const char*, 2> external_suffixes{".pch", ".asm"};

struct NastranRows {
  std::vector<ReducedRow> rows;
  std::map<Index, Matrix3> axes;  // of nodes whose displacements have a system of their own
  // .pch has them in EXTRN; .asm has nodes alone, whose rows here are all six
  bool knows_dofs = false;
};

// InputError with file and line: no card has the order of the rows, another reference system than
// the basic one, a node without a place.
NastranRows read_nastran_rows(const std::filesystem::path& stem);
// K := T K T^T, and M, where T has a node's axes on the diagonal. InputError: a node of axes whose
// rows are not x, y, z.
void turn_to_basic(const std::map<Index, Matrix3>& axes, const std::string& where,
                   ReducedMatrices& reduced);

// The matrices of --export in the order of their rows, n x n. `stem`: the files' names up to their
// suffixes. InputError with file and line: a missing or damaged file, an entry of no row or twice,
// another kind of matrix.
ReducedMatrices read_matrix_market(const std::filesystem::path& stem);
// Also of EXTSEOUT(EXTBULK,DMIGPCH): NAME.pch with rows, K and M.
ReducedMatrices read_dmig(const std::filesystem::path& stem);
ReducedMatrices read_abaqus(const std::filesystem::path& stem);
ReducedMatrices read_calculix(const std::filesystem::path& stem);

// Text or binary, by its first bytes; dense or sparse. Rows are those of the table, or of Nastran's
// external superelement; then KAA or KXX and MAA or MXX are read, displacements turned to basic
// axes.
ReducedMatrices read_op4(const std::filesystem::path& stem);

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

// --- from matrices to a superelement ---

// Basis craig-bampton, without sets. Nodes in the order in which rows name them first, the dofs of
// a node x, y, z; modes in the order of the rows. Mass, centre and inertia are those of the
// interface's rigid motions in M_cc, which condenses the interior's mass. InputError at `where`: K
// couples modes with the interface or with each other, M has other modal masses than 1 (1e-6 of the
// diagonals), K or M is not symmetric; a mode of eigenvalue 0 or less; an interface dof without
// stiffness or mass; rigid motions that the nodes do not determine, or that K resists. `doubts`:
// possible errors, a sentence each.
Superelement superelement_of(const ReducedMatrices& reduced, const std::string& where,
                             std::vector<std::string>& doubts);

// Gives rows their nodes' positions in the mesh. A node that the mesh does not have, and that has
// one row, is a modal coordinate. InputError: one that has several.
void place_rows(const Mesh& mesh, const std::string& mesh_file, const std::string& where,
                ReducedMatrices& reduced);

// Adds the mesh's sets whose nodes are all interface nodes. If no sideset is, each such nodeset
// becomes a surface: the outer sides of solid elements with all nodes in it. InputError naming
// `mesh_file`: an interface node that the mesh does not have, or has at another place (1e-6 of the
// mesh's size); no set and no side within the interface.
void add_faces(const Mesh& mesh, const std::string& mesh_file, const std::string& where,
               Superelement& superelement);

}  // namespace cbr
