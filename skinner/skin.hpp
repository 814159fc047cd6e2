// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of skinner: cbr-skin: shells on surfaces.
//
// Fictitious shells on sidesets, by which an explicit code sees the contact surface of a
// superelement.
#pragma once

#include <filesystem>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/surface.hpp"
#include "common/scene/scene.hpp"

namespace cbr {

struct SkinBlock {
  std::string name;
  FaceKind kind = FaceKind::quad4;
  Index n_shells = 0, n_nodes = 0;
};

struct SkinnedMesh {
  Mesh mesh;
  std::vector<SkinBlock> blocks;  // the shell blocks that were added
  // what the user should know: ids that moved, surfaces left out
  std::vector<std::string> notes;
  // component -> left_out_blocks() of its mesh, when there are any
  std::map<std::string, std::string> left_out = {};
};

// Appends to `mesh` a block `block_name` of shells on the faces: tri3, quad4, tri6, quad8 or quad9
// as the faces are, on the faces' own nodes, normals outward. Triangles among quadrilaterals go to
// a block of their own; the two blocks are then called NAME_quad4 and NAME_tri3. Ids of the shells
// follow on the highest element id. InputError: a block of that name exists; extract_surface()'s.
std::vector<SkinBlock> add_skin(Mesh& mesh, const Surface& surface, const std::string& block_name);

// The mesh with a block skin.SIDESET for each sideset named. InputError: no such sideset (lists
// them), an empty one, one named twice.
SkinnedMesh skin_mesh(Mesh mesh, const std::vector<std::string>& sidesets);

// The system mesh of a scene with skin: of each instance in its place, mirrored, rotated and moved,
// either (as: mesh) all nodes, volume blocks INSTANCE.BLOCK, sidesets and nodesets INSTANCE.NAME,
// or (as: superelement) the nodes of its interface, as nodesets INSTANCE.NAME. On it blocks
// skin.INSTANCE.SURFACE for each surface of `skin: surfaces` and each instance that has it; a
// surface may also be given as INSTANCE.SURFACE. A superelement is skinned only where its interface
// keeps all the surface's nodes. Node and element ids are the component's where they are free, else
// raised by the smallest multiple of a power of ten that frees them. Superelement files are not
// read; instances of components without a mesh are left out, with a note. InputError: a surface
// that no instance has; those of read_mesh.
SkinnedMesh skin_scene(const Scene& scene);

// What cbr-skin does, apart from its command line.
struct SkinCommand {
  // a scene, "-" for a scene on stdin, or a mesh (by its suffix)
  std::string input;
  std::vector<std::string> sidesets;  // of a mesh
  std::filesystem::path output;       // needed for a mesh; in place of the scene's skin: mesh
};

// Writes the skinned mesh, and for a scene the scene, with the mesh filled in, to `scene_out`
// unless that is null. Warns of superelements that are there and not of the present inputs.
// InputError: those of the readers; options that do not belong together. RunError: a mesh was
// replaced meanwhile.
void run_skin(const SkinCommand& command, std::ostream* scene_out, Report& report);

}  // namespace cbr
