// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/setup/built: what build() makes, and questions about it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/run/simulation/simulation.hpp"
#include "dynamics/setup/built/gap_watch.hpp"
#include "dynamics/setup/built/strain_watch.hpp"
#include "dynamics/setup/components/component_model.hpp"
#include "dynamics/setup/components/geometry.hpp"

namespace cbr {

struct MeshModes;

// A scene's instances ready to move, and what the outputs need to know of them beyond Body.
struct BuiltScene {
  Simulation simulation;
  struct OfInstance {
    std::string name, component;
    std::shared_ptr<const Geometry> geometry;
    std::vector<ReducedPart> parts;    // of a superelement, or
    Index n_modal = 0;                 // of all parts
    std::shared_ptr<const Mesh> mesh;  // of a rigid body, too
    bool is_rigid = false;
    std::optional<MassKind> mass_kind;  // of a mesh that is not rigid
    std::vector<BlockProperties> properties;
    std::vector<Index> body_node;            // of each node of the mesh
    std::shared_ptr<const MeshModes> modes;  // BuildOptions::mesh_modes
    Index n_shell_faces = 0;                 // of the skin, that act
    Placement placement;
    double mass = 0;
    Index n_following = 0;   // coordinates that follow contact as statics, beside Body::n_dofs()
    std::string why_linear;  // it cannot turn by any angle; empty: it can
  };
  std::vector<OfInstance> instances;  // as simulation.bodies
  GapWatch gaps;
  StrainWatch strains;
  std::vector<std::string> notes;  // for the summary
  std::string large_is_refused;    // what_large_is_refused_for()
  // Per instance, rad, with `rotations: auto`: beyond it the run is to start again with bodies that
  // turn; HUGE_VAL, or empty: never
  std::vector<double> turn_limit;
  bool momentum_is_kept = true;  // no boundary conditions, loads, or rigid walls that are met
};

}  // namespace cbr
