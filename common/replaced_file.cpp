// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/replaced_file.hpp"

#include <algorithm>
#include <optional>

#include "common/error.hpp"
#include "common/hdf5_file.hpp"

namespace cbr {
namespace {

// "" for an HDF5 file that says nothing of its format; none for what is no HDF5 file that can be read.
std::optional<std::string> hdf5_format(const std::filesystem::path& file) {
  try {
    const Hdf5Reader reader(file);
    if (!reader.has_attribute("/", "format") || !reader.is_string("/", "format")) return "";
    return reader.read_string("/", "format");
  } catch (const InputError&) {
    return {};
  }
}

}  // namespace

void refuse_other_hdf5(const std::filesystem::path& target, const std::vector<std::string>& formats, const std::string& what,
                       const std::string& cure) {
  const std::optional<std::string> found = hdf5_format(target);
  if (!found || std::find(formats.begin(), formats.end(), *found) != formats.end()) return;
  throw InputError(target.string() + ": is there and is another kind of HDF5 file (" +
                   (found->empty() ? "without a format" : "format " + *found) + "), which " + what + " would replace: " + cure);
}

}  // namespace cbr
