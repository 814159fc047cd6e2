// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/superelement/superelement_file.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <limits>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/superelement/superelement_check.hpp"

namespace cbr {
namespace {

constexpr int format_major = 1;

// --- writing ---

void write_surface(Hdf5Writer& file, const std::string& prefix, const Surface& surface) {
  const std::string group = prefix + "/interface/" + surface.name;
  file.write(group + "/faces", surface.faces);
  file.write(group + "/element", surface.element);
  file.write(group + "/side", surface.side);
  file.attribute(group + "/faces", "kind", std::string(name(surface.kind)));
}

std::string block_group(const std::string& prefix, std::size_t i) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%06zu", i);
  // block names are the user's: an attribute, not a group's name
  return prefix + "/recovery/blocks/" + digits;
}

void write_recovery(Hdf5Writer& file, const std::string& prefix,
                    const Superelement::Recovery& recovery) {
  file.write(prefix + "/recovery/nodes/id", recovery.node_ids);
  file.write(prefix + "/recovery/nodes/coordinates", recovery.coordinates);
  const std::string rotations = prefix + "/recovery/rotations/";
  const auto n = 3 * static_cast<Index>(recovery.node_ids.size());
  const auto write = [&](const std::string& name, const Matrix& rows) {
    if (recovery.rotations.empty()) return file.write(prefix + "/recovery/" + name, rows);
    file.write(prefix + "/recovery/" + name, Matrix(rows.topRows(n)));
    file.write(rotations + name, Matrix(rows.bottomRows(rows.rows() - n)));
  };
  write("Psi", recovery.Psi);
  write("Phi", recovery.Phi);
  if (!recovery.rotations.empty()) file.write(rotations + "node", recovery.rotations);
  for (std::size_t i = 0; i < recovery.blocks.size(); ++i) {
    const Block& block = recovery.blocks[i];
    file.write(block_group(prefix, i) + "/connectivity", block.connectivity);
    file.write(block_group(prefix, i) + "/element_id", block.element_ids);
    file.attribute(block_group(prefix, i), "name", block.name);
    file.attribute(block_group(prefix, i), "id", block.id);
    file.attribute(block_group(prefix, i), "type", std::string(name(block.type)));
    if (block.thickness > 0) file.write(block_group(prefix, i) + "/thickness", block.thickness);
  }
}

// Data of half of the modes.
void write_half_of_massless(Hdf5Writer& file, const std::string& group,
                            const Superelement::Massless& massless) {
  if (!massless.modes.empty()) file.attribute(group + "/V", "modes", massless.modes);
  if (massless.omega_fall > 0) file.write(group + "/omega_fall", massless.omega_fall);
}

// By columns: begin (columns + 1), row and value of each entry.
void write_sparse(Hdf5Writer& file, const std::string& group, const SparseMatrix& A) {
  const Index* begin = A.outerIndexPtr();
  const auto n = static_cast<std::size_t>(A.nonZeros());
  file.write(group + "/begin", std::vector<Index>(begin, begin + A.cols() + 1));
  file.write(group + "/row", std::vector<Index>(A.innerIndexPtr(), A.innerIndexPtr() + n));
  file.write(group + "/value", std::vector<double>(A.valuePtr(), A.valuePtr() + n));
}

void write_statics(Hdf5Writer& file, const std::string& group, const StaticShare& statics) {
  if (statics.empty()) return;
  file.write(group + "/node", statics.node);
  file.write(group + "/direction", statics.direction);
  if (statics.levels.empty()) return file.write(group + "/F", statics.F);
  file.compress(true);
  for (std::size_t l = 0; l < statics.levels.size(); ++l) {
    const std::string level = group + "/levels/" + std::to_string(l);
    write_sparse(file, level + "/P", statics.levels[l].P);
    write_sparse(file, level + "/S",
                 SparseMatrix(statics.levels[l].S.triangularView<Eigen::Lower>()));
  }
  file.compress(false);
}

// --- reading ---

[[noreturn]] void fail(const Hdf5Reader& file, const std::string& what) {
  throw InputError(file.file().string() + ": " + what);
}

// Indices beyond int are wrong wherever an int is expected; kept out of range, so that check()
// names them.
std::vector<int> to_int(const std::vector<Index>& values) {
  std::vector<int> narrow;
  narrow.reserve(values.size());
  for (const Index value : values) {
    narrow.push_back(static_cast<int>(std::clamp<Index>(value, std::numeric_limits<int>::min(),
                                                        std::numeric_limits<int>::max())));
  }
  return narrow;
}

FaceKind read_kind(const Hdf5Reader& file, const std::string& dataset) {
  const std::string text = file.read_string(dataset, "kind");
  for (const FaceKind kind :
       {FaceKind::tri3, FaceKind::quad4, FaceKind::tri6, FaceKind::quad8, FaceKind::quad9}) {
    if (text == name(kind)) return kind;
  }
  fail(file,
       dataset + ": attribute 'kind' is '" + text + "', allowed: tri3, quad4, tri6, quad8, quad9");
}

Surface read_surface(const Hdf5Reader& file, const std::string& prefix,
                     const std::string& surface_name) {
  const std::string group = prefix + "/interface/" + surface_name;
  Surface surface;
  surface.name = surface_name;
  surface.faces = file.read_index_table(group + "/faces");
  surface.kind = read_kind(file, group + "/faces");
  surface.element = file.read_indices(group + "/element");
  surface.side = to_int(file.read_indices(group + "/side"));
  return surface;
}

ElementType read_element_type(const Hdf5Reader& file, const std::string& group) {
  const std::string text = file.read_string(group, "type");
  std::vector<std::string> allowed;
  for (int i = 0; i <= static_cast<int>(ElementType::hex27); ++i) {
    const auto type = static_cast<ElementType>(i);
    if (text == name(type)) return type;
    allowed.emplace_back(name(type));
  }
  fail(file, group + ": attribute 'type' is '" + text + "', allowed: " + join(allowed));
}

Superelement::Recovery read_recovery(const Hdf5Reader& file, const std::string& prefix) {
  Superelement::Recovery recovery;
  recovery.node_ids = file.read_indices(prefix + "/recovery/nodes/id");
  recovery.coordinates = file.read_points(prefix + "/recovery/nodes/coordinates");
  const std::string rotations = prefix + "/recovery/rotations/";
  if (file.has(rotations + "node")) recovery.rotations = file.read_indices(rotations + "node");
  const auto read = [&](const std::string& name) {
    Matrix rows = file.read_matrix(prefix + "/recovery/" + name);
    if (recovery.rotations.empty()) return rows;
    const Matrix more = file.read_matrix(rotations + name);
    if (more.cols() != rows.cols())
      fail(file, rotations + name + ": has " + std::to_string(more.cols()) + " columns, expected " +
                     std::to_string(rows.cols()));
    rows.conservativeResize(rows.rows() + more.rows(), Eigen::NoChange);
    rows.bottomRows(more.rows()) = more;
    return rows;
  };
  recovery.Psi = read("Psi");
  recovery.Phi = read("Phi");
  if (!file.has(prefix + "/recovery/blocks")) return recovery;
  for (const auto& child : file.children(prefix + "/recovery/blocks")) {
    const std::string group = prefix + "/recovery/blocks/" + child;
    Block block;
    block.name = file.read_string(group, "name");
    block.id = file.read_index(group, "id");
    block.type = read_element_type(file, group);
    block.connectivity = file.read_index_table(group + "/connectivity");
    block.element_ids = file.read_indices(group + "/element_id");
    if (file.has(group + "/thickness")) block.thickness = file.read_scalar(group + "/thickness");
    recovery.blocks.push_back(std::move(block));
  }
  return recovery;
}

void read_half_of_massless(const Hdf5Reader& file, const std::string& group,
                           Superelement::Massless& massless) {
  if (file.has_attribute(group + "/V", "modes"))
    massless.modes = file.read_string(group + "/V", "modes");
  if (file.has(group + "/omega_fall"))
    massless.omega_fall = file.read_scalar(group + "/omega_fall");
}

// rows: none, of a square matrix.
SparseMatrix read_sparse(const Hdf5Reader& file, const std::string& group,
                         std::optional<Index> rows = {}) {
  const std::vector<Index> begin = file.read_indices(group + "/begin"),
                           row = file.read_indices(group + "/row");
  const Vector value = file.read_vector(group + "/value");
  const auto n = static_cast<Index>(row.size()), columns = static_cast<Index>(begin.size()) - 1;
  bool fits = !begin.empty() && begin.front() == 0 && begin.back() == n && value.size() == n &&
              std::is_sorted(begin.begin(), begin.end()) && value.allFinite();
  for (Index j = 0; fits && j < columns; ++j)
    for (Index i = begin[j]; i < begin[j + 1]; ++i)
      fits = fits && (i == begin[j] ? row[i] >= 0 : row[i] > row[i - 1]) &&
             row[i] < rows.value_or(columns);
  if (!fits)
    fail(file, group + ": begin, row and value are not those of a sparse matrix by columns");
  return Eigen::Map<const SparseMatrix>(rows.value_or(columns), columns, n, begin.data(),
                                        row.data(), value.data());
}

void read_statics(const Hdf5Reader& file, const std::string& group, StaticShare& statics) {
  if (!file.has(group)) return;
  statics.node = file.read_indices(group + "/node");
  statics.direction = file.read_points(group + "/direction");
  if (!file.has(group + "/levels")) {
    statics.F = file.read_matrix(group + "/F");
    return;
  }
  for (std::size_t l = 0; l < file.children(group + "/levels").size(); ++l) {
    const std::string level = group + "/levels/" + std::to_string(l);
    ComplianceLevel& of = statics.levels.emplace_back();
    const SparseMatrix lower = read_sparse(file, level + "/S");
    of.S = lower.selfadjointView<Eigen::Lower>();
    of.P = read_sparse(file, level + "/P", of.S.rows());
  }
}

void read_interface(const Hdf5Reader& file, const std::string& prefix, Superelement& s) {
  s.dof_node = file.read_indices(prefix + "/dofs/node");
  s.dof_component = to_int(file.read_indices(prefix + "/dofs/component"));
  s.node_ids = file.read_indices(prefix + "/nodes/id");
  s.coordinates = file.read_points(prefix + "/nodes/coordinates");
  if (file.has(prefix + "/interface")) {
    for (const auto& child : file.children(prefix + "/interface"))
      s.surfaces.push_back(read_surface(file, prefix, child));
  }
  if (file.has(prefix + "/nodesets")) {
    for (const auto& child : file.children(prefix + "/nodesets"))
      s.nodesets[child] = file.read_indices(prefix + "/nodesets/" + child);
  }
}

}  // namespace

