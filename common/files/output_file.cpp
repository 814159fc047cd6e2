// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/files/output_file.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <set>
#include <string>

#include "common/base/error.hpp"
#include "common/base/name_text.hpp"

namespace cbr {
namespace {

namespace fs = std::filesystem;

// Paths to unlink when a signal ends the process. A handler may only touch lock-free atomics; a run
// has few files open.
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
  if (char* path = alive[slot].exchange(nullptr)) std::free(path);
}

std::string system_text(int error) { return std::strerror(error); }

// rename() asks for the folder's permissions alone; whoever has protected a file does not want it
// replaced. Root may do anything, and is asked all the same.
void refuse_protected(const fs::path& target, const fs::path& resolved) {
  struct stat now = {};
  if (::stat(resolved.c_str(), &now) != 0) return;
  const bool protected_by_all = (now.st_mode & (S_IWUSR | S_IWGRP | S_IWOTH)) == 0;
  const bool refused = ::access(resolved.c_str(), W_OK) != 0;
  if (refused && errno == EROFS)
    throw RunError(target.string() + ": cannot be written: " + std::strerror(EROFS));
  if (protected_by_all || refused)
    throw RunError(target.string() +
                   ": Permission denied: is there and write-protected: make it writable (chmod "
                   "u+w) or give another name");
}

// Keeps the permissions of the replaced file, and its owner and group where the system allows.
void keep_mode(const fs::path& target, int descriptor) {
  struct stat old = {}, now = {};
  if (::fstat(descriptor, &now) != 0) return;
  if (::stat(target.c_str(), &old) != 0) {  // it was removed meanwhile: as a new file
    const mode_t mask = ::umask(0);
    ::umask(mask);
    ::fchmod(descriptor, 0666 & ~mask);
    return;
  }
  mode_t mode = old.st_mode & (S_IRWXU | S_IRWXG | S_IRWXO);
  const bool same_group =
      now.st_gid == old.st_gid || ::fchown(descriptor, static_cast<uid_t>(-1), old.st_gid) == 0;
  if (now.st_uid != old.st_uid) {
    [[maybe_unused]] const int result = ::fchown(descriptor, old.st_uid, static_cast<gid_t>(-1));
  }
  // To another group not more than to all
  if (!same_group) mode = (mode & ~static_cast<mode_t>(S_IRWXG)) | ((mode & S_IRWXO) << 3);
  ::fchmod(descriptor, mode);
}

// Found before the work: the temporary name is short, and rename() comes last.
void require_name(const fs::path& target) {
  const std::string name = target.filename().string();
  if (const std::string problem = name_problem(name); !problem.empty())
    throw InputError("the file name '" + printable_name(name) + "' " + problem +
                     ": give another name");
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const long longest = ::pathconf(folder.c_str(), _PC_NAME_MAX);
  if (longest > 0 && name.size() > static_cast<std::size_t>(longest))
    throw InputError("the file name '" + name.substr(0, 40) + "...' has " +
                     std::to_string(name.size()) + " bytes, at most " + std::to_string(longest) +
                     " are allowed there: give a shorter name");
}

// rename() would replace /dev/null by a regular file, or the link instead of its target.
fs::path resolved_target(const fs::path& target) {
  require_name(target);
  std::error_code error;
  fs::path resolved = target;
  if (fs::is_symlink(target, error)) {
    const auto pointed = fs::weakly_canonical(target, error);
    if (!error) resolved = pointed;
    // In a folder that others may write to, the link's owner would choose the replaced file
    if (fs::weakly_canonical(fs::absolute(target).parent_path(), error) != pointed.parent_path())
      throw InputError(target.string() + ": is a link to " + pointed.string() +
                       ", a file of another folder: give that name, or remove the link");
  }
  const auto status = fs::status(resolved, error);
  if (fs::is_directory(status))
    throw InputError(target.string() + ": is a directory, give the name of a file to write");
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw InputError(target.string() + ": is not a regular file, give the name of a file to write");
  }
  refuse_protected(target, resolved);
  if (target == "-")
    throw InputError(
        "-: what is written here is a file: give it a name (./- for a file of that name)");
  if (resolved.filename().empty())
    throw InputError("'" + target.string() + "': no file name to write to");
  const fs::path folder = resolved.has_parent_path() ? resolved.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error)) {
    throw InputError(target.string() + ": cannot be written, there is no folder '" +
                     folder.string() + "': make it first");
  }
  return resolved;
}

