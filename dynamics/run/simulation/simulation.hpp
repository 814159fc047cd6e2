// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/run/simulation: all that a run needs, ready to step. Bodies, contact
// pairs, monitored surfaces, steps.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/contact/enforce/tie.hpp"
#include "dynamics/contact/search/closeness.hpp"
#include "dynamics/contact/search/detection.hpp"
#include "dynamics/contact/search/rigid_wall.hpp"
#include "dynamics/motion/body.hpp"
#include "dynamics/motion/driven_motion.hpp"
#include "dynamics/motion/pointed_body.hpp"
#include "dynamics/motion/supported_body.hpp"
#include "dynamics/run/simulation/time_plan.hpp"

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
  // Of the slave's nodes on the master's faces, of the master's on the slave's, of crossing edges
  PairMemory memory, back, edges;
  ClosenessMemory look;  // at outputs
  PenaltyMemory penalty;
  ContactList ties;   // tied: found at the start
  Points tie_offset;  // ties x 3, scene axes: relative positions that are kept
  TieReport tie_report;
  // Extremes of the run, and since the last output: largest gap below 0 at the end of a step,
  // residual of the laws
  double penetration = 0, residual = 0, recent_penetration = 0, recent_residual = 0;
  Index n_fallbacks = 0;
  // In steps with functions: how many, and unknowns, summed over them and at most
  Index n_function_steps = 0, n_unknowns = 0, most_unknowns = 0;
  // Of the last step: area of the points with an impulse. Since the last output: impulse on the
  // slave; normal impulses (magnitudes) and their first moment, scene axes
  double area = 0, largest_area = 0;
  bool has_touched = false;  // in any step
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
  // Of the slave's nodes; null: every node is an unknown.
  std::shared_ptr<const PressureFunctions> functions;
  // Likewise, of its faces of second order: corner_functions(); null where all are linear.
  std::shared_ptr<const PressureFunctions> corners;
  bool may_stand = false;        // see standing_search.hpp
  PointLaw law;                  // frictionless, coulomb or tied
  double damping = 0;            // penalty
  std::optional<double> adjust;  // length, see ContactOptions
  std::optional<Pretension> pretension;
  bool is_link = false;  // of two points: its ties are there from the beginning
  // of a link with springs: their contact body, a third one beside those of slave and master
  Index joint = -1;
  std::unique_ptr<TurningLink> turning;  // few pairs have one
  bool yields = false;                   // springs: what the pair joins may move apart
  bool resolves_overlap = false;         // statics press apart what overlaps at the start

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
  // 0 of nodes of faces of second order, which have functions of corners: values at the nodes
  // (m x k), and integrals of each times the outward normal (k x 3).
  Vector areas;
  SparseMatrix corner_values;
  Points corner_normals = Points(0, 3);
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

}  // namespace cbr
