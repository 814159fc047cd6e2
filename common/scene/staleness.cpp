// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/staleness.hpp"

#include <algorithm>
#include <sstream>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/scene/component_blocks.hpp"
#include "common/scene/reduction_keys.hpp"
#include "common/scene/scene_words.hpp"

namespace cbr {
namespace {

using Provenance = std::map<std::string, std::string>;

// Keys of /provenance of the scene's needs of sets.
const std::string needs_of = "needs ", all_sets = "needs of all";

std::vector<std::string> words_in(const std::string& names) {
  std::vector<std::string> words;
  std::istringstream in(names);
  for (std::string word; std::getline(in >> std::ws, word, ',');) words.push_back(word);
  return words;
}

// A set's names stand in any order.
std::string sorted(const std::string& names) {
  std::vector<std::string> words = words_in(names);
  std::sort(words.begin(), words.end());
  return join(words);
}

bool is_option(const std::string& key) {
  return key != "mesh" && key != "mesh_hash" && key != "left_out" && !key.starts_with("block ");
}

class Differences {
 public:
  void add(const std::string& key, const std::string& in_file, const std::string& in_scene) {
    if (sorted(in_file) == sorted(in_scene)) return;
    add(key + ": " + (in_file.empty() ? "not given" : in_file) + " in the file, " +
        (in_scene.empty() ? "not given" : in_scene) + " in the scene");
  }
  void add(const std::string& text) { text_ += (text_.empty() ? "" : "; ") + text; }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string value(const Provenance& p, const std::string& key) {
  const auto found = p.find(key);
  return found == p.end() ? "" : found->second;
}

// Options of a block by its name in the mesh, which an unnamed block of an Exodus file has from its
// number.
const Component::BlockOptions* options_of(const Component& component, const std::string& block) {
  for (const auto& [named, options] : component.blocks)
    if (named == block || "block_" + named == block) return &options;
  return nullptr;
}

void compare_blocks(const Scene& scene, const Component& component, const Provenance& file,
                    Differences& differences) {
  for (const auto& [key, in_file] : file) {
    const auto end = key.rfind(": ");
    if (!key.starts_with("block ") || end == std::string::npos) continue;
    const std::string block = key.substr(6, end - 6), what = key.substr(end + 2);
    const Component::BlockOptions* own = options_of(component, block);
    const auto material =
        scene.materials.find(own && !own->material.empty() ? own->material : component.material);
    if (what == "element") {
      const auto default_element =
          in_file.ends_with("reduced") ? HexFormulation::reduced : HexFormulation::incompatible;
      differences.add("element of block " + block, in_file,
                      element_word(in_file.substr(0, in_file.find('-')),
                                   element_of(component, own).value_or(default_element)));
    } else if (what == "thickness") {
      differences.add("thickness of block " + block, in_file,
                      own && own->thickness ? number_text(*own->thickness) : "none");
    } else if (material != scene.materials.end()) {
      const Provenance own_numbers = material_provenance(material->second);
      const auto number = own_numbers.find(what);
      differences.add(what + " of block " + block, in_file,
                      number != own_numbers.end() ? number->second : "none");
    }
  }
}

// The mass matrix that the scene gives the elements of the file.
MassKind wanted_mass(const Component& component, const Provenance& file) {
  if (component.mass) return *component.mass;
  const bool spoilt = std::any_of(file.begin(), file.end(), [](const auto& item) {
    return item.first.starts_with("block ") && item.first.ends_with(": element") &&
           is_spoilt_by_lumping(item.second);
  });
  return spoilt ? MassKind::consistent : MassKind::lumped;
}

}  // namespace

Provenance material_provenance(const Material& m) {
  const auto three = [](const Vector3& v) {
    return "[" + number_text(v[0]) + ", " + number_text(v[1]) + ", " + number_text(v[2]) + "]";
  };
  Provenance p;
  p["density"] = number_text(m.density);
  if (!m.orthotropy) {
    p["youngs_modulus"] = number_text(m.youngs_modulus);
    p["poissons_ratio"] = number_text(m.poissons_ratio);
    return p;
  }
  const Orthotropy& of = *m.orthotropy;
  p["youngs_modulus"] = three(of.youngs_moduli);
  p["poissons_ratio"] = three(of.poissons_ratios);
  p["shear_modulus"] = three(of.shear_moduli);
  p["axes"] = of.center
                  ? "cylinder " + three(of.axes.row(2).transpose()) + " at " + three(*of.center)
                  : "[" + three(of.axes.row(0).transpose()) + ", " +
                        three(of.axes.row(1).transpose()) + "]";
  return p;
}

Provenance option_provenance(const Component& component, MassKind mass) {
  ReductionOptions reduction = *component.reduction;
  Provenance p;
  p["mass"] = word_of(mass_words, std::optional(mass));
  for (const ReductionKey& key : reduction_keys(reduction)) {
    if (key.provenance.empty() || !key.has_line(reduction.basis)) continue;
    const std::vector<std::string> words = words_of(key.scene.value);
    if (!words.empty() || key.scene.key == "interface") p[key.provenance] = join(words);
  }
  if (reduction.tolerance) p["pick"] = "tolerance";
  p.merge(point_provenance(component));
  return p;
}

Provenance point_provenance(const Component& component) {
  Provenance p;
  for (const std::string& name : component.reduction->interface_points) {
    const auto found = component.points.find(name);
    if (found == component.points.end()) continue;
    std::string& text = p["point " + name] = found->second.nodes;
    if (const auto& at = found->second.at)
      text += " at " + number_text((*at)[0]) + " " + number_text((*at)[1]) + " " +
              number_text((*at)[2]);
  }
  return p;
}

Provenance needs_provenance(const InterfaceNeeds& needs) {
  std::map<std::string, std::vector<std::string>> words;
  if (needs.all_touch) words[all_sets] = {"contact"};
  if (needs.all_touch.value_or(false)) words[all_sets].emplace_back("friction");
  for (const auto& [set, slides] : needs.touching) {
    words[needs_of + set].emplace_back("contact");
    if (slides) words[needs_of + set].emplace_back("friction");
  }
  for (const std::string& set : needs.held) words[needs_of + set].emplace_back("held");
  for (const auto& [set, kinds] : needs.loaded) {
    if (kinds.forces) words[needs_of + set].emplace_back("forces");
    if (kinds.pressure) words[needs_of + set].emplace_back("pressure");
    if (kinds.moments) words[needs_of + set].emplace_back("moments");
    if (kinds.means) words[needs_of + set].emplace_back("history");
  }
  Provenance p;
  for (const auto& [key, of] : words) p[key] = join(of);
  return p;
}

InterfaceNeeds needs_in(const Provenance& provenance) {
  InterfaceNeeds needs;
  for (const auto& [key, text] : provenance) {
    const std::vector<std::string> words = words_in(text);
    const auto has = [&](const char* word) {
      return std::find(words.begin(), words.end(), word) != words.end();
    };
    if (key == all_sets) needs.all_touch = has("friction");
    if (key == all_sets || !key.starts_with(needs_of)) continue;
    const std::string set = key.substr(needs_of.size());
    if (has("contact")) needs.touching[set] = has("friction");
    if (has("held")) needs.held.push_back(set);
    const LoadKinds kinds = {has("forces"), has("pressure"), has("moments"), has("history")};
    if (kinds.acts() || kinds.means) needs.loaded[set] = kinds;
  }
  return needs;
}

std::string missing_needs(const InterfaceNeeds& of_file, const InterfaceNeeds& of_scene) {
  const Provenance file = needs_provenance(of_file);
  std::vector<std::string> missing;
  for (const auto& [key, text] : needs_provenance(of_scene)) {
    const std::vector<std::string> there = words_in(value(file, key));
    std::vector<std::string> lacks;
    for (const std::string& word : words_in(text))
      if (std::find(there.begin(), there.end(), word) == there.end()) lacks.push_back(word);
    const std::string set = key == all_sets ? "all surfaces" : key.substr(needs_of.size());
    if (!lacks.empty()) missing.push_back(set + " (" + join(lacks) + ")");
  }
  return join(missing);
}

std::string stale_text(const Scene& scene, const Component& component) try {
  const Hdf5Reader reader(component.reduction->superelement);
  const Provenance file = reader.texts("/provenance");
  Provenance now = option_provenance(component, wanted_mass(component, file));
  const bool tells_needs = std::any_of(
      file.begin(), file.end(), [](const auto& item) { return item.first.starts_with(needs_of); });
  if (tells_needs && component.reduction->is_characteristic())
    now.merge(needs_provenance(interface_needs(scene, component)));
  if (file.empty()) return "the file does not tell what it was made from";
  Differences differences;
  if (reader.has_attribute("/", "basis"))
    differences.add("basis", reader.read_string("/", "basis"),
                    word_of(basis_words, component.reduction->basis));
  if (value(file, "mesh_hash") != mesh_hash(component.mesh))
    differences.add("the mesh " + component.mesh.filename().string() +
                    " is another than that of the file");
  for (const auto& [key, in_file] : file)
    if (is_option(key)) differences.add(key, in_file, value(now, key));
  for (const auto& [key, in_scene] : now)
    if (file.count(key) == 0) differences.add(key, "", in_scene);
  compare_blocks(scene, component, file, differences);
  return differences.text().empty()
             ? "what contact, supports and loads ask of its interface has changed"
             : differences.text();
} catch (const InputError&) {
  return "the file cannot be read";
}

bool is_of_other_mass(const Component& component) try {
  const Provenance file = Hdf5Reader(component.reduction->superelement).texts("/provenance");
  const std::string found = value(file, "mass");
  return !found.empty() &&
         found != word_of(mass_words, std::optional(wanted_mass(component, file)));
} catch (const InputError&) {
  return false;
}

bool lacks_face_centres(const std::filesystem::path& superelement) {
  try {
    const Hdf5Reader file(superelement);
    const std::string part = file.has("/domains/1") ? "/domains/1" : "/";
    if (!file.has_attribute(part, "format_version")) return false;
    const std::string version = file.read_string(part, "format_version");
    if (!version.starts_with("1.") || std::stoi(version.substr(2)) >= 6) return false;
    const Provenance p = file.texts("/provenance");
    return std::any_of(p.begin(), p.end(), [](const auto& item) { return item.second == "hex27"; });
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace cbr
