// SPDX-License-Identifier: GPL-3.0-or-later
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

#include "common/base/checksum.hpp"
#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/scene/reduction_keys.hpp"
#include "common/scene/scene.hpp"
#include "common/scene/scene_words.hpp"
#include "common/scene/staleness.hpp"
#include "common/scene/static_forces.hpp"

namespace cbr {
namespace {

// To be raised when the same inputs no longer give the same superelement: files made before are
// then stale.
constexpr int scheme = 1;

std::string hexadecimal(XXH128_hash_t hash) {
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, hash);
  constexpr const char* digits = "0123456789abcdef";
  std::string text;
  for (const unsigned char byte : canonical.digest) {
    text += digits[byte >> 4];
    text += digits[byte & 15];
  }
  return text;
}

std::string material_text(const Scene& scene, const std::string& material) {
  const auto found = scene.materials.find(material);
  if (found == scene.materials.end()) return "none";
  const Material& m = found->second;
  if (m.orthotropy) {
    std::string text;
    for (const auto& [what, value] : material_provenance(m)) text += what + " " + value + " ";
    return text;
  }
  return number_text(m.youngs_modulus) + " " + number_text(m.poissons_ratio) + " " +
         number_text(m.density);
}

// Without an element a deck chooses it, by its letters.
std::string properties_text(const Scene& scene, const Component& component,
                            const Component::BlockOptions* block) {
  const auto element = element_of(component, block);
  return material_text(scene, block == nullptr || block->material.empty() ? component.material
                                                                          : block->material) +
         " " +
         (element || !may_hold_materials(component.mesh)
              ? word_of(hex_words, element.value_or(HexFormulation::incompatible))
              : "of the deck");
}

// Names go in with their length, so that no two different inputs give the same text.
std::string counted(const std::string& text) { return std::to_string(text.size()) + ":" + text; }

std::string component_text(const Scene& scene, const Component& component) {
  const std::string all_blocks = properties_text(scene, component, nullptr);
  std::string text = "default " + all_blocks + "\n";
  for (const auto& [block, options] : component.blocks) {
    const std::string properties = properties_text(scene, component, &options);
    if (properties != all_blocks) text += "block " + counted(block) + " " + properties + "\n";
    if (options.thickness)
      text += "shells " + counted(block) + " " + number_text(*options.thickness) + "\n";
  }
  // Files of before `auto` hold lumped mass: those that it does not suit are recognised by their
  // provenance, is_of_other_mass().
  return text + "mass " + word_of(mass_words, component.mass ? component.mass : MassKind::lumped) +
         "\n";
}

// Each name once, in any order.
std::vector<std::string> as_set(std::vector<std::string> names) {
  sort_uniquely(names);
  return names;
}

// Sets that keep their statics, and whether in all directions.
std::string statics_text(const CharacteristicOptions& options, const InterfaceNeeds& needs) {
  const bool everywhere = options.shear || needs.all_touch.value_or(false);
  std::map<std::string, bool> sets;
  for (const auto& [set, slides] : needs.touching)
    if (options.statics.empty()) sets[set] = slides || everywhere;
  for (const auto& set : options.statics) {
    const auto found = needs.touching.find(set);
    sets[set] = everywhere || (found != needs.touching.end() && found->second);
  }
  std::string text;
  for (const auto& [set, directions] : sets)
    text += "statics " + counted(set) + (directions ? " all\n" : " normal\n");
  if (options.statics.empty() && needs.all_touch)
    text += everywhere ? "statics of all, all\n" : "statics of all, normal\n";
  return text;
}

std::string characteristic_text(const CharacteristicOptions& options, const InterfaceNeeds& needs) {
  std::string text =
      "characteristic modes of the free component " + std::to_string(options.modes) + "\n";
  std::vector<std::string> keep = options.keep;
  keep.insert(keep.end(), needs.held.begin(), needs.held.end());
  for (const auto& set : as_set(keep)) text += "keep " + counted(set) + "\n";
  text += options.shear ? "patterns 3 shear\n" : "patterns 1\n";
  const std::map<std::string, LoadKinds> loads = loads_beside_statics(options, needs);
  for (const auto& [set, kinds] : loads)
    text += "load on " + counted(set) + (kinds.forces ? " forces" : "") +
            (kinds.pressure ? " pressure" : "") + (kinds.moments ? " moments" : "") +
            (kinds.means ? " means" : "") + "\n";
  const std::string statics = statics_text(options, needs);
  // Older files are wrong where forces of contact balance others on the interface
  const bool may_balance = !statics.empty() && (!keep.empty() || !loads.empty());
  return text + (may_balance ? "balance of contact\n" : "") + statics;
}

// Places of the interface's points, and the sets that they move.
std::string points_text(const Component& component) {
  std::string text;
  for (const auto& [name, of] : point_provenance(component))
    text += counted(name) + " " + counted(of) + "\n";
  return text;
}

// A line for each option, by the table; names of sets each on a line, in any order.
std::string reduction_text(const ReductionOptions& reduction, const InterfaceNeeds& needs) {
  std::string text;
  ReductionOptions options = reduction;
  for (const ReductionKey& key : reduction_keys(options)) {
    const std::string& name = key.scene.key;
    if (name == "characteristic.modes" && reduction.is_characteristic())
      text += characteristic_text(reduction.characteristic, needs);
    if (key.hash.empty() || !key.has_line(reduction.basis)) continue;
    if (const auto* some = std::get_if<NamesOrTrue>(&key.scene.value)) {
      text += key.hash + (some->member ? " true\n" : " false\n");
      for (const auto& set : as_set(some->names)) text += key.hash + " of " + counted(set) + "\n";
    } else if (const auto* list = std::get_if<NameList>(&key.scene.value)) {
      for (const auto& set : as_set(list->names)) text += key.hash + " " + counted(set) + "\n";
    } else {
      for (const auto& word : words_of(key.scene.value)) text += key.hash + " " + word + "\n";
    }
    if (name == "massless_modes" && reduction.massless_modes == MasslessModes::tapered)
      text += "falling to the next that takes part\n";  // since 1.5
  }
  return text;
}

}  // namespace

