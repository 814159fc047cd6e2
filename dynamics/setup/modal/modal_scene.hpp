// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/setup/modal: modes and harmonic response of a scene.
//
// A linear scene: instances in modal coordinates, each free or held, and what ties join. For
// frequencies and harmonic response.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/app/report.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/motion/joint_body.hpp"
#include "dynamics/motion/modal/statics_body.hpp"
#include "dynamics/motion/pointed_body.hpp"
#include "dynamics/setup/bodies/mesh_modes.hpp"
#include "dynamics/setup/build.hpp"

namespace cbr {

// sum of weight . u(node) over nodes of a body, scene axes.
struct NodalSum {
  std::vector<std::pair<Index, Vector3>> terms;
};

// How a body answers: of m sums y and forces p on them, with eta'' + c eta' + omega^2 eta = g + A^T
// p,
//   y = A eta + sum over k of (w^2 - sigma)^k (S_k p + r_k)
// and of springs and dashpots y = B (K + i w C)^-1 B^T p, whose S_0 is that without C; and, of an
// acceleration a of the whole body (component axes), sum of (w^2 - sigma)^k I_k a. S, r and I:
// statics of what is not in the modes (bases massless and characteristic; meshes in their lowest
// modes, w: rad/s).
struct ModalAnswer {
  Matrix A;               // m x n
  std::vector<Matrix> S;  // m x m each, or none
  std::vector<Vector> r;  // m, of the body's own loads
  std::vector<Matrix> I;  // m x 3
  double sigma = 0;
  Matrix B;  // m x 6, of springs, else 0 x 0
  Matrix6 K, C;
};

// One body of the scene, as build() has made it.
class ModalBody {
 public:
  ModalBody(Body& body, const MeshModes* mesh);
  bool is_joint() const { return joint_ != nullptr; }
  const Vector& omega() const { return omega_; }
  Vector damping_rates() const;  // n
  Vector loads() const;
  // Forces of an acceleration of the whole body, scene axes (n): what modal coordinates feel of it.
  Vector gravity(const Vector3& acceleration) const;
  // Of a mesh so many terms of its series.
  ModalAnswer answer(const std::vector<NodalSum>& sums, int terms = 1) const;
  const MeshModes* mesh() const { return mesh_; }
  // The sums of a mesh by its dofs, component axes   (m x 3 N)
  SparseMatrix mesh_rows(const std::vector<NodalSum>& sums) const;
  // The sum by nodes of the body itself, without those of points.
  std::vector<std::pair<Index, Vector3>> inner_terms(const NodalSum& sum) const;
  Vector3 local(const Vector3& v) const {
    return modal_ != nullptr ? Vector3(modal_->axes().transpose() * v) : v;
  }
  void take_shape(const Vector& eta) {
    if (modal_ != nullptr) modal_->take_shape(eta);
  }
  // From here on its coordinates are these shapes of a mesh (3 N x n, component axes), for
  // take_shape() alone.
  void take_shapes(const Matrix& shapes);

 private:
  Matrix modal_rows(const std::vector<NodalSum>& sums) const;
  ModalAnswer answer_of_modes(const std::vector<NodalSum>& sums, int terms) const;
  void add_series(const std::vector<NodalSum>& sums, int terms, ModalAnswer& answer) const;
  ModalAnswer answer_of_joint(const std::vector<NodalSum>& sums) const;
  SuperelementBody* modal_ = nullptr;  // or
  const JointBody* joint_ = nullptr;
  const PointedBody* pointed_ = nullptr;  // of the first
  Vector omega_;
  const StaticsBody* statics_ = nullptr;
  const MeshModes* mesh_ = nullptr;
};

// A row of what ties keep at zero: sums of displacements of two bodies.
struct TieRow {
  std::vector<std::pair<Index, NodalSum>> of_bodies;
  bool is_dashpot = false;  // no stiffness: it acts in a sweep, and as damping of modes
};

// Springs and dashpots of a joint: what they join moves by -B^T y, y the rows of ties that they are
// in.
struct Dashpots {
  std::vector<Index> rows;
  Matrix B;  // rows x 6
  Matrix6 C;
};

// Squared frequencies up to this share of the lowest elastic one of the parts are rigid motions.
constexpr double rigid_share = 1e-8;

struct ModalScene {
  Scene scene;
  BuiltScene built;
  std::vector<ModalBody> bodies;  // as built.simulation.bodies
  std::vector<TieRow> ties;
};

// Rows of a symmetric positive semi-definite W (m x m) that determine the others: without those of
// zeros, and without those that others imply to round-off; ascending.
std::vector<Index> independent_rows(const Matrix& W);

// Whether ties, links or points may join instances, or hold nodes of one together.
bool has_ties(const Scene& scene);

// The scene without `time`, with supports at rest, and `loads` or none. Precondition: its contact
// is tied. InputError: as of build().
std::unique_ptr<ModalScene> modal_scene(const Scene& scene, const MeshModesWanted& wanted,
                                        bool loads, Report& report);

}  // namespace cbr
