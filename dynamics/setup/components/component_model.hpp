// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/setup/components: data that the instances of a component share.
//
// Read once, for any number of instances.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/scene/scene.hpp"
#include "common/superelement/superelement_group.hpp"
#include "dynamics/motion/coupled/coupled_model.hpp"
#include "dynamics/motion/modal/forms/modal_form.hpp"
#include "dynamics/motion/modal/forms/residual_compliance.hpp"
#include "dynamics/motion/nodal/mesh_body.hpp"
#include "dynamics/setup/components/geometry.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// One superelement of an instance: the only one, or a domain.
struct ReducedPart {
  std::shared_ptr<const Superelement> superelement;
  std::vector<Index> node;  // the body's node for each of its nodes
  Index first_mode = 0;     // first of its modal coordinates in the body
};

// Selection of the modes of a mesh.
struct MeshModesWanted {
  // the number of lowest modes; not given: all up to a frequency, and the next
  std::optional<Index> count;
  double up_to_hz = 0;
  bool is_joined = false;  // ties or links join meshes: small ones get all modes
};

// Options of cbr-dyn's command line.
struct BuildOptions {
  // With central differences and newmark, superelements up to this number of coordinates use their
  // diagonal form. Not given: those with a stored form, and small ones.
  std::optional<Index> diagonal_limit;
  // meshes use these modes: frequencies and harmonic response
  std::optional<MeshModesWanted> mesh_modes = {};
  // with `rotations: auto`: bodies that allow large rotation use it
  bool turns = false;
  // The scene of cbr-reduce, if the built scene is a part of it; null: the built scene.
  const Scene* reduced_for = nullptr;
};

struct ReducedComponent {
  std::shared_ptr<const Geometry> geometry;
  std::vector<ReducedPart> parts;
  // The only part, or the joined domains; for a group only if an instance uses its diagonal form.
  std::shared_ptr<Superelement> superelement;
  // of the free superelement, if an instance uses it
  std::shared_ptr<const ModalForm> form;
  // basis massless, or characteristic with residual compliance
  bool has_residual() const { return form && form->residual; }
  RigidBody rigid_body;
  std::map<std::string, std::string> provenance;  // of the file
  // of the joined domains; that of a superelement, or a domain, is in `parts`
  std::optional<Conditioning> conditioning;
  Index n_modal = 0, n_dofs = 0;
};

struct MeshedComponent {
  std::shared_ptr<const Geometry> geometry;
  std::shared_ptr<const Mesh> mesh;
  std::vector<BlockProperties> properties;  // per block of the mesh
  std::vector<Index> body_node;             // the body's node for each node of the mesh, or -1
  std::shared_ptr<const FiniteElementModel> fe;
  MassKind mass = MassKind::lumped;  // of fe
  // of rigid instances: with consistent mass, so that the inertia is that of the volume
  std::optional<RigidBody> rigid_body;
  std::shared_ptr<const MeshModel> model;  // if an instance is a MeshBody
  std::optional<MeshModesWanted> modes;
};

// Replaces `place` of instances by their positions, which are reported. They follow the scene's
// order. InputError: no such wall or surface, one that is not flat, or of an instance that is
// placed later.
void place_instances(Scene& scene, Report& report);

// Reads the sets of the component's superelement. InputError: missing or stale (with the command to
// run), or without a set that the scene uses.
void check_reduced_component(const Scene& scene, const Component& component, Report& report);

// Plans the bodies of its instances. Logs phases "read" and "setup". Precondition: the superelement
// has been checked. InputError: a damaged file; for a mesh also a missing set.
ReducedComponent read_reduced_component(SceneIndex& index, const Component& component,
                                        const BuildOptions& options, Report& report);
MeshedComponent read_meshed_component(SceneIndex& index, const Component& component,
                                      const BuildOptions& options, Report& report);

// For the .cpp of this folder. Nodes with six dofs keep x, y, z. Their rotations become a node at
// the same position, after all others. Its components stay 3, 4, 5, which identifies rotations in
// rigid motions. Returns the rotation node of each such node.
std::map<Index, Index> separate_rotations(Superelement& s);

}  // namespace cbr
