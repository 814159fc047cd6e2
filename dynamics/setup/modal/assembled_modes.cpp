// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/modal/assembled_modes.hpp"

#include <algorithm>
#include <limits>
#include <string>

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

using Triplets = std::vector<Eigen::Triplet<double, Index>>;

struct Part {
  const BodyModes* body = nullptr;
  Index first = 0, size = 0;
  const MeshModes* mesh = nullptr;                 // in all of its dofs; null: modal coordinates
  std::shared_ptr<const SparseCholesky> factor{};  // of the mesh: Z^T (K - sigma M) Z
};

class Assembled {
 public:
  Assembled(const ModalScene& scene, const std::vector<Index>& bodies, Index most_rows)
      : scene_(scene), bodies_(bodies) {
    take_parts();
    take_rows(most_rows);
    factor();
  }

  AssembledModes modes(Index count) {
    BlockLanczosOptions options;
    const Eigenpairs pairs = block_lanczos(
        M_.rows(), product_with(M_), [&](Eigen::Ref<Matrix> B) { solve(B); }, sigma_, count,
        options);
    if (!pairs.converged)
      throw RunError("the frequencies of the joined instances did not converge");
    AssembledModes modes;
    modes.lambda = energies(pairs);
    for (const Part& part : parts_) {
      const Matrix x = pairs.Phi.middleRows(part.first, part.size);
      modes.shapes.push_back(part.mesh != nullptr ? Matrix(part.mesh->Z * x) : x);
    }
    modes.c = damping(pairs, modes.lambda);
    return modes;
  }

 private:
  void take_parts() {
    Index n = 0;
    Triplets mass;
    double lowest = std::numeric_limits<double>::infinity(), far = 0;
    for (const Index b : bodies_) {
      const BodyModes& body = scene_.bodies[b];
      Part part{&body, n, body.omega().size(), nullptr};
      if (body.mesh() != nullptr && !body.mesh()->is_complete()) {
        part.mesh = body.mesh();
        part.size = part.mesh->K.rows();
        far = std::max(far, -part.mesh->sigma());
        for (Index j = 0; j < part.size; ++j)
          for (SparseMatrix::InnerIterator it(part.mesh->M, j); it; ++it)
            mass.emplace_back(n + it.row(), n + j, it.value());
      } else {
        for (Index j = 0; j < part.size; ++j) mass.emplace_back(n + j, n + j, 1.0);
      }
      for (const double omega : body.omega())
        if (omega > 0) lowest = std::min(lowest, omega * omega);
      n += part.size;
      parts_.push_back(part);
    }
    lowest_ = std::isfinite(lowest) ? lowest : far;
    sigma_ = -shift_share * lowest_;
    M_.resize(n, n);
    M_.setFromTriplets(mass.begin(), mass.end());
  }

