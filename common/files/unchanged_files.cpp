// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/files/unchanged_files.hpp"

#include "common/base/error.hpp"

namespace cbr {

void UnchangedFiles::add(const std::filesystem::path& file) {
  struct stat now = {};
  if (::stat(file.c_str(), &now) == 0) files_.emplace_back(file, now);
}

void UnchangedFiles::check() const {
  for (const auto& [file, before] : files_) {
    struct stat now = {};
    const bool same = ::stat(file.c_str(), &now) == 0 && now.st_dev == before.st_dev &&
                      now.st_ino == before.st_ino && now.st_size == before.st_size &&
                      now.st_mtim.tv_sec == before.st_mtim.tv_sec &&
                      now.st_mtim.tv_nsec == before.st_mtim.tv_nsec;
    if (!same)
      throw RunError(file.string() + ": was replaced or changed while it was read: run again");
  }
}

}  // namespace cbr
