// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/bodies/mesh_body.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "common/error.hpp"

namespace cbr {
namespace {

Eigen::Map<const Vector> flat(const Points& p) { return {p.data(), p.size()}; }
Eigen::Map<Vector> flat(Points& p) { return {p.data(), p.size()}; }

// Orthonormal basis of the displacements that the held directions leave free   (3 n x free).
SparseMatrix free_basis(Index n_nodes, const std::vector<HeldDirection>& held) {
  std::vector<std::vector<Vector3>> of_node(n_nodes);
  for (const HeldDirection& h : held) of_node[h.node].push_back(h.direction);
  std::vector<Eigen::Triplet<double, Index>> entries;
  Index column = 0;
  for (Index node = 0; node < n_nodes; ++node) {
    const Matrix3 Q = complete_basis(of_node[node]);
    for (Index f = static_cast<Index>(of_node[node].size()); f < 3; ++f, ++column)
      for (int c = 0; c < 3; ++c)
        if (Q(c, f) != 0) entries.emplace_back(3 * node + c, column, Q(c, f));
  }
  SparseMatrix Z(3 * n_nodes, column);
  Z.setFromTriplets(entries.begin(), entries.end());
  return Z;
}

}  // namespace

MeshBody::MeshBody(std::string name, std::shared_ptr<const MeshModel> model, const Placement& placement,
                   const std::vector<HeldDirection>& held, std::shared_ptr<RowThreads> threads)
    : name_(std::move(name)), model_(std::move(model)), placement_(placement), held_(held), threads_(std::move(threads)) {
  const Index n = model_->mass.size();
  X_ = (model_->coordinates * placement_.T.transpose()).rowwise() + placement_.position.transpose();
  for (Points* p : {&u_, &v_, &u_end_, &v_end_, &force_, &scratch_, &Ku_}) p->setZero(n, 3);
  v_.rowwise() = (placement_.T.transpose() * placement_.velocity).transpose();
  for (const HeldDirection& h : held_) v_.row(h.node) -= v_.row(h.node).dot(h.direction.transpose()) * h.direction.transpose();
  if (consistent()) {
    Z_ = free_basis(n, held_);
    factor_ = std::make_shared<SparseCholesky>(SparseMatrix(Z_.transpose() * model_->M * Z_));
    if (!factor_->ok()) throw RunError("instance '" + name_ + "': the consistent mass is not positive definite");
  }
}

Index MeshBody::track(const std::vector<Index>& nodes) {
  sets_.push_back(nodes);
  return static_cast<Index>(sets_.size()) - 1;
}

Index MeshBody::track_mean(const std::vector<Index>& nodes) {
  means_.push_back(nodes);
  return static_cast<Index>(means_.size()) - 1;
}

void MeshBody::gather(const Points& u, const std::vector<Index>& nodes, Points& x) const {
  x.resize(static_cast<Index>(nodes.size()), 3);
  for (Index i = 0; i < x.rows(); ++i) x.row(i) = X_.row(nodes[i]) + (placement_.T * u.row(nodes[i]).transpose()).transpose();
}

void MeshBody::positions(Index set, Points& x) const { gather(u_, sets_[set], x); }
void MeshBody::predicted_positions(Index set, Points& x) const { gather(u_end_, sets_[set], x); }

MotionBound MeshBody::motion_bound(Index) const {
  assert(false && "only exact bodies have a bound");
  return {};
}

void MeshBody::mean_motion(Index set, Vector3& position, Vector3& velocity) const {
  const auto& nodes = means_[set];
  position = X_(nodes, Eigen::all).colwise().mean().transpose() + placement_.T * u_(nodes, Eigen::all).colwise().mean().transpose();
  velocity = placement_.T * present_velocities()(nodes, Eigen::all).colwise().mean().transpose();
}

void MeshBody::load(double t, Points& f) const {
  f.setZero();
  for (const NodalLoad& load : loads_) f += history_value(load.history, t) * load.force;
}

void MeshBody::accelerations(const Points& force, Points& a) const {
  if (consistent()) {
    // a = Z (Z^T M Z)^-1 Z^T f
    Matrix reduced = Z_.transpose() * flat(force);
    factor_->solve_in_place(reduced);
    flat(a).noalias() = Z_ * Vector(reduced);
    return;
  }
  a.array() = force.array().colwise() / model_->mass.array();
  for (const HeldDirection& h : held_) a.row(h.node) -= a.row(h.node).dot(h.direction.transpose()) * h.direction.transpose();
}

const Points& MeshBody::internal_forces() const {
  if (!Ku_is_current_) multiply(model_->K, u_, Ku_, *threads_);
  Ku_is_current_ = true;
  return Ku_;
}

void MeshBody::total_accelerations(Points& a) const {
  if (loads_.empty()) {
    force_ = -internal_forces();
  } else {
    load(t_, force_);
    force_ -= internal_forces();
  }
  accelerations(force_, a);
}

// The mid-step velocity, half a step on under the internal forces and loads: second order at t_.
const Points& MeshBody::present_velocities() const {
  if (v_now_is_current_) return v_now_;
  v_now_ = v_;
  if (last_h_ > 0) {
    total_accelerations(scratch_);
    v_now_ += 0.5 * last_h_ * scratch_;
  }
  v_now_is_current_ = true;
  return v_now_;
}

std::span<const HeldDirection> MeshBody::held_of(Index node) const {
  const auto [first, last] = std::equal_range(held_.begin(), held_.end(), HeldDirection{node, {}},
                                              [](const HeldDirection& a, const HeldDirection& b) { return a.node < b.node; });
  return {first, last};
}

void MeshBody::predict(double t, double h) {
  t_ = t, h_ = h;
  total_accelerations(scratch_);
  if (last_h_ == 0) {
    // v- half a step before t = 0; booked as work of the loads, so that the energy balance starts from the given velocity.
    const Points back = v_ - 0.5 * h * scratch_;
    work_.external += 0.5 * (scalar_product(back, back) - scalar_product(v_, v_));
    v_ = back;
    last_h_ = h;
  }
  v_end_ = v_ + 0.5 * (last_h_ + h) * scratch_;
  u_end_ = u_ + h * v_end_;
  kicks_.clear();
}

void MeshBody::add_impulses(Index set, const Points& impulses, ImpulseKind kind) {
  const auto& nodes = sets_[set];
  if (consistent()) {
    force_.setZero();
    for (Index i = 0; i < impulses.rows(); ++i) force_.row(nodes[i]) += impulses.row(i) * placement_.T;
    accelerations(force_, scratch_);
    v_end_ += scratch_;
    u_end_ += h_ * scratch_;
  }
  for (Index i = 0; i < impulses.rows(); ++i) {
    if (impulses.row(i).isZero(0)) continue;
    const Index node = nodes[i];
    const Vector3 p = placement_.T.transpose() * impulses.row(i).transpose();
    kicks_.push_back({node, p, kind});
    if (consistent()) continue;
    Vector3 dv = p / model_->mass[node];
    for (const HeldDirection& h : held_of(node)) dv -= dv.dot(h.direction) * h.direction;
    v_end_.row(node) += dv.transpose();
    u_end_.row(node) += h_ * dv.transpose();
  }
}

Vector3 MeshBody::add_velocities(Index set, const Points& velocities, const Vector3&) {
  // With nodal masses impulses do just this; a consistent mass is weighed by its row sums, as a nodal enforcement would have it.
  Points impulses = velocities;
  for (Index i = 0; i < impulses.rows(); ++i) impulses.row(i) *= model_->mass[sets_[set][i]];
  add_impulses(set, impulses, ImpulseKind::contact);
  return Vector3::Zero();
}

void MeshBody::accept() {
  // The leapfrog's own energy answers to forces with the average of v- and v+.
  for (const Kick& kick : kicks_) {
    const double work = 0.5 * kick.impulse.dot((v_.row(kick.node) + v_end_.row(kick.node)).transpose());
    (kick.kind == ImpulseKind::friction ? work_.friction : work_.contact) += work;
  }
  if (!loads_.empty()) {
    load(t_, force_);
    work_.external += 0.25 * (last_h_ + h_) * flat(force_).dot(flat(v_) + flat(v_end_));
  }
  last_h_ = h_;
  Ku_is_current_ = v_now_is_current_ = false;
  u_.swap(u_end_);
  v_.swap(v_end_);
  t_ += h_;
}

}  // namespace cbr
