// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/files/netcdf_file.hpp"

#include <netcdf.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <limits>
#include <set>
#include <system_error>

#include "common/base/error.hpp"
#include "common/base/process.hpp"

namespace cbr {
namespace {

// The header of a classic netCDF file.
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

// Checks the header of a classic netCDF file (CDF-1, 2, 5). InputError where it is damaged, or
// where a variable ends beyond the file. The library crashes on some damaged headers, and reads
// zeros beyond the end of a file. Other files pass: false. Grammar: NetCDF Classic and 64-bit
// Offset File Formats, OGC 11-054r1, and its 64-bit data extension.
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

// The library would read .ncrc, .dodsrc and .daprc of HOME and of the current folder.
[[maybe_unused]] const bool no_settings = ::setenv("NCRCENV_IGNORE", "1", 1) == 0;

// Opens the file and reads all its numbers: the library, or that of HDF5 below it, crashes on some
// damaged files that are not classic.
void read_all_numbers(const std::filesystem::path& path) {
  int file = 0, n_variables = 0;
  if (nc_open(path.c_str(), NC_NOWRITE, &file) != NC_NOERR) return;
  nc_inq_nvars(file, &n_variables);
  std::error_code error;
  const double most = 1e3 * static_cast<double>(std::filesystem::file_size(path, error));
  for (int id = 0; id < n_variables; ++id) {
    int rank = 0, dimensions[NC_MAX_VAR_DIMS];
    nc_type type = NC_NAT;
    if (nc_inq_var(file, id, nullptr, &type, &rank, dimensions, nullptr) != NC_NOERR) continue;
    double n = 1;
    for (int d = 0; d < rank; ++d) {
      std::size_t length = 0;
      nc_inq_dimlen(file, dimensions[d], &length);
      n *= static_cast<double>(length);
    }
    if (n > most || n < 1 || type == NC_STRING || type > NC_MAX_ATOMIC_TYPE) continue;
    std::vector<double> values(static_cast<std::size_t>(n));
    type == NC_CHAR ? nc_get_var_text(file, id, reinterpret_cast<char*>(values.data()))
                    : nc_get_var_double(file, id, values.data());
  }
  nc_close(file);
}

}  // namespace

NetcdfReader::NetcdfReader(const std::filesystem::path& file) : where_(file.string()) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw InputError(where_ + ": no such file");
  // Only a compressed file may hold more than its size, and not without any bound.
  const bool classic = check_classic_netcdf(file);
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  most_ = (classic ? 1 : 1e3) * static_cast<double>(size);
  if (!classic && !survives_in_child(
                      where_, [&] { read_all_numbers(file); }, seconds_to_read(size)))
    throw InputError(
        where_ + ": is a damaged netCDF file: the netCDF library fails on it, or reads for ever");
  const int status = nc_open(file.c_str(), NC_NOWRITE, &file_);
  if (status != NC_NOERR) {
    file_ = -1;
    throw InputError(where_ +
                     ": is not an Exodus II (netCDF) file, or is damaged: " + nc_strerror(status));
  }
}

NetcdfReader::~NetcdfReader() {
  if (file_ >= 0) nc_close(file_);
}

void NetcdfReader::check(int status, const std::string& what) const {
  if (status != NC_NOERR)
    throw InputError(where_ + ": " + what + ": " + nc_strerror(status) +
                     ": the file is damaged or no mesh");
}

Index NetcdfReader::dimension(const std::string& name) const {
  int id = 0;
  if (nc_inq_dimid(file_, name.c_str(), &id) != NC_NOERR) return 0;
  std::size_t length = 0;
  check(nc_inq_dimlen(file_, id, &length), name);
  if (static_cast<double>(length) > most_)
    throw InputError(where_ + ": " + name + ": " + std::to_string(length) +
                     " is more than a file of this size can hold: damaged");
  return static_cast<Index>(length);
}

bool NetcdfReader::has(const std::string& variable) const {
  int id = 0;
  return nc_inq_varid(file_, variable.c_str(), &id) == NC_NOERR;
}

