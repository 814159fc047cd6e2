// SPDX-License-Identifier: GPL-3.0-or-later
// Names that files and terminals can hold.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cbr {

// The fault of a name: "holds bytes that are not UTF-8", "holds a control character (code
// 7)"; empty: nothing.
std::string name_problem(std::string_view name);

// In ASCII, '?' for all other bytes.
std::string printable_name(std::string_view name);

// '/' separates groups in HDF5.
std::string group_name(std::string name);
// InputError when two of the names become one group: "WHAT 'c/t' and 'c_t' ...".
void refuse_equal_groups(const std::vector<std::string>& names, const std::string& what);

}  // namespace cbr
