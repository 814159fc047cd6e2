// SPDX-License-Identifier: GPL-3.0-or-later
// Which mass a superelement has where the scene does not say, and that it is the nearer one:
// docs/decisions/mass.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "common/fem/assembly.hpp"
#include "common/mesh/mesh.hpp"
#include "common/scene/component_blocks.hpp"
#include "common/scene/staleness.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/bases/reduce.hpp"
#include "reducer/command.hpp"
#include "reducer/domains/domains.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::test::default_mass_test {
namespace {

namespace fs = std::filesystem;

// A bar with the sideset x_max.
Mesh bar(ElementType type, const std::array<Index, 3>& cells) {
  Mesh mesh = box_mesh(type, cells, Vector3(0.2, 0.04, 0.03));
  Sideset end{"x_max", 1, {}};
  const auto is_at_end = [&](Index node) { return mesh.coordinates(node, 0) > 0.2 - 1e-9; };
  for (Index e = 0; e < mesh.blocks[0].connectivity.rows(); ++e)
    for (int side = 1; side <= n_sides(type); ++side) {
      const std::vector<Index> nodes = nodes_of_side(mesh, {0, e, side});
      if (std::all_of(nodes.begin(), nodes.end(), is_at_end)) end.sides.push_back({0, e, side});
    }
  mesh.sidesets = {end};
  return mesh;
}

const Material steel = {.youngs_modulus = 2.1e11, .poissons_ratio = 0.3, .density = 7850};

class DefaultMass : public testing::Test {
 protected:
  fs::path file(const std::string& name) const { return folder_ / name; }

  // Of components by name, each with options such as "mass: lumped, ".
  std::string scene(const std::string& mesh,
                    const std::map<std::string, std::string>& components) const {
    std::ofstream out(file("scene.yaml"));
    out << "materials: {steel: {youngs_modulus: 2.1e11, poissons_ratio: 0.3, density: "
           "7850}}\ncomponents:\n";
    for (const auto& [name, options] : components)
      out << "  " << name << ": {mesh: " << mesh << ", material: steel, " << options
          << "reduction: {interface: [x_max], modes: 4}}\n";
    out << "instances:\n";
    for (const auto& [name, options] : components)
      out << "  of_" << name << ": {component: " << name << ", as: superelement}\n";
    out << "time: {end: 1.0e-5}\n";
    return file("scene.yaml").string();
  }

  static std::string reduce(const std::string& input) {
    ReduceCommand command;
    command.input = input;
    Report report("cbr-reduce", Verbosity::quiet);
    std::ostringstream scene;
    run_reduce(command, &scene, report);
    return scene.str();
  }

  std::string mass_of(const std::string& component) const {
    return read_superelement(file(component + ".cbr.h5")).provenance.at("mass");
  }

