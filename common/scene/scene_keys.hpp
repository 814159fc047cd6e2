// SPDX-License-Identifier: GPL-3.0-or-later
// The keys of the scene: one entry each, bound to the member that holds the value. From these lists
// follow reading, writing, and the keys that messages allow.
#pragma once

#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/base/types.hpp"
#include "common/scene/scene_words.hpp"

namespace cbr {

class SceneNode;
struct SceneReading;

// The allowed range of a number: above `low`, or from it on, and below `high`.
struct Bounds {
  double low = -HUGE_VAL, high = HUGE_VAL;
  bool has_low = false;
  bool hold(double value) const {
    return (value > low || (has_low && value == low)) && value < high;
  }
};
inline constexpr Bounds positive{.low = 0}, not_negative{.low = 0, .has_low = true};

// A member that always has a value, or an optional one.
template <typename Value>
class Place {
 public:
  Place(Value& member) : member_(&member) {}
  Place(std::optional<Value>& member) : optional_(&member) {}
  // null: none is given
  const Value* value() const {
    if (optional_ == nullptr) return member_;
    return optional_->has_value() ? &**optional_ : nullptr;
  }
  void set(const Value& value) const {
    if (optional_ != nullptr) {
      *optional_ = value;
    } else {
      *member_ = value;
    }
  }

 private:
  Value* member_ = nullptr;
  std::optional<Value>* optional_ = nullptr;
};

// A value of any enumeration. The table of words must outlive it.
struct OneWord {
  template <typename Value>
  OneWord(Value& member, const Words<Value>& words) : OneWord(Place<Value>(member), words) {}
  template <typename Value>
  OneWord(std::optional<Value>& member, const Words<Value>& words)
      : OneWord(Place<Value>(member), words) {}
  template <typename Value>
  OneWord(Place<Value> place, const Words<Value>& words)
      : allowed([&words] { return texts_of(words); }),
        word([place, &words] {
          return place.value() != nullptr ? word_of(words, *place.value()) : std::string();
        }),
        take([place, &words](std::size_t i) { place.set(words[i].second); }) {}
  std::function<std::vector<std::string>()> allowed;
  std::function<std::string()> word;      // empty: none is given
  std::function<void(std::size_t)> take;  // one of those that are allowed
};
struct Number {
  Place<double> place;
  Bounds bounds = {};
};
struct WholeNumber {
  Place<Index> place;
  Index least = 0;
};
struct TrueOrFalse {
  bool& member;
};
struct NameList {
  std::vector<std::string>& names;
};
struct NamesOrTrue {
  bool& member;
  std::vector<std::string>& names;  // of some alone
};
struct ThreeNumbers {
  Place<Vector3> place;
};
struct Text {
  std::string& member;
};
struct File {
  std::filesystem::path& member;
};
// Any other value: how it is read into the member, and its text as YAML, empty where there is none.
struct Own {
  template <typename Value, typename Read, typename Text>
  Own(Value& member, Read read_into, Text text_of)
      : read([&member, read_into](const SceneNode& node, const SceneReading& reading) {
          read_into(node, reading, member);
        }),
        text([&member, text_of] { return text_of(member); }) {}
  // Its section reads it, together with other keys.
  template <typename Value, typename Text>
  Own(const Value& member, Text text_of) : text([&member, text_of] { return text_of(member); }) {}
  std::function<void(const SceneNode&, const SceneReading&)> read = {};
  std::function<std::string()> text;
};
// Refused, whatever its value. With a successor no message lists it.
struct Retired {
  std::string successor;  // the cure for a user of it
};
using SceneValue = std::variant<OneWord, Number, WholeNumber, TrueOrFalse, NameList, NamesOrTrue,
                                ThreeNumbers, Text, File, Own, Retired>;

struct SceneKey {
  std::string key;  // of a map in the map "characteristic.modes"
  SceneValue value;
  // Whether to write a value that there is: most defaults are left out.
  bool is_written = true;
  bool is_required = false;
};

// The keys of a map, or of the map `head` ("characteristic") in it, in the list's order: those that
// are allowed, or the retired ones.
std::vector<std::string> names_of(const std::vector<SceneKey>& keys, const std::string& head = "",
                                  bool retired = false);

// The value as words: one; of names each. Nothing: it has none.
std::vector<std::string> words_of(const SceneValue& value);

}  // namespace cbr
