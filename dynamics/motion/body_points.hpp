// SPDX-License-Identifier: GPL-3.0-or-later
// Reference points of a body: weighted averages of the motion of some nodes, which others see as
// nodes of their own.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/motion/body.hpp"

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
  bool slides = false;  // its translation is that of a place that BodyPoints::slide() gives
  // A point of the superelement's interface: its nodes are that of its translation and that of its
  // rotation, about axes that the instance's mirror (-1) turns over.
  bool is_of_interface = false;
  double hand = 1;         // of rotations, too
  std::string where = {};  // what an error about it begins with
};

// The maps of u(nodes[i]) to d and theta, one of each for each node (3 x 3), scene axes.
// InputError if nodes without rotations lie on a line, or are one: they determine no
// rotation.
struct AverageMaps {
  std::vector<Matrix3> d, theta;
};
AverageMaps average_maps(const AveragePoint& point, const Points& positions);

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
// Point j has two nodes behind the n of the body itself: n + 2 j moves by d, n + 2 j + 1 by theta,
// both from `at`. Impulses on them are impulses and impulses of moments. Behind those of all points
// a rigid one has nodes that move by deformation_rows(), three each, from `at`: what holds them
// makes it rigid (RBE2).
class BodyPoints {
 public:
  // own_nodes: of the body itself, undeformed.
  BodyPoints(std::vector<AveragePoint> points, const Points& own_nodes);

  const Points& positions() const { return positions_; }  // of all nodes, undeformed
  Index translation_node(Index point) const { return n_ + 2 * point; }
  Index rotation_node(Index point) const { return n_ + 2 * point + 1; }
  std::vector<Index> deformation_nodes(Index point) const;  // none where it is not rigid
  // Whether impulses on a node change the momentum: not those on rotations and deformations.
  bool takes_force(Index node) const {
    return node < n_ ||
           (node < n_ + 2 * static_cast<Index>(points_.size()) && (node - n_) % 2 == 0);
  }
  // Translation and rotation now of a point of the body, and their rates, scene axes.
  void point_motion(const Body& body, Index point, Vector3& d, Vector3& theta, Vector3& velocity,
                    Vector3& spin) const;
  // weight . u(node) of one of all nodes as a sum over those of the body itself.
  void add_own_terms(Index node, const Vector3& weight,
                     std::vector<std::pair<Index, Vector3>>& terms) const;
  // A force, or a moment, on the point; follows: it turns with the body.
  BodyLoad point_load(bool is_force, Index point, const Vector3& value, const LoadHistory& history,
                      bool follows = false) const;
  // Of a point that slides: it moves as what is rigid with the point and `arm` from it does.
  void slide(Index point, const Vector3& arm) { arms_[point] = arm; }

  // What Body does with a set of its nodes that has points; `own`: of the nodes of the body itself
  // that the set moves by, without the turn.
  // Returns these nodes.
  std::vector<Index> track(const std::vector<Index>& nodes);
  bool has_points(Index set) const { return sets_[set].E.size() > 0; }
  // Their places become those of the set, with the turn.
  void extend(Index set, const BodyTurn& turn, Points& own) const;
  void extend_rates(Index set, Points& own) const;
  Matrix extended(Index set, const Matrix& own) const { return sets_[set].E * own; }
  NodeResponse extended(Index set, const NodeResponse& own) const;
  // Kept until h changes: the block turns with the body, to the last bit after a restart.
  NodeResponse turned_response(Index set, double h, const Matrix3& turn,
                               const std::function<NodeResponse()>& own) const;
  // Impulses on the set as those on its own nodes, in axes that turn with the body.
  Points spread(Index set, const Points& impulses) const;
  // Of impulses on the set, what the spread ones leave of their moment: a body takes those where
  // its nodes are now, and their shares are those of the middle of the step.
  Vector3 missing_moment(Index set, const BodyTurn& turn, const Points& own, const Points& impulses,
                         const Points& spread) const;
  void keep_state(StateArchive& archive);

 private:
  // x = X + E (x_own - X_own); without points E is empty, and the set is the body's own. Rows
  // behind those of the set's nodes are rotations of points that slide.
  struct NodeSet {
    Points X, X_own;
    SparseMatrix E;            // 3 m x 3 m_own
    std::vector<Index> nodes;  // m
    Index n_nodes = 0;         // without those behind
    // of a point that slides: the row of its translation, that of its rotation, the point
    struct Slide {
      Index row = 0, rotation = 0;
      std::size_t point = 0;
    };
    std::vector<Slide> slides;
    // E S E^T of the body's response S to a step of length h, in axes that turn with it
    mutable std::shared_ptr<const Matrix> answer;
    mutable double answer_h = 0;
  };
  // A node behind those of all points: of which point, and its maps of that one's nodes.
  struct Extra {
    std::size_t point = 0;
    std::vector<Matrix3> maps;
  };
  void add_deformations(std::size_t point, const Points& own_nodes);
  const std::vector<Matrix3>& maps_of(Index node, std::size_t& point) const;
  void extend(const NodeSet& set, Points& own) const;
  Matrix slid(const NodeSet& set, const Matrix& S) const;
  Matrix product(const NodeSet& set, const NodeResponse& own) const;

  Index n_ = 0;  // nodes of the body itself
  std::vector<AveragePoint> points_;
  std::vector<AverageMaps> maps_;
  std::vector<Extra> deformations_;  // nodes from n + 2 points on
  Points positions_;
  std::vector<Vector3> arms_;  // of points that slide
  std::vector<NodeSet> sets_;
};

}  // namespace cbr
