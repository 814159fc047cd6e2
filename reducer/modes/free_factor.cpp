// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/modes/free_factor.hpp"

#include <utility>
#include <vector>

#include "common/fem/assembly.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/sparse/symbolic_factor.hpp"
#include "reducer/condensation/superelement_algebra.hpp"

namespace cbr {
namespace {

// About the middle of all nodes and of their size, N^T M N = 1   (N x 6)
Matrix rigid_motions_of(const FreeComponent& model) {
  const Eigen::RowVector3d middle = model.x.colwise().mean();
  const double size = (model.x.rowwise() - middle).rowwise().norm().maxCoeff();
  Matrix N = rigid_modes(model.x, middle.transpose(), model.n_rotations);
  if (size > 0) N.rightCols(3) /= size;
  orthonormalise([&](const Matrix& X) { return Matrix(model.M * X); }, N, "the rigid motions");
  return N;
}

// Springs at six dofs of the interface constrain the rigid motions, on the diagonal of K, for the
// life of the object. A load in equilibrium strains no spring, so that K with springs gives a
// response of K.
class Springs {
 public:
  Springs(SparseMatrix& K, const Matrix& N, const std::vector<Index>& interface) : K_(K) {
    const PivotedQr qr(N(interface, Eigen::all).transpose());
    for (Index i = 0; i < N.cols(); ++i) {
      const Index dof = interface[qr.column(i)];
      before_.emplace_back(dof, K.coeff(dof, dof));
      K_.coeffRef(dof, dof) *= 2;
    }
  }
  ~Springs() {
    for (const auto& [dof, value] : before_) K_.coeffRef(dof, dof) = value;
  }
  Springs(const Springs&) = delete;
  Springs& operator=(const Springs&) = delete;

 private:
  SparseMatrix& K_;
  std::vector<std::pair<Index, double>> before_;
};

// Of c interface dofs: flops to eliminate them last, c^3 / 3 for themselves and more than twice
// that for their rows in the interior's columns (measured: faces of solids).
constexpr double flops_of_interface = 1.1;
// Share of a factor that a solve visits between forces on the interface and motions of it, both
// ways.
constexpr double visited = 0.8;

}  // namespace

FreeFactorCost free_factor_cost(const FactorCost& interior, double n_ratio, Index n_interface,
                                Index n_forces) {
  const auto c = static_cast<double>(n_interface), forces = static_cast<double>(n_forces);
  const FreeFactorCost one{interior.flops + flops_of_interface * c * c * c, 2 * c * c * forces,
                           true};
  const FreeFactorCost two{(1 + n_ratio) * interior.flops,
                           4 * visited * n_ratio * interior.n_nonzeros * forces, false};
  return one.all_flops() <= two.all_flops() ? one : two;
}

FreeFactor free_factor(const FreeComponent& model, const Partition& p, Index n_forces,
                       const Progress& progress) {
  Matrix N = rigid_motions_of(model);
  Matrix P = model.M * N;
  const std::vector<Index>& interface = p.interface_rows;
  const FactorCost interior = factor_cost(node_graph(p.K_II, 3, {}), 3);
  const double n_ratio = static_cast<double>(model.K.rows()) / static_cast<double>(p.n_interior());
  const bool last = free_factor_cost(interior, n_ratio, p.n_interface(), n_forces).is_one_factor;
  const Springs springs(model.K, N, interface);
  const std::vector<Index> none;
  FreeFactor made{
      std::move(N),
      std::move(P),
      SparseCholesky(model.K, last ? interface : none, progress, last ? interior.order : none),
      {}};
  if (last) made.interior = made.whole.leading();
  return made;
}

}  // namespace cbr
