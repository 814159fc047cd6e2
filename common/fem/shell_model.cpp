// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/shell_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/fem/connected_parts.hpp"
#include "common/fem/elements/shell_plane.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"

namespace cbr {
namespace {

// Without density the rotations are condensed, which leaves a full matrix of the skin's
// translations.
constexpr Index most_condensed_nodes = 5000;
// Weaker pivots are the round-off of stiffer directions of the same node, and are held up by
// `support` of the stiffest.
constexpr double weak_pivot = 1e-11, support = 1e-13;

bool counts(double x) { return x >= std::numeric_limits<double>::min(); }

std::string number(double x) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", x);
  return text.data();
}

void check_properties(const ShellProperties& shell) {
  const auto refuse = [](const std::string& what, double got, const std::string& allowed) {
    throw InputError("shells: " + what + " is " + number(got) + "; it must be " + allowed);
  };
  const auto from_zero = [&](const std::string& what, double x) {
    if (!(std::isfinite(x) && x >= 0)) refuse(what, x, "finite and at least 0");
  };
  from_zero("youngs_modulus", shell.material.youngs_modulus);
  from_zero("density", shell.material.density);
  from_zero("thickness", shell.thickness);
  const double nu = shell.material.poissons_ratio;
  if (!(nu > -1 && nu <= 0.5)) refuse("poissons_ratio", nu, "above -1 and at most 0.5");
}

struct Face {
  ElementType type = ElementType::quad4;
  std::array<Index, 4> node{};  // n: places in ShellModel::nodes
  Points X;
};

std::string describe(const IndexTable& faces, Index f) {
  const bool triangle = faces(f, 3) == faces(f, 2);
  std::string rows;
  for (Index i = 0; i < (triangle ? 3 : 4); ++i)
    rows += (i == 0 ? "" : ", ") + std::to_string(faces(f, i));
  return "face " + std::to_string(f) + " (nodes of rows " + rows + ")";
}

Face read_face(const IndexTable& faces, Index f, const Points& points,
               const std::vector<Index>& nodes) {
  Face face;
  if (faces(f, 3) == faces(f, 2)) face.type = ElementType::tri3;
  face.X.resize(n_nodes(face.type), 3);
  for (Index i = 0; i < face.X.rows(); ++i) {
    face.X.row(i) = points.row(faces(f, i));
    face.node[i] = std::lower_bound(nodes.begin(), nodes.end(), faces(f, i)) - nodes.begin();
  }
  const double corner = shell::corner_jacobian(face.type, face.X);
  if (!(corner > shell::flat_corner))
    throw InputError("shells: " + describe(faces, f) +
                     " is degenerate: its nodes coincide, lie on a line, or do not make a convex "
                     "face; correct the mesh");
  return face;
}

std::vector<Index> used_nodes(const IndexTable& faces, const Points& points) {
  std::vector<Index> nodes(faces.data(), faces.data() + faces.size());
  sort_uniquely(nodes);
  if (!nodes.empty() && (nodes.front() < 0 || nodes.back() >= points.rows()))
    throw InputError("shells: a face names row " +
                     std::to_string(nodes.front() < 0 ? nodes.front() : nodes.back()) + " of " +
                     std::to_string(points.rows()) + " nodes");
  return nodes;
}

[[noreturn]] void overflow(const IndexTable& faces, Index f, const char* what) {
  throw InputError("shells: the " + std::string(what) + " of " + describe(faces, f) +
                   " exceeds what a double can hold; check youngs_modulus, density, thickness and "
                   "the mesh's unit of length");
}

// 6 m x 6 m, translations first.
SparseMatrix assemble_stiffness(const IndexTable& faces, const std::vector<Face>& elements, Index m,
                                const ShellProperties& shell) {
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (std::size_t f = 0; f < elements.size(); ++f) {
    const Face& face = elements[f];
    const Matrix K = shell_stiffness(face.type, face.X, shell);
    if (!K.allFinite()) overflow(faces, static_cast<Index>(f), "stiffness");
    const auto place = [&](Index dof) {
      const Index node = face.node[dof / 6], c = dof % 6;
      return c < 3 ? 3 * node + c : 3 * m + 3 * node + c - 3;
    };
    for (Index j = 0; j < K.cols(); ++j)
      for (Index i = 0; i < K.rows(); ++i)
        if (K(i, j) != 0) entries.emplace_back(place(i), place(j), K(i, j));
  }
  SparseMatrix K(6 * m, 6 * m);
  K.setFromTriplets(entries.begin(), entries.end());
  for (Index j = 0; j < K.outerSize(); ++j)
    for (SparseMatrix::InnerIterator entry(K, j); entry; ++entry)
      if (!std::isfinite(entry.value())) overflow(faces, 0, "stiffness around the nodes");
  return K;
}

// Adds `support` of the stiffest rotation of each node to its diagonal.
SparseMatrix supported(SparseMatrix K_rr) {
  const Vector diagonal = K_rr.diagonal();
  SparseMatrix added(K_rr.rows(), K_rr.cols());
  added.setIdentity();
  for (Index i = 0; i < diagonal.size(); ++i)
    added.coeffRef(i, i) = support * diagonal.segment<3>(i / 3 * 3).maxCoeff();
  return K_rr + added;
}

// K_tt - K_tr K_rr^-1 K_rt   (3 m x 3 m). K is scaled to the size of 1 meanwhile, rotations by a
// length of the skin: products of three entries must not leave a double's range.
SparseMatrix condense_rotations(const SparseMatrix& K) {
  const Index n = K.rows() / 2;
  if (n > 3 * most_condensed_nodes)
    throw InputError(
        "shells: " + std::to_string(n / 3) +
        " nodes with a modulus but no density: the rotations would have no inertia, and to "
        "eliminate them for more than " +
        std::to_string(most_condensed_nodes) +
        " nodes takes too much memory; give the shells a density (it may be small)");
  Vector scale(2 * n);
  const Vector diagonal = K.diagonal();
  scale.head(n).setConstant(1 / std::sqrt(diagonal.head(n).maxCoeff()));
  scale.tail(n).setConstant(1 / std::sqrt(diagonal.tail(n).maxCoeff()));
  const SparseMatrix k = scale.asDiagonal() * K * scale.asDiagonal();
  SparseMatrix k_rr = k.bottomRightCorner(n, n);
  const SparseMatrix k_rt = k.bottomLeftCorner(n, n);
  SparseCholesky factor(k_rr);
  if (!factor.ok() || !(factor.smallest_pivot() > weak_pivot))
    factor = SparseCholesky(supported(k_rr));
  if (!factor.ok())
    throw RunError("shells: the rotations cannot be eliminated; give the shells a density");
  const Matrix X = factor.solve(Matrix(k_rt));
  Matrix S = Matrix(k.topLeftCorner(n, n)) - k_rt.transpose() * X;
  S = (S + S.transpose()).eval() * (0.5 / scale(0) / scale(0));
  return S.sparseView(0, 0);
}

}  // namespace

