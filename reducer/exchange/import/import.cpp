// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/exchange/import/import.hpp"

#include <optional>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/files/checked_files.hpp"
#include "common/files/output_file.hpp"
#include "common/scene/scene.hpp"
#include "common/superelement/superelement_file.hpp"
#include "reducer/domains/domains.hpp"
#include "reducer/judgement/accuracy.hpp"
#include "reducer/modes/diagonal_form.hpp"

namespace cbr {
namespace {

// Of the format and the bytes of all files: the same inputs, the same hash.
std::string hash_of(const std::string& format, const std::vector<std::filesystem::path>& files) {
  std::string text = "cbr import 1 " + format + "\n";
  for (const auto& file : files) text += file_hash(file) + "\n";
  return bytes_hash(text);
}

void refuse_to_replace(const std::filesystem::path& target,
                       const std::vector<std::filesystem::path>& inputs) {
  for (const auto& input : inputs) {
    if (is_same_file(target, input))
      throw InputError(input.string() + ": --import would replace it: name another file with -o");
  }
  refuse_other_file(target, superelement_kind(), "the superelement", "give -o another name");
}

std::optional<Mesh> mesh_of(const ImportOptions& options, bool is_needed, Report& report) {
  if (options.faces.empty()) {
    if (is_needed)
      throw InputError(options.file.string() + ": --import " + options.format +
                       " needs --faces MESH: the file has no coordinates");
    return {};
  }
  const auto phase = report.phase("reading the mesh");
  return read_mesh(options.faces);
}

void add_mesh(const Mesh& mesh, const ImportOptions& options, Superelement& s, Report& report) {
  add_faces(mesh, options.faces.string(), options.file.string(), s);
  if (s.n() > options.diagonal_limit) return;
  const auto phase = report.phase("diagonal form");
  try {
    const bool has_points = std::any_of(s.dof_component.begin(), s.dof_component.end(),
                                        [](int component) { return component > 2; });
    add_diagonal_form(
        s, has_points ? std::vector<Index>(s.node_ids.size(), 0) : parts_of(mesh, s.node_ids));
  } catch (const InputError& error) {
    throw InputError(options.file.string() + ": " + error.what());
  }
}

void summarise(const Superelement& s, const ImportOptions& options, const std::string& users,
               Report& report) {
  report.line("imported " + options.file.string() + " (" + users + "): " + std::to_string(s.n()) +
              " coordinates, " + std::to_string(s.c()) + " of the interface (" +
              std::to_string(s.node_ids.size()) + " nodes), " + std::to_string(s.k()) + " modes");
  const RigidBody& body = s.rigid_body;
  report.line("  mass         " + number_text(body.mass) + ", centre (" +
              number_text(body.center(0)) + ", " + number_text(body.center(1)) + ", " +
              number_text(body.center(2)) + "), by the rigid motions of the interface");
  report.line("  sets         " + sets_text(s));
  report.line("  file         " + options.target.string());
}

}  // namespace

void import_superelement(const ImportOptions& options, Report& report) {
  UnchangedFiles inputs;
  ImportedMatrices imported;
  {
    const auto phase = report.phase("reading the matrices");
    imported = import_matrices(options.format, options.file);
  }
  if (imported.reduced.has_damping)
    report.warning(options.file.string() +
                   ": its damping matrix is left out, as superelements have none: give the "
                   "instance damping");
  if (imported.reduced.has_recovery)
    report.warning(
        options.file.string() +
        ": its OTM is left out: the superelement has no recovery of the interior, so that "
        "fields and stress show the interface alone");
  std::vector<std::filesystem::path> files = imported.files;
  if (!options.faces.empty())
    for (const auto& file : mesh_files(options.faces)) files.push_back(file);
  refuse_to_replace(options.target, files);
  { const TemporaryFile probe(options.target); }  // finds an unwritable file before the work
  for (const auto& file : files) inputs.add(file);
  const std::optional<Mesh> mesh = mesh_of(options, imported.needs_mesh, report);
  if (imported.needs_mesh)
    place_rows(*mesh, options.faces.string(), options.file.string(), imported.reduced);
  std::vector<std::string> doubts;
  Superelement s = superelement_of(imported.reduced, options.file.string(), doubts);
  for (const std::string& doubt : doubts) report.warning(doubt);
  imported.reduced = {};  // as large as the superelement
  if (mesh) add_mesh(*mesh, options, s, report);
  s.content_hash = hash_of(options.format, files);
  s.provenance["import"] = options.format;
  s.provenance["import_file"] = options.file.filename().string();
  if (!options.faces.empty()) s.provenance["faces"] = options.faces.filename().string();
  inputs.check();
  {
    const auto phase = report.phase("writing the superelement");
    write_superelement(s, options.target);
  }
  if (options.faces.empty() && s.nodesets.empty())
    report.warning(
        options.file.string() +
        ": a file of matrices names no faces and no sets, so that contact, supports and loads " +
        "cannot find any in the superelement: give --faces MESH");
  summarise(s, options, imported.users, report);
}

namespace {

struct ImportFormat {
  std::string name;
  std::string users;                  // for messages
  std::vector<std::string> suffixes;  // of the files that are read; none: one file of any name
  ReducedMatrices (*read)(const std::filesystem::path& file_or_stem);
  bool needs_mesh = false;  // its files have no coordinates
  // of Nastran's EXTSEOUT, instead of the table; then these are read
  std::vector<std::string> external = {};
};

// A new format is one entry here and a file of its own.
const std::vector<ImportFormat>& formats() {
  static const std::vector<ImportFormat> all = {
      {"sierra", "Sierra/SD", {}, read_sierra},
      {"matrix-market", "Matrix Market", {".K.mtx", ".M.mtx", ".dofs.csv"}, read_matrix_market},
      {"dmig", "Nastran DMIG", {".dmig", ".dofs.csv"}, read_dmig, false, {".pch"}},
      {"op4", "Nastran OUTPUT4", {".op4", ".dofs.csv"}, read_op4, false, {".op4", ".pch", ".asm"}},
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
  std::vector<std::string> suffixes = format.suffixes;
  suffixes.insert(suffixes.end(), format.external.begin(), format.external.end());
  for (const std::string& suffix : suffixes) {
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
  std::vector<std::string> suffixes = format.suffixes, external;
  for (const std::string& suffix : format.external)
    if (std::filesystem::exists(stem + suffix)) external.push_back(suffix);
  const bool has_table = !suffixes.empty() && std::filesystem::exists(stem + suffixes.back());
  if (!has_table && !external.empty() && external.back() != suffixes.front()) suffixes = external;
  for (const std::string& suffix : suffixes) {
    imported.files.emplace_back(stem + suffix);
    if (!std::filesystem::exists(imported.files.back()))
      throw InputError(imported.files.back().string() + ": no such file: --import " + name +
                       " reads " + join(format.suffixes) + " of one name" +
                       (format.needs_mesh ? "" : ", as --export writes them") +
                       (format.external.empty() ? "" : ", or files of Nastran's EXTSEOUT"));
  }
  if (format.suffixes.empty()) imported.files.push_back(file);
  imported.reduced = format.read(stem);
  return imported;
}

}  // namespace cbr
