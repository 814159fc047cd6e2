// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/fuzz/targets.hpp"

namespace cbr::fuzz {

// A folder of this process, in memory if possible, as readers take file names.
class ScratchFolder {
 public:
  ScratchFolder() {
    const std::filesystem::path memory = "/dev/shm";
    std::error_code error;
    path_ =
        (std::filesystem::is_directory(memory, error) ? memory
                                                      : std::filesystem::temp_directory_path()) /
        ("cbr-fuzz-" + std::to_string(::getpid()));
    std::filesystem::create_directories(path_);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  // A new name, as caches are keyed by name.
  std::filesystem::path fresh(const std::string& suffix) {
    return path_ / (std::to_string(++count_) + suffix);
  }

 private:
  std::filesystem::path path_;
  unsigned long count_ = 0;
};

inline ScratchFolder& scratch() {
  static ScratchFolder folder;
  return folder;
}

// A temporary file with these bytes.
class ScratchFile {
 public:
  ScratchFile(const std::string& suffix, Bytes bytes) : path_(scratch().fresh(suffix)) {
    std::ofstream(path_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }
  explicit ScratchFile(const std::string& suffix) : path_(scratch().fresh(suffix)) {}
  ~ScratchFile() { ::unlink(path_.c_str()); }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace cbr::fuzz
