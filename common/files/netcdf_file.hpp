// SPDX-License-Identifier: GPL-3.0-or-later
// RAII over the netCDF C library: classic, 64-bit offset and netCDF-4 files. The only code that
// includes netcdf.h is netcdf_file.cpp.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// InputError "FILE: variable: ..." for a variable that is missing, of the wrong shape or type, or
// not readable (damaged, cut short).
class NetcdfReader {
 public:
  explicit NetcdfReader(const std::filesystem::path& file);
  ~NetcdfReader();
  NetcdfReader(const NetcdfReader&) = delete;
  NetcdfReader& operator=(const NetcdfReader&) = delete;

  const std::string& where() const { return where_; }
  Index dimension(const std::string& name) const;  // 0 when there is none, as Exodus II means it
  bool has(const std::string& variable) const;
  std::vector<Index> shape(const std::string& variable) const;
  std::vector<Index> integers(const std::string& variable) const;  // row-major
  std::vector<double> reals(const std::string& variable) const;    // row-major
  // rows of characters, without trailing blanks and zeros
  std::vector<std::string> strings(const std::string& variable) const;
  // "" when there is none; variable "": of the file
  std::string text(const std::string& variable, const std::string& attribute) const;

 private:
  int variable_id(const std::string& variable) const;
  Index n_values(const std::string& variable) const;
  void check(int status, const std::string& what) const;
  std::string where_;
  double most_ = 0;  // values of one variable, by the size of the file
  int file_ = -1;
};

// Writes the 64-bit offset format. Definitions first, then end_definitions(), then values, then
// close(). RunError when the disk refuses. The same calls give the same bytes.
class NetcdfWriter {
 public:
  NetcdfWriter(const std::filesystem::path& file, std::string where);
  ~NetcdfWriter();
  NetcdfWriter(const NetcdfWriter&) = delete;
  NetcdfWriter& operator=(const NetcdfWriter&) = delete;

  // variable "": of the file
  void attribute(const std::string& variable, const std::string& name, const std::string& value);
  void attribute(const std::string& name, int value);
  void attribute(const std::string& name, float value);
  // 0: unlimited
  void dimension(const std::string& name, Index size);
  // 32 bits
  void define_integers(const std::string& variable, const std::vector<std::string>& dimensions);
  void define_reals(const std::string& variable, const std::vector<std::string>& dimensions);
  void define_text(const std::string& variable, const std::vector<std::string>& dimensions);
  void end_definitions();
  // InputError when one does not fit 32 bits
  void write(const std::string& variable, const std::vector<Index>& values);
  void write(const std::string& variable, const std::vector<double>& values);
  // padded with zeros
  void write(const std::string& variable, const std::vector<std::string>& values, Index width);
  // At one place of the variable's first, unlimited dimension.
  void write_record(const std::string& variable, Index record, const std::vector<double>& values);
  void close();

 private:
  void define(const std::string& variable, int type, const std::vector<std::string>& dimensions);
  int variable_id(const std::string& variable) const;
  void check(int status, const std::string& what) const;
  std::string where_;
  int file_ = -1;
};

}  // namespace cbr
