// SPDX-License-Identifier: GPL-3.0-or-later
// An input file of Abaqus or CalculiX as it stands: its nodes, elements, sets, surfaces, sections
// and materials. Data of a run (steps, supports, loads, output) are skipped.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/mesh/io/deck_lines.hpp"
#include "common/mesh/io/file_mesh.hpp"

namespace cbr {

// Ids of nodes or elements, in the file's order.
struct InpSet {
  std::string name;  // as it was first spelled; Abaqus ignores the case of letters
  std::vector<Index> ids;
  DeckPlace place;
  bool internal = false;                 // made by a program for its own use
  std::vector<std::string> elsets = {};  // of a node set: element sets whose nodes are in it, too
};

struct InpSurface {
  struct Entry {
    std::string set;  // its name in capitals; empty: the element `id`
    Index id = 0;
    std::string label;  // "S1"; empty: the outer faces
    DeckPlace place;
  };
  std::string name;
  bool of_nodes = false;
  std::vector<Entry> entries;
};

struct InpSection {
  std::string elset, material, orientation;  // in capitals
  DeckPlace place;
};

// *COUPLING with *KINEMATIC or *DISTRIBUTING, *RIGID BODY, *DISTRIBUTING COUPLING.
struct InpConstraint {
  std::string node;  // its number or set, in capitals
  std::string set;   // a surface, or a node set, in capitals
  bool of_assembly = false, rigid = false, is_complete = false;
  std::array<bool, 6> motions{};  // all false: none given, which means all
  DeckPlace place;
};

// *MASS, *ROTARY INERTIA.
struct InpMass {
  std::string elset;
  double mass = 0;
  Matrix3 inertia;
  DeckPlace place;
};

struct InpFile {
  FileMesh mesh;                                // FileElement::block: ELSET of *ELEMENT, or empty
  std::map<Index, std::vector<Index>> lines;    // elements of one dimension: id -> node ids
  std::map<std::string, InpSet> nsets, elsets;  // by the name in capitals
  std::vector<std::string> nset_order, elset_order;
  std::vector<InpSurface> surfaces;
  std::vector<InpSection> sections;
  std::vector<InpConstraint> constraints;
  std::vector<InpMass> masses;
  // Elements MASS, ROTARYI and DCOUP3D: id -> node; below 0: of the assembly, which has nodes and
  // sets of its own
  std::map<Index, Index> point_elements;
  std::set<Index> distributing_elements;  // DCOUP3D of these
  std::map<Index, Vector3> assembly_nodes;
  std::set<Index> plane_elements;  // CPS4, CPE4, ...
  std::map<std::string, InpSet> assembly_sets;
  // By the name in capitals. Orientations have only axes, or a problem.
  std::map<std::string, FileMaterial> materials, orientations;
  std::string dropped;  // Mesh::dropped
};

// InputError with file and line: an element type, a keyword that would change the part and is not
// supported, a malformed line.
InpFile read_inp(const std::filesystem::path& file);

}  // namespace cbr
