// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/modal_body.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

Eigen::Map<Vector> flat(Points& p) { return {p.data(), p.size()}; }

bool is_massless(const ModalForm& form) { return form.residual && form.residual->is_massless; }

// An interface without mass changes the energy as it lands and lets go. Of a bouncing bar it was
// 1.3e-3 at 0.16 of the critical step and 3.5e-2 at 0.33: docs/decisions/massless.md, "Steps".
constexpr double massless_share = 0.2;

}  // namespace

ModalBody::ModalBody(std::string name, std::shared_ptr<const Superelement> superelement,
                     std::shared_ptr<const ModalForm> form, const Placement& placement,
                     Scheme scheme, const NewmarkOptions& newmark, const Damping& damping)
    : Body({.name = std::move(name),
            .scheme = scheme,
            .n_dofs = form->omega.size(),
            .positions = placement.placed(superelement->coordinates),
            .steps_alone = scheme == Scheme::exact,
            .contact_share = is_massless(*form) ? massless_share : 1,
            .kicks_at_end = is_massless(*form)}),
      superelement_(std::move(superelement)),
      form_(std::move(form)),
      placement_(placement),
      rows_(form_->shared.row_table(*superelement_)),
      residual_(form_, rows_, placement.T, damping.material.beta),
      damping_(damping.rates(form_->omega)),
      flow_(form_, damping_),
      newmark_(newmark, form_, damping_),
      kick_(form_->omega.size()),
      end_kick_(form_->omega.size()) {
  assert(scheme != Scheme::newmark || !is_massless(*form_));
  const Index n = form_->omega.size();
  for (Vector* x : {&now_.eta, &now_.v, &end_.eta, &end_.v, &f_}) x->setZero(n);
  // v = V^T M^ R_t v0: the rigid motion, or its projection when directions are constrained.
  now_.v.noalias() = form_->E.leftCols(3) * (placement_.T.transpose() * placement_.velocity);
}

double ModalBody::largest_frequency() const {
  return form_->residual ? residual_.critical_frequency() : form_->highest();
}

Index ModalBody::own_track(const std::vector<Index>& nodes) {
  sets_.push_back({form_->shared.rows(form_->V, *rows_, nodes), own_nodes()(nodes, Eigen::all)});
  residual_.track(*sets_.back().rows);
  if (frame_) frame_->track();
  local_.resize(std::max<Index>(local_.rows(), static_cast<Index>(nodes.size())), 3);
  return static_cast<Index>(sets_.size()) - 1;
}

Index ModalBody::own_track_mean(const std::vector<Index>& nodes) {
  means_.push_back({form_->shared.mean_rows(form_->V, *rows_, nodes),
                    own_nodes()(nodes, Eigen::all).colwise().mean().transpose()});
  residual_.track_mean(nodes);
  return static_cast<Index>(means_.size()) - 1;
}

void ModalBody::own_positions(Index set, Points& x) const {
  unturned_positions(set, x);
  if (frame_) frame_->turn_positions(set, x);
}

void ModalBody::own_predicted_positions(Index set, Points& x) const {
  unturned_end(set, x);
  if (frame_) frame_->turn_predicted_positions(set, x);
}

void ModalBody::unturned_positions(Index set, Points& x) const {
  sets_[set].rows->displacements(now_.eta, placement_.T, x);
  x += sets_[set].X;
  residual_.add_positions(set, x);
}

void ModalBody::unturned_end(Index set, Points& x) const {
  sets_[set].rows->displacements(end_.eta, placement_.T, x);
  x += sets_[set].X;
  residual_.add_predicted_positions(set, x);
}

void ModalBody::own_mean_motion(Index set, Vector3& position, Vector3& velocity) const {
  const MeanSet& s = means_[set];
  position = s.X;
  velocity.setZero();
  if (now_.eta.size() > 0) {
    position += placement_.T * Vector3(s.Vt->transpose() * now_.eta);
    velocity = placement_.T * Vector3(s.Vt->transpose() * present_rates());
  }
  residual_.add_mean_motion(set, *s.Vt, now_.eta, position, velocity);
  if (frame_) frame_->turn_mean_motion(position, velocity);
}

// Leapfrog with the damping of half a step on each side of t, so that the critical step stays:
//   (1 + c h / 2) v+ = (1 - c h- / 2) v- + (h- + h)/2 (f - omega^2 eta),   eta+ = eta + h v+.
// At the start v- is half a step before t = 0.
void ModalBody::predict_central(double h) {
  flow_.loads().sum(t_, f_);
  f_ -= form_->omega.cwiseAbs2().cwiseProduct(now_.eta);
  const auto c = damping_.c.array();
  if (last_h_ == 0) {
    // The half kick back is booked as work of the loads and of damping: the energy balance starts
    // from the given velocity.
    const Vector all = f_.array() - c * now_.v.array();
    const double of_loads = 0.5 * h * f_.dot(0.25 * h * f_ - now_.v);
    work_.external += of_loads;
    work_.damping += 0.5 * h * all.dot(0.25 * h * all - now_.v) - of_loads;
    now_.v -= 0.5 * h * all;
    last_h_ = h;
  }
  // Forces at the end of the last step are a kick at the start of this one
  const bool late = is_damped() && late_;
  if (late) now_.v -= late_.start;
  end_.v = (1 - 0.5 * last_h_ * c) * now_.v.array() + 0.5 * (last_h_ + h) * f_.array();
  if (late) {
    end_.v += late_.start;
    now_.v += late_.start;
  }
  end_.v.array() /= 1 + 0.5 * h * c;
  end_.eta = now_.eta + h * end_.v;
}

