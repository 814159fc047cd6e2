// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sstream>
#include <string>

#include "common/scene/scene.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"

namespace cbr::test {

// Every key of docs/formats.md once, each with a value other than its default.
inline const std::string full_scene = R"(materials:
  steel: {youngs_modulus: 5.17e12, poissons_ratio: 0.3, density: 7836}
  "soft stuff": {youngs_modulus: 1.0e-3, poissons_ratio: -0.25, density: 0.1}
components:
  block:
    mesh: meshes/block.msh
    material: steel
    blocks:
      core: {material: soft stuff, element: hex8, thickness: 0.0025}
      "true": {element: hex8-hourglass}
    element: hex8-hourglass
    mass: consistent
    reduction:
      basis: craig-bampton
      interface: [contact, "two words"]
      modes: 80
      pick: participation
      domains: 3
      recovery: true
      superelement: ../out/block.h5
  plate:
    mesh: /elsewhere/plate.e
    material: steel
    reduction: {interface: contact, cutoff_hz: 2.0e6, domains: 2, second_reduction: {cutoff_hz: 1.5e6}, condense_rotations: true, exact_modes: true}
  bare: {mesh: bare.msh, blocks: {all: {material: steel}}}
instances:
  right: {component: block, as: mesh, position: [0.0381, 0, 0], rotation: [10, -20.5, 1e-3], mirror: x, velocity: [-1, 0.1, 3810], angular_velocity: [1, 2, -3]}
  left:  {component: plate, as: superelement}
  third: {component: bare}
skin: {surfaces: [contact], youngs_modulus: 6.9e3, poissons_ratio: 0.3, density: 0.11, thickness: 2.5e-10, mesh: skins/skinned.msh}
boundary:
  - {instance: left, nodes: clamp, fix: [x, z], rotations: [y], velocity: [0.5, 0, 2], angular_velocity: [0, 3, 0], about: [1, 2, 3], history: {time: [0, 1e-6, 3e-6], value: [0, 1, 0]}}
loads:
  - {instance: left, surface: tip, traction: [-1, 0, 0], history: {time: [0, 3e-7, 6e-7], value: [0, 6.9e8, 0]}}
  - {instance: right, surface: tip.end, force: [0, 0, -100]}
  - {gravity: [0, 0, -9.81]}
walls:
  floor: {plane: {point: [0, 0, -0.25], normal: [0, 3, 4]}}
  "the ball": {sphere: {center: [1, 2, 3], radius: 1.5e-3, inside: true}}
  pipe: {cylinder: {point: [0, 0, 7], axis: [0, -2, 0], radius: 12, inside: true}}
contact:
  - {between: [left.contact, right.contact], formulation: two-way, enforcement: penalty, friction: 0.25, damping: 0.125}
  - {between: [left.top, right.a.b], enforcement: nodal}
  - {between: [floor, left.contact], friction: 0.375, adjust: 1.0e-5}
  - {between: [left.side, third.top], tied: true, formulation: mortar}
  - {between: all, friction: {static: 0.5, kinetic: 0.125, decay: 8}, adjust: 0}
time: {end: 1.2e-5, step: 1.0e-8, integrator: newmark, alpha: -0.125, force: true, rotations: large}
output:
  every: 1.0e-7
  history: [left.contact, right.contact]
  fields: [displacement, stress, contact_pressure]
  format: exodus
  reactions: [left.clamp]
  stress: [left.root, {instance: right, elements: [3, 17], worst: 5, envelope: true}]
  checkpoint: {every: 2.5e-7, file: keep/impact.h5}
sweep: {from_hz: 12.5, to_hz: 2125, points: 57, spacing: log, modes: 43}
)";

// A component that is a superelement file alone.
inline const std::string alone_scene = R"(components:
  part: {superelement: parts/given.cbr.h5}
instances:
  left: {component: part, position: [1, 2, 3]}
)";

inline std::string replaced(std::string text, const std::string& old, const std::string& with) {
  const auto at = text.find(old);
  if (at == std::string::npos) throw std::logic_error("the sample scene has no '" + old + "'");
  return text.replace(at, old.size(), with);
}

inline Scene read_text(const TemporaryFolder& folder, const std::string& text) {
  write_bytes(folder / "impact.yaml", text);
  return read_scene((folder / "impact.yaml").string());
}

// The message without the folder's name; "no error" if the scene is read.
inline std::string refusal(const TemporaryFolder& folder, const std::string& text) {
  const std::string message = refusal_of([&] { read_text(folder, text); }),
                    prefix = folder.path().string() + "/";
  return message.rfind(prefix, 0) == 0 ? message.substr(prefix.size()) : message;
}

inline std::string written(const Scene& scene) {
  std::ostringstream out;
  write_scene(scene, out);
  return out.str();
}

}  // namespace cbr::test
