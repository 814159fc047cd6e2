// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/yaml/scene_node.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <set>
#include <unordered_set>

#include "common/base/error.hpp"

namespace cbr {
namespace {

constexpr int deepest_merge = 20;   // an anchor may hold itself
constexpr int most_merges = 10000;  // or hold others twice, which hold others twice, ...

std::string quoted(std::string_view text) {
  constexpr std::size_t longest = 60;
  return "'" + std::string(text.substr(0, longest)) + (text.size() > longest ? "..." : "") + "'";
}

template <typename Number>
std::from_chars_result parse(std::string_view text, Number& value) {
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (text.size() > 1 && *begin == '+' && begin[1] != '-') ++begin;
  return std::from_chars(begin, end, value);
}

bool is_any_of(std::string_view text, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), text) != words.end();
}

}  // namespace

void SceneNode::fail(const std::string& what) const {
  throw InputError(source().text() + ": " + (path_.empty() ? "" : path_ + ": ") + what);
}

void SceneNode::fail_repeated() const { fail("'" + text() + "' is listed twice: remove one"); }

std::string SceneNode::found() const {
  switch (kind()) {
    case YamlTree::Kind::null:
      return "nothing";
    case YamlTree::Kind::map:
      return "a map";
    case YamlTree::Kind::sequence:
      return "a list";
    default:
      return quoted(word());
  }
}

std::size_t SceneNode::choice(const std::vector<std::string>& allowed) const {
  const std::string word = text();
  const auto place = std::find(allowed.begin(), allowed.end(), word);
  if (place != allowed.end()) return static_cast<std::size_t>(place - allowed.begin());
  const std::string hint = nearest_name(word, allowed);
  fail("unknown value " + found() + hint + (hint.empty() ? ", " : " ") +
       "allowed: " + join(allowed));
}

std::string SceneNode::text() const {
  if (!is_scalar()) fail("found " + found() + ", expected a word");
  if (word().empty()) fail("found an empty word");
  return std::string(word());
}

void SceneNode::fail_number(std::errc error, bool whole) const {
  const bool infinite = is_any_of(word(), {".nan", ".NaN", ".NAN", ".inf", ".Inf", ".INF", "-.inf",
                                           "-.Inf", "-.INF", "+.inf", "+.Inf", "+.INF"});
  if (infinite || (error == std::errc() && whole))
    fail("found " + found() + ", expected a finite number");
  if (error == std::errc::result_out_of_range && whole)
    fail("found " + found() + ", which no double can hold");
  fail("found " + found() + ", expected a number");
}

double SceneNode::number() const {
  double value = 0;
  const auto [end, error] = parse(word(), value);
  const bool whole = is_scalar() && end == word().data() + word().size();
  if (error != std::errc() || !whole || !std::isfinite(value)) fail_number(error, whole);
  return value;
}

double SceneNode::number(const Bounds& bounds) const {
  const double value = number();
  if (bounds.hold(value)) return value;
  const auto number_text = [](double bound) {
    std::string digits = std::to_string(bound);
    digits.erase(digits.find_last_not_of('0') + 1);
    return digits.back() == '.' ? digits.substr(0, digits.size() - 1) : digits;
  };
  const std::string low = number_text(bounds.low);
  if (std::isfinite(bounds.high))
    fail("found " + found() + ", expected a number between " + low + " and " +
         number_text(bounds.high) + ", both excluded");
  fail("found " + found() + ", expected a number " + (bounds.has_low ? "from " : "above ") + low);
}

Index SceneNode::index(Index least) const {
  const std::string expected = ", expected a whole number from " + std::to_string(least);
  Index value = 0;
  const auto [end, error] = parse(word(), value);
  if (error != std::errc() || end != word().data() + word().size() || value < least)
    fail("found " + found() + expected);
  return value;
}

bool SceneNode::boolean() const {
  if (!is_scalar()) fail("found " + found() + ", expected true or false");
  std::string lower(word());
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (is_any_of(lower, {"true", "yes", "on"})) return true;
  if (is_any_of(lower, {"false", "no", "off"})) return false;
  fail("found " + found() + ", expected true or false");
}

SceneNode SceneNode::item(std::size_t i) const {
  const YamlTree::Id id = tree_->item(id_, i);
  return {*tree_, id, path_ + "[" + std::to_string(i) + "]", tree_->line(id)};
}

std::size_t SceneNode::list_size() const {
  if (!is_list())
    fail("found " + found() + ", expected a list" + (is_map() ? ": begin each entry with '- '" : ""));
  return tree_->size(id_);
}

std::vector<SceneNode> SceneNode::list() const {
  std::vector<SceneNode> items;
  items.reserve(list_size());
  for_each_item([&](SceneNode node) { items.push_back(std::move(node)); });
  return items;
}

std::vector<SceneNode> SceneNode::list_or_one() const {
  return is_scalar() ? std::vector<SceneNode>{*this} : list();
}