void ModalBody::predict_end() { frame_ ? frame_->predict(t_, h_) : predict_modes(); }

void ModalBody::predict_modes() {
  kick_.clear();
  end_kick_.clear();
  late_.end.setZero();
  switch (scheme()) {
    case Scheme::exact:
      flow_.advance(t_, h_, now_, end_, nullptr);
      if (!facts_.kicks_at_end) kick_back();
      break;
    case Scheme::central_difference:
      predict_central(h_);
      break;
    case Scheme::newmark:
      newmark_.predict(t_, h_, flow_.loads(), now_, end_);
      break;
  }
  residual_.predict(t_, h_, frame_ ? 1 : n_steps_);
}

// f_: modal forces of forces on the set's nodes. In a frame their sum moves the centre of mass in
// the scene's axes.
void ModalBody::take_force(Index set, const Points& impulses) {
  sets_[set].rows->kick(impulses, placement_.T, local_, f_);
  if (!frame_) return;
  const auto E = form_->E.topLeftCorner(form_->n_rigid, 3);
  const Vector3 momentum =
      placement_.T.transpose() * (frame_->R() * impulses.colwise().sum().transpose());
  f_.head(form_->n_rigid).noalias() = E * (momentum / E.col(0).squaredNorm());
}

void ModalBody::own_take_impulses(Index set, const Impulses& impulses) {
  frame_ ? frame_->take_impulses(set, impulses) : push_modes(set, impulses);
}

void ModalBody::push_modes(Index set, const Impulses& impulses) {
  residual_.push(set, impulses);
  if (facts_.kicks_at_end) return add_late(set, impulses.all);
  take_force(set, impulses.all);
  flow_.amplify(f_);
  feel_kick();
}

// Of the modal kick f_ at the start of the step.
void ModalBody::feel_kick() {
  kick_.add(f_);
  if (is_exact()) return flow_.push(h_, f_, end_);
  if (scheme() == Scheme::newmark) return newmark_.push(f_, now_, end_);
  f_.array() /= 1 + 0.5 * h_ * damping_.c.array();
  end_.eta += h_ * f_;
  end_.v += f_;
}

// Forces at the end of the step, times the step. Energies are of the middle of such a kick; with
// central differences it is half of the kick of the rates of the next step.
void ModalBody::add_late(Index set, const Points& impulses) {
  if (!late_) late_.begin(now_.eta.size());
  take_force(set, impulses);
  flow_.amplify(f_);
  late_.end += f_;
  end_.v += f_;
}

Vector3 ModalBody::own_add_velocities(Index set, const Points& velocities,
                                      const Vector3& momentum) {
  if (form_->residual) lacks_nodal_masses();
  assert(scheme() != Scheme::newmark && flow_.contact_step() == 0 && !is_damped());
  const Matrix3& T = placement_.T;
  const Matrix& B = velocity_map(*sets_[set].rows);
  // change = V^T M^ [0; dv]: V^-1 of a velocity of the interface dofs alone
  Points local = velocities * T;
  f_.noalias() = B * flat(local);
  // Uniform velocity of the set's nodes for the rest of the momentum: T E^T B [I; I; ...] T^T extra
  // = momentum - T E^T f   (3 x 3)
  Matrix uniform = Matrix::Zero(f_.size(), 3);
  for (Index i = 0; i < B.cols(); ++i) uniform.col(i % 3) += B.col(i);
  const auto to_momentum = form_->E.leftCols(3).transpose();
  const Matrix3 mass = T * (to_momentum * uniform) * T.transpose();
  const Vector3 missing = momentum - T * (to_momentum * f_);
  const Vector3 extra = solve_semidefinite(mass, missing).value_or(Vector3::Zero());
  f_.noalias() += uniform * (T.transpose() * extra);
  (is_exact() ? end_kick_ : kick_).add(f_);
  end_.eta += h_ * f_;
  end_.v += f_;
  return extra;
}

// Between the kicks energy changes by the work of forces, spin and damping.
void ModalBody::accept_exact() {
  spin_work_ = 0;
  if (kick_) book_kick(kick_.sum(), now_.v, work_);
  if (is_damped() || flow_.is_driven()) {
    if (kick_) now_.v += kick_.sum();
    if (kick_) flow_.turning().forget_start();
    FlowWork flow;
    flow.external = is_damped() ? 0 : work_.external;
    flow_.advance(t_, h_, now_, end_, &flow);
    work_.external = is_damped() ? work_.external + flow.external : flow.external;
    work_.contact += flow.contact;
    spin_work_ = flow.spin;
    flow_.turning().forget_start();
    if (is_damped())
      work_.damping +=
          modal_energy(form_->omega, end_) - modal_energy(form_->omega, now_) - flow.sum();
    if (late_) end_.v += late_.end;
  }
  if (late_) accept_late();
  if (end_kick_) accept_end_kick(end_kick_.sum());
  if (!facts_.kicks_at_end) change_force();
}

