// SPDX-License-Identifier: GPL-3.0-or-later
// What a superelement may have beyond its matrices: since version 1.2 of its file /accuracy and
// /loads, since 1.4 /conditioning, which a group of them may have, too, since its version 1.1.
#pragma once

#include <optional>
#include <string>

#include "common/files/hdf5_file.hpp"
#include "common/superelement/superelement.hpp"

namespace cbr {

// The object that carries the attributes.
std::string file_root(const std::string& prefix);

void write_extras(Hdf5Writer& file, const std::string& prefix, const Superelement& superelement);
void read_extras(const Hdf5Reader& file, const std::string& prefix, Superelement& superelement);
// InputError "WHERE: FIELD: ..."
void check_extras(const Superelement& superelement, const std::string& where);

// Figures that are not known are not in the file. InputErrors name /conditioning and the figure;
// `n`: coordinates there are.
void write_conditioning(Hdf5Writer& file, const std::string& prefix,
                        const std::optional<Conditioning>& conditioning);
std::optional<Conditioning> read_conditioning(const Hdf5Reader& file, const std::string& prefix);
void check_conditioning(const std::optional<Conditioning>& conditioning, Index n,
                        const std::string& where);

}  // namespace cbr
