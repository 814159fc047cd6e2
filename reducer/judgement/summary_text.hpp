// SPDX-License-Identifier: GPL-3.0-or-later
// Lines about a superelement in the summary of a reduction and of --info.
#pragma once

#include <string>
#include <vector>

#include "common/superelement/superelement.hpp"

namespace cbr {

struct SummaryLine {
  std::string text;
  bool detail = false;  // for --verbose only
};

// Error estimates of the reduction, each with a good value; none without Superelement::accuracy.
std::vector<SummaryLine> accuracy_lines(const Superelement& superelement);

// The first six fixed-interface and free frequencies in Hz, as far as the superelement has them.
std::vector<SummaryLine> frequency_lines(const Superelement& superelement);

// At how many nodes the static compliance is in full, and in which directions. nodes: one of each
// entry (StaticShare::node); none without statics.
std::vector<SummaryLine> statics_lines(const std::vector<Index>& nodes, bool in_levels);

// "x_max (150 faces), corner (1 nodes)"; "none".
std::string sets_text(const Superelement& superelement);

// Where another basis usually steps faster in contact; "" where none does.
std::string advice_on_basis(const Superelement& superelement);

}  // namespace cbr
