// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/fem: assembly of stiffness and mass, rigid motions, shells on a surface.
//
// From a mesh and materials to K and M.
#pragma once

#include <vector>

#include "common/fem/elements/element.hpp"
#include "common/mesh/mesh.hpp"

namespace cbr {

struct BlockProperties {
  Material material;
  Hex8Formulation hex8 = Hex8Formulation::incompatible;
};

// The unconstrained finite element model of a component. Dof 3 i + c is component c of node
// nodes[i].
struct FiniteElementModel {
  SparseMatrix K;  // N x N, both triangles, N = 3 nodes.size()
  SparseMatrix M;  // N x N, both triangles; diagonal when lumped
  // indices into mesh.coordinates of the nodes that a volume element uses, ascending
  std::vector<Index> nodes;
  std::vector<Index> row;  // inverse: per mesh node its i, or -1
};

// What is wrong with a mesh of shells and beams alone, and what to do.
inline constexpr const char* no_volume_elements =
    "the mesh has no volume elements (hexes, tetrahedra, wedges, pyramids): there is nothing to "
    "compute; gmsh writes only what is "
    "in physical groups once there is one: add Physical Volume(\"part\") = {TAG}, and mesh with "
    "gmsh -3";

// One BlockProperties per mesh block (those of two-dimensional blocks are ignored: shells and skins
// have no volume). InputError: an inverted or degenerate element by its id, block and
// file-independent reason; a mesh without volume elements.
FiniteElementModel assemble(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                            MassKind mass);

// N x 6: three translations, then three rotations about `center`, as displacements of `points` (dof
// 3 i + c).
Matrix rigid_modes(const Points& points, const Vector3& center);

struct RigidBody {
  double mass = 0;
  Vector3 center = Vector3::Zero();   // of mass
  Matrix3 inertia = Matrix3::Zero();  // about the centre, full tensor
};
RigidBody rigid_body(const SparseMatrix& M, const Points& points);

}  // namespace cbr
