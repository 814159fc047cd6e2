// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/superelement/superelement_group.hpp"
#include "reducer/command.hpp"
#include "reducer/condensation/panel_memory.hpp"
#include "tests/unit/reducer/box_mesh.hpp"

namespace cbr::test::program_test {
namespace {

namespace fs = std::filesystem;

class Program : public testing::Test {
 protected:
  Program()
      : folder_(fs::temp_directory_path() / ("cbr-reduce-test-" + std::to_string(::getpid()))) {
    fs::create_directories(folder_);
    write_mesh(box_mesh({{3, 2, 2}, {3, 2, 2}, {0, 0, 0}, 0}), folder_ / "box.msh");
  }
  ~Program() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  // Runs as the program does, and returns the scene handed on.
  std::string run(std::vector<std::string> arguments, const std::string& timings = "") const {
    CLI::App app("test", "cbr-reduce");
    ReduceCommand command;
    add_reduce_options(app, command);
    std::reverse(arguments.begin(), arguments.end());
    app.parse(arguments);
    Report report("cbr-reduce", Verbosity::quiet, timings);
    std::ostringstream scene;
    run_reduce(command, &scene, report);
    return scene.str();
  }

  std::string message_of(const std::vector<std::string>& arguments,
                         const std::string& timings = "") const {
    try {
      run(arguments, timings);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no InputError";
  }

  std::vector<std::string> mesh_arguments(const std::vector<std::string>& more = {},
                                          const std::vector<std::string>& modes = {"--modes",
                                                                                   "4"}) const {
    std::vector<std::string> all = {path("box.msh"), "--interface", "x_max"};
    all.insert(all.end(), modes.begin(), modes.end());
    const std::vector<std::string> rest = {
        "--youngs-modulus", "1000", "--poissons-ratio", "0.3", "--density", "2", "-o",
        path("box.cbr.h5")};
    all.insert(all.end(), rest.begin(), rest.end());
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  std::string scene(const std::string& reduction, const std::string& more = "") const {
    const std::string file = path("scene.yaml");
    std::ofstream(file)
        << "materials: {soft: {youngs_modulus: 1000, poissons_ratio: 0.3, density: 2}}\n"
           "components:\n"
           "  box: {mesh: box.msh, material: soft, reduction: "
        << reduction << "}\n"
        << "  twin: {mesh: box.msh, material: soft, reduction: " << reduction << "}\n"
        << "instances:\n  a: {component: box, as: superelement}\n  b: {component: box, as: "
           "superelement, position: [9, 0, 0]}\n"
           "  c: {component: twin, as: superelement, position: [19, 0, 0]}\n"
        << more << "time: {end: 1.0}\n";
    return file;
  }

  static std::string bytes(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  fs::path folder_;
};

TEST_F(Program, AMeshGivesTheSameFileAsAScene) {
  EXPECT_EQ(run(mesh_arguments()), "");
  const Superelement s = read_superelement(path("box.cbr.h5"));
  EXPECT_EQ(s.k(), 4);
  EXPECT_EQ(s.c(), 27);
  EXPECT_EQ(s.provenance.at("mesh"), "box.msh");
  EXPECT_EQ(s.provenance.at("block solid: youngs_modulus"), "1000");
  EXPECT_FALSE(s.content_hash.empty());
  const std::string by_mesh = bytes(path("box.cbr.h5"));
  fs::remove(path("box.cbr.h5"));
  const std::string handed_on = run({scene("{interface: [x_max], modes: 4}")});
  EXPECT_EQ(bytes(path("box.cbr.h5")), by_mesh);
  EXPECT_EQ(bytes(path("twin.cbr.h5")), by_mesh);
  EXPECT_NE(handed_on.find(path("box.cbr.h5")), std::string::npos) << handed_on;
}

TEST_F(Program, ReducesOnlyWhatHasChanged) {
  run(mesh_arguments());
  const auto old = fs::file_time_type::clock::now() - std::chrono::hours(1);
  const auto is_made_anew = [&](const std::vector<std::string>& more) {
    fs::last_write_time(path("box.cbr.h5"), old);
    run(mesh_arguments(more));
    return fs::last_write_time(path("box.cbr.h5")) > old + std::chrono::minutes(1);
  };
  EXPECT_FALSE(is_made_anew({}));
  EXPECT_TRUE(is_made_anew({"--force"}));
  EXPECT_TRUE(is_made_anew({"--mass", "consistent"}));
  EXPECT_TRUE(is_made_anew({"--element", "hex8"}));
  EXPECT_TRUE(is_made_anew({"--element", "hex8", "--diagonal-limit", "3"}));
  EXPECT_FALSE(read_superelement(path("box.cbr.h5")).has_diagonal_form());
  EXPECT_FALSE(is_made_anew({"--element", "hex8", "--diagonal-limit", "3"}));
  std::ofstream(path("box.cbr.h5"), std::ios::app | std::ios::binary).close();
  fs::resize_file(path("box.cbr.h5"), 1000);
  EXPECT_TRUE(is_made_anew({}));
}

TEST_F(Program, AToleranceIsReducedOnce) {
  const std::string file = scene("{interface: [x_max], tolerance: 0.02}");
  const std::string handed_on = run({file});
  EXPECT_NE(handed_on.find("tolerance: 0.02"), std::string::npos) << handed_on;
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
  EXPECT_NE(message_of({scene("{interface: [x_max], tolerance: 0.3, pick: participation}")})
                .find("requires modes"),
            std::string::npos);
  EXPECT_NE(message_of({scene("{interface: [x_max], tolerance: 0.3, basis: massless}")})
                .find("is not available with basis: massless"),
            std::string::npos);
  EXPECT_NE(message_of({scene("{interface: [x_max], tolerance: 0.3, basis: characteristic, "
                              "characteristic: {modes: 4}}")})
                .find("is not available with basis: characteristic: take modes or cutoff_hz"),
            std::string::npos);
  EXPECT_NE(message_of(mesh_arguments({"--basis", "characteristic", "--characteristic-modes", "4"},
                                      {"--tolerance", "0.3"}))
                .find("is not available with basis: characteristic"),
            std::string::npos);
}

TEST_F(Program, TheDiagonalFormIsMadeWhereARunMayReadIt) {
  const std::string reduction = "{interface: [x_max], modes: 4}";
  const std::string held =
      "boundary:\n  - {instance: a, nodes: x_max, fix: [x]}\n  - {instance: b, nodes: x_max, fix: "
      "[x]}\n";
  const auto form = [&](const char* file) {
    return read_superelement(path(file)).has_diagonal_form();
  };
  run({scene(reduction, held)});
  EXPECT_FALSE(form("box.cbr.h5"));
  EXPECT_TRUE(form("twin.cbr.h5"));
  const Superelement without = read_superelement(path("box.cbr.h5"));
  // Another scene reads it: it is added, and all else stays
  run({scene(reduction)});
  EXPECT_TRUE(form("box.cbr.h5"));
  const Superelement with = read_superelement(path("box.cbr.h5")),
                     twin = read_superelement(path("twin.cbr.h5"));
  EXPECT_EQ(with.V, twin.V);
  EXPECT_EQ(with.omega, twin.omega);
  EXPECT_EQ(with.M_cc, without.M_cc);
  EXPECT_EQ(with.content_hash, without.content_hash);
  // It does no harm where nothing reads it
  const auto before = fs::last_write_time(path("box.cbr.h5"));
  run({scene(reduction, held)});
  EXPECT_EQ(fs::last_write_time(path("box.cbr.h5")), before);
  run({scene(reduction, held), "--diagonal-limit", "1000", "--force"});
  EXPECT_TRUE(form("box.cbr.h5"));
}

TEST_F(Program, SetsThatAreNotKeptAreRefusedThoughTheFileIsUpToDate) {
  const std::string reduction = "{interface: [x_max], modes: 4}";
  run({scene(reduction)});
  const std::string history = "output: {history: [a.x_min]}\n";
  EXPECT_NE(message_of({scene(reduction, history)}).find("keeps 0 of its"), std::string::npos);
  EXPECT_NE(message_of({scene(reduction, "output: {history: [a.x_mni]}\n")}).find("x_mni"),
            std::string::npos);
  EXPECT_EQ(message_of({scene(reduction, "output: {history: [a.x_max]}\n")}), "no InputError");
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
  EXPECT_NE(message_of({scene(reduction, load("x_mni"))}).find("no sideset 'x_mni'"),
            std::string::npos);
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

TEST_F(Program, OverwritesNoMeshAndNoScene) {
  const std::string mesh = bytes(path("box.msh"));
  std::vector<std::string> arguments = mesh_arguments();
  arguments.back() = path("box.msh");
  EXPECT_NE(message_of(arguments).find("another name"), std::string::npos);
  fs::create_symlink(path("box.msh"), path("link.h5"));
  const std::string file = scene("{interface: [x_max], modes: 4}");
  const auto with_superelement = [&](const std::string& name) {
    const std::string text = bytes(file);
    const std::string key = "modes: 4";
    std::string changed = text;
    changed.replace(text.find(key), key.size(), key + ", superelement: " + name);
    std::ofstream(file) << changed;
    const std::string message = message_of({file});
    EXPECT_EQ(bytes(file), changed);
    std::ofstream(file) << text;
    return message;
  };
  EXPECT_NE(with_superelement("link.h5").find("the mesh of component 'box'"), std::string::npos);
  EXPECT_NE(with_superelement("scene.yaml").find("the scene itself"), std::string::npos);
  EXPECT_EQ(bytes(path("box.msh")), mesh);
}

TEST_F(Program, TimingsInThePlaceOfASuperelementAreRefusedBeforeTheWork) {
  EXPECT_NE(message_of({scene("{interface: [x_max], modes: 4}")}, path("twin.cbr.h5"))
                .find("twin.cbr.h5: is the file of both the superelement of component 'twin' and "
                      "the timings"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(path("box.cbr.h5")));
  EXPECT_FALSE(fs::exists(path("twin.cbr.h5")));
}

TEST_F(Program, OverwritesNoHdf5FileOfAnotherKind) {
  {
    Hdf5Writer results(path("box.cbr.h5"));
    results.attribute("/", "format", std::string("cbr-results"));
    results.commit();
  }
  const std::string before = bytes(path("box.cbr.h5"));
  EXPECT_NE(message_of(mesh_arguments()).find("cbr-results"), std::string::npos)
      << message_of(mesh_arguments());
  EXPECT_EQ(bytes(path("box.cbr.h5")), before);
  std::ofstream(path("box.cbr.h5")) << "my notes\n";
  EXPECT_NE(message_of(mesh_arguments()).find("box.cbr.h5: exists and is not an HDF5 file"),
            std::string::npos);
  EXPECT_EQ(bytes(path("box.cbr.h5")), "my notes\n");
  std::ofstream(path("box.cbr.h5"), std::ios::trunc).flush();
  EXPECT_EQ(run(mesh_arguments()), "");  // over an empty one, as mktemp makes it
}

TEST(PanelMemory, AnInterfaceThatMemoryCannotHoldIsRefused) {
  EXPECT_NO_THROW(require_memory_for_interface(1000, 16e6));
  try {
    require_memory_for_interface(1000, 15e6);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(
        std::string(error.what())
            .find(
                "1000 dofs, whose dense mass and stiffness take 16.0 MB, the machine has 15.0 MB"),
        std::string::npos)
        << error.what();
  }
}

TEST_F(Program, AMeshWithoutEndIsRefused) {
  fs::remove(path("box.msh"));
  fs::create_symlink("/dev/zero", path("box.msh"));
  const std::string from_mesh = message_of(mesh_arguments()),
                    path_twice = "box.msh: " + path("box.msh");
  EXPECT_NE(from_mesh.find("box.msh: is not a regular file"), std::string::npos) << from_mesh;
  EXPECT_EQ(from_mesh.find(path_twice), std::string::npos) << from_mesh;
  const std::string from_scene = message_of({scene("{interface: [x_max], modes: 4}")});
  EXPECT_NE(from_scene.find("scene.yaml:3: component 'box': " + path("box.msh") +
                            ": is not a regular file"),
            std::string::npos)
      << from_scene;
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
  EXPECT_NE(warnings("4").find("keep more modes"), std::string::npos);
  const std::string all = warnings("54");
  EXPECT_NE(all.find("refine the mesh at the interface"), std::string::npos) << all;
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
  EXPECT_NE(table_of(mesh).find("| 17 "), std::string::npos);  // without a material
  ReduceCommand in_scene;
  in_scene.input = scene("{interface: [x_max], modes: 4}");
  EXPECT_NE(table_of(in_scene).find("| 17 "), std::string::npos);
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
  EXPECT_NE(message_of({path("box.msh")}).find("--youngs-modulus is missing"), std::string::npos);
  EXPECT_NE(message_of(mesh_arguments({"--basis", "massles"})).find("massless"), std::string::npos);
  EXPECT_NE(message_of(mesh_arguments({"--basis", "characteristic", "--statics", "x_mx"}))
                .find("did you mean 'x_max'"),
            std::string::npos);
  EXPECT_NE(message_of(mesh_arguments({"--keep", "x_max"}))
                .find("--keep requires --basis characteristic"),
            std::string::npos);
  EXPECT_NE(message_of(mesh_arguments({"--domains", "0"})).find("1 or more"), std::string::npos);
  EXPECT_NE(message_of(mesh_arguments({"--domains", "1000"})).find("at most that many"),
            std::string::npos);
  EXPECT_NE(message_of(mesh_arguments({"--interface", "x_mx"})).find("x_max"), std::string::npos);
  const std::string file = scene("{interface: [x_max], modes: 400}");
  EXPECT_NE(message_of({file, "--modes", "3"}).find("requires a mesh"), std::string::npos);
  EXPECT_NE(message_of({file}).find("scene.yaml:3: component 'box'"), std::string::npos)
      << message_of({file});
  const std::string again = message_of(
      {scene("{interface: [x_max], modes: 6, domains: 3, second_reduction: {modes: 400}}")});
  EXPECT_NE(again.find("scene.yaml:3: component 'box': second_reduction.modes: 400"),
            std::string::npos)
      << again;
  // What cannot run is not reduced.
  const std::string cannot =
      scene("{interface: [x_max], modes: 4}",
            "contact: [{between: [a.x_max, b.x_max], enforcement: nodal}]\n");
  const std::string text = bytes(cannot);
  std::ofstream(cannot) << text.substr(0, text.find("{end: 1.0}"))
                        << "{end: 1.0, integrator: newmark}\n";
  EXPECT_NE(message_of({cannot}).find("use 'enforcement: impulse'"), std::string::npos)
      << message_of({cannot});
  EXPECT_FALSE(fs::exists(path("box.cbr.h5")));
  EXPECT_THROW(run(mesh_arguments({"--cutoff-hz", "3"})), CLI::Error);
  EXPECT_THROW(run(mesh_arguments({"--memory", "much"})), CLI::Error);
  EXPECT_THROW(run(mesh_arguments({"--diagonal-limit", "-1"})), CLI::Error);
  EXPECT_THROW(run(mesh_arguments({"--diagonal-limit", "few"})), CLI::Error);
}

}  // namespace
}  // namespace cbr::test::program_test