void write_format(Hdf5Writer& file, const std::string& prefix, const std::string& format,
                  const std::string& format_version) {
  file.attribute(file_root(prefix), "format", format);
  file.attribute(file_root(prefix), "format_version", format_version);
  file.attribute(file_root(prefix), "generator", std::string("cbr ") + version());
}

void check_format(const Hdf5Reader& file, const std::string& prefix, const std::string& expected) {
  const bool group = expected == superelement_group_format;
  const std::string what =
      (prefix.empty() ? "is not a " : prefix + ": is not a ") +
      std::string(group ? "file of a group of superelements" : "superelement file") + ": ";
  if (!file.has_attribute(file_root(prefix), "format"))
    fail(file, what + "the root attribute 'format' is missing");
  const std::string format = file.read_string(file_root(prefix), "format");
  if (format != expected) {
    std::string hint;
    if (format == superelement_group_format)
      hint = ": it holds the domains of a decomposed component";
    if (format == superelement_format)
      hint = ": it holds one superelement, of a component that is not decomposed";
    fail(file, what + "attribute 'format' is '" + format + "', expected '" + expected + "'" + hint);
  }
  const std::string version = file.read_string(file_root(prefix), "format_version");
  int major = -1;
  const auto [end, error] = std::from_chars(version.data(), version.data() + version.size(), major);
  const bool valid =
      error == std::errc() && (end == version.data() + version.size() || *end == '.');
  if (!valid || major < 1)
    fail(file,
         "attribute 'format_version' is '" + version + "', expected MAJOR.MINOR such as '1.0'");
  if (major > format_major) {
    fail(file, "format_version " + version + " is newer than the versions " +
                   std::to_string(format_major) +
                   ".x that this program reads: use a newer cbr, or reduce the component again "
                   "with this one");
  }
  file.read_string(file_root(prefix), "generator");
}

