// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene_node.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "common/error.hpp"

namespace cbr {
namespace {

constexpr int deepest_merge = 20;   // an anchor may hold itself
constexpr int most_merges = 10000;  // or hold others twice, which hold others twice, ...

std::string quoted(const std::string& text) {
  constexpr std::size_t longest = 60;
  return "'" + (text.size() > longest ? text.substr(0, longest) + "..." : text) + "'";
}

int line_of(const YAML::Node& node, int otherwise) {
  return node.IsDefined() && !node.Mark().is_null() ? node.Mark().line + 1 : otherwise;
}

template <typename Number>
std::from_chars_result parse(const std::string& text, Number& value) {
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (text.size() > 1 && *begin == '+' && begin[1] != '-') ++begin;
  return std::from_chars(begin, end, value);
}

bool is_any_of(const std::string& text, const std::vector<std::string>& words) {
  return std::find(words.begin(), words.end(), text) != words.end();
}

}  // namespace

void SceneNode::fail(const std::string& what) const {
  throw InputError(source().text() + ": " + (path_.empty() ? "" : path_ + ": ") + what);
}

std::string SceneNode::found() const {
  if (is_null()) return "nothing";
  if (node_.IsMap()) return "a map";
  if (node_.IsSequence()) return "a list";
  return quoted(node_.Scalar());
}

void SceneNode::fail_choice(const std::vector<std::string>& allowed) const {
  fail("unknown value " + found() + nearest_name(node_.Scalar(), allowed) +
       (nearest_name(node_.Scalar(), allowed).empty() ? ", " : " ") + "allowed: " + join(allowed));
}

std::string SceneNode::text() const {
  if (!is_scalar()) fail("found " + found() + ", expected a word");
  if (node_.Scalar().empty()) fail("found an empty word");
  return node_.Scalar();
}

double SceneNode::number() const {
  if (!is_scalar()) fail("found " + found() + ", expected a number");
  const std::string& scalar = node_.Scalar();
  if (is_any_of(scalar, {".nan", ".NaN", ".NAN", ".inf", ".Inf", ".INF", "-.inf", "-.Inf", "-.INF", "+.inf", "+.Inf", "+.INF"})) {
    fail("found " + found() + ", expected a finite number");
  }
  double value = 0;
  const auto [end, error] = parse(scalar, value);
  const bool whole = end == scalar.data() + scalar.size();
  if (error == std::errc::result_out_of_range && whole) fail("found " + found() + ", which no double can hold");
  if (error != std::errc() || !whole) fail("found " + found() + ", expected a number");
  if (!std::isfinite(value)) fail("found " + found() + ", expected a finite number");
  return value;
}

double SceneNode::positive() const {
  const double value = number();
  if (value <= 0) fail("found " + found() + ", expected a number above 0");
  return value;
}

double SceneNode::not_negative() const {
  const double value = number();
  if (value < 0) fail("found " + found() + ", expected a number from 0");
  return value;
}

double SceneNode::in_open_range(double low, double high) const {
  const double value = number();
  if (value > low && value < high) return value;
  const auto number_text = [](double bound) {
    std::string digits = std::to_string(bound);
    digits.erase(digits.find_last_not_of('0') + 1);
    return digits.back() == '.' ? digits.substr(0, digits.size() - 1) : digits;
  };
  fail("found " + found() + ", expected a number between " + number_text(low) + " and " + number_text(high) + ", both excluded");
}

Index SceneNode::index(Index least) const {
  const std::string expected = ", expected a whole number from " + std::to_string(least);
  if (!is_scalar()) fail("found " + found() + expected);
  const std::string& scalar = node_.Scalar();
  Index value = 0;
  const auto [end, error] = parse(scalar, value);
  if (error != std::errc() || end != scalar.data() + scalar.size() || value < least) fail("found " + found() + expected);
  return value;
}

bool SceneNode::boolean() const {
  if (!is_scalar()) fail("found " + found() + ", expected true or false");
  std::string word = node_.Scalar();
  std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (is_any_of(word, {"true", "yes", "on"})) return true;
  if (is_any_of(word, {"false", "no", "off"})) return false;
  fail("found " + found() + ", expected true or false");
}

std::vector<SceneNode> SceneNode::list() const {
  if (!node_.IsSequence()) fail("found " + found() + ", expected a list");
  std::vector<SceneNode> items;
  for (const auto& item : node_) {
    items.emplace_back(item, file_, path_ + "[" + std::to_string(items.size()) + "]", line_of(item, line_));
  }
  return items;
}

std::vector<SceneNode> SceneNode::list_or_one() const { return is_scalar() ? std::vector<SceneNode>{*this} : list(); }

std::vector<double> SceneNode::numbers() const {
  std::vector<double> values;
  for (const auto& item : list()) values.push_back(item.number());
  return values;
}

Vector3 SceneNode::vector3() const {
  if (!node_.IsSequence() || node_.size() != 3) {
    fail("found " + (node_.IsSequence() ? "a list of " + std::to_string(node_.size()) : found()) +
         ", expected a list of three numbers");
  }
  const auto values = numbers();
  return {values[0], values[1], values[2]};
}

std::vector<std::string> SceneNode::names() const {
  std::vector<std::string> words;
  std::set<std::string> seen;
  for (const auto& item : list_or_one()) {
    words.push_back(item.text());
    if (!seen.insert(words.back()).second) item.fail("'" + words.back() + "' is there twice");
  }
  return words;
}

SceneMap SceneNode::map(std::vector<std::string> allowed) const { return {*this, std::move(allowed)}; }

SceneMap SceneNode::map_of_any() const {
  SceneMap any(*this, {});
  if (any.entries().empty()) fail("is empty, expected at least one entry");
  return any;
}

SceneMap::SceneMap(const SceneNode& node, std::vector<std::string> allowed) : node_(node), allowed_(std::move(allowed)) {
  if (!node.node_.IsMap()) {
    node.fail("found " + node.found() + ", expected a map" + (allowed_.empty() ? "" : " with the keys " + join(allowed_)));
  }
  add(node.node_, false, 0);
}

void SceneMap::add(const YAML::Node& map, bool merged, int depth) {
  if (merged && ++n_merges_ > most_merges) node_.fail("merge keys (<<) lead to too many maps");
  std::set<std::string> here;
  std::vector<YAML::Node> merge;
  for (const auto& entry : map) {
    const int line = line_of(entry.first, node_.line_);
    if (!entry.first.IsScalar()) {
      SceneNode(entry.first, node_.file_, node_.path_, line).fail("a key is not a plain word");
    }
    const std::string key = entry.first.Scalar();
    if (key == "<<" && entry.first.Tag() != "!") {  // "!" is the tag of a quoted word
      merge.push_back(entry.second);
      continue;
    }
    const SceneNode value(entry.second, node_.file_, (node_.path_.empty() ? "" : node_.path_ + ".") + key, line);
    if (!here.insert(key).second) value.fail("key '" + key + "' is there twice, remove one");
    if (!allowed_.empty() && !is_any_of(key, allowed_)) {
      const std::string hint = nearest_name(key, allowed_);
      value.fail("unknown key '" + key + "'" + hint + (hint.empty() ? ", " : " ") + "allowed: " + join(allowed_));
    }
    if (key.empty()) value.fail("a key is empty");
    if (!merged || find(key) == nullptr) entries_.emplace_back(key, value);
  }
  for (const auto& value : merge) add_merged(value, depth + 1);
}

// What is merged in gives way to what is there: https://yaml.org/type/merge.html
void SceneMap::add_merged(const YAML::Node& value, int depth) {
  if (depth > deepest_merge) node_.fail("merge keys (<<) are nested too deeply, or one holds itself");
  if (value.IsMap()) return add(value, true, depth);
  if (!value.IsSequence()) node_.fail("merge key (<<): expected a map or a list of maps");
  for (const auto& item : value) {
    if (!item.IsMap()) node_.fail("merge key (<<): expected a map or a list of maps");
    add(item, true, depth);
  }
}

const SceneNode* SceneMap::find(const std::string& key) const {
  for (const auto& [name, value] : entries_) {
    if (name == key) return &value;
  }
  return nullptr;
}

const SceneNode& SceneMap::at(const std::string& key) const {
  if (const SceneNode* value = find(key)) return *value;
  node_.fail("missing key '" + key + "'");
}

std::string SceneMap::exactly_one(const std::vector<std::string>& keys) const {
  std::vector<std::string> given;
  for (const auto& key : keys) {
    if (find(key) != nullptr) given.push_back(key);
  }
  if (given.size() == 1) return given[0];
  node_.fail((given.empty() ? "none of " : "more than one of ") + join(keys) + " is given, expected exactly one");
}

void require_known(const SceneNode& node, const std::string& kind, const std::string& name, const std::vector<std::string>& known) {
  if (is_any_of(name, known)) return;
  const std::string hint = nearest_name(name, known);
  node.fail("unknown " + kind + " '" + name + "'" + hint + (hint.empty() ? ", " : " ") +
            "known: " + (known.empty() ? "none" : join(known)));
}

}  // namespace cbr
