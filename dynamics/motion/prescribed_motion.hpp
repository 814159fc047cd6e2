// SPDX-License-Identifier: GPL-3.0-or-later
// Prescribed motion of a body's supports, its work, and the reactions of sets of supports.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/motion/body.hpp"
#include "dynamics/motion/loads.hpp"

namespace cbr {

// Along one axis. The acceleration is piecewise linear, so that a body takes it as it takes any
// load; velocity and displacement are its integrals in closed form.
class DrivenAxis {
 public:
  // value: what the history multiplies, in m, m/s or m/s^2.
  //  acceleration: begins with `speed`.
  //  velocity: piecewise linear; each corner is rounded over a millionth of the shorter interval
  //  beside it.
  //  displacement: value times the history. In statics it is linear between the points of its
  //  table, and constant before them. In motion, where the table begins with 0, it is their cubic
  //  spline, with smaller slopes where that would leave the values of the table, but beside a peak.
  //  It begins with `speed` where the table begins at 0, else at rest, and ends at rest where the
  //  table ends before the run.
  // Precondition: times from 0 on.
  DrivenAxis(SupportMotion motion, double value, const History& history, double speed,
             const TimeOptions& time);

  double displacement(double t) const;  // since t = 0
  double velocity(double t) const;
  double displacement_integral(double t) const;            // from 0 to t
  double largest_speed() const { return largest_speed_; }  // from 0 to the end
  const LoadHistory& acceleration() const { return acceleration_; }

 private:
  struct Knot {
    double t, a, slope, v, s, integral;  // from t on; integral of s up to t
  };
  void follow(double value, const History& displacement);
  void integrate(const History& acceleration, double speed, double end);
  const Knot& knot_at(double t) const;

  LoadHistory acceleration_;
  std::vector<Knot> knots_;
  double largest_speed_ = 0;
  bool is_static_ = false;  // velocities are none
};

// Along all axes: scene axes; an axis without motion is held where it is, or free.
struct DrivenMotion {
  std::array<std::vector<DrivenAxis>, 3> axes;  // none or one each

  bool empty() const;
  Vector3 displacement(double t) const;
  Vector3 velocity(double t) const;
  Vector3 largest_speed() const;
};

// Column j: the coordinates (Body::coordinates(), component axes) of equilibrium under forces on
// the supports alone, which are moved in the j-th way. So K psi is 0 but at the supports.
struct SupportShapes {
  Matrix psi;        // n x m
  Matrix inertia;    // M psi, n x m
  Matrix stiffness;  // psi^T K psi, m x m
  Matrix momentum;   // R^T M psi, 6 x m: R translations, and rotations about the centre of mass

  Matrix mass() const { return psi.transpose() * inertia; }
};

// A set whose reactions are asked for: six shapes that move it, along x, y, z and about them.
struct ReactionSet {
  std::string name;                 // of the set
  Vector3 point = Vector3::Zero();  // scene axes, that rotations and the moment are about
};

// How supports move: by one translation, or by shapes.
struct SupportPlan {
  std::vector<DrivenAxis> drives;
  // 3 x drives, scene axes: of a translation, with velocities of the body seen from the supports;
  // empty: shapes.
  Matrix directions;
  std::vector<Index> rotations;   // ascending: nodes that a translation leaves alone
  SupportShapes shapes;           // first of the drives
  std::vector<ReactionSet> sets;  // then of these, six each; not with a translation
  Index n_modal = 0;              // coordinates before those of the nodes
  Matrix3 T = Matrix3::Identity();
  double mass = 0;
  Matrix3 inertia = Matrix3::Zero();  // about the centre of mass, component axes
  bool has_inertia = true;  // false in statics, where supports have places and no velocities
  bool waits = false;       // statics come first, see Body::start_motion()
};

// u = u_r + sum over the drives psi_j g_j(t), u_r the body's own motion. psi_j is the static
// displacement for a unit motion of drive j: K psi_j = 0 at free dofs. So u_r is 0 at the supports,
// and only the inertia -M psi_j g_j'' loads it. Of a translation psi_j is a direction: u_r is the
// motion in axes that move with the supports, where gravity -g_j'' acts. The reaction of a set is
// psi_s . (M u'' + K u - f), with the shape psi_s that moves this set alone. docs/theory.md,
// "Supports that move".
//
// Sets are those of Body::own_track() and own_track_mean(). `own`: state and rates of all
// coordinates (empty: a translation) of the body without this motion.
class PrescribedMotion {
 public:
  PrescribedMotion(SupportPlan plan, Index n_nodes);

