// SPDX-License-Identifier: GPL-3.0-or-later
// Nodes and elements that readers of text files collect one by one, and the mesh that it
// makes. For the .cpp of this folder.
#pragma once

#include <map>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "common/mesh/io/deck_lines.hpp"
#include "common/mesh/mesh.hpp"

namespace cbr {

struct FileElement {
  Index id = 0;
  ElementType type = ElementType::hex8;
  std::size_t first = 0;  // of its nodes in FileMesh::element_nodes
  std::string block;      // a section's set, a property
  bool reduced = false;   // Block::reduced
};

struct FileMesh {
  std::string where;  // the file
  std::vector<Index> node_ids;
  std::vector<double> coordinates;  // 3 a node
  std::vector<FileElement> elements;
  std::vector<Index> element_nodes;               // ids, the order of Exodus II
  std::map<std::string, FileMaterial> materials;  // by the block's name
};

// Faces that a file has as elements of their own, by their places in FileMesh::elements.
struct FaceSet {
  std::string name;
  std::vector<std::size_t> elements;
};

// Blocks by FileElement::block, one for each type (NAME_hex8, NAME_wedge6 where there are several;
// NAME_hex8_reduced and NAME_hex8 where both are of one type).
// A set of faces is a sideset if all of them are sides of solids; faces of no sideset are blocks of
// shells. InputError: an element of a node that is not there.
Mesh mesh_of(const FileMesh& file, const std::vector<FaceSet>& faces);

// Nodes and elements of a mesh by their ids.
class MeshIds {
 public:
  explicit MeshIds(const Mesh& mesh);
  Index node(Index id) const;    // -1: there is none
  Side element(Index id) const;  // element -1: there is none

 private:
  std::unordered_map<Index, Index> nodes_;
  std::unordered_map<Index, Side> elements_;
};

// Reference points of a deck by the ids of their nodes, and masses on these. Nodes of an assembly,
// which has ids of its own, have negative ones.
struct FilePoints {
  struct Point {
    std::string nodes;  // its set
    Vector3 at;
    bool rigid = false;
    DeckPlace place;
  };
  struct Mass {
    std::string name;  // of its point where it is beside that of its node: "mass_7"
    Index node = 0;
    double mass = 0;
    Matrix3 inertia;  // about its centre
    Vector3 offset;   // of its centre from the node
    DeckPlace place;
  };
  std::map<Index, Point> points;
  std::vector<Mass> masses;

  // InputError: another constraint has this node.
  void add(Index node, Point point);
};
// Fills Mesh::points: node_ID with the masses at it, and mass_ID with one beside it. InputError: a
// mass on another node, or below 0.
void add_points(const FilePoints& all, Mesh& mesh);

// Ids of the nodes of elements.
std::unordered_set<Index> used_nodes(const FileMesh& file);

// Adds a nodeset, or nodes to the one of this name. `nodes` are indices. Without id it is counted.
void add_nodeset(Mesh& mesh, const std::string& name, std::vector<Index> nodes, Index id = 0);

}  // namespace cbr
