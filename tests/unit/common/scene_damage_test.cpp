// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes that are no scenes: empty, cut, damaged or endless files.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/support/refusal.hpp"
#include "tests/unit/common/scene_samples.hpp"

namespace cbr::scene_damage_test {
namespace {

using test::full_scene;
using test::read_text;
using test::refusal;
using test::TemporaryFolder;
using test::written;

TEST(SceneErrors, wholeFiles) {
  const TemporaryFolder folder;
  const auto starts = [&](const std::string& text, const std::string& start) {
    const std::string message = refusal(folder, text);
    EXPECT_EQ(message.substr(0, start.size()), start) << message;
  };
  starts("", "impact.yaml: is empty");
  starts("# only a comment\n", "impact.yaml: is empty");
  starts("{}", "impact.yaml:1: missing key 'materials'");
  starts("just words", "impact.yaml:1: found 'just words', expected a map with the keys materials");
  starts("- a\n- b\n", "impact.yaml:1: found a list, expected a map");
  starts("a: [1, 2\nb: {", "impact.yaml:");
  const std::string says = "is the brace { of line 2 not closed?";
  for (const char* after : {"", "\n", "c: 3\n", "\nc: 3\n", "\nc: {d: 3}\n"})
    EXPECT_SAYS(refusal(folder, std::string("a: 1\nb: {d: e\n") + after), says);
  EXPECT_SAYS(refusal(folder, "a: {b: [1, 2}\n"), "is the bracket [ of line 1 not closed?");
  starts("a: 1\n\tb: 2\n", "impact.yaml:2: is not valid YAML");
  starts(
      full_scene + "---\n" + full_scene,
      "impact.yaml:" + std::to_string(std::count(full_scene.begin(), full_scene.end(), '\n') + 1) +
          ": a second YAML document");
  starts("]", "impact.yaml:1: ");
  starts(", w], x: 1", "impact.yaml:1: ");
  starts("{a: 1}]", "impact.yaml:1: ");
  starts(std::string("materials\0: {}", 14), "impact.yaml: is not a text file");
  starts("materials: {}\ncomponents: {}\n", "impact.yaml:1: materials: is empty");
  starts(
      "materials: {m: {youngs_modulus: 1, poissons_ratio: 0, density: 1}}\ncomponents: {a: {mesh: "
      "a.msh, material: m}}\n"
      "contact: any\n",
      "impact.yaml:3: contact: found 'any', expected all, or a list of {between: ...}");
  starts("materials: *unknown\n", "impact.yaml:1: is not valid YAML");
  starts(std::string(200000, '[') + std::string(200000, ']'), "impact.yaml:");
  starts(std::string(100000, '{'), "impact.yaml:");
  starts("materials: &a {<<: *a}\n", "impact.yaml:");
  starts("materials: &a {m: {<<: *a}}\n", "impact.yaml:");
}

TEST(SceneErrors, filesThatCannotBeRead) {
  const TemporaryFolder folder;
  EXPECT_THROW(read_scene((folder / "missing.yaml").string()), InputError);
  EXPECT_THROW(read_scene(folder.path().string()), InputError);
  EXPECT_THROW(read_scene(""), InputError);
}

TEST(SceneErrors, filesWithoutEndAndLinksThatLeadNowhere) {
  const TemporaryFolder folder;
  const auto message = [&](const std::string& file) -> std::string {
    return test::refusal_of([&] { read_scene(file); });
  };
  const auto says = [&](const std::string& file, const std::string& part) {
    EXPECT_SAYS(message(file), part);
  };
  std::filesystem::create_symlink("/dev/zero", folder / "zero.yaml");
  says((folder / "zero.yaml").string(), "zero.yaml: is not a text file");
  test::write_bytes(folder / "sparse.yaml", "");
  std::filesystem::resize_file(folder / "sparse.yaml", 1'000'000'001);
  says((folder / "sparse.yaml").string(), "is of 1000000001 bytes, a scene has at most 1 GB");
  std::filesystem::create_symlink("loop.yaml", folder / "loop.yaml");
  says((folder / "loop.yaml").string(), "loop.yaml: cannot be opened: ");
  says("", "an empty name");
}

// The parser's own words for these are "illegal map value" and "bad file".
TEST(SceneErrors, slipsOfYamlNameTheirCure) {
  const TemporaryFolder folder;
  const auto says = [&](const std::string& text, const std::string& start,
                        const std::string& part) {
    const std::string message = refusal(folder, text);
    EXPECT_EQ(message.substr(0, start.size()), start) << message;
    EXPECT_SAYS(message, part);
  };
  says("time:\n\tend: 1\n", "impact.yaml:2: ", "replace tabs by spaces");
  says("time:\n  end: 1\n\tstep: 2\n", "impact.yaml:3: ", "replace tabs by spaces");
  says("a: 1\n" + std::string(1100, 'k') + ": 2\n",
       "impact.yaml:2: ", "a key has at most 1024 characters");
  says("a: 1\nb:\n  " + std::string(500, '['), "impact.yaml:3: ", "more than 100 deep");
  says("a: 1\nb:\n  " + std::string(500, '{'), "impact.yaml:3: ", "more than 100 deep");
}

// Whatever an editor's slip, a cut or a broken transfer makes of a scene: read, or refused in
// words.
TEST(SceneErrors, noDamageDoesMoreThanBeRefused) {
  const TemporaryFolder folder;
  std::mt19937 random(3);
  const std::string bytes = "{}[]:,-#&*!|>'\"%@`\n\t .0e+\xff\x80~<";
  int refused = 0;
  constexpr int trials = 1000;
  for (int trial = 0; trial < trials; ++trial) {
    std::string text = full_scene;
    for (int change = 0; change <= trial % 4 && !text.empty(); ++change) {
      const std::size_t at = random() % text.size();
      switch (random() % 4) {
        case 0:
          text[at] = bytes[random() % bytes.size()];
          break;
        case 1:
          text.erase(at, 1 + random() % 8);
          break;
        case 2:
          text.insert(at, 1, bytes[random() % bytes.size()]);
          break;
        default:
          text.resize(at + 1);
          break;
      }
    }
    if (refusal(folder, text) != "no error") {
      ++refused;
      continue;
    }
    const std::string once = written(read_text(folder, text));  // what is accepted can be handed on
    EXPECT_EQ(written(read_text(folder, once)), once);
  }
  EXPECT_GT(refused, trials / 2);
}

}  // namespace
}  // namespace cbr::scene_damage_test
