// SPDX-License-Identifier: GPL-3.0-or-later
// Files that are not to be lost or mixed: an output with a mistyped name must not cost the user
// another file, and inputs must not change while they are read.
#pragma once

#include <sys/stat.h>

#include <filesystem>
#include <string>
#include <utility>
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

// Inputs that are read in several parts, hashed and read: replaced in between they would be a
// mixture.
class UnchangedFiles {
 public:
  // as it is now. One that is not there is left to whoever reads it.
  void add(const std::filesystem::path& file);
  // RunError: one was replaced or written to since it was added
  void check() const;

 private:
  std::vector<std::pair<std::filesystem::path, struct stat>> files_;
};

}  // namespace cbr
