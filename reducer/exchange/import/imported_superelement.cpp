// SPDX-License-Identifier: GPL-3.0-or-later

#include <algorithm>
#include <cmath>
#include <map>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/linalg/dense.hpp"
#include "reducer/exchange/import/import.hpp"
#include "reducer/partition/interface_sets.hpp"

namespace cbr {
namespace {

// of the diagonals: far above the digits that codes write, far below another kind of reduction
constexpr double coupling = 1e-6;
constexpr double asymmetry = 1e-8;   // of the largest entry
constexpr double no_force = 1e-6;    // of |K_cc| |R|, as in superelement_rigid_check.cpp
constexpr double one_mass = 1e-6;    // cbr-dyn wants no less of a body in modal coordinates
constexpr double same_place = 1e-6;  // of the mesh's size: nine digits would do

// Where each coordinate of the superelement is among the rows.
struct Order {
  std::vector<Index> modes, dofs;
};

std::string row_name(const ReducedRow& row) {
  static const std::string motions[] = {"x", "y", "z", "rx", "ry", "rz"};
  return row.dof == 0 ? "modal coordinate " + std::to_string(row.node)
                      : motions[row.dof - 1] + " of node " + std::to_string(row.node);
}

class Importer {
 public:
  Importer(const ReducedMatrices& reduced, const std::string& where,
           std::vector<std::string>& doubts)
      : r_(reduced), where_(where), doubts_(doubts) {}

