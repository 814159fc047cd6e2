// SPDX-License-Identifier: GPL-3.0-or-later
// Fields for ParaView: XDMF (opened by ParaView 5.11 with its time steps) over an HDF5 file.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/files/hdf5_file.hpp"
#include "dynamics/output/field_grids.hpp"
#include "dynamics/setup/built/built_scene.hpp"
#include "dynamics/setup/built/instance_elements.hpp"

namespace cbr {

// Writes RESULTS.xdmf and RESULTS.fields.h5 beside the results file, or RESULTS.exo with the same
// contents. Without commit() no file remains.
class FieldWriter {
 public:
  // Fields kept with a checkpoint: the file of save() and the times to use from it.
  struct Saved {
    std::filesystem::path file;
    std::vector<double> times;
    Index digest = 0;  // of the writer that saved them
  };
  // `fields`: as of output.fields. Reports fields that are not available. `saved`: continues from
  // there. `run_hash`: of the run, empty for modes. InputError: `saved` is of another run, or does
  // not match its checksums and digest.
  FieldWriter(const Scene& scene, const BuiltScene& built, const std::filesystem::path& results,
              Report& report, const std::string& run_hash = "",
              const std::optional<Saved>& saved = {});
  void add(double t);  // the current state of the bodies
  const std::vector<double>& times() const { return times_; }
  Index digest() const { return heavy_->digest(); }  // of all data written so far
  void save(const std::filesystem::path& file);      // a complete file of the data so far
  // RunError for disk errors. frequency_hz: of modes, a step each
  void commit(const std::vector<double>& frequency_hz = {});
  const std::filesystem::path& file() const { return shown_; }  // the file for viewers

 private:
  struct Motion {
    Points u, v;
    std::optional<Matrix3> turn = {};  // large rotation
  };
  void start(const std::string& run_hash);
  void go_on(const Saved& saved, const std::string& run_hash);
  Motion motion_of(const FieldGrid& grid) const;
  Matrix of_contact(const FieldGrid& grid, Vector ContactNodes::*values) const;
  const Points& strained(Index instance);
  Matrix stresses(const FieldGrid& grid, const Matrix3& T);
  Matrix nodal_stresses(const FieldGrid& grid, const Matrix3& T);
  void find_elements(const Scene& scene, Report& report);
  void add_stresses(const std::string& group, const std::string& field, const FieldGrid& grid,
                    const Matrix& stress, double t);
  void write_grids();
  void commit_xdmf(const std::vector<double>& frequency_hz);
  bool wanted(const std::string& field) const;
  bool shares_points(std::size_t grid) const;  // with the previous grid

  const BuiltScene& built_;
  std::vector<std::string> fields_;
  const FieldFormat format_;
  std::filesystem::path shown_, heavy_file_, heavy_name_;
  std::unique_ptr<Hdf5Writer> heavy_;
  std::vector<FieldGrid> grids_;
  std::vector<const ContactNodes*> contact_of_;                  // per instance, or null
  std::map<Index, std::unique_ptr<InstanceElements>> elements_;  // per instance with stress
  Points strained_;  // of the elements of strained_of_ at this time
  Matrix nodal_;     // stress_values() of its nodes; empty: not yet
  Index strained_of_ = -1;
  std::vector<double> times_;
};

}  // namespace cbr
