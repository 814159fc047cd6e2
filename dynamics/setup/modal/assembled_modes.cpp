// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/modal/scene_modes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/block_lanczos.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"

namespace cbr {
namespace {

// Shift, relative to the lowest elastic eigenvalue of the parts. Near enough for fast convergence,
// and far enough that rigid motions do not hide the compliance of ties.
constexpr double shift_share = 0.1;
// Columns of A^T solved together.
constexpr Index columns_at_a_time = 64;
// Of tie_slack, tenfold until W has a factor.
constexpr double most_slack = 1e-6;
// Modes beyond those requested, among which a gap is found to count the modes below it.
constexpr Index spare = 4;
// Of that gap, relative to the distance from the shift; and the slack for the count.
constexpr double least_gap = 1e-7, count_slack = 1e-9;
// Compliance of ties below this fraction of the softest mode's is neglected: the tie then
// constrains the modes.
constexpr double no_compliance = 1e-9;
// If all parts are rigid and have no elastic frequency: relative to the softest tie, and of an
// eigenvalue to the highest one.
constexpr double round_off = 1e-14;

constexpr const char* no_convergence = "the frequencies of the joined instances did not converge";

using Triplets = std::vector<Eigen::Triplet<double, Index>>;

struct Part {
  const BodyModes* body = nullptr;
  Index first = 0, size = 0;
  const MeshModes* mesh = nullptr;                 // in all of its dofs; null: modal coordinates
  std::shared_ptr<const SparseCholesky> factor{};  // of the mesh: Z^T (K - sigma M) Z
  std::vector<Index> rows{};                       // of ties, ascending
  Matrix A{};                                      // rows x size, of modal coordinates
  SparseMatrix mesh_A{};                           // of a mesh
  Matrix S{};                                      // rows x rows, or none

  Vector lambda() const { return body->omega().cwiseAbs2(); }
  Matrix gaps(const Matrix& x) const {
    return mesh != nullptr ? Matrix(mesh_A * x) : Matrix(A * x);
  }
  Matrix forces(const Matrix& p) const {
    return mesh != nullptr ? Matrix(mesh_A.transpose() * p) : Matrix(A.transpose() * p);
  }
};

// Of p, forces of ties (m x modes).
struct Solution {
  Vector lambda;
  Matrix Phi, p;
};

double lowest_above(const Vector& lambda, double limit) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const double l : lambda)
    if (l > limit) lowest = std::min(lowest, l);
  return lowest;
}

class Assembled {
 public:
  Assembled(const ModalScene& scene, const std::vector<Index>& bodies, Index most_rows,
            const Progress& progress)
      : scene_(scene), bodies_(bodies), progress_(progress) {
    take_parts();
    take_rows(most_rows);
  }

  AssembledModes modes(Index count, JoinedBy by) {
    if (by == JoinedBy::size)
      by = has_meshes_ || (sigma_ < 0 && !takes_all_modes(n_, count)) ? JoinedBy::lanczos
                                                                      : JoinedBy::dense;
    std::optional<Solution> found;
    if (by == JoinedBy::lanczos) found = by_lanczos(count);
    if (!found && has_meshes_) throw RunError(no_convergence);
    if (!found) found = all_modes(count);
    AssembledModes modes{found->lambda, damping(*found), {}};
    for (const Part& part : parts_) {
      const Matrix x = found->Phi.middleRows(part.first, part.size);
      modes.shapes.push_back(part.mesh != nullptr ? Matrix(part.mesh->Z * x) : x);
    }
    return modes;
  }

 private:
  void take_parts() {
    Triplets mass;
    double lowest = std::numeric_limits<double>::infinity(), far = 0;
    for (const Index b : bodies_) {
      const BodyModes& body = scene_.bodies[b];
      Part part{&body, n_, body.omega().size()};
      if (body.mesh() != nullptr && !body.mesh()->is_complete()) {
        has_meshes_ = true;
        part.mesh = body.mesh();
        part.size = part.mesh->K.rows();
        far = std::max(far, -part.mesh->sigma());
        for (Index j = 0; j < part.size; ++j)
          for (SparseMatrix::InnerIterator it(part.mesh->M, j); it; ++it)
            mass.emplace_back(n_ + it.row(), n_ + j, it.value());
      } else {
        for (Index j = 0; j < part.size; ++j) mass.emplace_back(n_ + j, n_ + j, 1.0);
      }
      lowest = std::min(lowest, lowest_above(part.lambda(), 0));
      n_ += part.size;
      parts_.push_back(part);
    }
    lowest_ = std::isfinite(lowest) ? lowest : far;
    sigma_ = -shift_share * lowest_;
    M_.resize(n_, n_);
    M_.setFromTriplets(mass.begin(), mass.end());
  }

