// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/exchange/export/export_formats.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <memory>
#include <numbers>
#include <ostream>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/files/checked_files.hpp"
#include "common/files/output_file.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/exchange/reduced_matrices.hpp"

namespace cbr {
namespace {

using WriteText = void (*)(const ReducedMatrices& reduced, std::ostream& out);

void write_through(const std::filesystem::path& file,
                   const std::function<void(std::ostream&)>& write) {
  std::ofstream out(file);
  write(out);
  out.close();
  if (!out) throw RunError("cannot be written");
}

constexpr const char *our_comment = "superelement of cbr|Craig-Bampton superelement",
                     *table_header = "row,node,dof,x,y,z,frequency_hz\n",
                     *table_suffix = ".dofs.csv", *interface_suffix = ".interface.csv";

ExportFile stream_file(const std::string& suffix, WriteText write,
                       const std::string& start = our_comment) {
  return {suffix,
          [write](const ReducedMatrices& reduced, const std::filesystem::path& file,
                  const std::string&) {
            write_through(file, [&](std::ostream& out) { write(reduced, out); });
          },
          start, start == our_comment};
}

// The first entry is on the diagonal.
ExportFile abaqus_file(const std::string& suffix, WriteText write) {
  return stream_file(suffix, write, R"(^(\d+), (\d+), \1, \2, [-+.e\d]+\n)");
}

ExportFile op4_file(WriteText write) {
  return stream_file(".op4", write, "KAAX    (1P,3E24\\.16\n|\x18)");
}

ExportFile calculix_input_file() {
  return {".ccx.inp",
          [](const ReducedMatrices& reduced, const std::filesystem::path& file,
             const std::string& name) {
            write_through(file,
                          [&](std::ostream& out) { write_calculix_input(reduced, name, out); });
          },
          our_comment};
}

ExportFile sierra_file(bool is_newer) {
  return {
      ".nc",
      [is_newer](const ReducedMatrices& reduced, const std::filesystem::path& file,
                 const std::string& name) { write_sierra(reduced, is_newer, file, name + ".nc"); },
      "^CDF", false};
}

ExportFile of_modal(ExportFile file) {
  file.is_modal = true;
  return file;
}

// A new format is one entry here and a file of its own.
const std::vector<ExportFormat>& formats() {
  static const std::vector<ExportFormat> all = {
      {"matrix-market",
       "SciPy, MATLAB, Julia",
       {stream_file(".K.mtx", write_matrix_market_K), stream_file(".M.mtx", write_matrix_market_M),
        of_modal(stream_file(".T.mtx", write_matrix_market_T))},
       true},
      {"dmig", "Nastran, MYSTRAN", {stream_file(".dmig", write_dmig)}, true},
      {"op4", "Nastran (OUTPUT4, text)", {op4_file(write_op4)}, true},
      {"op4-binary", "Nastran (OUTPUT4, binary)", {op4_file(write_op4_binary)}, true},
      {"abaqus",
       "Abaqus *MATRIX INPUT",
       {abaqus_file(".K.abaqus.mtx", write_abaqus_K),
        abaqus_file(".M.abaqus.mtx", write_abaqus_M)}},
      {"mtx",
       "CalculiX *MATRIX ASSEMBLE",
       {abaqus_file(calculix_K, write_calculix_stiffness), abaqus_file(calculix_M, write_abaqus_M),
        calculix_input_file()},
       true},
      {"sierra", "Sierra/SD", {sierra_file(true)}},
      {"sierra-older", "Sierra/SD (older layout)", {sierra_file(false)}},
  };
  return all;
}

const ExportFormat& format_named(const std::string& name) {
  for (const ExportFormat& format : formats()) {
    if (format.name == name) return format;
  }
  throw InputError("--export: '" + name + "' found, " + join(export_format_names()) + " allowed");
}

void write_table(const std::vector<ReducedRow>& rows, const Matrix& M, std::ostream& out) {
  out << table_header;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const ReducedRow& row = rows[i];
    out << i + 1 << ',' << row.node << ',' << row.dof << ',';
    if (row.dof > 0) {
      out << format_text("%.17g,%.17g,%.17g,\n", row.position(0), row.position(1), row.position(2));
    } else if (M(static_cast<Index>(i), static_cast<Index>(i)) == 0) {
      out << ",,,\n";
    } else {
      out << format_text(",,,%.17g\n",
                         std::sqrt(std::max(row.eigenvalue, 0.0)) / (2 * std::numbers::pi));
    }
  }
}

[[noreturn]] void refuse_modal(const Superelement& s, const ExportFormat& format) {
  std::vector<std::string> others;
  for (const ExportFormat& other : formats())
    if (other.takes_modal) others.push_back(other.name);
  throw InputError("basis " + s.basis + " found, whose interface follows modes: " + format.name +
                   " has no form of this: take " + join(others) +
                   ", or reduce with basis: craig-bampton");
}

struct Output {
  std::filesystem::path path;
  FileKind kind;
  std::function<void(const std::filesystem::path& file)> write;
};

// Filled beside their targets, and put in place when the last is whole.
void write_all(const std::vector<Output>& outputs) {
  std::vector<std::unique_ptr<TemporaryFile>> files;
  for (const Output& output : outputs) {
    files.push_back(std::make_unique<TemporaryFile>(output.path));
    try {
      output.write(files.back()->path());
    } catch (const RunError& error) {
      throw RunError(output.path.string() + ": " + error.what());
    }
  }
  for (const auto& file : files) file->commit();
}

}  // namespace