std::string file_hash(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (std::filesystem::is_directory(status)) throw InputError(file.string() + ": is a directory");
  // A device or a pipe may have no end
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    throw InputError(file.string() + ": is not a regular file: give the path of a file on a disk");
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in.is_open())
    throw InputError(file.string() + ": cannot be opened: " + std::strerror(errno));
  const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(),
                                                                              XXH3_freeState);
  XXH3_128bits_reset(state.get());
  std::vector<char> buffer(std::size_t{1} << 20);
  while (in.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) || in.gcount() > 0) {
    XXH3_128bits_update(state.get(), buffer.data(), static_cast<std::size_t>(in.gcount()));
  }
  if (in.bad()) throw InputError(file.string() + ": cannot be read: " + std::strerror(errno));
  return hexadecimal(XXH3_128bits_digest(state.get()));
}

std::string mesh_hash(const std::filesystem::path& file) {
  const auto files = mesh_files(file);
  if (files.size() == 1) return file_hash(file);
  std::string text;
  for (const auto& one : files) text += file_hash(one) + "\n";
  return bytes_hash(text);
}

struct Checksum::State {
  XXH3_state_t* const xxh3 = XXH3_createState();
  State() { XXH3_64bits_reset(xxh3); }
  ~State() { XXH3_freeState(xxh3); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
};

Checksum::Checksum() : state_(std::make_unique<State>()) {}
Checksum::~Checksum() = default;
void Checksum::add(const void* data, std::size_t bytes) {
  if (bytes > 0) XXH3_64bits_update(state_->xxh3, data, bytes);
}
Index Checksum::value() const { return static_cast<Index>(XXH3_64bits_digest(state_->xxh3)); }

std::string bytes_hash(std::string_view bytes) {
  return hexadecimal(XXH3_128bits(bytes.data(), bytes.size()));
}

std::string content_hash(const Scene& scene, const Component& component) {
  return content_hash(scene, component, interface_needs(scene, component));
}

std::string content_hash(const Scene& scene, const Component& component,
                         const InterfaceNeeds& needs) {
  std::string text =
      "cbr content hash " + std::to_string(scheme) + "\nmesh " + mesh_hash(component.mesh) + "\n";
  text += component_text(scene, component);
  if (component.reduction)
    text += reduction_text(*component.reduction, needs) + points_text(component);
  return bytes_hash(text);
}

}  // namespace cbr
