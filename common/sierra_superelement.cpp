// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/sierra_superelement.hpp"

#include <netcdf.h>

#include <algorithm>

#include <string>

#include "common/error.hpp"

namespace cbr {
namespace {

class NetcdfFile {
 public:
  explicit NetcdfFile(const std::filesystem::path& file) : name_(file.string()) {
    const int status = nc_open(file.c_str(), NC_NOWRITE, &id_);
    if (status != NC_NOERR) throw InputError(name_ + ": cannot be read as netCDF: " + nc_strerror(status));
  }
  ~NetcdfFile() { nc_close(id_); }
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;

  [[noreturn]] void fail(const std::string& what) const { throw InputError(name_ + ": " + what); }

  bool has(const char* variable) const {
    int id = 0;
    return nc_inq_varid(id_, variable, &id) == NC_NOERR;
  }

  // -1 when there is no such dimension.
  Index dimension(const char* name) const {
    int id = 0;
    std::size_t length = 0;
    if (nc_inq_dimid(id_, name, &id) != NC_NOERR || nc_inq_dimlen(id_, id, &length) != NC_NOERR) return -1;
    return static_cast<Index>(length);
  }

  std::vector<Index> shape(const char* variable) const {
    int n = 0, dims[NC_MAX_VAR_DIMS];
    const int var = find(variable);
    if (nc_inq_varndims(id_, var, &n) != NC_NOERR || nc_inq_vardimid(id_, var, dims) != NC_NOERR) fail(unreadable(variable));
    std::vector<Index> lengths;
    for (int i = 0; i < n; ++i) {
      std::size_t length = 0;
      nc_inq_dimlen(id_, dims[i], &length);
      lengths.push_back(static_cast<Index>(length));
    }
    return lengths;
  }

  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> matrix(const char* variable) const {
    const auto lengths = shape(variable);
    if (lengths.size() != 2)
      fail(std::string("variable '") + variable + "' has " + std::to_string(lengths.size()) + " dimensions, not 2");
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values(lengths[0], lengths[1]);
    if (nc_get_var_double(id_, find(variable), values.data()) != NC_NOERR) fail(unreadable(variable));
    if (!values.allFinite()) fail(std::string("variable '") + variable + "' has values that are not finite");
    return values;
  }

  std::vector<double> doubles(const char* variable) const {
    std::vector<double> values(size(variable));
    if (nc_get_var_double(id_, find(variable), values.data()) != NC_NOERR) fail(unreadable(variable));
    return values;
  }

  std::vector<Index> integers(const char* variable) const {
    std::vector<long long> values(size(variable));
    if (nc_get_var_longlong(id_, find(variable), values.data()) != NC_NOERR) fail(unreadable(variable));
    return {values.begin(), values.end()};
  }

 private:
  int find(const char* variable) const {
    int id = 0;
    if (nc_inq_varid(id_, variable, &id) != NC_NOERR)
      fail(std::string("no variable '") + variable + "': not a Sierra/SD superelement");
    return id;
  }
  std::size_t size(const char* variable) const {
    std::size_t product = 1;
    for (const Index length : shape(variable)) product *= static_cast<std::size_t>(length);
    return product;
  }
  static std::string unreadable(const char* variable) { return std::string("variable '") + variable + "' cannot be read"; }

  std::string name_;
  int id_ = 0;
};

// Older files: one row per interface dof; newer ones: one per reduced dof, (0, 0) for modes. Told by the shape.
void read_dofs(const NetcdfFile& file, SierraSuperelement& s) {
  const auto map = file.matrix("cbmap");
  const Index n = s.Kr.rows(), n_interface = n - s.n_modes;
  if (map.cols() != 2 || (map.rows() != n && map.rows() != n_interface)) {
    file.fail("variable 'cbmap' is " + std::to_string(map.rows()) + " x " + std::to_string(map.cols()) + ", expected " +
              std::to_string(n) + " x 2 or " + std::to_string(n_interface) + " x 2");
  }
  for (Index i = map.rows() - n_interface; i < map.rows(); ++i) {
    const int component = static_cast<int>(map(i, 1));
    if (component < 1 || component > 6) file.fail("cbmap: dof " + std::to_string(component) + " is none of 1 to 6");
    s.dof_node.push_back(static_cast<Index>(map(i, 0)));
    s.dof_component.push_back(component - 1);
  }
}

void read_nodes(const NetcdfFile& file, SierraSuperelement& s) {
  s.node_ids = file.integers("node_num_map");
  const auto n = static_cast<Index>(s.node_ids.size());
  if (file.has("coord")) {
    const auto x = file.matrix("coord");
    if (x.rows() != 3 || x.cols() != n) file.fail("variable 'coord' does not fit node_num_map");
    s.coordinates = x.transpose();
    return;
  }
  s.coordinates.resize(n, 3);
  const char* names[] = {"coordx", "coordy", "coordz"};
  for (Index d = 0; d < 3; ++d) {
    const auto x = file.doubles(names[d]);
    if (static_cast<Index>(x.size()) != n) file.fail(std::string("variable '") + names[d] + "' does not fit node_num_map");
    s.coordinates.col(d) = Eigen::Map<const Vector>(x.data(), n);
  }
}

}  // namespace

SierraSuperelement read_sierra_superelement(const std::filesystem::path& path) {
  const NetcdfFile file(path);
  SierraSuperelement s;
  s.Kr = file.matrix("Kr");
  s.Mr = file.matrix("Mr");
  const Index n = s.Kr.rows();
  if (s.Kr.cols() != n || s.Mr.rows() != n || s.Mr.cols() != n) file.fail("Kr and Mr are not square matrices of one size");
  s.n_modes = std::max<Index>(0, file.dimension("NumEig"));
  if (s.n_modes > n) file.fail("NumEig is larger than Kr");
  read_dofs(file, s);
  read_nodes(file, s);
  if (file.has("OTM")) {
    s.output_map = file.matrix("OTM");
    s.output_nodes = file.integers("OutMap");
  }
  return s;
}

}  // namespace cbr