void write_rigid_body(Hdf5Writer& file, const std::string& prefix, const RigidBody& body) {
  file.write(prefix + "/rigid_body/mass", body.mass);
  file.write(prefix + "/rigid_body/center", Vector(body.center));
  file.write(prefix + "/rigid_body/inertia", Matrix(body.inertia));
}

RigidBody read_rigid_body(const Hdf5Reader& file, const std::string& prefix) {
  const std::string group = prefix + "/rigid_body/";
  RigidBody body;
  body.mass = file.read_scalar(group + "mass");
  const Vector center = file.read_vector(group + "center");
  if (center.size() != 3)
    fail(file, group + "center: wrong shape (" + std::to_string(center.size()) + "), expected (3)");
  const Points inertia = file.read_points(group + "inertia");
  if (inertia.rows() != 3) {
    fail(file, group + "inertia: wrong shape (" + std::to_string(inertia.rows()) +
                   ", 3), expected (3, 3)");
  }
  body.center = center;
  body.inertia = inertia;
  return body;
}

void check_count(const Hdf5Reader& file, const std::string& prefix, const std::string& attribute,
                 Index found, const std::string& dataset) {
  const Index claimed = file.read_index(file_root(prefix), attribute);
  if (claimed == found) return;
  fail(file, prefix + dataset + ": length " + std::to_string(found) + " is not the attribute '" +
                 attribute + "' = " + std::to_string(claimed));
}

