// SPDX-License-Identifier: GPL-3.0-or-later
// The state of a run as words of 8 bytes: saved and restored by the same functions, bit for bit.
#pragma once

#include <map>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// A class with a state has a member keep_state(StateArchive&), or a free function
// keep_state(StateArchive&, T&), that lists its data: archive(a, b, c). Saving appends these,
// restoring fills them in the same order, so that the two stay consistent. Supports numbers, enums,
// strings, vectors, maps, Eigen's dense matrices and sparse ones.
class StateArchive {
 public:
  StateArchive() = default;  // saves
  // Runs `keep` twice, first to measure the size, which may be most of the memory.
  template <typename Keep>
  static StateArchive saved(const Keep& keep) {
    StateArchive archive;
    archive.measures_ = true;
    keep(archive);
    archive.words_.reserve(archive.next_);
    archive.measures_ = false;
    archive.next_ = 0;
    keep(archive);
    return archive;
  }
  // Restores; `name` is for messages. InputError, from any call, when the words are not those of
  // such objects.
  StateArchive(std::vector<Index> words, std::string name)
      : words_(std::move(words)), name_(std::move(name)), restores_(true) {}

  bool restores() const { return restores_; }
  const std::vector<Index>& words() const { return words_; }
  void finish() const;  // restoring: InputError when words are left

  template <typename... T>
  void operator()(T&... values) {
    (one(values), ...);
  }
  // A value that must be the same when restoring and when saving. InputError when it is not.
  void expect(Index value);

 private:
  template <typename T>
  static constexpr bool is_plain = std::is_arithmetic_v<T> || std::is_enum_v<T>;

  void bytes(void* data, std::size_t n);
  Index size(Index n, std::size_t bytes_each);  // restoring: there are as many bytes left

  template <typename T>
  void one(T& value) {
    if constexpr (is_plain<T>) {
      bytes(&value, sizeof(T));
    } else if constexpr (std::is_base_of_v<Eigen::PlainObjectBase<T>, T>) {
      dense(value);
    } else if constexpr (requires { value.keep_state(*this); }) {
      value.keep_state(*this);
    } else {
      keep_state(*this, value);
    }
  }

  template <typename T>
  void dense(T& values) {
    constexpr std::size_t each = sizeof(typename T::Scalar);
    if constexpr (T::SizeAtCompileTime == Eigen::Dynamic) {
      const Index columns = size(values.cols(), 0),
                  rows = size(values.rows(), each * static_cast<std::size_t>(columns));
      if (restores_) values.resize(rows, columns);
    }
    bytes(values.data(), each * static_cast<std::size_t>(values.size()));
  }

  template <typename T>
  void one(std::vector<T>& values) {
    const Index n = size(static_cast<Index>(values.size()), is_plain<T> ? sizeof(T) : 1);
    if (restores_) values.resize(n);
    if constexpr (is_plain<T>) {
      bytes(values.data(), values.size() * sizeof(T));
    } else {
      for (T& value : values) one(value);
    }
  }

  template <typename T>
  void one(std::map<Index, T>& values) {
    std::vector<Index> keys;
    for (const auto& [key, value] : values) keys.push_back(key);
    one(keys);
    if (restores_) values.clear();
    for (const Index key : keys) one(values[key]);
  }

  void one(SparseMatrix& matrix);

  std::vector<Index> words_;
  std::string name_;
  bool restores_ = false, measures_ = false;
  std::size_t next_ = 0;
};

}  // namespace cbr
