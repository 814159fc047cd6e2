// SPDX-License-Identifier: GPL-3.0-or-later
// The steps of a reduction that all processes take together (bases/engine.hpp).
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/base/process.hpp"
#include "common/fem/connected_parts.hpp"
#include "common/linalg/dense.hpp"
#include "reducer/bases/engine.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/distributed/distributed_interior.hpp"
#include "reducer/distributed/processes.hpp"
#include "reducer/judgement/condition_numbers.hpp"

namespace cbr {
namespace {

// two eigenvalues closer than this are one multiple one to a count
constexpr double relative_gap = 1e-7;
constexpr Index panel_width = 128;

// Psi is put together in the first process, and written by it.
void require_memory_for_recovery(Index n_I, Index c) {
  const double bytes = 8.0 * static_cast<double>(n_I) * static_cast<double>(c);
  if (bytes > machine_memory_bytes())
    throw InputError("recovery: the motion of " + std::to_string(n_I) + " dofs inside with " +
                     std::to_string(c) + " on the interface takes " + human_bytes(bytes) +
                     " in the first process, whose machine has " +
                     human_bytes(machine_memory_bytes()) +
                     ": leave it out, take a smaller interface, or domains");
}

// `what` is supported in one process only.
[[noreturn]] void refuse(const std::string& what) {
  throw InputError(what +
                   " is not known to several processes and --engine petsc: reduce this component "
                   "in one process without it");
}

void refuse_unknown(const ReductionOptions& options) {
  if (options.is_massless()) refuse("basis: massless");
  if (options.tolerance) refuse("tolerance");
}

// Per node of the mesh its place in a list of model nodes, or -1.
std::vector<Index> places(const Reduction& r, const std::vector<Index>& nodes) {
  std::vector<Index> place(r.mesh.node_ids.size(), -1);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    place[mesh_node(r, nodes[i])] = static_cast<Index>(i);
  return place;
}

// Nodes inside and on the interface, without K and M.
void divide(Reduction& r) {
  r.model = number_nodes(r.mesh);
  r.x = r.mesh.coordinates(r.model.nodes, Eigen::all);
  r.p.interface_nodes = interface_nodes(r.mesh, r.model, r.options.interface_sets);
  const auto n = static_cast<Index>(r.model.nodes.size());
  r.p.interior_nodes = other_nodes(r.model, r.p.interface_nodes);
  r.p.interior_rows = dofs_of(r.p.interior_nodes);
  r.p.interface_rows = dofs_of(r.p.interface_nodes);
  const auto n_I = 3 * static_cast<Index>(r.p.interior_nodes.size()),
             c = 3 * static_cast<Index>(r.p.interface_nodes.size());
  r.p.K_II.resize(n_I, n_I);
  r.p.K_CC.resize(c, c);  // their sizes alone
  r.part = connected_parts(r.mesh, r.model);
  if (has_parts(r)) refuse("a component of several parts that share no node");
  if (n_I == 0) refuse("a component whose nodes are all on the interface");
  check_interface_holds(r.mesh, r.model, r.p, r.part);
  require_memory_for_interface(c, machine_memory_bytes());
  if (r.options.recovery) require_memory_for_recovery(n_I, c);
  r.figures.n_dofs = 3 * n;
  r.figures.n_interior = n_I;
}

// R^T M R of the six rigid motions about `center`, of the whole component   (6 x 6)
Matrix rigid_inertia(const Interior& interior, const Points& x_I, const Points& x_C,
                     const Vector3& center) {
  const Partition& p = interior.p;
  const Matrix R_I = rigid_modes(x_I, center), R_C = rigid_modes(x_C, center);
  const Matrix P_I = interior.times_mass(R_I) + p.M_IC * R_C;
  return interior.sum(R_I.transpose() * P_I +
                      R_C.transpose() * (p.M_IC.transpose() * R_I + p.M_CC * R_C));
}

// As rigid_motions() of one part.
RigidMotions rigid_rows(const Interior& interior, const Points& x_I, const Points& x_C) {
  const Partition& p = interior.p;
  const Vector3 middle = x_C.colwise().mean().transpose();
  double size = 0;
  for (const Points* x : {&x_I, &x_C})
    if (x->rows() > 0)
      size = std::max(size, (x->rowwise() - middle.transpose()).rowwise().norm().maxCoeff());
  size = largest(size);
  Matrix R_I = rigid_modes(x_I / size, middle / size), R_C = rigid_modes(x_C / size, middle / size);
  Matrix P_I = interior.times_mass(R_I) + p.M_IC * R_C;
  Matrix P_C = interior.sum(p.M_IC.transpose() * R_I + p.M_CC * R_C);
  // R <- R L^-T with R^T M R = L L^T; twice, as the first pass leaves cond(L) times round-off
  for (int pass = 0; pass < 2; ++pass) {
    const Cholesky cholesky(interior.inner(R_I, P_I) + R_C.transpose() * P_C);
    if (!cholesky.ok()) throw RunError("the mass of the rigid motions is not positive definite");
    for (Matrix* A : {&R_I, &R_C, &P_I, &P_C}) cholesky.divide_by_upper(*A);
  }
  const auto sparse = [](const Matrix& A) { return SparseMatrix(A.sparseView(0.0, 0.0)); };
  return {sparse(R_I), sparse(R_C), sparse(P_I), sparse(P_C)};
}

// As condition_numbers().
ConditionNumbers conditions(const DistributedInterior& interior) {
  const Vector D = interior.diagonal().cwiseSqrt().cwiseInverse(), one = Vector::Ones(D.size());
  std::array<double, 2> norms{};
  for (const bool scaled : {false, true}) {
    const Vector& scale = scaled ? D : one;
    Index here = 0;
    in_first([&] { here = interior.p.n_interior(); });
    InverseNorm search(here);  // the first process's, whose questions all answer
    while (any(!search.is_done())) {
      Matrix x = scatter_from_first(search.asked(), D.size()).cwiseQuotient(scale);
      interior.solve_in_place(x);
      const Vector answer = gather_in_first(Vector(x.col(0)).cwiseQuotient(scale));
      if (here > 0) search.answer(answer);
    }
    norms[scaled ? 1 : 0] =
        (scaled ? interior.scaled_one_norm() : interior.one_norm()) * largest(search.norm());
  }
  return {norms[0], norms[1]};
}

void make_symmetric(Matrix& A) {
  for (Index j = 0; j < A.cols(); ++j)
    for (Index i = 0; i < j; ++i) A(i, j) = A(j, i) = 0.5 * (A(i, j) + A(j, i));
}

class DistributedEngine final : public Engine {
 public:
  void assemble(Reduction& r, Superelement& s) override {
    const auto phase = r.report.phase("assembly");
    together([&] { divide(r); });
    const std::vector<Index> node = places(r, r.p.interior_nodes),
                             place = places(r, r.p.interface_nodes);
    const NodeShares shares =
        share_nodes(r.mesh, node, static_cast<Index>(r.p.interior_nodes.size()));
    InteriorRows rows;
    together([&] {
      rows = assemble_rows(r.mesh, r.properties, r.mass, node, place,
                           static_cast<Index>(r.p.interface_nodes.size()), shares,
                           process_numbers().own);
    });
    r.p.K_IC.swap(rows.K_IC);
    r.p.M_IC.swap(rows.M_IC);
    r.p.K_CC.swap(rows.K_CC);
    r.p.M_CC.swap(rows.M_CC);
    r.p.lumped = r.mass == MassKind::lumped;
    r.figures.condition.rigid = largest(rows.rigid_residual);
    auto inside = std::make_unique<DistributedInterior>(r.p, std::move(rows));
    inside_ = inside.get();
    r.inside = std::move(inside);
    x_I_ = coordinates_of(r, own_nodes(r));
    x_C_ = coordinates_of(r, r.p.interface_nodes);
    find_rigid_body(r.x, s.rigid_body);
  }

