// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement file spelt out dataset by dataset, as docs/formats.md has it and without the
// library's own writer of superelements: the reader's contract, and what the tests damage.
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

}  // namespace cbr::test