ShellModel assemble_shells(const IndexTable& faces, const Points& points,
                           const ShellProperties& shell) {
  check_properties(shell);
  ShellModel model;
  const bool stiff = counts(shell.material.youngs_modulus * shell.thickness);
  const bool heavy = counts(shell.material.density * shell.thickness);
  if (faces.rows() == 0 || !(stiff || heavy)) return model;

  model.nodes = used_nodes(faces, points);
  const auto m = static_cast<Index>(model.nodes.size());
  std::vector<Face> elements;
  for (Index f = 0; f < faces.rows(); ++f)
    elements.push_back(read_face(faces, f, points, model.nodes));

  Vector mass = Vector::Zero(m), rotary = Vector::Zero(m);
  for (std::size_t f = 0; f < elements.size(); ++f) {
    const ShellMass lumped = shell_lumped_mass(elements[f].type, elements[f].X, shell);
    if (!lumped.mass.allFinite() || !lumped.rotary.allFinite())
      overflow(faces, static_cast<Index>(f), "mass");
    for (Index i = 0; i < lumped.mass.size(); ++i) {
      mass(elements[f].node[i]) += lumped.mass(i);
      rotary(elements[f].node[i]) += lumped.rotary(i);
    }
  }
  if (!mass.allFinite() || !rotary.allFinite()) overflow(faces, 0, "mass around the nodes");
  if (counts(mass.minCoeff())) model.mass = mass;
  if (stiff) model.K = assemble_stiffness(faces, elements, m, shell);
  // Translations that are stiff without their rotations would resist rigid motions.
  if (stiff && !counts(Vector(model.K.diagonal()).tail(3 * m).maxCoeff())) model.K = SparseMatrix();
  if (model.K.size() == 0) return model;
  if (model.mass.size() > 0 && counts(rotary.minCoeff()))
    model.rotary = rotary;
  else
    model.K = condense_rotations(model.K);
  return model;
}

namespace {

constexpr double on_a_line = 1e-6;  // of the size of the nodes' set

// Whether the six rigid motions of these places are told apart by their displacements.
bool hold(const Points& all) {
  Points x = all.rowwise() - all.colwise().mean();
  const double size = x.rowwise().norm().maxCoeff();
  return size > 0 && PivotedQr(rigid_modes(x / size, Vector3::Zero()), on_a_line).rank() == 6;
}

}  // namespace

std::string hinged_shells(const Mesh& mesh, const FiniteElementModel& model) {
  if (model.n_rotations == 0) return {};
  Mesh shells;  // alone
  std::vector<char> is_of_solid(mesh.node_ids.size(), 0);
  for (const Block& block : mesh.blocks) {
    if (!is_structure(block)) continue;
    if (dimension(block.type) != 3) {
      shells.blocks.push_back(block);
      continue;
    }
    for (const Index node : block.connectivity.reshaped()) is_of_solid[node] = 1;
  }
  shells.coordinates = mesh.coordinates;
  shells.node_ids = mesh.node_ids;
  FiniteElementModel alone;
  number_nodes(shells, alone);
  const std::vector<Index> part = connected_parts(shells, alone);
  std::map<Index, std::vector<Index>> shared;  // of each part, mesh nodes
  for (Index i = 0; i < alone.n_translations(); ++i) {
    const Index node = alone.nodes[i];
    if (is_of_solid[node] != 0) shared[part[i]].push_back(node);
  }
  for (const auto& [number, nodes] : shared) {
    if (hold(mesh.coordinates(nodes, Eigen::all))) continue;
    std::string name;
    for (const Block& block : shells.blocks)
      for (const Index node : block.connectivity.reshaped())
        if (name.empty() && node == nodes.front()) name = block.name;
    return "shells of block '" + name + "' share " + std::to_string(nodes.size()) +
           " nodes with solids, all on one line (first node id " +
           std::to_string(mesh.node_ids[nodes.front()]) +
           "): they turn about it as on a hinge, as solids have no rotations; to hold them, let "
           "them go on along a face of the solids, or hold their rotations (boundary.rotations)";
  }
  return {};
}

}  // namespace cbr
