// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/superelement/superelement_check.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/linalg/dense.hpp"
#include "common/superelement/superelement_file.hpp"

namespace cbr {
namespace {

constexpr double symmetry_tolerance = 1e-10;  // of the largest entry
// of the probe: an eigensolver's residual on a stiff pencil, far below any wrong row
constexpr double diagonal_tolerance = 1e-6;
constexpr double unit_tolerance = 1e-6;   // of the length of a direction
constexpr double largest_length = 1e150;  // coordinates: their squares are still numbers
constexpr double most_round_off = 0.1;    // of the probe, however large the terms
// of the magnitudes of the terms: error of V with an ill-conditioned M
constexpr double round_off = 2e-14;

class Checker {
 public:
  Checker(const Superelement& superelement, const std::string& where)
      : s_(superelement), where_(where) {}

  void check(const SuperelementParts& parts) const {
    if (s_.basis.empty()) fail("attribute 'basis'", "is empty");
    if (s_.n() == 0)
      fail("attributes 'n_modes', 'n_interface'",
           "are both 0: the superelement has no coordinates");
    check_nodes();
    check_dofs();
    check_eigenvalues();
    if (parts.matrices && s_.is_massless()) check_massless();
    if (parts.matrices && s_.is_characteristic()) check_characteristic();
    if (parts.matrices && s_.has_interface_matrices()) check_matrices();
    for (const auto& surface : s_.surfaces) check_surface(surface);
    for (const auto& [name, nodes] : s_.nodesets) check_nodeset(name, nodes);
    check_rigid_body();
    if (!s_.has_interface_matrices() && (s_.has_diagonal_form() || s_.V.size() > 0))
      fail("/diagonal", "is there: basis " + s_.basis + " has no such form");
    if (s_.has_diagonal_form() || s_.V.size() > 0) check_diagonal();
    if (s_.has_diagonal_form() && parts.matrices) probe_diagonal();
    if (s_.recovery.size() > 1)
      fail("/recovery", "is there " + std::to_string(s_.recovery.size()) + " times, allowed: once");
    for (const auto& recovery : s_.recovery) check_recovery(recovery);
    if (!s_.recovery.empty())
      check_recovered_sets(
          static_cast<Index>(s_.node_ids.size() + s_.recovery.front().node_ids.size()));
  }

 private:
  [[noreturn]] void fail(const std::string& field, const std::string& what) const {
    throw InputError(where_ + ": " + field + ": " + what);
  }

  static std::string shape(Index rows, Index columns) {
    return "(" + std::to_string(rows) + ", " + std::to_string(columns) + ")";
  }

  template <typename Array>
  void require_shape(const std::string& field, const Array& a, Index rows, Index columns) const {
    if (a.rows() == rows && a.cols() == columns) return;
    fail(field, "wrong shape " + shape(a.rows(), a.cols()) + ", expected " + shape(rows, columns));
  }

  void require_length(const std::string& field, std::size_t length, Index expected,
                      const std::string& partner) const {
    if (static_cast<Index>(length) == expected) return;
    fail(field, "wrong length " + std::to_string(length) + ", expected " +
                    std::to_string(expected) + " as " + partner + " has");
  }

  template <typename Array>
  void require_finite(const std::string& field, const Array& a) const {
    if (a.allFinite()) return;
    for (Index j = 0; j < a.cols(); ++j) {
      for (Index i = 0; i < a.rows(); ++i) {
        if (!std::isfinite(a(i, j))) fail(field, "not finite at " + shape(i, j));
      }
    }
  }

  // Tile by tile, so that the transpose is not walked across the cache.
  void require_symmetric(const std::string& field, const Matrix& A) const {
    constexpr Index tile = 64;
    double difference = 0;
    for (Index j = 0; j < A.cols(); j += tile) {
      const Index columns = std::min(tile, A.cols() - j);
      for (Index i = j; i < A.rows(); i += tile) {
        const Index rows = std::min(tile, A.rows() - i);
        difference = std::max(
            difference, (A.block(i, j, rows, columns) - A.block(j, i, columns, rows).transpose())
                            .cwiseAbs()
                            .maxCoeff());
      }
    }
    const double scale = A.size() > 0 ? A.cwiseAbs().maxCoeff() : 0.0;
    if (difference <= symmetry_tolerance * scale) return;
    fail(field, "not symmetric: entries differ from their mirror images by " +
                    number_text(difference / scale) + " of the largest, allowed 1e-10");
  }

