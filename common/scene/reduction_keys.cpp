// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/reduction_keys.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/number_text.hpp"

namespace cbr {
namespace {

using Options = ReductionOptions;
using Names = std::vector<std::string>;

std::vector<ReductionKey> table() {
  std::vector<ReductionKey> keys;
  keys.push_back(
      {.key = "basis",
       .value = OneWord<Basis>{[](Options& r) -> Basis& { return r.basis; }, basis_words},
       .hash = "basis",
       .option = "--basis",
       .type_name = "WORD",
       .help = "craig-bampton (default: all interface dofs), characteristic (few shapes of the "
               "interface) or massless (no mass "
               "on the interface)"});
  keys.push_back({.key = "massless_modes",
                  .value = OneWord<MasslessModes>{[](Options& r) -> MasslessModes& {
                                                    return r.massless_modes;
                                                  },
                                                  massless_words},
                  .hash = "massless_modes",
                  .provenance = "massless_modes",
                  .only_with = Basis::massless,
                  .option = "--massless-modes",
                  .type_name = "WORD",
                  .help = "with massless: free (default; MacNeal) or tapered (free modes with "
                          "a tapered interface part, for impacts)",
                  .retired = "fixed",
                  .successor = "take tapered for impacts, or free"});
  keys.push_back(
      {.key = "characteristic.modes",
       .value = WholeNumber{[](Options& r) -> Index& { return r.characteristic.modes; }, 0},
       .provenance = "characteristic.modes",
       .only_with = Basis::characteristic,
       .option = "--characteristic-modes",
       .type_name = "N",
       .help = "with characteristic: number of modes that replace the interface's dofs, 0 or more "
               "(default: a third of --modes, "
               "10 to 40)"});
  keys.push_back(
      {.key = "characteristic.keep",
       .value = NameList{[](Options& r) -> Names& { return r.characteristic.keep; }},
       .provenance = "characteristic.keep",
       .only_with = Basis::characteristic,
       .option = "--keep",
       .type_name = "NAME",
       .help = "with characteristic: set whose nodes keep all their dofs; may be repeated"});
  keys.push_back({.key = "characteristic.pressure",
                  .value = Retired{},
                  .successor = "leave it out: all sidesets of 'statics' get a uniform pressure"});
  keys.push_back({.key = "characteristic.patterns",
                  .value = Retired{},
                  .successor = "leave it out: 'statics' keep the compliance of every node"});
  keys.push_back({.key = "characteristic.shear",
                  .value = TrueOrFalse{[](Options& r) -> bool& { return r.characteristic.shear; }},
                  .provenance = "characteristic.shear",
                  .only_with = Basis::characteristic,
                  .option = "--shear",
                  .help = "statics in all directions, for friction (default: normal "
                          "to the faces only)"});
  keys.push_back(
      {.key = "characteristic.statics",
       .value = NameList{[](Options& r) -> Names& { return r.characteristic.statics; }},
       .provenance = "characteristic.statics",
       .only_with = Basis::characteristic,
       .option = "--statics",
       .type_name = "NAME",
       .help = "with characteristic: contact sideset whose static compliance is kept in full "
               "(default: all sidesets of the interface); may be repeated",
       .retired = "none",
       .successor = "leave it out, or take basis: craig-bampton"});
  keys.push_back({.key = "interface",
                  .value = NameList{[](Options& r) -> Names& { return r.interface_sets; }},
                  .hash = "interface",
                  .provenance = "interface",
                  .option = "--interface",
                  .type_name = "NAME",
                  .help = "sideset or nodeset whose nodes are kept; may be repeated. Other sets "
                          "within these nodes are kept too"});
  keys.push_back({.key = "points",
                  .value = NameList{[](Options& r) -> Names& { return r.interface_points; }},
                  .hash = "point"});
  keys.push_back({.key = "condense_rotations",
                  .value = TrueOrFalse{[](Options& r) -> bool& { return r.condenses_rotations; }},
                  .hash = "condense_rotations",
                  .provenance = "condense_rotations"});
  keys.push_back(
      {.key = "modes",
       .value = WholeNumberOrNone{[](Options& r) -> std::optional<Index>& { return r.modes; }, 0},
       .hash = "modes",
       .provenance = "modes",
       .option = "--modes",
       .type_name = "N",
       .help = "number of fixed-interface modes, 0 or more; with --basis characteristic 80 if not "
               "given"});
  keys.push_back(
      {.key = "cutoff_hz",
       .value = NumberOrNone{[](Options& r) -> std::optional<double>& { return r.cutoff_hz; }, 0,
                             HUGE_VAL, "a positive frequency in Hz"},
       .hash = "cutoff_hz",
       .provenance = "cutoff_hz",
       .option = "--cutoff-hz",
       .type_name = "HZ",
       .help = "keep all fixed-interface modes below this frequency"});
  keys.push_back(
      {.key = "tolerance",
       .value = NumberOrNone{[](Options& r) -> std::optional<double>& { return r.tolerance; }, 0, 1,
                             "a number between 0 and 1 (both excluded)"},
       .hash = "tolerance",
       .provenance = "tolerance",
       .option = "--tolerance",
       .type_name = "SHARE",
       .help = "choose the modes by this relative error of the ten lowest squared free "
               "frequencies, and of the interior's strain "
               "energy under rigid accelerations of the interface"});
  keys.push_back({.key = "pick",
                  .value = OneWord<Pick>{[](Options& r) -> Pick& { return r.pick; }, pick_words},
                  .hash = "pick",
                  .provenance = "pick",
                  .option = "--pick",
                  .type_name = "WORD",
                  .help = "frequency (default: the lowest modes) or participation (modes that the "
                          "interface excites most)"});
  keys.push_back(
      {.key = "domains",
       .value = WholeNumber{[](Options& r) -> Index& { return r.domains; }, 1},
       .hash = "domains",
       .provenance = "domains",
       .option = "--domains",
       .type_name = "N",
       .help = "number of domains, which are reduced separately and share nodes (default: 1)"});
  keys.push_back(
      {.key = "second_reduction.modes",
       .value =
           WholeNumberOrNone{[](Options& r) -> std::optional<Index>& { return r.second_modes; }, 0},
       .hash = "second modes",
       .provenance = "second_modes"});
  keys.push_back({.key = "second_reduction.cutoff_hz",
                  .value = NumberOrNone{[](Options& r) -> std::optional<double>& {
                                          return r.second_cutoff_hz;
                                        },
                                        0, HUGE_VAL, ""},
                  .hash = "second cutoff_hz",
                  .provenance = "second_cutoff_hz"});
  keys.push_back(
      {.key = "recovery",
       .value = NamesOrTrue{[](Options& r) -> bool& { return r.recovery; },
                            [](Options& r) -> Names& { return r.recovery_sets; }},
       .hash = "recovery",
       .provenance = "recovery",
       .option = "--recovery",
       .help = "store Psi, Phi and the connectivity, to recover the interior's motion and stress"});
  // Its sets are part of the superelement, which tells them itself: /loads.
  keys.push_back({.key = "loads", .value = NameList{[](Options& r) -> Names& { return r.loads; }}});
  return keys;
}

// Reads the fields of options that nobody changes.
struct WordsOf {
  Options& r;
  Names operator()(const Retired&) const { return {}; }
  template <typename Value>
  Names operator()(const OneWord<Value>& v) const {
    return {word_of(v.words, v.field(r))};
  }
  Names operator()(const WholeNumber& v) const { return {std::to_string(v.field(r))}; }
  Names operator()(const WholeNumberOrNone& v) const {
    return v.field(r) ? Names{std::to_string(*v.field(r))} : Names();
  }
  Names operator()(const NumberOrNone& v) const {
    return v.field(r) ? Names{number_text(*v.field(r))} : Names();
  }
  Names operator()(const TrueOrFalse& v) const { return {v.field(r) ? "true" : "false"}; }
  Names operator()(const NameList& v) const { return v.field(r); }
  Names operator()(const NamesOrTrue& v) const {
    return v.names(r).empty() ? Names{v.field(r) ? "true" : "false"} : v.names(r);
  }
};

}  // namespace

const std::vector<ReductionKey>& reduction_keys() {
  static const std::vector<ReductionKey> keys = table();
  return keys;
}

std::vector<std::string> keys_of_reduction(const std::string& prefix) {
  Names names;
  for (const ReductionKey& key : reduction_keys()) {
    const auto dot = key.key.find('.');
    const bool is_inside = dot != std::string::npos;
    if (!prefix.empty()) {
      if (is_inside && key.key.substr(0, dot) == prefix) names.push_back(key.key.substr(dot + 1));
    } else if (names.empty() || names.back() != key.key.substr(0, dot)) {
      names.push_back(key.key.substr(0, dot));
    }
  }
  return names;
}

std::vector<std::string> words_of(const ReductionKey& key, const ReductionOptions& reduction) {
  ReductionOptions copy = reduction;
  return std::visit(WordsOf{copy}, key.value);
}

void complete(ReductionOptions& reduction, const std::vector<std::string>& given) {
  const auto is_given = [&](const char* key) {
    return std::find(given.begin(), given.end(), key) != given.end();
  };
  if (reduction.is_characteristic() && !reduction.modes && !reduction.cutoff_hz &&
      !reduction.tolerance)
    reduction.modes = default_modes;
  CharacteristicOptions& characteristic = reduction.characteristic;
  characteristic.is_default_modes = !is_given("characteristic.modes");
  if (characteristic.is_default_modes) characteristic.modes = default_shapes(reduction.modes);
}

}  // namespace cbr
