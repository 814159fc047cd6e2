// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/superelement: the superelement, its file, and what is checked of it.
//
// The superelement: the one contract between the programs. formats.md, "Superelement file", is its
// file.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "common/fem/assembly.hpp"
#include "common/linalg/compliance_levels.hpp"
#include "common/mesh/surface.hpp"
#include "common/superelement/conditioning.hpp"

namespace cbr {

// Residual compliance of faces beside the reduced interface, without mass. Entry i is a force at a
// node along a direction: the outward normal alone, or x, y and z in turn. A node of two faces with
// normals has an entry for each.
struct StaticShare {
  std::vector<Index> node;              // s, index into node_ids
  Points direction = Points(0, 3);      // s x 3, unit vectors in the component's axes
  Matrix F;                             // s x s, symmetric, positive semi-definite
  std::vector<ComplianceLevel> levels;  // of many forces, in place of F, which is empty

  Index size() const { return static_cast<Index>(node.size()); }
  bool empty() const { return node.empty(); }
};

// Coordinates q = [q_k; u_c]: k fixed-interface modal coordinates, then c interface dofs. K_kc = 0
// and M_kk = I are implied.
struct Superelement {
  std::string basis = "craig-bampton";
  std::string content_hash;  // of the inputs: content_hash() of common/scene/scene.hpp

  // k, (rad/s)^2, ascending with pick: frequency; any order with pick: participation
  Vector eigenvalues;
  Matrix K_cc, M_cc;  // c x c, symmetric
  Matrix M_kc;        // k x c

  // Basis "massless" (docs/theory.md, "An interface without mass"): in place of K_cc, M_cc and
  // M_kc, which are empty, and with eigenvalues of the free body.
  //   u_c = V q_k + F f_c,   q_k'' + diag(eigenvalues) q_k = V^T f_c
  struct Massless {
    Matrix V;  // c x k, interface rows of the modes; rigid ones first, eigenvalue 0
    // c x c, positive definite: compliance of the interface that is not in the modes
    Matrix F;
    double omega_closed = 0;  // rad/s, highest frequency with the interface held: limits a step
    // free, tapered, or fixed (modified Craig-Bampton, of older files); empty: not known
    std::string modes;
    double omega_fall = 0;  // rad/s, of tapered: where V falls to 0; files before 1.5: 0
  } massless;

  // Basis "characteristic" (docs/theory.md, "An interface of few shapes"): q_k are all coordinates
  // there are, and K_cc, M_cc, M_kc are empty.
  //   u_c = V q_k + B F B^T f_c,   q_k'' + diag(eigenvalues) q_k = V^T f_c
  // Column i of B (c x s) holds direction i at the three dofs of node i.
  struct Characteristic {
    Matrix V;             // c x k, rigid motions first, eigenvalue 0
    StaticShare statics;  // empty: files before 1.6, or none asked for
  } characteristic;

  std::vector<Index> dof_node;     // c, index into node_ids
  std::vector<int> dof_component;  // c, 0 1 2 = x y z; of points and shells 3 4 5 = rotations

  std::vector<Index> node_ids;  // n, the mesh's
  Points coordinates;           // n x 3
  // /interface/NAME; faces index node_ids. Empty for an interface given by nodesets only.
  std::vector<Surface> surfaces;
  // /nodesets/NAME (extension): indices into node_ids
  std::map<std::string, std::vector<Index>> nodesets;

  RigidBody rigid_body;  // of the full component

  // Of a component with fixed dofs, which are not among the c. /fixed
  struct Fixed {
    // Of the rigid motions about the centre of mass, in units of rigid_scales(), those that fixed
    // dofs resist: orthonormal combinations   (r x 6)
    Matrix resisted = Matrix(0, 6);
    // M times the six rigid motions, on the coordinates: of the modes q_k alone where they carry
    // all mass   (n x 6, k x 6)
    Matrix momentum = Matrix(0, 6);
    bool any() const { return resisted.rows() > 0; }
  } fixed;

  // Optional diagonal form: M = reduced mass, V^T M V = I, V^T K V = diag(omega^2). Rigid modes
  // first, omega = 0 exactly.
  Vector omega;  // n = k + c, rad/s, ascending; empty when not stored
  RowMatrix V;   // n x n; column j is mode j, rows in the order of q

  // Optional recovery of the interior: u_I = Psi u_c + Phi q_k, u_I with rotations of shells.
  struct Recovery {
    std::vector<Index> node_ids;  // interior nodes, mesh ids
    Points coordinates;
    // Nodes of shells whose rotations are no interface dofs, by position in [interface nodes;
    // interior nodes]. These rotations are the last rows of Psi and Phi.
    std::vector<Index> rotations;
    Matrix Psi, Phi;            // 3 (n_I + rotations) x c, and x k
    std::vector<Block> blocks;  // connectivity by position in [interface nodes; interior nodes]
  };
  std::vector<Recovery> recovery;  // none or one
  // Of recovery data: nodes of the mesh's sets, by their position in [interface nodes; interior
  // nodes]. Read without them, too.
  std::map<std::string, std::vector<Index>> recovered_sets;

