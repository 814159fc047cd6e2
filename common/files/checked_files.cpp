// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/files/checked_files.hpp"

#include <algorithm>
#include <fstream>
#include <optional>
#include <regex>
#include <string_view>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/files/netcdf_file.hpp"

namespace cbr {
namespace {

std::string first_bytes(const std::filesystem::path& file) {
  std::string start(400, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(in.gcount());
  return start;
}

// "" for an HDF5 file that says nothing of its format; none for one that cannot be read.
std::optional<std::string> hdf5_format(const std::filesystem::path& file) {
  try {
    const Hdf5Reader reader(file, Hdf5Reader::Look::root_attributes);
    return reader.texts("/")["format"];
  } catch (const InputError&) {
    return {};
  }
}

// "" when it is of the formats, else a description of the file.
std::string other_than_hdf5(const std::filesystem::path& file, const std::string& start,
                            const std::vector<std::string>& formats) {
  constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";
  if (!start.starts_with(signature)) return "is not an HDF5 file";
  const std::optional<std::string> found = hdf5_format(file);
  if (!found || std::find(formats.begin(), formats.end(), *found) != formats.end()) return "";
  return "is another kind of HDF5 file (" +
         (found->empty() ? "without a format" : "format " + *found) + ")";
}

std::string netcdf_title(const std::filesystem::path& file) {
  try {
    return NetcdfReader(file).text("", "title");
  } catch (const InputError&) {
    return "";
  }
}

}  // namespace

void refuse_other_file(const std::filesystem::path& target, const FileKind& kind,
                       const std::string& what, const std::string& cure) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(target, error) ||
      std::filesystem::file_size(target, error) == 0)
    return;
  const std::string start = first_bytes(target);
  bool is_ours = std::all_of(kind.beside.begin(), kind.beside.end(), [](const auto& file) {
    std::error_code ignored;
    return std::filesystem::exists(file, ignored);
  });
  if (!kind.start.empty()) is_ours &= std::regex_search(start, std::regex(kind.start));
  if (!kind.netcdf_title.empty())
    is_ours &= std::regex_match(netcdf_title(target), std::regex(kind.netcdf_title));
  std::string other = is_ours ? "" : "is not " + kind.noun + " that cbr wrote";
  if (!kind.hdf5_formats.empty()) other = other_than_hdf5(target, start, kind.hdf5_formats);
  if (!other.empty())
    throw InputError(target.string() + ": exists and " + other + "; " + what +
                     " would overwrite it: " + cure);
}

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
