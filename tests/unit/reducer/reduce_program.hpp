// SPDX-License-Identifier: GPL-3.0-or-later
// cbr-reduce inside a test, in a folder with a mesh and a scene of two components.
#pragma once

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "reducer/command.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/reducer/box_mesh.hpp"

namespace cbr::test {

class ReduceProgram : public testing::Test {
 protected:
  ReduceProgram() {
    write_mesh(box_mesh({{3, 2, 2}, {3, 2, 2}, {0, 0, 0}, 0}), folder_ / "box.msh");
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  // Runs like the program; returns the scene for the next program.
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
    return refusal_of([&] { run(arguments, timings); });
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

  TemporaryFolder folder_;
};

}  // namespace cbr::test