  void require_square(const std::string& field, const Matrix& A, Index size) const {
    require_shape(field, A, size, size);
    require_finite(field, A);
    require_symmetric(field, A);
    if (size > 0 && A.diagonal().minCoeff() < -symmetry_tolerance * A.cwiseAbs().maxCoeff())
      fail(field, "negative on the diagonal");
  }

  void require_in_range(const std::string& field, Index found, Index end) const {
    if (found >= 0 && found < end) return;
    fail(field, "index " + std::to_string(found) + " out of range, there are " +
                    std::to_string(end) + " nodes");
  }

  void require_unique(const std::string& field, const std::vector<Index>& ids) const {
    std::set<Index> seen;
    for (const Index id : ids) {
      if (!seen.insert(id).second) fail(field, "id " + std::to_string(id) + " twice");
    }
  }

  void check_nodes() const {
    require_length("/nodes/id", s_.node_ids.size(), s_.coordinates.rows(), "/nodes/coordinates");
    require_unique("/nodes/id", s_.node_ids);
    require_length_scale("/nodes/coordinates", s_.coordinates);
  }

  template <typename Array>
  void require_length_scale(const std::string& field, const Array& a) const {
    require_finite(field, a);
    const double largest = a.size() > 0 ? a.cwiseAbs().maxCoeff() : 0.0;
    if (largest > largest_length)
      fail(field, "has an entry of " + number_text(largest) + ", allowed up to 1e150");
  }

  void check_dofs() const {
    require_length("/dofs/component", s_.dof_component.size(), s_.c(), "/dofs/node");
    std::set<std::pair<Index, int>> seen;
    for (std::size_t i = 0; i < s_.dof_node.size(); ++i) {
      const int component = s_.dof_component[i];
      require_in_range("/dofs/node", s_.dof_node[i], static_cast<Index>(s_.node_ids.size()));
      if (component < 0 || component > 5)
        fail("/dofs/component",
             std::to_string(component) + " is none of 0, 1, 2 (x, y, z) and 3, 4, 5 (rotations)");
      if (!seen.emplace(s_.dof_node[i], component).second) {
        fail("/dofs/node", "component " + std::to_string(component) + " of node " +
                               std::to_string(s_.dof_node[i]) + " appears twice");
      }
    }
    for (const auto& [node, component] : seen)
      if (component > 2) check_point(node, seen);
  }

  // A node with rotations has all six dofs.
  void check_point(Index node, const std::set<std::pair<Index, int>>& dofs) const {
    if (s_.is_massless())
      fail("/dofs/component", "rotations (3, 4, 5) do not go with basis " + s_.basis);
    for (int component = 0; component < 6; ++component)
      if (dofs.count({node, component}) == 0)
        fail("/dofs/component", "node " + std::to_string(node) +
                                    " has a rotation but lacks component " +
                                    std::to_string(component) + ", expected all of 0 to 5");
  }

  void check_eigenvalues() const {
    require_finite("/matrices/eigenvalues", s_.eigenvalues);
    if (s_.k() > 0 && s_.eigenvalues.minCoeff() < 0) fail("/matrices/eigenvalues", "negative");
  }

  void check_matrices() const {
    require_square("/matrices/K_cc", s_.K_cc, s_.c());
    require_square("/matrices/M_cc", s_.M_cc, s_.c());
    require_shape("/matrices/M_kc", s_.M_kc, s_.k(), s_.c());
    require_finite("/matrices/M_kc", s_.M_kc);
  }

