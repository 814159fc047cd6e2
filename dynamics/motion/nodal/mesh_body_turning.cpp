// SPDX-License-Identifier: GPL-3.0-or-later
// What a mesh body does that turns by any angle.
#include <Eigen/LU>

#include <utility>

#include "common/files/state_archive.hpp"
#include "dynamics/motion/nodal/mesh_body.hpp"
#include "dynamics/motion/nodal/mesh_frame.hpp"

namespace cbr {
namespace {

// sum a_i x f_i
Vector3 sum_of_moments(const Field& a, const Field& f) {
  Vector3 sum;
  for (int c = 0; c < 3; ++c) {
    const int i = (c + 1) % 3, j = (c + 2) % 3;
    sum[c] = a.col(i).dot(f.col(j)) - a.col(j).dot(f.col(i));
  }
  return sum;
}

// w x a_i
Field turned_by(const Vector3& w, const Field& a) {
  Field v(a.rows(), 3);
  for (int c = 0; c < 3; ++c) {
    const int i = (c + 1) % 3, j = (c + 2) % 3;
    v.col(c) = w[i] * a.col(j) - w[j] * a.col(i);
  }
  return v;
}

}  // namespace

// What turns with the axes of a mesh.
struct MeshBody::Turning {
  struct Load {
    std::vector<Index> rows;
    std::array<Points, 3> patterns;  // of these, component axes at the start
    Vector3 value;
    bool follows;
    LoadHistory history;
  };
  // Moments of this step: a turn of the velocities by `w` each, component axes.
  struct Moment {
    Vector3 moment, w;
  };

