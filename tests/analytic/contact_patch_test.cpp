// SPDX-License-Identifier: GPL-3.0-or-later
// The contact patch test (Taylor and Papadopoulos 1991): two blocks with meshes that do not match,
// pressed together by a uniform pressure, must be strained uniformly. Both stand on planes of
// symmetry without friction, so that each is free to grow sidewards.
#include <gtest/gtest.h>

#include <cstdio>

#include "common/linalg/dense.hpp"
#include "common/mesh/surface.hpp"
#include "dynamics/contact/search/mortar.hpp"
#include "dynamics/setup/components/contact_faces.hpp"
#include "tests/support/bars.hpp"
#include "tests/support/solve.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::test::contact_patch_test {
namespace {

constexpr double pressure = 3;

struct Half {
  Mesh mesh;
  FiniteElementModel model;
  std::vector<Index> dofs;  // free ones
  Points exact;             // displacements
  ContactSurface surface;
  ContactBody body;
};

// Nodes off the rim of a section are moved in its plane.
Vector3 distorted(const Vector3& x, double share) {
  const auto bump = [](double s) { return s * (1 - s); };
  const double u = bump(x[0]), v = bump(x[1]), wave = std::sin(17 * x[0] + 5 * x[1]);
  return x + share * Vector3(u * (wave + 4 * v), v * (std::cos(11 * x[1] - 7 * x[0]) - 3 * u), 0);
}

ContactSurface surface_at(const Mesh& mesh, double z, Index body, bool whole) {
  Sideset sides{"face", 1, {}};
  const Block& block = mesh.blocks[0];
  for (Index e = 0; e < block.connectivity.rows(); ++e) {
    for (int side = 1; side <= n_sides(block.type); ++side) {
      bool on = true;
      for (const Index node : nodes_of_side(mesh, {0, e, side}))
        on = on && std::abs(mesh.coordinates(node, 2) - z) < 1e-9;
      if (on) sides.sides.push_back({0, e, side});
    }
  }
  const Surface surface = extract_surface(mesh, sides);
  ContactSurface contact;
  contact.name = "face";
  contact.body = body;
  contact.nodes = surface_nodes(surface);
  const IndexTable faces = whole ? whole_faces(surface) : contact_faces(surface);
  contact.faces = faces.leftCols(4);
  if (whole) contact.middle = faces.rightCols(5);
  fill_sizes(contact, mesh.coordinates);
  return contact;
}

// A unit cube from z = floor up.
Half half(ElementType type, std::array<Index, 3> cells, double share, double floor, double E,
          double sunk, Index body, bool whole) {
  const Material material{E, 0.3, 1};
  Half h;
  h.mesh =
      box_mesh(type, cells, Vector3::Ones(), [&](const Vector3& x) { return distorted(x, share); });
  h.mesh.coordinates.col(2).array() += floor;
  h.model = assemble(h.mesh, {{material, HexFormulation::incompatible}}, MassKind::lumped);
  h.dofs = free_dofs(h.mesh, h.model, [](const Vector3& x, int c) { return x[c] < 1e-9; });
  const auto& x = h.mesh.coordinates;
  h.exact = x * (0.3 * pressure / E);
  h.exact.col(2).array() = -pressure / E * (x.col(2).array() - floor) - sunk;
  h.surface = surface_at(h.mesh, 1, body, whole);
  h.body.start = h.body.end = x;
  return h;
}

struct Patch {
  double displacement = 0;  // largest error, as a share of the largest displacement
  double multiplier = 0;    // largest |impulse / area - pressure| / pressure
  double least = 0;         // smallest impulse / area / pressure
  Index n_points = 0;
};

using Detect = decltype(&detect);

// [K, -G^T; G, 0] [u; p] = [f; 0] with all points closed.
Patch solve(Half& lower, Half& upper, bool slave_is_upper, Detect search) {
  Half &slave = slave_is_upper ? upper : lower, &master = slave_is_upper ? lower : upper;
  PairMemory memory;
  ContactList list;
  search(slave.surface, slave.body, master.surface, master.body, false, {}, memory, list);
  const Index n0 = lower.dofs.size(), n1 = static_cast<Index>(upper.dofs.size()),
              m = static_cast<Index>(list.points.size());
  Matrix A = Matrix::Zero(n0 + n1 + m, n0 + n1 + m);
  Vector b = Vector::Zero(A.rows()), exact(n0 + n1);
  std::array<std::vector<Index>, 2> column;  // of dof 3 i + c of a mesh's nodes; -1: held
  for (const Half* h : {&lower, &upper}) {
    const Index body = h->surface.body, first = body == 0 ? 0 : n0,
                n = static_cast<Index>(h->dofs.size());
    column[body].assign(3 * h->mesh.coordinates.rows(), -1);
    A.block(first, first, n, n) = Matrix(submatrix(h->model.K, h->dofs));
    // The pressure's nodal forces are what the exact field needs there
    Vector u(3 * static_cast<Index>(h->model.nodes.size()));
    for (std::size_t i = 0; i < h->model.nodes.size(); ++i)
      u.segment<3>(3 * static_cast<Index>(i)) = h->exact.row(h->model.nodes[i]).transpose();
    const Vector f = h->model.K * u;
    for (Index k = 0; k < n; ++k) {
      const Index node = h->model.nodes[h->dofs[k] / 3], c = h->dofs[k] % 3;
      column[body][3 * node + c] = first + k;
      exact[first + k] = u[h->dofs[k]];
      if (body == 1 && c == 2 && h->mesh.coordinates(node, 2) > 2 - 1e-9)
        b[first + k] = f[h->dofs[k]];
    }
  }
  for (Index i = 0; i < m; ++i) {
    const ContactPoint& point = list.points[i];
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
      const ContactTerm& term = list.terms[t];
      for (Index c = 0; c < 3; ++c) {
        const Index k = column[term.body][3 * term.node + c];
        if (k < 0) continue;
        A(n0 + n1 + i, k) += term.coefficient * point.normal()[c];
        A(k, n0 + n1 + i) -= term.coefficient * point.normal()[c];
      }
    }
  }
  const Vector x = Lu(A).solve(b);
  Patch result;
  result.n_points = m;
  result.displacement =
      (x.head(n0 + n1) - exact).cwiseAbs().maxCoeff() / exact.cwiseAbs().maxCoeff();
  result.least = HUGE_VAL;
  for (Index i = 0; i < m; ++i) {
    const double p = x[n0 + n1 + i] / list.points[i].area / pressure;
    result.multiplier = std::max(result.multiplier, std::abs(p - 1));
    result.least = std::min(result.least, p);
  }
  return result;
}

