// SPDX-License-Identifier: GPL-3.0-or-later
// cbr-skin as users and pipes run it.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>

#include "common/scene/scene.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/common/mesh/sample_meshes.hpp"

namespace cbr::program_test {
namespace {

using test::TemporaryFolder;

struct Outcome {
  int code = -1;
  std::string out, err;
};

const char* scene_text =
    "materials:\n  steel: {youngs_modulus: 5.17e12, poissons_ratio: 0.3, density: 7836}\n"
    "components:\n  brick: {mesh: brick.msh, material: steel, reduction: {interface: [x_max], "
    "modes: 2}}\n"
    "instances:\n  left: {component: brick, as: superelement, position: [-3, 0, 0]}\n"
    "  right: {component: brick, as: mesh, position: [3, 0, 0], mirror: x}\n"
    "skin: {surfaces: [x_max], youngs_modulus: 6.9e3, poissons_ratio: 0.3, density: 0.11, "
    "thickness: 2.5e-10, mesh: s.msh}\n"
    "time: {end: 1}\n";

// A folder `work` with a mesh and a scene; what the program prints goes beside it.
struct Here {
  TemporaryFolder folder;
  Here() {
    std::filesystem::create_directories(folder / "here");
    write_mesh(test::brick(2, 1, 1), folder / "here" / "brick.msh");
    test::write_bytes(folder / "here" / "a.yaml", scene_text);
  }
  Outcome skin(const std::string& arguments) { return run(CBR_SKIN, arguments); }
  Outcome run(const std::string& program, const std::string& arguments) {
    const std::string work = (folder / "here").string(), out = (folder / "out").string(),
                      err = (folder / "err").string();
    const int status = std::system(
        ("cd '" + work + "' && " + program + " " + arguments + " > '" + out + "' 2> '" + err + "'")
            .c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, test::bytes_of(out), test::bytes_of(err)};
  }
  std::filesystem::path operator/(const std::string& name) const { return folder / "here" / name; }
  std::size_t n_entries() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder / "here"),
                      std::filesystem::directory_iterator()));
  }
};

// OpenBLAS says each time that it is loaded what it found: "Core: Haswell"
TEST(SkinProgram, runsWithKernelsOfThisProcessorUnlessToldOtherwise) {
  Here here;
  const auto last_core = [&](const std::string& variables) {
    const std::string said =
        here.run("env " + variables + " OPENBLAS_VERBOSE=2 " + std::string(CBR_SKIN), "--version")
            .err;
    const std::size_t at = said.rfind("Core: ");
    return at == std::string::npos
               ? said
               : said.substr(at + 6, said.find_first_of(" \n", at + 6) - at - 6);
  };
  EXPECT_EQ(last_core("OPENBLAS_CORETYPE=Prescott"), "Prescott");
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    EXPECT_NE(last_core("-u OPENBLAS_CORETYPE"), "Prescott");
  }
#endif
}

TEST(SkinProgram, overwritesNoMeshOfAComponent) {
  Here here;
  std::filesystem::create_symlink("brick.msh", here / "link.msh");
  const std::string mesh = test::bytes_of(here / "brick.msh");
  for (const char* output : {"brick.msh", "link.msh", "../here/brick.msh"}) {
    const Outcome outcome = here.skin(std::string("a.yaml -o ") + output);
    EXPECT_EQ(outcome.code, 2) << output;
    EXPECT_SAYS(outcome.err, "would be overwritten");
    EXPECT_EQ(test::bytes_of(here / "brick.msh"), mesh);
  }
}

