// SPDX-License-Identifier: GPL-3.0-or-later
// Which superelement files cbr-reduce makes anew, and what it never writes over.
#include <chrono>
#include <filesystem>
#include <fstream>

#include "common/files/hdf5_file.hpp"
#include "common/superelement/superelement_file.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/reducer/reduce_program.hpp"

namespace cbr::test::program_files_test {
namespace {

namespace fs = std::filesystem;

class ProgramFiles : public ReduceProgram {};

TEST_F(ProgramFiles, AMeshGivesTheSameFileAsAScene) {
  EXPECT_EQ(run(mesh_arguments()), "");
  const Superelement s = read_superelement(path("box.cbr.h5"));
  EXPECT_EQ(s.k(), 4);
  EXPECT_EQ(s.c(), 27);
  EXPECT_EQ(s.provenance.at("mesh"), "box.msh");
  EXPECT_EQ(s.provenance.at("block solid: youngs_modulus"), "1000");
  EXPECT_FALSE(s.content_hash.empty());
  const std::string by_mesh = bytes_of(path("box.cbr.h5"));
  fs::remove(path("box.cbr.h5"));
  const std::string handed_on = run({scene("{interface: [x_max], modes: 4}")});
  EXPECT_EQ(bytes_of(path("box.cbr.h5")), by_mesh);
  EXPECT_EQ(bytes_of(path("twin.cbr.h5")), by_mesh);
  EXPECT_SAYS(handed_on, path("box.cbr.h5"));
}

TEST_F(ProgramFiles, ReducesOnlyWhatHasChanged) {
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

TEST_F(ProgramFiles, TheDiagonalFormIsMadeWhereARunMayReadIt) {
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

TEST_F(ProgramFiles, SetsThatAreNotKeptAreRefusedThoughTheFileIsUpToDate) {
  const std::string reduction = "{interface: [x_max], modes: 4}";
  run({scene(reduction)});
  const std::string history = "output: {history: [a.x_min]}\n";
  EXPECT_SAYS(message_of({scene(reduction, history)}), "keeps 0 of its");
  EXPECT_SAYS(message_of({scene(reduction, "output: {history: [a.x_mni]}\n")}), "x_mni");
  EXPECT_EQ(message_of({scene(reduction, "output: {history: [a.x_max]}\n")}), "no error");
}

TEST_F(ProgramFiles, OverwritesNoMeshAndNoScene) {
  const std::string mesh = bytes_of(path("box.msh"));
  std::vector<std::string> arguments = mesh_arguments();
  arguments.back() = path("box.msh");
  EXPECT_SAYS(message_of(arguments), "another name");
  fs::create_symlink(path("box.msh"), path("link.h5"));
  const std::string file = scene("{interface: [x_max], modes: 4}");
  const auto with_superelement = [&](const std::string& name) {
    const std::string text = bytes_of(file);
    const std::string key = "modes: 4";
    std::string changed = text;
    changed.replace(text.find(key), key.size(), key + ", superelement: " + name);
    std::ofstream(file) << changed;
    const std::string message = message_of({file});
    EXPECT_EQ(bytes_of(file), changed);
    std::ofstream(file) << text;
    return message;
  };
  EXPECT_SAYS(with_superelement("link.h5"), "the mesh of component 'box'");
  EXPECT_SAYS(with_superelement("scene.yaml"), "the scene itself");
  EXPECT_EQ(bytes_of(path("box.msh")), mesh);
}

TEST_F(ProgramFiles, TimingsInThePlaceOfASuperelementAreRefusedBeforeTheWork) {
  EXPECT_SAYS(message_of({scene("{interface: [x_max], modes: 4}")}, path("twin.cbr.h5")),
              "twin.cbr.h5: is the file of both the superelement of component 'twin' and "
              "the timings");
  EXPECT_FALSE(fs::exists(path("box.cbr.h5")));
  EXPECT_FALSE(fs::exists(path("twin.cbr.h5")));
}

TEST_F(ProgramFiles, OverwritesNoHdf5FileOfAnotherKind) {
  {
    Hdf5Writer results(path("box.cbr.h5"));
    results.attribute("/", "format", std::string("cbr-results"));
    results.commit();
  }
  const std::string before = bytes_of(path("box.cbr.h5"));
  EXPECT_SAYS(message_of(mesh_arguments()), "cbr-results");
  EXPECT_EQ(bytes_of(path("box.cbr.h5")), before);
  std::ofstream(path("box.cbr.h5")) << "my notes\n";
  EXPECT_SAYS(message_of(mesh_arguments()), "box.cbr.h5: exists and is not an HDF5 file");
  EXPECT_EQ(bytes_of(path("box.cbr.h5")), "my notes\n");
  std::ofstream(path("box.cbr.h5"), std::ios::trunc).flush();
  EXPECT_EQ(run(mesh_arguments()), "");  // over an empty one, as mktemp makes it
}

TEST_F(ProgramFiles, AMeshWithoutEndIsRefused) {
  fs::remove(path("box.msh"));
  fs::create_symlink("/dev/zero", path("box.msh"));
  const std::string from_mesh = message_of(mesh_arguments()),
                    path_twice = "box.msh: " + path("box.msh");
  EXPECT_SAYS(from_mesh, "box.msh: is not a regular file");
  EXPECT_EQ(from_mesh.find(path_twice), std::string::npos) << from_mesh;
  EXPECT_SAYS(message_of({scene("{interface: [x_max], modes: 4}")}),
              "scene.yaml:3: component 'box': " + path("box.msh") + ": is not a regular file");
}

}  // namespace
}  // namespace cbr::test::program_files_test