struct Meshes {
  ElementType lower, upper;
  std::array<Index, 3> lower_cells, upper_cells;
  double share = 0;
};

Patch solve(const Meshes& of, bool slave_is_upper, Detect search) {
  const bool whole = search == &detect_mortar;
  Half lower = half(of.lower, of.lower_cells, of.share, 0, 1000, 0, 0, whole),
       upper = half(of.upper, of.upper_cells, 0.8 * of.share, 1, 400, pressure / 1000, 1, whole);
  return solve(lower, upper, slave_is_upper, search);
}

using enum ElementType;
const std::vector<Meshes> linear_meshes = {
    {hex8, hex8, {3, 3, 2}, {4, 5, 2}, 0},   {hex8, hex8, {3, 3, 2}, {4, 5, 2}, 0.2},
    {hex8, tet4, {4, 3, 2}, {3, 3, 2}, 0.2}, {tet4, hex8, {4, 4, 1}, {3, 5, 2}, 0.2},
    {tet4, tet4, {4, 4, 2}, {3, 3, 2}, 0.2}, {wedge6, hex8, {2, 3, 2}, {5, 2, 2}, 0.2}};

TEST(ContactPatch, MortarStrainsLinearElementsUniformly) {
  for (const Meshes& meshes : linear_meshes) {
    for (const bool slave_is_upper : {false, true}) {
      const Patch patch = solve(meshes, slave_is_upper, detect_mortar);
      EXPECT_LT(patch.displacement, 1e-10);
      EXPECT_LT(patch.multiplier, 1e-9);
      EXPECT_GT(patch.n_points, 8);
    }
  }
}

// What the test is for: nodes against faces, one way, load a mesh that does not match unevenly.
TEST(ContactPatch, NodesAgainstFacesDoNot) {
  for (const Meshes& meshes : linear_meshes)
    for (const bool slave_is_upper : {false, true})
      EXPECT_GT(solve(meshes, slave_is_upper, detect).displacement, 1e-3);
}

// Faces of second order, whole: the multipliers are linear, what they act on is not.
TEST(ContactPatch, MortarStrainsElementsOfSecondOrderUniformly) {
  const std::vector<Meshes> quadratic = {
      {hex20, hex20, {2, 2, 1}, {3, 3, 1}, 0},    {hex20, hex20, {2, 2, 1}, {3, 3, 1}, 0.2},
      {hex20, hex8, {2, 2, 1}, {3, 3, 1}, 0.2},   {tet10, tet10, {2, 2, 1}, {3, 3, 1}, 0.2},
      {tet10, hex20, {2, 2, 2}, {3, 3, 1}, 0.2},  {tet10, hex8, {3, 2, 1}, {2, 4, 1}, 0.2},
      {hex20, hex20, {2, 2, 1}, {2, 2, 1}, 0.2},  {hex27, hex27, {2, 2, 1}, {3, 3, 1}, 0.2},
      {hex27, hex8, {2, 2, 1}, {3, 3, 1}, 0.2},   {hex27, tet10, {2, 2, 1}, {3, 3, 1}, 0.2},
      {wedge15, hex20, {2, 2, 1}, {3, 3, 1}, 0.2}};
  for (const Meshes& meshes : quadratic) {
    for (const bool slave_is_upper : {false, true}) {
      const Patch patch = solve(meshes, slave_is_upper, detect_mortar);
      EXPECT_LT(patch.displacement, 1e-10);
      EXPECT_LT(patch.multiplier, 1e-9);
    }
  }
}

