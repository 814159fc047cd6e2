// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/unit/common/scene_samples.hpp"

namespace cbr::scene_errors_test {
namespace {

using test::full_scene;
using test::read_text;
using test::refusal;
using test::replaced;
using test::TemporaryFolder;
using test::written;

struct Mistake {
  std::string old, with;               // in the full scene
  std::vector<std::string> mentioned;  // by the message: line, key, found, allowed
};

void PrintTo(const Mistake& mistake, std::ostream* out) { *out << mistake.mentioned.front(); }

class SceneMistake : public testing::TestWithParam<Mistake> {};

TEST_P(SceneMistake, isRefusedWithLineKeyAndCure) {
  const TemporaryFolder folder;
  const Mistake& mistake = GetParam();
  const std::string message = refusal(folder, replaced(full_scene, mistake.old, mistake.with));
  EXPECT_FALSE(message.empty()) << "accepted: " << mistake.with;
  for (const auto& text : mistake.mentioned) {
    EXPECT_NE(message.find(text), std::string::npos) << "'" << text << "' is not in: " << message;
  }
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

const std::vector<Mistake> mistakes = {
    // keys
    {"    material: steel\n    blocks",
     "    materials: steel\n    blocks",
     {"impact.yaml:7: components.block.materials: unknown key 'materials', did you mean "
      "'material'? allowed: mesh, material"}},
    {"time: {end: 1.2e-5,",
     "time: {ende: 1.2e-5,",
     {"impact.yaml:47: time.ende: unknown key", "did you mean 'end'?"}},
    {"\noutput:",
     "\nextra: 1\noutput:",
     {"impact.yaml:48: extra: unknown key 'extra'", "allowed: materials, components"}},
    {"    mesh: meshes/block.msh\n", "", {"impact.yaml:5: components.block: missing key 'mesh'"}},
    {"density: 7836",
     "density: 7836, density: 7",
     {"impact.yaml:2: materials.steel.density: duplicate key 'density'"}},
    {"  left:  {component: plate, as: superelement}",
     "  left:  {component: plate}\n  left: {component: plate}",
     {"impact.yaml:29: instances.left", "duplicate key"}},
    {"youngs_modulus: 5.17e12, ",
     "",
     {"impact.yaml:2: materials.steel: missing key 'youngs_modulus'"}},
    // numbers
    {"5.17e12",
     "-5.17e12",
     {"impact.yaml:2: materials.steel.youngs_modulus: found '-5.17e12', expected a number above "
      "0"}},
    {"5.17e12", "0", {"youngs_modulus", "above 0"}},
    {"5.17e12", ".nan", {"youngs_modulus: found '.nan', expected a finite number"}},
    {"5.17e12", ".inf", {"youngs_modulus: found '.inf', expected a finite number"}},
    {"5.17e12", "nan", {"youngs_modulus", "finite"}},
    {"5.17e12", "1e999", {"youngs_modulus", "'1e999'"}},
    {"5.17e12", "5.17d12", {"youngs_modulus: found '5.17d12', expected a number"}},
    {"5.17e12", "0x10", {"youngs_modulus: found '0x10', expected a number"}},
    {"5.17e12", "210 GPa", {"youngs_modulus: found '210 GPa', expected a number"}},
    {"5.17e12", "[1]", {"youngs_modulus: found a list, expected a number"}},
    {"youngs_modulus: 5.17e12",
     "youngs_modulus:",
     {"youngs_modulus: found nothing, expected a number"}},
    {"poissons_ratio: 0.3, density: 7836",
     "poissons_ratio: 0.5, density: 7836",
     {"found '0.5', expected a number between -1 and 0.5"}},
    {"poissons_ratio: 0.3, density: 7836",
     "poissons_ratio: -1, density: 7836",
     {"expected a number between -1 and 0.5"}},
    {"density: 7836", "density: 0", {"density", "above 0"}},
    {"modes: 80",
     "modes: -1",
     {"impact.yaml:16: components.block.reduction.modes: found '-1', expected a whole number from "
      "0"}},
    {"modes: 80", "modes: 1.5", {"expected a whole number"}},
    {"modes: 80", "modes: 99999999999999999999", {"expected a whole number"}},
    {"modes: 80", "modes: eighty", {"found 'eighty', expected a whole number"}},
    {"domains: 3", "domains: 0", {"expected a whole number from 1"}},
    {"domains: 2, second", "second", {"second_reduction", "needs 'domains' above 1"}},
    {"cutoff_hz: 2.0e6, domains: 2",
     "tolerance: 0.1, domains: 2",
     {"second_reduction", "is not available with tolerance"}},
    {"{cutoff_hz: 1.5e6}", "{cutoff_hz: 1.5e6, modes: 3}", {"second_reduction", "cutoff_hz"}},
    {"{cutoff_hz: 1.5e6}", "{cutoff_hz: 0}", {"second_reduction.cutoff_hz"}},
    {"cutoff_hz: 2.0e6", "cutoff_hz: -2.0e6", {"cutoff_hz", "above 0"}},
    {"thickness: 2.5e-10",
     "thickness: -1",
     {"skin.thickness: found '-1', expected a number from 0"}},
    {"friction: 0.25",
     "friction: -0.25",
     {"impact.yaml:42: contact[0].friction: found '-0.25', expected a number from 0"}},
    {"end: 1.2e-5", "end: 0", {"time.end", "above 0"}},
    {"step: 1.0e-8", "step: -1.0e-8", {"time.step", "above 0"}},
    {"step: 1.0e-8",
     "step: small",
     {"time.step: found 'small', expected auto, seconds, or {cfl: NUMBER}"}},
    {"step: 1.0e-8, integrator: newmark",
     "step: {cfl: 1.5}",
     {"time.step.cfl", "from above 0 to 1", "newmark"}},
    {"alpha: -0.125", "alpha: -0.4", {"time.alpha", "from -1/3 to 0"}},
    {"rotations: large",
     "rotations: huge",
     {"time.rotations: unknown value 'huge', allowed: small, large"}},
    {"angular_velocity: [1, 2, -3]",
     "angular_velocity: 3",
     {"instances.right.angular_velocity: found '3'"}},
    {"alpha: -0.125", "mass_scaling: true", {"time.mass_scaling", "requires integrator: exact"}},
    {"integrator: newmark", "integrator: exact", {"time.alpha", "newmark"}},
    {"step: 1.0e-8", "step: {cfl: 0}", {"time.step.cfl", "above 0"}},
    {"step: 1.0e-8", "step: {clf: 0.5}", {"did you mean 'cfl'?"}},
    {"step: 1.0e-8", "step: [1]", {"time.step: expected auto"}},
    {"every: 1.0e-7", "every: -1", {"impact.yaml:49: output.every: found '-1'"}},
    // vectors and lists
    {"[0.0381, 0, 0]",
     "[0.0381, 0]",
     {"instances.right.position: found a list of 2, expected a list of three numbers"}},
    {"[0.0381, 0, 0]", "[0.0381, 0, 0, 0]", {"found a list of 4"}},
    {"[0.0381, 0, 0]", "0.0381", {"found '0.0381', expected a list of three numbers"}},
    {"[0.0381, 0, 0]", "[0.0381, zero, 0]", {"position[1]: found 'zero', expected a number"}},
    {"[10, -20.5, 1e-3]", "[10, .inf, 0]", {"rotation[1]", "finite"}},
    {"[0, 3e-7, 6e-7]",
     "[0, 3e-7, 3e-7]",
     {"impact.yaml:34: loads[0].history.time[2]: not above the time before it"}},
    {"[0, 3e-7, 6e-7]",
     "[0, 3e-7]",
     {"history.value: has 3 entries, expected as many as 'time' has: 2"}},
    {"time: [0, 3e-7, 6e-7], value: [0, 6.9e8, 0]",
     "time: [], value: []",
     {"history.time: is empty"}},
    {"fix: [x, z]", "fix: [x, x]", {"'x' is listed twice"}},
    {"fix: [x, z]", "fix: []", {"boundary[0].fix: is empty"}},
    {"rotations: [y]", "rotations: []", {"boundary[0].rotations: is empty", "or none"}},
    {"rotations: [y]", "rotations: [y, y]", {"boundary[0].rotations", "listed twice"}},
    {"rotations: [y]", "rotations: [ry]", {"boundary[0].rotations", "'ry'", "x, y, z"}},
    {"thickness: 0.0025", "thickness: 0", {"blocks.core.thickness", "'0'", "above 0"}},
    {"fix: [x, z]", "fix: [w]", {"unknown value 'w'", "allowed: x, y, z"}},
    // choices
    {"    element: hex8-hourglass",
     "    element: hex8-hourglas",
     {"impact.yaml:11: components.block.element: unknown value 'hex8-hourglas', did you mean "
      "'hex8-hourglass'? allowed: hex8"}},
    {"mass: consistent", "mass: heavy", {"allowed: auto, lumped, consistent"}},
    {"basis: craig-bampton",
     "basis: characteristic\n      characteristic: {statics: []}",
     {"components.block.reduction.characteristic.statics: is empty, expected sidesets of the "
      "interface, or none"}},
    {"basis: craig-bampton",
     "basis: craig",
     {"reduction.basis: unknown value 'craig', allowed: craig-bampton"}},
    {"pick: participation", "pick: random", {"allowed: frequency, participation"}},
    {"recovery: true", "recovery: maybe", {"expected true or false"}},
    {"recovery: true",
     "recovery: []",
     {"recovery: is empty, expected sets or element blocks of the mesh, or true"}},
    {"recovery: true", "recovery: [root]", {"recovery: of some sets requires domains: 1"}},
    {"[left.root, {",
     "[left.root, left.root, {",
     {"output.stress[1]: 'left.root' is listed twice"}},
    {"left.root", "floor", {"output.stress[0]: found 'floor', expected INSTANCE.SURFACE"}},
    {"elements: [3, 17]", "elements: [3, 3]", {"elements[1]: '3' is listed twice"}},
    {"elements: [3, 17], worst: 5, envelope: true",
     "envelope: false",
     {"output.stress[1]: names nothing to write"}},
    {"to_hz: 2125",
     "to_hz: 1",
     {"sweep.to_hz: found a frequency up to from_hz, expected one above it"}},
    {"spacing: log", "spacing: octaves", {"sweep.spacing: unknown value 'octaves'", "linear, log"}},
    {"as: mesh",
     "as: full",
     {"instances.right.as: unknown value 'full', allowed: superelement, mesh"}},
    {"mirror: x", "mirror: xy", {"allowed: x, y, z"}},
    {"enforcement: penalty",
     "enforcement: Penalty",
     {"did you mean 'penalty'? allowed: impulse, penalty, nodal"}},
    {"integrator: newmark", "integrator: euler", {"allowed: exact, central-difference, newmark"}},
    {"[displacement, stress, contact_pressure]",
     "[temperature]",
     {"output.fields[0]", "allowed: displacement, velocity, stress"}},
    {"[displacement, stress, contact_pressure]", "[stress, stress]", {"'stress' is listed twice"}},
    {"{every: 2.5e-7, file",
     "{every: 0, file",
     {"output.checkpoint.every", "expected a number above 0"}},
    {"{every: 2.5e-7, file",
     "{every_steps: 1.5, file",
     {"output.checkpoint.every_steps", "expected a whole number"}},
    {"{every: 2.5e-7, file", "{every_steps: 0, file", {"output.checkpoint.every_steps"}},
    {"{every: 2.5e-7, file",
     "{every_minutes: -1, file",
     {"output.checkpoint.every_minutes", "expected a number above 0"}},
    {"{every: 2.5e-7, file",
     "{every: 2.5e-7, every_steps: 3, file",
     {"output.checkpoint", "every", "every_steps", "exactly one"}},
    {"{every: 2.5e-7, file", "{file", {"output.checkpoint", "every_minutes"}},
    {"{every: 2.5e-7, file",
     "{evry: 2.5e-7, file",
     {"output.checkpoint.evry: unknown key 'evry', did you mean 'every'?"}},
    {"{every: 2.5e-7, file: keep/impact.h5}", "2.5e-7", {"output.checkpoint"}},
    // references
    {"    material: steel\n    blocks",
     "    material: stel\n    blocks",
     {"impact.yaml:7: components.block.material: unknown material 'stel', did you mean 'steel'? "
      "known: soft stuff, steel"}},
    {"{material: soft stuff, element: hex8, thickness: 0.0025}",
     "{material: rubber}",
     {"blocks.core.material: unknown material 'rubber'"}},
    {"component: plate",
     "component: plat",
     {"unknown component 'plat', did you mean 'plate'? known: bare, block, plate"}},
    {"component: bare}",
     "component: bare, as: superelement}",
     {"impact.yaml:29: instances.third.as", "has no 'reduction'"}},
    {"[left.contact, right.contact], form",
     "[lft.contact, right.contact], form",
     {"contact[0].between[0]: unknown instance 'lft', did you mean 'left'? known: right, left, "
      "third"}},
    {"[left.contact, right.contact], form",
     "[left.contact], form",
     {"has 1 surfaces, expected two"}},
    {"[left.contact, right.contact], form",
     "[left, right.contact], form",
     {"found 'left', expected INSTANCE.SURFACE or the name of a wall"}},
    {"[left.contact, right.contact], form",
     "[left., right.contact], form",
     {"expected INSTANCE.SURFACE"}},
    {"[left.contact, right.contact], form",
     "[left.contact, left.contact], form",
     {"cannot be in contact with itself"}},
    {"history: [left.contact, right.contact]",
     "history: [left.contact, left.contact]",
     {"output.history[1]: 'left.contact' is listed twice"}},
    {"history: [left.contact, right.contact]",
     "history: [middle.contact]",
     {"impact.yaml:50", "unknown instance 'middle'"}},
    {"instance: left, nodes",
     "instance: nobody, nodes",
     {"boundary[0].instance: unknown instance 'nobody'"}},
    // walls
    {"normal: [0, 3, 4]",
     "normal: [0, 0, 0]",
     {"impact.yaml:38: walls.floor.plane.normal: found [0, 0, 0], expected a direction: a vector "
      "that is not zero"}},
    {"normal: [0, 3, 4]",
     "normal: [0, 3, .nan]",
     {"walls.floor.plane.normal[2]: found '.nan', expected a finite number"}},
    {"normal: [0, 3, 4]",
     "normal: [0, 3]",
     {"walls.floor.plane.normal: found a list of 2, expected a list of three numbers"}},
    {", normal: [0, 3, 4]", "", {"walls.floor.plane: missing key 'normal'"}},
    {"normal: [0, 3, 4]",
     "normal: [0, 3, 4], inside: true",
     {"plane.inside: unknown key 'inside', allowed: point, normal"}},
    {"point: [0, 0, -0.25], ", "", {"walls.floor.plane: missing key 'point'"}},
    {"axis: [0, -2, 0]",
     "axis: [-0, 0.0, 0e5]",
     {"impact.yaml:40: walls.pipe.cylinder.axis: found [0, 0, 0]"}},
    {"axis: [0, -2, 0]",
     "axes: [0, -2, 0]",
     {"did you mean 'axis'? allowed: point, axis, radius, inside"}},
    {"radius: 12",
     "radius: 0",
     {"walls.pipe.cylinder.radius: found '0', expected a number above 0"}},
    {"radius: 12", "radius: -12", {"cylinder.radius", "above 0"}},
    {"radius: 1.5e-3",
     "radius: .inf",
     {"impact.yaml:39: walls.the ball.sphere.radius: found '.inf', expected a finite number"}},
    {"center: [1, 2, 3]",
     "centre: [1, 2, 3]",
     {"did you mean 'center'? allowed: center, radius, inside"}},
    {"1.5e-3, inside: true",
     "1.5e-3, inside: 1",
     {"sphere.inside: found '1', expected true or false"}},
    {"floor: {plane",
     "floor: {plain",
     {"walls.floor.plain: unknown key", "did you mean 'plane'? allowed: plane, sphere, cylinder"}},
    {"  pipe: {",
     "  pipe: {sphere: {center: [0, 0, 0], radius: 1}, ",
     {"walls.pipe: more than one of plane, sphere, cylinder"}},
    {"{cylinder: {point: [0, 0, 7], axis: [0, -2, 0], radius: 12, inside: true}}",
     "{}",
     {"walls.pipe: none of plane, sphere"}},
    {"  pipe: {",
     "  third: {",
     {"walls.third: an instance has the name 'third' too (line 29): give the wall another one"}},
    {"  pipe: {", "  pi.pe: {", {"the name of a wall holds a dot or a slash: 'pi.pe'"}},
    {"  pipe: {", "  floor: {", {"impact.yaml:40: walls.floor: duplicate key 'floor'"}},
    // contact
    {"[floor, left.contact]",
     "[flor, left.contact]",
     {"impact.yaml:44: contact[2].between[0]: found 'flor', expected INSTANCE.SURFACE or the name "
      "of a wall, did you mean 'floor'? "
      "walls: floor, the ball, pipe"}},
    {"[floor, left.contact]",
     "[floor, pipe]",
     {"'floor' and 'pipe' are both rigid walls, expected one surface of an instance"}},
    {"[floor, left.contact]", "[floor, floor]", {"'floor' cannot be in contact with itself"}},
    {"history: [left.contact, right.contact]",
     "history: [floor]",
     {"history[0]: found 'floor', expected INSTANCE.SURFACE"}},
    {"between: all",
     "between: every",
     {"contact[4].between: found 'every', expected all, or two surfaces"}},
    {"between: all", "between: {all: true}", {"contact[4].between: found a map, expected a list"}},
    {"[left.side, third.top]",
     "[right.a.b, left.top]",
     {"impact.yaml:45: contact[3]: [right.a.b, left.top] is listed twice (line 43 too), remove "
      "one"}},
    {"between: all, adjust: 0}",
     "between: all}\n  - {between: all, friction: 1}",
     {"impact.yaml:47: contact[5]: all is listed twice"}},
    {"formulation: two-way",
     "formulation: two_way",
     {"did you mean 'two-way'? allowed: node-face, two-way, mortar"}},
    {"two-way, enforcement: penalty, friction: 0.25, damping: 0.125",
     "two-way",
     {"contact[0].formulation: two-way needs 'enforcement: penalty'", "node-face"}},
    {"a.b], enforcement: nodal",
     "a.b], enforcement: nodal, formulation: mortar",
     {"contact[1].formulation: mortar is not available with 'enforcement: nodal'"}},
    {"friction: 0.375",
     "formulation: mortar",
     {"contact[2].formulation: 'floor' is a rigid wall", "only 'node-face'"}},
    {"friction: 0.375",
     "enforcement: penalty, formulation: two-way",
     {"contact[2].formulation: 'floor' is a rigid wall", "only 'node-face'"}},
    {"friction: 0.375",
     "tied: true",
     {"contact[2].tied: 'floor' is a rigid wall: nothing can be tied to it"}},
    {"friction: 0.375",
     "damping: 0.1",
     {"contact[2].damping: damping is that of the springs of 'enforcement: penalty'"}},
    {"damping: 0.125",
     "damping: -0.125",
     {"contact[0].damping: found '-0.125', expected a number from 0"}},
    {"damping: 0.125", "damping: .nan", {"contact[0].damping", "finite"}},
    {"adjust: 1.0e-5",
     "adjust: -1.0e-5",
     {"contact[2].adjust: found '-1.0e-5', expected a number from 0"}},
    {"adjust: 1.0e-5", "adjust: true", {"contact[2].adjust: found 'true', expected a number"}},
    {"tied: true", "tied: 2", {"contact[3].tied: found '2', expected true or false"}},
    {"tied: true",
     "tied: true, friction: 0.5",
     {"contact[3].friction: tied surfaces do not slide"}},
    {"tied: true", "tied: true, damping: 0.5", {"contact[3].damping: damping is that of"}},
    {"tied: true",
     "tied: true, enforcement: penalty",
     {"contact[3].enforcement: tied surfaces are held by 'enforcement: impulse'"}},
    {"tied: true", "tied: true, enforcement: nodal", {"contact[3].enforcement: tied surfaces"}},
    {"true, formulation: mortar",
     "true, formulation: two-way",
     {"contact[3].formulation: two-way needs 'enforcement: penalty'"}},
    {"tied: true", "tide: true", {"contact[3].tide: unknown key 'tide', did you mean 'tied'?"}},
    {"contact:\n  - {",
     "contact:\n  - 3\n  - {",
     {"contact[0]: found '3', expected a map with the keys between"}},
    // combinations
    {"modes: 80\n",
     "modes: 80\n      cutoff_hz: 1e6\n",
     {"components.block.reduction: more than one of modes, cutoff_hz, tolerance is given"}},
    {"      modes: 80\n",
     "      modes: 80\n      tolerance: 1.0e-3\n",
     {"more than one of modes, cutoff_hz, tolerance"}},
    {"      modes: 80\n",
     "      tolerance: 1.5\n",
     {"reduction.tolerance", "1.5", "between 0 and 1"}},
    {"      modes: 80\n",
     "",
     {"none of modes, cutoff_hz, tolerance is given, expected exactly one"}},
    {"      interface: [contact, \"two words\"]\n",
     "",
     {"components.block.reduction: missing key 'interface'"}},
    {"interface: [contact, \"two words\"]",
     "interface: [contact, contact]",
     {"'contact' is listed twice"}},
    {"interface: [contact, \"two words\"]", "interface: {contact: 1}", {"expected a list"}},
    {"traction: [-1, 0, 0]",
     "traction: [-1, 0, 0], force: [0, 0, 1]",
     {"loads[0]: more than one of traction, force, pressure, gravity"}},
    {"gravity: [0, 0, -9.81]",
     "gravity: [0, 0, -9.81], instance: left",
     {"gravity acts on everything"}},
    {"enforcement: nodal", "enforcement: nodal, friction: 0.1", {"knows no friction"}},
    {"superelement: ../out/block.h5",
     "superelement: plate.cbr.h5",
     {"is also that of component 'block'"}},
    {"{mesh: bare.msh, blocks: {all: {material: steel}}}",
     "{mesh: bare.msh}",
     {"components.bare: missing key 'material'"}},
    {"{mesh: bare.msh, blocks: {all: {material: steel}}}",
     "{mesh: bare.msh, blocks: {all: {element: hex8}}}",
     {"components.bare.blocks.all: missing key 'material'"}},
    // shapes
    {"  steel: {youngs_modulus: 5.17e12, poissons_ratio: 0.3, density: 7836}",
     "  steel: 5.17e12",
     {"impact.yaml:2: materials.steel: found '5.17e12', expected a map with the keys "
      "youngs_modulus"}},
    {"instances:\n  right:", "instances:\n  ri.ght:", {"holds a dot or a slash"}},
    {"surfaces: [contact]", "surfaces: []", {"skin.surfaces: is empty"}},
    {"mesh: meshes/block.msh", "mesh: ''", {"components.block.mesh: found an empty word"}},
    {"mesh: meshes/block.msh", "mesh:", {"components.block.mesh: found nothing, expected a word"}},
    {"boundary:\n  - {instance: left, nodes: clamp, fix: [x, z], rotations: [y], velocity: "
     "[0.5, 0, 2], angular_velocity: [0, 3, 0], about: [1, 2, 3], history: "
     "{time: [0, 1e-6, 3e-6], value: [0, 1, 0]}}",
     "boundary: {instance: left}",
     {"boundary: found a map, expected a list"}},
    {"  steel:", "  [a]:", {"impact.yaml:2: materials: a key is not a plain word"}},
    {"time: {end", "time: {<<: 1, end", {"time: merge key"}},
};

INSTANTIATE_TEST_SUITE_P(All, SceneMistake, testing::ValuesIn(mistakes));

TEST(SceneErrors, wholeFiles) {
  const TemporaryFolder folder;
  const auto starts = [&](const std::string& text, const std::string& start) {
    const std::string message = refusal(folder, text);
    EXPECT_EQ(message.substr(0, start.size()), start) << message;
  };
  starts("", "impact.yaml: is empty");
  starts("# only a comment\n", "impact.yaml: is empty");
  starts("{}", "impact.yaml:1: missing key 'materials'");
  starts("just words", "impact.yaml:1: found 'just words', expected a map with the keys materials");
  starts("- a\n- b\n", "impact.yaml:1: found a list, expected a map");
  starts("a: [1, 2\nb: {", "impact.yaml:");
  starts("a: 1\n\tb: 2\n", "impact.yaml:2: is not valid YAML");
  starts(
      full_scene + "---\n" + full_scene,
      "impact.yaml:" + std::to_string(std::count(full_scene.begin(), full_scene.end(), '\n') + 1) +
          ": a second YAML document");
  starts("]", "impact.yaml:1: ");
  starts(", w], x: 1", "impact.yaml:1: ");
  starts("{a: 1}]", "impact.yaml:1: ");
  starts(std::string("materials\0: {}", 14), "impact.yaml: is not a text file");
  starts("materials: {}\ncomponents: {}\n", "impact.yaml:1: materials: is empty");
  starts(
      "materials: {m: {youngs_modulus: 1, poissons_ratio: 0, density: 1}}\ncomponents: {a: {mesh: "
      "a.msh, material: m}}\n"
      "contact: any\n",
      "impact.yaml:3: contact: found 'any', expected all, or a list of {between: ...}");
  starts("materials: *unknown\n", "impact.yaml:1: is not valid YAML");
  starts(std::string(200000, '[') + std::string(200000, ']'), "impact.yaml:");
  starts(std::string(100000, '{'), "impact.yaml:");
  starts("materials: &a {<<: *a}\n", "impact.yaml:");
  starts("materials: &a {m: {<<: *a}}\n", "impact.yaml:");
}

TEST(SceneErrors, filesThatCannotBeRead) {
  const TemporaryFolder folder;
  EXPECT_THROW(read_scene((folder / "missing.yaml").string()), InputError);
  EXPECT_THROW(read_scene(folder.path().string()), InputError);
  EXPECT_THROW(read_scene(""), InputError);
}

TEST(SceneErrors, filesWithoutEndAndLinksThatLeadNowhere) {
  const TemporaryFolder folder;
  const auto message = [&](const std::string& file) -> std::string {
    try {
      read_scene(file);
      return "read";
    } catch (const InputError& error) {
      return error.what();
    }
  };
  const auto says = [&](const std::string& file, const std::string& part) {
    EXPECT_NE(message(file).find(part), std::string::npos) << message(file);
  };
  std::filesystem::create_symlink("/dev/zero", folder / "zero.yaml");
  says((folder / "zero.yaml").string(), "zero.yaml: is not a text file");
  test::write_bytes(folder / "sparse.yaml", "");
  std::filesystem::resize_file(folder / "sparse.yaml", 1'000'000'001);
  says((folder / "sparse.yaml").string(), "is of 1000000001 bytes, a scene has at most 1 GB");
  std::filesystem::create_symlink("loop.yaml", folder / "loop.yaml");
  says((folder / "loop.yaml").string(), "loop.yaml: cannot be opened: ");
  says("", "an empty name");
}

// The parser's own words for these are "illegal map value" and "bad file".
TEST(SceneErrors, slipsOfYamlNameTheirCure) {
  const TemporaryFolder folder;
  const auto says = [&](const std::string& text, const std::string& start,
                        const std::string& part) {
    const std::string message = refusal(folder, text);
    EXPECT_EQ(message.substr(0, start.size()), start) << message;
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  says("time:\n\tend: 1\n", "impact.yaml:2: ", "replace tabs by spaces");
  says("time:\n  end: 1\n\tstep: 2\n", "impact.yaml:3: ", "replace tabs by spaces");
  says("a: 1\n" + std::string(1100, 'k') + ": 2\n",
       "impact.yaml:2: ", "a key has at most 1024 characters");
  says("a: 1\nb:\n  " + std::string(500, '['), "impact.yaml:3: ", "more than 100 deep");
  says("a: 1\nb:\n  " + std::string(500, '{'), "impact.yaml:3: ", "more than 100 deep");
}

// Whatever an editor's slip, a cut or a broken transfer makes of a scene: read, or refused in
// words.
TEST(SceneErrors, noDamageDoesMoreThanBeRefused) {
  const TemporaryFolder folder;
  std::mt19937 random(3);
  const std::string bytes = "{}[]:,-#&*!|>'\"%@`\n\t .0e+\xff\x80~<";
  int refused = 0;
  constexpr int trials = 1000;
  for (int trial = 0; trial < trials; ++trial) {
    std::string text = full_scene;
    for (int change = 0; change <= trial % 4 && !text.empty(); ++change) {
      const std::size_t at = random() % text.size();
      switch (random() % 4) {
        case 0:
          text[at] = bytes[random() % bytes.size()];
          break;
        case 1:
          text.erase(at, 1 + random() % 8);
          break;
        case 2:
          text.insert(at, 1, bytes[random() % bytes.size()]);
          break;
        default:
          text.resize(at + 1);
          break;
      }
    }
    if (!refusal(folder, text).empty()) {
      ++refused;
      continue;
    }
    const std::string once = written(read_text(folder, text));  // what is accepted can be handed on
    EXPECT_EQ(written(read_text(folder, once)), once);
  }
  EXPECT_GT(refused, trials / 2);
}

}  // namespace
}  // namespace cbr::scene_errors_test