  std::shared_ptr<const MeshFrame> frame;
  MeshFit now, end;
  bool end_is_known = false;
  // Of u_end_: as the step has left it, and with the impulses of contact
  MeshFrame::Sums sums;
  bool sums_are_known = false;
  // Ku_ has K d in the axes of the fit
  Vector3 lambda = Vector3::Zero();
  Field gradient;
  Matrix3 R = Matrix3::Identity();  // now, scene axes
  std::vector<Load> loads;
  std::vector<Moment> moments;
  Field d;
  double energy_0 = 0;  // at the start
};

void MeshBody::turn_freely(const Vector3& angular_velocity) {
  const Matrix3& T = placement_.T;
  turning_.reset(new Turning);
  {
    const std::lock_guard<std::mutex> lock(model_->of_turned->lock);
    std::shared_ptr<const MeshFrame>& frame = model_->of_turned->frame;
    if (!frame) frame = std::make_shared<MeshFrame>(*model_);
    turning_->frame = frame;
  }
  turning_->d.resize(u_.rows(), 3);
  v_ += spun(T.determinant() * (T.transpose() * angular_velocity));
  fit_now();
  turning_->energy_0 = 0.5 * scalar_product(v_, v_);
}

void MeshBody::fit_now() {
  Turning& of = *turning_;
  of.now = of.end_is_known ? of.end : of.frame->fit(of.frame->sums(u_, *threads_), of.now);
  of.end_is_known = false;
  of.R = placement_.T * of.now.R * placement_.T.transpose();
}

void MeshBody::forget_end() { turning_->end_is_known = turning_->sums_are_known = false; }

void MeshBody::move_end(Index row, const Vector3& u) {
  if (turning_->sums_are_known) turning_->frame->add(row, u, turning_->sums);
  turning_->end_is_known = false;
}

const MeshFit& MeshBody::fit_at_end() const {
  Turning& of = *turning_;
  if (!of.sums_are_known) of.sums = of.frame->sums(u_end_, *threads_);
  of.sums_are_known = true;
  if (!of.end_is_known) of.end = of.frame->fit(of.sums, of.now);
  of.end_is_known = true;
  return of.end;
}

// K d and what makes it a gradient, formed once for each u.
void MeshBody::form_turned_forces() const {
  Turning& of = *turning_;
  if (Ku_is_current_) return;
  of.frame->strain(of.now, u_, of.d, *threads_);
  stiffness_forces(of.d, Ku_);
  of.frame->turn_moments(of.d, Ku_);
  of.lambda = of.frame->lambda(of.now, of.d, Ku_, *threads_);
  Ku_is_current_ = true;
}

const Field& MeshBody::turned_forces() const {
  Turning& of = *turning_;
  form_turned_forces();
  of.frame->pull_back(of.now, of.lambda, Ku_, of.gradient);
  return of.gradient;
}

// beta = 1: K times the rates of the strain.
void MeshBody::turned_damping(const Field& v, Field& f) const {
  const Turning& of = *turning_;
  form_turned_forces();
  Field rates(v.rows(), 3), of_body(v.rows(), 3);
  of.frame->strain_rates(of.now, of.d, v, rates);
  stiffness_forces(rates, of_body);
  of.frame->turn_moments(of.d, of_body);
  of.frame->pull_back(of.now, of.frame->lambda(of.now, of.d, of_body, *threads_), of_body, f);
}

void MeshBody::leap_turned(double s, double h) {
  Turning& of = *turning_;
  form_turned_forces();
  of.sums = of.frame->leap(
      of.now, of.lambda,
      {Ku_, u_, is_loaded() ? &load_ : nullptr, model_->inverse_mass, v_, u_end_, s, h}, *threads_);
  of.end_is_known = false;
  of.sums_are_known = true;
}

void MeshBody::turn_nodes() {
  for (const Index i : model_->rotations)
    u_end_.row(i) = MeshFrame::turned(h_ * v_.row(i).transpose(), u_.row(i).transpose());
}

Vector3 MeshBody::spin_of_nodes(const Field& p) const {
  return p(model_->rotations, Eigen::all).colwise().sum().transpose();
}

Field MeshBody::spun(const Vector3& w) const {
  Field v = turned_by(w, arms_now());
  for (const Index i : model_->rotations) v.row(i) = w.transpose();
  return v;
}

bool MeshBody::is_loaded() const {
  return !loads_.empty() || (turning_ && !turning_->loads.empty());
}

void MeshBody::add_turned_loads(double t, Field& f) const {
  const Turning& of = *turning_;
  for (const Turning::Load& load : of.loads) {
    const Vector3 b = load.history.value(t) *
                      (load.follows ? load.value : Vector3(of.R.transpose() * load.value));
    Points forces = Points::Zero(static_cast<Index>(load.rows.size()), 3);
    for (int a = 0; a < 3; ++a) forces += b[a] * load.patterns[a];
    forces *= of.now.R.transpose();
    for (Index i = 0; i < forces.rows(); ++i) f.row(load.rows[i]) += forces.row(i);
  }
}

void MeshBody::add_turned_load(const VectorForce& force, const LoadHistory& history) {
  Turning::Load added{{}, {}, force.value, force.follows, history};
  std::array<Points, 3> by_rows;
  for (std::size_t a = 0; a < 3; ++a) {
    const Points forces = force.patterns[a].forces.on_nodes();
    by_rows[a].setZero(u_.rows(), 3);
    for (Index i = 0; i < forces.rows(); ++i)
      by_rows[a].row(model_->row_of_node[i]) = forces.row(i) * placement_.T;
  }
  for (Index i = 0; i < u_.rows(); ++i)
    if (!by_rows[0].row(i).isZero(0) || !by_rows[1].row(i).isZero(0) ||
        !by_rows[2].row(i).isZero(0))
      added.rows.push_back(i);
  for (std::size_t a = 0; a < 3; ++a) added.patterns[a] = by_rows[a](added.rows, Eigen::all);
  turning_->loads.push_back(std::move(added));
}

Matrix3 MeshBody::turn_of_step() const { return turning_->R; }

BodyTurn MeshBody::turn_of(const MeshFit& fit) const {
  const Matrix3& T = placement_.T;
  return {T * (model_->rigid_body.center + fit.shift) + placement_.position,
          T * fit.R * T.transpose()};
}
BodyTurn MeshBody::turn_now() const { return turn_of(turning_->now); }
BodyTurn MeshBody::turn_at_end() const { return turn_of(fit_at_end()); }

Vector3 MeshBody::spin() const {
  const Turning& of = *turning_;
  const Vector3 w = of.now.R * of.frame->turn(of.now, present_velocities());
  return placement_.T.determinant() * (placement_.T * w);
}

void MeshBody::unturned(const MeshFit& fit, const Field& u, Index set, Points& x) const {
  const auto& rows = sets_[set];
  const auto& node = model_->forces.order();
  x.resize(static_cast<Index>(rows.size()), 3);
  for (Index i = 0; i < x.rows(); ++i) {
    const Vector3 all = fit.shift + turning_->frame->strain(fit, u, rows[i]);
    x.row(i) = own_nodes().row(node[rows[i]]) + (placement_.T * all).transpose();
  }
}
void MeshBody::unturned_positions(Index set, Points& x) const {
  unturned(turning_->now, u_, set, x);
}
void MeshBody::unturned_end(Index set, Points& x) const { unturned(fit_at_end(), u_end_, set, x); }

// By rows, component axes: c + d, and the rates of these.
void MeshBody::unturned_fields(Field& u, Field& v) const {
  const Turning& of = *turning_;
  const Field& rates = present_velocities();
  u.resize(u_.rows(), 3);
  v.resize(u_.rows(), 3);
  of.frame->strain(of.now, u_, u, *threads_);
  const Field d = u;
  u.rowwise() += of.now.shift.transpose();
  of.frame->strain_rates(of.now, d, rates, v);
  const Field own = v(model_->rotations, Eigen::all);
  v.rowwise() += (momenta(rates).head<3>() / model_->rigid_body.mass).transpose();
  u(model_->rotations, Eigen::all) = d(model_->rotations, Eigen::all);
  v(model_->rotations, Eigen::all) = own;
}

void MeshBody::unturned_displacements(Points& u, Points& v) const {
  Field of_rows, rates;
  unturned_fields(of_rows, rates);
  u = by_nodes(of_rows) * placement_.T.transpose();
  v = by_nodes(rates) * placement_.T.transpose();
}

void MeshBody::own_turn(const Points& X, Points& u, Points& v) const {
  if (!turning_) return;
  const Vector3 v_c =
      placement_.T * (momenta(present_velocities()).head<3>() / model_->rigid_body.mass);
  turn_points(turn_now(), v_c, spin(), X, u, v);
}

Field MeshBody::arms_now() const {
  Field arms = (u_.rowwise() - turning_->now.shift.transpose()) + turning_->frame->Y();
  arms(model_->rotations, Eigen::all).setZero();
  return arms;
}

Field MeshBody::momenta_of_nodes(const Field& v) const {
  if (!consistent()) return v.array().colwise() * model_->mass.array();
  const Points by_node = v;
  const Vector p = model_->M * Eigen::Map<const Vector>(by_node.data(), by_node.size());
  return Eigen::Map<const Points>(p.data(), v.rows(), 3);
}

// As impulses on all nodes that set the body spinning as if it were rigid.
void MeshBody::add_moment(const Vector3& moment) {
  if (moment.isZero(0)) return;
  const Matrix3& T = placement_.T;
  const Field y = arms_now();
  const Matrix3 P = y.transpose() * momenta_of_nodes(y);
  const Matrix3 J = (P.trace() + model_->mass(model_->rotations).sum()) * Matrix3::Identity() - P;
  const Vector3 of = T.determinant() * (T.transpose() * moment);
  const Vector3 w = J.inverse() * of;
  turning_->moments.push_back({of, w});
  const Field change = spun(w);
  v_ += change;
  u_end_ += h_ * change;
  turn_nodes();
  forget_end();
}

// The average of the angular momenta of v- and v+ times the turn: as of all other impulses. Forces
// inside have no moment.
void MeshBody::book_moments() {
  Turning& of = *turning_;
  if (of.moments.empty()) return;
  const Field y = arms_now();
  Vector3 change = Vector3::Zero();
  for (const Turning::Moment& moment : of.moments) change += moment.moment;
  for (const Kick& kick : kicks_) change += Vector3(y.row(kick.row)).cross(kick.impulse);
  if (is_loaded()) change += 0.5 * (last_h_ + h_) * sum_of_moments(y, load_);
  const Field p = momenta_of_nodes(v_);
  const Vector3 mean = sum_of_moments(y, p) + spin_of_nodes(p) - 0.5 * change;
  for (const Turning::Moment& moment : of.moments) work_.contact += moment.w.dot(mean);
  of.moments.clear();
}

BodyState MeshBody::turned_state() const {
  const Turning& of = *turning_;
  const Matrix3& T = placement_.T;
  const Field& Ku = internal_forces();
  const Field p = momenta_of_nodes(present_velocities());
  BodyState state;
  state.center_of_mass = turn_now().center;
  const Vector3 of_nodes = spin_of_nodes(p);
  state.momentum = T * (p.colwise().sum().transpose() - of_nodes);
  state.angular_momentum = T.determinant() * (T * (sum_of_moments(arms_now(), p) + of_nodes)) +
                           state.center_of_mass.cross(state.momentum);
  state.kinetic_energy = 0.5 * scalar_product(v_, v_) - 0.5 * last_h_ * v_.cwiseProduct(Ku).sum();
  state.strain_energy = 0.5 * of.d.cwiseProduct(Ku_).sum();
  const Eigen::Quaterniond& q = of.now.q;
  const Vector3 axis = T.determinant() * (T * q.vec());
  state.orientation = Eigen::Vector4d(q.w(), axis[0], axis[1], axis[2]);
  return state;
}

// Central differences keep no energy of forces that are not linear: what is left, which swings with
// the square of the step, is the integrator's.
BodyWork MeshBody::own_work() const {
  if (!turning_) return work_;
  BodyWork work = work_;
  const BodyState now = turned_state();
  work.numerical = now.kinetic_energy + now.strain_energy - turning_->energy_0 - work.external -
                   work.contact - work.damping;
  return work;
}

void MeshBody::keep_turning(StateArchive& archive) {
  Turning& of = *turning_;
  archive(of.now.shift, of.now.q.coeffs(), of.now.R, of.now.less_one, of.now.inverse_G, of.R);
}

}  // namespace cbr
