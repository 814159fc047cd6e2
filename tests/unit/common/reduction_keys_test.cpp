// SPDX-License-Identifier: GPL-3.0-or-later
// The table of the options of a reduction.
#include "common/scene/reduction_keys.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <set>

namespace cbr::reduction_keys_test {
namespace {

std::string formats() {
  std::ifstream in(std::string(CBR_SOURCE_DIR) + "/docs/formats.md");
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(ReductionKeys, AreAllInTheContract) {
  const std::string text = formats();
  ASSERT_FALSE(text.empty());
  for (const ReductionKey& key : reduction_keys()) {
    // {modes: N} or {cutoff_hz: F} of one row
    const bool is_inside = key.key.starts_with("second_reduction.");
    const std::string row = is_inside ? "second_reduction" : key.key;
    EXPECT_NE(text.find("`reduction." + row + "`"), std::string::npos) << key.key;
    if (!key.option.empty()) EXPECT_FALSE(key.help.empty()) << key.key;
  }
}

TEST(ReductionKeys, AreUnlikeEachOther) {
  std::set<std::string> keys, hashes, attributes, options;
  for (const ReductionKey& key : reduction_keys()) {
    EXPECT_TRUE(keys.insert(key.key).second) << key.key;
    if (!key.hash.empty()) EXPECT_TRUE(hashes.insert(key.hash).second) << key.key;
    if (!key.provenance.empty()) EXPECT_TRUE(attributes.insert(key.provenance).second) << key.key;
    if (!key.option.empty()) EXPECT_TRUE(options.insert(key.option).second) << key.key;
  }
}

// Each field is that of its own key: what one value changes, no other tells.
TEST(ReductionKeys, EachHasAFieldOfItsOwn) {
  const ReductionOptions plain;
  for (const ReductionKey& changed : reduction_keys()) {
    ReductionOptions options;
    if (std::holds_alternative<Retired>(changed.value)) continue;
    std::visit(
        [&](const auto& value) {
          if constexpr (!std::is_same_v<std::decay_t<decltype(value)>, Retired>) {
            auto& field = value.field(options);
            using Field = std::decay_t<decltype(field)>;
            if constexpr (std::is_same_v<Field, std::vector<std::string>>) {
              field = {"some"};
            } else if constexpr (std::is_same_v<Field, std::optional<Index>> ||
                                 std::is_same_v<Field, std::optional<double>>) {
              field = 7;
            } else if constexpr (std::is_same_v<Field, Index>) {
              field += 7;
            } else if constexpr (std::is_same_v<Field, bool>) {
              field = true;
            } else {
              field = value.words.back().second;
            }
          }
        },
        changed.value);
    for (const ReductionKey& key : reduction_keys())
      EXPECT_EQ(words_of(key, options) == words_of(key, plain), key.key != changed.key)
          << key.key << " by " << changed.key;
  }
}

}  // namespace
}  // namespace cbr::reduction_keys_test
