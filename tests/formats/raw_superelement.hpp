// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement file by datasets as in docs/formats.md, without the library's writer of
// superelements. It is the contract of the reader, and the file that tests damage.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/superelement/superelement_group.hpp"

namespace cbr::test {

using RawDataset = std::variant<double, Vector, Matrix, std::vector<Index>, IndexTable>;
using RawAttribute = std::variant<std::string, Index, double>;

struct RawFile {
  std::map<std::string, RawDataset> datasets;
  std::map<std::pair<std::string, std::string>, RawAttribute> attributes;  // (object, name)
};

RawFile raw_superelement(const Superelement& superelement, const std::string& prefix = "");
RawFile raw_group(const SuperelementGroup& group);
void write_raw(const RawFile& raw, const std::filesystem::path& file);

// Damage to one dataset, which a reader must reject by name.
bool is_integer(const RawDataset& values);
std::vector<RawDataset> wrong_lengths(const RawDataset& values);  // one row more and one row less
RawDataset with_first(RawDataset values, double entry);
RawDataset of_other_rank(const RawDataset& values);
RawDataset of_other_type(const RawDataset& values);

}  // namespace cbr::test
