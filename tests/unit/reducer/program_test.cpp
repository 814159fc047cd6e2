// SPDX-License-Identifier: GPL-3.0-or-later
// What cbr-reduce takes, makes, tells and refuses. Its files: program_files_test.cpp.
#include <filesystem>
#include <fstream>
#include <sstream>

#include "common/superelement/superelement_group.hpp"
#include "reducer/condensation/condensation.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/reducer/reduce_program.hpp"

namespace cbr::test::program_test {
namespace {

namespace fs = std::filesystem;

class Program : public ReduceProgram {};

TEST_F(Program, AToleranceIsReducedOnce) {
  const std::string file = scene("{interface: [x_max], tolerance: 0.02}");
  const std::string handed_on = run({file});
  EXPECT_SAYS(handed_on, "tolerance: 0.02");
  EXPECT_EQ(handed_on.find("pick:"), std::string::npos) << handed_on;
  const Superelement s = read_superelement(path("box.cbr.h5"));
  EXPECT_EQ(s.provenance.at("tolerance"), "0.02");
  ASSERT_TRUE(s.accuracy);
  EXPECT_LE(s.accuracy->largest_left_out, 0.02);
  const auto written = fs::last_write_time(path("box.cbr.h5"));
  run({file});
  EXPECT_EQ(fs::last_write_time(path("box.cbr.h5")), written);
  run({scene("{interface: [x_max], tolerance: 0.3}")});
  EXPECT_LT(read_superelement(path("box.cbr.h5")).k(), s.k());
  EXPECT_SAYS(message_of({scene("{interface: [x_max], tolerance: 0.3, pick: participation}")}),
              "requires modes");
  EXPECT_SAYS(message_of({scene("{interface: [x_max], tolerance: 0.3, basis: massless}")}),
              "is not available with basis: massless");
  EXPECT_SAYS(message_of({scene("{interface: [x_max], tolerance: 0.3, basis: characteristic, "
                                "characteristic: {modes: 4}}")}),
              "is not available with basis: characteristic: take modes or cutoff_hz");
  EXPECT_SAYS(
      message_of(mesh_arguments({"--basis", "characteristic", "--characteristic-modes", "4"},
                                {"--tolerance", "0.3"})),
      "is not available with basis: characteristic");
}

TEST_F(Program, LoadsInsideAreTakenInByThemselves) {
  const auto load = [](const std::string& set) {
    return "loads: [{instance: a, surface: " + set + ", force: [1, 0, 0]}]\n";
  };
  const auto written = [&] { return fs::last_write_time(path("box.cbr.h5")); };
  const std::string reduction = "{interface: [x_max], modes: 4}";
  run({scene(reduction, load("x_min"))});
  const Superelement s = read_superelement(path("box.cbr.h5"));
  EXPECT_EQ(s.k(), 7);
  EXPECT_EQ(s.n_residual, 3);
  ASSERT_EQ(s.loads.count("x_min"), 1U);
  EXPECT_EQ(read_superelement(path("twin.cbr.h5")).k(), 4);  // no load on an instance of it
  auto before = written();
  run({scene(reduction, load("x_min"))});
  EXPECT_EQ(written(), before);
  // Other loads: made anew; one on the interface needs nothing
  run({scene(reduction, load("y_min"))});
  EXPECT_EQ(read_superelement(path("box.cbr.h5")).loads.count("x_min"), 0U);
  run({scene(reduction, load("x_max"))});
  EXPECT_TRUE(read_superelement(path("box.cbr.h5")).loads.empty());
  before = written();
  run({scene(reduction)});
  EXPECT_EQ(written(), before);
  run({scene("{interface: [x_max], modes: 4, loads: [z_min]}")});
  EXPECT_EQ(read_superelement(path("twin.cbr.h5")).loads.count("z_min"), 1U);
  EXPECT_SAYS(message_of({scene(reduction, load("x_mni"))}), "no sideset 'x_mni'");
}

TEST_F(Program, LoadsInsideAreRefusedByWhatKnowsThoseOnTheInterfaceOnly) {
  const auto load = [](const std::string& set) {
    return "loads: [{instance: a, surface: " + set + ", force: [1, 0, 0]}]\n";
  };
  const auto find = [&](const std::string& reduction, const std::string& set, const char* words) {
    return message_of({scene(reduction, load(set))}).find(words) != std::string::npos;
  };
  const std::string massless = "{interface: [x_max], modes: 8, basis: massless}",
                    domains = "{interface: [x_max], modes: 4, domains: 2}";
  EXPECT_TRUE(find(massless, "x_min",
                   "'x_min' lies inside the part, and basis: massless knows loads on the interface "
                   "only: add it to "));
  EXPECT_TRUE(
      find("{interface: [x_max], modes: 4, basis: characteristic, characteristic: {modes: 4}}",
           "x_min", "lies inside"));
  EXPECT_TRUE(find(domains, "x_min",
                   "domains above 1 know loads on the interface only: add it to "
                   "reduction.interface, or use basis: "));
  EXPECT_TRUE(find(massless, "x_mni", "no sideset 'x_mni'"));
  for (const std::string& reduction : {massless, domains}) {
    run({scene(reduction, load("x_max"))});
    const auto written = fs::last_write_time(path("box.cbr.h5"));
    run({scene(reduction, load("x_max"))});
    EXPECT_EQ(fs::last_write_time(path("box.cbr.h5")), written);
    EXPECT_TRUE(find(reduction, "y_min", "lies inside")) << "though the file is up to date";
  }
}

TEST_F(Program, TheMemoryOptionChangesTheWayAndNotTheResult) {
  run(mesh_arguments({"--recovery"}));
  const Superelement a = read_superelement(path("box.cbr.h5"));
  run(mesh_arguments({"--recovery", "--memory", "1kB", "--force"}));
  const Superelement b = read_superelement(path("box.cbr.h5"));
  EXPECT_LT((a.M_cc - b.M_cc).norm(), 1e-13 * a.M_cc.norm());
  ASSERT_EQ(b.recovery.size(), 1u);
  EXPECT_LT((a.recovery[0].Psi - b.recovery[0].Psi).norm(), 1e-13 * a.recovery[0].Psi.norm());
}

TEST(PanelMemory, AnInterfaceThatMemoryCannotHoldIsRefused) {
  EXPECT_NO_THROW(require_memory_for_interface(1000, 16e6));
  EXPECT_SAYS(test::refusal_of([&] { require_memory_for_interface(1000, 15e6); }),
              "1000 dofs, whose dense mass and stiffness take 16.0 MB, the machine has 15.0 MB");
}

// In a pipeline stdout is the scene: OpenBLAS writes its complaints there.
TEST_F(Program, NothingButTheSceneOnStdoutWithoutModes) {
  testing::internal::CaptureStdout();
  run({scene("{interface: [x_max], modes: 0}")});
  const Superelement s = read_superelement(path("box.cbr.h5"));
  residual_mass_share(s);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(s.k(), 0);
}

// All 54 modes leave the mass of the interface's own nodes: more of them are no cure.
TEST_F(Program, MoreModesAreAdvisedWhereTheyHelp) {
  write_mesh(box_mesh({{2, 2, 2}, {2, 2, 2}, {0, 0, 0}, 0}), folder_ / "box.msh");
  const auto warnings = [&](const std::string& modes) {
    testing::internal::CaptureStderr();
    run(mesh_arguments({}, {"--modes", modes}));
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_SAYS(warnings("4"), "keep more modes");
  const std::string all = warnings("54");
  EXPECT_SAYS(all, "refine the mesh at the interface");
  EXPECT_EQ(all.find("keep more modes"), std::string::npos) << all;
}

TEST_F(Program, EstimateReducesNothing) {
  const auto table_of = [&](ReduceCommand command) {
    command.estimate = true;
    Report report("cbr-reduce", Verbosity::quiet);
    std::ostringstream out;
    run_estimate(command, out, report);
    return out.str();
  };
  ReduceCommand mesh;
  mesh.input = path("box.msh");
  mesh.reduction = {{"interface", {"x_max"}}, {"modes", {"4"}}};
  EXPECT_SAYS(table_of(mesh), "| 17 ");  // without a material
  ReduceCommand in_scene;
  in_scene.input = scene("{interface: [x_max], modes: 4}");
  EXPECT_SAYS(table_of(in_scene), "| 17 ");
  EXPECT_FALSE(fs::exists(path("box.cbr.h5")));
  mesh.reduction["interface"] = {"x_mx"};
  EXPECT_THROW(table_of(mesh), InputError);
  mesh.reduction["interface"] = {"x_max"};
  mesh.reduction.erase("modes");
  EXPECT_THROW(table_of(mesh), InputError);
  mesh.reduction["cutoff_hz"] = {"10"};
  EXPECT_THROW(table_of(mesh), InputError);  // Weyl's law needs a material
}

TEST_F(Program, DomainsMakeAGroup) {
  const auto file = path("box.cbr.h5");
  run(mesh_arguments({"--domains", "3", "--recovery"}));
  ASSERT_TRUE(is_superelement_group(file));
  const SuperelementGroup group = read_superelement_group(file);
  EXPECT_EQ(group.domains.size(), 3u);
  EXPECT_TRUE(group.has_diagonal_form());
  ASSERT_TRUE(group.conditioning && group.conditioning->rho_res);
  EXPECT_GT(group.conditioning->rho_res->minCoeff(), 0);
  EXPECT_EQ(group.provenance.at("domains"), "3");
  EXPECT_FALSE(group.content_hash.empty());
  EXPECT_EQ(read_content_hash(file), group.content_hash);
  for (const auto& domain : group.domains) EXPECT_EQ(domain.recovery.size(), 1u);
  // Nothing to do a second time; again with another limit of the diagonal form.
  const auto written = fs::last_write_time(file);
  run(mesh_arguments({"--domains", "3", "--recovery"}));
  EXPECT_EQ(fs::last_write_time(file), written);
  run(mesh_arguments({"--domains", "3", "--recovery", "--diagonal-limit", "10"}));
  EXPECT_FALSE(read_superelement_group(file).has_diagonal_form());
}

TEST_F(Program, ASecondReductionMakesOneSuperelement) {
  const std::string file =
      scene("{interface: [x_max], modes: 6, domains: 3, second_reduction: {modes: 8}}");
  run({file});
  const Superelement s = read_superelement(path("box.cbr.h5"));
  EXPECT_EQ(s.k(), 8);
  EXPECT_TRUE(s.has_diagonal_form());
  EXPECT_EQ(s.provenance.at("second_modes"), "8");
  ASSERT_TRUE(s.conditioning && s.conditioning->rho_res);
  EXPECT_EQ(*s.conditioning->rho_res, residual_mass_share(s));
  const auto written = fs::last_write_time(path("box.cbr.h5"));
  run({file});
  EXPECT_EQ(fs::last_write_time(path("box.cbr.h5")), written);
}

TEST_F(Program, RefusesWithTheCure) {
  EXPECT_SAYS(message_of({path("box.msh")}), "--youngs-modulus is missing");
  EXPECT_SAYS(message_of(mesh_arguments({"--basis", "massles"})), "massless");
  EXPECT_SAYS(message_of(mesh_arguments({"--basis", "characteristic", "--statics", "x_mx"})),
              "did you mean 'x_max'");
  EXPECT_SAYS(message_of(mesh_arguments({"--keep", "x_max"})),
              "--keep requires --basis characteristic");
  EXPECT_SAYS(message_of(mesh_arguments({"--domains", "0"})), "1 or more");
  EXPECT_SAYS(message_of(mesh_arguments({"--domains", "1000"})), "at most that many");
  EXPECT_SAYS(message_of(mesh_arguments({"--interface", "x_mx"})), "x_max");
  const std::string file = scene("{interface: [x_max], modes: 400}");
  EXPECT_SAYS(message_of({file, "--modes", "3"}), "requires a mesh");
  EXPECT_SAYS(message_of({file}), "scene.yaml:3: component 'box'");
  EXPECT_SAYS(message_of({scene(
                  "{interface: [x_max], modes: 6, domains: 3, second_reduction: {modes: 400}}")}),
              "scene.yaml:3: component 'box': second_reduction.modes: 400");
  // What cannot run is not reduced.
  const std::string cannot =
      scene("{interface: [x_max], modes: 4}",
            "contact: [{between: [a.x_max, b.x_max], enforcement: nodal}]\n");
  const std::string text = bytes_of(cannot);
  std::ofstream(cannot) << text.substr(0, text.find("{end: 1.0}"))
                        << "{end: 1.0, integrator: newmark}\n";
  EXPECT_SAYS(message_of({cannot}), "take enforcement: impulse");
  EXPECT_FALSE(fs::exists(path("box.cbr.h5")));
  EXPECT_THROW(run(mesh_arguments({"--cutoff-hz", "3"})), CLI::Error);
  EXPECT_THROW(run(mesh_arguments({"--memory", "much"})), CLI::Error);
  EXPECT_THROW(run(mesh_arguments({"--diagonal-limit", "-1"})), CLI::Error);
  EXPECT_THROW(run(mesh_arguments({"--diagonal-limit", "few"})), CLI::Error);
}

}  // namespace
}  // namespace cbr::test::program_test