  void check_massless() const {
    const auto& m = s_.massless;
    if (s_.k() == 0)
      fail("attribute 'n_modes'", "is 0: basis massless has at least the rigid motions");
    require_shape("/massless/V", m.V, s_.c(), s_.k());
    require_finite("/massless/V", m.V);
    require_square("/massless/F", m.F, s_.c());
    for (Index i = 0; i < s_.c(); ++i)
      if (!(m.F(i, i) > 0))
        fail("/massless/F", "not positive on the diagonal at " + std::to_string(i));
    require_ascending();
    const double highest = std::sqrt(s_.eigenvalues.maxCoeff());
    if (!std::isfinite(m.omega_closed) || m.omega_closed < highest * (1 - 1e-9) ||
        !(m.omega_closed > 0))
      fail("/massless/omega_closed", number_text(m.omega_closed) +
                                         " is below the highest frequency of the modes, " +
                                         number_text(highest));
    if (m.omega_fall != 0 && !(std::isfinite(m.omega_fall) && m.omega_fall > highest))
      fail("/massless/omega_fall", number_text(m.omega_fall) +
                                       " is not above the highest frequency of the modes, " +
                                       number_text(highest));
  }

  void check_characteristic() const {
    if (s_.k() == 0)
      fail("attribute 'n_modes'", "is 0: basis characteristic has at least the rigid motions");
    require_shape("/characteristic/V", s_.characteristic.V, s_.c(), s_.k());
    require_finite("/characteristic/V", s_.characteristic.V);
    require_ascending();
    check_statics(s_.characteristic.statics);
  }

  void check_statics(const StaticShare& statics) const {
    const std::string group = "/characteristic/statics";
    for (const Index node : statics.node)
      require_in_range(group + "/node", node, static_cast<Index>(s_.node_ids.size()));
    require_shape(group + "/direction", statics.direction, statics.size(), 3);
    require_finite(group + "/direction", statics.direction);
    for (Index i = 0; i < statics.size(); ++i) {
      const double length = statics.direction.row(i).norm();
      if (!(std::abs(length - 1) <= unit_tolerance))
        fail(group + "/direction", "row " + std::to_string(i) + " has length " +
                                       number_text(length) + ", expected a unit vector");
    }
    for (std::size_t l = 0; l < statics.levels.size(); ++l)
      if (const Index n = statics.levels[l].P.cols(); n != statics.size())
        fail(group + "/levels/" + std::to_string(l) + "/P/begin",
             "is of " + std::to_string(n) + " columns, expected " + std::to_string(statics.size()));
    if (!statics.levels.empty()) return;
    require_square(group + "/F", statics.F, statics.size());
    for (Index i = 0; i < statics.size(); ++i)
      if (statics.F(i, i) < 0)
        fail(group + "/F", "negative on the diagonal at " + std::to_string(i));
  }

  void require_ascending() const {
    for (Index i = 1; i < s_.k(); ++i)
      if (s_.eigenvalues(i) < s_.eigenvalues(i - 1))
        fail("/matrices/eigenvalues", "not ascending at " + std::to_string(i));
  }

  // The name becomes a group's name in the file and the second half of INSTANCE.SURFACE in a scene.
  void require_name(const std::string& field, const std::string& name) const {
    if (name.empty() || name == "." || name == "..")
      fail(field, "'" + name + "' cannot be the name of a set: rename it in the mesh");
    for (const char character : name) {
      if (character == '/' || static_cast<unsigned char>(character) < 0x20) {
        fail(field,
             "the set's name '" + name +
                 "' holds a slash or a control character, which a superelement file cannot name: "
                 "rename it in the mesh");
      }
    }
  }

  void check_surface(const Surface& surface) const {
    require_name("/interface", surface.name);
    const std::string group = "/interface/" + surface.name;
    for (const auto& other : s_.surfaces) {
      if (&other != &surface && other.name == surface.name) fail(group, "appears twice");
    }
    require_shape(group + "/faces", surface.faces, surface.n_faces(), n_nodes(surface.kind));
    for (Index i = 0; i < surface.faces.size(); ++i) {
      require_in_range(group + "/faces", surface.faces.data()[i],
                       static_cast<Index>(s_.node_ids.size()));
    }
    for (Index f = 0; f < surface.n_faces(); ++f) check_face(group + "/faces", surface, f);
    require_length(group + "/element", surface.element.size(), surface.n_faces(), group + "/faces");
    require_length(group + "/side", surface.side.size(), surface.n_faces(), group + "/faces");
    for (const int side : surface.side) {
      if (side < 1 || side > 6)
        fail(group + "/side", std::to_string(side) + " is no side number, allowed: 1 to 6");
    }
  }

