// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/setup/components: what the instances of a component share.
//
// What the instances of a component share: read once, however often it is placed.
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
#include "dynamics/motion/modal/forms/diagonal_form.hpp"
#include "dynamics/motion/modal/forms/statics_form.hpp"
#include "dynamics/motion/nodal/mesh_body.hpp"
#include "dynamics/setup/components/geometry.hpp"
#include "dynamics/setup/components/motion_plan.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// One superelement of an instance: the only one, or a domain.
struct ReducedPart {
  std::shared_ptr<const Superelement> superelement;
  std::vector<Index> node;  // of each of its nodes: the body's
  Index first_mode = 0;     // its modal coordinates among the body's
};

// Which modes of a mesh.
struct MeshModesWanted {
  // the lowest so many; not given: as many as there are up to a frequency, and the next
  std::optional<Index> count;
  double up_to_hz = 0;
  bool is_joined = false;  // ties or links join meshes: small ones in all of their modes
};

// What the command line of cbr-dyn says.
struct BuildOptions {
  // With central differences and newmark, superelements up to this many coordinates move in their
  // diagonal form. Not given: those whose file has it, and small ones.
  std::optional<Index> diagonal_limit;
  // meshes move in these modes: frequencies and harmonic response
  std::optional<MeshModesWanted> mesh_modes = {};
  // with `rotations: auto`: bodies that can turn by any angle do
  bool turns = false;
  // What cbr-reduce saw, where the scene that is built is a part of it; null: the scene itself.
  const Scene* reduced_for = nullptr;
};

struct ReducedComponent {
  std::shared_ptr<const Geometry> geometry;
  std::vector<ReducedPart> parts;
  // The only part, or the domains joined; of a group only when an instance moves in its diagonal
  // form.
  std::shared_ptr<Superelement> superelement;
  // of the free superelement, when an instance moves in it
  std::shared_ptr<const DiagonalForm> form;
  // Of the free superelement, of basis massless or characteristic with statics; then there is no
  // `form`.
  std::shared_ptr<const StaticsForm> statics;
  RigidBody rigid_body;
  std::map<std::string, std::string> provenance;  // of the file
  // of the domains together; that of a superelement, or a domain, is in `parts`
  std::optional<Conditioning> conditioning;
  Index n_modal = 0, n_dofs = 0;
  MotionPlans plans;
  BuildOptions options;
};

struct MeshedComponent {
  std::shared_ptr<const Geometry> geometry;
  std::shared_ptr<const Mesh> mesh;
  std::vector<BlockProperties> properties;  // per block of the mesh
  std::vector<Index> body_node;             // of each node of the mesh: the body's node, or -1
  std::shared_ptr<const FiniteElementModel> fe;
  MassKind mass = MassKind::lumped;  // of fe
  Index n_parts = 1;                 // that no elements join
  // of rigid instances: with consistent mass, so that the inertia is that of the volume
  std::optional<RigidBody> rigid_body;
  std::shared_ptr<const MeshModel> model;  // when an instance moves as a MeshBody
  std::optional<MeshModesWanted> modes;
  MotionPlans plans;
};

// Reads of the component's superelement what tells its sets. InputError: it is missing or stale
// (with the command to run), or does not keep a set that the scene names of an instance of it.
void check_reduced_component(const Scene& scene, const Component& component, Report& report);

// In phases "read" and "setup" of the report. The superelement has been checked. InputError: a file
// that is damaged, and of a mesh also a set that the scene names and that it does not have.
ReducedComponent read_reduced_component(const SceneIndex& index, const Component& component,
                                        const BuildOptions& options, Report& report);
MeshedComponent read_meshed_component(const SceneIndex& index, const Component& component,
                                      const BuildOptions& options, Report& report);

}  // namespace cbr
