// SPDX-License-Identifier: GPL-3.0-or-later
// What a run refuses to write over, and checkpoints' fields that are not what was kept.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "dynamics/output/checkpoint.hpp"
#include "dynamics/output/output_names.hpp"
#include "dynamics/program.hpp"
#include "dynamics/setup/contact/contact_sides.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/dynamics/bricks.hpp"

namespace cbr::program_files_test {
namespace {

class ProgramFiles : public ::testing::Test {
 protected:
  ProgramFiles() {
    write_mesh(test::brick({2, 1, 1}, Vector3(1, 0.5, 0.5)), folder_ / "block.msh");
  }

  std::string scene(const std::string& output) {
    std::ofstream(folder_ / "scene.yaml")
        << "materials:\n  soft: {youngs_modulus: 100, poissons_ratio: 0.25, density: 1}\n"
           "components:\n  block: {mesh: block.msh, material: soft}\n"
           "instances:\n  a: {component: block, as: mesh, velocity: [0.3, 0, 0]}\n"
           "time: {end: 0.02, step: 1.0e-3}\noutput: {every: 2.0e-3"
        << output << "}\n";
    return (folder_ / "scene.yaml").string();
  }
  std::filesystem::path in(const std::string& name) const { return folder_ / name; }

  void run(const std::string& output, const std::string& restart = "",
           const std::string& timings = "", const std::string& results = "r.h5") {
    Report report("test", Verbosity::quiet);
    const auto at = [&](const std::string& name) {
      return name.empty() ? std::filesystem::path() : folder_ / name;
    };
    run_scene(scene(output), folder_ / results, report, {}, at(restart), at(timings));
  }

  // What is refused, and that it is so before the first step.
  std::string refused(const std::string& output, const std::string& restart = "",
                      const std::string& timings = "") {
    const auto written = [&] {
      return std::filesystem::exists(in("r.h5")) ? std::filesystem::last_write_time(in("r.h5"))
                                                 : std::filesystem::file_time_type::min();
    };
    const auto before = written();
    const std::string message = test::refusal_of([&] { run(output, restart, timings); });
    EXPECT_EQ(before, written());
    EXPECT_NE(message, "no error");
    return message;
  }

  void make_foreign(const std::string& name) {
    Hdf5Writer file(in(name));
    file.write("/values", 1.0);
    file.commit();
  }