Superelement read_superelement_at(const Hdf5Reader& file, const std::string& prefix,
                                  const SuperelementParts& parts) {
  check_format(file, prefix, superelement_format);
  Superelement s;
  s.basis = file.read_string(file_root(prefix), "basis");
  s.content_hash = file.read_string(file_root(prefix), "content_hash");
  s.eigenvalues = file.read_vector(prefix + "/matrices/eigenvalues");
  read_interface(file, prefix, s);
  check_count(file, prefix, "n_modes", s.k(), "/matrices/eigenvalues");
  check_count(file, prefix, "n_interface", s.c(), "/dofs/node");
  if (parts.matrices && s.is_massless()) {
    s.massless.V = file.read_matrix(prefix + "/massless/V");
    s.massless.F = file.read_matrix(prefix + "/massless/F");
    s.massless.omega_closed = file.read_scalar(prefix + "/massless/omega_closed");
    read_half_of_massless(file, prefix + "/massless", s.massless);
  } else if (parts.matrices && s.is_characteristic()) {
    s.characteristic.V = file.read_matrix(prefix + "/characteristic/V");
    read_statics(file, prefix + "/characteristic/statics", s.characteristic.statics);
  } else if (parts.matrices) {
    s.K_cc = file.read_matrix(prefix + "/matrices/K_cc");
    s.M_cc = file.read_matrix(prefix + "/matrices/M_cc");
    s.M_kc = file.read_matrix(prefix + "/matrices/M_kc");
  }
  s.rigid_body = read_rigid_body(file, prefix);
  if (parts.diagonal && file.has(prefix + "/diagonal")) {
    s.omega = file.read_vector(prefix + "/diagonal/omega");
    s.V = file.read_row_matrix(prefix + "/diagonal/V");
  }
  if (parts.recovery && file.has(prefix + "/recovery"))
    s.recovery.push_back(read_recovery(file, prefix));
  if (file.has(prefix + "/recovery/sets"))
    for (const auto& set : file.children(prefix + "/recovery/sets"))
      s.recovered_sets[set] = file.read_indices(prefix + "/recovery/sets/" + set);
  read_extras(file, prefix, s);
  s.provenance = file.texts(prefix + "/provenance");
  const auto modes = s.provenance.find("massless_modes");  // where files before 1.5 say it
  if (s.is_massless() && s.massless.modes.empty() && modes != s.provenance.end())
    s.massless.modes = modes->second;
  check_parts(s, parts, file.file().string() + (prefix.empty() ? "" : ": " + prefix));
  return s;
}

