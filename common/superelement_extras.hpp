// SPDX-License-Identifier: GPL-3.0-or-later
// What a superelement may have beyond its matrices since version 1.2 of its file: /accuracy and /loads.
#pragma once

#include <string>

#include "common/hdf5_file.hpp"
#include "common/superelement.hpp"

namespace cbr {

inline constexpr const char* extras_version = "1.2";

bool has_extras(const Superelement& superelement);
void write_extras(Hdf5Writer& file, const std::string& prefix, const Superelement& superelement);
void read_extras(const Hdf5Reader& file, const std::string& prefix, Superelement& superelement);
// InputError "WHERE: FIELD: ..."
void check_extras(const Superelement& superelement, const std::string& where);

}  // namespace cbr
