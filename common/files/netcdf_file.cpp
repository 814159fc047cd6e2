// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/files/netcdf_file.hpp"

#include <netcdf.h>

#include <limits>
#include <system_error>

#include "common/base/child_process.hpp"
#include "common/base/error.hpp"
#include "common/files/netcdf_header.hpp"

namespace cbr {
namespace {

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
