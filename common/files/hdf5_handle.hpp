// SPDX-License-Identifier: GPL-3.0-or-later
// What the reader and the writer share. Included by hdf5_reader.cpp and hdf5_writer.cpp only.
#pragma once

#include <hdf5.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/checksum.hpp"
#include "common/base/types.hpp"

namespace cbr::hdf5 {

// An HDF5 identifier that closes itself.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle() = default;
  Handle(hid_t id, Close close) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }
  bool ok() const { return id_ >= 0; }
  hid_t release() { return std::exchange(id_, -1); }

 private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

// By default the library prints its error stack; the setting is per thread.
inline void silence() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

// Rows copied at once between a column-major matrix and the file's rows: 16 MB, whatever the
// matrix's size.
inline Index panel_rows(Index columns) {
  return std::max<Index>(1, (Index{1} << 21) / std::max<Index>(1, columns));
}

// Memory and file spaces of rows [first, first + rows) of a two-dimensional dataset.
inline std::pair<Handle, Handle> panel(hid_t dataset, Index first, Index rows, Index columns) {
  const hsize_t start[2] = {static_cast<hsize_t>(first), 0};
  const hsize_t count[2] = {static_cast<hsize_t>(rows), static_cast<hsize_t>(columns)};
  Handle memory(H5Screate_simple(2, count, nullptr), H5Sclose),
      file(H5Dget_space(dataset), H5Sclose);
  H5Sselect_hyperslab(file, H5S_SELECT_SET, start, nullptr, count, nullptr);
  return {std::move(memory), std::move(file)};
}

inline constexpr const char* checksum_attribute = "checksum";

// XXH3 (64 bit) of a dataset's numbers as they are in the file, int64. Empty: not one whole number.
inline std::optional<Index> checksum_of(hid_t dataset) {
  const Handle attribute(H5Aopen(dataset, checksum_attribute, H5P_DEFAULT), H5Aclose);
  const Handle type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
  Index value = 0;
  if (H5Tget_class(type) != H5T_INTEGER || H5Sget_simple_extent_npoints(space) != 1 ||
      H5Aread(attribute, H5T_NATIVE_INT64, &value) < 0)
    return {};
  return value;
}

// Of an object's texts, which are in the one structure of a file without a checksum of the library:
// the XXH3 (64 bit) of each attribute's name and text, int64. Texts that others add have none.
inline constexpr const char* checksums_of_texts = "checksums_of_texts";

// Empty: none, or not whole numbers.
inline std::vector<Index> text_checksums(hid_t object) {
  const Handle attribute(H5Aopen(object, checksums_of_texts, H5P_DEFAULT), H5Aclose);
  const Handle type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
  const hssize_t n = H5Sget_simple_extent_npoints(space);
  if (n <= 0 || H5Tget_class(type) != H5T_INTEGER) return {};
  std::vector<Index> values(n);
  if (H5Aread(attribute, H5T_NATIVE_INT64, values.data()) < 0) return {};
  return values;
}

inline Index text_checksum(const std::string& attribute, const std::string& text) {
  Checksum term;
  term.add(attribute.data(), attribute.size());
  term.add(text.data(), text.size());
  return term.value();
}

// Term of ComparedChecksums::digest
inline Index digest_term(const std::string& dataset, Index value) {
  Checksum term;
  term.add(dataset.data(), dataset.size());
  term.add(&value, sizeof value);
  return term.value();
}

// hdf5_string_heap.cpp

// False when a heap of variable-length strings ("global heap collection" of the HDF5 file format
// specification, III.E) is damaged. It is the one structure of our files without a checksum, and
// the library (1.10.8) follows its pointers unchecked. Checks the whole file up to 64 MB. Of a
// larger one the first and the last 16 MB, where our writer puts its strings. Also false when
// `visit`, which reads the file by the library, crashes in a process of its own. Some structures of
// other programs' files have no checksums either. Both run once for a file, and `visit` again for
// the first `whole` reading.
bool is_sound(const std::filesystem::path& file, bool whole, const std::function<void()>& visit);

}  // namespace cbr::hdf5