int NetcdfReader::variable_id(const std::string& variable) const {
  if (variable.empty()) return NC_GLOBAL;
  int id = 0;
  if (nc_inq_varid(file_, variable.c_str(), &id) != NC_NOERR)
    throw InputError(where_ + ": " + variable +
                     ": there is no such variable: the file is no Exodus II mesh or is damaged");
  return id;
}

std::vector<Index> NetcdfReader::shape(const std::string& variable) const {
  const int id = variable_id(variable);
  int n = 0, dims[NC_MAX_VAR_DIMS];
  check(nc_inq_varndims(file_, id, &n), variable);
  check(nc_inq_vardimid(file_, id, dims), variable);
  std::vector<Index> sizes;
  for (int d = 0; d < n; ++d) {
    std::size_t length = 0;
    check(nc_inq_dimlen(file_, dims[d], &length), variable);
    if (static_cast<double>(length) > most_)  // also where another dimension is 0
      throw InputError(where_ + ": " + variable +
                       ": is larger than a file of this size can hold: damaged");
    sizes.push_back(static_cast<Index>(length));
  }
  return sizes;
}

Index NetcdfReader::n_values(const std::string& variable) const {
  double n = 1;
  for (const Index size : shape(variable)) n *= static_cast<double>(size);
  if (n > most_)
    throw InputError(where_ + ": " + variable +
                     ": is larger than a file of this size can hold: damaged");
  return static_cast<Index>(n);
}

std::vector<Index> NetcdfReader::integers(const std::string& variable) const {
  static_assert(sizeof(long long) == sizeof(Index));
  std::vector<long long> values(n_values(variable));
  if (!values.empty())
    check(nc_get_var_longlong(file_, variable_id(variable), values.data()), variable);
  return {values.begin(), values.end()};
}

std::vector<double> NetcdfReader::reals(const std::string& variable) const {
  std::vector<double> values(n_values(variable));
  if (!values.empty())
    check(nc_get_var_double(file_, variable_id(variable), values.data()), variable);
  return values;
}

std::vector<std::string> NetcdfReader::strings(const std::string& variable) const {
  const auto sizes = shape(variable);
  if (sizes.size() != 2)
    throw InputError(where_ + ": " + variable + ": should have two dimensions, not " +
                     std::to_string(sizes.size()));
  std::string all(n_values(variable), '\0');
  if (!all.empty()) check(nc_get_var_text(file_, variable_id(variable), all.data()), variable);
  std::vector<std::string> rows;
  for (Index r = 0; r < sizes[0]; ++r) {
    std::string row =
        all.substr(static_cast<std::size_t>(r * sizes[1]), static_cast<std::size_t>(sizes[1]));
    row = row.substr(0, row.find('\0'));
    row.erase(row.find_last_not_of(' ') + 1);
    rows.push_back(row);
  }
  return rows;
}

std::string NetcdfReader::text(const std::string& variable, const std::string& attribute) const {
  const int id = variable_id(variable);
  nc_type type = NC_NAT;
  std::size_t length = 0;
  if (nc_inq_att(file_, id, attribute.c_str(), &type, &length) != NC_NOERR || type != NC_CHAR)
    return "";
  std::string value(length, '\0');
  check(nc_get_att_text(file_, id, attribute.c_str(), value.data()),
        variable + " attribute " + attribute);
  return value.substr(0, value.find('\0'));
}

NetcdfWriter::NetcdfWriter(const std::filesystem::path& file, std::string where)
    : where_(std::move(where)) {
  const int status = nc_create(file.c_str(), NC_CLOBBER | NC_64BIT_OFFSET, &file_);
  if (status != NC_NOERR) {
    file_ = -1;
    throw RunError(where_ + ": could not be written: " + nc_strerror(status));
  }
  int old_mode = 0;
  check(nc_set_fill(file_, NC_NOFILL, &old_mode), "fill mode");  // every value is written
}