  void factorise(Reduction& r) override {
    const auto phase = r.report.phase("factorisation");
    r.report.progress("factorisation", 0);
    const Index wrong = inside_->factorise();
    r.report.end_progress();
    if (wrong > 0)
      throw InputError("the stiffness of the interior is singular (" + std::to_string(wrong) +
                       " pivots are not positive): a part of it can move freely, as elements do "
                       "that share only an edge or a node with the rest, or is held too weakly for "
                       "a double; a reduction in one process names the node");
    r.figures.factor_nonzeros = inside_->n_nonzeros();
    r.figures.factor_flops = inside_->flops();
    r.report.detail(format_text("MUMPS: %.3g entries in the factor, %.3g flops",
                                r.figures.factor_nonzeros, r.figures.factor_flops));
    r.figures.condition.K_II = conditions(*inside_);
  }

  Index count_below(Reduction&, double hz) override {
    const double omega = 2 * std::numbers::pi * hz;
    return count_below(omega * omega);
  }

  FixedInterfaceModes lowest_modes(Reduction& r, Index k) override {
    const Index n = r.p.n_interior();
    require_dofs_for_modes(k, n);
    FixedInterfaceModes modes;
    modes.method = k == 0 ? "none" : "krylov-schur";
    for (Index ncv = 0;; ncv = std::min(n, 3 * k + 40)) {
      // one more, to detect a twin of the last
      const auto all = inside_->lowest_modes(std::min(k + 1, n), ncv);
      r.report.end_progress();
      r.report.detail(format_text("SLEPc: %d restarts", all.restarts));
      modes.next = all.lambda.size() > k ? all.lambda(k) : 0;
      modes.lambda = all.lambda.head(k);
      modes.Phi = all.Phi.leftCols(k);
      modes.proven = k == 0 || all.lambda.size() == n || is_complete(all.lambda, modes.counts);
      if (modes.proven) return modes;
      if (ncv > 0) break;
      r.report.detail("the inertia count found a missed mode: again with a larger Krylov space");
    }
    throw RunError(
        "fixed-interface modes: the eigensolver misses one below the last (inertia count)");
  }

