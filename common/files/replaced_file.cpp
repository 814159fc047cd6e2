// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/files/replaced_file.hpp"

#include <algorithm>
#include <fstream>
#include <optional>
#include <string_view>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"

namespace cbr {
namespace {

// "" for an HDF5 file that says nothing of its format; none for what is no HDF5 file that can be
// read.
std::optional<std::string> hdf5_format(const std::filesystem::path& file) {
  try {
    const Hdf5Reader reader(file, Hdf5Reader::Look::root_attributes);
    if (!reader.has_attribute("/", "format") || !reader.is_string("/", "format")) return "";
    return reader.read_string("/", "format");
  } catch (const InputError&) {
    return {};
  }
}

bool is_something_else(const std::filesystem::path& file) {
  constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error) ||
      std::filesystem::file_size(file, error) == 0)
    return false;
  std::string start(signature.size(), '\0');
  std::ifstream in(file, std::ios::binary);
  return !in.read(start.data(), static_cast<std::streamsize>(start.size())) || start != signature;
}

}  // namespace

void refuse_other_file(const std::filesystem::path& target, const std::vector<std::string>& formats,
                       const std::string& what, const std::string& cure) {
  if (is_something_else(target))
    throw InputError(target.string() + ": exists and is not an HDF5 file; " + what +
                     " would overwrite it: " + cure);
  const std::optional<std::string> found = hdf5_format(target);
  if (!found || std::find(formats.begin(), formats.end(), *found) != formats.end()) return;
  throw InputError(target.string() + ": exists and is another kind of HDF5 file (" +
                   (found->empty() ? "without a format" : "format " + *found) + "), which " + what +
                   " would overwrite: " + cure);
}

}  // namespace cbr