std::vector<std::string> export_format_names() {
  std::vector<std::string> names;
  for (const ExportFormat& format : formats()) names.push_back(format.name);
  return names;
}

void export_superelement(const std::string& name, const std::filesystem::path& file,
                         const std::filesystem::path& target, Index first_modal_node,
                         Report& report) {
  const ExportFormat& format = format_named(name);
  const Superelement s = read_superelement(file);
  const ReducedMatrices reduced = [&] {
    try {
      if (!s.has_interface_matrices() && !format.takes_modal) refuse_modal(s, format);
      return reduced_matrices(s, first_modal_node);
    } catch (const InputError& error) {
      throw InputError(file.string() + ": --export: " + error.what());
    }
  }();
  const std::filesystem::path table = target.string() + table_suffix;
  std::vector<Output> outputs;
  for (const ExportFile& part : format.files) {
    if (part.is_modal && reduced.interface.empty()) continue;
    FileKind kind{.noun = "an export for " + format.users, .start = part.start};
    if (!part.has_mark) kind.beside = {table};
    outputs.push_back({target.string() + part.suffix, kind, [&](const std::filesystem::path& out) {
                         part.write(reduced, out, target.filename().string());
                       }});
  }
  const auto add_table = [&](const std::filesystem::path& path,
                             const std::vector<ReducedRow>& rows) {
    if (!rows.empty())
      outputs.push_back(
          {path,
           {.noun = "a table of rows", .start = "^" + std::string(table_header)},
           [&](const std::filesystem::path& out) {
             write_through(out, [&](std::ostream& text) { write_table(rows, reduced.M, text); });
           }});
  };
  add_table(table, reduced.rows);
  add_table(target.string() + interface_suffix, reduced.interface);
  for (const Output& output : outputs) {
    if (is_same_file(output.path, file))
      throw InputError(file.string() + ": --export would replace it: name another file with -o");
    refuse_other_file(output.path, output.kind, "--export", "name another file with -o");
  }
  write_all(outputs);
  const Index n = reduced.K.rows();
  report.line("exported " + file.string() + " for " + format.users + ": " + std::to_string(n) +
              " rows, " +
              (reduced.interface.empty()
                   ? std::to_string(s.c()) + " of the interface first, then " +
                         std::to_string(s.k()) + " modal coordinates"
                   : std::to_string(s.k()) + " modes, then " + std::to_string(n - s.k()) +
                         " residual vectors without mass; " + std::to_string(s.c()) +
                         " dofs of the interface follow them (u = T q)"));
  for (const Output& output : outputs) report.line("  file         " + output.path.string());
}

}  // namespace cbr
