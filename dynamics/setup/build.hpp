// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/setup: scene to bodies, contact and steps.
//
// From a scene to a simulation that can run.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/run/simulation.hpp"
#include "dynamics/setup/component_model.hpp"
#include "dynamics/setup/gap_watch.hpp"
#include "dynamics/setup/geometry.hpp"

namespace cbr {

struct MeshModes;

// A scene's instances ready to move, and what the outputs need to know of them beyond Body.
struct BuiltScene {
  Simulation simulation;
  struct OfInstance {
    std::string name, component;
    std::shared_ptr<const Geometry> geometry;
    std::vector<ReducedPart> parts;  // of a superelement, or
    Index n_modal = 0;               // of all parts
    std::shared_ptr<const Mesh> mesh;
    std::vector<BlockProperties> properties;
    std::vector<Index> body_node;  // of each node of the mesh
    std::shared_ptr<const MeshModes> modes;  // BuildOptions::mesh_modes
    Index n_shell_faces = 0;       // of the skin, that act
    Placement placement;
    double mass = 0;
  };
  std::vector<OfInstance> instances;  // as simulation.bodies
  GapWatch gaps;
  std::vector<std::string> notes;     // for the summary
  bool momentum_is_kept = true;       // no boundary conditions, loads, or rigid walls that are met
};

// Reads superelements and meshes, in phases "read" and "setup" of the report. InputError: a missing or stale superelement (with the
// command to run), surfaces that are not there, what this version cannot do.
BuiltScene build(const Scene& scene, Report& report, const BuildOptions& options = {});

}  // namespace cbr
