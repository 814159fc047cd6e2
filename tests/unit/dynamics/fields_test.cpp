// SPDX-License-Identifier: GPL-3.0-or-later
// The file of fields as docs/formats.md describes it: what a script or a viewer takes from it by
// name.
#include <gtest/gtest.h>

#include <Eigen/LU>

#include <cmath>
#include <fstream>

#include "common/files/hdf5_file.hpp"
#include "dynamics/output/field_grids.hpp"
#include "dynamics/program.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/dynamics/bricks.hpp"

namespace cbr::fields_test {
namespace {

constexpr double E = 100, nu = 0.25;

// A held and sheared brick, turned so that all components differ.
class Fields : public ::testing::Test {
 protected:
  Fields() {
    write_mesh(test::brick({4, 2, 3}, Vector3(1, 0.5, 0.6)), folder_ / "brick.msh");
    std::ofstream(folder_ / "scene.yaml")
        << "materials: {soft: {youngs_modulus: 100, poissons_ratio: 0.25, density: 1}}\n"
           "components: {brick: {mesh: brick.msh, material: soft, element: hex8}}\n"
           "instances: {a: {component: brick, as: mesh, rotation: [10, 20, 30]}}\n"
           "boundary: [{instance: a, nodes: x_min, fix: [x, y, z]}]\n"
           "loads: [{instance: a, surface: x_max, traction: [1, 2, -3]}]\n"
           "time: {end: 0.1}\noutput: {every: 0.05, fields: [displacement, stress]}\n";
    Report report("test", Verbosity::quiet);
    run_scene((folder_ / "scene.yaml").string(), folder_ / "r.h5", report);
  }

  test::TemporaryFolder folder_;
};

// VTK has the upper mid-edges before the upright ones.
TEST(FieldGrids, CellsOfSecondOrderComeInTheOrderOfVtk) {
  const auto order = [](ElementType type) {
    IndexTable nodes(1, n_nodes(type));
    for (Index i = 0; i < nodes.cols(); ++i) nodes(0, i) = i;
    const IndexTable vtk = vtk_order(nodes, type);
    EXPECT_EQ(vtk_order(vtk, type), nodes.leftCols(vtk.cols()));
    return std::vector<Index>(vtk.data(), vtk.data() + vtk.size());
  };
  EXPECT_EQ(order(ElementType::wedge15),
            (std::vector<Index>{0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11}));
  EXPECT_EQ(order(ElementType::hex27), (std::vector<Index>{0,  1,  2,  3,  4,  5,  6,  7,  8, 9, 10,
                                                           11, 16, 17, 18, 19, 12, 13, 14, 15}));
  EXPECT_EQ(order(ElementType::tet10).back(), 9);
}

// Gradient of a trilinear field at the centre of a hex8, du_i / dx_j: corner a has the reference
// position xi_a = +-1.
Matrix3 gradient_at_centre(const Points& X, const Points& u) {
  Points dN(8, 3);
  dN << -1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1;
  const Matrix3 dx = X.transpose() * dN, du = u.transpose() * dN;
  return du * dx.inverse();
}

TEST_F(Fields, EachStressHasItsNameAndIsHookesLawOfTheDisplacementsAtTheCentre) {
  const Hdf5Reader file(folder_ / "r.fields.h5");
  const Points X = file.read_points("/grids/0/points"),
               u = file.read_points("/steps/2/0/displacement");
  const IndexTable cells = file.read_index_table("/grids/0/cells");
  const auto stress = [&](const std::string& name) {
    return file.read_matrix("/steps/2/0/stress_" + name);
  };
  const Matrix xx = stress("xx"), yy = stress("yy"), zz = stress("zz"), xy = stress("xy"),
               yz = stress("yz"), xz = stress("xz"), von_mises = stress("von_mises");
  ASSERT_EQ(xx.rows(), cells.rows());
  for (Index e = 0; e < cells.rows(); ++e) {
    const Matrix3 grad =
        gradient_at_centre(X(cells.row(e), Eigen::all), u(cells.row(e), Eigen::all));
    const Matrix3 strain = 0.5 * (grad + grad.transpose());
    const Matrix3 sigma =
        E / (1 + nu) * (strain + nu / (1 - 2 * nu) * strain.trace() * Matrix3::Identity());
    const Matrix3 deviator = sigma - sigma.trace() / 3 * Matrix3::Identity();
    const double bound = 1e-12 * sigma.norm();
    EXPECT_NEAR(xx(e, 0), sigma(0, 0), bound);
    EXPECT_NEAR(yy(e, 0), sigma(1, 1), bound);
    EXPECT_NEAR(zz(e, 0), sigma(2, 2), bound);
    EXPECT_NEAR(xy(e, 0), sigma(0, 1), bound);
    EXPECT_NEAR(yz(e, 0), sigma(1, 2), bound);
    EXPECT_NEAR(xz(e, 0), sigma(0, 2), bound);
    EXPECT_NEAR(von_mises(e, 0), std::sqrt(1.5) * deviator.norm(), bound);
  }
}

TEST_F(Fields, FileTellsTimesNamesAndTheMeshsIds) {
  const Hdf5Reader file(folder_ / "r.fields.h5");
  EXPECT_EQ(file.read_string("/", "format_version"), "1.5");
  EXPECT_EQ(file.read_vector("/times"), Hdf5Reader(folder_ / "r.h5").read_vector("/time"));
  EXPECT_EQ(file.read_string("/grids/0", "instance"), "a");
  EXPECT_EQ(file.read_string("/grids/0", "topology"), "Hexahedron");
  const Mesh mesh = read_mesh(folder_ / "brick.msh");
  EXPECT_EQ(file.read_string("/grids/0", "name"), "a." + mesh.blocks[0].name);
  EXPECT_EQ(file.read_indices("/grids/0/element_ids"), mesh.blocks[0].element_ids);
  const std::vector<Index> ids = file.read_indices("/grids/0/node_ids");
  const IndexTable cells = file.read_index_table("/grids/0/cells");
  ASSERT_EQ(static_cast<Index>(ids.size()), file.shape("/grids/0/points")[0]);
  for (Index e = 0; e < cells.rows(); ++e)
    for (Index a = 0; a < 8; ++a)
      EXPECT_EQ(ids[cells(e, a)], mesh.node_ids[mesh.blocks[0].connectivity(e, a)]);
}

// Viewers name six components of one array each in their own order: there is no such array.
TEST_F(Fields, TextNamesScalarsOnly) {
  std::ifstream in(folder_ / "r.xdmf");
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  EXPECT_EQ(text.find("Tensor"), std::string::npos);
  for (const std::string name : {"xx", "yy", "zz", "xy", "yz", "xz", "von_mises"})
    EXPECT_SAYS(text, "Name=\"stress_" + name + "\" AttributeType=\"Scalar\" Center=\"Cell\"")
        << name;
}

}  // namespace
}  // namespace cbr::fields_test