// The patch test in motion: bars without lateral contraction whose ends are meshed differently
// strike each other as bars that are one element thick do, wave by wave. So do few shapes, whose
// statics hold a uniform pressure. These are the same for all meshes here, so that statics follow
// forces equally fast.
TEST(ContactPatch, WavesPassBetweenMeshesThatDoNotMatch) {
  struct Way {
    bool mesh;
    const char* basis;
    Index modes;
  };
  const auto strike = [](Index across1, Index across2, const std::string& contact, const Way& way) {
    Bar first, second;
    first.velocity = 1e-3;
    first.n = 4;
    first.across = across1;
    second.start = 1 + 1e-5;
    second.n = 6;
    second.across = across2;
    for (Bar* bar : {&first, &second}) {
      bar->mesh = way.mesh;
      bar->basis = way.basis;
      bar->modes = way.modes;
    }
    BarScene scene;
    scene.bars = {first, second};
    scene.step = "5e-4";
    scene.end = 0.3;
    scene.contact = contact;
    if (way.mesh) scene.integrator = "central-difference";
    return run(scene);
  };
  for (const Way& way :
       {Way{true, "", 0}, Way{false, "craig-bampton", -1},
        Way{false, "characteristic, characteristic: {modes: 0, statics: [x_min, x_max]}", 3}}) {
    const Ran thin = strike(1, 1, "", way), mortar = strike(2, 3, ", formulation: mortar", way),
              node_face = strike(2, 3, "", way);
    const auto difference = [&](const Ran& ran) {
      double largest = 0;
      for (const char* name : {"b0", "b1"}) {
        const auto &a = ran.body(name).momentum.values, &b = thin.body(name).momentum.values;
        EXPECT_EQ(a.size(), b.size());
        for (std::size_t k = 0; k < a.size(); ++k)
          largest = std::max(largest, std::abs(a[k] - b[k]));
      }
      return largest / (thin.mass("b0") * 1e-3);
    };
    std::printf("%s %s: mortar %.1e, node on face %.1e\n", way.mesh ? "mesh" : "superelement",
                way.basis, difference(mortar), difference(node_face));
    EXPECT_LT(difference(mortar), 1e-9) << way.basis;
    EXPECT_GT(difference(node_face), 1e-4) << way.basis;
  }
}

// Faces of second order through the whole program.
TEST(ContactPatch, FacesOfSecondOrderStrikeEachOther) {
  SceneFolder folder;
  const std::array<ElementType, 2> types{hex20, tet10};
  for (std::size_t i = 0; i < 2; ++i) {
    Mesh mesh = box_mesh(types[i], {4, 2 + Index(i), 2}, Vector3(1, 0.3, 0.3));
    for (const double x : {0.0, 1.0}) {
      Sideset sides{x == 0 ? "x_min" : "x_max", x == 0 ? 1 : 2, {}};
      for (Index e = 0; e < mesh.blocks[0].connectivity.rows(); ++e)
        for (int side = 1; side <= n_sides(types[i]); ++side) {
          const Vector X = mesh.coordinates(nodes_of_side(mesh, {0, e, side}), 0);
          if ((X.array() - x).abs().maxCoeff() < 1e-9) sides.sides.push_back({0, e, side});
        }
      mesh.sidesets.push_back(sides);
    }
    folder.add(name_of(i) + ".exo", mesh);
  }
  Bar first, second;
  first.velocity = 1e-3;
  second.start = 1 + 1e-5;
  first.width = second.width = 0.3;
  BarScene scene;
  scene.bars = {first, second};
  scene.integrator = "central-difference";
  scene.end = 0.3;
  scene.contact = ", formulation: mortar";
  const Ran ran = folder.run(yaml(scene));
  const auto speed = [&](const std::string& name) {
    return at(ran.body(name).momentum, ran.result.time.size() - 1)[0] / ran.mass(name);
  };
  // Equal bars exchange their speeds
  EXPECT_NEAR(speed("b0"), 0, 1e-4);
  EXPECT_NEAR(speed("b1"), 1e-3, 1e-4);
}

}  // namespace
}  // namespace cbr::test::contact_patch_test
