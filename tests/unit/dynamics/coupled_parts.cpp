// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/dynamics/coupled_parts.hpp"

#include <Eigen/Geometry>

#include <random>

#include "common/linalg/dense.hpp"

namespace cbr::test {

Chain chain(Index n_domains, Index k) {
  const std::array<Index, 3> n{3, 2, 3};
  const double spacing = 0.1;
  const Index plane = n[1] * n[2];
  Chain c;
  c.coordinates.resize(plane * (n_domains + 1), 3);
  Matrix R = Matrix::Zero(6, 6);
  std::vector<Vector3> at;
  std::vector<double> mass;
  for (Index d = 0; d < n_domains; ++d) {
    Lattice part = lattice(n, spacing, 2e3 * double(1 + d % 2), 0.3 + 0.2 * double(d));
    part.points.col(0).array() += double(d * (n[0] - 1)) * spacing;
    auto s = std::make_shared<Superelement>(reduce(part, x_nodes(part, true, true), k));
    // x_nodes alternates: minimum, maximum, minimum, ...
    std::vector<Index> place;
    for (Index i = 0; i < s->coordinates.rows(); ++i) {
      place.push_back((d + i % 2) * plane + i / 2);
      c.coordinates.row(place.back()) = s->coordinates.row(i);
    }
    c.place.push_back(place);
    c.domains.push_back(s);
    for (Index i = 0; i < part.points.rows(); ++i) {
      at.push_back(part.points.row(i).transpose());
      mass.push_back(part.mass[i]);
    }
  }
  for (std::size_t i = 0; i < at.size(); ++i) {
    c.body.mass += mass[i];
    c.body.center += mass[i] * at[i];
  }
  c.body.center /= c.body.mass;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const Vector3 r = at[i] - c.body.center;
    c.body.inertia += mass[i] * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose());
  }
  return c;
}

ShellModel random_shells(const Points& points, const std::vector<Index>& nodes, double stiffness,
                         double mass) {
  const Index m = nodes.size();
  Matrix R(6 * m, 6);
  R.topRows(3 * m) = rigid_modes(points(nodes, Eigen::all), Vector3::Zero());
  R.bottomRows(3 * m) = Matrix::Zero(3 * m, 6);
  for (Index i = 0; i < m; ++i) R.block<3, 3>(3 * (m + i), 3).setIdentity();
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const Matrix A = Matrix::NullaryExpr(6 * m, 6 * m, [&] { return normal(random); });
  const Matrix Q = orthonormal_basis(R);
  const Matrix P = Matrix::Identity(6 * m, 6 * m) - Q * Q.transpose();
  const Matrix K = stiffness * P * A.transpose() * A * P;
  ShellModel shells;
  shells.nodes = nodes;
  shells.K = (0.5 * (K + K.transpose())).sparseView();
  shells.mass = Vector::LinSpaced(m, mass, 2 * mass);
  shells.rotary = Vector::LinSpaced(m, 1e-3 * mass, 2e-3 * mass);
  return shells;
}

CoupledModel chain_with_shells(Index k) {
  const Chain c = chain(2, k);
  CoupledModel model = c.model();
  add_shells(random_shells(c.coordinates, {0, 1, 2, 4}, 20, 0.05), model);
  return model;
}

Matrix whole_stiffness(const CoupledModel& model) {
  Matrix K = Matrix::Zero(model.n(), model.n());
  if (model.K.size() > 0) K.bottomRightCorner(model.n_nodal(), model.n_nodal()) = model.K;
  Index first = 0;
  for (const CoupledPart& part : model.parts) {
    const Superelement& s = *part.superelement;
    K.diagonal().segment(first, s.k()) = s.eigenvalues;
    for (Index j = 0; j < s.c(); ++j)
      for (Index i = 0; i < s.c(); ++i)
        K(model.n_modal() + part.dof[i], model.n_modal() + part.dof[j]) += s.K_cc(i, j);
    first += s.k();
  }
  return K;
}

Matrix whole_mass(const CoupledModel& model) {
  Matrix M = Matrix::Zero(model.n(), model.n());
  if (model.M.size() > 0) M.bottomRightCorner(model.n_nodal(), model.n_nodal()) = model.M;
  Index first = 0;
  for (const CoupledPart& part : model.parts) {
    const Superelement& s = *part.superelement;
    M.diagonal().segment(first, s.k()).setOnes();
    for (Index j = 0; j < s.c(); ++j) {
      const Index column = model.n_modal() + part.dof[j];
      for (Index i = 0; i < s.k(); ++i) M(first + i, column) = M(column, first + i) = s.M_kc(i, j);
      for (Index i = 0; i < s.c(); ++i) M(model.n_modal() + part.dof[i], column) += s.M_cc(i, j);
    }
    first += s.k();
  }
  return M;
}

std::vector<HeldDirection> some_held() {
  const Vector3 a = Vector3(1, 2, -0.5).normalized(), b = a.cross(Vector3(0, 0, 1)).normalized();
  return {
      {3, a}, {7, a}, {7, b}, {8, Vector3::UnitX()}, {8, Vector3::UnitY()}, {8, Vector3::UnitZ()}};
}

Matrix whole_free_basis(const CoupledModel& model, const std::vector<HeldDirection>& held) {
  const Matrix Z = free_dofs(model, held).Z;
  Matrix whole = Matrix::Zero(model.n(), model.n_modal() + Z.cols());
  whole.topLeftCorner(model.n_modal(), model.n_modal()).setIdentity();
  whole.bottomRightCorner(Z.rows(), Z.cols()) = Z;
  return whole;
}

const std::vector<Method> methods{{Scheme::central_difference, 0},
                                  {Scheme::newmark, 0},
                                  {Scheme::newmark, -0.1},
                                  {Scheme::newmark, -1.0 / 3}};

const History ramp{{0.0, 0.013, 0.041, 0.3}, {1.0, 3.0, -2.0, 0.5}};

std::shared_ptr<const CoupledModel> shared(CoupledModel model) {
  return std::make_shared<const CoupledModel>(std::move(model));
}

}  // namespace cbr::test