  // By a second solve of each column, so that no process has more of Psi than its rows of one
  // panel. The first process has the whole Psi, if it is to be kept.
  Condensation condense(Reduction& r, const Matrix& Phi) override {
    r.p.rigid = rigid_rows(*inside_, x_I_, x_C_);
    const Index c = r.p.n_interface(), c_here = process_numbers().own == 0 ? c : 0;
    Condensation result;
    result.way = CondensationWay::second_solve;
    result.panel = std::min(panel_width, c);
    const std::vector<Index> order =
        r.options.recovery ? inside_->order_of_rows() : std::vector<Index>();
    together([&] {
      result.K_cc.resize(c_here, c_here);
      result.M_cc.resize(c_here, c_here);
      result.M_kc = Matrix::Zero(Phi.cols(), c);
      result.Psi.resize(static_cast<Index>(order.size()), r.options.recovery ? c : 0);
    });
    Matrix m = r.p.rigid.P_C;
    const Matrix M_Phi = inside_->times_mass(Phi);
    for (Index first = 0; first < c; first += panel_width) {
      r.report.progress("constraint modes", static_cast<double>(first) / static_cast<double>(c));
      condense_panel(r, Phi, M_Phi, first, order, m, result);
    }
    r.report.end_progress();
    make_symmetric(result.K_cc);
    make_symmetric(result.M_cc);
    follow(r, m, Phi, result);
    return result;
  }

 private:
  // As rigid_body(): first about the mean of the points, then about the centre of mass that this
  // gives, where nothing cancels.
  void find_rigid_body(const Points& x, RigidBody& body) const {
    body.center = x.colwise().mean().transpose();
    Matrix r = rigid_inertia(*inside_, x_I_, x_C_, body.center);
    const double mass = r.diagonal().head(3).mean();
    body.center += Vector3(r(1, 5) - r(2, 4), r(2, 3) - r(0, 5), r(0, 4) - r(1, 3)) / (2 * mass);
    r = rigid_inertia(*inside_, x_I_, x_C_, body.center);
    body.mass = r.diagonal().head(3).mean();
    body.inertia = 0.5 * (r.bottomRightCorner(3, 3) + r.bottomRightCorner(3, 3).transpose());
  }

  // The count's factor takes the place of the other, which is made again.
  Index count_below(double sigma) {
    for (int attempt = 0; attempt < 5; ++attempt, sigma *= 1 + 1e-10)
      if (const Index count = inside_->count_below(sigma); count >= 0) {
        inside_->factorise();
        return count;
      }
    throw RunError("the eigenvalues below " +
                   std::to_string(std::sqrt(sigma) / (2 * std::numbers::pi)) +
                   " Hz cannot be counted: every shift nearby meets a vanishing pivot: ask for "
                   "another cutoff, or other modes");
  }

