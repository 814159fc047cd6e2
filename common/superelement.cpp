// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/superelement.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <limits>
#include <utility>

#include "common/error.hpp"
#include "common/hdf5_file.hpp"
#include "common/program.hpp"
#include "common/superelement_check.hpp"

namespace cbr {
namespace {

constexpr const char* format_name = "cbr-superelement";
constexpr const char* format_version = "1.0";
constexpr int format_major = 1;

// --- writing ---

void write_surface(Hdf5Writer& file, const Surface& surface) {
  const std::string group = "/interface/" + surface.name;
  file.write(group + "/faces", surface.faces);
  file.write(group + "/element", surface.element);
  file.write(group + "/side", surface.side);
  file.attribute(group + "/faces", "kind", std::string(name(surface.kind)));
}

std::string block_group(std::size_t i) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%06zu", i);
  return std::string("/recovery/blocks/") + digits;  // block names are the user's: an attribute, not a group's name
}

void write_recovery(Hdf5Writer& file, const Superelement::Recovery& recovery) {
  file.write("/recovery/nodes/id", recovery.node_ids);
  file.write("/recovery/nodes/coordinates", recovery.coordinates);
  file.write("/recovery/Psi", recovery.Psi);
  file.write("/recovery/Phi", recovery.Phi);
  for (std::size_t i = 0; i < recovery.blocks.size(); ++i) {
    const Block& block = recovery.blocks[i];
    file.write(block_group(i) + "/connectivity", block.connectivity);
    file.write(block_group(i) + "/element_id", block.element_ids);
    file.attribute(block_group(i), "name", block.name);
    file.attribute(block_group(i), "id", block.id);
    file.attribute(block_group(i), "type", std::string(name(block.type)));
  }
}

// --- reading ---

[[noreturn]] void fail(const Hdf5Reader& file, const std::string& what) { throw InputError(file.file().string() + ": " + what); }

void check_format(const Hdf5Reader& file) {
  if (!file.has_attribute("/", "format")) fail(file, "is not a superelement file: the root attribute 'format' is missing");
  const std::string format = file.read_string("/", "format");
  if (format != format_name) {
    fail(file, "is not a superelement file: attribute 'format' is '" + format + "', expected '" + format_name + "'");
  }
  const std::string version = file.read_string("/", "format_version");
  int major = -1;
  const auto [end, error] = std::from_chars(version.data(), version.data() + version.size(), major);
  const bool valid = error == std::errc() && (end == version.data() + version.size() || *end == '.');
  if (!valid || major < 1) fail(file, "attribute 'format_version' is '" + version + "', expected MAJOR.MINOR such as '1.0'");
  if (major > format_major) {
    fail(file, "format_version " + version + " is newer than the versions " + std::to_string(format_major) +
                   ".x that this program reads: use a newer cbr, or reduce the component again with this one");
  }
}

// Indices beyond int are wrong wherever an int is expected; kept out of range, so that check() names them.
std::vector<int> to_int(const std::vector<Index>& values) {
  std::vector<int> narrow;
  narrow.reserve(values.size());
  for (const Index value : values) {
    narrow.push_back(static_cast<int>(std::clamp<Index>(value, std::numeric_limits<int>::min(), std::numeric_limits<int>::max())));
  }
  return narrow;
}

FaceKind read_kind(const Hdf5Reader& file, const std::string& dataset) {
  const std::string text = file.read_string(dataset, "kind");
  for (const FaceKind kind : {FaceKind::tri3, FaceKind::quad4, FaceKind::tri6, FaceKind::quad8}) {
    if (text == name(kind)) return kind;
  }
  fail(file, dataset + ": attribute 'kind' is '" + text + "', allowed: tri3, quad4, tri6, quad8");
}

Surface read_surface(const Hdf5Reader& file, const std::string& surface_name) {
  const std::string group = "/interface/" + surface_name;
  Surface surface;
  surface.name = surface_name;
  surface.faces = file.read_index_table(group + "/faces");
  surface.kind = read_kind(file, group + "/faces");
  surface.element = file.read_indices(group + "/element");
  surface.side = to_int(file.read_indices(group + "/side"));
  return surface;
}

ElementType read_element_type(const Hdf5Reader& file, const std::string& group) {
  using enum ElementType;
  const std::string text = file.read_string(group, "type");
  std::vector<std::string> allowed;
  for (const ElementType type : {tri3, tri6, quad4, quad8, quad9, tet4, tet10, pyramid5, wedge6, hex8, hex20, hex27}) {
    if (text == name(type)) return type;
    allowed.emplace_back(name(type));
  }
  fail(file, group + ": attribute 'type' is '" + text + "', allowed: " + join(allowed));
}

Superelement::Recovery read_recovery(const Hdf5Reader& file) {
  Superelement::Recovery recovery;
  recovery.node_ids = file.read_indices("/recovery/nodes/id");
  recovery.coordinates = file.read_points("/recovery/nodes/coordinates");
  recovery.Psi = file.read_matrix("/recovery/Psi");
  recovery.Phi = file.read_matrix("/recovery/Phi");
  if (!file.has("/recovery/blocks")) return recovery;
  for (const auto& child : file.children("/recovery/blocks")) {
    const std::string group = "/recovery/blocks/" + child;
    Block block;
    block.name = file.read_string(group, "name");
    block.id = file.read_index(group, "id");
    block.type = read_element_type(file, group);
    block.connectivity = file.read_index_table(group + "/connectivity");
    block.element_ids = file.read_indices(group + "/element_id");
    recovery.blocks.push_back(std::move(block));
  }
  return recovery;
}

RigidBody read_rigid_body(const Hdf5Reader& file) {
  RigidBody body;
  body.mass = file.read_scalar("/rigid_body/mass");
  const Vector center = file.read_vector("/rigid_body/center");
  if (center.size() != 3) fail(file, "/rigid_body/center: wrong shape (" + std::to_string(center.size()) + "), expected (3)");
  const Points inertia = file.read_points("/rigid_body/inertia");
  if (inertia.rows() != 3) {
    fail(file, "/rigid_body/inertia: wrong shape (" + std::to_string(inertia.rows()) + ", 3), expected (3, 3)");
  }
  body.center = center;
  body.inertia = inertia;
  return body;
}

void read_interface(const Hdf5Reader& file, Superelement& s) {
  s.dof_node = file.read_indices("/dofs/node");
  s.dof_component = to_int(file.read_indices("/dofs/component"));
  s.node_ids = file.read_indices("/nodes/id");
  s.coordinates = file.read_points("/nodes/coordinates");
  if (file.has("/interface")) {
    for (const auto& child : file.children("/interface")) s.surfaces.push_back(read_surface(file, child));
  }
  if (file.has("/nodesets")) {
    for (const auto& child : file.children("/nodesets")) s.nodesets[child] = file.read_indices("/nodesets/" + child);
  }
}

void check_count(const Hdf5Reader& file, const std::string& attribute, Index found, const std::string& dataset) {
  const Index claimed = file.read_index("/", attribute);
  if (claimed == found) return;
  fail(file,
       dataset + ": length " + std::to_string(found) + " is not the attribute '" + attribute + "' = " + std::to_string(claimed));
}

}  // namespace

