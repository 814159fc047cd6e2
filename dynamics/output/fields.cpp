// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/output/fields.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/fem/stress_values.hpp"
#include "common/files/output_file.hpp"
#include "dynamics/output/field_formats.hpp"
#include "dynamics/output/output_names.hpp"

namespace cbr {
namespace {

template <typename Array>
void require_finite(const Array& values, const std::string& field, const FieldGrid& grid,
                    double t) {
  if (values.allFinite()) return;
  std::ostringstream message;
  message << "field '" << field << "' of " << grid.name << " is no longer finite at t = " << t
          << " s: are loads, velocities or units beyond a double's reach? Nothing has been written";
  throw RunError(message.str());
}

}  // namespace

FieldWriter::FieldWriter(const Scene& scene, const BuiltScene& built,
                         const std::filesystem::path& results, Report& report,
                         const std::string& run_hash, const std::optional<Saved>& saved)
    : built_(built),
      fields_(scene.output.fields),
      format_(scene.output.format),
      shown_(format_ == FieldFormat::exodus ? exodus_file(results) : xdmf_file(results)),
      heavy_file_(fields_file(results)),
      grids_(field_grids(scene, built, report)) {
  heavy_name_ = heavy_file_.filename();
  if (format_ == FieldFormat::exodus && grids_.empty())
    throw InputError(
        scene.output.source.text() +
        ": output.format: exodus needs an element or a face to show, and the scene has " +
        "none: leave output.fields out, or reduce with faces on the interface");
  if (std::any_of(fields_.begin(), fields_.end(), is_stress)) find_elements(scene, report);
  contact_of_.assign(built.simulation.bodies.size(), nullptr);
  for (const ContactNodes& contact : built.simulation.contact_nodes)
    contact_of_[contact.body] = &contact;
  saved ? go_on(*saved, run_hash) : start(run_hash);
}

void FieldWriter::start(const std::string& run_hash) {
  heavy_ = std::make_unique<Hdf5Writer>(heavy_file_);
  heavy_->start("cbr-fields", "1.5", "cbr-dyn");
  if (!run_hash.empty()) heavy_->attribute("/", "run_hash", run_hash);
  write_grids();
}

void FieldWriter::write_grids() {
  for (std::size_t g = 0; g < grids_.size(); ++g) {
    const FieldGrid& grid = grids_[g];
    const std::string group = grid_group(g);
    if (shares_points(g)) {
      heavy_->link(grid_group(g - 1) + "points", group + "points");
      heavy_->link(grid_group(g - 1) + "node_ids", group + "node_ids");
    } else {
      heavy_->write(group + "points", grid.points);
      heavy_->write(group + "node_ids", grid.node_ids);
    }
    heavy_->write(group + "cells", grid.cells);
    heavy_->write(group + "element_ids", grid.element_ids);
    const std::string object = group.substr(0, group.size() - 1);
    heavy_->attribute(object, "name", grid.name);
    heavy_->attribute(object, "instance", built_.instances[grid.instance].name);
    heavy_->attribute(object, "topology", grid.topology);
  }
}

// Continues from a saved file. It has more steps if it was saved after the checkpoint and the run
// ended before the next one.
void FieldWriter::go_on(const Saved& saved, const std::string& run_hash) {
  times_ = saved.times;
  std::error_code error;
  const std::string cure =
      ": put back the file that was written with the checkpoint, or start the run again, without "
      "--restart";
  if (!std::filesystem::exists(saved.file, error))
    throw InputError(
        saved.file.string() +
        ": no such file: holds the fields (output.fields) of the checkpoint beside it" + cure);
  try {
    const Hdf5Reader kept(saved.file);
    const bool same =
        kept.has_attribute("/", "run_hash") && kept.read_string("/", "run_hash") == run_hash;
    if (!same)
      throw InputError(saved.file.string() + ": is not of the run that the checkpoint is of");
    Index digest = 0;
    const auto add = [&](const std::string& group) {
      if (kept.has(group)) digest ^= kept.compare_checksums(group).digest;
    };
    add("/grids");
    for (std::size_t step = 0; step < times_.size(); ++step)
      add(step_group(step).substr(0, step_group(step).size() - 1));
    if (digest != saved.digest)
      throw InputError(saved.file.string() +
                       ": is damaged: its fields are not those of the checkpoint");
  } catch (const InputError& wrong) {
    throw InputError(wrong.what() + cure);
  }
  heavy_ = std::make_unique<Hdf5Writer>(heavy_file_, saved.file);
  heavy_->add_checksums(saved.digest);
  for (std::size_t step = times_.size();; ++step) {
    const std::string group = step_group(step);
    if (!heavy_->remove(group.substr(0, group.size() - 1))) break;
  }
}

void FieldWriter::save(const std::filesystem::path& file) { heavy_->save_copy(file); }

bool FieldWriter::wanted(const std::string& field) const {
  return std::find(fields_.begin(), fields_.end(), field) != fields_.end();
}

// Finds the elements of each grid; rigid bodies have no stress.
void FieldWriter::find_elements(const Scene& scene, Report& report) {
  for (FieldGrid& grid : grids_) {
    const auto& of = built_.instances[grid.instance];
    if (!grid.block || of.is_rigid) continue;
    auto& elements = elements_[grid.instance];
    if (!elements) elements = std::make_unique<InstanceElements>(scene, of, scene.output.source);
    const auto& groups = elements->groups();
    for (std::size_t g = 0; g < groups.size(); ++g)
      if (groups[g].element_ids == grid.element_ids) grid.groups.push_back(static_cast<Index>(g));
    if (grid.groups.empty())
      report.line("note: no stress of the shells of '" + of.name +
                  "': its superelement has no rotations of them; run cbr-reduce --force");
  }
}

namespace {

// Rotation of a body with large rotation, scene axes.
std::optional<Matrix3> turn_of(const Body& body) {
  const auto q = body.state().orientation;
  if (!q) return {};
  return Eigen::Quaterniond((*q)[0], (*q)[1], (*q)[2], (*q)[3]).toRotationMatrix();
}

}  // namespace

FieldWriter::Motion FieldWriter::motion_of(const FieldGrid& grid) const {
  Motion motion;
  Body& body = *built_.simulation.bodies[grid.instance];
  if (grid.part < 0) {
    body.displacements(motion.u, motion.v);
    motion.u.conservativeResize(grid.points.rows(), Eigen::NoChange);
    motion.v.conservativeResize(grid.points.rows(), Eigen::NoChange);
    if (body.turns()) motion.turn = turn_of(body);
    return motion;
  }
  const auto& of = built_.instances[grid.instance];
  const ReducedPart& part = of.parts[grid.part];
  const Superelement& s = *part.superelement;
  const Superelement::Recovery& recovery = s.recovery.front();
  const auto whole = [&](const Vector& q) {
    Vector u_c(s.c());
    Points u = Points::Zero(grid.points.rows(), 3);
    for (Index i = 0; i < s.c(); ++i) {
      const int d = s.dof_component[i] % 3;
      u_c[i] = q[of.n_modal + 3 * part.node[s.dof_node[i]] + d];
      u(s.dof_node[i], d) = u_c[i];
    }
    // Rotation nodes move with their own node
    for (const auto& [node, rotation] : of.geometry->rotations) u.row(rotation) = u.row(node);
    // u_I = Psi u_c + Phi q_k, then to the scene's axes
    const Vector u_I = recovery.Psi * u_c + recovery.Phi * q.segment(part.first_mode, s.k());
    const Index n = recovery.coordinates.rows();
    u.bottomRows(n) = Eigen::Map<const Points>(u_I.data(), n, 3);
    return Points(u * of.placement.T.transpose());
  };
  Vector q, rates;
  body.coordinates(q, rates);
  motion.u = whole(q);
  motion.v = whole(rates);
  motion.turn = turn_of(body);
  body.turn(grid.points, motion.u, motion.v);
  return motion;
}

// Displacements of the instance's elements at this time, without its large rotation.
const Points& FieldWriter::strained(Index instance) {
  if (strained_of_ == instance) return strained_;
  Vector q, rates;
  built_.simulation.bodies[instance]->coordinates(q, rates);
  strained_ = elements_.at(instance)->displacements(q);
  strained_of_ = instance;
  nodal_.resize(0, 0);
  return strained_;
}

namespace {

// From stress_values() of the groups of a grid, those of datasets_of().
Matrix of_grid(const FieldGrid& grid, Index rows, const std::vector<Matrix>& of_groups) {
  if (of_groups.empty()) return Matrix::Zero(rows, (grid.is_shell() ? 3 : 1) * n_stress_values);
  if (!grid.is_shell()) return of_groups.front();
  const Matrix &top = of_groups.front(), &bottom = of_groups.back();
  Matrix all(rows, 3 * n_stress_values);
  all << top, top, bottom;
  for (Index i = 0; i < rows; ++i)
    if (bottom(i, von_mises_column) > top(i, von_mises_column))
      all.row(i).head(n_stress_values) = bottom.row(i);
  return all;
}

}  // namespace

// At the elements' centres, scene axes; T: from component axes.
Matrix FieldWriter::stresses(const FieldGrid& grid, const Matrix3& T) {
  std::vector<Matrix> of_groups;
  for (const Index g : grid.groups) {
    const InstanceElements& elements = *elements_.at(grid.instance);
    of_groups.push_back(stress_values(turned_stress(
        elements.element_stresses(elements.groups()[g], strained(grid.instance)), T)));
  }
  return of_grid(grid, grid.cells.rows(), of_groups);
}

// At each point of the grid in the material of its block; 0 for points without an element.
Matrix FieldWriter::nodal_stresses(const FieldGrid& grid, const Matrix3& T) {
  std::vector<Matrix> of_groups;
  for (const Index g : grid.groups) {
    const InstanceElements& elements = *elements_.at(grid.instance);
    const Points& u = strained(grid.instance);
    if (nodal_.size() == 0) nodal_ = stress_values(turned_stress(elements.nodal_stresses(u), T));
    Matrix& out = of_groups.emplace_back(Matrix::Zero(grid.points.rows(), n_stress_values));
    for (Index i = 0; i < out.rows(); ++i) {
      const Index node =
          grid.part < 0 ? i : elements.node_of_part(static_cast<std::size_t>(grid.part), i);
      if (const Index place = elements.place(node, elements.groups()[g].material); place >= 0)
        out.row(i) = nodal_.row(place);
    }
  }
  return of_grid(grid, grid.points.rows(), of_groups);
}

// p x 1: at contact nodes, 0 elsewhere.
Matrix FieldWriter::of_contact(const FieldGrid& grid, Vector ContactNodes::*values) const {
  const auto& of = built_.instances[grid.instance];
  Vector of_body = Vector::Zero(built_.simulation.bodies[grid.instance]->n_nodes());
  if (const ContactNodes* contact = contact_of_[grid.instance])
    of_body(contact->nodes) = contact->*values;
  if (grid.part < 0) return of_body.head(grid.points.rows());
  const std::vector<Index>& node = of.parts[grid.part].node;
  Matrix out = Matrix::Zero(grid.points.rows(), 1);
  out.topRows(static_cast<Index>(node.size())) = of_body(node);
  return out;
}

// Grids of a mesh's blocks share all of its points, and so the fields at points.
bool FieldWriter::shares_points(std::size_t g) const {
  return g > 0 && grids_[g].instance == grids_[g - 1].instance &&
         grids_[g].part == grids_[g - 1].part;
}

void FieldWriter::add(double t) {
  const std::string step = step_group(times_.size());
  strained_of_ = -1;
  Motion motion;
  for (std::size_t g = 0; g < grids_.size(); ++g) {
    const bool same = shares_points(g);
    if (!same) motion = motion_of(grids_[g]);
    const std::string group = step + std::to_string(g) + "/",
                      before = same ? step + std::to_string(g - 1) + "/" : "";
    const auto write = [&](const std::string& field, const auto& values) {
      if (!wanted(field)) return;
      if (same) return heavy_->link(before + field, group + field);
      const auto& found = values();
      require_finite(found, field, grids_[g], t);
      heavy_->write(group + field, found);
    };
    write("displacement", [&]() -> const Points& { return motion.u; });
    write("velocity", [&]() -> const Points& { return motion.v; });
    write("contact_pressure", [&] { return of_contact(grids_[g], &ContactNodes::pressure); });
    write("contact_slip", [&] { return of_contact(grids_[g], &ContactNodes::slip); });
    if (!grids_[g].block) continue;
    Matrix3 T = built_.instances[grids_[g].instance].placement.T;
    if (motion.turn) T = *motion.turn * T;
    if (wanted("stress")) add_stresses(group, "stress", grids_[g], stresses(grids_[g], T), t);
    if (wanted("nodal_stress"))
      add_stresses(group, "nodal_stress", grids_[g], nodal_stresses(grids_[g], T), t);
  }
  times_.push_back(t);
}

void FieldWriter::add_stresses(const std::string& group, const std::string& field,
                               const FieldGrid& grid, const Matrix& stress, double t) {
  require_finite(stress, field, grid, t);
  const std::vector<std::string> datasets = datasets_of(field, grid.is_shell());
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    heavy_->write(group + datasets[i], Matrix(stress.col(static_cast<Index>(i))));
  }
}

void FieldWriter::commit(const std::vector<double>& frequency_hz) {
  if (format_ == FieldFormat::xdmf) return commit_xdmf(frequency_hz);
  heavy_->use_and_remove([&](const std::filesystem::path& file) {
    write_exodus_fields(file, times_, grids_, fields_, shown_);
  });
}

void FieldWriter::commit_xdmf(const std::vector<double>& frequency_hz) {
  heavy_->write("/times", times_);
  if (!frequency_hz.empty()) heavy_->write("/frequency_hz", frequency_hz);
  heavy_->commit();
  TemporaryFile temporary(shown_);
  errno = 0;
  std::ofstream file(temporary.path());
  write_xdmf(file, heavy_name_, times_, grids_, fields_);
  file.close();
  if (!file)
    throw RunError(shown_.string() + ": cannot be written" +
                   (errno != 0 ? ": " + std::string(std::strerror(errno)) : ""));
  temporary.commit();
}

}  // namespace cbr
