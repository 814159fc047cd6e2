// SPDX-License-Identifier: GPL-3.0-or-later
// Files that are replaced while they are read, what a signal and a killed process leave behind.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <filesystem>
#include <functional>
#include <string>

#include "common/base/error.hpp"
#include "common/files/checked_files.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/files/output_file.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"

static int signal_during_open = 0;
static int writes_before_a_full_disk = -1;  // the one after them fails, the next do not

static ssize_t write_at(int descriptor, const void* data, size_t size, off_t place) {
  if (writes_before_a_full_disk >= 0 && writes_before_a_full_disk-- == 0) {
    errno = ENOSPC;
    return -1;
  }
  return ::syscall(SYS_pwrite64, descriptor, data, size, place);
}

extern "C" ssize_t pwrite(int descriptor, const void* data, size_t size, off_t place) {
  return write_at(descriptor, data, size, place);
}
extern "C" ssize_t pwrite64(int descriptor, const void* data, size_t size, off64_t place) {
  return write_at(descriptor, data, size, place);
}

// In the place of libc's: as a signal that comes while the system makes the file, on a busy disk,
// and is handled as open() returns.
extern "C" int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  const auto descriptor = static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, flags, mode));
  if (signal_during_open != 0 && (flags & O_CREAT) != 0) std::raise(signal_during_open);
  return descriptor;
}

