// SPDX-License-Identifier: GPL-3.0-or-later
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <system_error>

#include "common/base/error.hpp"
#include "common/files/checked_files.hpp"
#include "common/files/output_file.hpp"
#include "common/mesh/io/deck_lines.hpp"
#include "common/mesh/io/mesh_formats.hpp"

namespace cbr {
namespace {

// other: what the program gmsh converts
enum class Format { none, gmsh, exodus, abaqus, nastran, med, other };

std::string suffix_of(const std::filesystem::path& file) {
  std::string suffix = file.extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return suffix;
}

Format format_of(const std::filesystem::path& file) {
  const std::string suffix = suffix_of(file);
  if (suffix == ".msh") return Format::gmsh;
  for (const char* known : {".exo", ".e", ".g", ".ncf", ".nc4", ".nc", ".exoii", ".ex2"})
    if (suffix == known) return Format::exodus;
  if (suffix == ".inp") return Format::abaqus;
  if (suffix == ".bdf" || suffix == ".nas") return Format::nastran;
  if (suffix == ".med") return Format::med;
  if (suffix == ".unv" || suffix == ".vtk") return Format::other;
  return Format::none;
}

// CalculiX's pre-processor calls its decks .msh, too.
Format found_format(const std::filesystem::path& file) {
  std::error_code error;
  const Format format = format_of(file);
  if (format != Format::gmsh || !std::filesystem::is_regular_file(file, error)) return format;
  TextLines lines(file, true);
  while (lines.next())
    if (const auto text = trimmed(lines.line()); !text.empty())
      return text.starts_with('*') ? Format::abaqus : Format::gmsh;
  return format;
}

DeckLines::Kind deck_kind(const std::filesystem::path& deck) {
  return found_format(deck) == Format::abaqus ? DeckLines::Kind::inp : DeckLines::Kind::bdf;
}

Format known_format(const std::filesystem::path& file) {
  const Format format = format_of(file);
  if (const std::string cure = foreign_mesh_cure(file); !cure.empty())
    throw InputError(file.string() + ": " + cure);
  if (format == Format::none)
    throw InputError(file.string() +
                     ": a mesh's name ends in .msh (gmsh), .exo .e .g .ncf .nc4 (Exodus II), .inp "
                     "(Abaqus, CalculiX), " +
                     ".bdf .nas (Nastran), .med (Salome), .unv or .vtk, not in '" +
                     file.extension().string() + "'");
  return format;
}

Format written_format(const std::filesystem::path& file) {
  const Format format = known_format(file);
  if (!is_written_mesh_name(file))
    throw InputError(
        file.string() +
        ": meshes are written as .msh (gmsh) or .exo (Exodus II): give it another suffix");
  return format;
}

Mesh read(const std::filesystem::path& file, Format format) {
  static const std::map<Format, Mesh (*)(const std::filesystem::path&)> readers = {
      {Format::gmsh, read_gmsh},
      {Format::exodus, read_exodus},
      {Format::abaqus, read_abaqus_mesh},
      {Format::nastran, read_nastran_mesh},
      {Format::med, read_med},
      {Format::other, read_with_gmsh}};
  return readers.at(format)(file);
}

std::array<Index, 4> key_of(const std::vector<Index>& corners) {
  std::array<Index, 4> key = {-1, -1, -1, -1};
  std::copy(corners.begin(), corners.end(), key.begin());
  std::sort(key.begin(), key.end());
  return key;
}

// Whether two faces of the same corners run around in the same sense.
bool same_sense(const std::vector<Index>& a, const std::vector<Index>& b) {
  const auto start = std::find(b.begin(), b.end(), a[0]) - b.begin();
  return b[(static_cast<std::size_t>(start) + 1) % b.size()] == a[1];
}

std::vector<Index> corners_of(const Mesh& mesh, const Side& side) {
  auto nodes = nodes_of_side(mesh, side);
  const auto type = mesh.blocks[side.block].type;
  nodes.resize(n_corners(side_kind(type, side.side)));
  return nodes;
}

}  // namespace

std::string foreign_mesh_cure(const std::filesystem::path& file) {
  const std::string suffix = suffix_of(file), name = file.stem().string();
  if (is_among(".vtu .cdb .fem .xdmf .mesh .dat", suffix))
    return "is not of a format that is read: convert it to gmsh's .msh or to Exodus II with names "
           "for the faces; meshio knows most formats (meshio convert " +
           file.filename().string() + " " + name + ".exo)";
  if (is_among(".geo .step .stp .iges .igs .brep .stl", suffix))
    return "is a geometry and no mesh: mesh it first (gmsh -3 " + file.filename().string() +
           " -o " + name +
           ".msh), with a Physical Volume for the part and a Physical Surface for each face";
  return "";
}

bool is_mesh_name(const std::filesystem::path& file) { return format_of(file) != Format::none; }

bool is_written_mesh_name(const std::filesystem::path& file) {
  const Format format = format_of(file);
  return format == Format::gmsh || format == Format::exodus;
}

bool may_hold_materials(const std::filesystem::path& file) {
  const Format format = found_format(file);
  return format == Format::abaqus || format == Format::nastran;
}

std::vector<std::filesystem::path> mesh_files(const std::filesystem::path& file) {
  std::error_code error;
  if (!may_hold_materials(file) || !std::filesystem::is_regular_file(file, error)) return {file};
  DeckLines lines(file, deck_kind(file));
  while (lines.next() && lines.includes()) {
  }
  return lines.files();
}

bool deck_holds(const std::filesystem::path& deck, const std::vector<std::string>& words) {
  // Most lines are data
  const auto begins_one = [&](char c) {
    return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
      return word[0] == std::toupper(static_cast<unsigned char>(c));
    });
  };
  DeckLines lines(deck, deck_kind(deck));
  while (lines.next()) {
    const std::string_view line = trimmed(lines.line());
    if (line.empty() || !begins_one(line[0])) continue;
    const std::string start = without_blanks(in_capitals(line.substr(0, 40)));
    for (const std::string& word : words)
      if (start.starts_with(word)) return true;
  }
  return false;
}

