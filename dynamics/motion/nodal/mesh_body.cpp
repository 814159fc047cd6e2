// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/nodal/mesh_body.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "dynamics/motion/nodal/mesh_kernels.hpp"

namespace cbr {
namespace {

Eigen::Map<const Vector> flat(const Field& p) { return {p.data(), p.size()}; }

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

// Nodes that are held whole are held along the axes: then it does not matter how an instance is
// turned, and hold() leaves nothing.
void take_axes(std::vector<HeldDirection>& held) {
  for (std::size_t i = 0; i + 2 < held.size(); ++i) {
    if (held[i + 2].node != held[i].node) continue;
    for (int c = 0; c < 3; ++c, ++i) held[i].direction = Vector3::Unit(c);
    --i;
  }
}

}  // namespace

MeshBody::MeshBody(std::string name, std::shared_ptr<const MeshModel> model,
                   const Placement& placement, const std::vector<HeldDirection>& held,
                   std::shared_ptr<RowThreads> threads, MeshOptions options)
    : Body({.name = std::move(name),
            .scheme = Scheme::central_difference,
            .n_dofs = 3 * model->mass.size() - static_cast<Index>(held.size()),
            .positions = placement.placed(model->coordinates)}),
      still_(std::move(options.statics)),
      model_(std::move(model)),
      placement_(placement),
      held_(held),
      threads_(std::move(threads)),
      damping_(options.damping) {
  const Index n = model_->mass.size();
  for (Field* p : {&u_, &v_, &u_end_}) p->setZero(n, 3);
  for (Field* p : {&load_, &Ku_, &v_now_}) p->resize(n, 3);
  for (HeldDirection& h : held_) h.node = model_->row_of_node[h.node];
  std::stable_sort(held_.begin(), held_.end(),
                   [](const HeldDirection& a, const HeldDirection& b) { return a.node < b.node; });
  take_axes(held_);
  if (consistent()) {
    Z_ = free_basis(n, held_);
    factor_ = std::make_shared<SparseCholesky>(SparseMatrix(Z_.transpose() * model_->M * Z_));
    if (!factor_->ok())
      throw RunError("instance '" + facts_.name +
                     "': the consistent mass is not positive definite");
  }
  v_.rowwise() = (placement_.T.transpose() * placement_.velocity).transpose();
  v_(model_->rotations, Eigen::all).setZero();
  hold_velocity();
  largest_frequency_ = held_.empty() ? model_->largest_frequency : held_frequency();
  if (options.angular_velocity) turn_freely(*options.angular_velocity);
}

std::vector<Index> MeshBody::rows(const std::vector<Index>& nodes) const {
  std::vector<Index> rows;
  for (const Index node : nodes) rows.push_back(model_->row_of_node[node]);
  return rows;
}

Points MeshBody::by_nodes(const Field& u) const {
  Points p(u.rows(), 3);
  for (Index i = 0; i < p.rows(); ++i) p.row(model_->forces.order()[i]) = u.row(i);
  return p;
}

Index MeshBody::own_track(const std::vector<Index>& nodes) {
  sets_.push_back(rows(nodes));
  v_before_.emplace_back(static_cast<Index>(nodes.size()), 3);
  if (still_) still_->track(nodes);
  return static_cast<Index>(sets_.size()) - 1;
}

Index MeshBody::own_track_mean(const std::vector<Index>& nodes) {
  means_.push_back(rows(nodes));
  return static_cast<Index>(means_.size()) - 1;
}

void MeshBody::gather(const Field& u, const std::vector<Index>& rows, Points& x) const {
  x.resize(static_cast<Index>(rows.size()), 3);
  const auto& node = model_->forces.order();
  const Points& X = own_nodes();
  for (Index i = 0; i < x.rows(); ++i)
    x.row(i) = X.row(node[rows[i]]) + (placement_.T * u.row(rows[i]).transpose()).transpose();
}

void MeshBody::own_positions(Index set, Points& x) const {
  if (still_) return still_->positions(set, x);
  gather(u_, sets_[set], x);
}
void MeshBody::own_predicted_positions(Index set, Points& x) const {
  if (still_) return still_->predicted_positions(set, x);
  gather(u_end_, sets_[set], x);
}

void MeshBody::own_mean_motion(Index set, Vector3& position, Vector3& velocity) const {
  const Field& v = present_velocities();
  const auto& node = model_->forces.order();
  Vector3 X = Vector3::Zero(), u = X, rate = X;
  for (const Index row : means_[set]) {
    X += own_nodes().row(node[row]).transpose();
    u += u_.row(row).transpose();
    rate += v.row(row).transpose();
  }
  const auto n = static_cast<double>(means_[set].size());
  position = (X + placement_.T * u) / n;
  velocity = placement_.T * rate / n;
}

void MeshBody::load(double t, Field& f) const {
  f.setZero();
  for (const auto& load : loads_) load.force.add_to(f, load.history.value(t));
  if (turning_) add_turned_loads(t, f);
}

void MeshBody::hold(Field& v) const {
  for (const HeldDirection& h : held_)
    v.row(h.node) -= v.row(h.node).dot(h.direction.transpose()) * h.direction.transpose();
}

// As supports that take hold at once would leave it, like that of all other bodies: of a consistent
// mass the nodes beside the held ones change theirs too.
void MeshBody::hold_velocity() {
  if (held_.empty() || !consistent()) return hold(v_);
  const Points v = v_;
  const Vector momentum = model_->M * Eigen::Map<const Vector>(v.data(), v.size());
  accelerations(Field(Eigen::Map<const Points>(momentum.data(), v.rows(), 3)), v_);
}

void MeshBody::accelerations(const Field& force, Field& a) const {
  if (consistent()) {
    // a = Z (Z^T M Z)^-1 Z^T f; rows are nodes
    const Points f = force;
    Matrix reduced = Z_.transpose() * Eigen::Map<const Vector>(f.data(), f.size());
    factor_->solve_in_place(reduced);
    const Vector free = Z_ * Vector(reduced);
    a = Eigen::Map<const Points>(free.data(), f.rows(), 3);
    return;
  }
  a.array() = force.array().colwise() * model_->inverse_mass.array();
  hold(a);
}

void MeshBody::stiffness_forces(const Field& u, Field& Ku) const {
  model_->forces.each(
      u, *threads_, room_, [&](Index begin, Index end, const double* f, Index stride) {
        for (int c = 0; c < 3; ++c)
          std::copy(f + c * stride, f + c * stride + end - begin, Ku.col(c).data() + begin);
      });
}

double MeshBody::held_frequency() const {
  const std::scoped_lock guard(model_->of_held->lock);
  for (const auto& [held, omega] : model_->of_held->known)
    if (held == held_) return omega;
  return model_->of_held->known.emplace_back(held_, find_held_frequency()).second;
}

// In coordinates of the free directions alone: parts of a vector that nothing sees would grow from
// product to product.
double MeshBody::find_held_frequency() const {
  const Index n = model_->mass.size();
  const SparseMatrix Z = consistent() ? Z_ : free_basis(n, held_);  // 3 n x free, rows of the nodes
  if (Z.cols() == 0) return 0;
  Field u(n, 3), f(n, 3);
  Points p;
  const auto to_field = [&](const Vector& x, Field& field) {
    const Vector all = Z * x;
    field = Eigen::Map<const Points>(all.data(), n, 3);
  };
  const auto to_free = [&](const Field& field, Vector& x) {
    p = field;
    x = Z.transpose() * Eigen::Map<const Vector>(p.data(), p.size());
  };
  const double lambda = largest_eigenvalue(
      Z.cols(),
      [&](const Vector& x, Vector& Kx) {
        to_field(x, u);
        stiffness_forces(u, f);
        to_free(f, Kx);
      },
      [&](const Vector& x, Vector& a) {
        if (consistent()) return factor_->solve(x.data(), a.data());
        to_field(x, u);
        u.array().colwise() *= model_->inverse_mass.array();
        to_free(u, a);
      });
  return std::sqrt(lambda);
}

const Field& MeshBody::internal_forces() const {
  if (turning_) return turned_forces();
  if (Ku_is_current_) return Ku_;
  stiffness_forces(u_, Ku_);
  Ku_is_current_ = true;
  return Ku_;
}

// K u . v
double MeshBody::scalar_product_of_forces(const Field& v) const {
  return flat(internal_forces()).dot(flat(v));
}

void MeshBody::total_accelerations(Field& a) const {
  if (!is_loaded()) return accelerations(-internal_forces(), a);
  load(t_, load_);
  accelerations(load_ - internal_forces(), a);
}

// The mid-step velocity, half a step on under the internal forces and loads: second order at t_.
const Field& MeshBody::present_velocities() const {
  if (v_now_is_current_) return v_now_;
  v_now_ = v_;
  if (last_h_ > 0) {
    damped_accelerations(v_now_);
    if (lasting_.rows() > 0) v_now_ += lasting_;
    v_now_ = kick_share(last_h_) * (v_ + 0.5 * last_h_ * v_now_);
  }
  v_now_is_current_ = true;
  return v_now_;
}

std::span<const HeldDirection> MeshBody::held_of(Index row) const {
  const auto [first, last] = std::equal_range(
      held_.begin(), held_.end(), HeldDirection{row, {}},
      [](const HeldDirection& a, const HeldDirection& b) { return a.node < b.node; });
  return {first, last};
}

// v- half a step before t = 0; booked as work of the loads, so that the energy balance starts from
// the given velocity.
void MeshBody::start(double h) {
  Field back(v_.rows(), 3);
  total_accelerations(back);
  back = v_ - 0.5 * h * back;
  work_.external += 0.5 * (scalar_product(back, back) - scalar_product(v_, v_));
  if (is_damped()) {
    const double without = scalar_product(back, back);
    damped_accelerations(back);
    back = v_ - 0.5 * h * (back - damping_.alpha * v_);
    work_.damping += 0.5 * (scalar_product(back, back) - without);
  }
  v_ = back;
  last_h_ = h;
}

// v+ = v- + s M^-1 (f - K u),  u_end = u + h v+: in the pass that forms K u, unless that is known.
void MeshBody::leap(double s, double h) {
  const auto on_rows = [&](Index begin, Index end, const double* f, Index stride) {
    for (int c = 0; c < 3; ++c)
      leapfrog({f + c * stride, !is_loaded() ? nullptr : load_.col(c).data() + begin,
                model_->inverse_mass.data() + begin, u_.col(c).data() + begin,
                v_.col(c).data() + begin, u_end_.col(c).data() + begin},
               end - begin, s, h);
  };
  if (turning_) return leap_turned(s, h);
  if (Ku_is_current_) {
    threads_->for_rows(u_.rows(), [&](Index begin, Index end) {
      on_rows(begin, end, Ku_.data() + begin, Ku_.rows());
    });
  } else {
    model_->forces.each(u_, *threads_, room_, on_rows);
  }
  if (held_.empty()) return;
  hold(v_);
  for (const HeldDirection& held : held_)
    u_end_.row(held.node) = u_.row(held.node) + h * v_.row(held.node);
}

// M^-1 (f - K u - beta K v-): the stiffness part of the damping is half a step late.
void MeshBody::damped_accelerations(Field& a) const {
  if (damping_.beta == 0) return total_accelerations(a);
  Kv_.resize(u_.rows(), 3);
  turning_ ? turned_damping(v_, Kv_) : stiffness_forces(v_, Kv_);
  Field force = -internal_forces() - damping_.beta * Kv_;
  if (is_loaded()) {
    load(t_, load_);
    force += load_;
  }
  accelerations(force, a);
}

// (1 + alpha h / 2) v+ = (1 - alpha h- / 2) v- + s M^-1 (f - K u - beta K v-),  u_end = u + h v+.
void MeshBody::leap_damped(double s, double h) {
  v_old_ = v_;
  damped_accelerations(u_end_);
  v_ = kick_share(h) * ((1 - 0.5 * last_h_ * damping_.alpha) * v_ + s * u_end_);
  u_end_ = u_ + h * v_;
}

// (v- + v+) / 2 times the damping's impulse  -alpha / 2 M (h- v- + h v+) - s beta K v-.
double MeshBody::damping_work() const {
  const Field mean = 0.5 * (v_old_ + v_);
  double work = -0.5 * damping_.alpha * scalar_product(mean, last_h_ * v_old_ + h_ * v_);
  if (damping_.beta > 0) work -= 0.5 * (last_h_ + h_) * damping_.beta * flat(mean).dot(flat(Kv_));
  return work;
}

void MeshBody::predict_end() {
  const double h = h_;
  if (last_h_ == 0) start(h);
  for (std::size_t set = 0; set < sets_.size(); ++set)
    for (Index i = 0; i < v_before_[set].rows(); ++i) v_before_[set].row(i) = v_.row(sets_[set][i]);
  const double s = 0.5 * (last_h_ + h);
  if (h != last_h_ && !turning_) Ku_v_before_ = scalar_product_of_forces(v_);
  if (is_loaded()) {
    load(t_, load_);
    work_.external += 0.5 * s * flat(load_).dot(flat(v_));  // the other half in accept()
  }
  if (turning_) forget_end();
  if (is_damped()) {
    leap_damped(s, h);
  } else if (consistent()) {
    total_accelerations(u_end_);
    v_ += s * u_end_;
    u_end_ = u_ + h * v_;
  } else {
    leap(s, h);
  }
  if (turning_) turn_nodes();
  kicks_.clear();
  lasting_.resize(0, 3);
}

// Velocities between two steps are those under them.
void MeshBody::own_expect_forces(Index set, const Points& forces) {
  v_now_is_current_ = false;
  lasting_.resize(0, 3);
  if (forces.rows() == 0) return;
  lasting_.setZero(u_.rows(), 3);
  for (Index i = 0; i < forces.rows(); ++i)
    lasting_.row(sets_[set][i]) += forces.row(i) * placement_.T;
  accelerations(Field(lasting_), lasting_);
}

void MeshBody::own_take_impulses(Index set, const Impulses& of) {
  const Points& impulses = of.all;
  if (turning_ && consistent()) forget_end();
  const auto& rows = sets_[set];
  if (consistent()) {
    Field change = Field::Zero(u_.rows(), 3);
    for (Index i = 0; i < impulses.rows(); ++i)
      change.row(rows[i]) += impulses.row(i) * placement_.T;
    accelerations(Field(change), change);
    if (is_damped()) change *= kick_share(h_);
    v_ += change;
    u_end_ += h_ * change;
  }
  for (Index i = 0; i < impulses.rows(); ++i) {
    if (impulses.row(i).isZero(0)) continue;
    const Index row = rows[i];
    const Vector3 p = placement_.T.transpose() * impulses.row(i).transpose();
    kicks_.push_back({row, p, v_before_[set].row(i).transpose()});
    if (consistent()) continue;
    Vector3 dv = p / model_->mass[row];
    if (is_damped()) dv *= kick_share(h_);
    for (const HeldDirection& h : held_of(row)) dv -= dv.dot(h.direction) * h.direction;
    v_.row(row) += dv.transpose();
    u_end_.row(row) += h_ * dv.transpose();
    if (turning_) move_end(row, h_ * dv);
  }
}

Vector3 MeshBody::own_add_velocities(Index set, const Points& velocities, const Vector3&) {
  // With nodal masses impulses do just this; a consistent mass is weighed by its row sums, as a
  // nodal enforcement would have it.
  Points impulses = velocities;
  for (Index i = 0; i < impulses.rows(); ++i) impulses.row(i) *= model_->mass[sets_[set][i]];
  take_impulses(set, {impulses});
  return Vector3::Zero();
}

void MeshBody::own_accept() {
  // The leapfrog's own energy answers to forces with the average of v- and v+.
  for (const Kick& kick : kicks_)
    work_.contact += 0.5 * kick.impulse.dot(kick.v_before + v_.row(kick.row).transpose());
  if (turning_) book_moments();
  if (is_loaded()) work_.external += 0.25 * (last_h_ + h_) * flat(load_).dot(flat(v_));
  if (is_damped()) work_.damping += damping_work();
  // Its energy holds a term -h/2 v . K u: a change of h brings (h - h-)/4 K u . (v+ - v-).
  if (h_ != last_h_ && !turning_)
    work_.numerical += 0.25 * (h_ - last_h_) * (scalar_product_of_forces(v_) - Ku_v_before_);
  last_h_ = h_;
  Ku_is_current_ = v_now_is_current_ = false;
  if (turning_) fit_at_end();
  u_.swap(u_end_);
  if (turning_) fit_now();
  t_ += h_;
}

}  // namespace cbr