NetcdfWriter::~NetcdfWriter() {
  if (file_ >= 0) nc_abort(file_);
}

void NetcdfWriter::check(int status, const std::string& what) const {
  if (status != NC_NOERR)
    throw RunError(where_ + ": " + what + " could not be written: " + nc_strerror(status));
}

int NetcdfWriter::variable_id(const std::string& variable) const {
  if (variable.empty()) return NC_GLOBAL;
  int id = 0;
  check(nc_inq_varid(file_, variable.c_str(), &id), variable);
  return id;
}

void NetcdfWriter::attribute(const std::string& variable, const std::string& name,
                             const std::string& value) {
  check(nc_put_att_text(file_, variable_id(variable), name.c_str(), value.size(), value.c_str()),
        name);
}

void NetcdfWriter::attribute(const std::string& name, int value) {
  check(nc_put_att_int(file_, NC_GLOBAL, name.c_str(), NC_INT, 1, &value), name);
}

void NetcdfWriter::attribute(const std::string& name, float value) {
  check(nc_put_att_float(file_, NC_GLOBAL, name.c_str(), NC_FLOAT, 1, &value), name);
}

void NetcdfWriter::dimension(const std::string& name, Index size) {
  int id = 0;
  check(nc_def_dim(file_, name.c_str(), size == 0 ? NC_UNLIMITED : static_cast<std::size_t>(size),
                   &id),
        name);
}

void NetcdfWriter::define(const std::string& variable, int type,
                          const std::vector<std::string>& dimensions) {
  std::vector<int> ids;
  for (const auto& name : dimensions) {
    ids.emplace_back();
    check(nc_inq_dimid(file_, name.c_str(), &ids.back()), name);
  }
  int id = 0;
  check(nc_def_var(file_, variable.c_str(), type, static_cast<int>(ids.size()), ids.data(), &id),
        variable);
}

void NetcdfWriter::define_integers(const std::string& variable,
                                   const std::vector<std::string>& dimensions) {
  define(variable, NC_INT, dimensions);
}
void NetcdfWriter::define_reals(const std::string& variable,
                                const std::vector<std::string>& dimensions) {
  define(variable, NC_DOUBLE, dimensions);
}
void NetcdfWriter::define_text(const std::string& variable,
                               const std::vector<std::string>& dimensions) {
  define(variable, NC_CHAR, dimensions);
}

void NetcdfWriter::end_definitions() { check(nc_enddef(file_), "header"); }

void NetcdfWriter::write(const std::string& variable, const std::vector<Index>& values) {
  std::vector<int> narrow;
  narrow.reserve(values.size());
  for (const Index value : values) {
    if (value > std::numeric_limits<int>::max() || value < std::numeric_limits<int>::min())
      throw InputError(where_ + ": " + variable + ": " + std::to_string(value) +
                       " does not fit the 32 bits of this format: renumber");
    narrow.push_back(static_cast<int>(value));
  }
  check(nc_put_var_int(file_, variable_id(variable), narrow.data()), variable);
}

void NetcdfWriter::write(const std::string& variable, const std::vector<double>& values) {
  check(nc_put_var_double(file_, variable_id(variable), values.data()), variable);
}

void NetcdfWriter::write(const std::string& variable, const std::vector<std::string>& values,
                         Index width) {
  std::string all;
  for (auto value : values) {
    value.resize(width);
    all += value;
  }
  check(nc_put_var_text(file_, variable_id(variable), all.data()), variable);
}

void NetcdfWriter::write_record(const std::string& variable, Index record,
                                const std::vector<double>& values) {
  const std::size_t start[] = {static_cast<std::size_t>(record), 0}, count[] = {1, values.size()};
  check(nc_put_vara_double(file_, variable_id(variable), start, count, values.data()), variable);
}

void NetcdfWriter::close() {
  const int status = nc_close(file_);
  file_ = -1;
  check(status, "the end of the file");
}

}  // namespace cbr
