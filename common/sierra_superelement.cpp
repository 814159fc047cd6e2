// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/sierra_superelement.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/error.hpp"
#include "common/mesh/netcdf_file.hpp"
#include "common/number_text.hpp"
#include "common/row_matrix.hpp"

namespace cbr {
namespace {

// What only these files ask for, on top of the reader that Exodus files have too.
class SierraFile {
 public:
  explicit SierraFile(const std::filesystem::path& file) : reader_(file) {}

  [[noreturn]] void fail(const std::string& what) const { throw InputError(reader_.where() + ": " + what); }
  bool has(const std::string& variable) const { return reader_.has(variable); }
  Index dimension(const std::string& name) const { return reader_.dimension(name); }
  std::vector<Index> shape(const std::string& variable) const {
    if (!has(variable)) fail("no variable '" + variable + "': not a Sierra/SD superelement");
    return reader_.shape(variable);
  }

  RowMatrix matrix(const std::string& variable) const {
    const auto lengths = shape(variable);
    if (lengths.size() != 2) fail("variable '" + variable + "' has " + std::to_string(lengths.size()) + " dimensions, not 2");
    const auto values = doubles(variable);
    return Eigen::Map<const RowMatrix>(values.data(), lengths[0], lengths[1]);
  }

  std::vector<double> doubles(const std::string& variable) const {
    shape(variable);
    auto values = reader_.reals(variable);
    for (const double value : values)
      if (!std::isfinite(value)) fail("variable '" + variable + "' has values that are not finite");
    return values;
  }

  std::vector<Index> integers(const std::string& variable) const {
    shape(variable);
    return reader_.integers(variable);
  }

 private:
  NetcdfReader reader_;
};

// Older files: one row per interface dof; newer ones: one per reduced dof, (0, 0) for modes. Told by the shape.
void read_dofs(const SierraFile& file, SierraSuperelement& s) {
  const auto map = file.matrix("cbmap");
  const Index n = s.Kr.rows(), n_interface = n - s.n_modes;
  if (map.cols() != 2 || (map.rows() != n && map.rows() != n_interface)) {
    file.fail("variable 'cbmap' is " + std::to_string(map.rows()) + " x " + std::to_string(map.cols()) + ", expected " +
              std::to_string(n) + " x 2 or " + std::to_string(n_interface) + " x 2");
  }
  for (Index i = map.rows() - n_interface; i < map.rows(); ++i) {
    if (!(map(i, 1) >= 1 && map(i, 1) <= 6)) file.fail("cbmap: dof " + number_text(map(i, 1)) + " is none of 1 to 6");
    if (!(std::abs(map(i, 0)) < 1e15)) file.fail("cbmap: node " + number_text(map(i, 0)) + " is no node's number");
    s.dof_node.push_back(static_cast<Index>(map(i, 0)));
    s.dof_component.push_back(static_cast<int>(map(i, 1)) - 1);
  }
}

void read_nodes(const SierraFile& file, SierraSuperelement& s) {
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
  const SierraFile file(path);
  SierraSuperelement s;
  s.Kr = file.matrix("Kr");
  s.Mr = file.matrix("Mr");
  const Index n = s.Kr.rows();
  if (s.Kr.cols() != n || s.Mr.rows() != n || s.Mr.cols() != n) file.fail("Kr and Mr are not square matrices of one size");
  s.n_modes = std::max<Index>(0, file.dimension("NumEig"));
  if (s.n_modes > n) file.fail("NumEig is larger than Kr");
  read_dofs(file, s);
  read_nodes(file, s);
  if (file.has("Cr")) {
    const auto damping = file.doubles("Cr");
    s.has_damping = std::any_of(damping.begin(), damping.end(), [](double value) { return value != 0; });
  }
  if (file.has("OTM")) {
    s.output_map = file.matrix("OTM");
    s.output_nodes = file.integers("OutMap");
  }
  return s;
}

}  // namespace cbr