  // By the inertia count between the last two that are apart.
  bool is_complete(const Vector& lambda, std::string& counts) {
    Index j = lambda.size() - 1;
    while (j > 0 && lambda(j) - lambda(j - 1) < relative_gap * lambda(j)) --j;
    const double sigma = j > 0 ? 0.5 * (lambda(j) + lambda(j - 1)) : 0.5 * lambda(0);
    const Index below = count_below(sigma);
    counts += (counts.empty() ? "" : "; ") +
              format_text("%lld below %.6g Hz, %lld found", static_cast<long long>(below),
                          std::sqrt(sigma) / (2 * std::numbers::pi), static_cast<long long>(j));
    return below == j;
  }

  // Columns first to first + panel_width; rows of m = Psi^T (M R)_I + (M R)_C
  void condense_panel(const Reduction& r, const Matrix& Phi, const Matrix& M_Phi, Index first,
                      const std::vector<Index>& order, Matrix& m, Condensation& result) const {
    const Partition& p = r.p;
    const Index width = std::min(panel_width, p.n_interface() - first);
    const auto panel = [&](const SparseMatrix& A) { return Matrix(A.middleCols(first, width)); };
    const Matrix M_IC = panel(p.M_IC);
    Matrix X = -panel(p.K_IC);
    inside_->solve_in_place(X);  // Psi of the panel
    if (r.options.recovery) gather_columns(order, X, first, result.Psi);
    const Matrix K = sum_to_first(p.K_IC.transpose() * X + panel(p.K_CC));
    const Matrix coupling = sum_to_first(Phi.transpose() * M_IC + M_Phi.transpose() * X);
    m.middleRows(first, width) += inside_->sum(p.rigid.momentum(X)).transpose();
    // M_cc = M_CC + M_CI Psi - K_CI K_II^-1 (M_IC + M_II Psi)
    Matrix Y = M_IC;
    inside_->add_mass(X, Y);
    inside_->solve_in_place(Y);
    const Matrix M = sum_to_first(p.M_IC.transpose() * X + panel(p.M_CC) - p.K_IC.transpose() * Y);
    if (K.rows() == 0) return;
    result.K_cc.middleCols(first, width) = K;
    result.M_cc.middleCols(first, width) = M;
    result.M_kc.middleCols(first, width) = coupling;
  }

  // As in condensation.cpp: rigid motions exactly, G to all processes.
  void follow(const Reduction& r, const Matrix& m, const Matrix& Phi, Condensation& result) const {
    const RigidMotions& rigid = r.p.rigid;
    result.G = inside_
                   ->from_first([&] {
                     result.rigid = follow_rigid_motions(rigid, m, result.K_cc, result.M_cc);
                     return Matrix(rigid_content(rigid, result.M_cc));
                   })
                   .sparseView(0.0, 0.0);
    const Matrix momentum = inside_->sum(rigid.momentum(Phi));
    follow_rigid_motions(rigid, result.G, momentum, result.M_kc);
    if (!r.options.recovery) return;
    Matrix missing = inside_->gather(Matrix(rigid.R_I));
    if (missing.rows() == 0) return;
    missing -= result.Psi * rigid.R_C;
    result.Psi += missing * result.G;
  }

  DistributedInterior* inside_ = nullptr;  // the reduction's
  Points x_I_, x_C_;                       // nodes of this process, of the interface
};

}  // namespace

Superelement reduce_in_processes(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                                 MassKind mass, const ReductionOptions& options,
                                 const ReduceSettings& settings, Report& report,
                                 ReductionFigures* figures) {
  refuse_unknown(options);
  Reduction r{mesh, properties, mass, options, settings, report};
  DistributedEngine engine;
  Superelement s = reduce_by(engine, r);
  const double own = peak_memory_bytes(), most = largest(own), least = -largest(-own);
  report.line("  processes    peak memory of one " + human_bytes(least) + " to " +
              human_bytes(most));
  if (figures != nullptr) *figures = r.figures;
  return s;
}

}  // namespace cbr
