// SPDX-License-Identifier: GPL-3.0-or-later
// A mistyped name of an output must not cost the user another file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cbr {

// Marks of a file of one kind, as written by a program of cbr. Empty ones are not checked.
struct FileKind {
  std::string noun;                                // "a table of timings", for messages
  std::vector<std::string> hdf5_formats = {};      // the root attribute 'format' is one of these
  std::string start = {};                          // ECMAScript, in the first 400 bytes of a text
  std::string netcdf_title = {};                   // ECMAScript, of the whole title
  std::vector<std::filesystem::path> beside = {};  // must be there, too
};

// InputError when `target` exists and is not recognised: "FILE: exists and is not NOUN; WHAT would
// overwrite it: CURE". Empty files pass, and damaged HDF5 files where HDF5 is expected.
void refuse_other_file(const std::filesystem::path& target, const FileKind& kind,
                       const std::string& what, const std::string& cure);

}  // namespace cbr