// Long tables: a path is made only for entries that are no numbers.
std::vector<double> SceneNode::numbers() const {
  std::vector<double> values(list_size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string_view digits = tree_->text(tree_->item(id_, i));
    const auto [end, error] = parse(digits, values[i]);
    if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(values[i]))
      values[i] = item(i).number();
  }
  return values;
}

Vector3 SceneNode::vector3() const {
  if (!is_list() || tree_->size(id_) != 3) {
    fail("found " + (is_list() ? "a list of " + std::to_string(tree_->size(id_)) : found()) +
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
    if (!seen.insert(words.back()).second) item.fail_repeated();
  }
  return words;
}

SceneMap SceneNode::map(std::vector<std::string> allowed) const {
  return {*this, std::move(allowed)};
}

SceneMap SceneNode::map_of(const std::vector<SceneKey>& keys, const std::string& head) const {
  return {*this, names_of(keys, head), names_of(keys, head, true)};
}

SceneMap SceneNode::map_of_any() const {
  SceneMap any(*this, {});
  if (any.entries().empty()) fail("is empty, expected at least one entry");
  return any;
}

SceneMap::SceneMap(const SceneNode& node, std::vector<std::string> allowed,
                   std::vector<std::string> retired)
    : node_(node), allowed_(std::move(allowed)), retired_(std::move(retired)) {
  if (!node.is_map()) {
    node.fail("found " + node.found() + ", expected a map" +
              (allowed_.empty() ? "" : " with the keys " + join(allowed_)));
  }
  add(node.id_, false, 0);
}

SceneNode SceneMap::value_of(YamlTree::Id map, std::size_t i, const std::string& key) const {
  const YamlTree& tree = *node_.tree_;
  return {tree, tree.value_of_key(map, i), (node_.path_.empty() ? "" : node_.path_ + ".") + key,
          tree.line(tree.key(map, i))};
}

void SceneMap::add(YamlTree::Id map, bool merged, int depth) {
  if (merged && ++n_merges_ > most_merges) node_.fail("merge keys (<<) lead to too many maps");
  const YamlTree& tree = *node_.tree_;
  std::unordered_set<std::string> here;
  std::vector<YamlTree::Id> merge;
  for (std::size_t i = 0; i < tree.size(map); ++i) {
    const YamlTree::Id id = tree.key(map, i);
    if (tree.kind(id) != YamlTree::Kind::scalar)
      SceneNode(tree, id, node_.path_, tree.line(id)).fail("a key is not a plain word");
    const std::string key(tree.text(id));
    if (key == "<<" && !tree.is_quoted(id)) {
      merge.push_back(tree.value_of_key(map, i));
      continue;
    }
    const auto value = [&] { return value_of(map, i, key); };
    const bool is_twice = merged ? !here.insert(key).second : place_.contains(key);
    if (is_twice) value().fail("duplicate key '" + key + "': remove one");
    const auto is_in = [&](const auto& names) {
      return std::find(names.begin(), names.end(), key) != names.end();
    };
    if (!allowed_.empty() && !is_in(allowed_) && !is_in(retired_)) {
      const std::string hint = nearest_name(key, allowed_);
      value().fail("unknown key '" + key + "'" + hint + (hint.empty() ? ", " : " ") +
                   "allowed: " + join(allowed_));
    }
    if (key.empty()) value().fail("a key is empty");
    if (place_.try_emplace(key, entries_.size()).second) entries_.emplace_back(key, value());
  }
  for (const YamlTree::Id value : merge) add_merged(value, depth + 1);
}

// Own keys override merged ones: https://yaml.org/type/merge.html
void SceneMap::add_merged(YamlTree::Id value, int depth) {
  if (depth > deepest_merge)
    node_.fail("merge keys (<<) are nested too deeply, or one holds itself");
  const YamlTree& tree = *node_.tree_;
  if (tree.kind(value) == YamlTree::Kind::map) return add(value, true, depth);
  if (tree.kind(value) != YamlTree::Kind::sequence)
    node_.fail("merge key (<<): expected a map or a list of maps");
  for (std::size_t i = 0; i < tree.size(value); ++i) {
    if (tree.kind(tree.item(value, i)) != YamlTree::Kind::map)
      node_.fail("merge key (<<): expected a map or a list of maps");
    add(tree.item(value, i), true, depth);
  }
}

const SceneNode* SceneMap::find(const std::string& key) const {
  const auto found = place_.find(key);
  return found == place_.end() ? nullptr : &entries_[found->second].second;
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
  node_.fail((given.empty() ? "none of " : "more than one of ") + join(keys) +
             " is given, expected exactly one");
}

void require_known(const SceneNode& node, const std::string& kind, const std::string& name,
                   const std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), name) != known.end()) return;
  const std::string hint = nearest_name(name, known);
  node.fail("unknown " + kind + " '" + name + "'" + hint + (hint.empty() ? ", " : " ") +
            "known: " + (known.empty() ? "none" : join(known)));
}

}  // namespace cbr
