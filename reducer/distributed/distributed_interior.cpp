// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/distributed/distributed_interior.hpp"

#include <slepceps.h>

#include <algorithm>
#include <string>

#include "common/base/error.hpp"
#include "reducer/distributed/petsc.hpp"
#include "reducer/distributed/processes.hpp"

namespace cbr {
namespace {

// the ordering of Debian's MUMPS that suits meshes of solids: it has no METIS and no Scotch
constexpr int pord = 4;
constexpr int good_block = 128;            // right-hand sides that MUMPS solves for at a time
constexpr int room = 30, most_room = 500;  // per cent beyond MUMPS's estimate of a factor
constexpr int no_room[] = {-8, -9, -14, -15, -17, -20};  // of INFOG(1): more room helps
constexpr int out_of_memory[] = {-13, -19};

template <std::size_t n>
bool is_one_of(const int (&codes)[n], PetscInt code) {
  return std::find(std::begin(codes), std::end(codes), code) != std::end(codes);
}

PetscErrorCode solve_with_factor(PC pc, Vec b, Vec x) {
  void* factor = nullptr;
  if (const PetscErrorCode code = PCShellGetContext(pc, &factor); code != 0) return code;
  return MatSolve(static_cast<Mat>(factor), b, x);
}

Mat matrix_of(DistributedRows& rows, Index n_own, Index n) {
  Mat A = nullptr;
  petsc(MatCreateMPIAIJWithArrays(PETSC_COMM_WORLD, static_cast<PetscInt>(n_own),
                                  static_cast<PetscInt>(n_own), static_cast<PetscInt>(n),
                                  static_cast<PetscInt>(n), rows.start.data(), rows.column.data(),
                                  rows.value.data(), &A));
  rows = {};
  petsc(MatSetOption(A, MAT_SYMMETRIC, PETSC_TRUE));
  petsc(MatSetOption(A, MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
  return A;
}

}  // namespace

struct DistributedInterior::Impl {
  Index n, n_own;
  Mat K = nullptr, M = nullptr, F = nullptr;
  int relaxed = room;
  Vector diagonal;
  double norm = 0, scaled_one_norm = 0;

  explicit Impl(InteriorRows& rows)
      : n(rows.n),
        n_own(rows.n_own),
        K(matrix_of(rows.K_II, n_own, n)),
        M(matrix_of(rows.M_II, n_own, n)),
        diagonal(n_own) {
    measure();
  }

  void measure() {
    petsc(MatNorm(K, NORM_1, &norm));
    Vec d = vector(diagonal.data());
    petsc(MatGetDiagonal(K, d));
    const Vector D = diagonal.cwiseSqrt().cwiseInverse();
    Vec scale = vector(D.data());
    Mat scaled = nullptr;
    petsc(MatDuplicate(K, MAT_COPY_VALUES, &scaled));
    petsc(MatDiagonalScale(scaled, scale, scale));
    petsc(MatNorm(scaled, NORM_1, &scaled_one_norm));
    petsc(MatDestroy(&scaled));
    petsc(VecDestroy(&scale));
    petsc(VecDestroy(&d));
  }

  ~Impl() {
    MatDestroy(&F);
    MatDestroy(&M);
    MatDestroy(&K);
  }

  void analyse(Mat A) {
    petsc(MatDestroy(&F));
    petsc(MatGetFactor(A, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, &F));
    petsc(MatMumpsSetIcntl(F, 7, pord));
    petsc(MatMumpsSetIcntl(F, 13, 1));  // the root's pivots are counted, too
    petsc(MatMumpsSetIcntl(F, 14, relaxed));
    petsc(MatMumpsSetIcntl(F, 27, good_block));
    petsc(MatMumpsSetIcntl(F, 24, 1));  // pivots that vanish are counted
    MatFactorInfo info;
    petsc(MatFactorInfoInitialize(&info));
    petsc(MatCholeskyFactorSymbolic(F, A, nullptr, &info));
  }

  // MUMPS's own word of it, 0: done.
  PetscInt code() const {
    PetscInt of_all = 0;
    petsc(MatMumpsGetInfog(F, 1, &of_all));
    return of_all < 0 ? of_all : 0;
  }

  void factorise(Mat A) {
    if (F == nullptr) analyse(A);
    for (;;) {
      MatFactorInfo info;
      petsc(MatFactorInfoInitialize(&info));
      petsc(MatCholeskyFactorNumeric(F, A, &info));
      if (code() == 0) return;
      refuse_or_relax();
      analyse(A);
    }
  }

  void refuse_or_relax() {
    PetscInt detail = 0;
    petsc(MatMumpsGetInfog(F, 2, &detail));
    if (is_one_of(no_room, code()) && relaxed < most_room) {
      relaxed *= 2;
      return;
    }
    if (is_one_of(out_of_memory, code()) || is_one_of(no_room, code()))
      throw RunError(
          "the factor of the interior's stiffness finds no memory: use more processes on more "
          "machines, or domains");
    throw RunError("MUMPS: error " + std::to_string(code()) + " (" + std::to_string(detail) +
                   ") in the factorisation");
  }

  PetscInt infog(int i) const {
    PetscInt value = 0;
    petsc(MatMumpsGetInfog(F, i, &value));
    return value;
  }

  Mat view(const Matrix& X) const {
    Mat A = nullptr;
    petsc(MatCreateDense(PETSC_COMM_WORLD, static_cast<PetscInt>(n_own), PETSC_DECIDE,
                         static_cast<PetscInt>(n), static_cast<PetscInt>(X.cols()),
                         const_cast<double*>(X.data()), &A));
    return A;
  }

  Vec vector(const double* x) const {
    Vec v = nullptr;
    petsc(VecCreateMPIWithArray(PETSC_COMM_WORLD, 1, static_cast<PetscInt>(n_own),
                                static_cast<PetscInt>(n), x, &v));
    return v;
  }

  Matrix product(Mat A, const Matrix& X) const {
    Matrix Y(n_own, X.cols());
    for (Index j = 0; j < X.cols(); ++j) {
      Vec x = vector(X.col(j).data()), y = vector(Y.col(j).data());
      petsc(MatMult(A, x, y));
      petsc(VecDestroy(&x));
      petsc(VecDestroy(&y));
    }
    return Y;
  }
};

DistributedInterior::DistributedInterior(const Partition& partition, InteriorRows&& rows)
    : Interior(partition), impl_(std::make_unique<Impl>(rows)), nodes_(std::move(rows.nodes)) {}
DistributedInterior::~DistributedInterior() = default;

Index DistributedInterior::factorise() {
  impl_->factorise(impl_->K);
  return impl_->infog(12) + impl_->infog(28);
}

double DistributedInterior::n_nonzeros() const {
  const PetscInt entries = impl_->infog(29);  // in millions, where it is negative
  return entries < 0 ? -1e6 * entries : entries;
}

double DistributedInterior::flops() const {
  PetscReal flops = 0;
  petsc(MatMumpsGetRinfog(impl_->F, 3, &flops));
  return flops;
}

const Vector& DistributedInterior::diagonal() const { return impl_->diagonal; }
double DistributedInterior::one_norm() const { return impl_->norm; }
double DistributedInterior::scaled_one_norm() const { return impl_->scaled_one_norm; }

Matrix DistributedInterior::times_stiffness(const Matrix& X) const {
  return impl_->product(impl_->K, X);
}

void DistributedInterior::add_mass(const Matrix& X, Matrix& Y) const {
  Y += impl_->product(impl_->M, X);
}

void DistributedInterior::solve_in_place(Matrix& X) const {
  if (X.cols() == 0) return;
  const Matrix right = X;
  Mat B = impl_->view(right), Y = impl_->view(X);
  petsc(MatMatSolve(impl_->F, B, Y));
  petsc(MatDestroy(&B));
  petsc(MatDestroy(&Y));
}

Matrix DistributedInterior::sum(Matrix part) const { return cbr::sum(part); }

void DistributedInterior::in_first(const std::function<void()>& work) const { cbr::in_first(work); }

Matrix DistributedInterior::from_first(const std::function<Matrix()>& result) const {
  Matrix of_first;
  cbr::in_first([&] { of_first = result(); });
  return cbr::from_first(of_first);
}

std::vector<Index> DistributedInterior::order_of_rows() const {
  Vector own(n_rows());
  for (Index i = 0; i < own.size(); ++i) own(i) = static_cast<double>(3 * nodes_[i / 3] + i % 3);
  std::vector<Index> order;
  for (const double row : gather_in_first(own)) order.push_back(static_cast<Index>(row));
  return order;
}

void gather_columns(const std::vector<Index>& order, const Matrix& own, Index first, Matrix& B) {
  for (Index j = 0; j < own.cols(); ++j) {
    const Vector all = gather_in_first(own.col(j));
    for (Index i = 0; i < all.size(); ++i) B(order[i], first + j) = all(i);
  }
}

Matrix DistributedInterior::gather(Matrix own) const {
  const std::vector<Index> order = order_of_rows();
  Matrix all(static_cast<Index>(order.size()), own.cols());
  gather_columns(order, own, 0, all);
  return all;
}

DistributedInterior::Modes DistributedInterior::lowest_modes(Index k, Index ncv) const {
  EPS eps = nullptr;
  ST st = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  petsc(EPSCreate(PETSC_COMM_WORLD, &eps));
  petsc(EPSSetOperators(eps, impl_->K, impl_->M));
  petsc(EPSSetProblemType(eps, EPS_GHEP));
  petsc(EPSSetType(eps, EPSKRYLOVSCHUR));
  petsc(EPSSetWhichEigenpairs(eps, EPS_TARGET_MAGNITUDE));
  petsc(EPSSetTarget(eps, 0));
  petsc(EPSSetDimensions(eps, static_cast<PetscInt>(k),
                         ncv > 0 ? static_cast<PetscInt>(ncv) : PETSC_DEFAULT, PETSC_DEFAULT));
  petsc(EPSSetTolerances(eps, 1e-13, 500));
  petsc(EPSGetST(eps, &st));
  petsc(STSetType(st, STSINVERT));
  petsc(STSetMatMode(st, ST_MATMODE_SHELL));
  petsc(STGetKSP(st, &ksp));
  petsc(KSPSetType(ksp, KSPPREONLY));
  petsc(KSPGetPC(ksp, &pc));
  petsc(PCSetType(pc, PCSHELL));
  petsc(PCShellSetContext(pc, impl_->F));
  petsc(PCShellSetApply(pc, solve_with_factor));
  petsc(EPSSolve(eps));
  PetscInt converged = 0, restarts = 0;
  petsc(EPSGetConverged(eps, &converged));
  petsc(EPSGetIterationNumber(eps, &restarts));
  if (converged < k)
    throw RunError("fixed-interface modes: " + std::to_string(converged) + " of " +
                   std::to_string(k) + " converged in " + std::to_string(restarts) +
                   " restarts of the eigensolver: ask for a few more or fewer modes");
  Modes modes{Vector(k), Matrix(impl_->n_own, k), static_cast<int>(restarts)};
  for (Index j = 0; j < k; ++j) {
    Vec x = impl_->vector(modes.Phi.col(j).data());
    petsc(EPSGetEigenpair(eps, static_cast<PetscInt>(j), &modes.lambda(j), nullptr, x, nullptr));
    petsc(VecDestroy(&x));
  }
  petsc(EPSDestroy(&eps));
  return modes;
}

Index DistributedInterior::count_below(double sigma) {
  Mat A = nullptr;
  petsc(MatDuplicate(impl_->K, MAT_COPY_VALUES, &A));
  petsc(MatAXPY(A, -sigma, impl_->M, SUBSET_NONZERO_PATTERN));
  impl_->factorise(A);
  petsc(MatDestroy(&A));
  return impl_->infog(28) > 0 ? -1 : impl_->infog(12);
}

}  // namespace cbr
