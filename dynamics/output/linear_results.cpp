// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/output/linear_results.hpp"

#include <fstream>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/base/name_text.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/files/output_file.hpp"
#include "dynamics/output/fields.hpp"

namespace cbr {
namespace {

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
