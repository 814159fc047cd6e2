// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/run: the loop over steps.
//
// All that a run needs, ready to step: bodies, contact pairs, monitored surfaces, steps. And the
// run.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/contact/enforce/tie.hpp"
#include "dynamics/contact/search/detection.hpp"
#include "dynamics/contact/search/rigid_wall.hpp"
#include "dynamics/motion/body.hpp"
#include "dynamics/motion/driven_motion.hpp"
#include "dynamics/motion/pointed_body.hpp"
#include "dynamics/motion/supported_body.hpp"
#include "dynamics/run/time_plan.hpp"

namespace cbr {

// Of tied surfaces that statics pull together along a normal, and lock then.
struct Pretension {
  std::optional<double> force, shortening;  // one of them; a pull is positive
  // by which the surfaces have been pulled together, in the end
  double length = 0;
};

// How the rows of a link follow its ends, of which one at least turns by any angle: theory.md,
// "Links of bodies that turn". Its axes turn with the first end, or are those of the ground.
struct TurningLink {
  // Of a contact body: the nodes of a point's translation and rotation. contact -1: the ground.
  struct End {
    Index contact = -1, translation = 0, rotation = 0;
    bool is_ground() const { return contact < 0; }
  };
  End first, second;
  bool of_rotations = false;           // the pair's rows are
  std::array<bool, 3> is_on{};         // its rows
  std::array<bool, 3> is_fixed{};      // the rotations that the link holds
  Matrix3 axes = Matrix3::Identity();  // rows: at the start, scene axes
  Vector3 at = Vector3::Zero();        // of the first end at the start
  // of the first end's points that which moves with the place of the second: PointedBody::slide()
  Index slides = -1;
  double size = 1;  // of what it joins
};

// What a run makes of a pair.
struct PairState {
  PairMemory memory, back;  // back: of the master's nodes on the slave's faces (two-way)
  PenaltyMemory penalty;
  ContactList ties;   // tied: found at the start
  Points tie_offset;  // ties x 3, scene axes: relative positions that are kept
  TieReport tie_report;
  // Extremes of the run, and since the last output: largest gap below 0 at the end of a step,
  // residual of the laws
  double penetration = 0, residual = 0, recent_penetration = 0, recent_residual = 0;
  Index n_fallbacks = 0;
  // Of the last step: area of the points with an impulse. Since the last output: impulse on the
  // slave; normal impulses (magnitudes) and their first moment, scene axes
  double area = 0, largest_area = 0;
  Vector3 impulse = Vector3::Zero(), moment = Vector3::Zero();
  double normal_impulse = 0;
  // Of a wall that moves: what it has done on the body along normals and by friction; of statics
  // its forces of both kinds at the end of the last load step
  double wall_work = 0, wall_friction_work = 0;
  Vector3 wall_force = Vector3::Zero(), wall_friction = Vector3::Zero();
};

// `contact: all` makes one of every two instances, few of which ever come near each other: what is
// not the pair's own is shared, and what a run makes of it is made when it is first searched.
struct ContactPair {
  std::string name;                          // "left.contact - right.contact"
  std::shared_ptr<const SourceLine> source;  // its entry in the scene
  bool of_all = false;                       // one of those that `all` stands for
  // ->body: index into Simulation::contact_nodes
  std::shared_ptr<const ContactSurface> slave, master;
  // or none; then `master` has no faces, the slave's body and size, and the wall's name
  std::shared_ptr<const RigidWall> wall;
  bool slave_is_first = true;  // of the two that the scene names
  Enforcement enforcement = Enforcement::impulse;
  Formulation formulation = Formulation::node_face;
  PointLaw law;                  // frictionless, coulomb or tied
  double damping = 0;            // penalty
  std::optional<double> adjust;  // length, see ContactOptions
  std::optional<Pretension> pretension;
  bool is_link = false;  // of two points: its ties are there from the beginning
  // of a link with springs: their contact body, a third one beside those of slave and master
  Index joint = -1;
  std::optional<TurningLink> turning;
  bool yields = false;            // springs: what the pair joins may move apart
  bool resolves_overlap = false;  // statics press apart what overlaps at the start

  bool has_state() const { return state_ != nullptr; }
  PairState& state();             // made when there is none
  const PairState& seen() const;  // as it is; of nothing when there is none

