// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/dynamics/lattice.hpp"

#include <Eigen/Geometry>

#include "common/linalg/dense.hpp"

namespace cbr::test {

Lattice lattice(std::array<Index, 3> n, double spacing, double stiffness, double mass) {
  Lattice body;
  body.n = n;
  const Index N = n[0] * n[1] * n[2];
  body.points.resize(N, 3);
  body.mass = Vector::Constant(N, mass);
  body.K = Matrix::Zero(3 * N, 3 * N);
  for (Index k = 0; k < n[2]; ++k)
    for (Index j = 0; j < n[1]; ++j)
      for (Index i = 0; i < n[0]; ++i)
        body.points.row(body.node(i, j, k)) = spacing * Vector3(double(i), double(j), double(k));
  for (Index a = 0; a < N; ++a) {
    for (Index b = a + 1; b < N; ++b) {
      const Vector3 d = (body.points.row(b) - body.points.row(a)).transpose();
      if (d.norm() > 1.75 * spacing) continue;
      const Matrix3 block = stiffness * d * d.transpose() / d.squaredNorm();
      body.K.block<3, 3>(3 * a, 3 * a) += block;
      body.K.block<3, 3>(3 * b, 3 * b) += block;
      body.K.block<3, 3>(3 * a, 3 * b) -= block;
      body.K.block<3, 3>(3 * b, 3 * a) -= block;
    }
  }
  return body;
}

const Lattice& block() {
  static const Lattice body = lattice({4, 3, 3}, 0.1, 2e3, 0.5);
  return body;
}

RigidBody rigid_body_of(const Lattice& body) {
  RigidBody rigid;
  rigid.mass = body.mass.sum();
  rigid.center = (body.points.transpose() * body.mass) / rigid.mass;
  for (Index i = 0; i < body.mass.size(); ++i) {
    const Vector3 r = body.points.row(i).transpose() - rigid.center;
    rigid.inertia += body.mass[i] * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose());
  }
  return rigid;
}

std::vector<Surface> x_faces(const Lattice& body, const std::vector<Index>& nodes) {
  std::vector<Index> position(body.mass.size(), -1);
  for (std::size_t i = 0; i < nodes.size(); ++i) position[nodes[i]] = static_cast<Index>(i);
  std::vector<Surface> surfaces;
  for (const bool maximum : {false, true}) {
    Surface s;
    s.name = maximum ? "x_max" : "x_min";
    const Index i = maximum ? body.n[0] - 1 : 0;
    if (position[body.node(i, 0, 0)] < 0) continue;
    s.faces.resize((body.n[1] - 1) * (body.n[2] - 1), 4);
    Index f = 0;
    for (Index k = 0; k + 1 < body.n[2]; ++k) {
      for (Index j = 0; j + 1 < body.n[1]; ++j, ++f) {
        const Index a = position[body.node(i, j, k)], b = position[body.node(i, j + 1, k)],
                    c = position[body.node(i, j + 1, k + 1)], d = position[body.node(i, j, k + 1)];
        if (maximum) {
          s.faces.row(f) << a, b, c, d;
        } else {
          s.faces.row(f) << a, d, c, b;
        }
      }
    }
    s.element.assign(f, 1);
    s.side.assign(f, 1);
    surfaces.push_back(s);
  }
  return surfaces;
}

std::vector<Index> x_nodes(const Lattice& body, bool minimum, bool maximum) {
  std::vector<Index> nodes;
  for (Index a = 0; a < body.mass.size(); ++a) {
    const Index i = a % body.n[0];
    if ((minimum && i == 0) || (maximum && i == body.n[0] - 1)) nodes.push_back(a);
  }
  return nodes;
}

Superelement reduce(const Lattice& body, const std::vector<Index>& interface_nodes, Index k) {
  std::vector<Index> c, I;
  std::vector<char> kept(body.mass.size(), 0);
  for (const Index node : interface_nodes) kept[node] = 1;
  Superelement s;
  for (const Index node : interface_nodes) {
    s.node_ids.push_back(node + 1);
    for (int d = 0; d < 3; ++d) {
      c.push_back(3 * node + d);
      s.dof_node.push_back(static_cast<Index>(s.node_ids.size()) - 1);
      s.dof_component.push_back(d);
    }
  }
  for (Index node = 0; node < body.mass.size(); ++node)
    for (int d = 0; d < 3 && !kept[node]; ++d) I.push_back(3 * node + d);
  Vector m(3 * body.mass.size());
  for (Index i = 0; i < m.size(); ++i) m[i] = body.mass[i / 3];
  const Matrix K_II = body.K(I, I), K_IC = body.K(I, c), M_II = Vector(m(I)).asDiagonal();
  const Matrix Psi = -Ldlt(K_II).solve(K_IC);
  const SymmetricEigen modes = generalized_eigen(K_II, M_II);
  const Matrix Phi = modes.vectors.leftCols(k);
  s.eigenvalues = modes.values.head(k);
  s.K_cc = Matrix(body.K(c, c)) + K_IC.transpose() * Psi;
  s.K_cc = (0.5 * (s.K_cc + s.K_cc.transpose())).eval();
  s.M_cc = Psi.transpose() * M_II * Psi;
  s.M_cc.diagonal() += Vector(m(c));
  s.M_cc = (0.5 * (s.M_cc + s.M_cc.transpose())).eval();
  s.M_kc = Phi.transpose() * M_II * Psi;
  s.coordinates = body.points(interface_nodes, Eigen::all);
  s.surfaces = x_faces(body, interface_nodes);
  s.rigid_body = rigid_body_of(body);
  return s;
}

void store_diagonal_form(Superelement& s) {
  const SymmetricEigen modes = generalized_eigen(reduced_stiffness(s), reduced_mass(s));
  s.omega = modes.values.cwiseMax(0).cwiseSqrt();
  s.omega.head(6).setZero();
  s.V = modes.vectors;
}

Model model(Superelement s) {
  store_diagonal_form(s);
  Model m;
  m.superelement = std::make_shared<Superelement>(std::move(s));
  m.form = std::make_shared<ModalForm>(free_modal_form(*m.superelement, "test"));
  return m;
}

Placement oblique(bool mirrored) {
  Placement placement;
  placement.T = Eigen::AngleAxisd(0.7, Vector3(1, 2, -1).normalized()).toRotationMatrix();
  if (mirrored) placement.T = (placement.T * Vector3(1, -1, 1).asDiagonal()).eval();
  placement.position = Vector3(0.3, -0.2, 1.1);
  placement.velocity = Vector3(2, -1, 0.5);
  return placement;
}

Points random_points(std::mt19937& random, Index n, double size) {
  std::normal_distribution<double> normal;
  return Points::NullaryExpr(n, 3, [&] { return size * normal(random); });
}

}  // namespace cbr::test
