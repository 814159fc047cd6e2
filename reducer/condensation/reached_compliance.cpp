// SPDX-License-Identifier: GPL-3.0-or-later

#include <algorithm>
#include <atomic>
#include <functional>
#include <vector>

#include "common/base/threads.hpp"
#include "common/linalg/blas_threads.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/condensation/panel_product.hpp"

namespace cbr {
namespace {

struct Panel {
  Index first, count;  // columns of B
  SupernodeSet reached;
};

class Compliance {
 public:
  Compliance(const SparseCholesky& factor, const SparseMatrix& B, double bytes)
      : tree_(factor.tree()),
        n_(factor.n_rows()),
        s_(B.cols()),
        place_(inverse({tree_.factor().order, tree_.factor().order + n_})),
        columns_(by_first_row(B, place_)),
        loads_(reordered(B, place_, columns_)),
        wanted_(tree_.reach(rows_of(loads_.sparse(), 0, s_))),
        C_(Matrix::Zero(s_, s_)) {
    for (const Index supernode : wanted_.supernodes) {
      offset_.push_back(n_wanted_);
      n_wanted_ += tree_.factor().columns(supernode);
    }
    const double column_bytes = 8.0 * static_cast<double>(n_) * n_threads();
    const Index width =
        std::clamp<Index>(static_cast<Index>(bytes / column_bytes), 1, std::min(good_panel, s_));
    for (Index first = 0; first < s_; first += width) {
      const Index count = std::min(width, s_ - first);
      panels_.push_back({first, count, tree_.reach(rows_of(loads_.sparse(), first, count))});
    }
    const double squared = static_cast<double>(n_wanted_) * static_cast<double>(s_);
    is_square_ = 8 * squared < bytes && squared < solve_penalty * wanted_.flops_per_column;
  }

  Matrix run() {
    const SingleThreadedBlas blas;
    if (is_square_) Y_.setZero(s_, n_wanted_);
    share(panels_.size(), [this](const auto& next) { solve(next); });
    const std::size_t pairs = is_square_ ? panels_.size() * panels_.size() : 0;
    share(pairs, [this](const auto& next) {
      for (std::size_t pair = next(); pair < panels_.size() * panels_.size(); pair = next())
        multiply(panels_[pair / panels_.size()], panels_[pair % panels_.size()]);
    });
    restore_order(columns_, C_);
    return std::move(C_);
  }

 private:
  using Next = std::function<std::size_t()>;

  // work(next) on all threads, for whom next() deals out 0, 1, ...
  static void share(std::size_t n, const std::function<void(const Next&)>& work) {
    std::atomic<std::size_t> count{0};
    run_threads(std::min(n_threads(), static_cast<int>(n)),
                [&](int) { work([&count] { return count++; }); });
  }

  void solve(const Next& next) {
    PanelSolver solver(tree_, panels_.front().count);
    const SparseMatrix& B = loads_.sparse();
    Matrix X, out;
    for (std::size_t i = next(); i < panels_.size(); i = next()) {
      const Panel& panel = panels_[i];
      // Rows that are not reached are neither written nor read
      if (X.rows() != panel.count) X.resize(panel.count, n_);
      for (const Index supernode : wanted_.supernodes)
        X.middleCols(tree_.factor().first(supernode), tree_.factor().columns(supernode)).setZero();
      for (Index j = 0; j < panel.count; ++j)
        for (SparseMatrix::InnerIterator it(B, panel.first + j); it; ++it)
          X(j, it.row()) = it.value();
      solver.forward(X, panel.reached);
      if (is_square_) {
        keep(panel, X);
        continue;
      }
      solver.backward(X, wanted_);
      // The columns from the panel's own on, as the rest is the other triangle
      out.setZero(panel.count, s_ - panel.first);
      loads_.add(X, 1, out);
      C_.block(panel.first, panel.first, panel.count, out.cols()) = out;
    }
  }

  void keep(const Panel& panel, const Matrix& X) {
    for (std::size_t i = first_of(panel); i < wanted_.supernodes.size(); ++i) {
      const Index s = wanted_.supernodes[i], columns = tree_.factor().columns(s);
      Y_.block(panel.first, offset_[i], panel.count, columns) =
          X.middleCols(tree_.factor().first(s), columns);
    }
  }

  // Of the supernodes that are wanted the first that a panel reaches
  std::size_t first_of(const Panel& panel) const {
    if (panel.reached.supernodes.empty()) return wanted_.supernodes.size();
    const auto found = std::lower_bound(wanted_.supernodes.begin(), wanted_.supernodes.end(),
                                        panel.reached.supernodes.front());
    return static_cast<std::size_t>(found - wanted_.supernodes.begin());
  }

  void multiply(const Panel& a, const Panel& b) {
    const std::size_t start = std::max(first_of(a), first_of(b));
    if (b.first < a.first || start == wanted_.supernodes.size()) return;
    const Index left = n_wanted_ - offset_[start];
    C_.block(a.first, b.first, a.count, b.count).noalias() =
        Y_.block(a.first, n_wanted_ - left, a.count, left) *
        Y_.block(b.first, n_wanted_ - left, b.count, left).transpose();
  }

  const SupernodeTree& tree_;
  Index n_, s_, n_wanted_ = 0;
  std::vector<Index> place_, columns_;
  PanelProduct loads_;
  SupernodeSet wanted_;
  std::vector<Index> offset_;  // of the supernodes that are wanted, in Y
  std::vector<Panel> panels_;
  // C = Y Y^T, Y = (L^-1 B)^T, costs less than L^-T Y^T and B^T of that, and Y fits
  bool is_square_ = false;
  Matrix Y_, C_;  // s x rows that are wanted
};

}  // namespace

Matrix reached_compliance(const SparseCholesky& factor, const SparseMatrix& B, double bytes) {
  if (B.cols() == 0) return Matrix(0, 0);
  return Compliance(factor, B, bytes).run();
}

}  // namespace cbr
