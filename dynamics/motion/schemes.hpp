// SPDX-License-Identifier: GPL-3.0-or-later
// Shared by the time integrations of all bodies: the impulses of a step, and Newmark's method with
// its HHT-alpha form.
#pragma once

#include <functional>
#include <utility>

#include "common/base/types.hpp"
#include "dynamics/motion/body.hpp"
#include "dynamics/motion/body_readings.hpp"
#include "dynamics/motion/loads.hpp"

namespace cbr {

// The sum of the impulses of a step   (n); false: there are none.
class Kick {
 public:
  explicit Kick(Index n = 0) : sum_(Vector::Zero(n)) {}
  void clear() { any_ = false; }
  void add(const Vector& impulse) {
    if (!any_) sum_.setZero(impulse.size());
    sum_ += impulse;
    any_ = true;
  }
  explicit operator bool() const { return any_; }
  const Vector& sum() const { return sum_; }

 private:
  Vector sum_;
  bool any_ = false;
};

// Of an impulse on coordinates of mass 1 whose rates are v before it.
inline void book_kick(const Vector& impulse, const Vector& v, BodyWork& work) {
  work.contact += impulse.dot(v) + 0.5 * impulse.squaredNorm();
}

// M a_{n+1} + (1 + alpha) (K u_{n+1} - f_{n+1}) - alpha (K u_n - f_n) = 0 (Hilber, Hughes, Taylor
// 1977, doi 10.1002/eqe.4290050306), alpha in [-1/3, 0]; 0: average acceleration (Newmark 1959),
// which keeps all energy. Second order and stable for any step. An impulse p of contact is a force
// p / h that is constant over the step and no part of a:
//   v_{n+1} = v_n + h ((1 - gamma) a_n + gamma a_{n+1}) + M^-1 G^T p,   u_{n+1} = ... + h / 2 M^-1
//   G^T p,
// so it moves the end by h / 2 A^-1 G^T p, A = M + (1 + alpha) beta h^2 K, and for any alpha
//   v_{n+1} = 2 / h (u_{n+1} - u_n) - v_n - alpha^2 / 2 h (a_{n+1} - a_n).
// The impulse's work is p . G (u_{n+1} - u_n) / h: where the gap at the end is nil, -p g_n / h,
// never above 0, at any step. (A kick at the start, as under central differences, brings energy
// above the critical step: several times that of an impact at 10 to 20 of it.) Velocities of what
// is closed are settled afterwards, see settle_velocities() of
// dynamics/contact/enforce/enforcement.hpp.
struct NewmarkOptions {
  double alpha = 0;
  double beta() const { return 0.25 * (1 - alpha) * (1 - alpha); }
  double gamma() const { return 0.5 - alpha; }
  // theta: A = M + theta K
  double stiffness_factor(double h) const { return (1 + alpha) * beta() * h * h; }
};

// A step h of Newmark's method on a body with displacements u and momenta p = M v, n each, once all
// impulses are known.
struct NewmarkStep {
  double h;
  const Vector &u, &p;  // at the start
  const Vector &move, &Ma, &f0, &f1;
  const Kick& kick;
  Vector &u_end, &p_end, &Ma_end;
};

// The body's part in the method. Functions set their last argument.
struct NewmarkOperators {
  std::function<void(const Vector& u, Vector& Ku)> stiffness;
  std::function<void(const Vector& move, const Vector& u_end, Vector& K_move)> stiffness_of_move;
  std::function<void(const Vector& p, Vector& Cv)> damping;  // C M^-1 p; null: none
  std::function<void(const Vector& move, Vector& C_move)> damping_of_move;
  std::function<void(double h, Vector& f)> solve;  // h A^-1 f, A = M + theta (K + 2 C / h)
  std::function<void(Vector& f)> solve_mass;       // M^-1 f
  // at_end: of u_end, after stiffness_of_move()
  std::function<double(const Vector& u, const Vector& p, bool at_end)> energy;
  // Corrects the ends of coordinates whose rates the forces' difference would spoil; null: none.
  std::function<void(const NewmarkStep& step)> correct;
};

// In a step predict() comes first, then push() for each impulse, and arrive().
class Newmark {
 public:
  Newmark(const NewmarkOptions& numbers, NewmarkOperators of)
      : numbers_(numbers), of_(std::move(of)) {}
  const NewmarkOptions& numbers() const { return numbers_; }

  void predict(double t, double h, const Loads<Vector>& loads, const Vector& u, const Vector& p,
               Vector& u_end);
  // An impulse of contact moves the end.
  void push(const Vector& move, const Vector& u, Vector& u_end);
  bool has_arrived() const { return arrived_; }
  // p_end, and the work of the step. Once a step.
  void arrive(bool loaded, const Kick& kick, const Vector& u, const Vector& p, Vector& u_end,
              Vector& p_end, BodyWork& work);
  // Impulses that act at the start, before arrive(), and at the end, after it: their damping.
  void feel_start(const Vector& impulse);
  void feel_end(const Vector& impulse);
  void accept() { arrived_ = false; }
  void keep_state(StateArchive& archive);

 private:
  void book_damped(bool loaded, const NewmarkStep& step, double energy, BodyWork& work);
  void book(bool loaded, const NewmarkStep& step, BodyWork& work);

  NewmarkOptions numbers_;
  NewmarkOperators of_;
  double h_ = 0;
  // The step's move; M a at its start, and at its end, until arrive() without the part of the move;
  // loads at both
  Vector move_, Ma_, e_, f0_, f1_;
  Vector last_move_, last_change_of_f_;  // HHT-alpha
  Vector Ku_, Cv_;                       // workspaces: of the start, then of the move
  // arrived_: the end of the step is known, impulses included
  bool started_ = false, arrived_ = false;
};

// Generalised displacements u and forces of a body with n coordinates: at the end of the last load
// step, and in this one.
struct StaticState {
  Vector u_start;                     // n
  Vector loads, contact;              // n, of this iteration
  Vector loads_start, contact_start;  // n

  bool empty() const { return u_start.size() == 0; }
  void begin(const Vector& u);  // once: forces are 0
  // The forces of an iteration; those of contact come one by one.
  void begin_iteration(Vector loads_now);
  void add(const Vector& force) { contact += force; }
  // Work of the mean forces over the load step, u being its end: exact for a linear body. This load
  // step is the last one then.
  void book(const Vector& u, BodyWork& work);
  void keep_state(StateArchive& archive);
};

}  // namespace cbr
