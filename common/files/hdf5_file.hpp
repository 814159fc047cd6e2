// SPDX-License-Identifier: GPL-3.0-or-later
// RAII over the HDF5 C library, Eigen <-> dataset. hdf5.h is included by hdf5_handle.hpp, for
// hdf5_reader.cpp and hdf5_writer.cpp, alone. Row-major in the file, without time stamps: the same
// contents give the same bytes.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// Writes to a temporary file beside `file`; commit() renames it. Without commit() nothing is left
// behind. Groups on the way are made. RunError names the path when the system refuses. Strings are
// UTF-8 of variable length, which h5py reads as str. Superblock and object headers of HDF5 1.8 and
// later: they carry checksums.
class Hdf5Writer {
 public:
  explicit Hdf5Writer(const std::filesystem::path& file);
  // Goes on with a copy of `from`, that save_copy() of a writer has made. InputError when it is
  // none.
  Hdf5Writer(const std::filesystem::path& file, const std::filesystem::path& from);
  ~Hdf5Writer();
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

  void write(const std::string& dataset, double value);          // shape (1)
  void write(const std::string& dataset, const Vector& values);  // shape (n)
  void write(const std::string& dataset, const std::vector<double>& values);
  void write(const std::string& dataset, const std::vector<Index>& values);  // int64
  void write(const std::string& dataset, const std::vector<int>& values);    // int64
  // int64, rows x columns
  void write(const std::string& dataset, const IndexTable& values);
  // rows x columns, row-major in the file
  void write(const std::string& dataset, const Matrix& values);
  // likewise, without a copy
  void write(const std::string& dataset, const RowMatrix& values);
  void write(const std::string& dataset, const Points& values);
  // From here on datasets are small in the file and slow to write (shuffle, deflate), or no longer.
  void compress(bool all);
  // From here on each dataset gets the attribute `checksum`: XXH3 (64 bit) of its numbers as they
  // are in the file, int64. Each object with texts gets `checksums_of_texts`. `digest`: of those
  // that a copy holds.
  void add_checksums(Index digest = 0);
  // add_checksums(), and the root attributes that each of our formats has.
  void start(const std::string& format, const std::string& version, const std::string& program);
  Index digest() const;  // ComparedChecksums::digest of all written; remove() does not change it
  // one more name of a dataset that is there
  void link(const std::string& dataset, const std::string& name);
  // Object "/" is the root; a group that is not there yet is made.
  void attribute(const std::string& object, const std::string& name, const std::string& value);
  void attribute(const std::string& object, const std::string& name, Index value);
  void attribute(const std::string& object, const std::string& name, double value);
  bool remove(const std::string& object);  // false: is not there
  // A whole file of the data written so far; this one stays open.
  void save_copy(const std::filesystem::path& target);
  void commit();
  // Instead of commit(): `use` reads the whole file under its temporary name, then it is gone.
  void use_and_remove(const std::function<void(const std::filesystem::path& file)>& use);

 private:
  void close();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct ComparedChecksums {
  Index datasets = 0, without = 0;  // that match; that have none
  Index digest = 0;                 // XOR of the hash of each name and checksum
};

// InputError "FILE: /dataset: ..." for a dataset that is missing, of the wrong type or shape, or
// not readable (truncated). Allocates nothing for a dataset that claims to be larger than the file
// allows. A scalar may be of shape () or (1). Checksums are verified where there are any.
class Hdf5Reader {
 public:
  // Extent of the trial in a process of its own, as damage may crash the library: all, or the
  // root's attributes for callers that read no more.
  enum class Look : char { all, root_attributes };
  explicit Hdf5Reader(const std::filesystem::path& file, Look look = Look::all);
  ~Hdf5Reader();
  Hdf5Reader(const Hdf5Reader&) = delete;
  Hdf5Reader& operator=(const Hdf5Reader&) = delete;

  const std::filesystem::path& file() const;
  bool has(const std::string& object) const;
  std::vector<std::string> children(const std::string& group) const;  // by name
  std::vector<Index> shape(const std::string& dataset) const;
  double read_scalar(const std::string& dataset) const;
  Vector read_vector(const std::string& dataset) const;
  Matrix read_matrix(const std::string& dataset) const;
  RowMatrix read_row_matrix(const std::string& dataset) const;  // without a copy
  Points read_points(const std::string& dataset) const;
  std::vector<Index> read_indices(const std::string& dataset) const;
  IndexTable read_index_table(const std::string& dataset) const;
  // A list of texts of one length, as other programs write them: strings of fixed length, or arrays
  // of bytes. With their padding.
  std::vector<std::string> read_texts(const std::string& dataset) const;
  bool has_attribute(const std::string& object, const std::string& attribute) const;
  // Those of an object, by name; none without it.
  std::map<std::string, std::string> texts(const std::string& object) const;
  std::string read_string(const std::string& object, const std::string& attribute) const;
  Index read_index(const std::string& object, const std::string& attribute) const;
  // Reads all texts and datasets of a group, tables of doubles in pieces. InputError names the
  // first that does not match.
  ComparedChecksums compare_checksums(const std::string& group) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cbr