  // A face without an area is never touched. A triangle among quad4 (and quad8, quad9) repeats its
  // last node.
  void check_face(const std::string& field, const Surface& surface, Index f) const {
    const bool is_triangle = surface.kind == FaceKind::tri3 || surface.kind == FaceKind::tri6;
    const Index n_corners = is_triangle ? 3 : 4;
    const auto row = surface.faces.row(f);
    Index n_distinct = 0;
    for (Index a = 0; a < n_corners; ++a) {
      bool is_new = true;
      for (Index b = 0; b < a; ++b) is_new = is_new && row[a] != row[b];
      n_distinct += is_new;
    }
    const bool collapsed = n_distinct == 3 && !is_triangle && row[3] == row[2];
    if (n_distinct < n_corners && !collapsed)
      fail(field, "face " + std::to_string(f) + " repeats a node");
    // Corners may be far from the origin: differences of them
    Vector3 area = Vector3::Zero();
    double longest = 0;
    for (Index a = 1; a < n_corners; ++a) {
      const Vector3 edge = (s_.coordinates.row(row[a]) - s_.coordinates.row(row[0])).transpose();
      if (a > 1)
        area +=
            edge.cross((s_.coordinates.row(row[a - 1]) - s_.coordinates.row(row[0])).transpose());
      longest = std::max(longest, edge.squaredNorm());
    }
    if (!(area.norm() > 1e-12 * longest))
      fail(field, "face " + std::to_string(f) + " has no area by /nodes/coordinates");
  }

  void check_nodeset(const std::string& name, const std::vector<Index>& nodes) const {
    require_name("/nodesets", name);
    for (const Index node : nodes)
      require_in_range("/nodesets/" + name, node, static_cast<Index>(s_.node_ids.size()));
    require_unique("/nodesets/" + name, nodes);
  }

  void check_rigid_body() const {
    const auto& body = s_.rigid_body;
    if (!std::isfinite(body.mass) || body.mass <= 0)
      fail("/rigid_body/mass", number_text(body.mass) + " is not a positive number");
    require_length_scale("/rigid_body/center", body.center);
    require_finite("/rigid_body/inertia", body.inertia);
    require_symmetric("/rigid_body/inertia", body.inertia);
    const double scale = body.inertia.cwiseAbs().maxCoeff();
    if (symmetric_eigenvalues3(body.inertia).minCoeff() < -symmetry_tolerance * scale) {
      fail("/rigid_body/inertia", "has a negative moment of inertia");
    }
  }

  void check_diagonal() const {
    require_shape("/diagonal/omega", s_.omega, s_.n(), 1);
    require_shape("/diagonal/V", s_.V, s_.n(), s_.n());
    require_finite("/diagonal/omega", s_.omega);
    require_finite("/diagonal/V", s_.V);
    if (s_.omega.minCoeff() < 0) fail("/diagonal/omega", "negative");
    for (Index i = 1; i < s_.omega.size(); ++i) {
      if (s_.omega(i) < s_.omega(i - 1))
        fail("/diagonal/omega", "not ascending at " + std::to_string(i));
    }
  }

  template <bool absolute>
  static auto if_absolute(const Matrix& A) {
    if constexpr (absolute) {
      return A.cwiseAbs();
    } else {
      return Eigen::Map<const Matrix>(A.data(), A.rows(), A.cols());
    }
  }