Mesh read_mesh(const std::filesystem::path& file) {
  known_format(file);
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (status.type() == std::filesystem::file_type::not_found)
    throw InputError(file.string() + ": no such file: give the path of a mesh");
  if (!std::filesystem::exists(status))
    throw InputError(file.string() + ": cannot be opened: " + error.message());
  if (!std::filesystem::is_regular_file(status))
    throw InputError(file.string() + ": is not a regular file: give the path of a mesh");
  if (access(file.c_str(), R_OK) != 0)
    throw InputError(file.string() + ": is not readable: check its permissions");
  Mesh mesh = read(file, found_format(file));
  check_mesh(mesh, file.string());
  return mesh;
}

void refuse_other_mesh(const std::filesystem::path& file, const std::string& what,
                       const std::string& cure) {
  refuse_other_file(file,
                    written_format(file) == Format::gmsh
                        ? FileKind{.noun = "a gmsh mesh", .start = gmsh_mark}
                        : FileKind{.noun = "an Exodus II mesh", .netcdf_title = exodus_mesh_title},
                    what, cure);
}

void write_mesh(const Mesh& mesh, const std::filesystem::path& file) {
  const Format format = written_format(file);
  check_mesh(mesh, file.string());
  TemporaryFile temporary(file);
  format == Format::gmsh ? write_gmsh(mesh, temporary.path(), file.string())
                         : write_exodus(mesh, temporary.path(), file.string());
  temporary.commit();
}

SideLookup::SideLookup(const Mesh& mesh, const std::vector<bool>& wanted) : mesh_(mesh) {
  for (Index b = 0; b < static_cast<Index>(mesh.blocks.size()); ++b) {
    const Block& block = mesh.blocks[b];
    for (Index e = 0; e < block.connectivity.rows(); ++e)
      for (int s = 1; s <= n_sides(block.type); ++s) {
        const auto& local = side_nodes(block.type, s);
        const bool all =
            std::all_of(local.begin(), local.begin() + n_corners(side_kind(block.type, s)),
                        [&](int i) { return wanted[block.connectivity(e, i)]; });
        if (all) entries_.push_back({key_of(corners_of(mesh, {b, e, s})), {b, e, s}});
      }
  }
  std::stable_sort(entries_.begin(), entries_.end(),
                   [](const Entry& a, const Entry& b) { return a.key < b.key; });
}

Side SideLookup::find(const std::vector<Index>& corners) const {
  const auto key = key_of(corners);
  const auto first =
      std::lower_bound(entries_.begin(), entries_.end(), key,
                       [](const Entry& a, const auto& wanted) { return a.key < wanted; });
  if (first == entries_.end() || first->key != key) return {-1, -1, 0};
  for (auto entry = first; entry != entries_.end() && entry->key == key; ++entry)
    if (same_sense(corners, corners_of(mesh_, entry->side))) return entry->side;
  return first->side;
}

}  // namespace cbr
