// SPDX-License-Identifier: GPL-3.0-or-later
// Decks of Abaqus and Nastran that include other files, also hostile ones.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <iomanip>
#include <sstream>

#include "common/scene/scene.hpp"
#include "sample_meshes.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/solve.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::deck_test {
namespace {

using test::refusal_of;
using test::TemporaryFolder;

const std::string nodes = "1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n",
                  tet = "*ELEMENT, TYPE=C3D4, ELSET=ALL\n1, 1, 2, 3, 4\n",
                  grid = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n";

std::filesystem::path put(const TemporaryFolder& folder, const std::string& name,
                          const std::string& text) {
  const auto file = folder / name;
  std::filesystem::create_directories(file.parent_path());
  test::write_bytes(file, text);
  return file;
}

const std::string
    of_scene = ": supports, loads, contact, damping and steps are the scene's",
    of_materials =
        ": not in this version; use linear elasticity, and compare output.stress with "
        "the yield stress",
    of_heat =
        ": not in this version; use contact[].interference for a shrink fit, and loads "
        "for other thermal strain";

TEST(Deck, includesAreReadInTheirPlace) {
  const TemporaryFolder folder;
  put(folder, "a/b/nodes.txt", nodes);
  put(folder, "a/b/tip.inp", "*NSET, NSET=TIP\n4\n");
  put(folder, "a/one.inp", "*include, input=\"b\\two.inp\"\n*NSET, NSET=ONE\n1\n");
  // b/tip.inp: from the folder of the deck's own file, where there is none beside two.inp
  put(folder, "a/b/two.inp", "*NODE, INPUT=nodes.txt\n*INCLUDE, INPUT=a/b/tip.inp\n");
  const std::string deck = "*INCLUDE,\n INPUT = a/one.inp\n" + tet;
  const auto file = put(folder, "deck.inp", deck + "*STEP\n*INCLUDE, INPUT=not there\n");
  const Mesh mesh = read_mesh(file);
  EXPECT_EQ(mesh.coordinates.rows(), 4);
  EXPECT_EQ(set_names(mesh), "TIP, ONE (nodesets)");
  EXPECT_EQ(mesh.dropped, "*STEP (line 5 and all after it)" + of_scene);
  std::vector<std::string> names;
  for (const auto& one : mesh_files(file)) names.push_back(one.lexically_relative(folder / ""));
  EXPECT_EQ(names, (std::vector<std::string>{"deck.inp", "a/one.inp", "a/b/two.inp",
                                             "a/b/nodes.txt", "a/b/tip.inp"}));

  put(folder, "in/grid.bdf", grid);
  put(folder, "in/all.bdf", "CTETRA,1,1,1,2,3,4\nINCLUDE grid.bdf\n");
  const auto bulk =
      put(folder, "deck.bdf", "BEGIN BULK\ninclude 'in/\n  all.bdf' $ all\nENDDATA\n");
  EXPECT_EQ(read_mesh(bulk).coordinates, mesh.coordinates);
  EXPECT_EQ(mesh_files(bulk).size(), 3U);
}

TEST(Deck, aMshOfAbaqusTextIsRecognised) {
  const TemporaryFolder folder;
  const auto file = put(folder, "all.msh", "\n** cgx\n*NODE, NSET=Nall\n" + nodes + tet);
  EXPECT_TRUE(may_hold_materials(file));
  EXPECT_EQ(read_mesh(file).blocks.at(0).name, "ALL");
  EXPECT_FALSE(may_hold_materials(put(folder, "new.msh", "$MeshFormat\n")));
}

TEST(Deck, theHashCoversIncludedFiles) {
  const TemporaryFolder folder;
  const auto file = put(folder, "deck.inp", "*INCLUDE, INPUT=n.inp\n" + tet);
  const auto alone = put(folder, "alone.inp", "*NODE\n" + nodes + tet);
  put(folder, "n.inp", "*NODE\n" + nodes);
  const std::string before = mesh_hash(file);
  put(folder, "n.inp", "*NODE\n" + nodes + "5, 9, 9, 9\n");
  EXPECT_NE(mesh_hash(file), before);
  EXPECT_EQ(mesh_hash(alone), file_hash(alone));
}

TEST(Deck, wedgesOfSecondOrder) {
  using test::element_points;
  const Points X = element_points(ElementType::wedge15, test::skew_corners(ElementType::wedge15));
  const TemporaryFolder folder;
  std::string inp = "*NODE\n", bdf;
  for (Index i = 0; i < 15; ++i) {
    std::ostringstream place;
    place << std::setprecision(17) << ", " << X(i, 0) << ", " << X(i, 1) << ", " << X(i, 2);
    inp += std::to_string(i + 1) + place.str() + "\n";
    bdf += "GRID," + std::to_string(i + 1) + "," + place.str() + "\n";
  }
  // Abaqus: the upper mid-edges, 13 to 15 here, before the vertical ones
  inp += "*ELEMENT, TYPE=C3D15\n1, 1,2,3,4,5,6,7,8,9,13,14,15,10,11,12\n*SURFACE, NAME=S\n1, S2\n";
  bdf += "CPENTA,1,7,1,2,3,4,5,6,\n,7,8,9,10,11,12,13,14,\n,15\n";
  for (const auto& file : {put(folder, "w.inp", inp), put(folder, "w.bdf", bdf)}) {
    const Mesh mesh = read_mesh(file);
    ASSERT_EQ(mesh.blocks.at(0).type, ElementType::wedge15);
    for (Index i = 0; i < 15; ++i)
      EXPECT_EQ(mesh.coordinates.row(mesh.blocks[0].connectivity(0, i)), X.row(i)) << file << i;
    if (!mesh.sidesets.empty()) EXPECT_EQ(mesh.sidesets[0].sides.at(0).side, 5);
  }
  const auto cut = put(folder, "cut.bdf", "GRID,1\nCPENTA,1,7,1,2,3,4,5,6,\n,,8\n");
  EXPECT_SAYS(refusal_of([&] { read_mesh(cut); }), "has 6 points");
}

// The mesh as a deck of solids of this word, with the lines of its material.
std::string deck_text(const Mesh& mesh, const std::string& word, const std::string& material) {
  std::ostringstream text;
  text << std::setprecision(17) << "*NODE\n";
  for (Index i = 0; i < mesh.coordinates.rows(); ++i)
    text << i + 1 << ", " << mesh.coordinates(i, 0) << ", " << mesh.coordinates(i, 1) << ", "
         << mesh.coordinates(i, 2) << "\n";
  text << "*ELEMENT, TYPE=" << word << ", ELSET=E\n";
  const Block& block = mesh.blocks[0];
  const Index n = block.connectivity.cols(), n_upper = n > 8 ? n_corners(block.type) / 2 : 0;
  for (Index e = 0; e < block.connectivity.rows(); ++e) {
    text << e + 1;
    for (Index i = 0; i < n; ++i) {
      const Index moved = i < n - 2 * n_upper ? i : i < n - n_upper ? i + n_upper : i - n_upper;
      text << "," << (i == 10 ? "\n" : " ") << block.connectivity(e, moved) + 1;
    }
    text << "\n";
  }
  return text.str() + "*MATERIAL, NAME=M\n*DENSITY\n7.8e-9\n" + material;
}

// Of a deck whose nodes at x = 0 are fixed.
struct Answers {
  Vector3 tip;           // displacement of the corner (4, 1, 1) under the force (100, 200, -300)
  double frequency = 0;  // lowest, of consistent mass, Hz
};

Answers answers(const std::filesystem::path& deck) {
  Component component;
  component.mesh = deck;
  const Mesh mesh = read_mesh(component);
  auto properties = block_properties(Scene(), component, mesh);
  properties[0].reduced_mass = true;
  const auto fixed = [](const Vector3& x, int) { return std::abs(x[0]) < 1e-9; };
  const auto model = assemble(mesh, properties, MassKind::lumped);
  const auto dofs = test::free_dofs(mesh, model, fixed);
  Index tip = 0;
  mesh.coordinates.rowwise().sum().maxCoeff(&tip);
  Matrix load = Matrix::Zero(model.K.rows(), 1);
  load.middleRows<3>(3 * tip) << 100, 200, -300;
  Matrix u = Matrix::Zero(model.K.rows(), 1);
  const Matrix found = SparseCholesky(test::submatrix(model.K, dofs)).solve(Matrix(load(dofs, 0)));
  u(dofs, 0) = found;
  return {u.middleRows<3>(3 * tip),
          test::frequencies(mesh, properties[0], MassKind::consistent, fixed, 1)(0)};
}

// References: CalculiX 2.20, *STATIC and *FREQUENCY, its seven digits. Its mass of C3D8R has
// rank 1.
TEST(Deck, solidsHaveTheAnswersOfCalculix) {
  const auto skew = [](const Vector3& x) -> Vector3 {
    return {x[0] * (1 + 0.025 * x[1] * x[2]), x[1] + 0.05 * x[0] * x[2], x[2] - 0.04 * x[0] * x[1]};
  };
  const auto sheared = [](const Vector3& x) -> Vector3 {
    return {x[0], x[1] + 0.3 * x[0], x[2] - 0.1 * x[0] + 0.2 * x[1]};
  };
  const std::string steel = "*ELASTIC\n210000, 0.3\n*SOLID SECTION, ELSET=E, MATERIAL=M\n",
                    wood =
                        "*ELASTIC, TYPE=ENGINEERING CONSTANTS\n"
                        "130000, 9000, 11000, 0.3, 0.28, 0.4, 5000, 4000,\n3000, 293\n"
                        "*ORIENTATION, NAME=O, SYSTEM=RECTANGULAR\n1, 1, 0.2, -1, 1, 0.3\n3, 0\n"
                        "*SOLID SECTION, ELSET=E, MATERIAL=M, ORIENTATION=O\n";
  struct Case {
    std::string word;
    ElementType type;
    std::string material;
    Answers of_calculix;
  };
  const TemporaryFolder folder;
  for (const auto& [word, type, material, expected] : std::vector<Case>{
           {"C3D20R",
            ElementType::hex20,
            steel,
            {{1.345232e-2, 3.104607e-1, -5.414081e-1}, 49675.48}},
           {"C3D20",
            ElementType::hex20,
            steel,
            {{1.103062e-2, 2.973541e-1, -5.159432e-1}, 49989.56}},
           {"C3D15",
            ElementType::wedge15,
            steel,
            {{1.199271e-2, 2.916974e-1, -5.100012e-1}, 49988.66}},
           {"C3D8R", ElementType::hex8, steel, {{-1.194250e-1, 5.758413e-1, -8.490110e-1}}},
           {"C3D20", ElementType::hex20, wood, {{-8.968994e-2, 3.580942, -6.670300}}}}) {
    SCOPED_TRACE(word + material);
    const Mesh mesh = word == "C3D8R" ? test::box_mesh(type, {4, 2, 2}, Vector3(4, 1, 1), sheared)
                                      : test::box_mesh(type, {4, 2, 2}, Vector3(4, 1, 1), skew);
    const Answers found = answers(put(folder, "box.inp", deck_text(mesh, word, material)));
    EXPECT_LT((found.tip - expected.tip).norm(), 1e-6 * expected.tip.norm())
        << found.tip.transpose();
    if (expected.frequency > 0) EXPECT_NEAR(found.frequency / expected.frequency, 1, 1e-6);
  }
}

TEST(Deck, blocksOfReducedIntegrationAreMarked) {
  const TemporaryFolder folder;
  const Mesh box = test::box_mesh(ElementType::hex8, {2, 1, 1}, Vector3(2, 1, 1));
  std::string text = deck_text(box, "C3D8R", "*SOLID SECTION, ELSET=E, MATERIAL=M\n");
  const Mesh mesh = read_mesh(put(folder, "one.inp", text));
  EXPECT_EQ(mesh.blocks.at(0).name, "E");
  EXPECT_TRUE(mesh.blocks[0].reduced);
  const auto second = text.find("\n2,", text.find("*ELEMENT")) + 1;
  text.insert(second, "*ELEMENT, TYPE=C3D8I, ELSET=E\n");
  const Mesh two = read_mesh(put(folder, "two.inp", text));
  ASSERT_EQ(two.blocks.size(), 2U);
  EXPECT_EQ(two.blocks[0].name, "E_reduced");
  EXPECT_EQ(two.blocks[1].name, "E");
  EXPECT_FALSE(two.blocks[1].reduced);
  // The scene's word counts more than the letters
  Scene scene;
  scene.materials["steel"] = {2.1e5, 0.3, 7.8e-9};
  Component component;
  component.material = "steel";
  EXPECT_EQ(block_properties(scene, component, mesh)[0].hex, HexFormulation::reduced);
  component.element = HexFormulation::incompatible;
  EXPECT_EQ(block_properties(scene, component, mesh)[0].hex, HexFormulation::incompatible);
}

TEST(Deck, engineeringConstantsThatAreOfNoUseAreNamed) {
  const std::string elastic = "*ELASTIC, TYPE=ENGINEERING CONSTANTS\n",
                    good = "9, 9, 9, 0.3, 0.3, 0.3, 3, 3,\n3\n",
                    section = "*SOLID SECTION, ELSET=E, MATERIAL=M, ORIENTATION=O\n";
  const Mesh box = test::box_mesh(ElementType::hex8, {1, 1, 1}, Vector3(1, 1, 1));
  const TemporaryFolder folder;
  for (const auto& [material, words] : std::vector<std::pair<std::string, std::string>>{
           {elastic + "9, 9, 9, 0.3, 0.3, 0.3, 3, 3\n*ORIENTATION, NAME=O\n1,0,0,0,1,0\n",
            "has 8 of nine engineering constants"},
           {elastic + "9, 9, 9, 0.9, 0.9, 0.9, 3, 3,\n3\n*ORIENTATION, NAME=O\n1,0,0,0,1,0\n",
            "with which strains exist that give energy"},
           {elastic + good +
                "9, 9, 9, 0.3, 0.3, 0.3, 3, 3,\n3\n*ORIENTATION, NAME=O\n1,0,0,0,1,0\n",
            "depends on the temperature"},
           {elastic + good + "*ORIENTATION, NAME=O\n1, 0, 0, 2, 0, 0\n", "on one line"},
           {elastic + good + "*ORIENTATION, NAME=O, SYSTEM=SPHERICAL\n0,0,0,0,0,1\n",
            "has an *ORIENTATION of SYSTEM=SPHERICAL (read are rectangular and cylindrical"},
           {elastic + good + "*ORIENTATION, NAME=O, SYSTEM=CYLINDRICAL\n0,0,1,0,0,1\n",
            "on one line"},
           {elastic + good + "*ORIENTATION, NAME=O\n1,0,0,0,1,0\n3, 45\n",
            "with a rotation about one of its axes"},
           {elastic + good + "*ORIENTATION, NAME=O\n1, 0, 0\n", "six numbers"},
           {elastic + good + "*ORIENTATION, NAME=O\nDI\n", "of a *DISTRIBUTION"},
           {elastic + good, "there is no *ORIENTATION 'O'"}}) {
    const auto deck = put(folder, "box.inp", deck_text(box, "C3D8", material + section));
    const std::string message = refusal_of([&] { answers(deck); });
    EXPECT_SAYS(message, words);
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

// Lekhnitskii, Anisotropic Plates (1968), section 26: a ring in plane stress under the pressure p
// inside has u = A r^k + B r^-k with k^2 = E_2 / E_1. nu_13 = nu_23 = 0: plane stress in 3D, too.
TEST(Deck, aRingIsOrthotropicInCylindricalAxes) {
  const double a = 1, b = 2, E_1 = 1000, E_2 = 4000, nu = 0.3, k = std::sqrt(E_2 / E_1), p = 1;
  const Vector3 center(0.3, -0.2, 5);
  const auto bend = [&](const Vector3& x) -> Vector3 {  // of the radius, angle and height
    return center + Vector3(x[0] * std::cos(x[1]), x[0] * std::sin(x[1]), x[2]);
  };
  // sigma_r = E_1 / (1 - nu nu_21) (u' + nu_21 u / r), -p at a and 0 at b
  const double nu_21 = nu * E_2 / E_1, C = E_1 / (1 - nu * nu_21);
  const auto stress = [&](double m, double r) { return C * (m + nu_21) * std::pow(r, m - 1); };
  Eigen::Matrix2d rows;
  rows << stress(k, a), stress(-k, a), stress(k, b), stress(-k, b);
  const Eigen::Vector2d AB = rows.inverse() * Eigen::Vector2d(-p, 0);
  const auto u_r = [&](double r) { return AB[0] * std::pow(r, k) + AB[1] * std::pow(r, -k); };
  const std::string material =
      "*ELASTIC, TYPE=ENGINEERING CONSTANTS\n1000, 4000, 3000, 0.3, 0, 0, 800, 900,\n700\n"
      "*ORIENTATION, NAME=O, SYSTEM=CYLINDRICAL\n0.3, -0.2, 7, 0.3, -0.2, 9\n"
      "*SOLID SECTION, ELSET=E, MATERIAL=M, ORIENTATION=O\n";
  const TemporaryFolder folder;
  for (const auto& [word, type, worst] :
       {std::tuple{"C3D20", ElementType::hex20, 2e-3}, {"C3D8I", ElementType::hex8, 4e-3}}) {
    const Mesh mesh = test::box_mesh(type, {8, 8, 1}, Vector3(1, std::numbers::pi / 2, 0.2),
                                     [&](const Vector3& x) { return bend(x + Vector3(a, 0, 0)); });
    Component component;
    component.mesh = put(folder, "ring.inp", deck_text(mesh, word, material));
    const Mesh read = read_mesh(component);
    const auto properties = block_properties(Scene(), component, read);
    const auto model = assemble(read, properties, MassKind::lumped);
    const auto out_of = [&](Index i) -> Vector3 {  // from the axis to a node
      const Vector3 x = read.coordinates.row(model.nodes[i]).transpose() - center;
      return {x[0], x[1], 0};
    };
    Vector exact(model.K.rows());
    for (Index i = 0; i < static_cast<Index>(model.nodes.size()); ++i)
      exact.segment<3>(3 * i) = u_r(out_of(i).norm()) * out_of(i).normalized();
    // Given are the displacements inside and those across planes of symmetry
    const auto dofs = test::free_dofs(read, model, [&](const Vector3& x, int c) {
      const Vector3 arm = x - center;
      return std::abs(arm[c]) < 1e-9 || (c < 2 && arm.head<2>().norm() < a + 1e-9);
    });
    Vector u = exact;
    u(dofs).setZero();
    const Vector load = -(model.K * u);
    const Vector found = SparseCholesky(test::submatrix(model.K, dofs)).solve(Matrix(load(dofs)));
    u(dofs) = found;
    const double off = (u - exact).cwiseAbs().maxCoeff();
    EXPECT_LT(off, worst * u_r(a)) << word;
  }
}

TEST(Deck, constraintsOfDecksAreReferencePoints) {
  const TemporaryFolder folder;
  const std::string solid = grid + "CTETRA,1,1,1,2,3,4\nGRID,9,,2.,0.,0.\nGRID,10,,0.,3.,0.\n",
                    rigid = "RBE2,5,9,123456,2,3,4,,\n,1.2e-5\n",
                    average = "RBE3,6,,10,123456,1.,123,2,3\n,4,1.,123,1,,,\n";
  const Mesh mesh =
      read_mesh(put(folder, "a.bdf",
                    solid + rigid + average + "PARAM,WTMASS,2.\nCONM2,7,9,0,2.5,,,,,\n," +
                        "4.,1.,5.,2.,3.,6.\nCONM2,8,9,-1,1.,1.,1.,1.\nCONM2,3,9,,.5\n"));
  EXPECT_EQ(mesh.dropped, "");
  EXPECT_EQ(mesh.nodesets.at(find_nodeset(mesh, "rbe2_5")).nodes, (std::vector<Index>{1, 2, 3}));
  EXPECT_EQ(mesh.nodesets.at(find_nodeset(mesh, "rbe3_6")).nodes.size(), 4U);
  ASSERT_EQ(mesh.points.size(), 3U);
  const MeshPoint &nine = mesh.points.at("node_9"), &ten = mesh.points.at("node_10"),
                  &beside = mesh.points.at("mass_8");
  EXPECT_TRUE(nine.nodes == "rbe2_5" && nine.rigid && *nine.at == Vector3(2, 0, 0));
  EXPECT_EQ(nine.mass, 6);  // times WTMASS
  Matrix3 J;
  J << 8, -2, -4, -2, 10, -6, -4, -6, 12;
  EXPECT_EQ(nine.inertia, J);
  EXPECT_TRUE(ten.nodes == "rbe3_6" && !ten.rigid && ten.mass == 0);
  EXPECT_TRUE(beside.nodes == "rbe2_5" && !beside.rigid && *beside.at == Vector3(1, 1, 1));
  EXPECT_EQ(beside.mass, 2);
  // A node of an element moves with its own rigid set
  const Mesh own = read_mesh(put(folder, "b.bdf", solid + "RBE2,5,1,123,2,3\n"));
  EXPECT_EQ(own.nodesets.at(find_nodeset(own, "rbe2_5")).nodes.size(), 3U);

  const std::string surface = "*SURFACE, NAME=Top\n1, S3\n",
                    body = "*NSET, NSET=Foot\n1, 2, 3\n*RIGID BODY, NSET=FOOT, REF NODE=10\n",
                    masses =
                        "*ELEMENT, TYPE=MASS, ELSET=HEAVY\n7, 9\n*MASS, ELSET=HEAVY\n2.5,\n"
                        "*ELEMENT, TYPE=ROTARYI, ELSET=TURNS\n8, 9\n*ROTARY INERTIA, ELSET=TURNS\n"
                        "4, 5, 6, -1, -2, -3\n";
  const auto inp = [&](const std::string& cards) {
    return put(folder, "a.inp", "*NODE\n" + nodes + "9, 2\n10, 0, 3\n" + tet + surface + cards);
  };
  const std::string coupling = "*COUPLING, REF NODE=9, SURFACE=TOP, CONSTRAINT NAME=C\n";
  const Mesh deck = read_mesh(inp(coupling + "*KINEMATIC\n1, 3\n" + body + masses));
  ASSERT_EQ(deck.points.size(), 2U);
  EXPECT_EQ(deck.dropped, "");
  const MeshPoint& top = deck.points.at("node_9");
  EXPECT_TRUE(top.nodes == "Top" && top.rigid && *top.at == Vector3(2, 0, 0) && top.mass == 2.5);
  EXPECT_EQ(top.inertia, J / 2);
  EXPECT_TRUE(deck.points.at("node_10").nodes == "Foot" && deck.points.at("node_10").rigid);
  EXPECT_EQ(deck.points.at("node_10").line, 17);
  EXPECT_FALSE(read_mesh(inp(coupling + "*DISTRIBUTING\n")).points.at("node_9").rigid);
  const std::string distribution =
      "*ELEMENT, TYPE=DCOUP3D, ELSET=D\n7, 9\n*DISTRIBUTING COUPLING, ELSET=D\n1, 2.\n";
  const Mesh old = read_mesh(inp("*NSET, NSET=Foot\n2, 3\n" + distribution + "FOOT, 2.\n"));
  EXPECT_TRUE(!old.points.at("node_9").rigid && *old.points.at("node_9").at == Vector3(2, 0, 0));
  EXPECT_EQ(old.points.at("node_9").nodes, "distributing_D");
  EXPECT_EQ(old.nodesets.at(find_nodeset(old, "distributing_D")).nodes.size(), 3U);
  // Nodes and sets of an assembly have numbers of their own
  const Mesh cae = read_mesh(put(folder, "cae.inp",
                                 "*PART, NAME=P\n*NODE\n" + nodes + tet +
                                     "*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, "
                                     "PART=P\n*END INSTANCE\n*NODE\n1, 7, 8, 9\n*NSET, "
                                     "NSET=RP\n1,\n*ELSET, ELSET=S, INSTANCE=I\n"
                                     "1,\n*SURFACE, NAME=Top\nS, S3\n*ELEMENT, TYPE=MASS, "
                                     "ELSET=HEAVY\n1, 1\n*MASS, ELSET=HEAVY\n"
                                     "3,\n*COUPLING, CONSTRAINT NAME=C, REF NODE=RP, "
                                     "SURFACE=Top\n*KINEMATIC\n*END ASSEMBLY\n"));
  EXPECT_EQ(*cae.points.at("node_1").at, Vector3(7, 8, 9));
  EXPECT_EQ(cae.points.at("node_1").mass, 3);

  for (const auto& [cards, words] : std::vector<std::pair<std::string, std::string>>{
           {"RBE2,5,9,12,2,3\n", "a.bdf:8: RBE2: 5 has CM = 12, expected 123456, or 123"},
           {"RBE2,5,9,123,2,10\n", "a.bdf:8: node 10 of 'rbe2_5' is a node of no element"},
           {"RBE2,5,99,123,2,3\n", "a.bdf:8: node 99 of 'rbe2_5' is no GRID"},
           {rigid + "RBE2,6,9,123,1\n", "a.bdf:10: node 9 is the reference of line 8 too"},
           {"RBE3,6,,9,123,1.,123,2,3\n", "6 has REFC = 123, expected 123456"},
           {"RBE3,6,,9,123456,1.,123,2,2.,\n,123,3\n", "6 has a weight = 2., expected 1."},
           {"RBE3,6,,9,123456,1.,12,2,3\n", "6 has components = 12, expected 123"},
           {"RBE3,6,,9,123456,1.,123,2,3,\n,UM,2,3\n", "6 has UM, which is not read"},
           {"RBE3,6,,1,123456,1.,123,2,3\n", "node 1 of 'rbe3_6' is a node of an element"},
           {"CONM2,7,1,,2.\n", "a.bdf:8: a mass on node 1 found, expected"},
           {rigid + "CONM2,7,9,4,2.\n", "7 has coordinate system 4"},
           {rigid + "CONM2,7,9,,-2.\n", "a.bdf:10: is no mass"},
           {rigid + "CONM2,7,9,,2.,,,,,\n,1.,2.,1.,,,1.\n", "a positive definite inertia"}}) {
    const auto file = put(folder, "a.bdf", solid + cards);
    const std::string message = refusal_of([&] { read_mesh(file); });
    EXPECT_SAYS(message, words) << words;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  for (const auto& [cards, words] : std::vector<std::pair<std::string, std::string>>{
           {coupling, "a.inp:12: *COUPLING without *KINEMATIC or *DISTRIBUTING"},
           {"*KINEMATIC\n", "a.inp:12: *KINEMATIC without the *COUPLING before it"},
           {coupling + "*KINEMATIC\n1, 2\n",
            "a.inp:12: *COUPLING joins some of the motions 1 to 3"},
           {coupling + "*DISTRIBUTING\n1, 3\n",
            "a.inp:12: *COUPLING joins some of the motions 1 to 6"},
           {coupling + "*DISTRIBUTING, WEIGHTING METHOD=LINEAR\n", "WEIGHTINGMETHOD=LINEAR found"},
           {coupling + "*KINEMATIC\n0, 2\n", "from 1 to 6"},
           {"*COUPLING, REF NODE=9, SURFACE=NO\n*KINEMATIC\n", "there is no set 'NO'"},
           {distribution + "2, 1.\n", "a.inp:16: unequal weights found"},
           {distribution + "2, -1.\n", "a.inp:16: weight -1. found, expected above 0"},
           {"*DISTRIBUTING COUPLING, ELSET=NO\n1, 1.\n", "without ELSET= of one element DCOUP3D"},
           {masses + "*DISTRIBUTING COUPLING, ELSET=HEAVY\n1,\n", "one element DCOUP3D"},
           {"*COUPLING, REF NODE=99, SURFACE=TOP\n*KINEMATIC\n", "no reference node 99"},
           {"*COUPLING, REF NODE=1, SURFACE=TOP\n*KINEMATIC\n", "node 1 is a node of an element"},
           {"*COUPLING, REF NODE=X, SURFACE=TOP\n*KINEMATIC\n", "there is no node set 'X'"},
           {"*COUPLING, SURFACE=TOP\n*KINEMATIC\n", "a.inp:12: *COUPLING without REF NODE="},
           {"*RIGID BODY, ELSET=ALL, REF NODE=9\n", "use instances.NAME.as: rigid"},
           {masses, "a.inp:15: a mass on node 9 found, expected"},
           {"*MASS, ELSET=NO\n1,\n", "there is no element set 'NO'"},
           {"*MASS, ELSET=ALL, TYPE=ANISOTROPIC\n1,\n", "*MASS has TYPE"}}) {
    const auto file = inp(cards);
    const std::string message = refusal_of([&] { read_mesh(file); });
    EXPECT_SAYS(message, words) << words;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

// The orders of vtkCellType.h, in which programs write; wedges look outwards by their first three
// nodes.
TEST(Deck, solidsOfVtkAreInItsOrder) {
  using test::element_points;
  const TemporaryFolder folder;
  struct Case {
    ElementType type;
    int number;
    std::vector<int> order;  // of Exodus at each place of VTK
  };
  for (const auto& [type, number, order] : std::vector<Case>{
           {ElementType::tet10, 24, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}},
           {ElementType::wedge6, 13, {0, 2, 1, 3, 5, 4}},
           {ElementType::wedge6, 13, {0, 1, 2, 3, 4, 5}},
           {ElementType::wedge15, 26, {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11}},
           {ElementType::wedge15, 26, {0, 2, 1, 3, 5, 4, 8, 7, 6, 14, 13, 12, 9, 11, 10}},
           {ElementType::hex20, 25, {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,
                                     10, 11, 16, 17, 18, 19, 12, 13, 14, 15}},
           {ElementType::hex27, 29, {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 16, 17,
                                     18, 19, 12, 13, 14, 15, 23, 24, 25, 26, 21, 22, 20}}}) {
    const Points X = element_points(type, test::skew_corners(type));
    std::ostringstream text;
    text << std::setprecision(17) << "# vtk DataFile Version 2.0\nx\nASCII\nDATASET "
         << "UNSTRUCTURED_GRID\nPOINTS " << X.rows() << " double\n";
    for (const int a : order) text << X.row(a) << "\n";
    text << "CELLS 1 " << X.rows() + 1 << "\n" << X.rows();
    for (Index a = 0; a < X.rows(); ++a) text << " " << a;
    text << "\nCELL_TYPES 1\n" << number << "\n";
    const Mesh mesh = read_mesh(put(folder, "a.vtk", text.str()));
    ASSERT_EQ(mesh.blocks.at(0).type, type);
    const Points found = mesh.coordinates(mesh.blocks[0].connectivity.row(0), Eigen::all);
    EXPECT_LT((found - X).norm(), 1e-12) << number << "\n" << found - X;
  }
}

TEST(Deck, hostileIncludesAreOneLine) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "folder");
  ASSERT_EQ(mkfifo((folder / "fifo").c_str(), 0600), 0);
  put(folder, "self.inp", "\n*INCLUDE, INPUT=self.inp\n");
  put(folder, "ring.inp", "*INCLUDE, INPUT=folder/back.inp\n");
  put(folder, "folder/back.inp", "*HEADING\n*INCLUDE, INPUT=../ring.inp\n");
  std::filesystem::create_symlink("self.inp", folder / "link.inp");
  // Each of twenty files includes the next one twice: a million
  for (int i = 0; i < 20; ++i) {
    const std::string next = "*INCLUDE, INPUT=bomb" + std::to_string(i + 1) + "\n";
    put(folder, "bomb" + std::to_string(i), next + next);
  }
  put(folder, "bomb20", "");
  put(folder, "bad.inp", "*NODE\n1, 0, 0, x\n");
  put(folder, "binary.inp", std::string("*NODE\n\0\0", 8));
  put(folder, "sets.inp", "*SURFACE, NAME=S\n7, S1\n");
  for (const auto& [name, words] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {"missing.inp", {"deck.inp:2: ", "missing.inp: no such file", "give its path"}},
           {"", {"deck.inp:2: ", "without the name"}},
           {"folder", {"deck.inp:2: ", "not a regular file"}},
           {"fifo", {"deck.inp:2: ", "not a regular file"}},
           {"/dev/zero", {"deck.inp:2: ", "/dev/zero: is not a regular file"}},
           {"deck.inp", {"deck.inp:2: ", "includes itself"}},
           {"self.inp", {"self.inp:2: ", "includes itself"}},
           {"link.inp", {"link.inp:2: ", "includes itself"}},
           {"ring.inp", {"folder/back.inp:2: ", "ring.inp includes itself"}},
           {"bomb0", {"bomb", "more than 1000 files"}},
           {"bad.inp", {"bad.inp:2: ", "finite number"}},
           {"binary.inp", {"binary.inp:2: ", "is no text"}},
           {"sets.inp", {"sets.inp:2: ", "element 7 of surface 'S'"}}}) {
    const auto file =
        put(folder, "deck.inp", "*HEADING\n*INCLUDE, INPUT=" + name + "\n*NODE\n" + nodes + tet);
    const std::string message = refusal_of([&] { read_mesh(file); });
    for (const std::string& word : words) EXPECT_SAYS(message, word) << name;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  const auto bulk = put(folder, "deck.bdf", "INCLUDE 'deck.bdf'\n");
  EXPECT_SAYS(refusal_of([&] { read_mesh(bulk); }), "deck.bdf:1: INCLUDE: ");
  put(folder, "g.bdf", grid + "GRID,5,,0.,0.,1.x\n");
  put(folder, "deck.bdf", "INCLUDE 'g.bdf'\nCTETRA,1,1,1,2,3,4\n");
  EXPECT_SAYS(refusal_of([&] { read_mesh(bulk); }), "g.bdf:5: GRID: '1.x' found");
}

TEST(Deck, cardsOfNastranThatAreNotReadAreListed) {
  const TemporaryFolder folder;
  const auto deck = [&](const std::string& cards) {
    return read_mesh(
        put(folder, "deck.bdf",
            "BEGIN BULK\n" + grid + "CTETRA,1,1,1,2,3,4\nPSOLID,1,7\n" + cards + "ENDDATA\n"));
  };
  const std::string steel = "MAT1,7,2.1e11,,.3,7850.\n";
  EXPECT_EQ(deck(steel + "CORD2R,4,,0.,0.,0.\nPARAM,POST,-1\nSET1,3,1,2\n").dropped, "");
  EXPECT_EQ(deck(steel + "CBAR,2,9,1,2,0.,0.,1.\nDMIG,K,0,6,1\nMATS1,7,,PLASTIC\nDMIG,K,1,1\n" +
                 "CYJOIN,1,,5\nPARAM,G,.02\n")
                .dropped,
            "CBAR (line 9), DMIG (line 10, and 1 more): not in this version; MATS1 (line 11)" +
                of_materials +
                "; CYJOIN (line 13): cyclic symmetry is not in this version; mesh the whole part; "
                "PARAM,G (line 14)" +
                of_scene);
  EXPECT_EQ(deck("MAT1,7,2.1e11,,.3,7850.,1.2e-5,20.,.01\n").dropped,
            "GE of MAT1 (line 8)" + of_scene);
  put(folder, "more.bdf", "CELAS9,1\n");
  EXPECT_EQ(deck(steel + "INCLUDE 'more.bdf'\n").dropped,
            "CELAS9 (" + (folder / "more.bdf").string() + ":1): not in this version");
  EXPECT_EQ(deck("MAT11,7,1.e9\n").blocks.at(0).material->problem, "is a MAT11, not supported");
  EXPECT_EQ(deck("MAT11,8,1.e9\n" + steel).blocks.at(0).material->problem, "");
  // gmsh writes curves as bars
  EXPECT_EQ(read_mesh(put(folder, "deck.bdf",
                          "$ Created by Gmsh\n" + grid +
                              "CTETRA,1,1,1,2,3,4\nCBAR,2,9,1,2,0.,0.,1.\nENDDATA\n"))
                .dropped,
            "");
}

TEST(Deck, eachKeywordThatIsNotReadHasItsReason) {
  const TemporaryFolder folder;
  const auto dropped = [&](const std::string& words) {
    return read_mesh(put(folder, "deck.inp", "*NODE\n" + nodes + tet + words)).dropped;
  };
  EXPECT_EQ(dropped("*PLASTIC\n300, 0\n*Pre-Tension Section\n*Cyclic Hardening\n*FILM\n*BOUNDARY\n"
                    "*EXPANSION\n1e-5\n"),
            "*PLASTIC (line 8), *CYCLIC HARDENING (line 11)" + of_materials +
                "; *PRE-TENSION SECTION (line 10), *BOUNDARY (line 13)" + of_scene +
                "; *FILM (line 12): not in this version; *EXPANSION (line 14)" + of_heat);
}

TEST(Deck, keywordsThatChangeThePartAreRefused) {
  const TemporaryFolder folder;
  const std::string whole = "*NODE\n" + nodes + tet, step = "*STEP\n*STATIC\n";
  const auto deck = [&](const std::string& text) { return put(folder, "deck.inp", whole + text); };
  for (const auto& [text, words] : std::vector<std::pair<std::string, std::string>>{
           {"*MATRIX INPUT, NAME=K, INPUT=k.mtx\n", "deck.inp:8: *MATRIX INPUT found: not in this"},
           {"*USER ELEMENT, TYPE=U1, NODES=2\n", "deck.inp:8: *USER ELEMENT found: not in this"},
           {"*MODEL CHANGE, TYPE=ELEMENT, REMOVE\nALL\n", "deck.inp:8: *MODEL CHANGE found: not"},
           {"*TIE, CYCLIC SYMMETRY, NAME=T\nA, B\n", "deck.inp:8: *TIE found: cyclic symmetry"},
           {step + "*Model Change, type=element, remove\nALL\n*END STEP\n",
            "deck.inp:10: *MODEL CHANGE found: not"}}) {
    const auto file = deck(text);
    const std::string message = refusal_of([&] { read_mesh(file); });
    EXPECT_SAYS(message, words);
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_NO_THROW(
      read_mesh(deck(step + "*MODEL CHANGE, TYPE=CONTACT PAIR, REMOVE\nA, B\n*END STEP\n")));
}

TEST(Deck, aSetMayNameAnElementTwice) {
  const TemporaryFolder folder;
  const std::string whole = "*NODE\n" + nodes + tet, twice = "*ELSET, ELSET=TWICE\n1, 1\n",
                    material = "*MATERIAL, NAME=M\n*ELASTIC\n1., .3\n",
                    section = "*SOLID SECTION, ELSET=TWICE, MATERIAL=M\n";
  const Mesh mesh = read_mesh(put(folder, "deck.inp", whole + twice + material + section));
  EXPECT_EQ(mesh.blocks.at(0).name, "TWICE");
  const auto two =
      put(folder, "two.inp",
          whole + twice + material + section + "*SOLID SECTION, ELSET=ALL, MATERIAL=M\n");
  EXPECT_SAYS(refusal_of([&] { read_mesh(two); }), "element 1 has two sections");
}

TEST(Deck, surfacesOfShellsHaveTwoFaces) {
  const TemporaryFolder folder;
  const std::string shells =
                        "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 1, 1, 0\n"
                        "*ELEMENT, TYPE=S3, ELSET=PLATE\n1, 1, 2, 3\n2, 2, 4, 3\n",
                    top = "*SURFACE, NAME=TOP\nPLATE, SPOS\n",
                    under = "*SURFACE, NAME=UNDER\n2, SNEG\n";
  const Mesh mesh = read_mesh(put(folder, "deck.inp", shells + top + under));
  ASSERT_EQ(mesh.sidesets.size(), 2U);
  const std::vector<Side> both = mesh.sidesets[0].sides, one = mesh.sidesets[1].sides;
  ASSERT_EQ(both.size(), 2U);
  ASSERT_EQ(one.size(), 1U);
  EXPECT_EQ(nodes_of_side(mesh, both[0]), (std::vector<Index>{0, 1, 2}));
  EXPECT_EQ(both[1].side, 1);
  EXPECT_EQ(one[0].side, 2);
  // Of shells S1 and S2 are these faces and edges follow, of plane elements all are edges
  const auto side = [&](const std::string& text, const std::string& label) {
    return read_mesh(put(folder, "s.inp", text + "*SURFACE, NAME=S\n1, " + label + "\n"))
        .sidesets.at(0)
        .sides.at(0)
        .side;
  };
  std::string plane = shells;
  plane.replace(plane.find("S3"), 2, "CPS3");
  EXPECT_EQ(side(shells, "S1"), 2);
  EXPECT_EQ(side(shells, "S2"), 1);
  EXPECT_EQ(side(shells, "S3"), 3);
  EXPECT_EQ(side(plane, "S1"), 3);
  EXPECT_EQ(side(plane, "S3"), 5);
  const auto solid =
      put(folder, "deck.inp", "*NODE\n" + nodes + tet + "*SURFACE, NAME=S\n1, SPOS\n");
  EXPECT_SAYS(refusal_of([&] { read_mesh(solid); }), "SPOS, SNEG of a shell");
}

}  // namespace
}  // namespace cbr::deck_test
