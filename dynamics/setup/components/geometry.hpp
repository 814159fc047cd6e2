// SPDX-License-Identifier: GPL-3.0-or-later
// Nodes, surfaces and node sets of a component by name, whatever it is advanced as; and what
// follows from faces alone.
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

// Component axes. Faces and sets index the rows of `coordinates`, which are the body's nodes.
struct Geometry {
  std::vector<Index> node_ids;  // of the mesh
  Points coordinates;
  std::map<std::string, Surface> surfaces;
  std::map<std::string, std::vector<Index>> nodesets;
  // Of points of a superelement's interface, and of nodes of shells: the node of x, y, z and that
  // of its rotations, which comes behind all others. A nodeset of a point's name has the first.
  std::map<Index, Index> rotations;
  std::set<std::string> recovered;  // sets that recovery data of a superelement know, inside too
  bool reduced = false;             // a superelement: what it does not keep is not there
  bool has_mesh = true;  // false: a superelement file alone, which nobody can reduce again
};

Geometry geometry_of(const Superelement& superelement);
Geometry geometry_of(const Mesh& mesh, const FiniteElementModel& model);

// The node of x, y, z of a point that has six dofs: one of the interface, or one whose set is one
// node with rotations. -1: the point has none.
Index node_of_point(const Geometry& geometry, const std::string& point, const std::string& set);

// Whether the set is one of recovery data alone, not of the body's nodes.
bool is_inside(const Geometry& geometry, const std::string& set);

// InputError at `source`, with the names there are and the cure: for a superelement, to keep the
// surface and reduce again.
const Surface& find_surface(const Geometry& geometry, const std::string& instance,
                            const std::string& name, const SourceLine& source);
// InputError, as below: a use that does not find its surface or nodes.
void check_uses(const std::vector<SetUse>& uses, const Geometry& geometry);
void check_uses(const std::vector<SetUse>& uses, const Mesh& mesh);

// Of a surface or a nodeset.
std::vector<Index> find_nodes(const Geometry& geometry, const std::string& instance,
                              const std::string& name, const SourceLine& source);

}  // namespace cbr