  // A y for A = M or K in the order [k; c], or |A| y.
  template <bool absolute>
  Vector times_mass(const Vector& y) const {
    const auto y_k = y.head(s_.k()), y_c = y.tail(s_.c());
    const auto part = [](const Matrix& A) { return if_absolute<absolute>(A); };
    Vector My(s_.n());
    My << y_k, part(s_.M_cc) * y_c;
    // BLAS complains, on stdout, about a matrix without rows.
    if (s_.k() > 0) {
      My.head(s_.k()) += part(s_.M_kc) * y_c;
      My.tail(s_.c()) += part(s_.M_kc).transpose() * y_k;
    }
    return My;
  }
  template <bool absolute>
  Vector times_stiffness(const Vector& y) const {
    Vector Ky(s_.n());
    Ky << s_.eigenvalues.cwiseProduct(y.head(s_.k())),
        if_absolute<absolute>(s_.K_cc) * y.tail(s_.c());
    return Ky;
  }
  // V^T M V = I and V^T K V = diag(omega^2) on one vector x with entries +-1: O(n^2), and a wrong
  // row or column of V, M or K cannot hide from it except by chance. Allowed besides is the
  // round-off of the sums, which counts when V is large against I.
  void probe_diagonal() const {
    const Vector x = random_signs(s_.n());
    const Vector y = s_.V * x, size = s_.V.cwiseAbs().rowwise().sum();  // V x, |V| |x|   (n)
    const Vector lambda = s_.omega.cwiseAbs2();
    const Vector wrong_M = s_.V.transpose() * times_mass<false>(y) - x;
    const Vector wrong_K = s_.V.transpose() * times_stiffness<false>(y) - lambda.cwiseProduct(x);
    const auto allowed = [&](double scale, const Vector& sums) {
      return diagonal_tolerance * scale * x.norm() +
             std::min(round_off * (s_.V.cwiseAbs().transpose() * sums).norm(),
                      most_round_off * scale * x.norm());
    };
    if (!(wrong_M.norm() <= allowed(1, times_mass<true>(size)))) {
      fail("/diagonal/V", "is not orthonormal with the reduced mass: V^T M V is not the identity");
    }
    if (!(wrong_K.norm() <= allowed(lambda.maxCoeff(), times_stiffness<true>(size)))) {
      fail("/diagonal/omega", "does not fit the reduced stiffness: V^T K V is not diag(omega^2)");
    }
  }

  void check_recovery(const Superelement::Recovery& recovery) const {
    const Index n_i = static_cast<Index>(recovery.node_ids.size());
    require_shape("/recovery/nodes/coordinates", recovery.coordinates, n_i, 3);
    require_length_scale("/recovery/nodes/coordinates", recovery.coordinates);
    require_unique("/recovery/nodes/id", recovery.node_ids);
    const auto rows = 3 * (n_i + static_cast<Index>(recovery.rotations.size()));
    require_shape("/recovery/Psi", recovery.Psi, rows, s_.c());
    require_shape("/recovery/Phi", recovery.Phi, rows, s_.k());
    require_unique("/recovery/rotations/node", recovery.rotations);
    for (const Index node : recovery.rotations)
      require_in_range("/recovery/rotations/node", node,
                       static_cast<Index>(s_.node_ids.size()) + n_i);
    require_finite("/recovery/Psi", recovery.Psi);
    require_finite("/recovery/Phi", recovery.Phi);
    for (const auto& block : recovery.blocks) {
      const std::string group = "/recovery/blocks, block '" + block.name + "'";
      require_length(group + ", element_id", block.element_ids.size(), block.connectivity.rows(),
                     "connectivity");
      require_shape(group + ", connectivity", block.connectivity, block.connectivity.rows(),
                    n_nodes(block.type));
      for (Index i = 0; i < block.connectivity.size(); ++i) {
        require_in_range(group, block.connectivity.data()[i],
                         static_cast<Index>(s_.node_ids.size()) + n_i);
      }
    }
  }

  void check_recovered_sets(Index n) const {
    for (const auto& [name, nodes] : s_.recovered_sets)
      for (const Index node : nodes) require_in_range("/recovery/sets/" + name, node, n);
  }

  const Superelement& s_;
  const std::string& where_;
};

}  // namespace

void check_parts(const Superelement& superelement, const SuperelementParts& parts,
                 const std::string& where) {
  Checker(superelement, where).check(parts);
  check_extras(superelement, where);
}

void check(const Superelement& superelement, const std::string& where) {
  check_parts(superelement, {}, where);
}

}  // namespace cbr
