// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/output/results.hpp"

#include <chrono>
#include <fstream>
#include <map>
#include <sstream>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/base/name_text.hpp"
#include "common/fem/stress_values.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/files/output_file.hpp"
#include "common/superelement/superelement.hpp"
#include "dynamics/output/fields.hpp"
#include "dynamics/setup/modal/harmonic.hpp"
#include "dynamics/setup/modal/scene_modes.hpp"

namespace cbr {
namespace {

Points points(const Series3& series) {
  const Index n = static_cast<Index>(series.values.size()) / 3;
  return Eigen::Map<const Points>(series.values.data(), n, 3);
}

void write_bodies(Hdf5Writer& file, const Simulation& simulation, const RunResult& result) {
  for (std::size_t b = 0; b < result.bodies.size(); ++b) {
    const bool is_joint = simulation.n_instances > 0 && b >= simulation.n_instances;
    const std::string group =
        (is_joint ? "/joints/" : "/instances/") + group_name(simulation.bodies[b]->name()) + "/";
    const RunResult::OfBody& of = result.bodies[b];
    file.write(group + "center_of_mass", points(of.center_of_mass));
    file.write(group + "momentum", points(of.momentum));
    file.write(group + "angular_momentum", points(of.angular_momentum));
    file.write(group + "kinetic_energy", of.kinetic_energy);
    file.write(group + "strain_energy", of.strain_energy);
    if (!of.reaction.values.empty()) file.write(group + "reaction", points(of.reaction));
    if (of.orientation.empty()) continue;
    const auto n = static_cast<Index>(of.orientation.size()) / 4;
    file.write(group + "orientation",
               Matrix(Eigen::Map<const RowMatrix>(of.orientation.data(), n, 4)));
  }
}

void write_monitors(Hdf5Writer& file, const Simulation& simulation, const RunResult& result) {
  for (std::size_t m = 0; m < result.monitors.size(); ++m) {
    const std::string group = "/surfaces/" + group_name(simulation.monitors[m].name) + "/";
    file.write(group + "mean_position", points(result.monitors[m].mean_position));
    file.write(group + "mean_velocity", points(result.monitors[m].mean_velocity));
    file.write(group + "mean_acceleration", points(result.monitors[m].mean_acceleration));
    file.write(group + "force", points(result.monitors[m].force));
    if (!result.monitors[m].rotation.values.empty())
      file.write(group + "rotation", points(result.monitors[m].rotation));
  }
}

void write_reactions(Hdf5Writer& file, const Simulation& simulation, const RunResult& result) {
  for (std::size_t i = 0; i < result.reactions.size(); ++i) {
    const ReactionWatch& watch = simulation.reactions[i];
    const ReactionSet& set = watch.body->supports()->sets()[watch.set];
    const std::string group =
        "/instances/" + group_name(watch.instance) + "/reactions/" + group_name(set.name) + "/";
    file.write(group + "force", points(result.reactions[i].force));
    file.write(group + "moment", points(result.reactions[i].moment));
    file.write(group + "point", Vector(set.point));
  }
}

// Which face of a shell each stress is of, where there are shells.
void write_faces(Hdf5Writer& file, const std::string& group, const std::vector<Index>& faces) {
  if (std::any_of(faces.begin(), faces.end(), [](Index face) { return face != 0; }))
    file.write(group + "face", faces);
}

// Each column of stress_values() under its name; rows: outputs, columns: nodes or elements.
void write_watches(Hdf5Writer& file, const Simulation& simulation, const RunResult& result) {
  for (std::size_t w = 0; w < result.watches.size(); ++w) {
    const StressWatch& watch = simulation.watches[w];
    const std::string group =
        "/stress/" + group_name(watch.name) + (watch.of_nodes ? "/" : "/elements/");
    file.write(group + (watch.of_nodes ? "node_id" : "element_id"), watch.ids);
    if (watch.of_nodes) file.write(group + "block_id", watch.block_ids);
    write_faces(file, group, watch.faces);
    const auto m = static_cast<Index>(watch.ids.size()), n = static_cast<Index>(result.time.size());
    const Matrix values =
        stress_values(Eigen::Map<const RowMatrix>(result.watches[w].data(), n * m, 6));
    for (Index j = 0; j < n_stress_values; ++j) {
      const Vector column = values.col(j);
      file.write(group + std::string(stress_names[j]),
                 Matrix(Eigen::Map<const RowMatrix>(column.data(), n, m)));
    }
  }
}

void write_envelope(Hdf5Writer& file, const std::string& group, const Matrix& extremes) {
  file.write(group + "von_mises", Vector(extremes.col(0)));
  file.write(group + "von_mises_time", Vector(extremes.col(1)));
  file.write(group + "principal_1", Vector(extremes.col(2)));
  file.write(group + "principal_3", Vector(extremes.col(3)));
}

void write_scans(Hdf5Writer& file, const Simulation& simulation, const RunResult& result) {
  for (std::size_t i = 0; i < result.scans.size(); ++i) {
    const StressScan& scan = simulation.scans[i];
    const RunResult::OfScan& of = result.scans[i];
    const std::string group = "/stress/" + group_name(scan.name) + "/";
    if (scan.n_worst > 0) {
      const auto n = static_cast<Index>(result.time.size());
      IndexTable ids(n, scan.n_worst), faces = ids;
      for (Index k = 0; k < ids.size(); ++k) {
        ids(k / scan.n_worst, k % scan.n_worst) = scan.element_ids[of.worst[k]];
        faces(k / scan.n_worst, k % scan.n_worst) = scan.element_faces[of.worst[k]];
      }
      file.write(group + "worst/element_id", ids);
      if (!faces.isZero(0)) file.write(group + "worst/face", faces);
      file.write(group + "worst/von_mises",
                 Matrix(Eigen::Map<const RowMatrix>(of.worst_stress.data(), n, scan.n_worst)));
    }
    if (!scan.envelope) continue;
    file.write(group + "envelope/elements/element_id", scan.element_ids);
    write_faces(file, group + "envelope/elements/", scan.element_faces);
    write_envelope(file, group + "envelope/elements/", of.of_elements);
    file.write(group + "envelope/nodes/node_id", scan.node_ids);
    file.write(group + "envelope/nodes/block_id", scan.node_block_ids);
    write_faces(file, group + "envelope/nodes/", scan.node_faces);
    write_envelope(file, group + "envelope/nodes/", of.of_nodes);
  }
}

void write_contact(Hdf5Writer& file, const Simulation& simulation, const RunResult& result) {
  file.write("/contact/active", result.active);
  for (std::size_t p = 0; p < result.pairs.size(); ++p) {
    const RunResult::OfPair& of = result.pairs[p];
    const std::string group = "/contact/" + group_name(simulation.pairs[p].name) + "/";
    for (std::size_t i = 0; i < of.series.size(); ++i) {
      const PairOutput& output = pair_outputs()[i];
      if (output.size == 1) file.write(group + output.name, of.series[i].values);
      if (output.size == 3) file.write(group + output.name, points(of.series[i]));
      file.attribute(group + output.name, "dimension", output.dimension);
    }
  }
}

// Number of values per output in RunResult.
double values_per_output(const Simulation& simulation) {
  double values = 8;  // time, energies and works, active
  values += 11 * static_cast<double>(simulation.bodies.size()) +
            12 * static_cast<double>(simulation.monitors.size()) +
            6 * static_cast<double>(simulation.reactions.size());
  for (const StressWatch& watch : simulation.watches)
    values += 6 * static_cast<double>(watch.ids.size());
  for (const StressScan& scan : simulation.scans) values += 2 * static_cast<double>(scan.n_worst);
  for (const auto& supports : simulation.supports) values += supports ? 3 : 0;
  double of_pair = 0;
  for (const PairOutput& output : pair_outputs()) of_pair += static_cast<double>(output.size);
  for (const ContactPair& pair : simulation.pairs) values += pair.of_all ? 0 : of_pair;
  return values;
}

void write_table(const std::filesystem::path& path, const HarmonicResponse& response) {
  TemporaryFile temporary(path);
  std::ofstream out(temporary.path());
  out << "surface,frequency_hz,x_real,x_imag,y_real,y_imag,z_real,z_imag\n";
  out.precision(17);
  for (const HarmonicResponse::OfSet& set : response.sets) {
    for (Index i = 0; i < response.frequency_hz.size(); ++i) {
      out << set.name << "," << response.frequency_hz[i];
      for (int axis = 0; axis < 3; ++axis)
        out << "," << set.displacement(i, axis).real() << "," << set.displacement(i, axis).imag();
      out << "\n";
    }
  }
  out.close();
  if (!out) throw RunError(path.string() + ": cannot be written");
  temporary.commit();
}

// Sets one mode as the only motion.
void show(SceneModes& modes, const InstanceModes& of, Index mode) {
  for (BodyModes& body : modes.scene->bodies) body.take_shape(Vector::Zero(body.omega().size()));
  for (std::size_t i = 0; i < of.bodies.size(); ++i)
    modes.scene->bodies[of.bodies[i]].take_shape(of.shapes[i].col(mode));
}

}  // namespace

void refuse_names_that_meet(const Simulation& simulation) {
  const auto refuse = [](const auto& list, const std::string& what) {
    std::vector<std::string> names;
    for (const auto& one : list) names.push_back(one.name);
    refuse_equal_groups(names, what);
  };
  refuse(simulation.monitors, "output.history: the sets");
  refuse(simulation.pairs, "contact: the pairs");
  refuse(simulation.watches, "output.stress: the sets");
  refuse(simulation.scans, "output.stress: the sets");
  std::vector<std::string> reactions;
  for (const ReactionWatch& watch : simulation.reactions)
    reactions.push_back(watch.instance + "." + watch.body->supports()->sets()[watch.set].name);
  refuse_equal_groups(reactions, "output.reactions: the sets");
}

void require_memory_for_outputs(const Scene& scene, const Simulation& simulation, double memory) {
  const TimePlan& plan = simulation.plan;
  const double outputs = static_cast<double>(plan.n_steps() / plan.steps_per_output) + 1,
               values = values_per_output(simulation);
  const double bytes = 8 * outputs * values;
  if (bytes <= memory) return;
  const bool has_every = scene.output.every > 0;
  std::ostringstream text;
  text.precision(3);
  text << (has_every ? scene.output.source : scene.time->source).text() << ": "
       << (has_every ? "output.every" : "time") << ": " << outputs << " outputs of " << values
       << " numbers take " << human_bytes(bytes) << ", the machine has " << human_bytes(memory)
       << ": give output.every " << 2 * plan.end * bytes / memory / outputs << " s or more";
  throw InputError(text.str());
}

RunInputs inputs_of(const Scene& scene, const std::string& hash,
                    const std::filesystem::path& results) {
  const auto folder = std::filesystem::absolute(results).parent_path();
  std::ostringstream text;
  write_scene(scene, text);
  RunInputs inputs{text.str(), hash, {}};
  std::map<std::filesystem::path, std::string> hashes;  // thousands of instances may share a file
  for (const Instance& instance : scene.instances) {
    const Component& component = component_of(scene, instance);
    if (instance.as != InstanceKind::superelement || !component.reduction) continue;
    const std::filesystem::path& file = component.reduction->superelement;
    const auto [known, is_new] = hashes.try_emplace(file);
    if (is_new) known->second = read_content_hash(file);
    inputs.superelements.push_back(
        {instance.name,
         std::filesystem::absolute(file).lexically_proximate(folder).generic_string(),
         known->second});
  }
  return inputs;
}

void write_results(const std::filesystem::path& path, const Simulation& simulation,
                   const RunResult& result, const Report& report, const RunInputs& inputs,
                   std::optional<double> outside_basis) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  Hdf5Writer file(path);
  file.start("cbr-results", "1.14", "cbr-dyn");
  Index n_dofs = 0;
  for (const auto& body : simulation.bodies) n_dofs += body->n_dofs();
  file.attribute("/", "partial", Index{result.ended_at ? 1 : 0});
  if (result.preload_reached) file.attribute("/", "preload_reached", *result.preload_reached);
  file.attribute("/", "steps", result.steps);
  file.attribute("/", "n_dofs", n_dofs);
  file.attribute("/", "warnings", join(report.warnings(), "\n"));
  if (!inputs.scene.empty()) file.attribute("/", "scene", inputs.scene);
  if (!inputs.hash.empty()) file.attribute("/", "run_hash", inputs.hash);
  for (const char* phase : {"read", "setup", "steps"})
    file.attribute("/", std::string("wall_seconds_") + phase, report.seconds(phase));
  file.write("/time", result.time);
  write_monitors(file, simulation, result);
  write_bodies(file, simulation, result);
  for (const SuperelementOfInstance& of : inputs.superelements) {
    file.attribute("/instances/" + group_name(of.instance), "superelement", of.file);
    file.attribute("/instances/" + group_name(of.instance), "superelement_hash", of.content_hash);
  }
  write_reactions(file, simulation, result);
  write_watches(file, simulation, result);
  write_scans(file, simulation, result);
  file.write("/energy/total", result.total);
  file.write("/energy/work_external", result.work_external);
  file.write("/energy/work_contact", result.work_contact);
  file.write("/energy/work_friction", result.work_friction);
  file.write("/energy/work_damping", result.work_damping);
  file.write("/energy/work_numerical", result.work_numerical);
  if (outside_basis) file.attribute("/energy", "outside_basis", *outside_basis);
  write_contact(file, simulation, result);
  // The time so far: without closing the file
  file.attribute("/", "wall_seconds_write",
                 std::chrono::duration<double>(Clock::now() - start).count());
  file.commit();
}

