// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/files/netcdf_header.hpp"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "common/base/error.hpp"

namespace cbr {
namespace {

class Header {
 public:
  Header(std::string bytes, double file_size, std::string where)
      : bytes_(std::move(bytes)),
        where_(std::move(where)),
        file_size_(file_size),
        version_(bytes_[3]) {}

  void check() {
    at_ = 4;
    const std::uint64_t records = wide();
    const bool streaming = records == (version_ == 5 ? ~std::uint64_t{0} : 0xffffffffULL);
    read_dimensions();
    read_attributes();
    const std::uint64_t n = list(0x0B, "variables");
    std::set<std::string> names;
    double record_bytes = 0, record_end = 0;
    for (std::uint64_t i = 0; i < n; ++i) {
      const std::string name = read_name(names);
      bool record = false;
      double size = 1;
      const std::uint64_t rank = wide();
      if (rank > dimensions_.size()) fail(name + " has an impossible number of dimensions");
      for (std::uint64_t d = 0; d < rank; ++d) {
        const std::uint64_t id = wide();
        if (id >= dimensions_.size()) fail(name + " refers to a dimension that does not exist");
        if (dimensions_[id] == 0 && d > 0)
          fail(name + " has its unlimited dimension in the wrong place");
        record = record || dimensions_[id] == 0;
        size *= dimensions_[id] == 0 ? 1.0 : static_cast<double>(dimensions_[id]);
      }
      read_attributes();
      size *= type_size();
      wide();  // vsize: redundant, and wrong by design for large variables
      const auto begin = static_cast<double>(version_ == 1 ? narrow() : number(8));
      if (begin < 0 || (!record && begin + size > file_size_))
        fail(name + " ends at byte " +
             std::to_string(static_cast<std::int64_t>(std::min(begin + size, 9e18))) + " of " +
             std::to_string(static_cast<std::int64_t>(file_size_)));
      if (record) {
        record_bytes += size;
        record_end = std::max(record_end, begin + size);
      }
    }
    // The last record begins (records - 1) strides after the first.
    if (!streaming && record_bytes > 0 && records > 0 &&
        record_end + static_cast<double>(records - 1) * record_bytes > file_size_)
      fail("the records end beyond the file");
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(where_ + ": is cut short or damaged: " + what + " (header of a netCDF file)");
  }

  std::uint64_t number(std::size_t bytes) {
    if (at_ + bytes > bytes_.size()) fail("the header is incomplete");
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i)
      value = value << 8 | static_cast<unsigned char>(bytes_[at_ + i]);
    at_ += bytes;
    return value;
  }
  std::uint64_t narrow() { return number(4); }
  std::uint64_t wide() { return number(version_ == 5 ? 8 : 4); }

  void skip(std::uint64_t bytes) {
    const std::uint64_t all = (bytes + 3) / 4 * 4;
    if (bytes > bytes_.size() || at_ + all > bytes_.size()) fail("the header is incomplete");
    at_ += static_cast<std::size_t>(all);
  }

  std::uint64_t list(std::uint64_t tag, const std::string& what) {
    const std::uint64_t found = narrow(), n = wide();
    if ((found != tag && (found != 0 || n != 0)) || n > bytes_.size())
      fail("the list of " + what + " is unreadable");
    return n;
  }

  std::string read_name(std::set<std::string>& names) {
    const std::uint64_t length = wide();
    const std::size_t start = at_;
    skip(length);
    const std::string name = bytes_.substr(start, static_cast<std::size_t>(length));
    const bool legal = length > 0 && length <= 256 &&
                       std::all_of(name.begin(), name.end(),
                                   [](char c) { return static_cast<unsigned char>(c) > 0x20; });
    if (!legal) fail("a name is unreadable");
    if (!names.insert(name).second) fail("two things are named " + name);
    return name;
  }

  double type_size() {
    static const double sizes[] = {0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};
    const std::uint64_t type = narrow();
    if (type < 1 || type > (version_ == 5 ? 11U : 6U)) fail("an unknown type of number");
    return sizes[type];
  }

  void read_dimensions() {
    const std::uint64_t n = list(0x0A, "dimensions");
    std::set<std::string> names;
    for (std::uint64_t i = 0; i < n; ++i) {
      read_name(names);
      dimensions_.push_back(wide());
    }
    if (std::count(dimensions_.begin(), dimensions_.end(), 0U) > 1)
      fail("two dimensions are unlimited");
  }

  void read_attributes() {
    const std::uint64_t n = list(0x0C, "attributes");
    std::set<std::string> names;
    for (std::uint64_t i = 0; i < n; ++i) {
      read_name(names);
      const double size = type_size();
      const std::uint64_t count = wide();
      if (count > bytes_.size()) fail("an attribute is unreadable");
      skip(count * static_cast<std::uint64_t>(size));
    }
  }

  std::string bytes_, where_;
  double file_size_;
  int version_;
  std::size_t at_ = 0;
  std::vector<std::uint64_t> dimensions_;
};

}  // namespace

bool check_classic_netcdf(const std::filesystem::path& file) {
  constexpr double longest_header = 1 << 26;
  std::error_code error;
  const auto size = static_cast<double>(std::filesystem::file_size(file, error));
  std::ifstream stream(file, std::ios::binary);
  char magic[4] = "";
  if (!stream.read(magic, 4) || std::string(magic, 3) != "CDF" ||
      (magic[3] != 1 && magic[3] != 2 && magic[3] != 5))
    return false;
  std::string bytes(static_cast<std::size_t>(std::min(size, longest_header)), '\0');
  stream.seekg(0);
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size())))
    throw InputError(file.string() + ": could not be read");
  Header(std::move(bytes), size, file.string()).check();
  return true;
}

}  // namespace cbr