  // Rows of dashpots, which have no force, come last.
  void take_rows(Index most_rows) {
    std::vector<Index> place(scene_.bodies.size(), -1);
    for (std::size_t i = 0; i < bodies_.size(); ++i) place[bodies_[i]] = static_cast<Index>(i);
    std::vector<std::vector<NodalSum>> sums(parts_.size());
    for (const bool is_dashpot : {false, true}) {
      for (const TieRow& tie : scene_.ties) {
        if (place[tie.of_bodies.front().first] < 0 || tie.is_dashpot != is_dashpot) continue;
        for (const auto& [body, sum] : tie.of_bodies) {
          sums[place[body]].push_back(sum);
          parts_[place[body]].rows.push_back(m_);
        }
        ++m_;
      }
      if (!is_dashpot) n_stiff_ = m_;
    }
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const auto n_rows = static_cast<Index>(sums[i].size());
      if (parts_[i].mesh != nullptr && n_rows > most_rows)
        throw InputError(scene_.scene.file.string() + ": instance '" +
                         scene_.built.instances[bodies_[i]].name + "' has " +
                         std::to_string(n_rows) +
                         " conditions of ties and links, and --modes takes at most " +
                         std::to_string(most_rows) +
                         " of a mesh: use as: superelement, or tie coarser surfaces");
      if (n_rows > 0) join(parts_[i], sums[i]);
    }
  }

  void join(Part& part, const std::vector<NodalSum>& sums) {
    if (part.mesh != nullptr) {
      part.mesh_A = part.body->mesh_rows(sums) * part.mesh->Z;
      return;
    }
    ModalAnswer answer = part.body->answer(sums);
    part.A = std::move(answer.A);
    if (!answer.S.empty()) part.S = std::move(answer.S.front());
    if (answer.B.size() > 0 && !answer.C.isZero(0))
      dashpots_.push_back({part.rows, answer.B, answer.C});
  }

  void factor() {
    for (Part& part : parts_) {
      if (part.mesh == nullptr) continue;
      part.factor =
          std::make_shared<SparseCholesky>(SparseMatrix(part.mesh->K - sigma_ * part.mesh->M));
      if (!part.factor->ok()) throw RunError(no_factor);
    }
    W_ = compliance(sigma_, half_of_progress(0));
    for (double slack = tie_slack; slack <= most_slack; slack *= 10) {
      W_factor_ = std::make_unique<SparseCholesky>(with_slack(W_, slack));
      if (W_factor_->ok()) return;
    }
    throw RunError("the ties of the joined instances contradict each other");
  }

  Progress half_of_progress(double first) const {
    if (!progress_) return {};
    return [this, first](double share) { progress_(first + 0.5 * share); };
  }

  // The lower triangle of W = A D^-1 A^T + S, D = K - shift M, of rows with a force. Each part has
  // a dense block; those of meshes are at the shift of their factor.
  SparseMatrix compliance(double shift, const Progress& progress = {}) const {
    Triplets lower;
    double done = 0, all = 0;
    for (const Part& part : parts_) all += static_cast<double>(part.rows.size());
    for (const Part& part : parts_) {
      const Matrix W = compliance(part, shift, [&](Index columns) {
        done += static_cast<double>(columns);
        if (progress) progress(done / all);
      });
      for (Index j = 0; j < W.cols(); ++j)
        for (Index i = j; i < W.rows() && part.rows[i] < n_stiff_; ++i)
          lower.emplace_back(part.rows[i], part.rows[j], W(i, j));
    }
    for (Index t = 0; t < n_stiff_; ++t) lower.emplace_back(t, t, 0.0);
    SparseMatrix W(n_stiff_, n_stiff_);
    W.setFromTriplets(lower.begin(), lower.end());
    return W;
  }

  static Matrix compliance(const Part& part, double shift,
                           const std::function<void(Index)>& on_columns) {
    const auto m = static_cast<Index>(part.rows.size());
    Matrix W = part.S.size() > 0 ? part.S : Matrix(Matrix::Zero(m, m));
    if (m == 0) return W;
    if (part.mesh == nullptr) {
      const Vector weight = (part.lambda().array() - shift).inverse();
      W += Matrix(part.A * weight.asDiagonal()) * part.A.transpose();
      on_columns(m);
      return W;
    }
    const SparseMatrix At = part.mesh_A.transpose();
    for (Index j = 0; j < m; j += columns_at_a_time) {
      const Index q = std::min(columns_at_a_time, m - j);
      Matrix X = At.middleCols(j, q);
      part.factor->solve_in_place(X);
      W.middleCols(j, q) += part.mesh_A * X;
      on_columns(q);
    }
    return W;
  }

  static SparseMatrix with_slack(SparseMatrix W, double slack) {
    for (Index t = 0; t < W.cols(); ++t) {
      double& own = W.coeffRef(t, t);
      own += own != 0 ? slack * std::abs(own) : 1;
    }
    return W;
  }

  // B <- D^-1 B
  void solve_apart(Eigen::Ref<Matrix> B) const {
    for (const Part& part : parts_) {
      auto rows = B.middleRows(part.first, part.size);
      if (part.mesh != nullptr) {
        Matrix X = rows;
        part.factor->solve_in_place(X);
        rows = X;
      } else {
        rows.array().colwise() /= part.lambda().array() - sigma_;
      }
    }
  }

  // A x   (m x columns)
  Matrix gaps(const Matrix& x) const {
    Matrix all = Matrix::Zero(m_, x.cols());
    for (const Part& part : parts_)
      if (!part.rows.empty())
        all(part.rows, Eigen::all) += part.gaps(x.middleRows(part.first, part.size));
    return all;
  }

  // p of W p = -A y: tie forces, 0 of dashpots   (m x columns)
  Matrix carried(const Matrix& y) const {
    Matrix p = Matrix::Zero(m_, y.cols());
    if (n_stiff_ == 0) return p;
    const Matrix right = -gaps(y).topRows(n_stiff_);
    Matrix of_stiff = Matrix::Zero(n_stiff_, y.cols());
    for (int i = 0; i < tie_refinements; ++i) {
      Matrix left = right - W_.selfadjointView<Eigen::Lower>() * of_stiff;
      W_factor_->solve_in_place(left);
      of_stiff += left;
    }
    p.topRows(n_stiff_) = of_stiff;
    return p;
  }

  // B <- (K - sigma M)^-1 B
  void solve(Eigen::Ref<Matrix> B) const {
    solve_apart(B);
    const Matrix p = carried(B);
    Matrix by_ties = Matrix::Zero(B.rows(), B.cols());
    for (const Part& part : parts_)
      if (!part.rows.empty())
        by_ties.middleRows(part.first, part.size) = part.forces(p(part.rows, Eigen::all));
    solve_apart(by_ties);
    B += by_ties;
  }

  // Nothing: no convergence, or, without meshes, a mode is missing.
  std::optional<Solution> by_lanczos(Index count) {
    factor();
    BlockLanczosOptions options;
    options.progress = half_of_progress(0.5);
    const Eigenpairs pairs = block_lanczos(
        n_, product_with(M_), [&](Eigen::Ref<Matrix> B) { solve(B); }, sigma_,
        has_meshes_ ? count : count + spare, options);
    if (!pairs.converged || (!has_meshes_ && is_mode_missing(pairs.lambda))) return {};
    Solution found{{}, pairs.Phi.leftCols(count), {}};
    // Phi = (lambda - sigma) (y + D^-1 A^T p)
    Matrix y = M_ * found.Phi;
    solve_apart(y);
    found.p = carried(y) * Vector(pairs.lambda.head(count).array() - sigma_).asDiagonal();
    found.lambda = energies(found);
    return found;
  }

  // Many equal eigenvalues, as of mechanisms, may be more than the Krylov space has. By Sylvester
  // those below s are the negative ones of D(s) less those of W(s).
  bool is_mode_missing(const Vector& lambda) const {
    Index below = lambda.size() - spare;
    for (Index j = below; j < lambda.size(); ++j)
      if (lambda[j] - lambda[j - 1] > lambda[below] - lambda[below - 1]) below = j;
    const double s = 0.5 * (lambda[below] + lambda[below - 1]);
    if (lambda[below] - s < least_gap * (s - sigma_)) return false;
    Index n_below = 0;
    for (const Part& part : parts_) n_below += (part.lambda().array() < s).count();
    const SparseMatrix W = with_slack(compliance(s), count_slack);
    const Index negative = negative_inertia(SparseMatrix(W.selfadjointView<Eigen::Lower>()));
    return negative >= 0 && n_below - negative != below;
  }

  // phi . K phi by the parts and ties: lambda of Lanczos has the round-off of the shift, and its
  // shapes have it in their strains. 0 within that and the round-off of the sum.
  Vector energies(const Solution& of) const {
    Vector energy = Vector::Zero(of.Phi.cols());
    Vector least = Vector::Constant(energy.size(), energy_round_off * lowest_);
    for (const Part& part : parts_) {
      const Matrix x = of.Phi.middleRows(part.first, part.size);
      energy += residual_energy(part, of);
      if (part.mesh == nullptr) {
        energy += x.cwiseAbs2().transpose() * part.lambda();
        continue;
      }
      energy += x.cwiseProduct(part.mesh->K * x).colwise().sum().transpose();
      least += round_off_of_energy(part.mesh->K, x);
    }
    return (energy.array() > least.array()).select(energy, 0);
  }

  // All modes in dense matrices. Ties with compliance are springs, p = -S^-1 A x; others are
  // constraints, A x = 0.
  Solution all_modes(Index count) const {
    Vector lambda(n_);
    Matrix A_all = Matrix::Zero(m_, n_), S_all = Matrix::Zero(m_, m_);
    for (const Part& part : parts_) {
      lambda.segment(part.first, part.size) = part.lambda();
      if (!part.rows.empty()) A_all(part.rows, Eigen::seqN(part.first, part.size)) = part.A;
      if (part.S.size() > 0) S_all(part.rows, part.rows) += part.S;
    }
    const double lowest = lowest_above(lambda, 0);
    const bool is_elastic = std::isfinite(lowest);
    const SymmetricEigen compliance = symmetric_eigen(S_all.topLeftCorner(n_stiff_, n_stiff_));
    const Matrix A = compliance.vectors.transpose() * A_all.topRows(n_stiff_);
    const double soft = is_elastic     ? no_compliance * A.squaredNorm() / lowest
                        : A.rows() > 0 ? round_off * compliance.values.maxCoeff()
                                       : 0;
    std::vector<Index> held, springs;
    for (Index i = 0; i < A.rows(); ++i)
      if (compliance.values[i] > soft)
        springs.push_back(i);
      else if (A.row(i).norm() > 1e-10 * A.norm())  // else redundant
        held.push_back(i);
    Matrix K = lambda.asDiagonal();
    const Vector stiffness = Vector(compliance.values(springs)).cwiseInverse();
    const Matrix B = A(springs, Eigen::all);
    if (!springs.empty()) K += B.transpose() * stiffness.asDiagonal() * B;
    Matrix Z = Matrix::Identity(n_, n_);
    if (!held.empty()) Z = null_space(A(held, Eigen::all), 1e-10);
    const SymmetricEigen pairs = generalized_eigen(Z.transpose() * K * Z, Z.transpose() * Z);
    if (!pairs.converged) throw RunError(no_convergence);
    count = std::min(count, static_cast<Index>(pairs.values.size()));
    // By the parts: K has the round-off of its highest frequency
    const auto energies = [&](const Matrix& X) {
      const Matrix stretch = B * X;
      return Matrix(X.transpose() * lambda.asDiagonal() * X +
                    stretch.transpose() * stiffness.asDiagonal() * stretch);
    };
    // So the shapes up to the lowest elastic frequency of the parts are found again among
    // themselves
    const double highest = pairs.values.size() > 0 ? pairs.values.maxCoeff() : 0,
                 next = is_elastic ? lowest : lowest_above(pairs.values, round_off * highest);
    const Index n_low = (pairs.values.array() <= next).count();
    Matrix shapes = Z * pairs.vectors;
    shapes.leftCols(n_low) *= symmetric_eigen(energies(shapes.leftCols(n_low))).vectors;
    Solution found;
    found.Phi = shapes.leftCols(count);
    found.lambda = energies(found.Phi).diagonal();
    // Round-off among these, and of what the others leave in them
    const double left = energy_round_off * highest,
                 least = energy_round_off * next + left * left / next;
    found.lambda = (found.lambda.array() > least).select(found.lambda, 0);
    found.p = Matrix::Zero(m_, count);
    if (!springs.empty())
      found.p.topRows(n_stiff_) =
          -compliance.vectors(Eigen::all, springs) * (stiffness.asDiagonal() * (B * found.Phi));
    return found;
  }

  // Energy of residual compliance and springs of a part in each mode.
  static Vector residual_energy(const Part& part, const Solution& of) {
    if (part.S.size() == 0) return Vector::Zero(of.Phi.cols());
    const Matrix p = of.p(part.rows, Eigen::all);
    return p.cwiseProduct(part.S * p).colwise().sum().transpose();
  }

  // phi . C phi of each mode: its own damping and dashpots.
  Vector damping(const Solution& of) const {
    const Vector omega = of.lambda.cwiseMax(0).cwiseSqrt();
    Vector c = Vector::Zero(omega.size());
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const Part& part = parts_[i];
      if (part.body->is_joint()) continue;  // a dashpot, below
      const Damping& own = scene_.built.instances[bodies_[i]].damping;
      const Matrix x = of.Phi.middleRows(part.first, part.size);
      c += part.mesh != nullptr ? of_mesh(own, *part.mesh, x, omega)
                                : Vector(x.cwiseAbs2().transpose() * part.body->damping_rates());
      c += own.material.beta * residual_energy(part, of);
    }
    if (dashpots_.empty()) return c;
    // Without joints a row is A x + S p
    Matrix y = gaps(of.Phi);
    for (const Part& part : parts_)
      if (part.S.size() > 0 && !part.body->is_joint())
        y(part.rows, Eigen::all) += part.S * of.p(part.rows, Eigen::all);
    for (const Dashpots& dashpots : dashpots_) {
      const Matrix r = dashpots.B.transpose() * y(dashpots.rows, Eigen::all);
      c += r.cwiseProduct(dashpots.C * r).colwise().sum().transpose();
    }
    return c;
  }

  // alpha and beta by mass and stiffness, ratios and loss factors by the mesh's part of the strain
  // energy.
  static Vector of_mesh(const Damping& damping, const MeshModes& mesh, const Matrix& x,
                        const Vector& omega) {
    if (damping.none()) return Vector::Zero(omega.size());
    const Vector mass = x.cwiseProduct(mesh.M * x).colwise().sum().transpose(),
                 stiffness = x.cwiseProduct(mesh.K * x).colwise().sum().transpose();
    const Vector rates = damping.rates(omega).c;
    const double alpha = damping.material.alpha, beta = damping.material.beta;
    Vector c = alpha * mass + beta * stiffness;
    for (Index j = 0; j < omega.size(); ++j)
      if (omega[j] > 0)
        c[j] += (rates[j] / (omega[j] * omega[j]) - alpha / (omega[j] * omega[j]) - beta) *
                stiffness[j];
    return c;
  }

  const ModalScene& scene_;
  const std::vector<Index>& bodies_;
  Progress progress_;
  std::vector<Part> parts_;
  Index n_ = 0, m_ = 0, n_stiff_ = 0;  // coordinates; rows of ties; those with a force come first
  bool has_meshes_ = false;            // in all of their dofs
  double lowest_ = 0, sigma_ = 0;
  SparseMatrix M_, W_;
  std::vector<Dashpots> dashpots_;
  std::unique_ptr<SparseCholesky> W_factor_;
};

}  // namespace

AssembledModes assembled_modes(const ModalScene& scene, const std::vector<Index>& bodies,
                               Index count, const Progress& progress, JoinedBy by,
                               Index most_rows) {
  return Assembled(scene, bodies, most_rows, progress).modes(count, by);
}

}  // namespace cbr