void write_superelement_at(Hdf5Writer& file, const std::string& prefix, const Superelement& s) {
  write_format(file, prefix, superelement_format, superelement_version);
  file.attribute(file_root(prefix), "content_hash", s.content_hash);
  file.attribute(file_root(prefix), "basis", s.basis);
  file.attribute(file_root(prefix), "n_modes", s.k());
  file.attribute(file_root(prefix), "n_interface", s.c());
  file.write(prefix + "/matrices/eigenvalues", s.eigenvalues);
  if (s.is_massless()) {
    file.write(prefix + "/massless/V", s.massless.V);
    file.write(prefix + "/massless/F", s.massless.F);
    file.write(prefix + "/massless/omega_closed", s.massless.omega_closed);
    write_half_of_massless(file, prefix + "/massless", s.massless);
  } else if (s.is_characteristic()) {
    file.write(prefix + "/characteristic/V", s.characteristic.V);
    write_statics(file, prefix + "/characteristic/statics", s.characteristic.statics);
  } else {
    file.write(prefix + "/matrices/K_cc", s.K_cc);
    file.write(prefix + "/matrices/M_cc", s.M_cc);
    file.write(prefix + "/matrices/M_kc", s.M_kc);
  }
  file.write(prefix + "/dofs/node", s.dof_node);
  file.write(prefix + "/dofs/component", s.dof_component);
  file.write(prefix + "/nodes/id", s.node_ids);
  file.write(prefix + "/nodes/coordinates", s.coordinates);
  // By name, so that the bytes do not depend on the order in which the sets were asked for.
  std::map<std::string, const Surface*> by_name;
  for (const auto& surface : s.surfaces) by_name[surface.name] = &surface;
  for (const auto& [surface_name, surface] : by_name) write_surface(file, prefix, *surface);
  for (const auto& [nodeset, nodes] : s.nodesets)
    file.write(prefix + "/nodesets/" + nodeset, nodes);
  write_rigid_body(file, prefix, s.rigid_body);
  if (s.has_diagonal_form()) {
    file.write(prefix + "/diagonal/omega", s.omega);
    file.write(prefix + "/diagonal/V", s.V);
  }
  for (const auto& recovery : s.recovery) write_recovery(file, prefix, recovery);
  for (const auto& [set, nodes] : s.recovered_sets)
    file.write(prefix + "/recovery/sets/" + set, nodes);
  write_extras(file, prefix, s);
  for (const auto& [key, value] : s.provenance) file.attribute(prefix + "/provenance", key, value);
}

Superelement read_superelement(const std::filesystem::path& path, const SuperelementParts& parts) {
  return read_superelement_at(Hdf5Reader(path), "", parts);
}

void write_superelement(const Superelement& s, const std::filesystem::path& path) {
  check(s, path.string());
  Hdf5Writer file(path);
  file.add_checksums();
  write_superelement_at(file, "", s);
  file.commit();
}

bool stores_diagonal_form(const std::filesystem::path& path) {
  return Hdf5Reader(path).has("/diagonal");
}

std::string read_content_hash(const std::filesystem::path& path) {
  try {
    const Hdf5Reader file(path);
    const bool group = file.has_attribute("/", "format") &&
                       file.read_string("/", "format") == superelement_group_format;
    check_format(file, "", group ? superelement_group_format : superelement_format);
    return file.read_string("/", "content_hash");
  } catch (const InputError&) {
    return "";
  }
}

}  // namespace cbr
