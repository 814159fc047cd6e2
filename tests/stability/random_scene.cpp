// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/stability/random_scene.hpp"

#include <algorithm>
#include <cmath>

#include "tests/stability/random_dice.hpp"

namespace cbr::test {
namespace {

constexpr CellKind kinds[] = {{ElementType::hex8},
                              {ElementType::hex20},
                              {ElementType::hex27},
                              {ElementType::tet4},
                              {ElementType::tet10},
                              {ElementType::wedge6},
                              {ElementType::pyramid5},
                              {ElementType::pyramid5, ElementType::hex8},
                              {ElementType::wedge6, ElementType::hex8},
                              {ElementType::wedge15}};

std::string name_of(const CellKind& kind) {
  const std::string even(name(kind.even)), odd(name(kind.odd));
  return odd == even ? even : odd + "+" + even;
}

std::function<Vector3(const Vector3&)> warp(Dice& dice, double amount) {
  const Vector3 wave = dice.vector(2), phase = dice.vector(3), tilt = dice.vector(0.1);
  return [=](const Vector3& p) {
    const Vector3 wiggle(std::sin(wave[0] * p[1] + wave[1] * p[2] + phase[0]),
                         std::sin(wave[1] * p[2] + 2 * p[0] + phase[1]),
                         std::sin(wave[2] * p[0] + 2 * p[1] + phase[2]));
    return Vector3(p + amount * wiggle + Vector3(0, tilt[0] * p[0], tilt[1] * p[1]));
  };
}

Material material(Dice& dice) {
  return {100 * dice.uniform(0.6, 1.4), dice.uniform(0, 0.4), dice.uniform(0.7, 1.3)};
}

RandomBody random_body(Dice& dice, const std::string& name) {
  RandomBody b;
  b.name = name;
  b.shape.kind = kinds[dice.below(std::size(kinds))];
  const bool many =
      b.shape.kind.odd != ElementType::hex8 || b.shape.kind.even == ElementType::pyramid5;
  for (Index& n : b.shape.n) n = many ? 1 + dice.below(2) : 1 + dice.below(3);
  if (b.shape.n[0] * b.shape.n[1] * b.shape.n[2] == 1) b.shape.n[0] = 2;
  b.shape.map = warp(dice, dice.uniform(0, 0.04));
  b.mesh = lattice_mesh(b.shape);
  b.low = material(dice);
  b.high = dice.once_in(2) ? material(dice) : b.low;
  constexpr const char* formulations[] = {"hex8-incompatible", "hex8", "hex8-hourglass"};
  b.element = formulations[dice.below(3)];
  b.mass = dice.once_in(3) ? "consistent" : "lumped";
  b.reduced = dice.once_in(2);
  b.interface_sets = {"x_min", "x_max"};
  if (dice.once_in(3)) b.interface_sets.push_back("y_max");
  if (dice.once_in(4)) b.interface_sets.push_back("three");
  const Index n_interior = interior_dofs(b);
  b.modes = dice.once_in(4)   ? 0
            : dice.once_in(3) ? n_interior
                              : std::min(n_interior, 1 + dice.below(12));
  b.pick = dice.once_in(3) ? "participation" : "frequency";
  return b;
}

std::string options(Dice& dice, const std::string& integrator, bool wall) {
  std::string text;
  const bool penalty = integrator != "newmark" && dice.once_in(3);
  if (penalty)
    text += ", enforcement: penalty" + std::string(dice.once_in(2) ? ", damping: 0.1" : "");
  if (!wall && penalty && dice.once_in(2)) text += ", formulation: two-way";
  if (!wall && !penalty && dice.once_in(3)) text += ", formulation: mortar";
  if (dice.once_in(3)) text += ", friction: " + test::text(dice.uniform(0.1, 0.5));
  return text;
}

void add_wall(Dice& dice, RandomScene& scene) {
  const RandomBody& a = scene.bodies.front();
  RandomWall wall{"wall", "plane", Vector3::Zero(), Vector3::UnitX(), 0};
  // In front of the lowest point of face x_min, leaning a little
  double low = HUGE_VAL;
  for (const Index node : set_nodes(a.mesh, "x_min"))
    low = std::min(low, (a.rotation * a.mesh.coordinates.row(node).transpose() + a.position)[0]);
  const double gap = dice.uniform(0.005, 0.03);
  wall.direction = (Vector3::UnitX() + dice.vector(0.05)).normalized();
  wall.point = Vector3(low - gap - 0.05, 0.5, 0.5);
  if (const Index kind = dice.below(4); kind > 1) {
    wall.kind = kind == 2 ? "sphere" : "cylinder";
    wall.radius = dice.uniform(1, 3);
    wall.point -= Vector3(wall.radius - 0.05, 0, 0);
    if (kind == 3) wall.direction = (Vector3::UnitZ() + dice.vector(0.2)).normalized();
  }
  scene.walls.push_back(wall);
  scene.pairs.push_back({"a.x_min", "wall", options(dice, scene.integrator, true)});
  scene.bodies.front().velocity = Vector3(-1, 0, 0) + dice.vector(0.2);
}

// The second body is turned and moved until it stands in front of the first one's face x_max.
void add_second(Dice& dice, RandomScene& scene) {
  RandomBody b = random_body(dice, "b");
  const RandomBody& a = scene.bodies.front();
  b.rotation = dice.rotation(0.1);
  double high = -HUGE_VAL, low = HUGE_VAL;
  for (const Index node : set_nodes(a.mesh, "x_max"))
    high = std::max(high, (a.rotation * a.mesh.coordinates.row(node).transpose() + a.position)[0]);
  for (const Index node : set_nodes(b.mesh, "x_min"))
    low = std::min(low, (b.rotation * b.mesh.coordinates.row(node).transpose())[0]);
  b.position = Vector3(high - low + dice.uniform(0.003, 0.02), dice.uniform(-0.3, 0.3),
                       dice.uniform(-0.3, 0.3));
  b.velocity = Vector3(-1, 0, 0) + dice.vector(0.2);
  scene.bodies.push_back(std::move(b));
  scene.pairs.push_back({"a.x_max", "b.x_min", options(dice, scene.integrator, false)});
}

void add_load(Dice& dice, RandomScene& scene) {
  RandomLoad load;
  const Index kind = dice.below(3);
  load.kind = kind == 0 ? "traction" : kind == 1 ? "force" : "gravity";
  load.value = dice.vector(kind == 2 ? 5 : 2);
  if (kind < 2) {
    load.instance = scene.bodies[dice.below(static_cast<Index>(scene.bodies.size()))].name;
    load.surface = dice.once_in(2) ? "x_min" : "x_max";
  }
  if (dice.once_in(2)) {
    const double t = 0.3 * scene.end;
    load.time = {0, dice.uniform(0.2, 0.8) * t, t, 2 * t};
    load.factor = {0, 1, dice.uniform(-1, 1), 0};
  }
  scene.loads.push_back(load);
}

std::string list(const std::vector<double>& values, double unit) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + test::text(value * unit);
  return "[" + text + "]";
}

std::string material_text(const std::string& name, const Material& m, const Change& change) {
  return "  " + name + ": {youngs_modulus: " +
         text(m.youngs_modulus * change.force() / std::pow(change.length, 2)) +
         ", poissons_ratio: " + text(m.poissons_ratio) +
         ", density: " + text(m.density * change.mass / std::pow(change.length, 3)) + "}\n";
}

std::string component_text(const RandomBody& b) {
  std::string text =
      "  c_" + b.name + ": {mesh: " + b.name + ".exo, material: m_" + b.name + "_low, blocks: {";
  std::string blocks;
  for (const Block& block : b.mesh.blocks)
    blocks += (blocks.empty() ? "" : ", ") + block.name + ": {material: m_" + b.name + "_" +
              block.name.substr(0, block.name.find('_')) + "}";
  text += blocks + "}, element: " + b.element + ", mass: " + b.mass;
  if (!b.reduced) return text + "}\n";
  text += ", reduction: {basis: " + b.basis + (b.reduction.empty() ? "" : ", " + b.reduction) +
          ", modes: " + std::to_string(b.modes) + ", pick: " + b.pick + ", interface: [";
  for (const auto& set : b.interface_sets)
    text += set + (&set == &b.interface_sets.back() ? "]" : ", ");
  if (b.domains > 1) text += ", domains: " + std::to_string(b.domains);
  if (b.second_modes)
    text += ", second_reduction: {modes: " + std::to_string(*b.second_modes) + "}";
  return text + "}}\n";
}

std::string instance_text(const RandomBody& b, const Change& change, bool in_place) {
  const bool mirrored = change.S.determinant() < 0;
  const Matrix3 M = mirrored ? Matrix3(Vector3(-1, 1, 1).asDiagonal()) : Matrix3::Identity();
  std::string text = "  " + b.name + ": {component: c_" + b.name +
                     ", as: " + (b.reduced ? "superelement" : "mesh") +
                     ", velocity: " + test::text(change.velocity(b.velocity));
  if (!in_place)
    text += ", position: " + test::text(change.point(b.position)) +
            ", rotation: " + test::text(degrees(change.S * b.rotation * M)) +
            (mirrored ? ", mirror: x" : "");
  return text + "}\n";
}

std::string wall_text(const RandomWall& w, const Change& change) {
  std::string text = "  " + w.name + ": {" + w.kind + ": {" +
                     (w.kind == "sphere" ? "center: " : "point: ") +
                     test::text(change.point(w.point));
  if (w.kind == "plane") text += ", normal: " + test::text(change.direction(w.direction));
  if (w.kind == "cylinder") text += ", axis: " + test::text(change.direction(w.direction));
  if (w.kind != "plane") text += ", radius: " + test::text(change.length * w.radius);
  return text + "}}\n";
}

std::string load_text(const RandomLoad& load, const Change& change) {
  const double unit = load.kind == "traction" ? change.force() / std::pow(change.length, 2)
                      : load.kind == "force"  ? change.force()
                                              : change.speed() / change.time;
  std::string text = "  - {";
  if (load.kind != "gravity")
    text += "instance: " + load.instance + ", surface: " + load.surface + ", ";
  text += load.kind + ": " + test::text(Vector3(unit * change.direction(load.value)));
  if (!load.time.empty())
    text += ", history: {time: " + list(load.time, change.time) +
            ", value: " + list(load.factor, 1) + "}";
  return text + "}\n";
}

}  // namespace

