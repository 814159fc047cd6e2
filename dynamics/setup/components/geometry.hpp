// SPDX-License-Identifier: GPL-3.0-or-later
// Nodes, surfaces and node sets of a component by name, for all kinds of instances; and functions
// of the faces.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/fem/assembly.hpp"
#include "common/mesh/face_weights.hpp"
#include "common/mesh/surface.hpp"
#include "common/scene/scene.hpp"
#include "common/scene/scene_uses.hpp"
#include "common/superelement/superelement.hpp"

namespace cbr {

// Component axes. Faces and sets index the rows of `coordinates`, the body's nodes.
struct Geometry {
  std::vector<Index> node_ids;  // of the mesh
  Points coordinates;
  std::map<std::string, Surface> surfaces;
  std::map<std::string, std::vector<Index>> nodesets;
  // For points of a superelement's interface, and nodes of shells: from the node of x, y, z to its
  // rotation node, which follows all others. A nodeset with a point's name has the first.
  std::map<Index, Index> rotations;
  // Axes along which nodes do not move (reduction.fixed): dofs that a superelement does not have.
  std::set<std::pair<Index, int>> fixed;
  // sets in a superelement's recovery data, including interior ones
  std::set<std::string> recovered;
  bool reduced = false;  // a superelement: only retained sets exist
  bool has_mesh = true;  // false: a superelement file alone, which cannot be reduced again
};

Geometry geometry_of(const Superelement& superelement);
Geometry geometry_of(const Mesh& mesh, const FiniteElementModel& model);

// The node of x, y, z of a point with six dofs: one of the interface, or a set of one node with
// rotations. -1: none.
Index node_of_point(const Geometry& geometry, const std::string& point, const std::string& set);

// Whether the set is in recovery data only, not among the body's nodes.
bool is_inside(const Geometry& geometry, const std::string& set);

// InputError at `source`, with the existing names and the cure. For a superelement: keep the
// surface and reduce again.
const Surface& find_surface(const Geometry& geometry, const std::string& instance,
                            const std::string& name, const SourceLine& source);
// InputError as below, if a use does not find its surface or nodes.
void check_uses(const std::vector<SetUse>& uses, const Geometry& geometry);
void check_uses(const std::vector<SetUse>& uses, const Mesh& mesh);

// Nodes of a surface or a nodeset.
std::vector<Index> find_nodes(const Geometry& geometry, const std::string& instance,
                              const std::string& name, const SourceLine& source);

}  // namespace cbr
