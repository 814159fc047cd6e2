// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/modes/interior_loads.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/mesh/face_weights.hpp"
#include "common/mesh/surface.hpp"
#include "common/scene/scene_words.hpp"

namespace cbr {
namespace {

// Of the strain energy of K_II^-1 F: least energy outside the modes, and outside the other vectors,
// for another vector.
constexpr double round_off = 1e-10;

// Place of each mesh node's first dof in u_I (>= 0) or, as -1 - place, in u_C.
std::vector<Index> places(const Mesh& mesh, const FiniteElementModel& model, const Partition& p) {
  std::vector<Index> place(mesh.node_ids.size(), 0);
  const Index n = model.n_translations();  // behind them are rotations
  for (std::size_t i = 0; i < p.interior_nodes.size() && p.interior_nodes[i] < n; ++i)
    place[model.nodes[p.interior_nodes[i]]] = 3 * static_cast<Index>(i);
  for (std::size_t i = 0; i < p.interface_nodes.size() && p.interface_nodes[i] < n; ++i)
    place[model.nodes[p.interface_nodes[i]]] = -1 - 3 * static_cast<Index>(i);
  return place;
}

bool is_nodeset(const Mesh& mesh, const std::string& name) {
  return find_sideset(mesh, name) < 0 && find_nodeset(mesh, name) >= 0;
}

Surface surface_of_load(const Mesh& mesh, const std::string& name) {
  const Index set = find_sideset(mesh, name);
  if (set < 0)
    throw InputError("loads: the mesh has no sideset '" + name +
                     "' (available: " + set_names(mesh) + ")");
  return extract_surface(mesh, mesh.sidesets[set]);
}

}  // namespace

void refuse_loads_inside(const Mesh& mesh, const ReductionOptions& reduction,
                         const std::vector<std::string>& sets, bool takes_faces_in) {
  if (sets.empty()) return;
  const FiniteElementModel model = number_nodes(mesh);
  std::vector<char> is_kept(mesh.node_ids.size(), 0);
  for (const Index i : nodes_of_sets(mesh, model, reduction)) is_kept[model.nodes[i]] = 1;
  for (const std::string& name : sets) {
    const bool of_nodes = is_nodeset(mesh, name);
    const std::vector<Index> nodes =
        of_nodes ? set_nodes(mesh, name) : surface_nodes(surface_of_load(mesh, name));
    if (std::all_of(nodes.begin(), nodes.end(), [&](Index node) { return is_kept[node] != 0; }))
      continue;
    if (!reduction.interface_points.empty())
      throw InputError("loads: '" + name +
                       "' lies inside the part, and reduction.points knows loads on the interface "
                       "only: give the load a point, or add '" +
                       name + "' to reduction.interface");
    if (of_nodes)
      throw InputError(
          "loads: nodeset '" + name +
          "' lies inside the part, and forces on nodes act on nodes that are kept: add '" + name +
          "' to reduction.interface");
    if (takes_faces_in) continue;
    const std::string who = reduction.is_decomposed()
                                ? "domains above 1 know"
                                : "basis: " + word_of(basis_words, reduction.basis) + " knows";
    throw InputError("loads: '" + name + "' lies inside the part, and " + who +
                     " loads on the interface only: add it to reduction.interface, or use basis: "
                     "craig-bampton with domains: 1");
  }
}

InteriorLoads interior_loads(const Mesh& mesh, const FiniteElementModel& model, const Partition& p,
                             const std::vector<std::string>& sets) {
  InteriorLoads loads;
  const std::vector<Index> place = places(mesh, model, p);
  std::vector<Vector> weights;
  std::vector<std::vector<Index>> nodes;
  for (const std::string& name : sets) {
    if (is_nodeset(mesh, name)) continue;
    const Surface surface = surface_of_load(mesh, name);
    std::vector<Index> of_surface = surface_nodes(surface);
    for (const Index node : of_surface)
      if (model.row[node] < 0)
        throw InputError("loads: sideset '" + name + "' has a node that no volume element uses");
    if (std::all_of(of_surface.begin(), of_surface.end(),
                    [&](Index node) { return place[node] < 0; }))
      continue;
    loads.names.push_back(name);
    weights.push_back(face_weights(surface, mesh.coordinates));
    loads.areas.push_back(weights.back().sum());
    nodes.push_back(std::move(of_surface));
  }
  const auto m = static_cast<Index>(loads.names.size());
  loads.F_I = Matrix::Zero(3 * static_cast<Index>(p.interior_nodes.size()), 3 * m);
  loads.F_C = Matrix::Zero(3 * static_cast<Index>(p.interface_nodes.size()), 3 * m);
  for (Index j = 0; j < m; ++j)
    for (const Index node : nodes[j])
      for (int d = 0; d < 3; ++d) {
        const Index at = place[node];
        (at >= 0 ? loads.F_I(at + d, 3 * j + d) : loads.F_C(-1 - at + d, 3 * j + d)) =
            weights[j](node);
      }
  if (!p.has_fixed()) return loads;
  loads.F_I = Matrix(loads.F_I(p.interior_dofs, Eigen::all));
  loads.F_C = Matrix(loads.F_C(p.interface_dofs, Eigen::all));
  return loads;
}

Index add_residual_vectors(const Interior& interior, const Matrix& F_I,
                           FixedInterfaceModes& modes) {
  if (F_I.cols() == 0 || interior.p.n_interior() == 0) return 0;
  const Index k = modes.lambda.size();
  Matrix X = F_I;
  interior.solve_in_place(X);
  // F^T K_II^-1 F, diagonal
  const Vector energy = interior.sum(F_I.cwiseProduct(X).colwise().sum()).transpose();
  Matrix F = F_I;  // K_II X
  if (k > 0) {
    // X <- X - Phi (Phi^T M_II X) twice, so that round-off leaves nothing of the modes in it; K_II
    // X goes along by M_II Phi Lambda
    for (int pass = 0; pass < 2; ++pass) {
      const Matrix overlap = interior.inner(modes.Phi, interior.times_mass(X));
      X.noalias() -= modes.Phi * overlap;
      const Matrix W = modes.Phi * Matrix(modes.lambda.asDiagonal() * overlap);
      interior.add_mass(-W, F);
    }
  }
  const Vector scale = energy.unaryExpr([](double e) { return e > 0 ? 1 / std::sqrt(e) : 0.0; });
  X = X * scale.asDiagonal();
  Matrix K = interior.inner(X, F) * scale.asDiagonal();
  K = 0.5 * (K + K.transpose()).eval();
  // Independent directions in energy: K = U diag(e) U^T
  const SymmetricEigen independent = symmetric_eigen(K);
  std::vector<Index> kept;
  for (Index j = 0; j < K.cols(); ++j)
    if (independent.values(j) > round_off) kept.push_back(j);
  if (kept.empty()) return 0;
  const Vector root = Vector(independent.values(kept)).cwiseSqrt().cwiseInverse();
  const Matrix T = Matrix(independent.vectors(Eigen::all, kept)) * root.asDiagonal();
  X = X * T;  // X^T K_II X = I
  const Matrix M = interior.inner(X, interior.times_mass(X));
  const SymmetricEigen ritz = symmetric_eigen(M);
  const Vector mu = ritz.values.reverse();  // 1 / lambda, lambda ascending
  Matrix more = X * Matrix(ritz.vectors.rowwise().reverse()) *
                Matrix(mu.cwiseSqrt().cwiseInverse().asDiagonal());
  if (interior.own_nodes() == nullptr) fix_signs(more);
  const Index r = more.cols();
  modes.lambda.conservativeResize(k + r);
  modes.lambda.tail(r) = mu.cwiseInverse();
  modes.Phi.conservativeResize(Eigen::NoChange, k + r);
  modes.Phi.rightCols(r) = more;
  return r;
}

Index add_residual_vectors(const std::vector<ComponentPart>& parts, const Matrix& F_I,
                           FixedInterfaceModes& modes) {
  const std::vector<std::size_t> owner = owners(parts, modes.Phi);
  std::vector<FixedInterfaceModes> vectors(parts.size());
  const Index k = modes.lambda.size();
  for (std::size_t q = 0; q < parts.size(); ++q) {
    const ComponentPart& part = parts[q];
    const Matrix F = F_I(part.inside, Eigen::all);
    vectors[q].Phi.resize(F.rows(), 0);
    if (F.size() == 0 || F.cwiseAbs().maxCoeff() == 0) continue;
    std::vector<Index> kept;
    for (Index j = 0; j < k; ++j)
      if (owner[j] == q) kept.push_back(j);
    FixedInterfaceModes own;
    own.lambda = modes.lambda(kept);
    own.Phi = modes.Phi(part.inside, kept);
    const SparseCholesky factor(part.p.K_II);
    const Index r = add_residual_vectors(LocalInterior(part.p, factor), F, own);
    vectors[q].lambda = own.lambda.tail(r);
    vectors[q].Phi = own.Phi.rightCols(r);
  }
  const FixedInterfaceModes more = joined(parts, vectors, F_I.rows());
  const Index r = more.lambda.size();
  modes.lambda.conservativeResize(k + r);
  modes.Phi.conservativeResize(Eigen::NoChange, k + r);
  modes.lambda.tail(r) = more.lambda;
  modes.Phi.rightCols(r) = more.Phi;
  return r;
}

Matrix generalised_forces(const Interior& interior, const Matrix& F_I, const Matrix& F_C,
                          const Matrix& Phi) {
  const Partition& p = interior.p;
  Matrix X = F_I;
  interior.solve_in_place(X);
  Matrix Q(Phi.cols() + p.n_interface(), F_I.cols());
  Q << interior.inner(Phi, F_I), F_C - interior.sum(p.K_IC.transpose() * X);
  if (const RigidMotions& rigid = p.rigid; rigid.count() > 0) {
    // F_c <- F_c + G^T (R^T F - R_C^T F_c)
    auto F_c = Q.bottomRows(p.n_interface());
    const Matrix missing = interior.sum(SparseMatrix(rigid.R_I.transpose()) * F_I) +
                           SparseMatrix(rigid.R_C.transpose()) * Matrix(F_C - F_c);
    F_c += SparseMatrix(rigid.G.transpose()) * missing;
  }
  return Q;
}

std::map<std::string, Superelement::InteriorLoad> generalised_loads(const Interior& interior,
                                                                    const InteriorLoads& loads,
                                                                    const Matrix& Phi) {
  const Matrix Q = generalised_forces(interior, loads.F_I, loads.F_C, Phi);
  std::map<std::string, Superelement::InteriorLoad> result;
  for (std::size_t j = 0; j < loads.names.size(); ++j)
    result[loads.names[j]] = {loads.areas[j], Q.middleCols(3 * static_cast<Index>(j), 3)};
  return result;
}

Matrix unit_strains(const Points& X, const Vector3& center) {
  Matrix D = Matrix::Zero(3 * X.rows(), 6);
  for (Index i = 0; i < X.rows(); ++i) {
    const Vector3 x = X.row(i).transpose() - center;
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3, mixed = 3 + a;  // xy, yz, zx
      D(3 * i + a, a) = x[a];
      D(3 * i + a, mixed) = 0.5 * x[b];
      D(3 * i + b, mixed) = 0.5 * x[a];
    }
  }
  return D;
}