Index interior_dofs(const RandomBody& body) {
  std::vector<char> kept(body.mesh.coordinates.rows(), 0);
  for (const auto& set : body.interface_sets)
    for (const Index node : set_nodes(body.mesh, set)) kept[node] = 1;
  return 3 * std::count(kept.begin(), kept.end(), 0);
}

bool RandomScene::has(const std::string& option) const {
  return std::any_of(pairs.begin(), pairs.end(), [&](const RandomPair& pair) {
    return pair.options.find(option) != std::string::npos;
  });
}

std::string RandomScene::text() const {
  std::string words = integrator;
  for (const RandomBody& b : bodies)
    words +=
        "; " + b.name + ": " + name_of(b.shape.kind) + " " + b.mass +
        (b.reduced ? " " + b.basis + " " + b.reduction + " " + std::to_string(b.modes) + " modes" +
                         (b.domains > 1 ? " of " + std::to_string(b.domains) + " domains" : "") +
                         (b.second_modes ? " and again " + std::to_string(*b.second_modes) : "")
                   : " full");
  for (const RandomWall& wall : walls) words += "; " + wall.kind;
  for (const RandomPair& pair : pairs)
    words += "; " + pair.first + " - " + pair.second + pair.options;
  for (const RandomLoad& load : loads)
    words += "; " + load.kind +
             (load.surface.empty() ? "" : " on " + load.instance + "." + load.surface);
  if (cfl > 1) words += "; " + test::text(cfl) + " critical steps";
  for (const auto& name : held) words += "; held " + name;
  return words + (skin ? "; skin" : "");
}

