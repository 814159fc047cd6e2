// SPDX-License-Identifier: GPL-3.0-or-later
// An input file of Abaqus or CalculiX as it stands: its nodes, elements, sets, surfaces, sections
// and materials. Data of a run (steps, supports, loads, output) are skipped.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
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

struct InpFile {
  FileMesh mesh;                                // FileElement::block: ELSET of *ELEMENT, or empty
  std::map<Index, std::vector<Index>> lines;    // elements of one dimension: id -> node ids
  std::map<std::string, InpSet> nsets, elsets;  // by the name in capitals
  std::vector<std::string> nset_order, elset_order;
  std::vector<InpSurface> surfaces;
  std::vector<InpSection> sections;
  // By the name in capitals. Orientations have only axes, or a problem.
  std::map<std::string, FileMaterial> materials, orientations;
  std::string dropped;  // Mesh::dropped
};

// InputError with file and line: an element type, a keyword that would change the part and is not
// supported, a malformed line.
InpFile read_inp(const std::filesystem::path& file);

}  // namespace cbr