  void take_rows(Index most_rows) {
    std::vector<const TieRow*> ties;
    for (const TieRow& tie : scene_.ties)
      if (std::find(bodies_.begin(), bodies_.end(), tie.of_bodies.front().first) != bodies_.end())
        ties.push_back(&tie);
    const auto m = static_cast<Index>(ties.size());
    for (Index t = 0; t < m; ++t)
      if (!ties[t]->is_dashpot) stiff_.push_back(t);
    if (m > most_rows)
      throw InputError(scene_.scene.file.string() + ": instance '" +
                       scene_.built.instances[bodies_.front()].name +
                       "' and what is joined to it have " + std::to_string(m) +
                       " conditions of ties and links, and --modes takes at most " +
                       std::to_string(most_rows) +
                       " between meshes: use as: superelement, or tie coarser surfaces");
    S_ = S_bodies_ = Matrix::Zero(m, m);
    Triplets entries;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      std::vector<NodalSum> sums;
      std::vector<Index> rows;
      for (Index t = 0; t < m; ++t)
        for (const auto& [of, sum] : ties[t]->of_bodies)
          if (of == bodies_[i]) {
            sums.push_back(sum);
            rows.push_back(t);
          }
      if (!sums.empty()) add_part(parts_[i], sums, rows, entries);
    }
    A_.resize(m, M_.rows());
    A_.setFromTriplets(entries.begin(), entries.end());
  }

  void add_part(const Part& part, const std::vector<NodalSum>& sums, const std::vector<Index>& rows,
                Triplets& entries) {
    if (part.mesh != nullptr) {
      const SparseMatrix A = part.body->mesh_rows(sums) * part.mesh->Z;
      for (Index j = 0; j < A.cols(); ++j)
        for (SparseMatrix::InnerIterator it(A, j); it; ++it)
          entries.emplace_back(rows[it.row()], part.first + j, it.value());
      return;
    }
    const ModalAnswer answer = part.body->answer(sums);
    for (Index j = 0; j < answer.A.cols(); ++j)
      for (Index i = 0; i < answer.A.rows(); ++i)
        if (answer.A(i, j) != 0) entries.emplace_back(rows[i], part.first + j, answer.A(i, j));
    if (!answer.S.empty()) {
      S_(rows, rows) += answer.S.front();
      if (!part.body->is_joint()) S_bodies_(rows, rows) += answer.S.front();
    }
    if (answer.B.size() > 0 && !answer.C.isZero(0)) dashpots_.push_back({rows, answer.B, answer.C});
  }

  void factor() {
    for (Part& part : parts_) {
      if (part.mesh == nullptr) continue;
      part.factor =
          std::make_shared<SparseCholesky>(SparseMatrix(part.mesh->K - sigma_ * part.mesh->M));
      if (!part.factor->ok()) throw RunError(no_factor);
    }
    // W = A D^-1 A^T + S   (m x m)
    const SparseMatrix At = A_.transpose();
    Matrix W = S_;
    for (Index j = 0; j < W.cols(); j += columns_at_a_time) {
      const Index q = std::min(columns_at_a_time, static_cast<Index>(W.cols()) - j);
      Matrix X = At.middleCols(j, q);
      solve_apart(X);
      W.middleCols(j, q) += A_ * X;
    }
    const Matrix of_stiff = W(stiff_, stiff_);
    kept_.clear();
    for (const Index row : independent_rows(of_stiff)) kept_.push_back(stiff_[row]);
    Matrix kept = W(kept_, kept_);
    W_ = std::make_unique<Cholesky>(Matrix(0.5 * (kept + kept.transpose())));
    if (!W_->ok()) throw RunError("the ties of the joined instances contradict each other");
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
        rows.array().colwise() /= part.body->omega().array().square() - sigma_;
      }
    }
  }

  // -W^-1 A y: tie forces of kept rows, 0 in others   (m x columns)
  Matrix carried(const Matrix& y) const {
    const Matrix gaps = A_ * y;
    Matrix p = -gaps(kept_, Eigen::all);
    W_->solve_in_place(p);
    Matrix all = Matrix::Zero(A_.rows(), y.cols());
    all(kept_, Eigen::all) = p;
    return all;
  }

  // B <- (K - sigma M)^-1 B
  void solve(Eigen::Ref<Matrix> B) const {
    solve_apart(B);
    if (kept_.empty()) return;
    Matrix by_ties = A_.transpose() * carried(B);
    solve_apart(by_ties);
    B += by_ties;
  }

  // Of each mode, m x modes: Phi = (lambda - sigma) (y + D^-1 A^T p)
  Matrix tie_forces(const Eigenpairs& pairs) const {
    Matrix y = M_ * pairs.Phi;
    solve_apart(y);
    return carried(y) * Vector(pairs.lambda.array() - sigma_).asDiagonal();
  }

  // phi . K phi by the parts and ties: pairs.lambda has the round-off of the shift, and its shapes
  // have it in their strains. 0 within that and the round-off of the sum.
  Vector energies(const Eigenpairs& pairs) const {
    const Matrix p = tie_forces(pairs);
    Vector energy = p.cwiseProduct(S_ * p).colwise().sum().transpose();
    Vector least = Vector::Constant(energy.size(), energy_round_off * lowest_);
    for (const Part& part : parts_) {
      const Matrix x = pairs.Phi.middleRows(part.first, part.size);
      if (part.mesh == nullptr) {
        energy += x.cwiseAbs2().transpose() * part.body->omega().cwiseAbs2();
        continue;
      }
      energy += x.cwiseProduct(part.mesh->K * x).colwise().sum().transpose();
      least += round_off_of_energy(part.mesh->K, x);
    }
    return (energy.array() > least.array()).select(energy, 0);
  }

  Vector damping(const Eigenpairs& pairs, const Vector& lambda) const {
    const Vector omega = lambda.cwiseMax(0).cwiseSqrt();
    Vector c = Vector::Zero(omega.size());
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const Matrix x = pairs.Phi.middleRows(parts_[i].first, parts_[i].size);
      if (parts_[i].mesh == nullptr) {
        c += x.cwiseAbs2().transpose() * parts_[i].body->damping_rates();
        continue;
      }
      const auto& of = scene_.built.instances[bodies_[i]];
      c += of_mesh(of.damping, *parts_[i].mesh, x, omega);
    }
    if (dashpots_.empty()) return c;
    const Matrix y = A_ * pairs.Phi + S_bodies_ * tie_forces(pairs);
    for (const Dashpots& of : dashpots_) {
      const Matrix r = of.B.transpose() * y(of.rows, Eigen::all);
      c += r.cwiseProduct(of.C * r).colwise().sum().transpose();
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
  std::vector<Part> parts_;
  double lowest_ = 0, sigma_ = 0;
  SparseMatrix M_, A_;
  Matrix S_, S_bodies_;
  std::vector<Index> stiff_, kept_;
  std::vector<Dashpots> dashpots_;
  std::unique_ptr<Cholesky> W_;
};

}  // namespace

bool needs_assembly(const ModalScene& scene, const std::vector<Index>& bodies) {
  const auto is_in = [&](Index b) {
    return std::find(bodies.begin(), bodies.end(), b) != bodies.end();
  };
  const bool is_joined = std::any_of(scene.ties.begin(), scene.ties.end(), [&](const TieRow& tie) {
    return is_in(tie.of_bodies.front().first);
  });
  return is_joined && std::any_of(bodies.begin(), bodies.end(), [&](Index b) {
           const MeshModes* mesh = scene.bodies[b].mesh();
           return mesh != nullptr && !mesh->is_complete();
         });
}

AssembledModes assembled_modes(const ModalScene& scene, const std::vector<Index>& bodies,
                               Index count, Index most_rows) {
  return Assembled(scene, bodies, most_rows).modes(count);
}

}  // namespace cbr
