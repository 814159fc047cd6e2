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
  HexFormulation hex = HexFormulation::incompatible;
  // Whether consistent mass has the points of `hex`, too: singular where these are reduced.
  bool reduced_mass = false;
};

// The finite element model of a component, which assemble() leaves unconstrained. Dof 3 i + c is
// component c of node nodes[i]: of its displacement, and of the last n_rotations nodes of its
// rotation about the fixed axes.
struct FiniteElementModel {
  SparseMatrix K;  // N x N, both triangles, N = 3 nodes.size()
  SparseMatrix M;  // N x N, both triangles; diagonal when lumped
  // Indices into mesh.coordinates of the nodes that a solid or a shell uses, ascending; behind them
  // those of shells once more, ascending too.
  std::vector<Index> nodes;
  std::vector<Index> row;  // inverse: per mesh node its first i, or -1
  Index n_rotations = 0;
  // Row of K and M of each dof, -1 where it is fixed; empty: nothing is, row i is dof i.
  std::vector<Index> row_of_dof = {};

  bool is_fixed(Index dof) const { return !row_of_dof.empty() && row_of_dof[dof] < 0; }
  Index n_translations() const { return static_cast<Index>(nodes.size()) - n_rotations; }
};

// Message about a mesh of shells and beams alone: the fault and its cure.
inline constexpr const char* no_volume_elements =
    "the mesh has no volume elements (hexes, tetrahedra, wedges, pyramids), and no block of shells "
    "with a thickness: there is nothing to compute; give shells one, as blocks: {NAME: {thickness: "
    "0.001}}; gmsh writes only what is "
    "in physical groups once there is one: add Physical Volume(\"part\") = {TAG}, and mesh with "
    "gmsh -3";

// One BlockProperties per mesh block (those of blocks that are not structure are ignored).
// InputError: an inverted or degenerate element by its id, block and file-independent reason; a
// mesh without solids and shells.
FiniteElementModel assemble(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                            MassKind mass);

// `nodes`, `row` and n_rotations of the model alone; no nodes when the mesh has no structure.
void number_nodes(const Mesh& mesh, FiniteElementModel& model);

// N x 6: three translations, then three rotations about `center`, as displacements of `points` (dof
// 3 i + c). The last n_rotations of them are rotations.
Matrix rigid_modes(const Points& points, const Vector3& center, Index n_rotations = 0);

struct RigidBody {
  double mass = 0;
  Vector3 center = Vector3::Zero();   // of mass
  Matrix3 inertia = Matrix3::Zero();  // about the centre, full tensor
};
// n_rotations: as above.
RigidBody rigid_body(const SparseMatrix& M, const Points& points, Index n_rotations = 0);
// Of the columns of rigid motions, so that they are of one size: 1 for translations, 1 / radius of
// inertia for rotations   (6)
Vector rigid_scales(const RigidBody& body);

// The rigid body that a mesh is as geometry, whatever its mass matrix: by the elements' quadrature
// of rho over their volume. `properties`: one per block. Elements are not checked: for meshes that
// can be assembled, or for information only.
RigidBody rigid_body_of_geometry(const Mesh& mesh, const std::vector<BlockProperties>& properties);

// As assemble() has them. InputError: a material out of range; an inverted, degenerate or repeated
// element, by its id and block; sizes and units whose matrices a double cannot hold.
void check_mesh(const Mesh& mesh, const std::vector<BlockProperties>& properties);

}  // namespace cbr