Superelement read_superelement(const std::filesystem::path& path, const SuperelementParts& parts) {
  const Hdf5Reader file(path);
  check_format(file);
  Superelement s;
  s.basis = file.read_string("/", "basis");
  s.content_hash = file.read_string("/", "content_hash");
  file.read_string("/", "generator");
  s.eigenvalues = file.read_vector("/matrices/eigenvalues");
  read_interface(file, s);
  check_count(file, "n_modes", s.k(), "/matrices/eigenvalues");
  check_count(file, "n_interface", s.c(), "/dofs/node");
  if (parts.matrices) {
    s.K_cc = file.read_matrix("/matrices/K_cc");
    s.M_cc = file.read_matrix("/matrices/M_cc");
    s.M_kc = file.read_matrix("/matrices/M_kc");
  }
  s.rigid_body = read_rigid_body(file);
  if (parts.diagonal && file.has("/diagonal")) {
    s.omega = file.read_vector("/diagonal/omega");
    s.V = file.read_matrix("/diagonal/V");
  }
  if (parts.recovery && file.has("/recovery")) s.recovery.push_back(read_recovery(file));
  if (file.has("/provenance")) {
    for (const auto& attribute : file.attributes("/provenance")) {
      if (file.is_string("/provenance", attribute)) s.provenance[attribute] = file.read_string("/provenance", attribute);
    }
  }
  check_parts(s, parts, path.string());
  return s;
}

