// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/reduction_keys.hpp"

#include <algorithm>

namespace cbr {

std::vector<ReductionKey> reduction_keys(ReductionOptions& r) {
  return {
      {.scene = {"basis", OneWord{r.basis, basis_words}},
       .hash = "basis",
       .option = "--basis",
       .type_name = "WORD",
       .help = "craig-bampton (default: all interface dofs), characteristic (few shapes of the "
               "interface) or massless (no mass on the interface)"},
      {.scene = {"massless_modes", OneWord{r.massless_modes, massless_words}},
       .hash = "massless_modes",
       .provenance = "massless_modes",
       .only_with = Basis::massless,
       .option = "--massless-modes",
       .type_name = "WORD",
       .help = "with massless: free (default; MacNeal) or tapered (free modes with "
               "a tapered interface part, for impacts)",
       .retired = "fixed",
       .successor = "take tapered for impacts, or free"},
      {.scene = {"characteristic.modes", WholeNumber{r.characteristic.modes},
                 !r.characteristic.is_default_modes},
       .provenance = "characteristic.modes",
       .only_with = Basis::characteristic,
       .option = "--characteristic-modes",
       .type_name = "N",
       .help = "with characteristic: number of modes that replace the interface's dofs, 0 or more "
               "(default: a third of --modes, 10 to 40)"},
      {.scene = {"characteristic.keep", NameList{r.characteristic.keep},
                 !r.characteristic.keep.empty()},
       .provenance = "characteristic.keep",
       .only_with = Basis::characteristic,
       .option = "--keep",
       .type_name = "NAME",
       .help = "with characteristic: set whose nodes keep all their dofs; may be repeated"},
      {.scene = {"characteristic.pressure",
                 Retired{"leave it out: all sidesets of 'statics' get a uniform pressure"}}},
      {.scene = {"characteristic.patterns",
                 Retired{"leave it out: 'statics' keep the compliance of every node"}}},
      {.scene = {"characteristic.shear", TrueOrFalse{r.characteristic.shear},
                 r.characteristic.shear},
       .provenance = "characteristic.shear",
       .only_with = Basis::characteristic,
       .option = "--shear",
       .help = "statics in all directions, for friction (default: normal "
               "to the faces only)"},
      {.scene = {"characteristic.statics", NameList{r.characteristic.statics},
                 !r.characteristic.statics.empty()},
       .provenance = "characteristic.statics",
       .only_with = Basis::characteristic,
       .option = "--statics",
       .type_name = "NAME",
       .help = "with characteristic: contact sideset whose static compliance is kept in full "
               "(default: all sidesets of the interface); may be repeated",
       .retired = "none",
       .successor = "leave it out, or take basis: craig-bampton"},
      {.scene = {"interface", NameList{r.interface_sets},
                 !r.interface_sets.empty() || r.interface_points.empty()},
       .hash = "interface",
       .provenance = "interface",
       .option = "--interface",
       .type_name = "NAME",
       .help = "sideset or nodeset whose nodes are kept; may be repeated. Other sets "
               "within these nodes are kept too"},
      {.scene = {"points", NameList{r.interface_points}, !r.interface_points.empty()},
       .hash = "point"},
      {.scene = {"fixed", Own{r.fixed, read_fixed, fixed_text}, !r.fixed.empty()},
       .hash = "fixed",
       .provenance = "fixed",
       .is_younger = true},
      {.scene = {"condense_rotations", TrueOrFalse{r.condenses_rotations}, r.condenses_rotations},
       .hash = "condense_rotations",
       .provenance = "condense_rotations",
       .is_younger = true},
      {.scene = {"modes", WholeNumber{r.modes}},
       .hash = "modes",
       .provenance = "modes",
       .option = "--modes",
       .type_name = "N",
       .help = "number of fixed-interface modes, 0 or more; with --basis characteristic 80 if not "
               "given"},
      {.scene = {"cutoff_hz", Number{r.cutoff_hz, positive}},
       .hash = "cutoff_hz",
       .provenance = "cutoff_hz",
       .option = "--cutoff-hz",
       .type_name = "HZ",
       .help = "keep all fixed-interface modes below this frequency",
       .allowed = "a positive frequency in Hz"},
      {.scene = {"tolerance", Number{r.tolerance, {.low = 0, .high = 1}}},
       .hash = "tolerance",
       .provenance = "tolerance",
       .option = "--tolerance",
       .type_name = "SHARE",
       .help = "choose the modes by this relative error of the ten lowest squared free "
               "frequencies, and of the interior's strain "
               "energy under rigid accelerations of the interface",
       .allowed = "a number between 0 and 1 (both excluded)"},
      {.scene = {"pick", OneWord{r.pick, pick_words}, !r.tolerance},
       .hash = "pick",
       .provenance = "pick",
       .option = "--pick",
       .type_name = "WORD",
       .help = "frequency (default: the lowest modes) or participation (modes that the "
               "interface excites most)"},
      {.scene = {"exact_modes", TrueOrFalse{r.exact_modes}, r.exact_modes},
       .hash = "exact_modes",
       .provenance = "exact_modes",
       .option = "--exact-modes",
       .help = "modes to round-off (default: as right as a basis needs, frequencies to 1e-6)",
       .is_younger = true},
      {.scene = {"domains", WholeNumber{r.domains, 1}},
       .hash = "domains",
       .provenance = "domains",
       .option = "--domains",
       .type_name = "N",
       .help = "number of domains, which are reduced separately and share nodes (default: 1)"},
      {.scene = {"second_reduction.modes", WholeNumber{r.second_modes}},
       .hash = "second modes",
       .provenance = "second_modes"},
      {.scene = {"second_reduction.cutoff_hz", Number{r.second_cutoff_hz, positive}},
       .hash = "second cutoff_hz",
       .provenance = "second_cutoff_hz"},
      {.scene = {"recovery", NamesOrTrue{r.recovery, r.recovery_sets}},
       .hash = "recovery",
       .provenance = "recovery",
       .option = "--recovery",
       .help = "store Psi, Phi and the connectivity, to recover the interior's motion and stress"},
      // Its sets stand in the superelement itself: /loads.
      {.scene = {"loads", NameList{r.loads}, !r.loads.empty()}},
      {.scene = {"superelement", File{r.superelement}}},
  };
}

std::vector<SceneKey> scene_keys(ReductionOptions& reduction) {
  std::vector<SceneKey> keys;
  for (const ReductionKey& key : reduction_keys(reduction)) {
    keys.push_back(key.scene);
    keys.back().is_written &= key.goes_with(reduction.basis);
  }
  return keys;
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
