// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <charconv>
#include <ostream>

#include "common/base/error.hpp"
#include "common/base/number_text.hpp"
#include "common/scene/reduction_keys.hpp"
#include "common/scene/scene.hpp"
#include "common/scene/scene_words.hpp"

namespace cbr {
namespace {

// Words that YAML readers, ours and others, take for something else than text.
bool is_reserved(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const char* word : {"true", "false", "yes", "no", "on", "off", "null", "n"}) {
    if (text == word) return true;
  }
  return false;
}

bool is_plain(const std::string& text) {
  const auto is_letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
  };
  if (text.empty() || is_reserved(text) || !(is_letter(text[0]) || text[0] == '/')) return false;
  return std::all_of(text.begin(), text.end(), [&](char c) {
    return is_letter(c) || (c >= '0' && c <= '9') || c == '/' || c == '.' || c == '-';
  });
}

std::string word(const std::string& text) {
  if (is_plain(text)) return text;
  constexpr const char* digits = "0123456789abcdef";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (code < 0x20 || code == 0x7f) {
      quoted += "\\x";
      quoted += digits[code >> 4];
      quoted += digits[code & 15];
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string list(const std::vector<std::string>& items) { return "[" + join(items) + "]"; }

std::string words(const std::vector<std::string>& texts) {
  std::vector<std::string> items;
  for (const auto& text : texts) items.push_back(word(text));
  return list(items);
}

std::string numbers(const std::vector<double>& values) {
  std::vector<std::string> items;
  for (const double value : values) items.push_back(number_text(value));
  return list(items);
}

std::string vector(const Vector3& v) { return numbers({v(0), v(1), v(2)}); }

// {key: value, ...}, in the order of the calls.
class FlowMap {
 public:
  FlowMap& add(const std::string& key, const std::string& value) {
    items_.push_back(key + ": " + value);
    return *this;
  }
  FlowMap& add_if(bool condition, const std::string& key, const std::string& value) {
    return condition ? add(key, value) : *this;
  }
  std::string text() const { return "{" + join(items_) + "}"; }

 private:
  std::vector<std::string> items_;
};

std::string path(const std::filesystem::path& file) {
  return word(std::filesystem::absolute(file).lexically_normal().string());
}

// What the table says of the options, a map of their own on one line. Pick, domains and recovery
// always, so that the scene says what is done.
bool is_written(const ReductionKey& key, const ReductionOptions& reduction) {
  if (!key.goes_with(reduction.basis)) return false;
  if (key.key == "characteristic.modes") return !reduction.characteristic.is_default_modes;
  if (key.key == "characteristic.shear") return reduction.characteristic.shear;
  if (key.key == "condense_rotations") return reduction.condenses_rotations;
  if (key.key == "pick") return !reduction.tolerance;
  const bool is_needed = key.key == "interface" && reduction.interface_points.empty();
  return is_needed || !words_of(key, reduction).empty();
}

std::string written(const ReductionKey& key, const ReductionOptions& reduction) {
  const std::vector<std::string> found = words_of(key, reduction);
  const auto* some = std::get_if<NamesOrTrue>(&key.value);
  ReductionOptions copy = reduction;
  const bool are_names = std::holds_alternative<NameList>(key.value) ||
                         (some != nullptr && !some->names(copy).empty());
  return are_names ? words(found) : found.front();
}

void write_reduction(const ReductionOptions& reduction, std::ostream& out) {
  out << "    reduction:\n";
  for (const std::string& name : keys_of_reduction()) {
    FlowMap map;
    bool has_map = false;
    for (const ReductionKey& key : reduction_keys()) {
      const auto dot = key.key.find('.');
      if (key.key.substr(0, dot) != name || !is_written(key, reduction)) continue;
      has_map = dot != std::string::npos;
      if (has_map) map.add(key.key.substr(dot + 1), written(key, reduction));
      if (!has_map) out << "      " << name << ": " << written(key, reduction) << "\n";
    }
    if (has_map) out << "      " << name << ": " << map.text() << "\n";
  }
  out << "      superelement: " << path(reduction.superelement) << "\n";
}

void write_component(const Component& component, std::ostream& out) {
  out << "  " << word(component.name) << ":\n";
  if (!component.has_mesh) {
    out << "    superelement: " << path(component.reduction->superelement) << "\n";
    return;
  }
  out << "    mesh: " << path(component.mesh) << "\n";
  if (!component.material.empty()) out << "    material: " << word(component.material) << "\n";
  if (!component.blocks.empty()) out << "    blocks:\n";
  for (const auto& [block, options] : component.blocks) {
    FlowMap map;
    map.add_if(!options.material.empty(), "material", word(options.material));
    if (options.element) map.add("element", word_of(hex8_words, *options.element));
    if (options.thickness) map.add("thickness", number_text(*options.thickness));
    out << "      " << word(block) << ": " << map.text() << "\n";
  }
  out << "    element: " << word_of(hex8_words, component.element) << "\n";
  out << "    mass: " << word_of(mass_words, component.mass) << "\n";
  if (!component.points.empty()) out << "    points:\n";
  for (const auto& [name, point] : component.points) {
    FlowMap map;
    map.add("surface", word(point.nodes));
    if (point.at) map.add("at", vector(*point.at));
    map.add_if(point.rigid, "coupling", "rigid");
    if (point.mass > 0) map.add("mass", number_text(point.mass));
    const Matrix3& J = point.inertia;
    if (!J.isZero(0))
      map.add("inertia", numbers({J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(1, 2), J(0, 2)}));
    out << "      " << word(name) << ": " << map.text() << "\n";
  }
  if (component.reduction) write_reduction(*component.reduction, out);
}

void write_instance(const Instance& instance, std::ostream& out) {
  FlowMap map;
  map.add("component", word(instance.component)).add("as", word_of(instance_words, instance.as));
  map.add("position", vector(instance.position)).add("rotation", vector(instance.rotation_degrees));
  map.add_if(!instance.mirror.empty(), "mirror", instance.mirror)
      .add("velocity", vector(instance.velocity));
  if (!instance.damping.empty()) {
    FlowMap damping;
    damping.add("frequency_hz", numbers(instance.damping.frequency_hz))
        .add("ratio", numbers(instance.damping.ratio));
    map.add("damping", damping.text());
  }
  map.add_if(!instance.angular_velocity.isZero(0), "angular_velocity",
             vector(instance.angular_velocity));
  out << "  " << word(instance.name) << ": " << map.text() << "\n";
}

void write_skin(const SkinOptions& skin, std::ostream& out) {
  FlowMap map;
  map.add("surfaces", words(skin.surfaces)).add("youngs_modulus", number_text(skin.youngs_modulus));
  map.add("poissons_ratio", number_text(skin.poissons_ratio))
      .add("density", number_text(skin.density));
  map.add("thickness", number_text(skin.thickness)).add("mesh", path(skin.mesh));
  out << "skin: " << map.text() << "\n";
}

FlowMap& add_history(const History& history, FlowMap& map) {
  if (history.time.empty()) return map;
  return map.add(
      "history",
      FlowMap().add("time", numbers(history.time)).add("value", numbers(history.value)).text());
}

std::string boundary_text(const BoundaryCondition& condition) {
  std::vector<std::string> axes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (condition.fix[axis]) axes.push_back(std::string(1, "xyz"[axis]));
  }
  FlowMap map;
  map.add("instance", word(condition.instance))
      .add("nodes", word(condition.nodes))
      .add("fix", list(axes));
  if (condition.fix_rotations) {
    std::vector<std::string> rotations;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if ((*condition.fix_rotations)[axis]) rotations.push_back(std::string(1, "xyz"[axis]));
    map.add("rotations", rotations.empty() ? "none" : list(rotations));
  }
  if (condition.motion == SupportMotion::none) return map.text();
  map.add(word_of(motion_words, condition.motion), vector(condition.value));
  if (condition.turn != Vector3::Zero())
    map.add(word_of(turn_words, condition.motion), vector(condition.turn));
  if (condition.about) map.add("about", vector(*condition.about));
  return add_history(condition.history, map).text();
}

std::string load_text(const Load& load) {
  FlowMap map;
  const bool is_gravity = load.kind == Load::Kind::gravity;
  if (!is_gravity)
    map.add("instance", word(load.instance))
        .add(load.on_point ? "point" : "surface", word(load.surface));
  if (load.kind == Load::Kind::pressure) {
    map.add("pressure", number_text(load.value[0]));
  } else {
    map.add(is_gravity                        ? "gravity"
            : load.kind == Load::Kind::moment ? "moment"
            : load.kind == Load::Kind::force  ? "force"
                                              : "traction",
            vector(load.value));
  }
  if (load.follows != (load.kind == Load::Kind::pressure))
    map.add("follow", load.follows ? "true" : "false");
  return add_history(load.history, map).text();
}

std::string wall_text(const WallOptions& wall) {
  FlowMap map;
  map.add(wall.kind == WallOptions::Kind::sphere ? "center" : "point", vector(wall.point));
  if (wall.kind == WallOptions::Kind::plane) map.add("normal", vector(wall.direction));
  if (wall.kind == WallOptions::Kind::cylinder) map.add("axis", vector(wall.direction));
  if (wall.kind != WallOptions::Kind::plane) {
    map.add("radius", number_text(wall.radius)).add("inside", wall.inside ? "true" : "false");
  }
  FlowMap of;
  of.add(word_of(wall_words, wall.kind), map.text());
  if (wall.motion == SupportMotion::none) return of.text();
  of.add(word_of(motion_words, wall.motion), vector(wall.value));
  return add_history(wall.history, of).text();
}

std::string contact_text(const ContactOptions& contact) {
  FlowMap map;
  map.add("between", contact.all ? "all" : words({contact.first.text(), contact.second.text()}));
  map.add("formulation", word_of(formulation_words, contact.formulation));
  map.add("enforcement", word_of(enforcement_words, contact.enforcement));
  map.add("friction", number_text(contact.friction)).add("damping", number_text(contact.damping));
  if (contact.pressures)
    map.add("pressures", *contact.pressures == 0 ? "nodes" : std::to_string(*contact.pressures));
  map.add("tied", contact.tied ? "true" : "false");
  if (contact.adjust) map.add("adjust", number_text(*contact.adjust));
  if (contact.pretension_force)
    map.add("pretension", FlowMap().add("force", number_text(*contact.pretension_force)).text());
  if (contact.shortening)
    map.add("pretension", FlowMap().add("shortening", number_text(*contact.shortening)).text());
  map.add_if(contact.resolves_overlap, "overlap", "resolve");
  return map.text();
}

std::string six_text(const Matrix6& A) {
  std::vector<std::string> rows;
  for (Index i = 0; i < 6; ++i)
    rows.push_back(numbers(std::vector<double>(A.row(i).begin(), A.row(i).end())));
  return list(rows);
}

std::string link_text(const LinkOptions& link) {
  const char* const names[] = {"x", "y", "z", "rx", "ry", "rz"};
  std::vector<std::string> fix;
  for (std::size_t m = 0; m < 6; ++m)
    if (link.fix[m]) fix.emplace_back(names[m]);
  FlowMap map;
  map.add("between", words({link.first.text(), link.second.text()}))
      .add_if(!fix.empty(), "fix", list(fix));
  if (!link.stiffness.isZero(0)) map.add("stiffness", six_text(link.stiffness));
  if (!link.damping.isZero(0)) map.add("damping", six_text(link.damping));
  if (!link.axes.isIdentity(0))
    map.add("axes",
            list({vector(link.axes.row(0).transpose()), vector(link.axes.row(1).transpose())}));
  return map.text();
}

std::string time_text(const TimeOptions& time) {
  const std::string step = time.step  ? number_text(*time.step)
                           : time.cfl ? "{cfl: " + number_text(*time.cfl) + "}"
                                      : std::string("auto");
  FlowMap map;
  map.add("end", number_text(time.end)).add("step", step);
  if (time.is_static) {
    map.add("static", "true");
  } else {
    map.add("integrator", word_of(integrator_words, time.integrator));
  }
  if (time.preload) map.add("preload", std::to_string(*time.preload));
  if (time.alpha != 0) map.add("alpha", number_text(time.alpha));
  if (time.mass_scaling) map.add("mass_scaling", "true");
  map.add_if(time.rotations != Rotations::automatic, "rotations",
             word_of(rotations_words, time.rotations));
  return map.add_if(time.force_step, "force", "true").text();
}

std::string checkpoint_text(const CheckpointOptions& checkpoint) {
  FlowMap map;
  if (checkpoint.every) map.add("every", number_text(*checkpoint.every));
  if (checkpoint.every_steps) map.add("every_steps", std::to_string(*checkpoint.every_steps));
  if (checkpoint.every_minutes) map.add("every_minutes", number_text(*checkpoint.every_minutes));
  if (!checkpoint.file.empty()) map.add("file", path(checkpoint.file));
  return map.text();
}

std::string stress_text(const StressOptions& stress) {
  if (!stress.set.empty()) return word(stress.instance + "." + stress.set);
  FlowMap map;
  map.add("instance", word(stress.instance));
  std::vector<std::string> ids;
  for (const Index id : stress.elements) ids.push_back(std::to_string(id));
  if (!ids.empty()) map.add("elements", list(ids));
  if (stress.worst > 0) map.add("worst", std::to_string(stress.worst));
  return map.add_if(stress.envelope, "envelope", "true").text();
}

std::string sweep_text(const SweepOptions& sweep) {
  FlowMap map;
  map.add("from_hz", number_text(sweep.from_hz)).add("to_hz", number_text(sweep.to_hz));
  map.add("points", std::to_string(sweep.points))
      .add("spacing", sweep.is_logarithmic ? "log" : "linear");
  if (sweep.modes) map.add("modes", std::to_string(*sweep.modes));
  return map.text();
}

template <typename Item, typename Text>
void write_list(const std::string& section, const std::vector<Item>& items, const Text& text,
                std::ostream& out) {
  if (!items.empty()) out << section << ":\n";
  for (const auto& item : items) out << "  - " << text(item) << "\n";
}

}  // namespace