RandomScene random_scene(unsigned seed) {
  Dice dice(seed);
  RandomScene scene;
  scene.seed = seed;
  constexpr const char* integrators[] = {"exact", "central-difference", "newmark", "exact"};
  scene.integrator = integrators[dice.below(4)];
  scene.end = 0.24;
  scene.every = 0.08;
  scene.bodies.push_back(random_body(dice, "a"));
  scene.bodies[0].rotation = dice.rotation(0.2);
  scene.bodies[0].velocity = Vector3(0.5, 0, 0) + dice.vector(0.2);
  if (dice.once_in(2)) add_wall(dice, scene);
  if (scene.walls.empty() || dice.once_in(2)) add_second(dice, scene);
  for (Index n = dice.below(3); n > 0; --n) add_load(dice, scene);
  RandomBody& last = scene.bodies.back();
  if (dice.once_in(4)) {
    scene.held.push_back(last.name + ".three");
    if (last.reduced && std::find(last.interface_sets.begin(), last.interface_sets.end(),
                                  "three") == last.interface_sets.end())
      last.interface_sets.push_back("three");
    last.modes = std::min(last.modes, interior_dofs(last));
    last.velocity.setZero();
    // or nothing would move
    if (scene.bodies.size() == 1)
      scene.loads.push_back({"", "", "gravity", Vector3(-8, 1, 2), {}, {}});
  }
  if (dice.once_in(6)) scene.skin = last.name + ".x_max";
  return scene;
}

