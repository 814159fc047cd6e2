// SPDX-License-Identifier: GPL-3.0-or-later
// From a scene to a simulation that can run.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/report.hpp"
#include "common/scene.hpp"
#include "dynamics/bodies/mesh_body.hpp"
#include "dynamics/bodies/superelement_body.hpp"
#include "dynamics/integrators/simulation.hpp"
#include "dynamics/setup/geometry.hpp"

namespace cbr {

// What the instances of a component share.
struct ComponentModel {
  std::shared_ptr<Geometry> geometry;
  std::shared_ptr<Superelement> superelement;  // as: superelement
  std::shared_ptr<const DiagonalForm> form;    // of the free superelement; empty when every instance is held
  std::shared_ptr<Geometry> mesh_geometry;     // as: mesh; the three below too
  std::shared_ptr<Mesh> mesh;
  std::vector<BlockProperties> properties;  // per block of the mesh
  std::vector<Index> body_node;             // of each node of the mesh: the body's node, or -1
  std::shared_ptr<MeshModel> mesh_model;
};

// A scene's instances ready to move, and what the outputs need to know of them beyond Body.
struct BuiltScene {
  Simulation simulation;
  struct OfInstance {
    std::string name, component;
    std::shared_ptr<const Geometry> geometry;
    std::shared_ptr<const Superelement> superelement;  // or
    std::shared_ptr<const Mesh> mesh;
    std::vector<BlockProperties> properties;
    std::vector<Index> body_node;                         // of each node of the mesh
    const SuperelementBody* superelement_body = nullptr;  // owned by the simulation
    Placement placement;
    double mass = 0;
  };
  std::vector<OfInstance> instances;  // as simulation.bodies
  std::vector<std::string> notes;     // for the summary
  bool momentum_is_kept = true;       // no boundary conditions, loads, or rigid walls that are met
};

// Reads superelements and meshes, in phases "read" and "setup" of the report. InputError: a missing or stale superelement (with the
// command to run), surfaces that are not there, what this version cannot do.
BuiltScene build(const Scene& scene, Report& report);

// What the instances of `component` as: superelement share.
ComponentModel read_superelement_model(const Scene& scene, const Component& component, Report& report);

}  // namespace cbr