TEST(SkinProgram, skinsAMesh) {
  Here here;
  for (const char* arguments : {"brick.msh --sideset x_max --sideset x_min -o s.exo",
                                "--sideset x_max brick.msh --sideset x_min -o s.exo"}) {
    const Outcome outcome = here.skin(arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    const Mesh mesh = read_mesh(here / "s.exo");
    EXPECT_GE(find_block(mesh, "skin.x_max"), 0);
    EXPECT_GE(find_block(mesh, "skin.x_min"), 0);
    EXPECT_EQ(here.n_entries(), 3U);
  }
  EXPECT_EQ(here.skin("--quiet brick.msh --sideset x_max -o s.msh").err, "");
}

TEST(SkinProgram, warnsOfReducedIntegrationWhichItsFileCannotHold) {
  Here here;
  test::write_bytes(
      here.folder / "here" / "r.inp",
      "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n"
      "*ELEMENT, TYPE=C3D8R, ELSET=ALL\n1, 1,2,3,4,5,6,7,8\n*SURFACE, NAME=S\n1, S1\n");
  const Outcome skinned = here.skin("r.inp --sideset S -o s.exo");
  EXPECT_EQ(skinned.code, 0);
  EXPECT_SAYS(skinned.err, "block 'ALL' has reduced integration: give it element: reduced");
}

TEST(SkinProgram, isAFilterOfScenes) {
  Here here;
  const Outcome from_file = here.skin("a.yaml");
  EXPECT_EQ(from_file.code, 0) << from_file.err;
  EXPECT_SAYS(from_file.err, "skin.right.x_max: 1 shells (quad4) on 4 nodes");
  const std::string mesh = test::bytes_of(here / "s.msh");
  const Outcome from_stdin = here.skin("- < a.yaml");
  EXPECT_EQ(from_stdin.code, 0) << from_stdin.err;
  EXPECT_EQ(from_file.out, from_stdin.out);
  EXPECT_EQ(mesh, test::bytes_of(here / "s.msh"));
  // What comes out can go in again, anywhere.
  test::write_bytes(here.folder / "moved.yaml", from_file.out);
  const Scene scene = read_scene((here.folder / "moved.yaml").string());
  ASSERT_TRUE(scene.skin.has_value());
  EXPECT_EQ(std::filesystem::weakly_canonical(scene.skin->mesh),
            std::filesystem::weakly_canonical(here / "s.msh"));
  EXPECT_TRUE(std::filesystem::exists(scene.components.at("brick").mesh));
  EXPECT_EQ(here.skin("../moved.yaml").out, from_file.out);
}

TEST(SkinProgram, aSceneWithoutSkinPassesThroughAndNoMeshIsRead) {
  Here here;
  std::string text = scene_text;
  text.erase(text.find("skin:"), text.find("time:") - text.find("skin:"));
  test::write_bytes(here / "a.yaml", text);
  std::filesystem::remove(here / "brick.msh");
  const Outcome once = here.skin("a.yaml");
  EXPECT_EQ(once.code, 0) << once.err;
  test::write_bytes(here.folder / "b.yaml", once.out);
  EXPECT_EQ(here.skin("../b.yaml").out, once.out);
  EXPECT_EQ(here.n_entries(), 1U);
}

// The mesh replaced between cbr-reduce and cbr-skin: the skin is of another mesh than the
// superelement.
TEST(SkinProgram, warnsOfASuperelementThatIsNotOfThePresentMesh) {
  Here here;
  EXPECT_EQ(here.skin("a.yaml -q").err, "");  // none there yet
  ASSERT_EQ(here.run(CBR_REDUCE, "a.yaml -q").code, 0);
  EXPECT_EQ(here.skin("a.yaml -q").err, "");
  write_mesh(test::brick(3, 1, 1), here / "brick.msh");
  const Outcome stale = here.skin("a.yaml -q");
  EXPECT_EQ(stale.code, 0);
  for (const char* part : {"warning: ", "component 'brick'", "brick.cbr.h5", "run cbr-reduce"})
    EXPECT_SAYS(stale.err, part);
  ASSERT_EQ(here.run(CBR_REDUCE, "a.yaml -q").code, 0);
  EXPECT_EQ(here.skin("a.yaml -q").err, "");
  test::write_bytes(here / "brick.cbr.h5", "no superelement");
  EXPECT_SAYS(here.skin("a.yaml -q").err, "brick.cbr.h5");
}

TEST(SkinProgram, badInputIsOneLineAndLeavesNothing) {
  Here here;
  const auto refused = [&](const std::string& arguments, const std::string& part) {
    const Outcome outcome = here.skin(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_EQ(outcome.err.rfind("cbr-skin: error: ", 0), 0U) << outcome.err;
    EXPECT_SAYS(outcome.err, part);
  };
  const auto changed = [&](const std::string& old, const std::string& by) {
    std::string text = scene_text;
    test::write_bytes(here / "b.yaml", text.replace(text.find(old), old.size(), by));
  };
  refused("", "INPUT");
  refused("none.yaml", "none.yaml");
  refused("none.msh --sideset a -o b.msh", "none.msh: no such file");
  refused("brick.msh", "--sideset");
  refused("brick.msh --sideset x_max", "-o");
  refused("brick.msh --sideset x_max -o ./brick.msh", "would be overwritten");
  refused("brick.msh --sideset x_max -o s.msh --timings ./s.msh",
          "is the file of both the skinned mesh and the timings");
  refused("brick.msh --sideset top -o s.msh", "x_min, x_max");
  refused("brick.msh --sideset x_max -o s.stl", ".stl");
  refused("brick.msh --sideset x_max -o no/such/folder/s.msh", "folder");
  refused("a.yaml --sideset x_max", "surfaces");
  changed("surfaces: [x_max]", "surfaces: [x_mix]");
  refused("b.yaml", "b.yaml:8");
  changed("mesh: s.msh", "mesh: brick.msh");
  refused("b.yaml", "component 'brick'");
  changed("mesh: s.msh", "mesh: s.stl");
  refused("b.yaml", "s.stl");
  changed("density: 0.11", "density: -0.11");
  refused("b.yaml", "density");
  changed("thickness: 2.5e-10", "thickness: -1");
  refused("b.yaml", "thickness");
  changed("brick.msh", "wall.msh");
  refused("b.yaml", "wall.msh");
  EXPECT_EQ(here.n_entries(), 3U);  // the mesh and the two scenes
}

}  // namespace
}  // namespace cbr::program_test