namespace cbr::files_test {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

TEST(UnchangedFiles, WhatIsReplacedOrWrittenToIsNamed) {
  const TemporaryFolder folder;
  const fs::path file = folder / "a.msh", other = folder / "b.msh";
  test::write_bytes(file, "one");
  test::write_bytes(other, "one");
  const auto after = [&](const std::function<void()>& change) {
    UnchangedFiles files;
    files.add(file);
    files.add(other);
    files.add(folder / "missing");
    files.check();
    change();
    return test::refusal_of<RunError>([&] { files.check(); });
  };
  EXPECT_EQ(after([] {}), "no error");
  // The same bytes under the same name, but another file: whatever was read of the first may not be
  // of the second
  const auto replace = [&] {
    TemporaryFile made(file);
    test::write_bytes(made.path(), "one");
    made.commit();
  };
  const auto grow = [&] { test::write_bytes(file, "one and more"); };
  const auto remove = [&] { fs::remove(file); };
  for (const std::function<void()>& change :
       {std::function<void()>(replace), std::function<void()>(grow),
        std::function<void()>(remove)}) {
    EXPECT_SAYS(after(change), file.string(), "run again");
  }
}

// Number of temporary files in the folder.
int n_temporary(const fs::path& folder) {
  int n = 0;
  for (const auto& entry : fs::directory_iterator(folder)) n += entry.path().extension() == ".tmp";
  return n;
}

TEST(TemporaryFile, IsGoneWhenASignalComesWhileItIsMade) {
  const TemporaryFolder folder;
  const pid_t child = ::fork();
  if (child == 0) {
    std::signal(SIGTERM, [](int) {
      remove_temporary_files();
      ::_exit(7);
    });
    signal_during_open = SIGTERM;
    const TemporaryFile file(folder / "a.h5");
    ::_exit(8);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 7) << status;
  EXPECT_EQ(folder.n_entries(), 0u);
}

class KilledProcess : public testing::Test {
 protected:
  // A process that is killed while it writes.
  void leave_a_temporary_file() const {
    const pid_t child = ::fork();
    if (child == 0) {
      const TemporaryFile file(folder_ / "a.h5");
      ::raise(SIGKILL);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
  }
  const TemporaryFolder folder_;
};

TEST_F(KilledProcess, NextRunRemovesWhatItLeft) {
  test::write_bytes(folder_ / "a.h5", "before");
  for (int i = 0; i < 3; ++i) leave_a_temporary_file();
  EXPECT_GE(n_temporary(folder_.path()), 1);
  // Not ours: of a process that lives, of another machine, of another program
  const TemporaryFolder elsewhere;
  const std::string alive = TemporaryFile(elsewhere / "b.h5").path().filename().string();
  const fs::path of_alive = folder_ / alive, foreign = folder_ / ".cbr-00000000-999999999-0.tmp",
                 other = folder_ / ".cbr-mine.tmp";
  for (const fs::path& file : {of_alive, foreign, other}) test::write_bytes(file, "");
  const pid_t next = ::fork();
  if (next == 0) {
    {
      TemporaryFile file(folder_ / "a.h5");
      test::write_bytes(file.path(), "after");
      file.commit();
    }
    ::_exit(0);
  }
  ::waitpid(next, nullptr, 0);
  EXPECT_EQ(test::bytes_of(folder_ / "a.h5"), "after");
  EXPECT_EQ(n_temporary(folder_.path()), 3);
  for (const fs::path& file : {of_alive, foreign, other}) EXPECT_TRUE(fs::exists(file)) << file;
}

// A disk that is full for a moment: told, or the file is right.
TEST(FullForAMoment, IsToldOrDoesNoHarm) {
  const TemporaryFolder folder;
  const fs::path file = folder / "a.h5";
  const Vector values = Vector::LinSpaced(50, 1, 2);
  const Matrix matrix = values * values.transpose();
  int n_told = 0, n_writes = 0;
  for (bool reached = true; reached; ++n_writes) {
    writes_before_a_full_disk = n_writes;
    bool told = false;
    try {
      Hdf5Writer writer(file);
      for (int i = 0; i < 5; ++i) writer.write("/steps/" + std::to_string(i) + "/u", values);
      writer.write("/K", matrix);
      writer.attribute("/", "name", std::string("x"));
      writer.commit();
    } catch (const RunError& error) {
      told = true;
      EXPECT_SAYS(error.what(), "No space left");
    }
    reached = writes_before_a_full_disk < 0;
    writes_before_a_full_disk = -1;
    n_told += told;
    if (told) continue;
    const Hdf5Reader reader(file);
    for (int i = 0; i < 5; ++i)
      EXPECT_EQ(reader.read_vector("/steps/" + std::to_string(i) + "/u"), values) << n_writes;
    EXPECT_EQ(reader.read_matrix("/K"), matrix) << n_writes;
    EXPECT_EQ(reader.read_string("/", "name"), "x");
  }
  EXPECT_GT(n_told, 5);
  EXPECT_EQ(folder.n_entries(), 1u);
}

TEST(TemporaryFile, HasTheModeOfANewFileWhereTheOldOneHasGone) {
  const TemporaryFolder folder;
  test::write_bytes(folder / "a.h5", "before");
  const fs::perms usual = fs::status(folder / "a.h5").permissions();
  TemporaryFile file(folder / "a.h5");
  fs::remove(folder / "a.h5");
  file.commit();
  EXPECT_EQ(fs::status(folder / "a.h5").permissions(), usual);
}

// What a checkpoint keeps of fields that are still being written: a whole file, and the next writer
// goes on with it.
TEST(SavedCopy, IsWholeAndGoesOn) {
  const TemporaryFolder folder;
  const fs::path file = folder / "a.h5", saved = folder / "saved.h5";
  const Vector values = Vector::LinSpaced(5000, 0, 1);
  {
    Hdf5Writer writer(file);
    writer.attribute("/", "name", std::string("x"));
    for (int i = 0; i < 3; ++i)
      writer.write("/steps/" + std::to_string(i) + "/u", Vector(values * i));
    writer.save_copy(saved);
    writer.write("/steps/3/u", values);
  }  // ended here, not committed
  EXPECT_FALSE(fs::exists(file));
  EXPECT_EQ(Hdf5Reader(saved).read_vector("/steps/2/u"), values * 2);
  EXPECT_FALSE(Hdf5Reader(saved).has("/steps/3"));
  {
    Hdf5Writer writer(file, saved);
    EXPECT_TRUE(writer.remove("/steps/2"));
    EXPECT_FALSE(writer.remove("/steps/2"));
    EXPECT_FALSE(writer.remove("/nowhere/2"));
    writer.write("/steps/2/u", Vector(values * 7));
    writer.commit();
  }
  const Hdf5Reader whole(file);
  EXPECT_EQ(whole.read_string("/", "name"), "x");
  EXPECT_EQ(whole.read_vector("/steps/1/u"), values);
  EXPECT_EQ(whole.read_vector("/steps/2/u"), values * 7);
  EXPECT_EQ(Hdf5Reader(saved).read_vector("/steps/2/u"), values * 2);
  test::write_bytes(saved, "no HDF5");
  EXPECT_THROW(Hdf5Writer(file, saved), InputError);
  EXPECT_EQ(folder.n_entries(), 2u);
}

}  // namespace
}  // namespace cbr::files_test
