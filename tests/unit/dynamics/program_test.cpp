// SPDX-License-Identifier: GPL-3.0-or-later
// Whole runs from a scene file: results, fields, refusals.
#include "dynamics/program.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <regex>
#include <thread>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "dynamics/output/results.hpp"
#include "dynamics/setup/build.hpp"
#include "reducer/modes/diagonal_form.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/dynamics/bricks.hpp"

namespace cbr::program_test {
namespace {

// A folder with a mesh, a scene of two blocks, and the block's superelement, made anew for each
// test.
class Program : public ::testing::Test {
 protected:
  Program() { write_mesh(test::brick({4, 2, 2}, Vector3(1, 0.5, 0.5)), folder_ / "block.msh"); }

  std::string scene(const std::string& kind, const std::string& contact = "",
                    const std::string& time = "", const std::string& more = "") {
    const std::filesystem::path file = folder_ / "scene.yaml";
    std::ofstream(file)
        << "materials:\n  soft: {youngs_modulus: 100, poissons_ratio: 0.25, density: 1}\n"
           "components:\n  block:\n    mesh: block.msh\n    material: soft\n    reduction: "
           "{interface: [x_max], modes: 12}\n"
           "instances:\n  left: {component: block, as: "
        << kind << ", velocity: [0.3, 0, 0]}\n  right: {component: block, as: " << kind
        << ", position: [2.01, 0, 0], mirror: x}\n"
        << "contact:\n  - {between: [left.x_max, right.x_max]" << contact << "}\n"
        << "time: {end: 0.6" << time << "}\n"
        << more
        << (more.find("output") == std::string::npos
                ? "output: {every: 0.05, history: [left.x_max, right.x_max]}\n"
                : "");
    return file.string();
  }

  void make_superelement(const std::string& scene_file, Index modes = 12) {
    const Scene scene = read_scene(scene_file);
    const Component& component = scene.components.at("block");
    const test::Lattice full = test::as_lattice(
        test::make_brick({4, 2, 2}, Vector3(1, 0.5, 0.5), scene.materials.at("soft")), {4, 2, 2});
    Superelement s = test::reduce(full, test::x_nodes(full, false, true), modes);
    s.content_hash = content_hash(scene, component);
    write_superelement(s, component.reduction->superelement);
  }

  void run(const std::string& scene_file) {
    Report report("test", Verbosity::quiet);
    run_scene(scene_file, folder_ / "results.h5", report);
  }

  void expect_refused(const std::string& scene_file, const std::vector<std::string>& parts) {
    const std::string message = test::refusal_of([&] { run(scene_file); });
    for (const auto& part : parts) EXPECT_SAYS(message, part);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "results.h5"));
  }

  test::TemporaryFolder folder_;
};

// A block is pressed on a rough floor and pushed along it; a shelf takes what presses it more.
TEST_F(Program, ResultsHoldWhatAPreloadHasComeTo) {
  const std::string file =
      scene("mesh",
            ", friction: 0.5}\n  - {between: [left.x_min, floor], friction: 0.5}\n"
            "  - {between: [left.x_max, shelf]",
            ", preload: 4",
            "walls:\n  floor: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}\n"
            "  shelf: {plane: {point: [0.999, 0, 0], normal: [1, 0, 0]}}\n"
            "loads:\n  - {instance: left, surface: x_max, force: [-0.0437, 0, 0]}\n"
            "  - {instance: left, surface: x_min, force: [0, 0.015, 0]}\n");
  const std::string what = test::refusal_of<RunError>([&] { run(file); });
  EXPECT_SAYS(what, "load step 4 of 4 before the time 0: instance 'left' is not held",
              "results.h5: holds load step 3 of 4 before the time 0 as the output of t");
  const Hdf5Reader results(folder_ / "results.h5");
  EXPECT_EQ(results.read_index("/", "partial"), 1);
  EXPECT_EQ(results.read_index("/", "preload_reached"), 3);
  EXPECT_EQ(results.read_vector("/time").size(), 1);
  EXPECT_NEAR(results.read_points("/contact/left.x_min - floor/force")(0, 1), -0.75 * 0.015, 1e-9);
}