  Superelement run() {
    order_rows();
    require_symmetric("K", r_.K);
    require_symmetric("M", r_.M);
    require_decoupled();
    require_positive();
    const auto &modes = order_.modes, &dofs = order_.dofs;
    s_.eigenvalues = r_.K.diagonal()(modes);
    s_.K_cc = part(r_.K, dofs);
    s_.M_cc = part(r_.M, dofs);
    s_.M_kc = r_.M(modes, dofs);
    add_rigid_body();
    name_points();
    return std::move(s_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(where_ + ": " + what); }
  const ReducedRow& row(Index i) const { return r_.rows[i]; }

  // Exactly symmetric; a symmetric part keeps its bits.
  static Matrix part(const Matrix& A, const std::vector<Index>& dofs) {
    const Matrix A_cc = A(dofs, dofs);
    return 0.5 * (A_cc + A_cc.transpose());
  }

  void order_rows() {
    std::map<Index, std::vector<std::pair<int, Index>>> of_node;  // (dof, row)
    for (Index i = 0; i < static_cast<Index>(r_.rows.size()); ++i) {
      if (row(i).dof == 0) {
        order_.modes.push_back(i);
        continue;
      }
      auto& dofs = of_node[row(i).node];
      if (dofs.empty()) s_.node_ids.push_back(row(i).node);
      dofs.emplace_back(row(i).dof, i);
    }
    if (s_.node_ids.empty())
      fail("has no interface dof: exports of characteristic and massless bases do not come back");
    s_.coordinates.resize(static_cast<Index>(s_.node_ids.size()), 3);
    for (std::size_t node = 0; node < s_.node_ids.size(); ++node) {
      auto& dofs = of_node.at(s_.node_ids[node]);
      std::sort(dofs.begin(), dofs.end());
      s_.coordinates.row(static_cast<Index>(node)) = row(dofs.front().second).position.transpose();
      for (const auto& [dof, i] : dofs) {
        if (row(i).position != row(dofs.front().second).position)
          fail("node " + std::to_string(s_.node_ids[node]) + " has several positions");
        s_.dof_node.push_back(static_cast<Index>(node));
        s_.dof_component.push_back(dof - 1);
        order_.dofs.push_back(i);
      }
    }
  }

  // A node with rotations is a point, which a scene names by its set.
  void name_points() {
    for (std::size_t i = 0; i < s_.dof_node.size(); ++i)
      if (s_.dof_component[i] > 2)
        s_.nodesets["node_" + std::to_string(s_.node_ids[s_.dof_node[i]])] = {s_.dof_node[i]};
  }

  void require_symmetric(const char* name, const Matrix& A) const {
    const double scale = A.cwiseAbs().maxCoeff(),
                 difference = (A - A.transpose()).cwiseAbs().maxCoeff();
    if (!(difference <= asymmetry * scale))
      fail(std::string(name) + " is not symmetric: entries differ from their mirror images by " +
           number_text(difference / scale) + " of the largest, allowed 1e-8");
  }

  // K_kc = 0, K_kk diagonal, M_kk = I: a Craig-Bampton superelement with modes of unit mass.
  void require_decoupled() const {
    const Vector scale = r_.K.diagonal().cwiseAbs().cwiseSqrt();
    for (const Index j : order_.modes) {
      for (Index i = 0; i < r_.K.rows(); ++i) {
        if (i != j && !(std::abs(r_.K(i, j)) <= coupling * scale(i) * scale(j)))
          fail("K couples " + row_name(row(j)) + " with " + row_name(row(i)) +
               ": not a Craig-Bampton superelement of fixed-interface modes");
        if (row(i).dof != 0) continue;
        if (!(std::abs(r_.M(i, j) - (i == j ? 1.0 : 0.0)) <= coupling))
          fail("M has " + number_text(r_.M(i, j)) + " at " + row_name(row(j)) + " and " +
               row_name(row(i)) + ", expected " + (i == j ? "1" : "0") +
               ": scale modes to unit mass, or export again if the file is damaged");
      }
    }
  }

  void require_positive() const {
    for (Index i = 0; i < r_.K.rows(); ++i)
      for (const auto& [name, A] : {std::pair("K", &r_.K), std::pair("M", &r_.M)})
        if (!((*A)(i, i) > 0))
          fail(std::string(name) + " has " + number_text((*A)(i, i)) + " on the diagonal at " +
               row_name(row(i)) +
               ", expected a positive number: export again if the file is damaged");
  }

  // Twice: about the mean of the nodes, then about the centre of mass that this gives, where
  // nothing cancels.
  void add_rigid_body() {
    RigidBody& body = s_.rigid_body;
    body.center = s_.coordinates.colwise().mean().transpose();
    for (const bool about_center : {false, true}) {
      const Matrix R = reduced_rigid_modes(s_, body.center).bottomRows(s_.c());
      if (!about_center) require_rigid(R);
      // R_c^T M_cc R_c   (6 x 6)
      const Matrix6 r = R.transpose() * (s_.M_cc * R);
      body.mass = r.diagonal().head<3>().mean();
      if (!(body.mass > 0))
        fail("the mass of its rigid translations is " + number_text(body.mass) +
             ", expected a positive number");
      if (about_center) require_one_mass(r.topLeftCorner<3, 3>());
      if (about_center) {
        body.inertia =
            0.5 * (r.bottomRightCorner<3, 3>() + r.bottomRightCorner<3, 3>().transpose());
      } else {
        // t_i^T M (e_k x x) = m (e_k x c)_i: each component of c twice, in two translations.
        const Vector3 moment(r(1, 5) - r(2, 4), r(2, 3) - r(0, 5), r(0, 4) - r(1, 3));
        body.center += moment / (2 * body.mass);
      }
    }
  }

  // R   (c x 6)
  void require_rigid(Matrix R) {
    const double size =
        (s_.coordinates.rowwise() - s_.coordinates.colwise().mean()).rowwise().norm().maxCoeff();
    if (!(size > 0) || !std::isfinite(size))
      fail("all interface nodes are at one place: they do not determine the mass of the part");
    R.rightCols(3) /= size;
    if (PivotedQr(R, 1e-6).rank() < 6)
      fail(
          "the interface's dofs do not determine the six rigid motions, which tell the mass of the "
          "part");
    const Matrix force = s_.K_cc * R;
    const double translation = force.leftCols(3).norm() / (s_.K_cc.norm() * R.leftCols(3).norm());
    const double rotation = force.rightCols(3).norm() / (s_.K_cc.norm() * R.rightCols(3).norm());
    if (!(translation <= no_force))
      fail("K resists rigid translations, by " + number_text(translation) +
           " of its size: the part is held inside, so that its mass is unknown: import the part "
           "without supports");
    if (!(rotation <= no_force))
      fail("K resists rigid rotations about the nodes' coordinates, by " + number_text(rotation) +
           " of its size: the coordinates do not belong to the matrices, or the part is held "
           "inside");
    doubt_rows(R, force);
  }

  // One entry that is missing shows in its row alone.
  void doubt_rows(const Matrix& R, const Matrix& force) {
    Matrix scale = s_.K_cc.cwiseAbs() * R.cwiseAbs();
    // By symmetry a row may have no part in a motion, but of round-off
    constexpr double least_part = 1e-3;
    const Eigen::RowVectorXd most = R.cwiseAbs().colwise().maxCoeff().cwiseMax(1e-300);
    const Vector of_row = (scale.array().rowwise() / most.array()).rowwise().maxCoeff();
    scale += least_part * of_row * most;
    Index worst = 0, motion = 0;
    const double share =
        (force.cwiseAbs().array() / (scale.array() + 1e-300)).maxCoeff(&worst, &motion);
    if (share <= no_force) return;
    const ReducedRow& at = row(order_.dofs[worst]);
    doubts_.push_back(where_ + ": K resists rigid motion at " + row_name(at) + ", by " +
                      number_text(share) +
                      " of its row: an entry may be missing there: export it again");
  }

  // m I, whatever the part is.
  void require_one_mass(const Matrix3& m) const {
    const double mean = m.diagonal().mean();
    const double off = (m - mean * Matrix3::Identity()).cwiseAbs().maxCoeff() / mean;
    if (!(off <= one_mass))
      fail("the mass of its rigid translations along x, y and z is " + number_text(m(0, 0)) + ", " +
           number_text(m(1, 1)) + " and " + number_text(m(2, 2)) +
           ", expected one number, and no coupling (" + number_text(off) +
           " of it found): entries of M are missing or wrong, export it again");
  }

  const ReducedMatrices& r_;
  const std::string& where_;
  std::vector<std::string>& doubts_;
  Order order_;
  Superelement s_;
};

// Sides of solid elements with all nodes in the set that no other element shares.
Sideset outer_sides(const Mesh& mesh, const std::vector<char>& is_in, const std::string& name) {
  std::map<std::vector<Index>, std::vector<Side>> sides;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    const Block& block = mesh.blocks[b];
    if (dimension(block.type) != 3) continue;
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      for (int side = 1; side <= n_sides(block.type); ++side) {
        const Side one{static_cast<Index>(b), e, side};
        std::vector<Index> nodes = nodes_of_side(mesh, one);
        if (!std::all_of(nodes.begin(), nodes.end(), [&](Index node) { return is_in[node] != 0; }))
          continue;
        std::sort(nodes.begin(), nodes.end());
        sides[nodes].push_back(one);
      }
    }
  }
  Sideset set{name, 0, {}};
  for (const auto& [nodes, same] : sides)
    if (same.size() == 1) set.sides.push_back(same.front());
  const auto key = [](const Side& side) { return std::tuple(side.block, side.element, side.side); };
  std::sort(set.sides.begin(), set.sides.end(),
            [&](const Side& a, const Side& b) { return key(a) < key(b); });
  return set;
}

// Interface node of each mesh node, or -1.
std::vector<Index> places_in(const Mesh& mesh, const std::string& mesh_file,
                             const std::string& where, const Superelement& s) {
  std::map<Index, Index> row_of_id;
  for (std::size_t i = 0; i < mesh.node_ids.size(); ++i)
    row_of_id.emplace(mesh.node_ids[i], static_cast<Index>(i));
  const double size =
      (mesh.coordinates.colwise().maxCoeff() - mesh.coordinates.colwise().minCoeff()).norm();
  std::vector<Index> place(mesh.node_ids.size(), -1);
  std::vector<char> is_point(s.node_ids.size(), 0);  // which the mesh need not have
  for (std::size_t i = 0; i < s.dof_node.size(); ++i)
    if (s.dof_component[i] > 2) is_point[s.dof_node[i]] = 1;
  for (std::size_t i = 0; i < s.node_ids.size(); ++i) {
    const std::string node = "interface node " + std::to_string(s.node_ids[i]) + " of " + where;
    const auto found = row_of_id.find(s.node_ids[i]);
    if (found == row_of_id.end() && is_point[i] != 0) continue;
    if (found == row_of_id.end())
      throw InputError(mesh_file + ": has no " + node +
                       ": give --faces the mesh that it was made from");
    const double apart =
        (mesh.coordinates.row(found->second) - s.coordinates.row(static_cast<Index>(i))).norm();
    if (!(apart <= same_place * size) && is_point[i] != 0) continue;
    if (!(apart <= same_place * size))
      throw InputError(mesh_file + ": " + node + " is " + number_text(apart) +
                       " away from its place in the mesh: give --faces the mesh that it was made "
                       "from, in the same unit");
    place[found->second] = static_cast<Index>(i);
  }
  return place;
}

}  // namespace

