// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/setup/modal: modes and harmonic response of a scene.
//
// A linear scene: instances in modal coordinates, free or constrained, and ties. For frequencies
// and harmonic response.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "common/app/report.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/motion/body_points.hpp"
#include "dynamics/motion/joint_body.hpp"
#include "dynamics/motion/modal/modal_body.hpp"
#include "dynamics/setup/bodies/mesh_modes.hpp"
#include "dynamics/setup/build.hpp"

namespace cbr {

// sum of weight . u(node) over nodes of a body, scene axes.
struct NodalSum {
  std::vector<std::pair<Index, Vector3>> terms;
};

// Response of m sums y of a body to forces p on them, with eta'' + c eta' + omega^2 eta = g + A^T
// p.
//   y = A eta + sum over k of (w^2 - sigma)^k (S_k p + r_k)
// With an acceleration a of the whole body (component axes), also sum of (w^2 - sigma)^k I_k a.
// Springs and dashpots: y = B (K + i w C)^-1 B^T p, whose S_0 is that without C. S, r and I:
// residual response, of bases massless and characteristic, and of meshes in their lowest modes; w:
// rad/s.
struct ModalAnswer {
  Matrix A;               // m x n
  std::vector<Matrix> S;  // m x m each, or none
  std::vector<Vector> r;  // m, of the body's own loads
  std::vector<Matrix> I;  // m x 3
  double sigma = 0;
  Matrix B;  // m x 6, of springs, else 0 x 0
  Matrix6 K, C;
};

// One body of a scene from build().
class BodyModes {
 public:
  BodyModes(Body& body, const MeshModes* mesh);
  bool is_joint() const { return joint_ != nullptr; }
  const Vector& omega() const { return omega_; }
  Vector damping_rates() const;  // n
  Vector loads() const;
  // Modal forces of an acceleration of the whole body, scene axes (n).
  Vector gravity(const Vector3& acceleration) const;
  // `terms`: of a mesh's series.
  ModalAnswer answer(const std::vector<NodalSum>& sums, int terms = 1) const;
  const MeshModes* mesh() const { return mesh_; }
  // The sums by the dofs of a mesh, component axes   (m x 3 N)
  SparseMatrix mesh_rows(const std::vector<NodalSum>& sums) const;
  // The sum by nodes of the body itself, without points.
  std::vector<std::pair<Index, Vector3>> inner_terms(const NodalSum& sum) const;
  Vector3 local(const Vector3& v) const {
    return modal_ != nullptr ? Vector3(modal_->axes().transpose() * v) : v;
  }
  void take_shape(const Vector& eta) {
    if (modal_ != nullptr) modal_->take_shape(eta);
  }
  // Replaces the coordinates by these shapes of a mesh (3 N x n, component axes), for take_shape()
  // only.
  void take_shapes(const Matrix& shapes);

 private:
  Matrix modal_rows(const std::vector<NodalSum>& sums) const;
  ModalAnswer answer_of_modes(const std::vector<NodalSum>& sums, int terms) const;
  void add_series(const std::vector<NodalSum>& sums, int terms, ModalAnswer& answer) const;
  ModalAnswer answer_of_joint(const std::vector<NodalSum>& sums) const;
  ModalBody* modal_ = nullptr;  // or
  const JointBody* joint_ = nullptr;
  const BodyPoints* points_ = nullptr;  // of the body
  Vector omega_;
  const MeshModes* mesh_ = nullptr;
};

// A tie constraint: a sum of displacements of two bodies that is zero.
struct TieRow {
  std::vector<std::pair<Index, NodalSum>> of_bodies;
  bool is_dashpot = false;  // without stiffness: for sweeps, and as damping of modes
};

// Springs and dashpots of a joint. Its ends move by -B^T y relative to each other, y the sums of
// its rows of ties.
struct Dashpots {
  std::vector<Index> rows;
  Matrix B;  // rows x 6
  Matrix6 C;
};

struct ModalScene {
  Scene scene;
  BuiltScene built;
  std::vector<BodyModes> bodies;  // in the order of built.simulation.bodies
  std::vector<TieRow> ties;
};

// Compliance added to each row of ties, relative to its own, so that redundant rows have a factor.
// Solutions are refined, and do not have it.
inline constexpr double tie_slack = 1e-12;
inline constexpr int tie_refinements = 3;

// Whether ties, links or points may join instances, or couple nodes of one.
bool has_ties(const Scene& scene);

// Builds the scene without `time`, with supports at rest, and with or without loads. Precondition:
// its contact is tied. InputError: as of build().
std::unique_ptr<ModalScene> modal_scene(const Scene& scene, const MeshModesWanted& wanted,
                                        bool loads, Report& report);

}  // namespace cbr