TEST_F(Program, ResultsHoldWhatTheFormatSays) {
  for (const std::string kind : {"mesh", "superelement"}) {
    const std::string file = scene(kind);
    if (kind == "superelement") make_superelement(file);
    run(file);
    const Hdf5Reader results(folder_ / "results.h5");
    EXPECT_EQ(results.read_string("/", "format"), "cbr-results");
    EXPECT_EQ(results.read_string("/", "format_version"), "1.14");
    EXPECT_EQ(results.read_index("/", "partial"), 0);
    EXPECT_GT(results.read_index("/", "steps"), 0);
    EXPECT_EQ(results.read_index("/", "n_dofs"), kind == "mesh" ? 2 * 135 : 2 * (12 + 27));
    const Vector time = results.read_vector("/time");
    ASSERT_EQ(time.size(), 13);
    for (Index i = 0; i < 13; ++i) EXPECT_NEAR(time[i], 0.05 * double(i), 1e-15);
    const Points left = results.read_points("/surfaces/left.x_max/mean_position");
    EXPECT_NEAR(left(0, 0), 1, 1e-12);
    EXPECT_NEAR(results.read_points("/surfaces/right.x_max/mean_position")(0, 0), 1.01, 1e-12);
    const Points a = results.read_points("/surfaces/left.x_max/force"),
                 b = results.read_points("/surfaces/right.x_max/force");
    EXPECT_LT((a + b).norm(), 1e-12 * a.norm());
    EXPECT_LT(a.col(0).minCoeff(), 0);
    // The impulse of the contact force is the change of momentum.
    const Points p = results.read_points("/instances/left/momentum");
    EXPECT_NEAR(0.05 * a.col(0).sum(), p(12, 0) - p(0, 0), 1e-12 * p(0, 0));
    const Vector total = results.read_vector("/energy/total"),
                 work = results.read_vector("/energy/work_contact");
    EXPECT_LT(((total - work).array() - total[0]).abs().maxCoeff(), 1e-12 * total[0]);
    for (const char* name : {"/instances/left/center_of_mass", "/instances/right/angular_momentum",
                             "/instances/left/kinetic_energy", "/instances/left/strain_energy",
                             "/energy/work_external", "/energy/work_friction", "/contact/active"})
      EXPECT_EQ(results.shape(name)[0], 13) << name;
    EXPECT_EQ(results.compare_checksums("/").without, 0);
    EXPECT_GT(results.compare_checksums("/").datasets, 20);
    std::ostringstream text;
    write_scene(read_scene(file), text);
    EXPECT_EQ(results.read_string("/", "scene"), text.str());
    EXPECT_EQ(results.read_string("/", "run_hash").size(), 32u);
  }
}

// Longer than the 64 KB that an attribute of fixed length holds
TEST_F(Program, ResultsHoldALongScene) {
  std::string rows;
  for (int i = 0; i < 20000; ++i) rows += "  - {instance: left, nodes: x_min, fix: [y]}\n";
  const std::string file = scene("mesh", "", "", "boundary:\n" + rows);
  run(file);
  const Hdf5Reader results(folder_ / "results.h5");
  std::ostringstream text;
  write_scene(read_scene(file), text);
  EXPECT_GT(text.str().size(), 500000u);
  EXPECT_EQ(results.read_string("/", "scene"), text.str());
}

TEST_F(Program, SameInputSameDatasets) {
  const std::string file = scene("mesh");
  run(file);
  const Matrix first =
      Hdf5Reader(folder_ / "results.h5").read_matrix("/surfaces/right.x_max/mean_velocity");
  run(file);
  EXPECT_EQ(first,
            Hdf5Reader(folder_ / "results.h5").read_matrix("/surfaces/right.x_max/mean_velocity"));
}

TEST_F(Program, ASuperelementThatIsMissingOrStaleNamesTheCure) {
  const std::string file = scene("superelement");
  expect_refused(file, {"does not exist", "cbr-reduce", "scene.yaml"});
  make_superelement(file);
  write_mesh(test::brick({4, 2, 3}, Vector3(1, 0.5, 0.5)), folder_ / "block.msh");
  expect_refused(file, {"not made from", "cbr-reduce"});
}

