// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/scene_keys.hpp"

#include "common/base/format_text.hpp"

namespace cbr {
namespace {

using Names = std::vector<std::string>;

struct WordsOf {
  Names operator()(const OneWord& v) const {
    const std::string word = v.word();
    return word.empty() ? Names() : Names{word};
  }
  Names operator()(const Number& v) const {
    const double* value = v.place.value();
    return value != nullptr ? Names{number_text(*value)} : Names();
  }
  Names operator()(const WholeNumber& v) const {
    const Index* value = v.place.value();
    return value != nullptr ? Names{std::to_string(*value)} : Names();
  }
  Names operator()(const TrueOrFalse& v) const { return {v.member ? "true" : "false"}; }
  Names operator()(const NameList& v) const { return v.names; }
  Names operator()(const NamesOrTrue& v) const {
    return v.names.empty() ? Names{v.member ? "true" : "false"} : v.names;
  }
  Names operator()(const File& v) const { return {v.member.string()}; }
  Names operator()(const Own& v) const {
    const std::string text = v.text();
    return text.empty() ? Names() : Names{text};
  }
  Names operator()(const auto&) const { return {}; }
};

}  // namespace

std::vector<std::string> names_of(const std::vector<SceneKey>& keys, const std::string& head,
                                  bool retired) {
  Names names;
  for (const SceneKey& key : keys) {
    const auto* of = std::get_if<Retired>(&key.value);
    if (retired != (of != nullptr && !of->successor.empty())) continue;
    const auto dot = key.key.find('.');
    if (head.empty()) {
      if (names.empty() || names.back() != key.key.substr(0, dot))
        names.push_back(key.key.substr(0, dot));
    } else if (dot != std::string::npos && key.key.substr(0, dot) == head) {
      names.push_back(key.key.substr(dot + 1));
    }
  }
  return names;
}

std::vector<std::string> words_of(const SceneValue& value) { return std::visit(WordsOf(), value); }

}  // namespace cbr