Superelement superelement_of(const ReducedMatrices& reduced, const std::string& where,
                             std::vector<std::string>& doubts) {
  return Importer(reduced, where, doubts).run();
}

void place_rows(const Mesh& mesh, const std::string& mesh_file, const std::string& where,
                ReducedMatrices& reduced) {
  std::map<Index, Index> row_of_id, n_rows;
  for (std::size_t i = 0; i < mesh.node_ids.size(); ++i)
    row_of_id.emplace(mesh.node_ids[i], static_cast<Index>(i));
  for (const ReducedRow& row : reduced.rows) ++n_rows[row.node];
  for (ReducedRow& row : reduced.rows) {
    const auto found = row_of_id.find(row.node);
    if (found != row_of_id.end())
      row.position = mesh.coordinates.row(found->second).transpose();
    else if (n_rows[row.node] == 1)
      row.dof = 0;
    else
      throw InputError(mesh_file + ": has no node " + std::to_string(row.node) + " of " + where +
                       ": give --faces the mesh that it was made from");
  }
}

void add_faces(const Mesh& mesh, const std::string& mesh_file, const std::string& where,
               Superelement& s) {
  const std::vector<Index> place = places_in(mesh, mesh_file, where, s);
  add_interface_sets(mesh, place, {}, s);
  if (!s.surfaces.empty()) return;
  Mesh with_sides = mesh;
  with_sides.sidesets.clear();
  with_sides.nodesets.clear();
  const auto add_surface = [&](const std::string& name, const std::vector<Index>& nodes) {
    std::vector<char> is_in(mesh.node_ids.size(), 0);
    for (const Index node : nodes) is_in[node] = 1;
    Sideset sides = outer_sides(mesh, is_in, name);
    if (!sides.sides.empty()) with_sides.sidesets.push_back(std::move(sides));
  };
  for (const Nodeset& nodeset : mesh.nodesets)
    if (s.nodesets.count(nodeset.name) > 0) add_surface(nodeset.name, nodeset.nodes);
  if (s.nodesets.empty()) {
    std::vector<Index> all;
    for (std::size_t i = 0; i < place.size(); ++i)
      if (place[i] >= 0) all.push_back(static_cast<Index>(i));
    add_surface("interface", all);
  }
  add_interface_sets(with_sides, place, {}, s);
  // A scene finds the surface first, whose nodes these are unless a node of the set is on no face.
  for (const Surface& surface : s.surfaces) {
    const auto found = s.nodesets.find(surface.name);
    if (found != s.nodesets.end() && found->second.size() == surface_nodes(surface).size())
      s.nodesets.erase(found);
  }
  if (s.surfaces.empty() && s.nodesets.empty())
    throw InputError(mesh_file +
                     ": no set, and no outer side of an element, lies within the interface of " +
                     where);
}

}  // namespace cbr
