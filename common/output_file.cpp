// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/output_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <string>

#include "common/error.hpp"

namespace cbr {
namespace {

namespace fs = std::filesystem;

// Paths to unlink when a signal ends the process. A handler may only touch lock-free atomics; a run has few files open.
std::array<std::atomic<char*>, 256> alive{};

int remember(const fs::path& path) {
  char* copy = ::strdup(path.c_str());
  for (std::size_t i = 0; i < alive.size(); ++i) {
    char* none = nullptr;
    if (alive[i].compare_exchange_strong(none, copy)) return static_cast<int>(i);
  }
  std::free(copy);
  return -1;  // still removed by the destructor
}

void forget(int slot) {
  if (slot < 0) return;
  // Null: a handler has taken the string and the process is ending, so it is left alone.
  if (char* path = alive[static_cast<std::size_t>(slot)].exchange(nullptr)) std::free(path);
}

std::string system_text(int error) { return std::strerror(error); }

// rename() would put a regular file in the place of /dev/null, or of the link instead of what it points to.
fs::path resolved_target(const fs::path& target) {
  std::error_code error;
  fs::path resolved = target;
  if (fs::is_symlink(target, error)) {
    const auto pointed = fs::weakly_canonical(target, error);
    if (!error) resolved = pointed;
  }
  const auto status = fs::status(resolved, error);
  if (fs::is_directory(status)) throw InputError(target.string() + ": is a directory, give the name of a file to write");
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw InputError(target.string() + ": is not a regular file, give the name of a file to write");
  }
  if (resolved.filename().empty()) throw InputError("'" + target.string() + "': no file name to write to");
  const fs::path folder = resolved.has_parent_path() ? resolved.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error)) {
    throw InputError(target.string() + ": cannot be written, there is no folder '" + folder.string() + "': make it first");
  }
  return resolved;
}

// A rename is on the disk when its folder is. Best effort: not every file system can do it, and the file itself is safe.
void sync_folder(const fs::path& folder) {
  const int descriptor = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace

TemporaryFile::TemporaryFile(const fs::path& target) : target_(resolved_target(target)) {
  static std::atomic<unsigned> counter{0};
  for (;;) {
    // A short name of its own: the target's name may already be as long as names can be.
    path_ = target_.parent_path() / (".cbr-" + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp");
    const int descriptor = ::open(path_.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
    if (descriptor >= 0) {
      ::close(descriptor);
      break;
    }
    if (errno != EEXIST) throw RunError(target_.string() + ": cannot be written: " + system_text(errno));
  }
  slot_ = remember(path_);
}

TemporaryFile::~TemporaryFile() {
  if (!committed_) ::unlink(path_.c_str());
  forget(slot_);
}

void TemporaryFile::commit() {
  const int descriptor = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = descriptor >= 0 && ::fsync(descriptor) == 0;
  const int sync_error = errno;
  if (descriptor >= 0) ::close(descriptor);
  // Some file systems cannot sync and say EINVAL; everything else means that the bytes are not there.
  if (!synced && sync_error != EINVAL) throw RunError(target_.string() + ": cannot be written: " + system_text(sync_error));
  if (::rename(path_.c_str(), target_.c_str()) != 0) {
    throw RunError(target_.string() + ": cannot be written: " + system_text(errno));
  }
  committed_ = true;
  sync_folder(target_.parent_path());
}

void remove_temporary_files() noexcept {
  for (auto& entry : alive) {
    if (char* path = entry.exchange(nullptr)) ::unlink(path);
  }
}

}  // namespace cbr