  // Optional: error estimates of the reduction (docs/theory.md, "Errors known before the run"),
  // /accuracy.
  struct Accuracy {
    Vector3 rho_res = Vector3::Zero();  // residual_mass_share()
    std::optional<Vector3> rho_floor;   // its limit with all modes; lumped mass only
    // translations along, rotations about x, y, z through the centre of mass
    Vector strain_left_out = Vector::Zero(6);
    double largest_left_out = 0;  // of all rigid motions
    struct OfSurface {
      // share of the energy that a flat impact of this face loses; 0 where it was not computed
      double impact = 0;
      double strain_left_out = 0;  // of the motion that a uniform pressure on the face brings
    };
    std::map<std::string, OfSurface> surfaces;  // those that are nearly flat
    // m, of the free component's lowest elastic modes: (lambda - exact) / lambda
    Vector frequency_hz, eigenvalue_error;
    // the largest eigenvalue_error of the ten lowest, of each part; listed or not
    std::optional<double> worst_of_ten;
    // m or none: share of a mode's compliance at the interface that moves with it
    Vector interface_share;
    // up to here all of `frequency_hz` are right to 1 %; 0: none, or not estimated
    double covered_hz = 0;
    // no fixed-interface mode (of modes of the free body: none) below this is missing
    double complete_hz = 0;
    double tolerance = 0;  // that picked the modes; 0: none did
  };
  std::optional<Accuracy> accuracy;

  // optional, /conditioning: of the reduction as it was made
  std::optional<Conditioning> conditioning;

  // Optional, /loads/NAME: faces inside the component, and the forces of a unit traction along x,
  // y, z on the coordinates. The last n_residual of the modes are residual vectors, which make the
  // static response to these loads exact.
  struct InteriorLoad {
    double weight = 0;  // area of the faces
    Matrix force;       // n x 3
  };
  std::map<std::string, InteriorLoad> loads;
  Index n_residual = 0;

  // Optional, /spin_moments: sym of the integral of rho x u^T of each coordinate's displacement u,
  // x from the centre of mass: xx, yy, zz, xy, yz, xz   (n x 6). For the change of inertia and
  // centrifugal forces. Empty: not known.
  Matrix spin_moments;
  // Optional, /spin_couplings: P_ij = integral of rho phi_i phi_j^T of the m lowest elastic modes
  // of the diagonal form (3 m x 3 m, symmetric). Coriolis forces, and the inertia of second order.
  // Empty: not known.
  Matrix spin_couplings;

  std::map<std::string, std::string> provenance;  // attributes of /provenance

  Index k() const { return eigenvalues.size(); }
  Index c() const { return static_cast<Index>(dof_node.size()); }
  Index n() const { return k() + c(); }
  // without dofs that follow from others
  Index n_coordinates() const { return is_characteristic() ? k() : n(); }
  bool has_diagonal_form() const { return omega.size() > 0; }
  bool is_massless() const { return basis == "massless"; }
  bool is_characteristic() const { return basis == "characteristic"; }
  // K_cc, M_cc and M_kc, and maybe a diagonal form of them.
  bool has_interface_matrices() const { return !is_massless() && !is_characteristic(); }
};

// Reads only these parts: a run in diagonal form does not touch K_cc.
struct SuperelementParts {
  bool matrices = true;  // K_cc, M_cc, M_kc, or those of `massless` or `characteristic`
  bool diagonal = true;
  bool recovery = true;
};

// InputError naming the field: wrong shape, non-finite, non-symmetric (1e-10 of the scale), index
// out of range, negative mass, ...
void check(const Superelement& superelement, const std::string& where);

// InputError: missing file, not HDF5, truncated, wrong `format`, a higher major version, a missing
// or wrong dataset, each by name.
Superelement read_superelement(const std::filesystem::path& file,
                               const SuperelementParts& parts = {});

// check()s, writes to a temporary name beside `file`, renames. Same contents, same bytes. RunError
// when the disk refuses.
void write_superelement(const Superelement& superelement, const std::filesystem::path& file);

// Root attribute only: cheap test whether a file is up to date. Of a superelement or a group of
// them; empty when the file is neither.
std::string read_content_hash(const std::filesystem::path& file);

// True if the file of a superelement or group has its diagonal form, which this does not read.
// InputError: no such file.
bool stores_diagonal_form(const std::filesystem::path& file);

// Full reduced matrices in the order [k; c].
Matrix reduced_stiffness(const Superelement& superelement);
Matrix reduced_mass(const Superelement& superelement);

// Rigid motions in reduced coordinates, n x 6 about `center`: [0; R_c].
Matrix reduced_rigid_modes(const Superelement& superelement, const Vector3& center);

// Combinations of the six rigid motions about the centre of mass that fixed dofs leave   (6 x r)
Matrix free_combinations(const Superelement& superelement);

// rho_res for x, y, z: the share of a rigid translation's kinetic energy that sits in M_cc - M_kc^T
// M_kc.
Vector3 residual_mass_share(const Superelement& superelement);

}  // namespace cbr