void write_superelement(const Superelement& s, const std::filesystem::path& path) {
  check(s, path.string());
  Hdf5Writer file(path);
  file.attribute("/", "format", std::string(format_name));
  file.attribute("/", "format_version", std::string(format_version));
  file.attribute("/", "generator", std::string("cbr ") + version());
  file.attribute("/", "content_hash", s.content_hash);
  file.attribute("/", "basis", s.basis);
  file.attribute("/", "n_modes", s.k());
  file.attribute("/", "n_interface", s.c());
  file.write("/matrices/eigenvalues", s.eigenvalues);
  file.write("/matrices/K_cc", s.K_cc);
  file.write("/matrices/M_cc", s.M_cc);
  file.write("/matrices/M_kc", s.M_kc);
  file.write("/dofs/node", s.dof_node);
  file.write("/dofs/component", s.dof_component);
  file.write("/nodes/id", s.node_ids);
  file.write("/nodes/coordinates", s.coordinates);
  // By name, so that the bytes do not depend on the order in which the sets were asked for.
  std::map<std::string, const Surface*> by_name;
  for (const auto& surface : s.surfaces) by_name[surface.name] = &surface;
  for (const auto& [surface_name, surface] : by_name) write_surface(file, *surface);
  for (const auto& [nodeset, nodes] : s.nodesets) file.write("/nodesets/" + nodeset, nodes);
  file.write("/rigid_body/mass", s.rigid_body.mass);
  file.write("/rigid_body/center", Vector(s.rigid_body.center));
  file.write("/rigid_body/inertia", Matrix(s.rigid_body.inertia));
  if (s.has_diagonal_form()) {
    file.write("/diagonal/omega", s.omega);
    file.write("/diagonal/V", s.V);
  }
  for (const auto& recovery : s.recovery) write_recovery(file, recovery);
  for (const auto& [key, value] : s.provenance) file.attribute("/provenance", key, value);
  file.commit();
}

std::string read_content_hash(const std::filesystem::path& path) {
  try {
    const Hdf5Reader file(path);
    check_format(file);
    return file.read_string("/", "content_hash");
  } catch (const InputError&) {
    return "";
  }
}

Matrix reduced_stiffness(const Superelement& s) {
  // K = [diag(eigenvalues) 0; 0 K_cc]   (n x n)
  Matrix K = Matrix::Zero(s.n(), s.n());
  K.diagonal().head(s.k()) = s.eigenvalues;
  K.bottomRightCorner(s.c(), s.c()) = s.K_cc;
  return K;
}

Matrix reduced_mass(const Superelement& s) {
  // M = [I M_kc; M_kc^T M_cc]   (n x n)
  Matrix M = Matrix::Identity(s.n(), s.n());
  M.topRightCorner(s.k(), s.c()) = s.M_kc;
  M.bottomLeftCorner(s.c(), s.k()) = s.M_kc.transpose();
  M.bottomRightCorner(s.c(), s.c()) = s.M_cc;
  return M;
}

Matrix reduced_rigid_modes(const Superelement& s, const Vector3& center) {
  // Translation e_a: u = e_a. Rotation about e_a: u = e_a x (x - center).   R = [0; R_c]   (n x 6)
  Matrix R = Matrix::Zero(s.n(), 6);
  for (Index i = 0; i < s.c(); ++i) {
    const Vector3 arm = s.coordinates.row(s.dof_node[static_cast<std::size_t>(i)]).transpose() - center;
    const int component = s.dof_component[static_cast<std::size_t>(i)];
    for (int axis = 0; axis < 3; ++axis) {
      R(s.k() + i, axis) = component == axis ? 1.0 : 0.0;
      R(s.k() + i, 3 + axis) = Vector3::Unit(axis).cross(arm)(component);
    }
  }
  return R;
}

Vector3 residual_mass_share(const Superelement& s) {
  Vector3 share = Vector3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    Vector r(s.c());  // rigid translation of the interface   (c)
    for (Index i = 0; i < s.c(); ++i) r(i) = s.dof_component[static_cast<std::size_t>(i)] == axis ? 1.0 : 0.0;
    // rho = r^T (M_cc - M_kc^T M_kc) r / r^T M_cc r
    const double whole = r.dot(s.M_cc * r);
    // BLAS complains, on stdout, about a matrix without rows.
    const double in_modes = s.k() > 0 ? (s.M_kc * r).squaredNorm() : 0.0;
    if (whole > 0) share(axis) = 1.0 - in_modes / whole;
  }
  return share;
}

}  // namespace cbr
