// SPDX-License-Identifier: GPL-3.0-or-later
// The keys of the scene, and the table of the options of a reduction.
#include "common/scene/reduction_keys.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <tuple>

#include "common/scene/limits.hpp"
#include "common/scene/yaml/scene_parse.hpp"
#include "tests/support/refusal.hpp"

namespace cbr::reduction_keys_test {
namespace {

std::string contract() {
  std::ifstream in(std::string(CBR_SOURCE_DIR) + "/docs/formats.md");
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Limits, AreTheTableOfTheContract) {
  std::string rows = "| ability | not with | instead |\n|---|---|---|\n";
  for (const Limit& limit : limits()) {
    rows += "| " + std::string(limit.ability) + " | ";
    for (const Feature feature : limit.not_with) {
      rows += std::string(feature == limit.not_with.front() ? "" : "; ") + std::string(feature);
      const SourceLine at{"scene.yaml", 3}, other{"scene.yaml", 7};
      const Features features{{limit.ability, {&at}}, {feature, {&other}}};
      const std::string message = test::refusal_of([&] { check_limits(features, "instance 'a'"); });
      EXPECT_TRUE(message.starts_with("scene.yaml:3: instance 'a': ")) << message;
      std::string cure = limit.cure;
      std::erase(cure, '`');
      EXPECT_TRUE(message.ends_with(" (line 7): " + cure)) << message;
    }
    rows += " | " + limit.cure + " |\n";
  }
  EXPECT_SAYS(contract(), "\n\n" + rows + "\n") << rows;
}

// By their last name; of `reduction` by the row in full, of which second_reduction has one.
TEST(SceneKeys, AreAllInTheContract) {
  const std::string text = contract();
  const auto check = [&](const std::vector<SceneKey>& keys) {
    for (const SceneKey& key : keys) {
      const std::regex word("\\b" + key.key.substr(key.key.find('.') + 1) + "\\b");
      EXPECT_TRUE(std::regex_search(text, word)) << key.key;
    }
  };
  std::tuple<Component, Component::BlockOptions, Component::Point, Instance, SkinOptions,
             BoundaryCondition, Load, WallOptions, ContactOptions, LinkOptions, TimeOptions,
             SweepOptions, OutputOptions, StressOptions, CheckpointOptions>
      of;
  std::apply([&](auto&... each) { (check(scene_keys(each)), ...); }, of);
  ReductionOptions none;
  for (const SceneKey& key : scene_keys(none)) {
    const std::string row = key.key.starts_with("second_") ? "second_reduction" : key.key;
    EXPECT_SAYS(text, "`reduction." + row + "`") << row;
  }
}

TEST(ReductionKeys, AreUnlikeEachOther) {
  std::set<std::string> keys, hashes, attributes, options;
  ReductionOptions none;
  for (const ReductionKey& key : reduction_keys(none)) {
    const std::string& name = key.scene.key;
    EXPECT_TRUE(keys.insert(name).second) << name;
    if (!key.hash.empty()) EXPECT_TRUE(hashes.insert(key.hash).second) << name;
    if (!key.provenance.empty()) EXPECT_TRUE(attributes.insert(key.provenance).second) << name;
    const bool is_new = key.option.empty() || options.insert(key.option).second;
    EXPECT_TRUE(is_new && key.option.empty() == key.help.empty()) << name;
  }
}

// Gives a key another value than it has by default.
struct Change {
  void operator()(const OneWord& v) const { v.take(v.allowed().size() - 1); }
  void operator()(const Number& v) const { v.place.set(7); }
  void operator()(const WholeNumber& v) const { v.place.set(70); }
  void operator()(const TrueOrFalse& v) const { v.member = true; }
  void operator()(const NameList& v) const { v.names = {"some"}; }
  void operator()(const NamesOrTrue& v) const { v.member = true; }
  void operator()(const File& v) const { v.member = "/some"; }
  void operator()(const auto&) const { FAIL(); }
};

// Each member is that of its own key: what one value changes, no other tells.
TEST(ReductionKeys, EachHasAMemberOfItsOwn) {
  ReductionOptions plain;
  const auto plain_keys = reduction_keys(plain);
  for (std::size_t changed = 0; changed < plain_keys.size(); ++changed) {
    ReductionOptions options;
    const auto keys = reduction_keys(options);
    if (std::holds_alternative<Retired>(keys[changed].scene.value)) continue;
    if (keys[changed].scene.key == "fixed") {
      options.fixed.push_back({"end", {true}, {}});
    } else {
      std::visit(Change(), keys[changed].scene.value);
    }
    for (std::size_t i = 0; i < keys.size(); ++i)
      EXPECT_EQ(words_of(keys[i].scene.value) == words_of(plain_keys[i].scene.value), i != changed)
          << keys[i].scene.key << " by " << keys[changed].scene.key;
  }
}

}  // namespace
}  // namespace cbr::reduction_keys_test
