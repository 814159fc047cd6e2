// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/formats/sample_superelement.hpp"

#include <random>

#include "common/linalg/dense.hpp"

namespace cbr::test {
namespace {

Matrix random_matrix(std::mt19937& random, Index rows, Index columns) {
  std::uniform_real_distribution<double> entry(-1, 1);
  return Matrix::NullaryExpr(rows, columns, [&] { return entry(random); });
}

void add_diagonal_form(Superelement& s) {
  const SymmetricEigen solver = generalized_eigen(reduced_stiffness(s), reduced_mass(s));
  s.omega = solver.values.cwiseMax(0).cwiseSqrt();
  s.V = solver.vectors;
}

bool identical(const Surface& a, const Surface& b) {
  return a.name == b.name && a.kind == b.kind && a.faces == b.faces && a.element == b.element &&
         a.side == b.side;
}

bool identical(const Block& a, const Block& b) {
  return a.name == b.name && a.id == b.id && a.type == b.type && a.connectivity == b.connectivity &&
         a.element_ids == b.element_ids;
}

template <typename Array>
bool same(const Array& a, const Array& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() && (a.array() == b.array()).all();
}

bool identical(const Superelement::Recovery& a, const Superelement::Recovery& b) {
  return a.node_ids == b.node_ids && same(a.coordinates, b.coordinates) && same(a.Psi, b.Psi) &&
         same(a.Phi, b.Phi) && a.blocks.size() == b.blocks.size() &&
         std::equal(a.blocks.begin(), a.blocks.end(), b.blocks.begin(),
                    [](const Block& x, const Block& y) { return identical(x, y); });
}

}  // namespace

Superelement sample_superelement(unsigned seed) {
  std::mt19937 random(seed);
  constexpr Index k = 4, c = 12;
  Superelement s;
  s.content_hash = "0123456789abcdef0123456789abcdef";
  s.eigenvalues = (Vector(k) << 10, 20, 20, 1e3).finished();
  const Matrix A = random_matrix(random, c, c), B = random_matrix(random, c, c);
  s.K_cc = A.transpose() * A;
  s.M_kc = random_matrix(random, k, c);
  s.M_cc = s.M_kc.transpose() * s.M_kc + B.transpose() * B + Matrix::Identity(c, c);
  for (Matrix* symmetric : {&s.K_cc, &s.M_cc})
    *symmetric = (0.5 * (*symmetric + symmetric->transpose())).eval();
  for (Index i = 0; i < c; ++i) {
    s.dof_node.push_back(i / 3);
    s.dof_component.push_back(static_cast<int>(i % 3));
  }
  s.node_ids = {11, 12, 23, 34};
  s.coordinates.resize(4, 3);
  s.coordinates << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0.25;
  Surface quads{"contact", FaceKind::quad4, IndexTable(1, 4), {7}, {5}},
      triangles{"other side", FaceKind::tri3, IndexTable(2, 3), {8, 9}, {1, 4}};
  quads.faces << 0, 1, 2, 3;
  triangles.faces << 0, 2, 1, 0, 3, 2;
  s.surfaces = {quads, triangles};
  s.nodesets["clamp"] = {1, 3};
  s.rigid_body = {2.5, Vector3(0.5, 0.5, -1), Vector3(1, 2, 2.5).asDiagonal()};
  s.rigid_body.inertia(0, 1) = s.rigid_body.inertia(1, 0) = 0.125;
  add_diagonal_form(s);
  Superelement::Recovery recovery;
  recovery.node_ids = {50, 60};
  recovery.coordinates = random_matrix(random, 2, 3);
  recovery.Psi = random_matrix(random, 6, c);
  recovery.Phi = random_matrix(random, 6, k);
  Block block{"core / 1", 3, ElementType::tet4, IndexTable(2, 4), {7, 8}};
  block.connectivity << 0, 1, 2, 4, 1, 2, 3, 5;
  recovery.blocks = {block};
  s.recovery = {recovery};
  s.provenance = {{"mesh", "block.msh"},
                  {"material", "E = 1, nu = 0.3, rho = 1 (\xc3\xa9preuve)"},
                  {"options", ""}};
  return s;
}

bool identical(const Superelement& a, const Superelement& b) {
  return a.basis == b.basis && a.content_hash == b.content_hash &&
         same(a.eigenvalues, b.eigenvalues) && same(a.K_cc, b.K_cc) && same(a.M_cc, b.M_cc) &&
         same(a.M_kc, b.M_kc) && a.dof_node == b.dof_node && a.dof_component == b.dof_component &&
         a.node_ids == b.node_ids && same(a.coordinates, b.coordinates) &&
         a.surfaces.size() == b.surfaces.size() &&
         std::equal(a.surfaces.begin(), a.surfaces.end(), b.surfaces.begin(),
                    [](const Surface& x, const Surface& y) { return identical(x, y); }) &&
         a.nodesets == b.nodesets && a.rigid_body.mass == b.rigid_body.mass &&
         same(a.rigid_body.center, b.rigid_body.center) &&
         same(a.rigid_body.inertia, b.rigid_body.inertia) && same(a.omega, b.omega) &&
         same(a.V, b.V) && same(a.spin_moments, b.spin_moments) &&
         same(a.spin_couplings, b.spin_couplings) && same(a.fixed.resisted, b.fixed.resisted) &&
         same(a.fixed.momentum, b.fixed.momentum) && a.recovery.size() == b.recovery.size() &&
         (a.recovery.empty() || identical(a.recovery[0], b.recovery[0])) &&
         a.provenance == b.provenance;
}

SuperelementGroup sample_group() {
  // Node ids by rows of a grid in the plane: id 10 i + j stands at (i, j, 0.25).
  const std::vector<std::vector<Index>> ids = {{0, 10, 11, 1}, {21, 11, 10, 20}, {2, 1, 11, 12}};
  SuperelementGroup group;
  group.content_hash = "fedcba9876543210fedcba9876543210";
  group.provenance = {{"mesh", "grid.msh"}, {"domains", "3"}};
  group.rigid_body = {0, Vector3(1, 1, 0.25), Vector3(3, 4, 5).asDiagonal()};
  for (std::size_t d = 0; d < ids.size(); ++d) {
    Superelement s = sample_superelement(static_cast<unsigned>(d + 1));
    s.content_hash = group.content_hash;
    s.omega.resize(0);
    s.V.resize(0, 0);
    s.node_ids = ids[d];
    for (Index i = 0; i < 4; ++i) {
      const Index id = ids[d][i];
      s.coordinates.row(i) << static_cast<double>(id / 10), static_cast<double>(id % 10), 0.25;
    }
    s.rigid_body.mass = 1.0 + static_cast<double>(d);
    group.rigid_body.mass += s.rigid_body.mass;
    for (Index& element : s.surfaces[0].element) element += 10 * static_cast<Index>(d);
    if (d == 1) s.surfaces.pop_back();
    group.domains.push_back(s);
  }
  Superelement whole = join(group);
  add_diagonal_form(whole);
  group.omega = whole.omega;
  group.V = whole.V;
  return group;
}

bool identical(const SuperelementGroup& a, const SuperelementGroup& b) {
  return a.content_hash == b.content_hash && a.domains.size() == b.domains.size() &&
         std::equal(a.domains.begin(), a.domains.end(), b.domains.begin(),
                    [](const Superelement& x, const Superelement& y) { return identical(x, y); }) &&
         a.rigid_body.mass == b.rigid_body.mass && same(a.rigid_body.center, b.rigid_body.center) &&
         same(a.rigid_body.inertia, b.rigid_body.inertia) && same(a.omega, b.omega) &&
         same(a.V, b.V) && a.provenance == b.provenance;
}

}  // namespace cbr::test
