// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/superelement/superelement_file.hpp"

#include <cmath>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"

namespace cbr {

std::string file_root(const std::string& prefix) { return prefix.empty() ? "/" : prefix; }

namespace {

void write_accuracy(Hdf5Writer& file, const std::string& group, const Superelement::Accuracy& a) {
  file.write(group + "/rho_res", Vector(a.rho_res));
  if (a.rho_floor) file.write(group + "/rho_floor", Vector(*a.rho_floor));
  file.write(group + "/strain_left_out", a.strain_left_out);
  file.write(group + "/largest_left_out", a.largest_left_out);
  for (const auto& [name, surface] : a.surfaces) {
    file.write(group + "/surfaces/" + name + "/impact", surface.impact);
    file.write(group + "/surfaces/" + name + "/strain_left_out", surface.strain_left_out);
  }
  file.write(group + "/frequency_hz", a.frequency_hz);
  file.write(group + "/eigenvalue_error", a.eigenvalue_error);
  if (a.worst_of_ten) file.write(group + "/worst_of_ten", *a.worst_of_ten);
  if (a.interface_share.size() > 0) file.write(group + "/interface_share", a.interface_share);
  file.write(group + "/covered_hz", a.covered_hz);
  file.write(group + "/complete_hz", a.complete_hz);
  file.write(group + "/tolerance", a.tolerance);
}

Vector3 read_vector3(const Hdf5Reader& file, const std::string& dataset) {
  const Vector v = file.read_vector(dataset);
  if (v.size() != 3)
    throw InputError(file.file().string() + ": " + dataset + ": wrong shape (" +
                     std::to_string(v.size()) + "), expected (3)");
  return v;
}

Superelement::Accuracy read_accuracy(const Hdf5Reader& file, const std::string& group) {
  Superelement::Accuracy a;
  a.rho_res = read_vector3(file, group + "/rho_res");
  if (file.has(group + "/rho_floor")) a.rho_floor = read_vector3(file, group + "/rho_floor");
  a.strain_left_out = file.read_vector(group + "/strain_left_out");
  a.largest_left_out = file.read_scalar(group + "/largest_left_out");
  if (file.has(group + "/surfaces")) {
    for (const auto& name : file.children(group + "/surfaces")) {
      const std::string of = group + "/surfaces/" + name;
      a.surfaces[name] = {file.read_scalar(of + "/impact"),
                          file.read_scalar(of + "/strain_left_out")};
    }
  }
  a.frequency_hz = file.read_vector(group + "/frequency_hz");
  a.eigenvalue_error = file.read_vector(group + "/eigenvalue_error");
  if (file.has(group + "/worst_of_ten")) a.worst_of_ten = file.read_scalar(group + "/worst_of_ten");
  if (file.has(group + "/interface_share"))
    a.interface_share = file.read_vector(group + "/interface_share");
  a.covered_hz = file.read_scalar(group + "/covered_hz");
  a.complete_hz = file.read_scalar(group + "/complete_hz");
  a.tolerance = file.read_scalar(group + "/tolerance");
  return a;
}

// Of one figure: its name in the file, its place and its least value; condition numbers may be
// infinite.
template <typename Of, typename Action>
void each_figure(Of& c, const Action& action) {
  action("K_II", c.K_II.plain, 1);
  action("K_II_scaled", c.K_II.scaled, 1);
  action("smallest_pivot", c.smallest_pivot, 0);
  action("reduced_mass", c.mass.plain, 1);
  action("reduced_mass_scaled", c.mass.scaled, 1);
  action("mode_orthogonality", c.modes.orthogonality, 0);
  action("mode_residual", c.modes.residual, 0);
  action("rigid_forces", c.rigid, 0);
  action("reduced_rigid_forces", c.reduced_rigid, 0);
  action("softest", c.softest, 0);
  action("lowest_omega", c.lowest_omega, 0);
  action("largest_omega", c.largest_omega, 0);
}

// The attributes of the group that are words.
template <typename Of, typename Action>
void each_word(Of& c, const Action& action) {
  action("inertia_counts", c.counts);
  action("weakest_pivot_at", c.weakest);
  action("rigid_forces_at", c.rigid_node);
  action("motion_without_stiffness_at", c.loose_node);
}

// Estimates are from below, and rounded
bool is_possible(double value, double least) {
  return value >= least * (1 - 1e-6) && (least == 1 || std::isfinite(value));
}

}  // namespace

void write_extras(Hdf5Writer& file, const std::string& prefix, const Superelement& s) {
  if (s.accuracy) write_accuracy(file, prefix + "/accuracy", *s.accuracy);
  for (const auto& [name, load] : s.loads) {
    file.write(prefix + "/loads/" + name + "/force", load.force);
    file.write(prefix + "/loads/" + name + "/weight", load.weight);
  }
  if (s.n_residual > 0) file.attribute(file_root(prefix), "n_residual", s.n_residual);
  if (s.spin_moments.size() > 0) file.write(prefix + "/spin_moments", s.spin_moments);
  if (s.spin_couplings.size() > 0) file.write(prefix + "/spin_couplings", s.spin_couplings);
  if (s.fixed.any()) {
    file.write(prefix + "/fixed/resisted", s.fixed.resisted);
    file.write(prefix + "/fixed/momentum", s.fixed.momentum);
  }
  write_conditioning(file, prefix, s.conditioning);
}

void read_extras(const Hdf5Reader& file, const std::string& prefix, Superelement& s) {
  if (file.has(prefix + "/accuracy")) s.accuracy = read_accuracy(file, prefix + "/accuracy");
  if (file.has(prefix + "/loads")) {
    for (const auto& name : file.children(prefix + "/loads")) {
      const std::string group = prefix + "/loads/" + name;
      s.loads[name] = {file.read_scalar(group + "/weight"), file.read_matrix(group + "/force")};
    }
  }
  if (file.has_attribute(file_root(prefix), "n_residual"))
    s.n_residual = file.read_index(file_root(prefix), "n_residual");
  if (file.has(prefix + "/spin_moments"))
    s.spin_moments = file.read_matrix(prefix + "/spin_moments");
  if (file.has(prefix + "/spin_couplings"))
    s.spin_couplings = file.read_matrix(prefix + "/spin_couplings");
  if (file.has(prefix + "/fixed")) {
    s.fixed.resisted = file.read_matrix(prefix + "/fixed/resisted");
    s.fixed.momentum = file.read_matrix(prefix + "/fixed/momentum");
  }
  s.conditioning = read_conditioning(file, prefix);
}

void write_conditioning(Hdf5Writer& file, const std::string& prefix,
                        const std::optional<Conditioning>& c) {
  if (!c) return;
  const std::string group = prefix + "/conditioning";
  each_figure(*c, [&](const std::string& name, double value, double) {
    if (!std::isnan(value)) file.write(group + "/" + name, value);
  });
  each_word(*c, [&](const std::string& name, const std::string& text) {
    if (!text.empty()) file.attribute(group, name, text);
  });
  if (c->rho_res) file.write(group + "/rho_res", Vector(*c->rho_res));
  if (!c->knows_frequencies()) return;
  file.attribute(group, "n_zero", c->n_zero);
  file.attribute(group, "n_rigid", c->n_rigid);
}

std::optional<Conditioning> read_conditioning(const Hdf5Reader& file, const std::string& prefix) {
  const std::string group = prefix + "/conditioning";
  if (!file.has(group)) return {};
  Conditioning c;
  each_figure(c, [&](const std::string& name, double& value, double) {
    const std::string dataset = group + "/" + name;
    if (!file.has(dataset)) return;
    value = file.read_scalar(dataset);
    // would be: not known
    if (std::isnan(value))
      throw InputError(file.file().string() + ": " + dataset + ": is not a number");
  });
  each_word(c, [&](const std::string& name, std::string& text) {
    if (file.has_attribute(group, name)) text = file.read_string(group, name);
  });
  if (file.has(group + "/rho_res")) c.rho_res = read_vector3(file, group + "/rho_res");
  if (!c.knows_frequencies()) return c;
  c.n_zero = file.read_index(group, "n_zero");
  c.n_rigid = file.read_index(group, "n_rigid");
  return c;
}

void check_conditioning(const std::optional<Conditioning>& c, Index n, const std::string& where) {
  if (!c) return;
  const auto require = [&](bool right, const std::string& field, const std::string& what) {
    if (!right) throw InputError(where + ": /conditioning: " + field + ": " + what);
  };
  each_figure(*c, [&](const std::string& name, double value, double least) {
    require(std::isnan(value) || is_possible(value, least), name,
            number_text(value) + " found, expected at least " + number_text(least));
  });
  require(!c->rho_res || (c->rho_res->array() > -0.01 && c->rho_res->array() < 1.01).all(),
          "rho_res", "not shares between 0 and 1");
  if (!c->knows_frequencies()) return;
  require(c->n_zero >= 0 && c->n_zero <= n, "attribute 'n_zero'",
          std::to_string(c->n_zero) + " found, there are " + std::to_string(n) + " coordinates");
  require(c->n_rigid >= 0 && c->n_rigid <= n, "attribute 'n_rigid'",
          std::to_string(c->n_rigid) + " found, there are " + std::to_string(n) + " coordinates");
  require(
      std::isnan(c->lowest_omega) || c->lowest_omega <= c->largest_omega, "lowest_omega",
      number_text(c->lowest_omega) + " is above largest_omega, " + number_text(c->largest_omega));
}

namespace {

std::string shape_of(const Matrix& A) {
  return "wrong shape (" + std::to_string(A.rows()) + ", " + std::to_string(A.cols()) + ")";
}

template <typename Require>
void check_fixed(const Superelement& s, const Require& require) {
  const Matrix &resisted = s.fixed.resisted, &momentum = s.fixed.momentum;
  if (resisted.size() == 0 && momentum.size() == 0) return;
  const Index n = s.has_interface_matrices() ? s.n() : s.k();
  require(resisted.rows() >= 1 && resisted.rows() <= 6 && resisted.cols() == 6, "/fixed/resisted",
          shape_of(resisted) + ", expected (r, 6) of 1 to 6 rigid motions");
  require(momentum.rows() == n && momentum.cols() == 6, "/fixed/momentum",
          shape_of(momentum) + ", expected (" + std::to_string(n) + ", 6)");
  require(momentum.allFinite(), "/fixed/momentum", "not finite");
  const Matrix unit = resisted * resisted.transpose();
  const double off = (unit - Matrix::Identity(unit.rows(), unit.rows())).cwiseAbs().maxCoeff();
  require(off <= 1e-6, "/fixed/resisted", "its rows are not orthonormal");
}

// Of at most all elastic modes of a body with six rigid motions.
template <typename Require>
void check_spin_couplings(const Superelement& s, const Require& require) {
  const Matrix& P = s.spin_couplings;
  const char* field = "/spin_couplings";
  if (P.size() == 0) return;
  const std::string shape = shape_of(P) + ", expected ";
  require(P.rows() == P.cols() && P.rows() % 3 == 0, field, shape + "(3 m, 3 m) of m modes");
  require(P.rows() <= 3 * (s.n() - 6), field,
          shape + "at most " + std::to_string(3 * (s.n() - 6)) + " rows, of the " +
              std::to_string(s.n()) + " modes without rigid ones");
  require(P.allFinite(), field, "not finite");
  require((P - P.transpose()).cwiseAbs().maxCoeff() <= 1e-10 * P.cwiseAbs().maxCoeff(), field,
          "not symmetric");
}

}  // namespace

void check_extras(const Superelement& s, const std::string& where) {
  const auto require = [&](bool right, const std::string& field, const std::string& what) {
    if (!right) throw InputError(where + ": " + field + ": " + what);
  };
  require(s.n_residual >= 0 && s.n_residual <= s.k(), "attribute 'n_residual'",
          std::to_string(s.n_residual) + " found, the superelement has " + std::to_string(s.k()) +
              " modes");
  for (const auto& [name, load] : s.loads) {
    const std::string group = "/loads/" + name;
    require(load.force.rows() == s.n() && load.force.cols() == 3, group + "/force",
            shape_of(load.force) + ", expected (" + std::to_string(s.n()) + ", 3)");
    require(load.force.allFinite(), group + "/force", "not finite");
    require(std::isfinite(load.weight) && load.weight > 0, group + "/weight",
            "is not a positive number");
  }
  require(
      s.spin_moments.size() == 0 || (s.spin_moments.rows() == s.n() && s.spin_moments.cols() == 6),
      "/spin_moments", shape_of(s.spin_moments) + ", expected (" + std::to_string(s.n()) + ", 6)");
  require(s.spin_moments.allFinite(), "/spin_moments", "not finite");
  check_spin_couplings(s, require);
  check_fixed(s, require);
  check_conditioning(s.conditioning, s.n(), where);
  if (!s.accuracy) return;
  const Superelement::Accuracy& a = *s.accuracy;
  const std::string group = "/accuracy/";
  require(a.rho_res.allFinite() && (!a.rho_floor || a.rho_floor->allFinite()), group + "rho_res",
          "not finite");
  require(a.strain_left_out.size() == 6, group + "strain_left_out",
          "wrong shape (" + std::to_string(a.strain_left_out.size()) + "), expected (6)");
  require(a.frequency_hz.size() == a.eigenvalue_error.size(), group + "eigenvalue_error",
          "wrong length " + std::to_string(a.eigenvalue_error.size()) + ", expected " +
              std::to_string(a.frequency_hz.size()));
  require(a.interface_share.size() == 0 || a.interface_share.size() == a.frequency_hz.size(),
          group + "interface_share",
          "wrong length " + std::to_string(a.interface_share.size()) + ", expected " +
              std::to_string(a.frequency_hz.size()));
  require(a.interface_share.allFinite(), group + "interface_share", "not finite");
  require(!a.worst_of_ten || std::isfinite(*a.worst_of_ten), group + "worst_of_ten", "not finite");
  require(
      a.strain_left_out.allFinite() && a.frequency_hz.allFinite() && a.eigenvalue_error.allFinite(),
      "/accuracy", "not finite");
  for (const auto& [name, of] : a.surfaces)
    require(std::isfinite(of.impact) && std::isfinite(of.strain_left_out),
            group + "surfaces/" + name, "not finite");
  for (const double value : {a.largest_left_out, a.covered_hz, a.complete_hz, a.tolerance})
    require(std::isfinite(value), "/accuracy", "not finite");
}

}  // namespace cbr
