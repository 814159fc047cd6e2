// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement inside an HDF5 file: at its root, or at a group of a file that holds several.
#pragma once

#include <optional>
#include <string>

#include "common/files/checked_files.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/superelement/superelement.hpp"

namespace cbr {

inline constexpr const char* superelement_format = "cbr-superelement";
inline constexpr const char* superelement_group_format = "cbr-superelement-group";
// Of files written now: datasets have checksums. Older versions: docs/formats.md.
inline constexpr const char *superelement_version = "1.16", *superelement_group_version = "1.3";

// A new superelement may replace these files.
inline FileKind superelement_kind() {
  return {.noun = "a superelement",
          .hdf5_formats = {superelement_format, superelement_group_format}};
}

// `prefix`: "" for the root, or "/domains/1". Attributes, too, stand at the prefix. InputErrors as
// of read_superelement().
void write_superelement_at(Hdf5Writer& file, const std::string& prefix,
                           const Superelement& superelement);
Superelement read_superelement_at(const Hdf5Reader& file, const std::string& prefix,
                                  const SuperelementParts& parts);

// Common to superelements and groups of them.
void write_format(Hdf5Writer& file, const std::string& prefix, const std::string& format,
                  const std::string& format_version);
void check_format(const Hdf5Reader& file, const std::string& prefix, const std::string& format);
void write_rigid_body(Hdf5Writer& file, const std::string& prefix, const RigidBody& body);
RigidBody read_rigid_body(const Hdf5Reader& file, const std::string& prefix);
// InputError unless the attribute has this value, which is the length of `dataset`.
void check_count(const Hdf5Reader& file, const std::string& prefix, const std::string& attribute,
                 Index found, const std::string& dataset);

// What a superelement may have beyond its matrices: since version 1.2 of its file /accuracy and
// /loads, since 1.4 /conditioning, which a group of them may have, too, since its version 1.1.

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
