// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/setup/built: the result of build(), and functions of it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/run/simulation/simulation.hpp"
#include "dynamics/setup/built/watches.hpp"
#include "dynamics/setup/components/component_model.hpp"
#include "dynamics/setup/components/geometry.hpp"

namespace cbr {

struct MeshModes;

// A scene's instances ready to move, and data for the outputs beyond Body.
struct BuiltScene {
  Simulation simulation;
  struct OfInstance {
    std::string name, component;
    std::shared_ptr<const Geometry> geometry;
    std::vector<ReducedPart> parts;    // of a superelement, or
    Index n_modal = 0;                 // of all parts
    std::shared_ptr<const Mesh> mesh;  // also of a rigid body
    bool is_rigid = false;
    std::optional<MassKind> mass_kind;  // of a mesh unless rigid
    std::vector<BlockProperties> properties;
    std::vector<Index> body_node;            // of each node of the mesh
    std::shared_ptr<const MeshModes> modes;  // BuildOptions::mesh_modes
    Index n_shell_faces = 0;                 // of the active skin
    Placement placement;
    double mass = 0;
    Damping damping;
    Index n_following = 0;   // quasi-static modes, in addition to Body::n_dofs()
    std::string why_linear;  // reason against large rotation; empty: it is possible
  };
  std::vector<OfInstance> instances;  // in the order of simulation.bodies
  GapWatch gaps;
  StrainWatch strains;
  std::vector<std::string> notes;  // for the summary
  // Per instance, rad, with `rotations: auto`: beyond it the run restarts with large rotation.
  // HUGE_VAL, or empty: never
  std::vector<double> turn_limit;
  std::string will_turn;         // reason to begin with large rotation instead; empty: none
  bool momentum_is_kept = true;  // without boundary conditions, loads, or contact with rigid walls
};

}  // namespace cbr
