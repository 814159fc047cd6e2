// SPDX-License-Identifier: GPL-3.0-or-later
// Shared data of mesh bodies, their queries, their start and their checkpoints.
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/files/state_archive.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "dynamics/motion/nodal/mesh_body.hpp"

namespace cbr {

namespace {

// Lanczos on the planes of a field: 3 n dofs, component c of row i at c n + i.
double largest_eigenvalue_lumped(const MeshForces& forces, const Vector& inverse_mass) {
  const Index n = forces.rows();
  RowThreads threads(1);
  MeshForces::Work room;
  Field u(n, 3);
  return largest_eigenvalue(
      3 * n,
      [&](const Vector& x, Vector& y) {
        u = Eigen::Map<const Field>(x.data(), n, 3);
        forces.each(u, threads, room, [&](Index begin, Index end, const double* f, Index stride) {
          for (int c = 0; c < 3; ++c)
            std::copy(f + c * stride, f + c * stride + end - begin, y.data() + c * n + begin);
        });
      },
      [&](const Vector& x, Vector& y) {
        Eigen::Map<Field>(y.data(), n, 3).array() =
            Eigen::Map<const Field>(x.data(), n, 3).array().colwise() * inverse_mass.array();
      });
}

}  // namespace

MeshModel mesh_model(const FiniteElementModel& model, const Points& coordinates, bool lumped) {
  return mesh_model(model, coordinates, lumped, MeshForces(model.K));
}

MeshModel mesh_model(const FiniteElementModel& model, const Points& coordinates, bool lumped,
                     MeshForces forces) {
  MeshModel mesh;
  const Index n = coordinates.rows();
  mesh.coordinates = coordinates;
  mesh.forces = std::move(forces);
  const auto& order = mesh.forces.order();
  mesh.row_of_node.resize(n);
  for (Index i = 0; i < n; ++i) mesh.row_of_node[order[i]] = i;
  Vector ones = Vector::Zero(3 * n);
  for (Index i = 0; i < n; ++i) ones[3 * i] = 1;
  const Vector sums = model.M * ones;
  mesh.mass.resize(n);
  for (Index i = 0; i < n; ++i) mesh.mass[i] = sums[3 * order[i]];
  // Row sums of a consistent mass may be negative (corners of hex20 and tet10): only a nodal
  // enforcement minds, and looks itself.
  if (lumped && !(mesh.mass.minCoeff() > 0))
    throw RunError("a node of the mesh has a lumped mass that is not positive");
  mesh.rigid_body = rigid_body(model.M, coordinates, model.n_rotations);
  double lambda = 0;
  if (lumped) {
    mesh.inverse_mass = mesh.mass.cwiseInverse();
    mesh.arms.resize(n, 3);
    for (Index i = 0; i < n; ++i)
      mesh.arms.row(i) =
          mesh.mass[i] * (coordinates.row(order[i]) - mesh.rigid_body.center.transpose());
    for (Index i = 0; i < n; ++i)
      if (order[i] >= model.n_translations()) mesh.rotations.push_back(i);
    mesh.arms(mesh.rotations, Eigen::all).setZero();
    lambda = largest_eigenvalue_lumped(mesh.forces, mesh.inverse_mass);
  } else {
    assert(std::is_sorted(order.begin(), order.end()));
    mesh.MR.noalias() = model.M * rigid_modes(coordinates, mesh.rigid_body.center);
    mesh.M = model.M;
    const SparseCholesky factor(model.M);
    if (!factor.ok()) throw RunError("the consistent mass is not positive definite");
    lambda = largest_eigenvalue(
        model.K.rows(), [&](const Vector& x, Vector& y) { y.noalias() = model.K * x; },
        [&](const Vector& x, Vector& y) { factor.solve(x.data(), y.data()); });
  }
  if (!(lambda > 0) || !std::isfinite(lambda))
    throw RunError(
        "the highest frequency of the mesh cannot be computed: its stiffness is too large, or its "
        "mass too small, for a double: look at the units of youngs_modulus and density");
  mesh.largest_frequency = std::sqrt(lambda);
  return mesh;
}

NodeResponse MeshBody::own_response(Index set, double h) const {
  const auto& nodes = sets_[set];
  const Index m = static_cast<Index>(nodes.size());
  const double push = h * kick_share(h);
  NodeResponse response;
  if (!consistent()) {
    bool any_held = false;
    response.diagonal.resize(3 * m);
    for (Index i = 0; i < m; ++i) {
      response.diagonal.segment<3>(3 * i).setConstant(push / model_->mass[nodes[i]]);
      any_held |= !held_of(nodes[i]).empty();
    }
    if (!any_held) return response;
  }
  // Columns of T h M^-1 T^T on the free directions   (3m x 3m)
  Matrix S = Matrix::Zero(3 * m, 3 * m);
  Field force = Field::Zero(model_->mass.size(), 3), a = force;
  for (Index j = 0; j < 3 * m; ++j) {
    force.row(nodes[j / 3]) = placement_.T.row(j % 3);
    if (consistent()) {
      accelerations(force, a);
      for (Index i = 0; i < m; ++i)
        S.col(j).segment<3>(3 * i) = push * (placement_.T * a.row(nodes[i]).transpose());
    } else {
      Vector3 local = force.row(nodes[j / 3]).transpose() / model_->mass[nodes[j / 3]];
      for (const HeldDirection& held : held_of(nodes[j / 3]))
        local -= local.dot(held.direction) * held.direction;
      S.col(j).segment<3>(3 * (j / 3)) = push * (placement_.T * local);
    }
    force.row(nodes[j / 3]).setZero();
  }
  response.diagonal.resize(0);
  response.set_block(std::move(S));
  return response;
}

Points MeshBody::nodal_masses(Index set) const {
  if (turning_) lacks_nodal_masses();
  return model_->mass(sets_[set]).replicate(1, 3);
}

void MeshBody::take_plan(const BodyPlan& plan) {
  add_loads(plan.loads);
  if (still_) still_->prepare(plan);
}

void MeshBody::add_loads(const std::vector<BodyLoad>& loads) {
  for (const BodyLoad& load : loads) {
    require_no_modal_forces(load, name());
    if (turning_ && load.vector) add_turned_load(*load.vector, load.history);
    if (const NodalForces of = turning_ ? load.fixed.forces : forces_of(load).forces) {
      const Points forces = of.on_nodes();
      Points by_rows(forces.rows(), 3);
      for (Index i = 0; i < by_rows.rows(); ++i)
        by_rows.row(i) = forces.row(model_->forces.order()[i]) * placement_.T;
      loads_.add(by_rows, load.history);
    }
    // M r g: row sums, lumped or consistent
    if (!load.acceleration) continue;
    Points weight = model_->mass * (placement_.T.transpose() * *load.acceleration).transpose();
    weight(model_->rotations, Eigen::all).setZero();
    loads_.add(weight, load.history);
  }
}

void MeshBody::add_start_impulse(const Vector& impulse) {
  const Eigen::Map<const Points> of_nodes(impulse.data(), impulse.size() / 3, 3);
  Field force(v_.rows(), 3), change(v_.rows(), 3);
  for (Index i = 0; i < force.rows(); ++i) force.row(i) = of_nodes.row(model_->forces.order()[i]);
  accelerations(force, change);
  v_ += change;
  hold_velocity();
}

double MeshBody::scalar_product(const Field& v, const Field& w) const {
  if (consistent()) {
    const Points a = v, b = w;
    return Eigen::Map<const Vector>(a.data(), a.size())
        .dot(model_->M * Eigen::Map<const Vector>(b.data(), b.size()));
  }
  double sum = 0;
  for (int c = 0; c < 3; ++c)
    sum += (v.col(c).array() * w.col(c).array() * model_->mass.array()).sum();
  return sum;
}

Eigen::Matrix<double, 6, 1> MeshBody::momenta(const Field& v) const {
  Eigen::Matrix<double, 6, 1> p;
  if (consistent()) {
    const Points by_node = v;
    const SingleThreadedBlas one;  // the same bits with any number of threads
    return model_->MR.transpose() * Eigen::Map<const Vector>(by_node.data(), by_node.size());
  }
  Matrix3 moment;  // sum of (m X) v^T
  for (int c = 0; c < 3; ++c) {
    p[c] = model_->mass.dot(v.col(c));
    for (int r = 0; r < 3; ++r) moment(r, c) = r == c ? 0 : model_->arms.col(r).dot(v.col(c));
  }
  p.tail<3>() << moment(1, 2) - moment(2, 1), moment(2, 0) - moment(0, 2),
      moment(0, 1) - moment(1, 0);
  if (model_->rotations.empty()) return p;
  const Vector3 spin = spin_of_nodes(v.array().colwise() * model_->mass.array());
  p.head<3>() -= spin;
  p.tail<3>() += spin;
  return p;
}

BodyState MeshBody::own_state() const {
  if (turning_) return turned_state();
  const Field& Ku = internal_forces();
  BodyState state =
      placement_.state(model_->rigid_body, momenta(u_), momenta(present_velocities()));
  // 1/2 v- M v+ with v+ of the internal forces alone: what leapfrog conserves together with the
  // strain energy
  state.kinetic_energy = 0.5 * scalar_product(v_, v_) - 0.5 * last_h_ * v_.cwiseProduct(Ku).sum();
  state.strain_energy = 0.5 * u_.cwiseProduct(Ku).sum();
  return state;
}

void MeshBody::own_displacements(Points& u, Points& v) const {
  if (still_) return still_->displacements(u, v);
  u = by_nodes(u_) * placement_.T.transpose();
  v = by_nodes(present_velocities()) * placement_.T.transpose();
}

void MeshBody::own_coordinates(Vector& q, Vector& rates) const {
  Field unturned, its_rates;
  if (turning_) unturned_fields(unturned, its_rates);
  const Points u = by_nodes(turning_ ? unturned : u_),
               v = by_nodes(turning_ ? its_rates : present_velocities());
  q = Eigen::Map<const Vector>(u.data(), u.size());
  rates = Eigen::Map<const Vector>(v.data(), v.size());
}

// Rates are those half a step before, of a body at rest under all forces.
void MeshBody::own_start_motion(double h, const std::vector<BodyLoad>& loads) {
  add_loads(loads);
  take_still();
  last_h_ = h;
  Ku_is_current_ = v_now_is_current_ = false;
  still_.reset();
}

// Displacements as equilibrium has them.
void MeshBody::take_still() {
  Points u, v;
  still_->displacements(u, v);
  const Points local = u * placement_.T;
  for (Index i = 0; i < local.rows(); ++i) u_.row(model_->row_of_node[i]) = local.row(i);
}

// K u is formed anew where it was known. Velocities are the same with either.
void MeshBody::own_keep_state(StateArchive& archive) {
  archive.expect(u_.rows());
  archive(u_, v_, t_, last_h_, work_, lasting_);
  if (turning_) keep_turning(archive);
  if (still_) {
    still_->keep_state(archive);
    if (archive.restores()) take_still();
  }
  bool is_known = Ku_is_current_;
  archive(is_known);
  if (!archive.restores()) return;
  Ku_is_current_ = v_now_is_current_ = false;
  if (is_known) internal_forces();
}

}  // namespace cbr
