// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement inside an HDF5 file: at its root, or at a group of a file that holds several.
#pragma once

#include <string>

#include "common/files/hdf5_file.hpp"
#include "common/files/replaced_file.hpp"
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

}  // namespace cbr
