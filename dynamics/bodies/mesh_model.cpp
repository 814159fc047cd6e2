// SPDX-License-Identifier: GPL-3.0-or-later
// The mesh body's shared data, and what a mesh body answers about itself.
#include <Eigen/Dense>

#include <cmath>

#include "common/error.hpp"
#include "common/linalg/eigenpairs.hpp"
#include "dynamics/bodies/mesh_body.hpp"

namespace cbr {

MeshModel mesh_model(const FiniteElementModel& model, const Points& coordinates, bool lumped) {
  MeshModel mesh;
  const Index n = coordinates.rows();
  mesh.coordinates = coordinates;
  mesh.K = block_matrix(model.K);
  Vector ones = Vector::Zero(3 * n);
  for (Index i = 0; i < n; ++i) ones[3 * i] = 1;
  const Vector rows = model.M * ones;
  mesh.mass.resize(n);
  for (Index i = 0; i < n; ++i) mesh.mass[i] = rows[3 * i];
  // Row sums of a consistent mass may be negative (corners of hex20 and tet10): only a nodal enforcement minds, and looks itself.
  if (lumped && !(mesh.mass.minCoeff() > 0)) throw RunError("a node of the mesh has a lumped mass that is not positive");
  mesh.rigid_body = rigid_body(model.M, coordinates);
  mesh.MR.noalias() = model.M * rigid_modes(coordinates, mesh.rigid_body.center);
  double lambda = 0;
  if (lumped) {
    lambda = largest_eigenvalue(model.K, Vector(model.M.diagonal()));
  } else {
    mesh.M = model.M;
    const SparseCholesky factor(model.M);
    if (!factor.ok()) throw RunError("the consistent mass is not positive definite");
    lambda = largest_eigenvalue(
        model.K.rows(), [&](const Vector& x, Vector& y) { y.noalias() = model.K * x; },
        [&](const Vector& x, Vector& y) { factor.solve(x.data(), y.data()); });
  }
  if (!(lambda > 0) || !std::isfinite(lambda)) throw RunError("the highest frequency of the mesh cannot be computed");
  mesh.largest_frequency = std::sqrt(lambda);
  return mesh;
}

NodeResponse MeshBody::response(Index set, double h) const {
  const auto& nodes = sets_[set];
  const Index m = static_cast<Index>(nodes.size());
  NodeResponse response;
  if (!consistent()) {
    bool any_held = false;
    response.diagonal.resize(3 * m);
    for (Index i = 0; i < m; ++i) {
      response.diagonal.segment<3>(3 * i).setConstant(h / model_->mass[nodes[i]]);
      any_held |= !held_of(nodes[i]).empty();
    }
    if (!any_held) return response;
  }
  // Columns of T h M^-1 T^T on the free directions   (3m x 3m)
  Matrix S = Matrix::Zero(3 * m, 3 * m);
  Points force = Points::Zero(model_->mass.size(), 3), a = force;
  for (Index j = 0; j < 3 * m; ++j) {
    force.row(nodes[j / 3]) = placement_.T.row(j % 3);
    if (consistent()) {
      accelerations(force, a);
      for (Index i = 0; i < m; ++i) S.col(j).segment<3>(3 * i) = h * (placement_.T * a.row(nodes[i]).transpose());
    } else {
      Vector3 local = force.row(nodes[j / 3]).transpose() / model_->mass[nodes[j / 3]];
      for (const HeldDirection& held : held_of(nodes[j / 3])) local -= local.dot(held.direction) * held.direction;
      S.col(j).segment<3>(3 * (j / 3)) = h * (placement_.T * local);
    }
    force.row(nodes[j / 3]).setZero();
  }
  response.diagonal.resize(0);
  response.set_block(std::move(S));
  return response;
}

Points MeshBody::nodal_masses(Index set) const { return model_->mass(sets_[set]).replicate(1, 3); }

void MeshBody::add_force(const Points& forces, const History& history) { loads_.push_back({forces * placement_.T, history}); }

void MeshBody::add_gravity(const Vector3& acceleration, const History& history) {
  // M r g: row sums, lumped or consistent
  loads_.push_back({model_->mass * (placement_.T.transpose() * acceleration).transpose(), history});
}

double MeshBody::scalar_product(const Points& v, const Points& w) const {
  const Eigen::Map<const Vector> a(v.data(), v.size()), b(w.data(), w.size());
  if (consistent()) return a.dot(model_->M * b);
  return (v.cwiseProduct(w).rowwise().sum().array() * model_->mass.array()).sum();
}

BodyState MeshBody::state() const {
  const Matrix3& T = placement_.T;
  const RigidBody& rigid = model_->rigid_body;
  const Eigen::Map<const Vector> u(u_.data(), u_.size()), v(v_.data(), v_.size());
  const Points &Ku = internal_forces(), &present = present_velocities();
  const Eigen::Map<const Vector> v_now(present.data(), present.size());
  const Eigen::Map<const Vector> internal(Ku.data(), Ku.size());
  const Vector moment = model_->MR.transpose() * u, rate = model_->MR.transpose() * v_now;
  BodyState state;
  state.center_of_mass = T * (rigid.center + moment.head<3>() / rigid.mass) + placement_.position;
  state.momentum = T * rate.head<3>();
  state.angular_momentum = T.determinant() * (T * rate.tail<3>()) + state.center_of_mass.cross(state.momentum);
  state.rotation = rigid.inertia.ldlt().solve(moment.tail<3>()).norm();
  if (!std::isfinite(state.rotation)) state.rotation = 0;
  // 1/2 v- M v+ with v+ of the internal forces alone: what leapfrog conserves together with the strain energy
  state.kinetic_energy = 0.5 * scalar_product(v_, v_) - 0.5 * last_h_ * v.dot(internal);
  state.strain_energy = 0.5 * u.dot(internal);
  return state;
}

void MeshBody::displacements(Points& u, Points& v) const {
  u = u_ * placement_.T.transpose();
  v = present_velocities() * placement_.T.transpose();
}

void MeshBody::coordinates(Vector& q, Vector& rates) const {
  const Points& v = present_velocities();
  q = Eigen::Map<const Vector>(u_.data(), u_.size());
  rates = Eigen::Map<const Vector>(v.data(), v.size());
}

}  // namespace cbr
