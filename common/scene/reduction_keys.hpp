// SPDX-License-Identifier: GPL-3.0-or-later
// The options of a reduction, one entry each. From this table follow the keys of the scene, what
// cbr-reduce hands on, the content hash, /provenance, and the command line of cbr-reduce.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/scene/scene.hpp"
#include "common/scene/scene_words.hpp"

namespace cbr {

template <typename Value>
using ReductionField = Value& (*)(ReductionOptions&);

// What a value may be.
template <typename Value>
struct OneWord {
  ReductionField<Value> field;
  const Words<Value>& words;
};
struct WholeNumber {
  ReductionField<Index> field;
  Index least = 0;
};
struct WholeNumberOrNone {
  ReductionField<std::optional<Index>> field;
  Index least = 0;
};
struct NumberOrNone {
  ReductionField<std::optional<double>> field;
  double above = 0, below = 0;  // both excluded
  std::string allowed;          // for messages of the command line
};
struct TrueOrFalse {
  ReductionField<bool> field;
};
struct NameList {
  ReductionField<std::vector<std::string>> field;
};
struct NamesOrTrue {
  ReductionField<bool> field;
  ReductionField<std::vector<std::string>> names;  // of some alone
};
struct Retired {};  // refused, whatever its value
using ReductionValue =
    std::variant<OneWord<Basis>, OneWord<Pick>, OneWord<MasslessModes>, WholeNumber,
                 WholeNumberOrNone, NumberOrNone, TrueOrFalse, NameList, NamesOrTrue, Retired>;

struct ReductionKey {
  std::string key;  // of `reduction` in the scene; of a map in it "characteristic.modes"
  ReductionValue value;
  // How its line of the hash begins. Empty: the option does not change the superelement, or
  // characteristic_text() tells it.
  std::string hash = {};
  // The attribute of /provenance; empty: none.
  std::string provenance = {};
  std::optional<Basis> only_with = {};
  // Of cbr-reduce; empty: none.
  std::string option = {}, type_name = {}, help = {};
  // A word that is refused, and what a user of it, or of a Retired key, does instead.
  std::string retired = {}, successor = {};

  bool goes_with(Basis basis) const { return !only_with || *only_with == basis; }
};

const std::vector<ReductionKey>& reduction_keys();

// Keys of `reduction`, or those of the map `prefix` ("characteristic") in it, in the table's order.
std::vector<std::string> keys_of_reduction(const std::string& prefix = "");

// The value as words: one; of names each. Nothing: it has none.
std::vector<std::string> words_of(const ReductionKey& key, const ReductionOptions& reduction);

// Whether `given` names the key: what is not given follows from what is.
void complete(ReductionOptions& reduction, const std::vector<std::string>& given);

}  // namespace cbr