TEST_F(Program, AMeshThatIsNoGoodNamesItsLineAndComponent) {
  const std::string file = scene("mesh");
  Mesh mesh = test::brick({4, 2, 2}, Vector3(1, 0.5, 0.5));
  mesh.blocks[0].connectivity.row(3).head(4).swap(mesh.blocks[0].connectivity.row(3).tail(4));
  write_mesh(mesh, folder_ / "block.msh");
  expect_refused(file, {"scene.yaml:4: component 'block': ", "block.msh: ", "is inverted"});
  std::filesystem::remove(folder_ / "block.msh");
  expect_refused(file, {"scene.yaml:4: component 'block': ", "block.msh: no such file"});
  std::filesystem::create_symlink("/dev/zero", folder_ / "block.msh");
  expect_refused(file, {"scene.yaml:4: component 'block': ", "block.msh: is not a regular file"});
}

TEST_F(Program, ASuperelementAtOddsWithItselfNamesItsFile) {
  const std::string file = scene("superelement", "", ", integrator: exact");
  make_superelement(file);
  Superelement s = read_superelement(folder_ / "block.cbr.h5");
  add_diagonal_form(s, std::vector<Index>(s.node_ids.size(), 0));
  s.rigid_body.mass *= 2;
  write_superelement(s, folder_ / "block.cbr.h5");
  expect_refused(file, {"scene.yaml:4: component 'block': ", "block.cbr.h5: ", "/rigid_body",
                        "cbr-reduce --force"});
}