// A rename is on the disk when its folder is. Best effort: not every file system can do it, and the
// file itself is safe.
void sync_folder(const fs::path& folder) {
  const int descriptor =
      ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

// Identifies this machine and its process namespace (containers number processes themselves):
// elsewhere our process numbers mean nothing.
std::string place_of_processes() {
  char text[256] = {};
  ::gethostname(text, sizeof text - 1);
  std::string place = text;
  const auto length = ::readlink("/proc/self/ns/pid", text, sizeof text - 1);
  if (length > 0) place.append(text, static_cast<std::size_t>(length));
  std::uint32_t hash = 2166136261u;  // FNV-1a
  for (const unsigned char c : place) hash = (hash ^ c) * 16777619u;
  constexpr const char* digits = "0123456789abcdef";
  std::string name;
  for (int shift = 28; shift >= 0; shift -= 4) name += digits[hash >> shift & 15u];
  return name;
}

const std::string& name_prefix() {
  static const std::string prefix = ".cbr-" + place_of_processes() + "-";
  return prefix;
}

// A process that was killed outright has left its temporary file; once it is gone, nobody will
// rename it.
bool is_left_behind(const std::string& name) {
  const std::string& prefix = name_prefix();
  if (!name.starts_with(prefix) || !name.ends_with(".tmp")) return false;
  int process = 0;
  const auto [end, error] =
      std::from_chars(name.data() + prefix.size(), name.data() + name.size(), process);
  return error == std::errc() && *end == '-' && process > 0 && ::kill(process, 0) != 0 &&
         errno == ESRCH;
}

// Once for each folder that the process writes to.
void remove_left_behind(const fs::path& folder) {
  static std::mutex lock;
  static std::set<fs::path> done;
  const std::scoped_lock guard(lock);
  if (!done.insert(folder).second) return;
  std::error_code error;
  for (fs::directory_iterator it(folder.empty() ? "." : folder, error), end; !error && it != end;
       it.increment(error))
    if (is_left_behind(it->path().filename().string())) ::unlink(it->path().c_str());
}

}  // namespace

TemporaryFile::TemporaryFile(const fs::path& target) : target_(resolved_target(target)) {
  static std::atomic<unsigned> counter{0};
  remove_left_behind(target_.parent_path());
  for (;;) {
    // A short name of its own: the target's name may already be as long as names can be.
    path_ = target_.parent_path() /
            (name_prefix() + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp");
    // Not to be read by more while it is written than in the end
    std::error_code error;
    const mode_t mode = fs::exists(target_, error) ? 0600 : 0666;
    // Known before it is there: a signal that comes during open() is handled when open() returns.
    // The name is ours alone.
    slot_ = remember(path_);
    const int descriptor = ::open(path_.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, mode);
    if (descriptor >= 0) {
      ::close(descriptor);
      return;
    }
    const int open_error = errno;
    forget(slot_);
    if (open_error != EEXIST)
      throw RunError(target_.string() + ": cannot be written: " + system_text(open_error));
  }
}

TemporaryFile::~TemporaryFile() {
  if (!committed_) ::unlink(path_.c_str());
  forget(slot_);
}

void TemporaryFile::commit() {
  const int descriptor = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = descriptor >= 0 && ::fsync(descriptor) == 0;
  const int sync_error = errno;
  if (descriptor >= 0) keep_mode(target_, descriptor);
  if (descriptor >= 0) ::close(descriptor);
  // Some file systems cannot sync and say EINVAL; everything else means that the bytes are not
  // there.
  if (!synced && sync_error != EINVAL)
    throw RunError(target_.string() + ": cannot be written: " + system_text(sync_error));
  if (::rename(path_.c_str(), target_.c_str()) != 0) {
    throw RunError(target_.string() + ": cannot be written: " + system_text(errno));
  }
  committed_ = true;
  sync_folder(target_.parent_path());
}

void TemporaryFile::fill_with(const fs::path& from) {
  std::error_code error;
  fs::copy_file(from, path_, fs::copy_options::overwrite_existing, error);
  if (error) throw RunError(target_.string() + ": cannot be written: " + error.message());
}

void write_copy(const fs::path& from, const fs::path& target) {
  TemporaryFile file(target);
  file.fill_with(from);
  file.commit();
}

bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (fs::equivalent(a, b, error)) return true;
  const auto plain = [&](const fs::path& file) {
    return fs::weakly_canonical(fs::absolute(file), error);
  };
  return plain(a) == plain(b);
}

void remove_temporary_files() noexcept {
  for (auto& entry : alive) {
    if (char* path = entry.exchange(nullptr)) ::unlink(path);
  }
}

}  // namespace cbr
