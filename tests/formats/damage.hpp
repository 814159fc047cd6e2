// SPDX-License-Identifier: GPL-3.0-or-later
// Damage to one dataset, which a reader must reject by name.
#pragma once

#include <vector>

#include "tests/formats/raw_superelement.hpp"

namespace cbr::test {

bool is_integer(const RawDataset& values);
std::vector<RawDataset> wrong_lengths(const RawDataset& values);  // one row more and one row less
RawDataset with_first(RawDataset values, double entry);
RawDataset of_other_rank(const RawDataset& values);
RawDataset of_other_type(const RawDataset& values);

}  // namespace cbr::test
