// SPDX-License-Identifier: GPL-3.0-or-later
// A strict view of a YAML tree. A value of another kind than asked for is an InputError with file,
// line and key.
#pragma once

#include <string>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/scene/scene_keys.hpp"
#include "common/scene/yaml/yaml_tree.hpp"

namespace cbr {

class SceneMap;

class SceneNode {
 public:
  // The tree must outlive it. `line`: of its key, where it is the value of one.
  SceneNode(const YamlTree& tree, YamlTree::Id id, std::string path, int line)
      : tree_(&tree), id_(id), line_(line), path_(std::move(path)) {}

  // "impact.yaml:12: components.block.mesh: WHAT"
  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void fail_repeated() const;  // an item of a list
  SourceLine source() const { return {tree_->name(), line_}; }
  const std::string& path() const { return path_; }
  bool is_map() const { return kind() == YamlTree::Kind::map; }
  bool is_scalar() const { return kind() == YamlTree::Kind::scalar; }
  bool is_list() const { return kind() == YamlTree::Kind::sequence; }

  std::string text() const;  // a scalar that is not empty
  double number() const;     // finite
  double number(const Bounds& bounds) const;
  Index index(Index least) const;  // whole, >= least
  bool boolean() const;
  Vector3 vector3() const;  // a list of three numbers
  std::vector<double> numbers() const;
  std::vector<SceneNode> list() const;
  // The same one by one, for lists of a million items.
  template <typename Visit>
  void for_each_item(const Visit& visit) const {
    const std::size_t n = list_size();
    for (std::size_t i = 0; i < n; ++i) visit(item(i));
  }
  std::vector<SceneNode> list_or_one() const;  // [a, b], or a alone
  std::vector<std::string> names() const;      // list_or_one() of text(), none twice
  SceneMap map(std::vector<std::string> allowed) const;
  SceneMap map_of(const std::vector<SceneKey>& keys, const std::string& head = "") const;
  SceneMap map_of_any() const;  // the keys are names that the user gives; at least one

  // The place of the scalar's text among those that are allowed.
  std::size_t choice(const std::vector<std::string>& allowed) const;

 private:
  friend class SceneMap;
  YamlTree::Kind kind() const { return tree_->kind(id_); }
  std::string_view word() const { return tree_->text(id_); }  // empty unless a scalar
  std::size_t list_size() const;
  SceneNode item(std::size_t i) const;
  std::string found() const;  // for messages: "'abc'", "a map", ...
  [[noreturn]] void fail_number(std::errc error, bool whole) const;

  const YamlTree* tree_;
  YamlTree::Id id_;
  int line_ = 0;
  std::string path_;
};

// A map whose keys are known: unknown keys, keys that are given twice and missing keys are errors.
// Merge keys (<<) are followed.
class SceneMap {
 public:
  // `allowed` empty: any key. `retired`: has a message of its own, and is not listed.
  SceneMap(const SceneNode& node, std::vector<std::string> allowed,
           std::vector<std::string> retired = {});

  const SceneNode* find(const std::string& key) const;  // null when not given
  const SceneNode& at(const std::string& key) const;    // InputError when not given
  const std::vector<std::pair<std::string, SceneNode>>& entries() const { return entries_; }
  const SceneNode& node() const { return node_; }
  // InputError unless exactly one of the keys is given; returns it.
  std::string exactly_one(const std::vector<std::string>& keys) const;

 private:
  void add(YamlTree::Id map, bool merged, int depth);
  void add_merged(YamlTree::Id value, int depth);
  SceneNode value_of(YamlTree::Id map, std::size_t i, const std::string& key) const;

  SceneNode node_;
  std::vector<std::string> allowed_, retired_;
  std::vector<std::pair<std::string, SceneNode>> entries_;
  std::unordered_map<std::string, std::size_t> place_;  // of a key in entries_
  int n_merges_ = 0;
};

// InputError unless `name` is among `known`: "unknown component 'blok', did you mean 'block'?
// known: ..."
void require_known(const SceneNode& node, const std::string& kind, const std::string& name,
                   const std::vector<std::string>& known);

}  // namespace cbr