void write_scene(const Scene& scene, std::ostream& out) {
  if (!scene.materials.empty()) out << "materials:\n";
  for (const auto& [material_name, material] : scene.materials) {
    FlowMap map;
    if (const auto& of = material.orthotropy) {
      map.add("youngs_modulus", vector(of->youngs_moduli))
          .add("poissons_ratio", vector(of->poissons_ratios));
      map.add("shear_modulus", vector(of->shear_moduli));
      map.add("axes",
              list({vector(of->axes.row(0).transpose()), vector(of->axes.row(1).transpose())}));
    } else {
      map.add("youngs_modulus", number_text(material.youngs_modulus))
          .add("poissons_ratio", number_text(material.poissons_ratio));
    }
    map.add("density", number_text(material.density));
    if (const auto damping = scene.damping.find(material_name); damping != scene.damping.end()) {
      FlowMap of;
      of.add("alpha", number_text(damping->second.alpha))
          .add("beta", number_text(damping->second.beta));
      map.add("damping", of.add("loss_factor", number_text(damping->second.loss_factor)).text());
    }
    out << "  " << word(material_name) << ": " << map.text() << "\n";
  }
  out << "components:\n";
  for (const auto& [component_name, component] : scene.components) write_component(component, out);
  if (!scene.instances.empty()) out << "instances:\n";
  for (const auto& instance : scene.instances) write_instance(instance, out);
  if (scene.skin) write_skin(*scene.skin, out);
  write_list("boundary", scene.boundary, boundary_text, out);
  write_list("loads", scene.loads, load_text, out);
  if (!scene.walls.empty()) out << "walls:\n";
  for (const auto& wall : scene.walls)
    out << "  " << word(wall.name) << ": " << wall_text(wall) << "\n";
  write_list("contact", scene.contact, contact_text, out);
  write_list("links", scene.links, link_text, out);
  if (scene.time) out << "time: " << time_text(*scene.time) << "\n";
  if (scene.sweep) out << "sweep: " << sweep_text(*scene.sweep) << "\n";
  std::vector<std::string> history;
  for (const auto& surface : scene.output.history) history.push_back(surface.text());
  FlowMap output;
  output.add("every", number_text(scene.output.every))
      .add("history", words(history))
      .add("fields", words(scene.output.fields));
  if (scene.output.format != FieldFormat::xdmf)
    output.add("format", word_of(field_format_words, scene.output.format));
  std::vector<std::string> stress;
  for (const auto& of : scene.output.stress) stress.push_back(stress_text(of));
  if (!stress.empty()) output.add("stress", list(stress));
  std::vector<std::string> reactions;
  for (const auto& set : scene.output.reactions) reactions.push_back(set.text());
  if (!reactions.empty()) output.add("reactions", words(reactions));
  if (scene.output.checkpoint) output.add("checkpoint", checkpoint_text(*scene.output.checkpoint));
  out << "output: " << output.text() << "\n";
}

}  // namespace cbr
