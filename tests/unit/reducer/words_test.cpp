// SPDX-License-Identifier: GPL-3.0-or-later
// What cbr-reduce tells and refuses in words: blocks left out, stale files, foreign meshes, --info.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>

#include "common/base/error.hpp"
#include "common/fem/assembly.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/scene/component_blocks.hpp"
#include "common/scene/staleness.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/bases/reduce.hpp"
#include "reducer/command.hpp"
#include "reducer/estimate/estimate.hpp"
#include "reducer/judgement/accuracy.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"
#include "tests/unit/reducer/box_mesh.hpp"

namespace cbr::test::words_test {
namespace {

namespace fs = std::filesystem;

class Words : public testing::Test {
 protected:
  Words() {
    Mesh mesh = box_mesh({{3, 2, 2}, {3, 2, 2}, {0, 0, 0}, 0});
    write_mesh(mesh, folder_ / "box.msh");
    const Block& solid = mesh.blocks.front();
    mesh.blocks.push_back(
        {"fin", 2, ElementType::quad4, solid.connectivity.leftCols(4).topRows(2), {101, 102}});
    write_mesh(mesh, folder_ / "fin.exo");
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  std::string scene(const std::string& mesh, const std::string& modes,
                    const std::string& blocks = "", const std::string& time = "") const {
    std::ofstream(path("scene.yaml"))
        << "materials: {soft: {youngs_modulus: 1000, poissons_ratio: 0.3, density: 2}}\n"
           "components:\n  box: {mesh: "
        << mesh << ", material: soft, " << blocks
        << "reduction: {interface: [x_max], modes: " << modes
        << "}}\ninstances:\n  a: {component: box}\ntime: {" << time << "end: 1.0}\n";
    return path("scene.yaml");
  }

  // The warnings.
  static std::string reduce(const std::string& input) {
    ReduceCommand command;
    command.input = input;
    Report report("cbr-reduce", Verbosity::quiet);
    std::ostringstream scene;
    run_reduce(command, &scene, report);
    return join(report.warnings());
  }

  // The first warning of materials and elements of a block of an element, of a material.
  std::string warned_of(const std::string& element, const std::string& material) const {
    std::ofstream(path("material.yaml"))
        << "materials: {m: {" << material
        << "}}\ncomponents:\n  box: {mesh: box.msh, material: m, element: " << element
        << ", reduction: {interface: [x_max], modes: 2}}\ninstances:\n  a: {component: box}\n";
    const std::string text = reduce(path("material.yaml"));
    return text.find("block solid: ") == std::string::npos ? "" : text;
  }

  static std::string refusal(const std::string& input) {
    return test::refusal_of([&] { reduce(input); });
  }

  const TemporaryFolder folder_;
};

TEST(BasisAdvice, IsForFacesOfManyNodesAndBasesThatKeepEachOfThem) {
  Superelement s;
  const auto face_of = [](Index nodes) {
    Surface face;
    face.name = "face";
    face.faces.resize(nodes / 4, 4);
    for (Index i = 0; i < face.faces.size(); ++i) face.faces.reshaped()[i] = i;
    return face;
  };
  s.surfaces = {face_of(8)};
  EXPECT_EQ(advice_on_basis(s), "");
  s.surfaces = {face_of(120), face_of(120)};  // the same nodes twice
  EXPECT_TRUE(
      advice_on_basis(s).starts_with("all 120 nodes of faces are kept one by one; with "
                                     "basis: characteristic"))
      << advice_on_basis(s);
  s.basis = "characteristic";
  EXPECT_EQ(advice_on_basis(s), "");
}

TEST_F(Words, ShellsAreNotedWithTheirCountAndRefusedWhereTheSceneNamesThem) {
  EXPECT_EQ(left_out_blocks(read_mesh(path("box.msh"))), "");
  EXPECT_EQ(left_out_blocks(read_mesh(path("fin.exo"))), "fin (2 quad4)");
  reduce(scene("fin.exo", "4"));
  EXPECT_EQ(read_superelement(path("box.cbr.h5")).provenance.at("left_out"), "fin (2 quad4)");
  const std::string text = refusal(scene("fin.exo", "4", "blocks: {fin: {material: soft}}, "));
  for (const char* part : {"scene.yaml:3", "blocks.fin", "2 quad4", "a thickness", "take it out"})
    EXPECT_SAYS(text, part);
}

TEST_F(Words, StepsOfASuperelementThatCostMoreThanThoseOfItsMeshAreWarnedOf) {
  write_mesh(box_mesh({{6, 6, 6}, {1, 1, 1}, {0, 0, 0}, 0}), path("cube.exo"));
  const auto warned = [&](const std::string& faces, const std::string& contact,
                          const std::string& time) {
    fs::remove(path("cube.cbr.h5"));
    std::ofstream(path("cube.yaml"))
        << "materials: {soft: {youngs_modulus: 1000, poissons_ratio: 0.3, density: 2}}\n"
           "components:\n  cube: {mesh: cube.exo, material: soft, reduction: {interface: ["
        << faces
        << "], modes: 5}}\ninstances:\n  a: {component: cube}\n"
           "walls: {w: {plane: {point: [-9, 0, 0], normal: [1, 0, 0]}}}\ncontact: "
        << contact << "\ntime: {" << time << "end: 1.0}\n";
    const std::string text = reduce(path("cube.yaml"));
    return text.find("times the bytes of a step of its mesh") != std::string::npos;
  };
  const std::string all = "x_min, x_max, y_min, y_max, z_min, z_max";
  EXPECT_TRUE(warned(all, "all", ""));
  EXPECT_FALSE(warned(all, "[{between: [a.x_min, w]}]", ""));
  EXPECT_FALSE(warned("x_min", "all", ""));
  EXPECT_FALSE(warned(all, "all", "integrator: newmark, "));
}

TEST_F(Words, MassLeftOnTheInterfaceIsWarnedOfWhereBodiesMove) {
  EXPECT_EQ(reduce(scene("box.msh", "0", "", "static: true, ")), "");
  fs::remove(path("box.cbr.h5"));
  EXPECT_SAYS(reduce(scene("box.msh", "0")), "much mass is left");
}

// From the mesh, and of a file that is up to date.
TEST_F(Words, ElementsThatLockAreWarnedOfNearIncompressibility) {
  const std::string soft = "youngs_modulus: 1.0e6, density: 1000, poissons_ratio: ";
  for (int time = 0; time < 2; ++time) {
    EXPECT_SAYS(warned_of("hex8", soft + "0.499"),
                "component 'box': block solid: hex8 locks at a Poisson's ratio of 0.499, so");
  }
  const auto cure_of = [](const char* element, const char* ratio) {
    Report report("test", Verbosity::quiet);
    warn_of_blocks({}, {{"block b: element", element}, {"block b: poissons_ratio", ratio}}, report);
    const std::string text = join(report.warnings());
    return text.substr(std::min(text.size(), text.find("use ")));
  };
  const std::string of_hexes = "use element: hex8-hourglass, or a mesh of hex20 or hex27";
  EXPECT_EQ(cure_of("hex8", "0.489"), "");
  EXPECT_EQ(cure_of("hex8", "0.49"), of_hexes);
  EXPECT_EQ(cure_of("hex8-incompatible", "0.498"), "");
  EXPECT_EQ(cure_of("hex8-incompatible", "0.49899999999999999"), of_hexes);
  for (const char* element : {"tet4", "wedge6", "pyramid5"})
    EXPECT_EQ(cure_of(element, "0.48999999999999999"), "use a mesh of tet10");
  for (const char* element : {"hex8-hourglass", "tet10", "hex20", "hex27"})
    EXPECT_EQ(cure_of(element, "0.4999"), "");
}

// Four hex20 of C3D20R in a row; elsewhere none has four edges of its own along one axis.
TEST_F(Words, RowsOfReducedIntegrationAreWarnedOf) {
  const auto warned = [](const std::array<Index, 3>& cells, HexFormulation hex) {
    Report report("test", Verbosity::quiet);
    const Mesh mesh = box_mesh(ElementType::hex20, cells, Vector3(1, 1, 1));
    warn_of_mesh({}, mesh, {{{1, 0.3, 1}, hex}}, report);
    return join(report.warnings());
  };
  EXPECT_SAYS(warned({1, 4, 1}, HexFormulation::reduced),
              "block solid: 4 hex20 of reduced integration lie in rows");
  EXPECT_EQ(warned({1, 4, 1}, HexFormulation::full), "");
  EXPECT_EQ(warned({2, 4, 1}, HexFormulation::reduced), "");
}

TEST_F(Words, WavesAsInNoSolidAreWarnedOfWithTheUnitsThatGiveThem) {
  const auto of = [&](const std::string& E, const std::string& rho) {
    return warned_of("hex8", "poissons_ratio: 0.3, youngs_modulus: " + E + ", density: " + rho);
  };
  EXPECT_SAYS(of("2.1e5", "7850"), "sqrt(E / rho) = 5.17 length units a second, slower",
              "MPa beside a density in kg/m^3");
  EXPECT_SAYS(of("2.1e11", "7.85e-9"), "5.17e+09 length units a second, faster");
  EXPECT_EQ(of("2", "1"), "");             // without units
  EXPECT_EQ(of("2.1e11", "7850"), "");     // m, kg
  EXPECT_EQ(of("2.1e5", "7.85e-9"), "");   // mm, t
  EXPECT_EQ(of("2.1e8", "7.85e-6"), "");   // mm, kg
  EXPECT_EQ(of("3.0e7", "7.3e-4"), "");    // inch, pound
  EXPECT_EQ(of("1.22e6", "3.52e-9"), "");  // diamond, in mm
  for (const std::string& text : {of("3.0e7", "0.283"), of("1.0e7", "0.098")})
    EXPECT_SAYS(text, "weight in lbf/in^3: divide it by 386.1");
  EXPECT_EQ(of("3.0e7", "0.1"), "");  // some rubber, in cm and g
}

// gmsh's beams come as nodesets.
TEST_F(Words, NodesetsOfNoSolidAreNotedLikeShells) {
  Mesh mesh = read_mesh(path("box.msh"));
  const Index n = mesh.coordinates.rows();
  mesh.coordinates.conservativeResize(n + 2, 3);
  mesh.coordinates.bottomRows(2) << 9, 9, 9, 10, 9, 9;
  mesh.node_ids.insert(mesh.node_ids.end(), {90001, 90002});
  mesh.nodesets.push_back({"beam", 77, {0, n, n + 1}});
  EXPECT_EQ(left_out_blocks(mesh), "beam (2 of its 3 nodes are of no element)");
}

TEST_F(Words, AStaleFileTellsWhichOptionDiffers) {
  reduce(scene("box.msh", "4"));
  const Scene now = read_scene(scene("box.msh", "5"));
  EXPECT_EQ(stale_text(now, now.components.at("box")), "modes: 4 in the file, 5 in the scene");
  const Scene other = read_scene(scene("box.msh", "4", "mass: consistent, "));
  EXPECT_EQ(stale_text(other, other.components.at("box")),
            "mass: lumped in the file, consistent in the scene");
}

// Of basis characteristic: what the scene does to its kept sets.
class WordsOnStatics : public Words {
 protected:
  std::string loaded(const std::string& contact, const std::string& loads) const {
    std::ofstream(path("statics.yaml"))
        << "materials: {soft: {youngs_modulus: 1.0e6, poissons_ratio: 0.3, density: 2}}\n"
           "components:\n  box: {mesh: box.msh, material: soft, reduction: {basis: characteristic, "
           "interface: [x_min, x_max, y_max], modes: 4}}\ninstances:\n  a: {component: box}\n"
           "walls: {w: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}}\n"
           "contact: [{between: [a.x_min, w]" +
               contact + "}]\nloads: [" + loads + "]\ntime: {end: 1.0}\n";
    return path("statics.yaml");
  }
  static std::string said_of(const std::string& input) {
    ReduceCommand command;
    command.input = input;
    testing::internal::CaptureStderr();
    Report report("cbr-reduce", Verbosity::normal);
    std::ostringstream scene;
    run_reduce(command, &scene, report);
    return testing::internal::GetCapturedStderr();
  }
  static std::string staleness_of(const std::string& input) {
    const Scene now = read_scene(input);
    return stale_text(now, now.components.at("box"));
  }
};

TEST_F(WordsOnStatics, TheSummaryNamesKeptSetsWithoutStatics) {
  const std::string load = "{instance: a, surface: x_max, traction: [1, 0, 0]}";
  EXPECT_SAYS(said_of(loaded("", "")), "no statics   x_max, y_max: ");
  EXPECT_SAYS(said_of(loaded("", load)), "6 to the scene's loads", "no statics   y_max: ");
}

TEST_F(WordsOnStatics, AFileOfOtherLoadsIsStaleAndSaysWhich) {
  const std::string load = "{instance: a, surface: x_max, traction: [1, 0, 0]}";
  reduce(loaded("", ""));
  EXPECT_EQ(staleness_of(loaded("", load)),
            "needs x_max: not given in the file, forces in the scene");
  EXPECT_EQ(staleness_of(loaded(", friction: 0.1", "")),
            "needs x_min: contact in the file, contact, friction in the scene");
  const Scene more = read_scene(loaded(", friction: 0.1", load)), less = read_scene(loaded("", ""));
  const InterfaceNeeds of_more = interface_needs(more, more.components.at("box")),
                       of_less = interface_needs(less, less.components.at("box"));
  EXPECT_EQ(missing_needs(of_more, of_less), "");
  EXPECT_EQ(missing_needs(of_less, of_more), "x_max (forces), x_min (friction)");
  // There and back
  EXPECT_EQ(needs_provenance(needs_in(needs_provenance(of_more))), needs_provenance(of_more));
  EXPECT_EQ(content_hash(less, less.components.at("box"), of_more),
            content_hash(more, more.components.at("box")));
}

TEST_F(Words, FilesOfOtherProgramsAreToldWhatToDoWith) {
  std::ofstream(path("x.cdb")) << "*NODE\n";
  for (const std::string& input : {path("x.cdb"), scene("x.cdb", "4")})
    EXPECT_SAYS(refusal(input), "convert it to gmsh's .msh or to Exodus II");
  EXPECT_SAYS(refusal(path("x.step")), "mesh it first (gmsh -3 x.step");
  Mesh shells = read_mesh(path("fin.exo"));
  shells.blocks.erase(shells.blocks.begin());
  shells.sidesets.clear();
  write_mesh(shells, folder_ / "shells.exo");
  EXPECT_SAYS(refusal(scene("shells.exo", "4")), "Physical Volume") << refusal(path("scene.yaml"));
}

TEST_F(Words, InfoTellsWhatASuperelementIs) {
  reduce(scene("box.msh", "4"));
  std::ostringstream out;
  print_info(path("box.cbr.h5"), out);
  for (const char* part :
       {"a superelement", "modes: 4", "block solid: density 2", "27 of the interface",
        "first frequencies with", "first elastic frequencies", "x_max (4 faces)", "aim: below 1 %"})
    EXPECT_SAYS(out.str(), part) << part;
  EXPECT_THROW(print_info(path("box.msh"), out), InputError);
}

TEST_F(Words, InfoTellsWhatResultsAndCheckpointsAre) {
  const auto told = [&](const std::string& format, const std::function<void(Hdf5Writer&)>& fill) {
    {
      Hdf5Writer file(path("some.h5"));
      file.attribute("/", "format", format);
      file.attribute("/", "format_version", std::string("1.3"));
      file.attribute("/", "generator", std::string("cbr-dyn 0"));
      fill(file);
      file.commit();
    }
    std::ostringstream out;
    print_info(path("some.h5"), out);
    return out.str();
  };
  const std::string results = told("cbr-results", [](Hdf5Writer& file) {
    file.attribute("/", "partial", Index{1});
    file.attribute("/", "steps", Index{120});
    file.attribute("/", "n_dofs", Index{77});
    file.write("/time", Vector(Vector::LinSpaced(3, 0, 0.5)));
    file.write("/instances/left/kinetic_energy", Vector(Vector::Zero(3)));
  });
  for (const char* part : {"results of a run", "3, from t = 0 to 0.5 s",
                           "120 steps, 77 dofs; stopped by a signal", "left"})
    EXPECT_SAYS(results, part) << part;
  const std::string checkpoint = told("cbr-checkpoint", [](Hdf5Writer& file) {
    file.attribute("/", "step", Index{9});
    file.write("/time", 0.25);
  });
  for (const char* part : {"a checkpoint", "t = 0.25 s, step 9", "--restart"})
    EXPECT_SAYS(checkpoint, part) << part;
  const Vector hz = Vector::LinSpaced(12, 0, 110);
  const std::string modes = told("cbr-modes", [&](Hdf5Writer& file) {
    file.write("/instances/left/frequency_hz", Vector(hz.head(3)));
  });
  EXPECT_SAYS(modes, "  modes        left: 0, 10, 20 Hz\n");
  const std::string shapes = told("cbr-fields", [&](Hdf5Writer& file) {
    file.write("/times", Vector(hz / 10));
    file.write("/frequency_hz", hz);
  });
  EXPECT_SAYS(shapes, "  modes        12: 0, 10, 20, 30, 40, 50, 60, 70, 80, 90, ..., 110 Hz\n");
  EXPECT_THROW(told("other", [](Hdf5Writer&) {}), InputError);
}

TEST_F(Words, ReadmesFirstSceneRunsAsItIsPrinted) {
  std::ifstream in(CBR_SOURCE_DIR "/README.md");
  std::stringstream readme;
  readme << in.rdbuf();
  const std::string text = readme.str(), fence = "```yaml\n";
  const auto first = text.find(fence) + fence.size();
  std::ofstream(path("impact.yaml")) << text.substr(first, text.find("```", first) - first);
  Mesh mesh = read_mesh(path("box.msh"));
  mesh.sidesets[find_sideset(mesh, "x_max")].name = "contact";
  write_mesh(mesh, folder_ / "block.msh");
  ASSERT_NO_THROW(reduce(path("impact.yaml")));
  const Superelement block = read_superelement(path("block.cbr.h5"));
  EXPECT_TRUE(block.is_characteristic());
  EXPECT_EQ(block.provenance.at("modes"), "80");
  EXPECT_GT(block.k(), 80);  // the shapes of the face come on top
}

TEST(EstimateOfRecovery, IsWhatTheFileHolds) {
  const Mesh mesh = box_mesh({{3, 2, 2}, {3, 2, 2}, {0, 0, 0}, 0});
  const std::vector<BlockProperties> soft = {
      {{.youngs_modulus = 1000, .poissons_ratio = 0.3, .density = 2}, {}}};
  ReductionOptions options;
  options.interface_sets = {"x_max"};
  options.modes = 4;
  options.recovery = true;
  const Estimate e = estimate(mesh, soft, options, std::vector<Index>(12, 0), 6000);
  Report report("test", Verbosity::quiet);
  const Superelement s = cbr::reduce(mesh, soft, MassKind::lumped, options, {}, report);
  const auto& r = s.recovery.front();
  EXPECT_EQ(e.recovery_nonzeros(), static_cast<double>(r.Psi.size() + r.Phi.size()));
  EXPECT_EQ(
      e.file_nonzeros(),
      static_cast<double>(r.Psi.size() + r.Phi.size() + s.K_cc.size() + s.M_cc.size() +
                          s.M_kc.size() + s.eigenvalues.size() + s.V.size() + s.omega.size()));
  std::ostringstream out;
  print_estimate(e, 4e9, "# title", out);
  const auto first =
      out.str().find("- dofs: 31 (27 of nodes, 4 modes) for 108 of the mesh\n- file: ");
  ASSERT_NE(first, std::string::npos) << out.str();
  EXPECT_LT(first, out.str().find("| 5 "));
  EXPECT_SAYS(out.str(), "of which recovery", "times the bytes of one of the full mesh");
}

TEST(FrequencyLines, AreTheLowestSixInHertz) {
  Superelement s;
  s.eigenvalues = Vector::LinSpaced(9, 1, 9).array().square();
  const auto lines = frequency_lines(s);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_SAYS(lines[0].text, ": 0.159155, 0.31831, 0.477465, 0.63662, 0.795775, 0.95493 Hz");
}

TEST(StaticsLines, TellNodesOfOneDirectionFromThoseOfThree) {
  const auto text = [](const std::vector<Index>& nodes) {
    const auto lines = statics_lines(nodes, nodes.size() == 5);
    return lines.empty() ? std::string() : lines.front().text;
  };
  EXPECT_EQ(text({}), "");
  EXPECT_SAYS(text({4, 7}), "at 2 nodes that may touch, normal to their faces");
  EXPECT_TRUE(text({4, 4, 4, 7, 7, 7}).ends_with("at 2 nodes that may touch, in all directions"));
  EXPECT_SAYS(text({4, 4, 4, 7, 9}),
              "at 3 nodes that may touch, in all directions at 1 of them, "
              "for friction, and normal to their faces at the other 2",
              "of single nodes to some 2 %");
  EXPECT_SAYS(text({4, 7}), "in full");
}

// A box's own: m (b^2 + c^2) / 12; of nodes with lumped mass it is more.
TEST(GeometryBody, IsTheBoxs) {
  const Mesh mesh = box_mesh({.n = {4, 1, 1}, .size = {4, 1, 2}});
  const RigidBody body = rigid_body_of_geometry(
      mesh, {{{.youngs_modulus = 1, .poissons_ratio = 0, .density = 3}, {}}});
  EXPECT_NEAR(body.mass, 24, 1e-12);
  EXPECT_LT((body.center - Vector3(2, 0.5, 1)).norm(), 1e-12);
  const Matrix3 expected = (Vector3(5, 20, 17) * 2).asDiagonal();
  EXPECT_LT((body.inertia - expected).norm(), 1e-11);
}

}  // namespace
}  // namespace cbr::test::words_test
