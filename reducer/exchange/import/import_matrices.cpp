// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/exchange/import/import_matrices.hpp"

#include "common/base/error.hpp"
#include "reducer/exchange/import/import_formats.hpp"

namespace cbr {
namespace {

struct ImportFormat {
  std::string name;
  std::string users;                  // for messages
  std::vector<std::string> suffixes;  // of the files that are read; none: one file of any name
  ReducedMatrices (*read)(const std::filesystem::path& file_or_stem);
  bool needs_mesh = false;  // its files have no coordinates
};

// A new format is one entry here and a file of its own.
const std::vector<ImportFormat>& formats() {
  static const std::vector<ImportFormat> all = {
      {"sierra", "Sierra/SD", {}, read_sierra},
      {"matrix-market", "Matrix Market", {".K.mtx", ".M.mtx", ".dofs.csv"}, read_matrix_market},
      {"dmig", "Nastran DMIG", {".dmig", ".dofs.csv"}, read_dmig},
      {"op4", "Nastran OUTPUT4", {".op4", ".dofs.csv"}, read_op4},
      {"abaqus",
       "Abaqus *MATRIX INPUT",
       {".K.abaqus.mtx", ".M.abaqus.mtx", ".dofs.csv"},
       read_abaqus},
      {"mtx",
       "CalculiX *MATRIX ASSEMBLE",
       {".K.ccx.mtx", ".M.ccx.mtx", ".dofs.csv"},
       read_calculix},
      {"substructure", "*SUBSTRUCTURE MATRIX OUTPUT", {}, read_substructure, true},
      {"matrix-storage",
       "CalculiX SOLVER=MATRIXSTORAGE",
       {".sti", ".mas", ".dof"},
       read_matrix_storage,
       true},
  };
  return all;
}

const ImportFormat& format_named(const std::string& name) {
  for (const ImportFormat& format : formats()) {
    if (format.name == name) return format;
  }
  throw InputError("--import: '" + name + "' found, " + join(import_format_names()) + " allowed");
}

// The names' common beginning, from one of the names.
std::string stem_of(const ImportFormat& format, const std::string& file) {
  for (const std::string& suffix : format.suffixes) {
    if (file.ends_with(suffix)) return file.substr(0, file.size() - suffix.size());
  }
  return file;
}

}  // namespace

std::vector<std::string> import_format_names() {
  std::vector<std::string> names;
  for (const ImportFormat& format : formats()) names.push_back(format.name);
  return names;
}

ImportedMatrices import_matrices(const std::string& name, const std::filesystem::path& file) {
  const ImportFormat& format = format_named(name);
  const std::string stem = stem_of(format, file.string());
  ImportedMatrices imported;
  imported.users = format.users;
  imported.needs_mesh = format.needs_mesh;
  for (const std::string& suffix : format.suffixes) {
    imported.files.emplace_back(stem + suffix);
    if (!std::filesystem::exists(imported.files.back()))
      throw InputError(imported.files.back().string() + ": no such file: --import " + name +
                       " reads " + join(format.suffixes) + " of one name" +
                       (format.needs_mesh ? "" : ", as --export writes them"));
  }
  if (format.suffixes.empty()) imported.files.push_back(file);
  imported.reduced = format.read(stem);
  return imported;
}

}  // namespace cbr
