// SPDX-License-Identifier: GPL-3.0-or-later
// The words of a scene file and their values: one table for reading, writing and hashing.
#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/scene/scene.hpp"

namespace cbr {

template <typename Value>
using Words = std::vector<std::pair<std::string, Value>>;

inline const Words<HexFormulation> hex_words = {{"hex8", HexFormulation::full},
                                                {"hex8-incompatible", HexFormulation::incompatible},
                                                {"hex8-hourglass", HexFormulation::hourglass},
                                                {"reduced", HexFormulation::reduced}};
inline const Words<std::optional<MassKind>> mass_words = {
    {"auto", std::nullopt}, {"lumped", MassKind::lumped}, {"consistent", MassKind::consistent}};
inline const Words<Basis> basis_words = {{"craig-bampton", Basis::craig_bampton},
                                         {"massless", Basis::massless},
                                         {"characteristic", Basis::characteristic}};
inline const Words<Pick> pick_words = {{"frequency", Pick::frequency},
                                       {"participation", Pick::participation}};
inline const Words<MasslessModes> massless_words = {{"free", MasslessModes::free},
                                                    {"tapered", MasslessModes::tapered}};
inline const Words<InstanceKind> instance_words = {{"superelement", InstanceKind::superelement},
                                                   {"mesh", InstanceKind::mesh},
                                                   {"rigid", InstanceKind::rigid}};
inline const Words<std::string> mirror_words = {{"x", "x"}, {"y", "y"}, {"z", "z"}};
inline const Words<bool> coupling_words = {{"average", false}, {"rigid", true}};
inline const Words<Load::Kind> load_words = {{"traction", Load::Kind::traction},
                                             {"force", Load::Kind::force},
                                             {"pressure", Load::Kind::pressure},
                                             {"gravity", Load::Kind::gravity},
                                             {"moment", Load::Kind::moment}};
inline const Words<bool> overlap_words = {{"keep", false}, {"resolve", true}};
inline const Words<bool> spacing_words = {{"linear", false}, {"log", true}};
inline const Words<Enforcement> enforcement_words = {{"impulse", Enforcement::impulse},
                                                     {"penalty", Enforcement::penalty},
                                                     {"nodal", Enforcement::nodal}};
inline const Words<Formulation> formulation_words = {{"auto", Formulation::automatic},
                                                     {"node-face", Formulation::node_face},
                                                     {"two-way", Formulation::two_way},
                                                     {"mortar", Formulation::mortar}};
inline const Words<WallOptions::Kind> wall_words = {{"plane", WallOptions::Kind::plane},
                                                    {"sphere", WallOptions::Kind::sphere},
                                                    {"cylinder", WallOptions::Kind::cylinder}};
inline const Words<SupportMotion> turn_words = {
    {"rotation", SupportMotion::displacement},
    {"angular_velocity", SupportMotion::velocity},
    {"angular_acceleration", SupportMotion::acceleration}};
inline const Words<SupportMotion> motion_words = {{"displacement", SupportMotion::displacement},
                                                  {"velocity", SupportMotion::velocity},
                                                  {"acceleration", SupportMotion::acceleration}};
inline const Words<Rotations> rotations_words = {
    {"auto", Rotations::automatic}, {"small", Rotations::small}, {"large", Rotations::large}};
inline const Words<FieldFormat> field_format_words = {{"xdmf", FieldFormat::xdmf},
                                                      {"exodus", FieldFormat::exodus}};
inline const Words<Integrator> integrator_words = {
    {"exact", Integrator::exact},
    {"central-difference", Integrator::central_difference},
    {"newmark", Integrator::newmark}};

template <typename Value>
std::string word_of(const Words<Value>& words, Value value) {
  for (const auto& [word, meaning] : words) {
    if (meaning == value) return word;
  }
  assert(false);
  return "";
}

// Of an element in provenance: "hex8-hourglass", "hex20-reduced"; of a type without a choice its
// name.
inline std::string element_word(const std::string& type, HexFormulation hex) {
  const bool is_hex8 = type == "hex8";
  if (hex == HexFormulation::reduced && (is_hex8 || type == "hex20" || type == "wedge15"))
    return type + "-reduced";
  return is_hex8 ? word_of(hex_words, hex) : type;
}

// Of a word that is not among them: nothing.
template <typename Value>
std::optional<Value> value_of(const Words<Value>& words, const std::string& text) {
  for (const auto& [word, value] : words) {
    if (word == text) return value;
  }
  return std::nullopt;
}

template <typename Value>
std::vector<std::string> texts_of(const Words<Value>& words) {
  std::vector<std::string> texts;
  for (const auto& [word, value] : words) texts.push_back(word);
  return texts;
}

}  // namespace cbr
