// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <ostream>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/scene/yaml/scene_parse.hpp"

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

}  // namespace

std::string yaml_word(const std::string& text) {
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

std::string yaml_list(const std::vector<std::string>& items) { return "[" + join(items) + "]"; }

std::string yaml_words(const std::vector<std::string>& texts) {
  std::vector<std::string> items;
  for (const auto& text : texts) items.push_back(yaml_word(text));
  return yaml_list(items);
}

std::string yaml_numbers(const std::vector<double>& values) {
  std::vector<std::string> items;
  for (const double value : values) items.push_back(number_text(value));
  return yaml_list(items);
}

std::string yaml_vector(const Vector3& v) { return yaml_numbers({v(0), v(1), v(2)}); }

std::string yaml_rows(const Matrix3& axes) {
  return yaml_list({yaml_vector(axes.row(0).transpose()), yaml_vector(axes.row(1).transpose())});
}

std::string yaml_path(const std::filesystem::path& file) {
  return file.empty() ? "" : yaml_word(std::filesystem::absolute(file).lexically_normal().string());
}

namespace {

struct YamlText {
  std::string operator()(const NameList& v) const { return yaml_words(v.names); }
  std::string operator()(const NamesOrTrue& v) const {
    return v.names.empty() ? (v.member ? "true" : "false") : yaml_words(v.names);
  }
  std::string operator()(const ThreeNumbers& v) const {
    return v.place.value() != nullptr ? yaml_vector(*v.place.value()) : "";
  }
  std::string operator()(const Text& v) const { return yaml_word(v.member); }
  std::string operator()(const File& v) const { return yaml_path(v.member); }
  std::string operator()(const Own& v) const { return v.text(); }
  std::string operator()(const auto& v) const { return join(words_of(v)); }
};

std::string flow_map(const std::vector<std::pair<std::string, std::string>>& entries) {
  std::vector<std::string> items;
  for (const auto& [key, text] : entries) items.push_back(key + ": " + text);
  return "{" + join(items) + "}";
}

// A map of maps, or a list of maps, each on a line.
template <typename Item>
std::string line_of(Item item) {
  return flow_map(scene_keys(item)) + "\n";
}

template <typename Item>
void write_list(const std::string& section, const std::vector<Item>& items, std::ostream& out) {
  if (!items.empty()) out << section << ":\n";
  for (const Item& item : items) out << "  - " << line_of(item);
}

template <typename Item>
void write_named(const std::string& section, const std::vector<Item>& items, std::ostream& out) {
  if (!items.empty()) out << section << ":\n";
  for (const Item& item : items) out << "  " << yaml_word(item.name) << ": " << line_of(item);
}

}  // namespace

std::vector<std::pair<std::string, std::string>> written(const std::vector<SceneKey>& keys) {
  std::vector<std::pair<std::string, std::string>> entries, inside;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto dot = keys[i].key.find('.');
    const std::string head = keys[i].key.substr(0, dot);
    const std::string text = keys[i].is_written ? std::visit(YamlText(), keys[i].value) : "";
    const bool is_inside = dot != std::string::npos;
    if (!text.empty())
      (is_inside ? inside : entries)
          .emplace_back(is_inside ? keys[i].key.substr(dot + 1) : head, text);
    const bool is_last = i + 1 == keys.size() || !keys[i + 1].key.starts_with(head + ".");
    if (!is_last || inside.empty()) continue;
    entries.emplace_back(head, flow_map(inside));
    inside.clear();
  }
  return entries;
}

std::string flow_map(const std::vector<SceneKey>& keys) { return flow_map(written(keys)); }

void write_scene(const Scene& scene, std::ostream& out) {
  if (!scene.materials.empty()) out << "materials:\n";
  for (auto [name, material] : scene.materials) {
    const auto damping = scene.damping.find(name);
    MaterialDamping of = damping != scene.damping.end() ? damping->second : MaterialDamping();
    out << "  " << yaml_word(name) << ": " << flow_map(scene_keys(material, of)) << "\n";
  }
  out << "components:\n";
  for (auto [name, component] : scene.components) {
    out << "  " << yaml_word(name) << ":\n";
    for (const auto& [key, text] : written(scene_keys(component)))
      out << "    " << key << (text.starts_with('\n') ? ":" : ": ") << text << "\n";
  }
  write_named("instances", scene.instances, out);
  if (scene.skin) out << "skin: " << line_of(*scene.skin);
  write_list("boundary", scene.boundary, out);
  write_list("loads", scene.loads, out);
  write_named("walls", scene.walls, out);
  write_list("contact", scene.contact, out);
  write_list("links", scene.links, out);
  if (scene.time) out << "time: " << line_of(*scene.time);
  if (scene.sweep) out << "sweep: " << line_of(*scene.sweep);
  out << "output: " << line_of(scene.output);
}

}  // namespace cbr
