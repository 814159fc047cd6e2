// SPDX-License-Identifier: GPL-3.0-or-later

#include <ostream>
#include <sstream>
#include <string>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/superelement/superelement_file.hpp"
#include "common/superelement/superelement_group.hpp"
#include "reducer/command.hpp"
#include "reducer/judgement/accuracy.hpp"

namespace cbr {
namespace {

void print_made_of(const std::map<std::string, std::string>& provenance, std::ostream& out) {
  for (const auto& [key, value] : provenance)
    if (key != "mesh_hash")
      out << "  made of      " << key << (key.starts_with("block ") ? " " : ": ") << value << '\n';
}

void print_body(const RigidBody& b, std::ostream& out) {
  const Matrix3& I = b.inertia;
  out << format_text("  mass         %.9g, centre (%.6g, %.6g, %.6g)\n", b.mass, b.center(0),
                     b.center(1), b.center(2))
      << format_text("  inertia      xx %.6g  yy %.6g  zz %.6g  xy %.6g  yz %.6g  xz %.6g\n",
                     I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(1, 2), I(0, 2));
}

void print_lines(const std::vector<SummaryLine>& lines, std::ostream& out) {
  for (const SummaryLine& line : lines)
    if (!line.detail) out << line.text << '\n';
}

void print_superelement(const Hdf5Reader& file, std::ostream& out) {
  const Superelement s = read_superelement(file.file(), {false, true, false});
  print_made_of(s.provenance, out);
  out << "  basis        " << s.basis << '\n'
      << "  dofs         " << s.n_coordinates() << ": " << s.c() << " of the interface ("
      << s.node_ids.size() << " nodes), " << s.k() << " modes"
      << (s.has_diagonal_form() ? ", with diagonal form" : "") << '\n';
  print_lines(frequency_lines(s), out);
  if (s.spin_moments.size() > 0) {
    out << "  turns        with centrifugal forces"
        << (s.spin_couplings.size() > 0
                ? format_text(", and Coriolis forces of the %td lowest elastic modes",
                              s.spin_couplings.rows() / 3)
                : ", without Coriolis forces")
        << '\n';
  }
  // The compliance itself may fill the memory, so the nodes are read alone.
  const std::string nodes = "/characteristic/statics/node";
  if (file.has(nodes))
    print_lines(statics_lines(file.read_indices(nodes), file.has("/characteristic/statics/levels")),
                out);
  out << "  sets kept    " << sets_text(s) << '\n';
  print_body(s.rigid_body, out);
  print_lines(accuracy_lines(s), out);
  if (!s.accuracy) out << "  errors       not in the file\n";
}

void print_group(const Hdf5Reader& file, std::ostream& out) {
  const SuperelementGroup group = read_superelement_group(file.file(), {false, true, false});
  JoinedNodes joined = join_nodes(group);
  Superelement described;
  described.omega = group.omega;
  described.surfaces = std::move(joined.surfaces);
  described.nodesets = std::move(joined.nodesets);
  Index k = 0;
  for (const Superelement& domain : group.domains) k += domain.k();
  const auto c = 3 * static_cast<Index>(joined.node_ids.size());
  print_made_of(group.provenance, out);
  out << "  dofs         " << k + c << ": " << c << " of nodes, " << k << " modes of "
      << group.domains.size() << " domains\n";
  print_lines(frequency_lines(described), out);
  out << "  sets kept    " << sets_text(described) << '\n';
  print_body(group.rigid_body, out);
  out << "  errors       of what domains make together are not estimated\n";
}

// "  instances    left, right" when the file has any.
void print_children(const Hdf5Reader& file, const char* label, const std::string& group,
                    std::ostream& out) {
  if (file.has(group)) out << label << join(file.children(group)) << '\n';
}

void print_times(const Hdf5Reader& file, const std::string& dataset, std::ostream& out) {
  if (!file.has(dataset)) return;
  const Vector t = file.read_vector(dataset);
  out << "  outputs      " << t.size();
  if (t.size() > 0) out << format_text(", from t = %.6g to %.6g s", t(0), t(t.size() - 1));
  out << '\n';
}

std::string frequencies_text(const Vector& hz) {
  constexpr Index most = 10;
  std::string text;
  for (Index i = 0; i < std::min(hz.size(), most); ++i)
    text += (i > 0 ? ", " : "") + format_text("%.6g", hz(i));
  return text + (hz.size() > most ? format_text(", ..., %.6g Hz", hz(hz.size() - 1)) : " Hz");
}

// Those of modes, since 1.4, are shapes.
void print_fields(const Hdf5Reader& file, std::ostream& out) {
  if (!file.has("/frequency_hz")) return print_times(file, "/times", out);
  const Vector hz = file.read_vector("/frequency_hz");
  out << "  modes        " << hz.size() << ": " << frequencies_text(hz) << '\n';
}

void print_modes(const Hdf5Reader& file, std::ostream& out) {
  for (const std::string& name : file.children("/instances"))
    out << "  modes        " << name << ": "
        << frequencies_text(file.read_vector("/instances/" + name + "/frequency_hz")) << '\n';
}

// Results since 1.8 have those of the run.
void print_warnings(const Hdf5Reader& file, std::ostream& out) {
  if (!file.has_attribute("/", "warnings")) return;
  std::istringstream lines(file.read_string("/", "warnings"));
  for (std::string line; std::getline(lines, line);) out << "  warning      " << line << '\n';
}

void print_results(const Hdf5Reader& file, std::ostream& out) {
  print_times(file, "/time", out);
  out << "  run          " << file.read_index("/", "steps") << " steps, "
      << file.read_index("/", "n_dofs") << " dofs";
  if (file.has_attribute("/", "partial") && file.read_index("/", "partial") != 0)
    out << "; stopped by a signal before its end";
  out << '\n';
  print_warnings(file, out);
  print_children(file, "  instances    ", "/instances", out);
  print_children(file, "  surfaces     ", "/surfaces", out);
  if (!file.has("/energy/total")) return;
  const Vector energy = file.read_vector("/energy/total");
  if (energy.size() > 0)
    out << format_text("  energy       %.9g at the start, %.9g at the end\n", energy(0),
                       energy(energy.size() - 1));
}

void print_checkpoint(const Hdf5Reader& file, std::ostream& out) {
  out << format_text("  reached      t = %.9g s", file.read_scalar("/time")) << ", step "
      << file.read_index("/", "step") << '\n'
      << "  use          cbr-dyn SCENE -o RESULTS --restart " << file.file().string() << '\n';
}

// InputError: a checksum does not match.
void print_head(const Hdf5Reader& file, const std::string& what, std::ostream& out) {
  const ComparedChecksums compared = file.compare_checksums("/");
  std::error_code error;
  const auto size = std::filesystem::file_size(file.file(), error);
  const auto text = [&](const char* attribute) {
    return file.has_attribute("/", attribute) ? file.read_string("/", attribute)
                                              : std::string("unknown");
  };
  out << file.file().string() << ": " << what << ", format " << text("format_version") << ", by "
      << text("generator") << (error ? "" : ", " + human_bytes(static_cast<double>(size))) << '\n';
  out << "  checksums    "
      << (compared.datasets == 0
              ? "none: written by a version without them, or by a script"
              : "match in " + std::to_string(compared.datasets) + " datasets" +
                    (compared.without > 0 ? "; " + std::to_string(compared.without) + " have none"
                                          : ""))
      << '\n';
}

struct Kind {
  const char *format, *words;
  void (*print)(const Hdf5Reader& file, std::ostream& out);
};

const Kind kinds[] = {
    {superelement_format, "a superelement", print_superelement},
    {superelement_group_format, "a group of superelements that share nodes", print_group},
    {"cbr-results", "results of a run", print_results},
    {"cbr-checkpoint", "a checkpoint of a run", print_checkpoint},
    {"cbr-fields", "fields (open the .xdmf beside it)", print_fields},
    {"cbr-modes", "modes of a scene", print_modes},
    {"cbr-sweep", "harmonic response of a scene", [](const auto& file, auto& out) {
       print_children(file, "  surfaces     ", "/surfaces", out);
     }}};

}  // namespace

void print_info(const std::filesystem::path& path, std::ostream& out) {
  const Hdf5Reader file(path);
  if (!file.has_attribute("/", "format"))
    throw InputError(path.string() + ": has no attribute 'format': it was not written by cbr");
  const std::string format = file.read_string("/", "format");
  for (const Kind& kind : kinds) {
    if (format != kind.format) continue;
    print_head(file, kind.words, out);
    return kind.print(file, out);
  }
  throw InputError(path.string() + ": format '" + format +
                   "' found, known: superelements, groups of them, results, fields, checkpoints, "
                   "modes and sweeps of cbr");
}

}  // namespace cbr
