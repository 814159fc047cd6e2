// SPDX-License-Identifier: GPL-3.0-or-later
// A write that fails says why, leaves nothing behind and spoils nothing that was there.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/files/output_file.hpp"
#include "common/superelement/superelement.hpp"
#include "tests/formats/sample_superelement.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"

namespace cbr::failed_write_test {
namespace {

using test::TemporaryFolder;

class FailedWrite : public testing::Test {
 protected:
  // A file of several MB: some of it goes to the disk at once, some when it is closed.
  static void write(const std::filesystem::path& file) {
    Hdf5Writer writer(file);
    writer.attribute("/", "text", std::string(300, 'x'));
    writer.write("/large/matrix", Matrix(Matrix::Random(700, 300)));
    for (int i = 0; i < 50; ++i)
      writer.write("/small/" + std::to_string(i), Vector(Vector::Ones(10)));
    writer.commit();
  }

  // In a process of its own: as on a disk with room for so many bytes. Exit code 0: refused as it
  // should be.
  [[noreturn]] static void write_with_room_for(rlim_t bytes, const std::filesystem::path& file) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, bytes};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    int code = 3;
    try {
      write(file);
    } catch (const RunError& error) {
      code = std::string(error.what()).find(file.string()) != std::string::npos ? 0 : 4;
    }
    std::exit(code);  // the library's own clean-up must come to an end, too
  }

  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "s.h5";
};

using FailedWriteDeathTest = FailedWrite;

TEST_F(FailedWriteDeathTest, diskFullAtAnyPointLeavesTheOldFile) {
  write(file);
  const auto size = std::filesystem::file_size(file);
  test::write_bytes(file, "what was there before");
  for (const auto room : {std::uintmax_t{0}, std::uintmax_t{100}, std::uintmax_t{5000}, size / 4,
                          size - 20000, size - 1000, size - 1}) {
    EXPECT_EXIT(write_with_room_for(room, file), testing::ExitedWithCode(0), "")
        << room << " of " << size;
    EXPECT_EQ(test::bytes_of(file), "what was there before") << room;
    EXPECT_EQ(folder.n_entries(), 1u) << room;
  }
  // The library makes the file somewhat longer before it cuts it to its length.
  // 3: written
  EXPECT_EXIT(write_with_room_for(size + 10000, file), testing::ExitedWithCode(3), "");
  EXPECT_EQ(std::filesystem::file_size(file), size);
}

// A program may go on after a write that failed, and write elsewhere.
TEST_F(FailedWriteDeathTest, theNextFileIsWhole) {
  const auto fail_and_go_on = [&] {
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit limit{};
    ::getrlimit(RLIMIT_FSIZE, &limit);
    for (int i = 0; i < 5; ++i) {
      limit.rlim_cur = 30000;
      ::setrlimit(RLIMIT_FSIZE, &limit);
      EXPECT_THROW(write(file), RunError);
      limit.rlim_cur = limit.rlim_max;
      ::setrlimit(RLIMIT_FSIZE, &limit);
      write(folder / "next.h5");
      if (Hdf5Reader(folder / "next.h5").read_vector("/small/49") != Vector::Ones(10)) std::exit(1);
    }
    std::exit(testing::Test::HasFailure() ? 1 : 0);
  };
  EXPECT_EXIT(fail_and_go_on(), testing::ExitedWithCode(0), "");
}

TEST_F(FailedWrite, withoutCommitNothingIsLeft) {
  {
    Hdf5Writer writer(file);
    writer.write("/values", Vector(Vector::Ones(1000)));
    EXPECT_EQ(folder.n_entries(), 1u);
    EXPECT_FALSE(std::filesystem::exists(file));
  }
  EXPECT_EQ(folder.n_entries(), 0u);
}

TEST_F(FailedWrite, superelementThatBreaksARuleLeavesNothing) {
  Superelement s = test::sample_superelement();
  s.M_cc(0, 1) += 1;
  EXPECT_THROW(write_superelement(s, file), InputError);
  EXPECT_EQ(folder.n_entries(), 0u);
}

TEST_F(FailedWrite, targetsThatAreNoFile) {
  EXPECT_THROW(write(folder.path()), InputError);
  EXPECT_THROW(write(folder / "no such folder" / "s.h5"), InputError);
  EXPECT_THROW(write("/dev/null"), InputError);
  EXPECT_THROW(write(""), InputError);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  EXPECT_EQ(folder.n_entries(), 0u);
}

TEST_F(FailedWrite, folderThatCannotBeWritten) {
  std::filesystem::path closed = folder.path();
  if (::geteuid() == 0) {
    closed = "/proc/self";  // root may write everywhere else
  } else {
    std::filesystem::permissions(
        folder.path(), std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  }
  EXPECT_SAYS(test::refusal_of<RunError>([&] { write(closed / "s.h5"); }),
              (closed / "s.h5").string());
}

TEST_F(FailedWrite, aLinkIsFollowedAndStays) {
  const auto link = folder / "link.h5";
  test::write_bytes(file, "old");
  std::filesystem::create_symlink("s.h5", link);
  write(link);
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(Hdf5Reader(file).shape("/large/matrix"), (std::vector<Index>{700, 300}));
  EXPECT_EQ(folder.n_entries(), 2u);
}

TEST_F(FailedWrite, permissionsAreThoseOfWhatIsReplaced) {
  namespace fs = std::filesystem;
  using fs::perms;
  for (const perms mode : {perms(0600), perms(0640), perms(0666)}) {
    test::write_bytes(file, "old");
    fs::permissions(file, mode);
    write(file);
    EXPECT_EQ(fs::status(file).permissions(), mode);
    EXPECT_EQ(Hdf5Reader(file).shape("/large/matrix"), (std::vector<Index>{700, 300}));
  }
  test::write_bytes(file, "protected");
  fs::permissions(file, perms(0444));
  EXPECT_SAYS(test::refusal_of<RunError>([&] { write(file); }), "write-protected");
  EXPECT_EQ(test::bytes_of(file), "protected");
  EXPECT_EQ(folder.n_entries(), 1u);
}

TEST_F(FailedWrite, namesAsLongAsNamesCanBe) {
  const auto longest = folder / (std::string(252, 'n') + ".h5");
  write(longest);
  EXPECT_TRUE(std::filesystem::exists(longest));
}

}  // namespace
}  // namespace cbr::failed_write_test