std::string yaml(const RandomScene& scene, const Change& change) {
  std::string materials = "materials:\n", components = "components:\n", instances = "instances:\n",
              walls, contact, loads, held, history;
  for (const RandomBody& b : scene.bodies) {
    materials += material_text("m_" + b.name + "_low", b.low, change) +
                 material_text("m_" + b.name + "_high", b.high, change);
    components += component_text(b);
    instances += instance_text(b, change, scene.in_place);
    history += (history.empty() ? "" : ", ") + b.name + ".x_min, " + b.name + ".x_max";
  }
  for (const RandomWall& wall : scene.walls) walls += wall_text(wall, change);
  for (const RandomPair& pair : scene.pairs)
    contact += "  - {between: [" + pair.first + ", " + pair.second + "]" + pair.options + "}\n";
  for (const RandomLoad& load : scene.loads) loads += load_text(load, change);
  for (const std::string& name : scene.held)
    held += "  - {instance: " + name.substr(0, name.find('.')) +
            ", nodes: " + name.substr(name.find('.') + 1) + ", fix: [x, y, z]}\n";
  std::string text = materials + components + instances;
  if (!walls.empty()) text += "walls:\n" + walls;
  if (!held.empty()) text += "boundary:\n" + held;
  if (!loads.empty()) text += "loads:\n" + loads;
  if (!contact.empty()) text += "contact:\n" + contact;
  if (scene.skin)
    text += "skin: {surfaces: [" + *scene.skin + "], youngs_modulus: " +
            test::text(random_skin.material.youngs_modulus * change.force() /
                       std::pow(change.length, 2)) +
            ", poissons_ratio: " + test::text(random_skin.material.poissons_ratio) + ", density: " +
            test::text(random_skin.material.density * change.mass / std::pow(change.length, 3)) +
            ", thickness: " + test::text(random_skin.thickness * change.length) + "}\n";
  return text + "time: {end: " + test::text(change.time * scene.end) +
         ", step: {cfl: " + test::text(scene.cfl) + "}, integrator: " + scene.integrator +
         "}\noutput: {every: " + test::text(change.time * scene.every) + ", history: [" + history +
         "]}\n";
}

Ran run_in(SceneFolder& folder, const RandomScene& scene, const Change& change, bool both_sides) {
  for (const RandomBody& b : scene.bodies) {
    Mesh mesh = b.mesh;
    mesh.coordinates *= change.length;
    if (scene.in_place)
      mesh.coordinates = ((mesh.coordinates * (change.S * b.rotation).transpose()).rowwise() +
                          change.point(b.position).transpose())
                             .eval();
    folder.add(b.name + ".exo", mesh);
  }
  set_threads(scene.threads);
  Ran ran = folder.prepare(yaml(scene, change));
  ran.built.simulation.detection.both_sides = both_sides;
  ran.result = cbr::run(ran.built.simulation);
  return ran;
}

Ran run(const RandomScene& scene, const Change& change) {
  SceneFolder folder;
  return run_in(folder, scene, change);
}

}  // namespace cbr::test
