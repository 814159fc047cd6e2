// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/files/state_archive.hpp"

#include <cstring>

#include "common/base/error.hpp"

namespace cbr {
namespace {

[[noreturn]] void refuse(const std::string& name) {
  throw InputError(
      name + ": the state in it is not that of this scene: start the run again, without --restart");
}

}  // namespace

void StateArchive::bytes(void* data, std::size_t n) {
  if (n == 0) return;
  const std::size_t n_words = (n + sizeof(Index) - 1) / sizeof(Index);
  if (restores_) {
    if (n_words > words_.size() - next_) refuse(name_);
    std::memcpy(data, words_.data() + next_, n);
    next_ += n_words;
    return;
  }
  if (measures_) {
    next_ += n_words;
    return;
  }
  const std::size_t at = words_.size();
  words_.resize(at + n_words, 0);
  std::memcpy(words_.data() + at, data, n);
}

Index StateArchive::size(Index n, std::size_t bytes_each) {
  bytes(&n, sizeof n);
  if (!restores_) return n;
  const std::size_t left = (words_.size() - next_) * sizeof(Index);
  if (n < 0 || (bytes_each > 0 && static_cast<std::size_t>(n) > left / bytes_each)) refuse(name_);
  return n;
}

void StateArchive::finish() const {
  if (next_ != words_.size()) refuse(name_);
}

void StateArchive::expect(Index value) {
  Index kept = value;
  bytes(&kept, sizeof kept);
  if (kept != value) refuse(name_);
}

void StateArchive::one(SparseMatrix& matrix) {
  if (!restores_) matrix.makeCompressed();
  Index rows = matrix.rows(), columns = matrix.cols();
  std::vector<Index> outer, inner;
  std::vector<double> values;
  if (!restores_ && matrix.size() > 0) {
    outer.assign(matrix.outerIndexPtr(), matrix.outerIndexPtr() + columns + 1);
    inner.assign(matrix.innerIndexPtr(), matrix.innerIndexPtr() + matrix.nonZeros());
    values.assign(matrix.valuePtr(), matrix.valuePtr() + matrix.nonZeros());
  }
  (*this)(rows, columns, outer, inner, values);
  if (!restores_) return;
  matrix = SparseMatrix();
  if (outer.empty()) return;
  if (static_cast<Index>(outer.size()) != columns + 1 || inner.size() != values.size() ||
      outer.back() != static_cast<Index>(inner.size()))
    refuse(name_);
  matrix = Eigen::Map<const SparseMatrix>(rows, columns, outer.back(), outer.data(), inner.data(),
                                          values.data());
}

}  // namespace cbr