std::filesystem::path sweep_table(const std::filesystem::path& results) {
  return std::filesystem::path(results).replace_extension(".csv");
}

void write_sweep(const std::filesystem::path& path, const HarmonicResponse& response) {
  Hdf5Writer file(path);
  file.start("cbr-sweep", "1.1", "cbr-dyn");
  file.write("/frequency_hz", response.frequency_hz);
  for (const HarmonicResponse::OfSet& set : response.sets) {
    const std::string name = group_name(set.name);
    file.write("/surfaces/" + name + "/displacement_real", Points(set.displacement.real()));
    file.write("/surfaces/" + name + "/displacement_imag", Points(set.displacement.imag()));
  }
  file.commit();
  write_table(sweep_table(path), response);
}

void write_modes(const std::filesystem::path& path, SceneModes& modes, Report& report) {
  Hdf5Writer file(path);
  file.start("cbr-modes", "1.1", "cbr-dyn");
  FieldWriter fields(modes.scene->scene, modes.scene->built, path, report);
  std::vector<double> frequency_hz;  // of each step
  for (const InstanceModes& of : modes.instances) {
    file.write("/instances/" + of.instance + "/frequency_hz", of.frequency_hz);
    file.write("/instances/" + of.instance + "/damping_ratio", of.damping_ratio);
    std::vector<Index> steps;
    for (Index j = 0; j < of.frequency_hz.size(); ++j) {
      show(modes, of, j);
      steps.push_back(static_cast<Index>(frequency_hz.size()));
      frequency_hz.push_back(of.frequency_hz(j));
      fields.add(static_cast<double>(frequency_hz.size()));
    }
    file.write("/instances/" + of.instance + "/field_step", steps);
  }
  fields.commit(frequency_hz);
  file.commit();
}

}  // namespace cbr
