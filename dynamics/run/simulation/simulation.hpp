// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/run/simulation: all data of a run, ready to step. Bodies, contact pairs,
// monitored surfaces, steps.
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/contact/enforce/tie.hpp"
#include "dynamics/contact/laws/friction_law.hpp"
#include "dynamics/contact/search/closeness.hpp"
#include "dynamics/contact/search/detection.hpp"
#include "dynamics/contact/search/rigid_wall.hpp"
#include "dynamics/motion/body.hpp"
#include "dynamics/motion/body_points.hpp"
#include "dynamics/motion/prescribed_motion.hpp"
#include "dynamics/run/simulation/pair_outputs.hpp"
#include "dynamics/run/simulation/time_plan.hpp"

namespace cbr {

// Tied surfaces that statics pull together along a normal and then lock.
struct Pretension {
  std::optional<double> force, shortening;  // exactly one; a pull is positive
  // final reduction of the distance
  double length = 0;
};

// Rotation of a link's rows with its ends, at least one with large rotation: theory.md, "Links of
// bodies that turn". Its axes rotate with the first end, or are fixed to the ground.
struct TurningLink {
  // Nodes of a contact body: a point's translation and rotation. contact -1: the ground.
  struct End {
    Index contact = -1, translation = 0, rotation = 0;
    bool is_ground() const { return contact < 0; }
  };
  End first, second;
  bool of_rotations = false;           // the pair's rows are rotations
  std::array<bool, 3> is_on{};         // its rows
  std::array<bool, 3> is_fixed{};      // constrained rotations of the link
  Matrix3 axes = Matrix3::Identity();  // rows: initial axes, scene axes
  Vector3 at = Vector3::Zero();        // the place of the ground: of the first end, initially
  // sliding point of the first end, at the position of the second: BodyPoints::slide()
  Index slides = -1;
  double size = 1;  // reference length of the joined bodies
  // Initial distance of the ends, of a link whose one row is along the line between them; 0: of
  // axes
  double length = 0;
};
// Rows, of which the first is along the line.
Matrix3 axes_along(const Vector3& line);

// Prescribed motion of a link's rows: of its first end relative to the second.
struct DrivenLink {
  DrivenMotion motion;          // along, or about, the axes of the link
  RigidWall::Shift shift = {};  // in this step
};

// State and results of a pair in a run.
struct PairState {
  // Slave nodes on master faces, master nodes on slave faces, crossing edges
  PairMemory memory, back, edges;
  ClosenessMemory look;  // for outputs
  PenaltyMemory penalty;
  ContactList ties;   // of tied pairs, found at the start
  Points tie_offset;  // ties x 3, scene axes: relative positions to keep
  TieReport tie_report;
  // Extremes of the run, and since the last output: penetration at the end of a step, residual of
  // the laws
  double penetration = 0, residual = 0, recent_penetration = 0, recent_residual = 0;
  Index n_fallbacks = 0;
  // Steps with pressure functions: their number, sum of unknowns, largest number of unknowns
  Index n_function_steps = 0, n_unknowns = 0, most_unknowns = 0;
  PairStep step;             // of the last search
  bool is_active = false;    // some point had an impulse then
  std::vector<double> kept;  // by outputs: add_step()
  double largest_area = 0;
  bool has_touched = false;  // in any step
  // Where friction depends on the slip speed: the largest |dmu/dv| / mu in the run, times what
  // friction changed of the slip speed v in a step. Beyond 1 the step is too long for the law.
  double friction_change = 0;
  // Moving wall, or link with prescribed motion: its work by normal impulses and by friction. In
  // statics its forces of both kinds at the end of the last load step; in motion the sum that
  // lasts, and friction alone
  double wall_work = 0, wall_friction_work = 0;
  Vector3 wall_force = Vector3::Zero(), wall_friction = Vector3::Zero();
};

// A contact pair. `contact: all` makes one for every two instances, few of which ever come near. So
// common data are shared, and the state is made at the first search.
struct ContactPair {
  std::string name;                          // "left.contact - right.contact"
  std::shared_ptr<const SourceLine> source;  // its entry in the scene
  bool of_all = false;                       // from `contact: all`
  // ->body: index into Simulation::contact_nodes
  std::shared_ptr<const ContactSurface> slave, master;
  // or null; else `master` has no faces, the slave's body and size, and the wall's name
  std::shared_ptr<const RigidWall> wall;
  bool slave_is_first = true;  // the slave is the first-named surface
  Enforcement enforcement = Enforcement::impulse;
  Formulation formulation = Formulation::node_face;
  // At slave nodes; null: every node is an unknown.
  std::shared_ptr<const PressureFunctions> functions;
  bool keeps_functions = false;  // in statics: on faces of few points too
  // Likewise, corner_functions() of second-order faces; null if all are linear.
  std::shared_ptr<const PressureFunctions> corners;
  bool may_stand = false;  // see standing_search.hpp
  PointLaw law;            // frictionless, coulomb or tied; friction: at rest
  FrictionLaw friction;
  PenaltyLaw penalty;
  double restitution = 0;        // impulse, of rigid bodies and walls
  std::optional<double> adjust;  // length, see ContactOptions
  std::optional<Pretension> pretension;
  bool is_link = false;  // of two points: its ties exist from the start
  // springs of a link: their contact body, in addition to slave and master
  Index joint = -1;
  std::unique_ptr<TurningLink> turning;  // few pairs have one
  std::shared_ptr<DrivenLink> driven;    // of Simulation::driven_links
  bool yields = false;                   // springs: the joined points may separate
  bool resolves_overlap = false;         // statics remove the initial overlap
  double interference = 0;               // length, see ContactOptions