 private:
  std::unique_ptr<PairState> state_;
};

// The contact nodes of one body: the union over its contact surfaces.
struct ContactNodes {
  Index body = 0;            // index into Simulation::bodies
  Index set = 0;             // Body::track
  std::vector<Index> nodes;  // the body's, ascending
  // When nodal pressures are wanted, else empty; of each node, undeformed, scene axes: its share of
  // the contact faces' areas as the sum of their outward vectors, and as the sum of their
  // magnitudes
  Points area_vectors;
  Vector areas;
  Vector pressure;  // normal force per area, mean since the last output
};

// A surface whose mean motion and contact force are written.
struct Monitor {
  std::string name;  // INSTANCE.SURFACE
  Index body = 0, mean_set = 0;
  Index contact = -1;                    // index into contact_nodes, or -1: no contact on this body
  std::vector<Index> contact_slots;      // contact nodes of that body that belong to this surface
  const PointedBody* pointed = nullptr;  // of a point: the body, and which of its points
  Index point = 0;
  // Of a set inside a superelement, which has no mean_set: mean displacement = rows * coordinates
  // (3 x n_q, scene axes), and the mean undeformed position
  Matrix rows;
  Vector3 reference = Vector3::Zero();
  bool is_inside() const { return rows.size() > 0; }
};

// Stress of some nodes or elements of a body: linear in its coordinates (Body::coordinates).
struct StressWatch {
  std::string name;  // INSTANCE.SET, or INSTANCE
  Index body = 0;
  bool of_nodes = false;
  std::vector<Index> ids;  // m, of nodes or elements of the mesh
  // m, of nodes: a block of the material whose elements the stress is the mean of
  std::vector<Index> block_ids;
  // 6 m x n_q, row 6 i + j is component j (xx yy zz xy yz xz, scene axes) of i: dense of a
  // superelement, sparse of a mesh
  Matrix rows;
  SparseMatrix sparse_rows;
  Vector stress(const Vector& q) const {
    return rows.size() > 0 ? Vector(rows * q) : Vector(sparse_rows * q);
  }
};

// All elements and nodes of a body at every output: the elements with the largest von Mises stress
// then, and extremes over time.
struct StressScan {
  std::string name;  // INSTANCE
  Index body = 0;
  Index n_worst = 0;
  bool envelope = false;
  std::vector<Index> element_ids, node_ids, node_block_ids;
  // stress_values() of elements at their centres, and of nodes if there is an envelope; scene axes
  std::function<void(const Vector& q, Matrix& elements, Matrix& nodes)> stresses;
};

// Of a body with supports: the resultants of its loads, scene axes.
struct Supports {
  struct Resultant {
    Vector3 force;
    LoadHistory history;
  };
  std::vector<Resultant> loads;
};

// A set whose reactions are written.
struct ReactionWatch {
  std::string instance;
  SupportedBody* body = nullptr;  // within one of the bodies
  std::size_t set = 0;            // of its reaction_sets()
};

// A wall that moves, and how.
struct MovingWall {
  std::shared_ptr<RigidWall> wall;
  DrivenMotion motion;
};

struct Simulation {
  std::vector<std::unique_ptr<Body>> bodies;      // of the instances, then joints
  std::size_t n_instances = 0;                    // the first so many; 0: all
  std::vector<std::optional<Supports>> supports;  // per body; none: it is free. Empty: nobody asks
  std::vector<ContactNodes> contact_nodes;
  std::vector<ContactPair> pairs;
  std::vector<MovingWall> moving_walls;
  std::vector<Monitor> monitors;
  std::vector<ReactionWatch> reactions;  // those of a body one after the other
  std::vector<StressWatch> watches;
  std::vector<StressScan> scans;
  TimePlan plan;
  bool is_static = false;  // run_statics() is for it, not run()
  Index preload = 0;       // load steps of statics before the first step
  DetectionOptions detection;