  const std::vector<ReactionSet>& sets() const { return plan_.sets; }
  bool is_translation() const { return plan_.directions.size() > 0; }
  bool moves() const { return !plan_.drives.empty(); }

  void track(const std::vector<Index>& nodes);
  void track_mean(const std::vector<Index>& nodes);
  // What is free keeps its velocity when the supports begin with one: on all coordinates; or empty.
  Vector start_impulse() const;
  // Those of inertia and the given ones.
  std::vector<BodyLoad> loads_at_start(const std::vector<BodyLoad>& loads) const;
  void begin(const std::vector<BodyLoad>& loads, const BodyState& own, const Vector& own_rates);

  void predict(double t, double h);
  void move_now(Index set, Points& x) const { move(set, displacement(now_), x); }
  void move_end(Index set, Points& x) const { move(set, displacement(t_ + h_), x); }
  void add_end_velocities(Index set, Points& v) const { move(set, velocity(t_ + h_), v); }
  MotionBound moved(Index set, MotionBound bound) const;
  // lasts: they are of forces through the step, else they act at its start
  void take_impulses(Index set, const Impulses& impulses, bool lasts);
  void take_momentum(const Vector3& momentum);  // of a translation
  void add_end_impulses(Index set, const Points& impulses);
  void expect_forces(Index set, const Points& forces, double lasting_share);
  void accept() { now_ = t_ + h_; }

  void relax(double t);
  void add_static_forces(Index set, const Points& forces);
  double settle();  // returns g . K g
  void end_load_step();
  std::vector<BodyLoad> start_motion(const std::vector<BodyLoad>& loads);

  BodyState moved(BodyState state, const Vector& own_rates) const;
  BodyWork worked(BodyWork work, const BodyState& own, const Vector& own_rates) const;
  void add_displacements(Points& u, Points& v) const;
  void add_coordinates(Vector& q, Vector& rates) const;  // of shapes
  void translate(Points& u, Points& v) const;            // of a translation, of any points
  void add_mean_motion(Index set, Vector3& position, Vector3& velocity) const;
  std::vector<Reaction> take_reactions(double t, double interval, const Vector& own_rates);
  std::vector<Reaction> static_reactions(double t) const;
  void keep_state(StateArchive& archive);

 private:
  // Of the nodes of a set, scene axes.
  struct NodeSet {
    Matrix psi;           // 3 m x shapes
    Matrix lower, upper;  // 3 x drives, the least and largest over the nodes
  };
  struct WorkingLoad {
    Vector on_shapes;  // psi^T f
    LoadHistory history;
  };

  Index n_drives() const { return static_cast<Index>(plan_.drives.size()); }
  Index n_shapes() const { return nodal_.cols(); }
  Vector displacement(double t) const;  // of the drives
  Vector velocity(double t) const;
  std::vector<BodyLoad> with_inertia(const std::vector<BodyLoad>& loads) const;
  void add_load(const BodyLoad& load);
  void move(Index set, const Vector& g, Points& x) const;
  // psi^T of impulses or forces on the set
  Vector on_shapes(Index set, const Points& impulses) const;
  void book(const Vector& on_shapes, const Vector& velocity);
  double strain_energy(const Vector& g) const;
  // Kinetic energy beyond the body's own.
  double kinetic_energy(const Vector& v, const Vector3& own_momentum,
                        const Vector& own_rates) const;
  double energy(const Vector3& own_momentum, const Vector& own_rates) const;
  std::vector<Reaction> by_sets(const Vector& on_shapes) const;

  SupportPlan plan_;
  Matrix mass_;   // psi^T M psi
  Matrix nodal_;  // 3 n x shapes: psi of the nodes, scene axes
  std::vector<NodeSet> sets_;
  std::vector<Matrix> means_;  // 3 x drives
  std::vector<WorkingLoad> loads_;
  double t_ = 0, h_ = 0;  // of the last step
  double now_ = 0;
  double energy_at_start_ = 0;
  double contact_ = 0;  // work of impulses on the supports' motion
  Vector pushed_;       // psi^T of impulses since the last take_reactions()
  Vector momenta_;      // psi^T M u' then
  // Statics: psi^T of contact, of this iteration and at the end of the last load step, and its time
  Vector forces_, forces_start_;
  double start_ = 0;
  Vector lasting_;  // psi^T of forces that last
};

}  // namespace cbr
