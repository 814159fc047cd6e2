// SPDX-License-Identifier: GPL-3.0-or-later
// What random scenes do with their reduced bodies beyond Craig-Bampton in one piece.
#include <algorithm>

#include "tests/stability/random_dice.hpp"
#include "tests/stability/random_scene.hpp"

namespace cbr::test {
namespace {

bool is_of(const RandomBody& body, const std::string& name) {
  return name.substr(0, name.find('.')) == body.name;
}

bool is_held(const RandomScene& scene, const RandomBody& body) {
  return std::any_of(scene.held.begin(), scene.held.end(),
                     [&](const auto& name) { return is_of(body, name); });
}

void erase_all(std::string& text, const std::string& words) {
  for (auto at = text.find(words); at != std::string::npos; at = text.find(words))
    text.erase(at, words.size());
}

// Of pairs that `body` is in, of all without one: no springs.
void take_impulses(RandomScene& scene, const RandomBody* body) {
  for (RandomPair& pair : scene.pairs) {
    if (body != nullptr && !is_of(*body, pair.first) && !is_of(*body, pair.second)) continue;
    for (const char* words : {", enforcement: penalty", ", damping: 0.1", ", formulation: two-way"})
      erase_all(pair.options, words);
  }
}

// Free modes leave the interface of c dofs a compliance of its own while they and the 6 rigid
// motions are no more than the interior's dofs, and a compliance far above round-off while they are
// far fewer.
void make_massless(Dice& dice, RandomScene& scene, RandomBody& b) {
  const Index n = interior_dofs(b);
  if (n < 24) return;  // as it was
  constexpr const char* ways[] = {"free", "tapered"};
  b.basis = "massless";
  b.reduction = std::string("massless_modes: ") + ways[dice.below(2)];
  b.modes = dice.below(std::min<Index>(16, n / 2 - 6) + 1);
  b.pick = "frequency";
  // No force but impulses, and no step but an explicit one, finds an interface without mass
  if (scene.integrator == "newmark")
    scene.integrator = dice.once_in(2) ? "exact" : "central-difference";
  take_impulses(scene, &b);
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return "[" + text + "]";
}

// Fewer of the interface's own modes than there are dofs to reduce, with statics of
// its two faces or of those that contact names.
void make_characteristic(Dice& dice, const RandomScene& scene, RandomBody& b) {
  const Index n_interface = 3 * b.mesh.coordinates.rows() - interior_dofs(b);
  std::vector<std::string> keep;
  const bool held = is_held(scene, b);
  if (held) keep.push_back("three");  // three nodes of x_max
  if (dice.once_in(2)) keep.push_back(dice.once_in(2) ? "x_min" : "x_max");
  RandomBody kept = b;
  kept.interface_sets = keep;
  const Index left =
      n_interface - (keep.empty() ? 6 : 3 * b.mesh.coordinates.rows() - interior_dofs(kept));
  if (left < 3) return;  // all of it is kept
  b.basis = "characteristic";
  b.reduction =
      "characteristic: {modes: " + std::to_string(dice.below(std::min<Index>(left - 1, 15)));
  if (!keep.empty()) b.reduction += ", keep: " + listed(keep);
  if (dice.once_in(2)) {
    b.reduction += ", statics: [x_min, x_max]";
    if (dice.once_in(3)) b.reduction += ", shear: true";
  }
  b.reduction += "}";
}

// The domains depend on the order of the elements: only of all their modes, however many, the
// answer does not.
void make_domains(Dice& dice, RandomScene& scene, RandomBody& b) {
  b.domains = 2 + dice.below(2);
  if (b.shape.n[0] * b.shape.n[1] * b.shape.n[2] < 3) b.domains = 2;
  const bool all = !dice.once_in(3);
  const Index n = interior_dofs(b);
  if (all) {
    b.modes = n;
    b.pick = "frequency";
  }
  if (all && n > 0 && dice.once_in(2)) b.second_modes = dice.once_in(3) ? n : 1 + dice.below(n);
  if (!all) scene.keeps_numbers = true;
}

// On a side of the part that the interface leaves out.
void load_inside(Dice& dice, RandomScene& scene, RandomBody& b) {
  RandomLoad load;
  load.kind = dice.once_in(2) ? "traction" : "force";
  load.value = dice.vector(2);
  load.instance = b.name;
  constexpr const char* sides[] = {"y_min", "z_min", "z_max"};
  load.surface = sides[dice.below(3)];
  if (dice.once_in(2)) {
    load.time = {0, 0.3 * scene.end, 0.6 * scene.end};
    load.factor = {0, 1, dice.uniform(-1, 1)};
  }
  scene.loads.push_back(load);
  scene.loads_inside = true;
}

bool has_shells(const RandomScene& scene, const RandomBody& b) {
  return scene.skin && is_of(b, *scene.skin);
}

}  // namespace

RandomScene random_scene_of_bases(unsigned seed) {
  RandomScene scene = random_scene(seed);
  Dice dice(seed ^ 0x9e3779b9U);
  for (RandomBody& b : scene.bodies) {
    b.reduced = b.reduced || !dice.once_in(3);
    if (!b.reduced) continue;
    const bool is_kept = std::find(b.interface_sets.begin(), b.interface_sets.end(), "three") !=
                         b.interface_sets.end();
    if (is_held(scene, b) && !is_kept) b.interface_sets.push_back("three");
    b.modes = std::min(b.modes, interior_dofs(b));
    switch (dice.below(5)) {
      case 0:
        if (!has_shells(scene, b)) make_massless(dice, scene, b);
        break;
      case 1:
        if (!has_shells(scene, b)) make_characteristic(dice, scene, b);
        break;
      case 2:
        make_domains(dice, scene, b);
        break;
      case 3:
        load_inside(dice, scene, b);
        break;
      default:
        break;
    }
  }
  if (scene.integrator == "exact" && !scene.loads_inside && dice.once_in(2)) {
    scene.cfl = dice.uniform(0.9, 4);
    take_impulses(scene, nullptr);
  }
  return scene;
}

}  // namespace cbr::test
