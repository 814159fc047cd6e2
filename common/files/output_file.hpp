// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/files: files that are whole or not there; HDF5, netCDF, the state of a run.
//
// Files that are whole or not there: written under a temporary name in the same folder, renamed
// when whole.
#pragma once

#include <filesystem>

namespace cbr {

// An empty file of a unique name beside `target`, for any library to fill. commit() renames it to
// the target in one step. Without commit() the destructor removes it, and so does a signal that
// ends a program of run_program(). A replaced file's permissions are kept. Removes files of
// processes that were killed outright.
class TemporaryFile {
 public:
  // InputError: the target's folder is missing, or the target is there and is no regular file, or a
  // link out of its folder.
  // RunError: it is write-protected; the system refuses.
  explicit TemporaryFile(const std::filesystem::path& target);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::filesystem::path& path() const { return path_; }      // of the temporary file
  const std::filesystem::path& target() const { return target_; }  // symbolic links followed
  // To the disk, then renamed. Whoever wrote path() has closed it. RunError names the target.
  void commit();
  // a copy of that file. RunError names the target.
  void fill_with(const std::filesystem::path& from);

 private:
  std::filesystem::path target_, path_;
  int slot_ = -1;  // in the list that remove_temporary_files() goes through
  bool committed_ = false;
};

// A copy of `from` in the target's place, whole or not at all. RunError names the target.
void write_copy(const std::filesystem::path& from, const std::filesystem::path& target);

// By another name too, as a link's; of files that are not there yet by their names.
bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

// Unlinks every TemporaryFile alive. Safe inside a signal handler; for the end of the process only.
void remove_temporary_files() noexcept;

}  // namespace cbr