// Of nodal contact.
void ModalBody::accept_end_kick(const Vector& kick) {
  if (!flow_.loads().empty()) {
    end_.eta += h_ * kick;
    end_.v += kick;
  }
  // Energy that the change at the end of the step brought: of (eta + h d, v + d) less that of (eta,
  // v)
  const auto omega2 = form_->omega.cwiseAbs2().array();
  work_.contact += kick.dot(end_.v) - 0.5 * kick.squaredNorm() +
                   h_ * (omega2 * kick.array() * (end_.eta - 0.5 * h_ * kick).array()).sum();
}

void ModalBody::accept_central() {
  // The rates before and after all of the forces at the start
  if (late_) {
    now_.v -= late_.start;
    end_.v -= late_.end;
    work_.contact += 0.5 * (late_.start + late_.end).dot(end_.v);
  }
  if (is_damped())
    work_.damping -= 0.25 * (damping_.c.array() * (last_h_ * now_.v + h_ * end_.v).array())
                                .matrix()
                                .dot(now_.v + end_.v);
  // v- and v+ average: the work of the kick and of the load that the leapfrog's own energy answers
  // to
  const double mean_h = 0.5 * (last_h_ + h_);
  if (kick_) work_.contact += 0.5 * kick_.sum().dot(now_.v + end_.v);
  if (!flow_.loads().empty()) {
    flow_.loads().sum(t_, f_);
    work_.external += 0.5 * mean_h * f_.dot(now_.v + end_.v);
  }
  // Its energy holds a term -h/2 v . omega^2 eta: a change of h brings (h - h-)/4 omega^2 eta . (v+
  // - v-).
  if (h_ != last_h_)
    work_.numerical += 0.25 * (h_ - last_h_) *
                       form_->omega.cwiseAbs2().cwiseProduct(now_.eta).dot(end_.v - now_.v);
  last_h_ = h_;
  if (late_) end_.v += late_.end;
}

void ModalBody::own_accept() { frame_ ? frame_->accept() : accept_modes(); }

void ModalBody::accept_modes() {
  if (residual_.needs_last_step()) {
    const auto n = static_cast<double>(n_steps_);
    ModalState last;
    flow_.advance(t_, h_ * (n - 1) / n, now_, last, nullptr);
    residual_.accept(last.eta);
  } else {
    residual_.accept(now_.eta);
  }
  switch (scheme()) {
    case Scheme::exact:
      accept_exact();
      break;
    case Scheme::central_difference:
      accept_central();
      break;
    case Scheme::newmark:
      arrive_newmark();
      newmark_.accept();
      break;
  }
  flow_.accept();
  late_.start.swap(late_.end);
  std::swap(now_, end_);
  t_ += h_;
}

void ModalBody::arrive_newmark() { newmark_.arrive(flow_.loads(), kick_, now_, end_, work_); }

void ModalBody::own_end_velocities(Index set, Points& v) {
  arrive_newmark();
  sets_[set].rows->displacements(end_.v, placement_.T, v);
}

void ModalBody::own_add_end_impulses(Index set, const Points& impulses) {
  if (scheme() != Scheme::newmark) return add_late(set, impulses);
  arrive_newmark();
  sets_[set].rows->kick(impulses, placement_.T, local_, f_);
  newmark_.push_end(f_, end_, work_);
}

void ModalBody::own_expect_forces(Index set, const Points& forces) {
  if (scheme() == Scheme::newmark || frame_ || forces.rows() == 0) return flow_.expect({});
  take_force(set, forces);
  flow_.expect(f_);
}

// The impulses of contact to come have the lasting forces in them, which act by themselves.
void ModalBody::kick_back() {
  if (flow_.lasting().size() == 0) return;
  f_ = -contact_kick(h_, flow_.lasting());
  feel_kick();
}

// Half of the change of forces acts before the moment at which they do, and half after it.
void ModalBody::change_force() {
  if (flow_.lasting().size() == 0 && flow_.next_lasting().size() == 0) return;
  const Vector kick =
      0.5 * contact_kick(h_, flow_.next_lasting()) - 0.5 * contact_kick(h_, flow_.lasting());
  book_kick(kick, end_.v, work_);
  end_.v += kick;
}

// Work of forces at the ends of steps, from the middle of the kick at the start of the step to that
// of the kick at its end. The next step gets the rest of that kick.
void ModalBody::accept_late() {
  const Vector start = 0.5 * late_.start;
  book_kick(start, now_.v - start, work_);
  end_.v -= late_.end;
  const Vector before = 0.5 * (late_.end - contact_kick(h_, flow_.lasting()));
  book_kick(before, end_.v, work_);
  late_.end -= contact_kick(h_, flow_.next_lasting());
  end_.v += before + 0.5 * late_.end;
}

}  // namespace cbr
