// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes of many lines: names are looked up, not compared one by one, and messages still name the
// line.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/scene/yaml/yaml_tree.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/common/scene_samples.hpp"

namespace cbr::scene_load_test {
namespace {

using test::read_text;
using test::refusal;
using test::TemporaryFolder;

constexpr int n_instances = 1500, n_entries = 15000;

std::string many_instances() {
  std::string text =
      "materials: {m: {youngs_modulus: 1, poissons_ratio: 0, density: 1}}\n"
      "components: {a: {mesh: a.msh, material: m}}\ninstances:\n";
  for (int i = 0; i < n_instances; ++i) text += "  b" + std::to_string(i) + ": {component: a}\n";
  return text;
}

// All different: b0 with b1 ... b1499, b1 with b2 ...
std::string many_pairs(int n) {
  std::string text = "contact:\n";
  for (int a = 0, k = 0; k < n; ++a)
    for (int b = a + 1; b < n_instances && k < n; ++b, ++k)
      text += "  - {between: [b" + std::to_string(a) + ".s, b" + std::to_string(b) + ".s]}\n";
  return text;
}

TEST(SceneLoad, manyEntriesOfContactAreReadAndOneThatIsTwiceIsTold) {
  const TemporaryFolder folder;
  const std::string scene = many_instances() + many_pairs(n_entries);
  EXPECT_EQ(read_text(folder, scene).contact.size(), static_cast<std::size_t>(n_entries));
  const int line = 3 + n_instances + 1 + n_entries + 1;
  EXPECT_EQ(refusal(folder, scene + "  - {between: [b7.s, b3.s]}\n")
                .find("impact.yaml:" + std::to_string(line) + ": contact[15000]: "),
            0u);
  EXPECT_SAYS(refusal(folder, scene + "  - {between: [b7.s, b3.s]}\n"),
              "[b7.s, b3.s] is listed twice (line ");
  EXPECT_SAYS(refusal(folder, scene + "  - {between: [b7.s, b1500.s]}\n"),
              "unknown instance 'b1500'");
}

TEST(SceneLoad, aNumberThatIsNoneIsNamedByItsPlaceInALongTable) {
  const TemporaryFolder folder;
  const auto scene = [](const std::string& last) {
    std::string times, values;
    for (int i = 0; i < 50000; ++i) {
      times += std::to_string(i) + (i % 10 == 9 ? ",\n    " : ", ");
      values += "1, ";
    }
    return many_instances() + "loads:\n  - gravity: [0, 0, 1]\n    history:\n      time: [" +
           times + last + "]\n      value: [" + values + "2]\n";
  };
  const Scene read = read_text(folder, scene("50000"));
  ASSERT_EQ(read.loads.at(0).history.time.size(), 50001u);
  EXPECT_TRUE(std::is_sorted(read.loads[0].history.time.begin(), read.loads[0].history.time.end()));
  const int line = 3 + n_instances + 4 + 5000;
  EXPECT_EQ(refusal(folder, scene("5e4x")),
            "impact.yaml:" + std::to_string(line) +
                ": loads[0].history.time[50000]: found '5e4x', expected a number");
  EXPECT_EQ(refusal(folder, scene("7")),
            "impact.yaml:" + std::to_string(line) +
                ": loads[0].history.time[50000]: not above the time before it, times must ascend");
  EXPECT_SAYS(refusal(folder, scene(".inf")),
              "time[50000]: found '.inf', expected a finite number");
  EXPECT_SAYS(refusal(folder, scene("[]")), "time[50000]: found a list, expected a number");
}

TEST(SceneLoad, mapsThatAreMergedGiveWayToWhatIsThere) {
  const TemporaryFolder folder;
  const Scene scene =
      read_text(folder,
                "materials: {m: &m {youngs_modulus: 1, poissons_ratio: 0, density: 1}, n: {<<: *m, "
                "density: 2}}\n"
                "components: {a: &a {mesh: a.msh, material: m}, b: {<<: [{material: n}, *a]}}\n"
                "loads:\n  - {gravity: &g [0, 0, 1], history: &h {time: [0, 1], value: [0, 1]}}\n"
                "  - {gravity: *g, history: *h}\n");
  EXPECT_EQ(scene.materials.at("n").youngs_modulus, 1);
  EXPECT_EQ(scene.materials.at("n").density, 2);
  EXPECT_EQ(scene.components.at("b").material, "n");
  EXPECT_EQ(scene.components.at("b").mesh, scene.components.at("a").mesh);
  EXPECT_EQ(scene.loads.at(1).history.time, scene.loads.at(0).history.time);
}

// The same events as YAML's, in a tree: quotes, nulls, nested and empty collections, keys of all
// kinds.
TEST(YamlTree, holdsWhatTheTextSays) {
  using Kind = YamlTree::Kind;
  const YamlTree tree(
      "a: [1, \"2\", ~, {}]\nb:\n  - c: 'null'\n    d:\n  - &x [[], y]\n? [e]\n: *x\n", "t.yaml");
  const auto root = tree.root();
  ASSERT_EQ(tree.kind(root), Kind::map);
  ASSERT_EQ(tree.size(root), 3u);
  EXPECT_EQ(tree.text(tree.key(root, 1)), "b");
  const auto a = tree.value_of_key(root, 0), b = tree.value_of_key(root, 1),
             e = tree.value_of_key(root, 2);
  ASSERT_EQ(tree.size(a), 4u);
  EXPECT_EQ(tree.text(tree.item(a, 0)), "1");
  EXPECT_FALSE(tree.is_quoted(tree.item(a, 0)));
  EXPECT_TRUE(tree.is_quoted(tree.item(a, 1)));
  EXPECT_EQ(tree.kind(tree.item(a, 2)), Kind::null);
  EXPECT_EQ(tree.kind(tree.item(a, 3)), Kind::map);
  EXPECT_EQ(tree.size(tree.item(a, 3)), 0u);
  ASSERT_EQ(tree.size(b), 2u);
  const auto cd = tree.item(b, 0), x = tree.item(b, 1);
  ASSERT_EQ(tree.size(cd), 2u);
  EXPECT_EQ(tree.text(tree.value_of_key(cd, 0)), "null");
  EXPECT_EQ(tree.kind(tree.value_of_key(cd, 0)), Kind::scalar);
  EXPECT_EQ(tree.kind(tree.value_of_key(cd, 1)), Kind::null);
  EXPECT_EQ(tree.line(tree.key(cd, 1)), 4);
  EXPECT_EQ(tree.kind(tree.key(root, 2)), Kind::sequence);
  EXPECT_EQ(e, x);  // an alias is what it names
  EXPECT_EQ(tree.text(tree.item(x, 1)), "y");
  EXPECT_EQ(tree.line(x), 5);
}

}  // namespace
}  // namespace cbr::scene_load_test
