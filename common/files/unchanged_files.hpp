// SPDX-License-Identifier: GPL-3.0-or-later
// Inputs that are read in several parts, hashed and read: replaced in between they would be a
// mixture.
#pragma once

#include <sys/stat.h>

#include <filesystem>
#include <utility>
#include <vector>

namespace cbr {

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