Matrix spin_moments(const Interior& interior, const Points& X_I, const Points& X_C,
                    const Vector3& center, const Matrix& Phi) {
  const Partition& p = interior.p;
  Matrix D_I = unit_strains(X_I, center), D_C = unit_strains(X_C, center);
  // Rotations of shells move their mid-surface not at all
  D_I.bottomRows(3 * p.interior_rotations).setZero();
  D_C.bottomRows(3 * p.interface_rotations).setZero();
  Matrix F_I = interior.times_mass(D_I);
  F_I.noalias() += p.M_IC * D_C;
  const Matrix F_C = interior.sum(p.M_CC * D_C + p.M_IC.transpose() * D_I);
  return generalised_forces(interior, F_I, F_C, Phi);
}

namespace {

// P(3 i + a, 3 j + b) += sum over the nodes of X(., i)^a Y(., j)^b
void add_node_products(const Matrix& X, const Matrix& Y, Matrix& P) {
  using Eigen::all, Eigen::last, Eigen::seq;
  if (X.rows() == 0) return;
  for (Index a = 0; a < 3; ++a) {
    const Matrix X_a = X(seq(a, last, 3), all);
    for (Index b = 0; b < 3; ++b)
      P(seq(a, last, 3), seq(b, last, 3)) += X_a.transpose() * Matrix(Y(seq(b, last, 3), all));
  }
}

}  // namespace

Matrix spin_couplings(const Interior& interior, const Matrix& Phi, const Matrix& V) {
  const Partition& p = interior.p;
  Matrix X_C = V.bottomRows(p.n_interface());
  Matrix X_I = p.K_IC * X_C;
  interior.solve_in_place(X_I);
  X_I = Phi * V.topRows(Phi.cols()) - X_I;
  // As above; masses of translations are the same in x, y and z, and mix none of them
  X_I.bottomRows(3 * p.interior_rotations).setZero();
  X_C.bottomRows(3 * p.interface_rotations).setZero();
  Matrix P = Matrix::Zero(3 * V.cols(), 3 * V.cols());
  Matrix Y_I = interior.times_mass(X_I);
  Y_I.noalias() += p.M_IC * X_C;
  add_node_products(X_I, Y_I, P);
  add_node_products(X_C, p.M_CC * X_C + p.M_IC.transpose() * X_I, P);
  P = interior.sum(std::move(P));
  return 0.5 * (P + P.transpose());
}

}  // namespace cbr