TEST_F(Program, TellsTheConditioningThatTheReductionKnew) {
  const std::string file = scene("superelement", "", ", integrator: exact");
  make_superelement(file);
  // Its impact loses much energy, which is a warning of its own
  const auto told = [&](const std::optional<Conditioning>& conditioning, Verbosity verbosity,
                        int warnings) {
    Superelement s = read_superelement(folder_ / "block.cbr.h5");
    s.conditioning = conditioning;
    write_superelement(s, folder_ / "block.cbr.h5");
    testing::internal::CaptureStderr();
    Report report("test", verbosity);
    run_scene(file, folder_ / "results.h5", report);
    EXPECT_EQ(report.n_warnings(), warnings);
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(told({}, Verbosity::verbose, 1).find("condition"), std::string::npos);
  Conditioning c;
  c.mass = {1e5, 200};
  EXPECT_SAYS(told(c, Verbosity::verbose, 1),
              "component 'block': condition of the reduced mass: 1.0e+05, scaled by its "
              "diagonal 2.0e+02",
              "component 'block': condition of K_II: not computed");
  EXPECT_EQ(told(c, Verbosity::normal, 1).find("condition of"), std::string::npos);
  c.mass.scaled = 1e13;  // once, though two instances stand on it
  EXPECT_SAYS(told(c, Verbosity::quiet, 2),
              "component 'block': the reduced mass is ill-conditioned (1e+13)");
}

TEST_F(Program, OutputsThatMemoryCannotHoldAreRefusedBeforeTheRun) {
  const Scene read = read_scene(scene("mesh"));
  Report report("test", Verbosity::quiet);
  const BuiltScene built = build(read, report);
  // 13 outputs of time, energies, two bodies, two surfaces and a pair
  constexpr double bytes = 8 * 13 * (8 + 2 * 11 + 2 * 12 + 13);
  EXPECT_NO_THROW(require_memory_for_outputs(read, built.simulation, bytes));
  const std::string message =
      test::refusal_of([&] { require_memory_for_outputs(read, built.simulation, bytes / 10); });
  for (const char* part : {"scene.yaml:", "output.every: 13 outputs of 67 numbers", "7.0 kB",
                           "697 B", "give output.every"})
    EXPECT_SAYS(message, part);
}

TEST_F(Program, RefusesWhatCannotBe) {
  expect_refused(scene("mesh", "", ", step: 1.0"), {"critical step", "force"});
}

TEST_F(Program, ASurfaceThatWasNotKeptNamesTheCure) {
  const std::string file = scene(
      "superelement", "", "", "loads:\n  - {instance: left, surface: x_min, force: [1, 0, 0]}\n");
  make_superelement(file);
  expect_refused(file, {"x_min", "x_max", "reduction.interface", "cbr-reduce", "scene.yaml:"});
}

TEST_F(Program, APulseThatStepsMayMissIsWarnedOf) {
  // Steps of 0.05 miss it, but for a body that moves exactly; a load that is switched on is no
  // pulse.
  std::string load =
      "loads:\n"
      "  - {instance: right, surface: x_max, force: [0, 1, 0], history: {time: [0.011, 0.012, "
      "0.014, 0.015], value: [0, 1, 1, "
      "0]}}\n";
  const auto warned = [&](const std::string& kind, const std::string& time) {
    const std::string file = scene(kind, "", time, load);
    if (kind == "superelement") make_superelement(file);
    testing::internal::CaptureStderr();
    run(file);
    return testing::internal::GetCapturedStderr().find(
               "loads[0].history rises and falls within 0.004 s") != std::string::npos;
  };
  EXPECT_TRUE(warned("mesh", ", integrator: newmark"));
  EXPECT_FALSE(warned("mesh", ", integrator: newmark, step: 0.001"));
  EXPECT_TRUE(warned("superelement", ", integrator: newmark"));
  EXPECT_FALSE(warned("superelement", ", integrator: exact"));
  load =
      "loads:\n  - {instance: right, surface: x_max, force: [0, 1, 0], history: {time: [0.011, "
      "0.012, 0.014], value: [0, 1, 1]}}\n";
  EXPECT_FALSE(warned("mesh", ", integrator: newmark"));
}

TEST_F(Program, LoadsBoundariesAndGravity) {
  const std::string file = scene("mesh", "", "",
                                 "loads:\n  - {instance: right, surface: x_max, force: [0, 0.005, "
                                 "0]}\n  - {gravity: [0, 0, -0.02]}\n"
                                 "boundary:\n  - {instance: left, nodes: x_min, fix: [x, y, z]}\n");
  run(file);
  const Hdf5Reader results(folder_ / "results.h5");
  const Points p = results.read_points("/instances/right/momentum");
  const Index last = p.rows() - 1;
  // The blocks meet, and their faces tilt a little: 0.2 %
  EXPECT_NEAR(p(last, 1), 0.005 * 0.6, 0.005 * 0.003);
  EXPECT_NEAR(p(last, 2), -0.25 * 0.02 * 0.6, 0.005 * 0.003);
  const Vector total = results.read_vector("/energy/total"),
               work = results.read_vector("/energy/work_contact") +
                      results.read_vector("/energy/work_external");
  EXPECT_LT(((total - work).array() - total[0]).abs().maxCoeff(), 1e-11 * total.maxCoeff());
}

// A file that cannot be read is not called stale, and no input is written over.
TEST_F(Program, ADamagedSuperelementIsCalledSo) {
  const std::string file = scene("superelement");
  make_superelement(file);
  const auto superelement = folder_ / "block.cbr.h5";
  std::filesystem::resize_file(superelement, std::filesystem::file_size(superelement) / 2);
  const std::string message = test::refusal_of([&] { run(file); });
  EXPECT_SAYS(message, "block.cbr.h5", "damaged");
  EXPECT_EQ(message.find("was not made from"), std::string::npos) << message;
}

TEST_F(Program, ResultsDoNotReplaceAnInput) {
  const std::string file = scene("mesh");
  Report report("test", Verbosity::quiet);
  for (const char* input : {"scene.yaml", "block.msh"}) {
    const auto size = std::filesystem::file_size(folder_ / input);
    EXPECT_THROW(run_scene(file, folder_ / input, report), InputError) << input;
    EXPECT_EQ(std::filesystem::file_size(folder_ / input), size);
  }
  EXPECT_THROW(run_scene(file, folder_ / "nowhere" / "results.h5", report), InputError);
  EXPECT_EQ(report.seconds("steps"), 0);  // found before the run
}

TEST_F(Program, ResultsReplaceResultsAlone) {
  const std::string file = scene("mesh");
  run(file);
  run(file);
  for (const std::string format : {"cbr-checkpoint", "cbr-superelement", ""}) {
    const auto other = folder_ / "other.h5";
    {
      Hdf5Writer writer(other);
      writer.write("/values", 1.0);
      if (!format.empty()) writer.attribute("/", "format", format);
      writer.commit();
    }
    Report report("test", Verbosity::quiet);
    EXPECT_THROW(run_scene(file, other, report), InputError) << format;
    EXPECT_TRUE(Hdf5Reader(other).has("/values"));
  }
}

// Not the user's mistake: exit code 1.
TEST_F(Program, AFolderThatGoesAwayDuringTheRunIsNoInputError) {
  const std::string file =
      scene("mesh", "", ", step: 3.0e-5",
            "output: {every: 0.05, checkpoint: {every_steps: 50, file: results/c.h5}}\n");
  const auto folder = folder_ / "results";
  std::filesystem::create_directory(folder);
  std::thread other([&] {
    std::error_code busy;
    while (!std::filesystem::exists(folder / "c.h5"))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    // a checkpoint may come in between
    while (std::filesystem::exists(folder)) std::filesystem::remove_all(folder, busy);
  });
  Report report("test", Verbosity::quiet);
  EXPECT_THROW(run_scene(file, folder / "results.h5", report), RunError);
  other.join();
}

TEST_F(Program, EveryDofHeld) {
  const std::string file =
      scene("mesh", "", "", "boundary:\n  - {instance: right, nodes: x_max, fix: [x, y, z]}\n");
  std::ifstream in(file);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  in.close();
  text.replace(text.find("modes: 12"), 9, "modes: 0");
  const std::string right = "right: {component: block, as: mesh";
  text.replace(text.find(right), right.size(), "right: {component: block, as: superelement");
  std::ofstream(file) << text;
  const Scene read = read_scene(file);
  const test::Lattice full = test::as_lattice(
      test::make_brick({4, 2, 2}, Vector3(1, 0.5, 0.5), read.materials.at("soft")), {4, 2, 2});
  Superelement s = test::reduce(full, test::x_nodes(full, false, true), 0);
  s.content_hash = content_hash(read, read.components.at("block"));
  write_superelement(s, folder_ / "block.cbr.h5");
  run(file);
  const Points p = Hdf5Reader(folder_ / "results.h5").read_points("/instances/left/momentum");
  EXPECT_LT(p(p.rows() - 1, 0), -0.5 * p(0, 0));  // thrown back by a wall
}

TEST_F(Program, FieldsReferToDatasetsThatAreThere) {
  const std::string file =
      scene("mesh", "", "", "output: {every: 0.2, fields: [displacement, velocity, stress]}\n");
  run(file);
  std::ifstream in(folder_ / "results.xdmf");
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const Hdf5Reader heavy(folder_ / "results.fields.h5");
  const std::regex item("Dimensions=\"(\\d+) (\\d+)\">results\\.fields\\.h5:([^<]+)<");
  int found = 0;
  for (std::sregex_iterator it(text.begin(), text.end(), item), end; it != end; ++it, ++found) {
    const auto shape = heavy.shape((*it)[3]);
    ASSERT_EQ(shape.size(), 2u);
    EXPECT_EQ(shape[0], std::stol((*it)[1]));
    EXPECT_EQ(shape[1], std::stol((*it)[2]));
  }
  // 4 times, 2 instances: cells, points, two fields, stress under ten names
  EXPECT_EQ(found, 4 * 2 * 14);
  // Before they meet, the left block moves as a whole and has no stress.
  EXPECT_LT(heavy.read_matrix("/steps/0/0/stress_xx").norm(), 1e-12);
  EXPECT_NEAR(heavy.read_points("/steps/0/0/velocity")(7, 0), 0.3, 1e-12);
  EXPECT_GT(heavy.read_matrix("/steps/1/0/stress_xx").norm(), 1e-3);
}

}  // namespace
}  // namespace cbr::program_test