  void shift_walls(double from, double to);  // of a step between these times
};

// Rows of three, one per output time.
struct Series3 {
  std::vector<double> values;
  void add(const Vector3& v) { values.insert(values.end(), v.data(), v.data() + 3); }
};

// What a run has done, whatever the machine: bodies predicted and accepted; comparisons that tell
// whether a pair is worth a search; searches of a pair in a step; motion bounds formed.
struct WorkCounts {
  Index body_steps = 0, pair_looks = 0, pair_searches = 0, bounds = 0;
};

// Wall time of the parts of the steps.
struct StepSeconds {
  double bodies = 0;  // predicted, positions of their contact nodes, accepted
  double search = 0;  // for constraints of contact
  // of the bodies to impulses on their contact nodes: asked when a step's length is new
  double response = 0;
  double contact = 0;  // its matrix, impulses, and what they do to the bodies
  double output = 0;
};

// rad: 5 degrees. Bodies are linear: beyond it their strains are off by a share of it, and a
// warning says so.
constexpr double small_rotation = 0.08726646259971647;

struct RunResult {
  std::vector<double> time;
  struct OfMonitor {
    // acceleration: change of the mean velocity since the last output over that time; force:
    // contact impulses likewise
    Series3 mean_position, mean_velocity, mean_acceleration, force;
    Series3 rotation = {};  // of a point
  };
  struct OfBody {
    Series3 center_of_mass, momentum, angular_momentum;
    Series3 reaction;  // force of all supports on a body that has some, mean since the last output
    std::vector<double> kinetic_energy, strain_energy;
    // n x 4, w x y z since the start; empty: the body is linear
    std::vector<double> orientation;
    double rotation = 0;                   // rad, the largest at an output
    std::optional<double> turned_at = {};  // the first output at which it was above small_rotation
  };
  // Of a pair that `contact: all` stands for and that has never come near: empty.
  struct OfPair {
    std::vector<double> active, penetration, residual;  // at the output; largest since the last one
    std::vector<double> area;                           // in contact at the output
    // on the first-named surface, mean since the last output; where, or 0 without a force
    Series3 force, center_of_pressure;
  };
  // Extremes over the outputs: von Mises stress and when it was, the largest and the smallest
  // principal stress   (m x 4)
  struct OfScan {
    // outputs x n_worst, places in element_ids, the largest first
    std::vector<Index> worst;
    std::vector<double> worst_stress;  // von Mises
    Matrix of_elements, of_nodes;
  };
  struct OfReaction {
    Series3 force, moment;
  };
  std::vector<OfMonitor> monitors;
  std::vector<OfReaction> reactions;
  std::vector<std::vector<double>> watches;  // per watch: outputs x 6 m
  std::vector<OfScan> scans;
  std::vector<OfBody> bodies;
  std::vector<OfPair> pairs;
  std::vector<double> total, work_external, work_contact, work_friction, work_damping,
      work_numerical, active;
  // body steps are counted once for all bodies; a jump skips over steps without contact
  Index steps = 0, jumps = 0;
  Index contact_steps = 0;  // steps with a constraint of contact
  double contact_rows = 0;  // constraints with an impulse, summed over the steps
  // largest share of all energy at an output that was in modes of scaled mass
  double scaled_energy_share = 0;
  WorkCounts work;
  StepSeconds seconds;          // of this part of the run, when it was restarted
  double largest_rotation = 0;  // rad
  // of the planned steps, those that the run has come to the end of
  Index reached = 0;
  // the time of the step after which the run was ended; none: it has come to its end
  std::optional<double> ended_at;
};

struct RunOptions {
  // false: every step is taken and every pair looked at (for tests)
  bool jumps = true;
  std::function<void(Index step, double t)> on_output;  // after the bodies have arrived there
  std::function<void(double fraction)> on_progress;     // now and then
  // After each step but the last: whether to end the run there, with what is recorded so far.
  std::function<bool()> is_to_end;
  // After each step but the last: whether `on_checkpoint` is to get the state, from which a run
  // goes on bit for bit.
  std::function<bool(Index step, double t)> is_checkpoint;
  std::function<void(Index step, double t, const StateArchive& state)> on_checkpoint;
  StateArchive* restart = nullptr;  // to go on from, of the same simulation, built anew
};

// RunError when the motion stops being finite, by time and instance. InputError: `restart` is of
// another simulation. Of a simulation that is_static: equilibrium at the end of each step.
// InputError: an instance that nothing holds.
RunResult run(Simulation& simulation, const RunOptions& options = {});

}  // namespace cbr
