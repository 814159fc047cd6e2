// SPDX-License-Identifier: GPL-3.0-or-later
// A body with reference points: weighted averages of the motion of some nodes, which others see as
// nodes of their own.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/motion/wrapped_body.hpp"

namespace cbr {

// A point whose translation and rotation are those of its nodes in the mean (RBE3). With weights w,
// sum 1, xbar = sum w x and r = x - xbar:
//   theta = J^-1 sum w r x u,   J = sum w (r . r I - r r^T),   d = sum w u + theta x (at - xbar).
// Forces and moments on it are the nodes' by the same weights, so that they do the same work.
struct AveragePoint {
  std::vector<Index> nodes;  // ascending
  Vector weights;            // of them, above 0
  Vector3 at;                // undeformed, scene axes
  bool rigid = false;        // the nodes are to move as a rigid body
  // The last so many nodes are rotations of others: theta has from them what nodes on a line, or
  // one node, do not determine.
  Index n_rotations = 0;
  bool slides = false;  // its translation is that of a place that PointedBody::slide() gives
  // A point of the superelement's interface: its nodes are that of its translation and that of its
  // rotation, about axes that the instance's mirror (-1) turns over.
  bool is_of_interface = false;
  double hand = 1;  // of rotations, too
};

// The maps of u(nodes[i]) to d and theta, one of each for each node (3 x 3), scene axes.
// InputError, with `where`, if nodes without rotations lie on a line, or are one: they determine no
// rotation.
struct AverageMaps {
  std::vector<Matrix3> d, theta;
};
AverageMaps average_maps(const AveragePoint& point, const Points& positions,
                         const std::string& where);

// By the angle |theta| about the axis theta.
Matrix3 rotation_of(const Vector3& theta);

// To a hundredth of their length.
bool lie_on_a_line(const AveragePoint& point, const Points& positions);

// Of k nodes, the k - 2 sums of three rows each that are 0 where and only where the nodes move as a
// rigid body: 3 (k - 2) x 3 k, an orthonormal basis of what is orthogonal to rigid motions.
Matrix deformation_rows(const AveragePoint& point, const Points& positions);

// Of a body that turns, points and their maps turn with it: the nodes of translations are places,
// and those of rotations are at `at` plus what the point turns in the body, in the scene's axes.
//
// Point j has two nodes behind those of the inner body: n + 2 j moves by d, n + 2 j + 1 by theta,
// both from `at`. Impulses on them are impulses and impulses of moments. Behind those of all points
// a rigid one has nodes that move by deformation_rows(), three each, from `at`: what holds them
// makes it rigid (RBE2).
class PointedBody final : public WrappedBody {
 public:
  // Before any set is tracked.
  PointedBody(std::unique_ptr<Body> inner, std::vector<AveragePoint> points,
              const std::string& where);

  Index translation_node(Index point) const { return n_ + 2 * point; }
  Index rotation_node(Index point) const { return n_ + 2 * point + 1; }
  std::vector<Index> deformation_nodes(Index point) const;  // none where it is not rigid
  // Whether impulses on a node change the momentum: not those on rotations and deformations.
  bool takes_force(Index node) const {
    return node < n_ ||
           (node < n_ + 2 * static_cast<Index>(points_.size()) && (node - n_) % 2 == 0);
  }
  // Translation and rotation now, and their rates, scene axes.
  void point_motion(Index point, Vector3& d, Vector3& theta, Vector3& velocity,
                    Vector3& spin) const;
  Body& inner() { return *inner_; }
  // weight . u(node) of one of its nodes as a sum over those of the inner body.
  void add_inner_terms(Index node, const Vector3& weight,
                       std::vector<std::pair<Index, Vector3>>& terms) const;
  // A force, or a moment, on the point; follows: it turns with the body.
  BodyLoad point_load(bool is_force, Index point, const Vector3& value, const LoadHistory& history,
                      bool follows = false) const;
  // Of a point that slides: it moves as what is rigid with the point and `arm` from it does.
  void slide(Index point, const Vector3& arm) { arms_[static_cast<std::size_t>(point)] = arm; }

  bool at_rest() const override { return inner_->at_rest(); }

  Index track(const std::vector<Index>& nodes) override;
  void positions(Index set, Points& x) const override;
  void predicted_positions(Index set, Points& x) const override;
  MotionBound motion_bound(Index set) const override {
    return inner_->bounds()->motion_bound(sets_[set].inner);
  }
  MotionBound quick_motion_bound(Index set) const override {
    return inner_->bounds()->quick_motion_bound(sets_[set].inner);
  }

  void take_impulses(Index set, const Impulses& impulses) override;
  void expect_forces(Index set, const Impulses& forces) override;
  Vector3 add_velocities(Index set, const Points& velocities, const Vector3& momentum) override;
  void end_velocities(Index set, Points& v) override;
  NodeResponse velocity_response(Index set) const override;
  void add_end_impulses(Index set, const Points& impulses, ImpulseKind kind) override;

  Matrix floating_motions(Index set) const override;
  NodeResponse static_response(Index set) const override;
  void add_static_forces(Index set, const Points& forces, ImpulseKind kind) override;

  NodeResponse response(Index set, double h) const override;
  Points nodal_masses(Index set) const override {
    return inner_->nodal()->nodal_masses(sets_[set].inner);
  }
  TurningAbility* turning() override { return inner_->turning(); }

  void displacements(Points& u, Points& v) const override { inner_->displacements(u, v); }
  void keep_state(StateArchive& archive) override;

 private:
  // x = X + E (x_inner - X_inner); without points E is empty, and the set is the inner body's.
  // Rows behind those of the set's nodes are rotations of points that slide.
  struct NodeSet {
    Index inner = 0;
    Points X, X_inner;
    SparseMatrix E;            // 3 m x 3 m_inner
    std::vector<Index> nodes;  // m
    Index n_nodes = 0;         // without those behind
    // of a point that slides: the row of its translation, that of its rotation, the point
    struct Slide {
      Index row = 0, rotation = 0;
      std::size_t point = 0;
    };
    std::vector<Slide> slides;
    // E S E^T of the inner body's response S to a step of length h, in axes that turn with it
    mutable std::shared_ptr<const Matrix> answer;
    mutable double answer_h = 0;
  };
  bool is_plain(Index set) const { return sets_[set].E.size() == 0; }
  void extend(const NodeSet& set, const Points& inner, Points& x) const;
  void extend_turned(const NodeSet& set, const Points& inner, const BodyTurn& turn,
                     Points& x) const;
  Points spread(const NodeSet& set, const Points& forces) const;
  Vector3 missing_moment(const NodeSet& set, const Points& impulses, const Points& nodal) const;
  NodeResponse turned_response(const NodeSet& set, double h) const;
  Matrix slid(const NodeSet& set, const Matrix& S) const;
  TurningAbility* turned() const { return inner_->turning(); }
  NodeResponse extended(const NodeSet& set, const NodeResponse& inner) const;

  // A node behind those of the inner body: of which point, and its maps of that one's nodes.
  struct Extra {
    std::size_t point = 0;
    std::vector<Matrix3> maps;
  };
  std::vector<AveragePoint> points_;
  std::vector<AverageMaps> maps_;
  std::vector<Extra> deformations_;  // nodes from n + 2 points on
  void add_deformations(std::size_t point, const std::string& where);
  const std::vector<Matrix3>& maps_of(Index node, std::size_t& point) const;
  Index n_ = 0;                // nodes of the inner body
  std::vector<Vector3> arms_;  // of points that slide
  std::vector<NodeSet> sets_;
};

}  // namespace cbr
