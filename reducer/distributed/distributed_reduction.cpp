// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/distributed/distributed_reduction.hpp"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/scene/scene_words.hpp"
#include "reducer/bases/characteristic/characteristic.hpp"
#include "reducer/bases/reduction_steps.hpp"
#include "reducer/condensation/residual_mass.hpp"
#include "reducer/distributed/distributed_interior.hpp"
#include "reducer/distributed/distributed_partition.hpp"
#include "reducer/distributed/processes.hpp"
#include "reducer/judgement/accuracy.hpp"
#include "reducer/judgement/condition_numbers.hpp"
#include "reducer/judgement/mode_tolerance.hpp"
#include "reducer/modes/diagonal_form.hpp"
#include "reducer/modes/spin_moments.hpp"

namespace cbr {
namespace {

// two eigenvalues closer than this are one multiple one to a count
constexpr double relative_gap = 1e-7;

int own_rank() {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

class DistributedReduction {
 public:
  DistributedReduction(Reduction& reduction, const std::vector<BlockProperties>& properties,
                       MassKind mass)
      : r_(reduction), properties_(properties), mass_(mass), rank_(own_rank()) {}

  Superelement run() {
    assemble_own();
    if (rank_ == 0) describe_interface(r_, s_);
    s_.basis = word_of(basis_words, r_.options.basis);
    factorise();
    for (Index ncv = 0;; ncv = std::min(interior_.rows.n, 3 * modes_.lambda.size() + 40)) {
      find_modes(ncv);
      if (is_complete() || ncv > 0) break;
      r_.report.detail("the inertia count found a missed mode: again with a larger Krylov space");
    }
    if (!is_proven_)
      throw RunError(
          "fixed-interface modes: the eigensolver misses one below the last (inertia count)");
    reduce_to_interface();
    keep_modes();
    add_loads();
    finish_matrices();
    if (r_.options.is_characteristic()) {
      go_over_to_shapes();
    } else {
      add_spin_moments();
      in_first([&] { judge(); });
      estimate_errors(true, nullptr);
      if (!r_.settings.is_diagonal_read) {
        s_.omega.resize(0);
        s_.V.resize(0, 0);
      }
    }
    if (r_.options.recovery) recover();
    tell_memory();
    return std::move(s_);
  }

 private:
  void assemble_own() {
    const auto phase = r_.report.phase("assembly");
    together([&] { divide(r_); });
    const std::vector<Index> node = places(r_, r_.p.interior_nodes),
                             place = places(r_, r_.p.interface_nodes);
    const NodeShares shares =
        share_nodes(r_.mesh, node, static_cast<Index>(r_.p.interior_nodes.size()));
    together([&] {
      interior_.rows =
          assemble_rows(r_.mesh, properties_, mass_, node, place,
                        static_cast<Index>(r_.p.interface_nodes.size()), shares, rank_);
    });
    std::vector<Index> own;
    for (const Index i : interior_.rows.nodes) own.push_back(r_.p.interior_nodes[i]);
    interior_.x_I = coordinates_of(r_, own);
    interior_.x_C = coordinates_of(r_, r_.p.interface_nodes);
    interior_.solver = std::make_unique<InteriorSolver>(interior_.rows);
    r_.figures.condition.rigid = largest(interior_.rows.rigid_residual);
    find_rigid_body();
  }

  // As rigid_body(): first about the mean of the points, then about the centre of mass that this
  // gives, where nothing cancels.
  void find_rigid_body() {
    RigidBody& body = s_.rigid_body;
    body.center = r_.x.colwise().mean().transpose();
    Matrix r = rigid_inertia(interior_, body.center);
    const double mass = r.diagonal().head(3).mean();
    body.center += Vector3(r(1, 5) - r(2, 4), r(2, 3) - r(0, 5), r(0, 4) - r(1, 3)) / (2 * mass);
    r = rigid_inertia(interior_, body.center);
    body.mass = r.diagonal().head(3).mean();
    body.inertia = 0.5 * (r.bottomRightCorner(3, 3) + r.bottomRightCorner(3, 3).transpose());
  }

  void factorise() {
    const auto phase = r_.report.phase("factorisation");
    r_.report.progress("factorisation", 0);
    const Index wrong = interior_.solver->factorise();
    r_.report.end_progress();
    if (wrong > 0)
      throw InputError("the stiffness of the interior is singular (" + std::to_string(wrong) +
                       " pivots are not positive): a part of it can move freely, as elements do "
                       "that share only an edge or a node "
                       "with the rest, or is held too weakly for a double; a reduction in one "
                       "process names the node");
    r_.figures.factor_nonzeros = interior_.solver->n_nonzeros();
    r_.figures.factor_flops = interior_.solver->flops();
    r_.report.detail(format_text("MUMPS: %.3g entries in the factor, %.3g flops",
                                 r_.figures.factor_nonzeros, r_.figures.factor_flops));
    r_.figures.condition.K_II = condition_numbers(*interior_.solver);
  }

  Index n_wanted() {
    if (r_.options.modes) return *r_.options.modes;
    if (n_below_ < 0) {
      const auto phase = r_.report.phase("modes: count below cutoff");
      const double omega = 2 * std::numbers::pi * *r_.options.cutoff_hz;
      n_below_ = count_below(omega * omega);
      interior_.solver->factorise();
    }
    return n_below_;
  }

  Index count_below(double sigma) {
    for (int attempt = 0; attempt < 5; ++attempt, sigma *= 1 + 1e-10)
      if (const Index count = interior_.solver->count_below(sigma); count >= 0) return count;
    throw RunError("the eigenvalues below " +
                   std::to_string(std::sqrt(sigma) / (2 * std::numbers::pi)) +
                   " Hz cannot be counted: every shift nearby meets a vanishing pivot: ask for "
                   "another cutoff, or other modes");
  }

  // And one more, to detect a twin of the last.
  void find_modes(Index ncv) {
    const Index n = interior_.rows.n, wanted = n_wanted();
    if (wanted > n)
      throw InputError("modes: " + std::to_string(wanted) +
                       " requested, but the interior has only " + std::to_string(n) +
                       " dofs and so " + std::to_string(n) +
                       " fixed-interface modes: ask for at most that many");
    const auto phase = r_.report.phase("fixed-interface modes");
    r_.report.progress("fixed-interface modes", 0);
    const Index k = n_mode_candidates(r_.options.pick, wanted, n), asked = std::min(k + 1, n);
    all_ = interior_.solver->lowest_modes(asked, ncv);
    r_.report.end_progress();
    r_.figures.n_candidates = k;
    modes_.method = k == 0 ? "none" : "krylov-schur";
    modes_.next = asked > k ? all_.lambda(k) : 0;
    modes_.lambda = all_.lambda.head(k);
    modes_.Phi = all_.Phi.leftCols(k);
    r_.report.detail(format_text("SLEPc: %d restarts", all_.restarts));
  }

  // By the inertia count between the last two that are apart. Its factor takes the place of the
  // other, which is made again.
  bool is_complete() {
    const Vector& lambda = all_.lambda;
    is_proven_ = true;
    if (modes_.lambda.size() == 0 || lambda.size() == interior_.rows.n) return true;
    const auto phase = r_.report.phase("modes: count");
    Index j = lambda.size() - 1;
    while (j > 0 && lambda(j) - lambda(j - 1) < relative_gap * lambda(j)) --j;
    const double sigma = j > 0 ? 0.5 * (lambda(j) + lambda(j - 1)) : 0.5 * lambda(0);
    const Index below = count_below(sigma);
    interior_.solver->factorise();
    modes_.counts +=
        (modes_.counts.empty() ? "" : "; ") +
        format_text("%lld below %.6g Hz, %lld found", static_cast<long long>(below),
                    std::sqrt(sigma) / (2 * std::numbers::pi), static_cast<long long>(j));
    is_proven_ = below == j;
    return is_proven_;
  }

  void reduce_to_interface() {
    const auto phase = r_.report.phase("condensation");
    ReductionFigures& figures = r_.figures;
    figures.mode_method = modes_.method;
    figures.modes_proven = is_proven_;
    figures.condition.counts = modes_.counts;
    figures.condition.modes = check_modes(*interior_.solver, modes_.lambda, modes_.Phi);
    if (figures.condition.modes.worst >= 0 && is_dependent(figures.condition.modes.orthogonality))
      throw RunError(
          "fixed-interface modes: the eigensolver has found one twice; ask for a few more or fewer "
          "modes");
    if (r_.options.modes && r_.options.pick == Pick::frequency)
      warn_of_cut_pair(modes_.lambda, modes_.next, r_.report);
    interior_.rigid = rigid_rows(interior_);
    condensed_ = condense(interior_, modes_.Phi, r_.options.recovery, r_.report);
    figures.way = condensed_.way;
    figures.panel = condensed_.panel;
    figures.rigid = condensed_.rigid;
    in_first([&] {
      judge_rigid(condensed_.rigid, figures.condition.K_II.scaled, figures.condition.weakest,
                  r_.report);
    });
    s_.K_cc = std::move(condensed_.K_cc);
    s_.M_cc = std::move(condensed_.M_cc);
  }

  // pick: participation
  void keep_modes() {
    const Index k = modes_.lambda.size();
    not_kept_.Phi.resize(interior_.n_own(), 0);
    not_kept_.beyond =
        k < interior_.rows.n ? std::max(modes_.next, k > 0 ? modes_.lambda(k - 1) : 0.0) : 0;
    if (r_.options.pick != Pick::participation || k <= *r_.options.modes) return;
    Vector number;
    in_first([&] {
      const std::vector<Index> kept = modes_by_participation(condensed_.M_kc, *r_.options.modes);
      condensed_.M_kc = Matrix(condensed_.M_kc(kept, Eigen::all));
      number = Eigen::Map<const Eigen::Matrix<Index, Eigen::Dynamic, 1>>(
                   kept.data(), static_cast<Index>(kept.size()))
                   .cast<double>();
    });
    Matrix kept = Matrix::Zero(*r_.options.modes, 1);
    if (rank_ == 0) kept.col(0) = number;
    kept = sum(kept);
    std::vector<Index> list;
    for (const double j : kept.reshaped()) list.push_back(static_cast<Index>(j));
    std::vector<Index> others;
    for (Index j = 0; j < k; ++j)
      if (!std::binary_search(list.begin(), list.end(), j)) others.push_back(j);
    not_kept_.lambda = modes_.lambda(others);
    not_kept_.Phi = modes_.Phi(Eigen::all, others);
    modes_.lambda = Vector(modes_.lambda(list));
    modes_.Phi = Matrix(modes_.Phi(Eigen::all, list));
  }

  // Rows of this process of those of the interior.
  Matrix own_rows(const Matrix& all) const {
    Matrix own(interior_.n_own(), all.cols());
    for (std::size_t i = 0; i < interior_.rows.nodes.size(); ++i)
      own.middleRows(3 * static_cast<Index>(i), 3) = all.middleRows(3 * interior_.rows.nodes[i], 3);
    return own;
  }

  void add_loads() {
    if (r_.options.loads.empty()) return;
    InteriorLoads loads;
    together([&] { loads = interior_loads(r_.mesh, r_.model, r_.p, r_.options.loads); });
    if (!loads.any()) return;
    if (r_.options.is_characteristic())
      refuse("basis: characteristic with loads inside the component");
    const auto phase = r_.report.phase("residual vectors");
    const Matrix F_I = own_rows(loads.F_I);
    s_.n_residual = add_residual_vectors(*interior_.solver, F_I, modes_);
    const Matrix more = mode_coupling(interior_, modes_.Phi.rightCols(s_.n_residual), s_.M_cc);
    const Matrix Q = generalised_forces(interior_, F_I, loads.F_C, modes_.Phi, s_.M_cc);
    if (rank_ > 0) return;
    condensed_.M_kc.conservativeResize(modes_.lambda.size(), interior_.c());
    condensed_.M_kc.bottomRows(s_.n_residual) = more;
    for (std::size_t j = 0; j < loads.names.size(); ++j)
      s_.loads[loads.names[j]] = {loads.areas[j], Q.middleCols(3 * static_cast<Index>(j), 3)};
  }

  void finish_matrices() {
    s_.eigenvalues = modes_.lambda;
    s_.M_kc = std::move(condensed_.M_kc);
    const Index own = s_.k() - s_.n_residual;
    if (own > 0)
      r_.figures.highest_frequency =
          std::sqrt(s_.eigenvalues.head(own).maxCoeff()) / (2 * std::numbers::pi);
  }

  void add_spin_moments() {
    const Vector3& center = s_.rigid_body.center;
    const Matrix D_I = unit_strains(interior_.x_I, center),
                 D_C = unit_strains(interior_.x_C, center);
    const InteriorRows& rows = interior_.rows;
    const Matrix F_I = interior_.solver->times_mass(D_I) + rows.M_IC * D_C;
    const Matrix F_C = sum(rows.M_CC * D_C + rows.M_IC.transpose() * D_I);
    s_.spin_moments = generalised_forces(interior_, F_I, F_C, modes_.Phi, s_.M_cc);
  }

  // Judges the reduced matrices in the first process.
  void judge() {
    const auto phase = r_.report.phase("diagonal form");
    Conditioning& condition = r_.figures.condition;
    judge_rigid_motions();
    const std::vector<Index> part = parts_of_interface(r_);
    const Cholesky M_res = residual_mass_factor(s_);
    if (s_.n() <= r_.settings.diagonal_limit)
      condition.n_rigid = r_.settings.is_diagonal_read
                              ? add_diagonal_form(s_, part, &M_res)
                              : add_lowest_modes(s_, part, n_estimated + n_beside);
    const Index loose = examine_reduced(s_, rigid_motions_of_parts(s_, part), M_res, condition);
    if (loose >= 0) condition.loose_node = node_of_interface_dof(r_, loose);
    tell_conditioning();
  }

  void judge_rigid_motions() {
    r_.figures.condition.reduced_rigid =
        rigid_residual(s_.K_cc, reduced_rigid_modes(s_, s_.rigid_body.center).bottomRows(s_.c()))
            .value;
  }

  void tell_conditioning() {
    report_conditioning(r_.figures.condition, r_.report);
    warn_of_conditioning(r_.figures.condition, r_.report);
    s_.conditioning = r_.figures.condition;
  }

  // Basis characteristic, from Craig-Bampton's form, which the first process has.
  void go_over_to_shapes() {
    FreeEigenvalues free;
    in_first([&] {
      judge_rigid_motions();
      add_lowest_free_modes();
    });
    estimate_errors(false, &free);
    s_.omega.resize(0);
    s_.V.resize(0, 0);
    const InteriorInertia inertia = interior_inertia();
    in_first([&] {
      take_shapes(inertia);
      judge_shapes(free);
      tell_conditioning();
    });
  }

  void add_lowest_free_modes() {
    Index& n_rigid = r_.figures.condition.n_rigid = 0;
    try {
      if (s_.n() <= r_.settings.diagonal_limit)
        n_rigid = add_lowest_modes(s_, parts_of_interface(r_), n_estimated + n_beside);
    } catch (const InputError&) {
      s_.omega.resize(0);  // a mass of round-off, with which the shapes may get on
    }
  }

  // As interior_inertia() of one factor.
  InteriorInertia interior_inertia() const {
    const RigidRows& rigid = interior_.rigid;
    Matrix X = rigid.P_I;
    interior_.solver->solve_in_place(X);
    return {rigid.R_C, inner(rigid.P_I, X)};
  }

  void take_shapes(const InteriorInertia& inertia) {
    const auto phase = r_.report.phase("characteristic modes");
    const std::vector<Index> part = parts_of_interface(r_);
    r_.figures.characteristic = make_characteristic(r_.options.characteristic, part, inertia, s_);
    const Index loose =
        examine_characteristic(s_, r_.figures.characteristic, part, r_.figures.condition);
    if (loose >= 0) r_.figures.condition.loose_node = node_of_interface_dof(r_, loose);
  }

  void judge_shapes(const FreeEigenvalues& free) {
    const Vector lambda = s_.eigenvalues.tail(s_.k() - r_.figures.condition.n_rigid);
    judge_eigenvalues(lambda, free, *s_.accuracy);
    const Index ten = std::min({lambda.size(), free.with_basis.size(), n_free_modes_of_tolerance});
    if (ten > 0)
      r_.figures.shapes_error =
          (1 - free.with_basis.head(ten).array() / lambda.head(ten).array()).maxCoeff();
  }

  // As accuracy_of(): the first process computes, all solve. of_faces: also figures of each face.
  // free: the free modes' eigenvalues, in the first process, if not null.
  void estimate_errors(bool of_faces, FreeEigenvalues* free) {
    const auto phase = r_.report.phase("errors");
    const InteriorSolver& solver = *interior_.solver;
    const Index r = s_.n_residual, own = modes_.lambda.size() - r;
    if (r > 0 && not_kept_.lambda.size() > 0) {  // as settled()
      not_kept_.beyond = std::min(not_kept_.beyond, not_kept_.lambda.minCoeff());
      not_kept_.lambda.resize(0);
      not_kept_.Phi.resize(interior_.n_own(), 0);
    }
    const Matrix Phi = modes_.Phi.leftCols(own), residual = modes_.Phi.rightCols(r);
    const Vector lambda = modes_.lambda.tail(r);
    InterfaceMotions motions;
    in_first([&] { motions = motions_of_interface(s_, parts_of_interface(r_), of_faces); });
    const Matrix Y = inertia_forces(interior_, s_.M_cc, from_first(motions.W));
    Matrix X = Y;
    solver.solve_in_place(X);
    const Matrix E = inner(Y, X);
    motions.E = 0.5 * (E + E.transpose());
    InteriorAnswers answers;
    answers.D = left_of_answer(solver, {Phi}, lambda, residual, Y).D;
    if (mass_ == MassKind::lumped) answers.rho_floor = lumped_on_interface();
    const Index n_rigid = r_.figures.condition.n_rigid;
    Matrix U, q;
    if (s_.has_diagonal_form()) {
      U = free_motions(s_, n_rigid);
      q = s_.V.block(own, 0, r, U.cols());
    }
    U = from_first(U);
    if (U.cols() > 0) answers.missing = missing_modes(U, from_first(q), Phi, residual, lambda);
    in_first([&] {
      s_.accuracy = accuracy_of(answers, motions, s_, n_rigid, not_kept_, of_faces, free);
      s_.accuracy->tolerance = 0;
    });
  }

  // q: of the residual vectors in the same motions
  MissingModes missing_modes(const Matrix& U, const Matrix& q, const Matrix& Phi,
                             const Matrix& residual, const Vector& lambda) {
    Matrix Y = inertia_forces(interior_, s_.M_cc, U);
    if (residual.cols() > 0) Y += interior_.solver->times_mass(residual * q);
    MissingModes missing{not_kept_.lambda, inner(not_kept_.Phi, Y), {}, {}, not_kept_.beyond};
    LeftOfAnswer left =
        left_of_answer(*interior_.solver, {Phi, not_kept_.Phi}, lambda, residual, std::move(Y));
    missing.D = std::move(left.D);
    missing.D_2 = std::move(left.D_2);
    return missing;
  }

  Vector3 lumped_on_interface() const {
    Vector3 floor = Vector3::Zero();
    for (Index i = 0; i < interior_.c(); ++i) floor(i % 3) += interior_.rows.M_CC.coeff(i, i);
    return floor / s_.rigid_body.mass;
  }

  void recover() {
    const auto phase = r_.report.phase("recovery");
    Matrix Phi = gather_rows(interior_.rows, modes_.Phi);
    in_first([&] { add_recovery(r_, std::move(condensed_.Psi), std::move(Phi), s_); });
  }

  void tell_memory() {
    const double own = peak_memory_bytes(), most = largest(own), least = -largest(-own);
    r_.report.line("  processes    peak memory of one " + human_bytes(least) + " to " +
                   human_bytes(most));
  }

  Reduction& r_;
  const std::vector<BlockProperties>& properties_;
  MassKind mass_;
  int rank_;
  Index n_below_ = -1;
  bool is_proven_ = false;
  DistributedInterior interior_;
  InteriorSolver::Modes all_;
  FixedInterfaceModes modes_;
  Condensation condensed_;
  ModesNotKept not_kept_;
  Superelement s_;
};

}  // namespace

Superelement reduce_in_processes(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                                 MassKind mass, const ReductionOptions& options,
                                 const ReduceSettings& settings, Report& report,
                                 ReductionFigures* figures) {
  refuse_unknown(options);
  Reduction r{mesh, options, settings, report, {}, {}, {}, {}, {}, {}};
  Superelement s = DistributedReduction(r, properties, mass).run();
  if (figures != nullptr) *figures = r.figures;
  return s;
}

}  // namespace cbr