  test::TemporaryFolder folder_;
};

void expect_in(const std::string& text, const std::vector<std::string>& words) {
  for (const auto& word : words) EXPECT_SAYS(text, word) << word << " in: " << text;
}

TEST_F(ProgramFiles, OutputsOfOneNameAreRefused) {
  const std::string fields = ", fields: [displacement]";
  expect_in(refused("", "", "r.h5"), {"r.h5", "timings", "results", "--timings"});
  expect_in(refused(fields, "", "r.xdmf"), {"r.xdmf", "timings", "fields"});
  expect_in(refused(", checkpoint: {every_steps: 5, file: c.h5}", "", "c.h5"),
            {"c.h5", "timings", "checkpoint"});
  // the last one's fields are r.fields.h5
  for (const std::string name : {"r.fields.h5", "r.xdmf", "r.cp"})
    expect_in(refused(fields + ", checkpoint: {every_steps: 5, file: " + name + "}"),
              {"fields", "output.checkpoint.file"});
  expect_in(refused(", checkpoint: {every_steps: 5, file: r.h5}"),
            {"results", "output.checkpoint.file"});
  run(", checkpoint: {every_steps: 5, file: r.xdmf}");  // no fields, no collision
}

TEST_F(ProgramFiles, ResultsReplaceNoOtherFile) {
  std::ofstream(in("r.h5")) << "my notes\n";
  expect_in(refused(""), {"r.h5", "exists and is not an HDF5 file", "--output"});
  std::ofstream(in("r.h5"), std::ios::trunc).flush();
  run("");  // over an empty one, as mktemp makes it
  run("");  // its own, again
}

TEST_F(ProgramFiles, PairsThatMemoryCannotHoldAreRefused) {
  ContactOptions all;
  all.source = {"a.yaml", 7};
  EXPECT_NO_THROW(require_memory_for_pairs(1e6, 1e9, all));
  EXPECT_SAYS(test::refusal_of([&] { require_memory_for_pairs(2e8, 24e9, all); }),
              "a.yaml:7: contact: all makes 2e+08 pairs, which take 60.0 GB or more, the "
              "machine has 24.0 GB");
}

TEST_F(ProgramFiles, SaysWhenPositionsAreTooFarOutToTellGaps) {
  const auto said = [&](const std::string& distance) {
    std::string text = test::bytes_of(scene(""));
    const std::string velocity = "velocity: [0.3, 0, 0]";
    text.replace(text.find(velocity), velocity.size(),
                 velocity + ", position: [0, " + distance + ", 0]");
    std::ofstream(in("far.yaml")) << text;
    testing::internal::CaptureStderr();
    Report report("test", Verbosity::quiet);
    run_scene(in("far.yaml").string(), in("r.h5"), report);
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(said("1.0e6").find("from the origin"), std::string::npos);
  EXPECT_SAYS(said("1.0e12"), "instance 'a' is 1 across and lies 1e+12 from the origin");
}

TEST_F(ProgramFiles, FieldsReplaceFieldsAlone) {
  const std::string fields = ", fields: [displacement]",
                    both = fields + ", checkpoint: {every_steps: 5, file: c.h5}";
  for (const std::string name : {"r.fields.h5", "c.fields.h5"}) {
    make_foreign(name);
    expect_in(refused(both), {name, "another kind of HDF5 file", "another name"});
    EXPECT_TRUE(Hdf5Reader(in(name)).has("/values"));
    std::filesystem::remove(in(name));
  }
  std::ofstream(in("r.xdmf")) << "my notes\n";
  expect_in(refused(fields), {"r.xdmf", "not an XDMF"});
  std::filesystem::remove(in("r.xdmf"));
  run(both);
  EXPECT_EQ(Hdf5Reader(in("r.fields.h5")).read_string("/", "format"), "cbr-fields");
  run(both);  // its own, again
  {
    Hdf5Writer other(in("r.fields.h5"));  // grids, but not of cbr, which writes a format
    other.write("/grids/0/points", Matrix(Matrix::Zero(1, 3)));
    other.commit();
  }
  expect_in(refused(both), {"r.fields.h5", "without a format", "another name"});
}

TEST_F(ProgramFiles, FieldsThatAreNotTheCheckpointsAreRefused) {
  const std::string both =
      ", fields: [displacement, velocity], checkpoint: {every_steps: 8, file: c.h5}";
  run(both);
  const auto whole = in("whole.h5");
  std::filesystem::copy_file(in("c.fields.h5"), whole);
  const std::size_t kept =
      static_cast<std::size_t>(Hdf5Reader(in("c.h5")).shape("/field_times")[0]);
  ASSERT_GT(kept, 3u);
  const auto damaged = [&](const std::function<void(Hdf5Writer&)>& change) {
    Hdf5Writer file(in("c.fields.h5"), whole);
    change(file);
    file.commit();
    return refused(both, "c.h5");
  };
  const auto replace = [](Hdf5Writer& file, const std::string& name, const Matrix& values) {
    EXPECT_TRUE(file.remove(name));
    file.write(name, values);
  };
  const Matrix u = Hdf5Reader(whole).read_matrix("/steps/1/0/displacement"),
               X = Hdf5Reader(whole).read_matrix("/grids/0/points");
  Matrix other = u;
  other(0, 0) = std::nan("");
  expect_in(damaged([&](Hdf5Writer& file) { replace(file, "/steps/1/0/displacement", other); }),
            {"c.fields.h5", "damaged"});
  other(0, 0) = std::nextafter(u(0, 0), 1);
  expect_in(damaged([&](Hdf5Writer& file) { replace(file, "/steps/1/0/displacement", other); }),
            {"c.fields.h5", "damaged"});
  expect_in(damaged([&](Hdf5Writer& file) { replace(file, "/grids/0/points", 2 * X); }),
            {"c.fields.h5", "damaged"});
  expect_in(damaged([&](Hdf5Writer& file) { file.remove("/steps/1/0/velocity"); }),
            {"c.fields.h5", "damaged", "--restart"});
  expect_in(damaged([&](Hdf5Writer& file) { file.remove("/steps/1"); }),
            {"c.fields.h5", "damaged"});
  expect_in(damaged([&](Hdf5Writer& file) { file.remove("/grids/0/node_ids"); }),
            {"c.fields.h5", "damaged"});
  std::filesystem::remove(in("c.fields.h5"));
  expect_in(refused(both, "c.h5"),
            {"c.fields.h5", "no such file", "output.fields", "without --restart"});
  // Steps that the checkpoint does not know are left out
  {
    Hdf5Writer file(in("c.fields.h5"), whole);
    file.link("/steps/0/0/displacement", "/steps/" + std::to_string(kept) + "/0/displacement");
    file.commit();
  }
  const Matrix last = Hdf5Reader(in("r.fields.h5")).read_matrix("/steps/10/0/velocity");
  run(both, "c.h5");
  const Hdf5Reader gone_on(in("r.fields.h5"));
  EXPECT_EQ(gone_on.read_matrix("/steps/10/0/velocity"), last);
  EXPECT_EQ(gone_on.compare_checksums("/").without, 0);
}

TEST_F(ProgramFiles, ADamagedCheckpointOfItsOwnNameIsCalledSo) {
  const std::string output = ", checkpoint: {every_steps: 8, file: c.h5}";
  run(output);
  std::filesystem::resize_file(in("c.h5"), 3000);
  const std::string said = refused(output, "c.h5");
  expect_in(said, {"c.h5", "damaged", "without --restart"});
  EXPECT_EQ(said.find("output.checkpoint.file"), std::string::npos) << said;
  // and anew: what is to be done with it
  expect_in(refused(output), {"c.h5", "is not a checkpoint", "remove it"});
}

}  // namespace
}  // namespace cbr::program_files_test
