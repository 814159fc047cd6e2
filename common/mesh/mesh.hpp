// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/mesh: the mesh and its surfaces.
//
// A finite element mesh: nodes, element blocks, sidesets, nodesets. Node order inside an element
// and side numbers are those of Exodus II, whatever file the mesh came from.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "common/mesh/element_type.hpp"

namespace cbr {

// A block's material in a file (.inp, .bdf), in the file's units.
struct FileMaterial {
  std::string name;
  double youngs_modulus = 0, poissons_ratio = 0, density = 0;
  std::string problem = {};  // why it is of no use: "has no *DENSITY"; empty: it is
  double alpha = 0, beta = 0, loss_factor = 0;  // *DAMPING: 1/s, s, K (1 + i loss_factor)
  // Orthotropic: E_1 E_2 E_3 nu_12 nu_13 nu_23 G_12 G_13 G_23. Empty: isotropic.
  std::vector<double> engineering_constants = {};
  Vector3 axis = Vector3::UnitX(), in_plane = Vector3::UnitY();  // its axis 1; of the plane 1-2
  // Given: axes are radial, tangential and axial, about the line through it along `axis`.
  std::optional<Vector3> center = {};
};

struct Block {
  std::string name;
  Index id = 0;
  ElementType type = ElementType::hex8;
  IndexTable connectivity;         // n_e x nodes per element, indices into Mesh::coordinates
  std::vector<Index> element_ids;  // n_e, unique in the mesh
  std::optional<FileMaterial> material = {};
  // Whether the file asks for reduced integration (C3D8R, C3D15, C3D20R of .inp).
  bool reduced = false;
  // Above 0: shells (tri3, quad4) that are structure, as the scene says; files do not have it.
  double thickness = 0;
};

// Whether programs compute with the block: solids, and shells with a thickness.
bool is_structure(const Block& block);

struct Side {
  Index block = 0;    // index into Mesh::blocks
  Index element = 0;  // row of the block's connectivity
  int side = 1;       // from 1, as Exodus II numbers the sides of the block's element type
  friend bool operator==(const Side&, const Side&) = default;
};

struct Sideset {
  std::string name;
  Index id = 0;
  std::vector<Side> sides;
};

struct Nodeset {
  std::string name;
  Index id = 0;
  std::vector<Index> nodes;  // ascending, unique
};

// A reference point that moves as the nodes of a set do in the mean; `rigid`: and makes them move
// as a rigid body.
struct MeshPoint {
  std::string nodes;          // the set
  std::optional<Vector3> at;  // not given: the set's centre
  bool rigid = false;
  double mass = 0;
  Matrix3 inertia = Matrix3::Zero();  // about the point
  std::string file = {};              // that has it, and the line; empty: the scene has it
  Index line = 0;
};

struct Mesh {
  Points coordinates;             // n x 3, the user's unit of length
  std::vector<Index> node_ids;    // n, unique
  std::vector<Block> blocks;      // volume blocks first or not: ask the type's dimension
  std::vector<Sideset> sidesets;  // a face may be in several
  std::vector<Nodeset> nodesets;
  std::map<std::string, MeshPoint> points = {};  // of a deck: RBE2, *COUPLING, ...
  // Keywords of the file that are not read: "*BOUNDARY (line 27), *PLASTIC (line 18)"; empty:
  // nothing.
  std::string dropped = {};
};

// Reads, as docs/meshes.md says, .msh (gmsh 2.2, 4.1, or Abaqus), .exo .e .g .ncf .nc4 (Exodus II),
// .inp (Abaqus, CalculiX), .bdf .nas (Nastran), .med (Salome), and through the program gmsh .unv
// and .vtk. InputError names the file and its fault: missing, truncated, an element type
// that is not supported, a side of no element, a repeated id.
Mesh read_mesh(const std::filesystem::path& file);

// The file, and those that it includes (*INCLUDE of .inp, INCLUDE of .bdf), as read_mesh reads
// them. InputError: an include that cannot be read. One that is no mesh, or not there, is given
// back.
std::vector<std::filesystem::path> mesh_files(const std::filesystem::path& file);

// Whether a line of the deck, or of one that it includes, begins with one of these words, in
// capitals without blanks.
bool deck_holds(const std::filesystem::path& deck, const std::vector<std::string>& words);

// Whether the suffix is one that read_mesh knows; one that write_mesh knows; whether the file is of
// a format that has materials.
bool is_mesh_name(const std::filesystem::path& file);
bool is_written_mesh_name(const std::filesystem::path& file);
bool may_hold_materials(const std::filesystem::path& file);

// InputError when `file` exists and write_mesh did not write it: "FILE: exists and ...; WHAT would
// overwrite it: CURE".
void refuse_other_mesh(const std::filesystem::path& file, const std::string& what,
                       const std::string& cure);

// Writes by suffix: .msh (4.1, text) or .exo .e .g (Exodus II, netCDF 64-bit offset). The same mesh
// gives the same bytes. To a temporary name, renamed when whole. A .msh file cannot hold sides of
// shells, and gives a block of shells that lies on solids back as a sideset unless its name begins
// with "skin.".
void write_mesh(const Mesh& mesh, const std::filesystem::path& file);

// Index of the named block, or -1.
Index find_block(const Mesh& mesh, const std::string& name);

// Index of the named set or -1. An unnamed Exodus set is called surface_ID / nodelist_ID (as SEACAS
// does); its bare number is accepted for it too.
Index find_sideset(const Mesh& mesh, const std::string& name);
Index find_nodeset(const Mesh& mesh, const std::string& name);

// Nodes of one side of an element, as mesh node indices, in the order of side_nodes(). Sides of
// shells as in Exodus II: 1 and 2 are the two faces (the second one turned over), 3 and up the
// edges. InputError for a side that the element does not have.
std::vector<Index> nodes_of_side(const Mesh& mesh, const Side& side);

// Names of the sidesets and nodesets that there are, for messages: "contact, tip (sidesets); clamp
// (nodesets)".
std::string set_names(const Mesh& mesh);

// InputError, the same for all readers: node indices out of range, a repeated node or
// element id, a non-finite coordinate, a side of no element, two blocks or two sidesets of one
// name. `where` starts the message: the file.
void check_mesh(const Mesh& mesh, const std::string& where);

// Node indices of a set, ascending and unique; the name may be a sideset's or a nodeset's.
// InputError lists the names there are.
std::vector<Index> set_nodes(const Mesh& mesh, const std::string& name);

}  // namespace cbr