  const TemporaryFolder folder_;
};

TEST_F(DefaultMass, IsConsistentOfTheElementsThatLumpingSpoils) {
  for (const ElementType type : volume_types) {
    const Mesh mesh = bar(type, {4, 1, 1});
    write_mesh(mesh, file("bar.exo"));
    const std::string completed = reduce(scene("bar.exo", {{"bar", ""}}));
    const bool spoilt =
        type == ElementType::hex20 || type == ElementType::tet10 || type == ElementType::wedge15;
    EXPECT_EQ(mass_of("bar"), spoilt ? "consistent" : "lumped") << name(type);
    EXPECT_SAYS(completed, "mass: auto");
    const Matrix3 own = read_superelement(file("bar.cbr.h5")).rigid_body.inertia;
    const Matrix3 geometry = rigid_body_of_geometry(mesh, {{steel, {}}}).inertia;
    if (spoilt) {
      EXPECT_LT((own - geometry).norm(), 1e-10 * geometry.norm()) << name(type);
    }
    EXPECT_EQ(mass_of_mesh(read_scene(file("scene.yaml").string()).components.at("bar")),
              MassKind::lumped);
  }
}

TEST_F(DefaultMass, GivesWayToTheScenes) {
  write_mesh(bar(ElementType::hex20, {4, 1, 1}), file("bar.exo"));
  reduce(scene("bar.exo", {{"bar", ""}, {"light", "mass: lumped, "}, {"same", "mass: auto, "}}));
  EXPECT_EQ(mass_of("bar"), "consistent");
  EXPECT_EQ(mass_of("light"), "lumped");
  EXPECT_EQ(mass_of("same"), "consistent");
}

// Of a thick, short bar of few elements, whose mass matters; to first order, and second order is a
// per cent there. Of domains the line has the highest, and the whole's first is below it.
TEST_F(DefaultMass, TheShiftByConsistentMassIsThatOfAnotherReduction) {
  const Mesh mesh = bar(ElementType::hex8, {12, 3, 3});
  ReductionOptions options;
  options.interface_sets = {"x_max"};
  options.modes = 6;
  Report quiet("test", Verbosity::quiet);
  Vector shift;
  for (const Basis basis : {Basis::massless, Basis::craig_bampton}) {
    options.basis = basis;
    ReductionFigures figures;
    const auto reduced = [&](MassKind mass) {
      return cbr::reduce(mesh, {{steel, {}}}, mass, options, {}, quiet, &figures);
    };
    const Superelement consistent = reduced(MassKind::consistent);
    EXPECT_EQ(figures.mass_shift.size(), 0);
    const Vector low = reduced(MassKind::lumped).eigenvalues.tail(6);
    shift = consistent.eigenvalues.tail(6).cwiseQuotient(low).cwiseSqrt().array() - 1;
    ASSERT_EQ(figures.mass_shift.size(), 6);
    EXPECT_GT(shift.maxCoeff(), 0.02);
    for (Index i = 0; i < 6; ++i)
      EXPECT_NEAR(figures.mass_shift(i), shift(i), 0.02 * shift(i)) << i;
  }
  options.domains = 2;
  GroupFigures group;
  reduce_domains(mesh, {{steel, {}}}, MassKind::lumped, options, {}, quiet, &group);
  double highest = 0;
  for (const DomainFigures& domain : group.domains) {
    ASSERT_EQ(domain.reduction.mass_shift.size(), 6);
    highest = std::max(highest, domain.reduction.mass_shift(0));
  }
  EXPECT_GT(highest, shift(0));
}

// A file of the other mass, as of before there was a default by element, is made anew, and the
// difference is told.
TEST_F(DefaultMass, OfAnOlderFileIsNoticed) {
  write_mesh(bar(ElementType::tet10, {3, 1, 1}), file("bar.exo"));
  reduce(scene("bar.exo", {{"bar", "mass: lumped, "}}));
  const Scene now = read_scene(scene("bar.exo", {{"bar", ""}}));
  EXPECT_TRUE(is_of_other_mass(now.components.at("bar")));
  EXPECT_EQ(stale_text(now, now.components.at("bar")),
            "mass: lumped in the file, consistent in the scene");
  reduce(file("scene.yaml").string());
  EXPECT_EQ(mass_of("bar"), "consistent");
  EXPECT_FALSE(is_of_other_mass(now.components.at("bar")));
  write_mesh(bar(ElementType::hex8, {3, 1, 1}), file("bar.exo"));
  reduce(scene("bar.exo", {{"bar", "mass: lumped, "}}));
  const Scene linear = read_scene(scene("bar.exo", {{"bar", ""}}));
  EXPECT_FALSE(is_of_other_mass(linear.components.at("bar"))) << "the same numbers";
}

// Six lowest elastic frequencies of the free mesh, rad/s.
Vector frequencies(ElementType type, const std::array<Index, 3>& cells, MassKind mass) {
  ReductionOptions options;
  options.basis = Basis::massless;
  options.interface_sets = {"x_max"};
  options.modes = 8;
  Report report("test", Verbosity::quiet);
  const Superelement s = cbr::reduce(bar(type, cells), {{steel, {}}}, mass, options, {}, report);
  return s.eigenvalues.segment(6, 6).cwiseSqrt();
}

TEST(MassOfElements, ConsistentIsAtLeastTwiceAsNearWhereItIsTheDefault) {
  const Vector reference = frequencies(ElementType::hex20, {16, 4, 3}, MassKind::consistent);
  const auto error = [&](ElementType type, const std::array<Index, 3>& cells, MassKind mass) {
    return (frequencies(type, cells, mass).array() / reference.array() - 1).abs().maxCoeff();
  };
  struct Case {
    ElementType type;
    std::array<Index, 3> cells;
  };
  for (const auto& [type, cells] :
       {Case{ElementType::hex20, {8, 2, 1}}, Case{ElementType::tet10, {10, 2, 2}}}) {
    const double lumped = error(type, cells, MassKind::lumped),
                 consistent = error(type, cells, MassKind::consistent);
    std::printf("%s: six lowest frequencies, lumped off by %.4f, consistent by %.4f\n",
                std::string(name(type)).c_str(), lumped, consistent);
    EXPECT_LT(2 * consistent, lumped) << name(type);
  }
}

}  // namespace
}  // namespace cbr::test::default_mass_test