  bool has_state() const { return state_ != nullptr; }
  PairState& state();             // made on demand
  const PairState& seen() const;  // an empty state if none was made
  // largest distance that may count as closed
  double closed_reach() const { return adjust.value_or(0) + std::max(0.0, interference); }
  // Motion of the partner whose motion is given; null: at rest, or none
  const RigidWall::Shift* shift() const {
    if (driven) return &driven->shift;
    return wall && wall->moves() ? &wall->shift() : nullptr;
  }

 private:
  std::unique_ptr<PairState> state_;
};

// The contact nodes of one body: the union over its contact surfaces.
struct ContactNodes {
  Index body = 0;            // index into Simulation::bodies
  Index set = 0;             // Body::track
  std::vector<Index> nodes;  // the body's, ascending
  // For fields of contact, else empty. Per node, undeformed, scene axes: tributary area of the
  // contact faces, as sum of outward vectors and of their magnitudes
  Points area_vectors;
  // areas: 0 for nodes of second-order faces, which have corner functions. Values of these at the
  // nodes (m x k), and their integrals times the outward normal (k x 3).
  Vector areas;
  SparseMatrix corner_values;
  Points corner_normals = Points(0, 3);
  Vector pressure;  // normal force per area, mean since the last output
  Vector slip;      // of slave nodes with friction, since the start: length of the way
};

// A surface with recorded mean motion and contact force.
struct Monitor {
  std::string name;  // INSTANCE.SURFACE
  Index body = 0, mean_set = 0;
  Index contact = -1;                // index into contact_nodes; -1: no contact on this body
  std::vector<Index> contact_slots;  // contact nodes of that body in this surface
  bool has_point = false;            // of a point of the body, with this index
  Index point = 0;
  // For an interior set of a superelement, without mean_set: mean displacement = rows * coordinates
  // (3 x n_q, scene axes), and the mean undeformed position
  Matrix rows;
  Vector3 reference = Vector3::Zero();
  bool is_inside() const { return rows.size() > 0; }
};

// Stress of selected nodes or elements of a body, linear in its coordinates (Body::coordinates).
struct StressWatch {
  std::string name;  // INSTANCE.SET, or INSTANCE
  Index body = 0;
  bool of_nodes = false;
  std::vector<Index> ids;  // m, of nodes or elements of the mesh
  // m, for nodes: a block of the material over whose elements the stress is averaged
  std::vector<Index> block_ids;
  std::vector<Index> faces;  // m, of shells 1: top, -1: bottom; of solids 0
  // 6 m x n_q, row 6 i + j is component j (xx yy zz xy yz xz, scene axes) of i. Dense for a
  // superelement, sparse for a mesh
  Matrix rows;
  SparseMatrix sparse_rows;
  Vector stress(const Vector& q) const {
    return rows.size() > 0 ? Vector(rows * q) : Vector(sparse_rows * q);
  }
};

// All elements and nodes of a body at every output: elements with the largest von Mises stress, and
// extremes over time.
struct StressScan {
  std::string name;  // INSTANCE
  Index body = 0;
  Index n_worst = 0;
  bool envelope = false;
  // An element or a node of shells is there twice: faces as above
  std::vector<Index> element_ids, element_faces, node_ids, node_block_ids, node_faces;
  // stress_values() of element centres, and of nodes for an envelope; scene axes
  std::function<void(const Vector& q, Matrix& elements, Matrix& nodes)> stresses;
};

// For a constrained body: resultants of its loads, scene axes.
struct Supports {
  struct Resultant {
    Vector3 force;
    LoadHistory history;
  };
  std::vector<Resultant> loads;
};

// A set with recorded reactions.
struct ReactionWatch {
  std::string instance;
  Body* body = nullptr;
  std::size_t set = 0;  // of PrescribedMotion::sets()
};

// A wall with prescribed motion.
struct MovingWall {
  std::shared_ptr<RigidWall> wall;
  DrivenMotion motion;
};

struct Simulation {
  std::vector<std::unique_ptr<Body>> bodies;      // of the instances, then joints
  std::size_t n_instances = 0;                    // of the leading bodies; 0: all
  std::vector<std::optional<Supports>> supports;  // per body; none: free. Empty: not requested
  std::vector<ContactNodes> contact_nodes;
  std::vector<ContactPair> pairs;
  std::vector<MovingWall> moving_walls;
  std::vector<std::shared_ptr<DrivenLink>> driven_links;
  std::vector<Monitor> monitors;
  std::vector<ReactionWatch> reactions;  // grouped by body
  std::vector<StressWatch> watches;
  std::vector<StressScan> scans;
  TimePlan plan;
  bool is_static = false;  // for run_statics(), not run()
  Index preload = 0;       // static load steps before the first step
  DetectionOptions detection;

  void shift_walls(double from, double to);  // and links, for a step between these times
};

}  // namespace cbr
