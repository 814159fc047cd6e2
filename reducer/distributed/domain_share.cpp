// SPDX-License-Identifier: GPL-3.0-or-later

#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/files/output_file.hpp"
#include "common/superelement/superelement_file.hpp"
#include "reducer/distributed/processes.hpp"

namespace cbr {
namespace {

int rank_of_domain(std::size_t d, int processes) {
  return static_cast<int>(d % static_cast<std::size_t>(processes));
}

// Place of short-lived files, which pass a superelement through its writer and reader.
std::filesystem::path scratch() {
  std::error_code wrong;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(wrong);
  if (wrong)
    throw RunError(
        "TMPDIR is no folder, where domains keep files while they are reduced: set it to one");
  return folder / "cbr-domain";
}

std::string bytes_of(const Superelement& s) {
  std::string bytes;
  Hdf5Writer file(scratch());
  write_superelement_at(file, "", s);
  file.use_and_remove([&](const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
  });
  return bytes;
}

Superelement superelement_of(const std::string& bytes) {
  const TemporaryFile file(scratch());
  std::ofstream out(file.path(), std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw RunError(file.path().string() + ": the superelement of a domain was not written");
  return read_superelement(file.path());
}

// Figures of a domain for the summary, beside its superelement, as lines.
std::string text_of(const DomainFigures& f) {
  std::ostringstream text;
  text.precision(17);
  text << f.n_elements << '\n'
       << f.modes_missing << '\n'
       << f.reduction.n_interior << '\n'
       << f.reduction.factor_nonzeros << '\n'
       << f.reduction.mode_method << '\n'
       << f.reduction.mass_shift.transpose() << '\n';
  for (const std::string& warning : f.warnings) text << warning << '\n';
  return text.str();
}

DomainFigures figures_of(const std::string& text) {
  DomainFigures f;
  std::istringstream in(text);
  in >> f.n_elements >> f.modes_missing >> f.reduction.n_interior >> f.reduction.factor_nonzeros;
  std::string line;
  std::getline(in, line);  // the rest of the last number's
  std::getline(in, f.reduction.mode_method);
  std::getline(in, line);
  std::istringstream shift_line(line);
  const std::vector<double> shift(std::istream_iterator<double>(shift_line), {});
  f.reduction.mass_shift = Eigen::Map<const Vector>(shift.data(), std::ssize(shift));
  while (std::getline(in, line)) f.warnings.push_back(line);
  return f;
}

}  // namespace

DomainShare share_of_domains() {
  const ProcessNumbers numbers = process_numbers();
  const int own = numbers.own, processes = numbers.all;
  DomainShare share;
  share.is_first = own == 0;
  share.here = numbers.here;
  share.processes = processes;
  share.is_own = [=](std::size_t d) { return rank_of_domain(d, processes) == own; };
  share.together = [](const std::function<void()>& work) { together(work); };
  share.gather = [=](std::vector<Superelement>& superelements,
                     std::vector<DomainFigures>& figures) {
    for (std::size_t d = 0; d < superelements.size(); ++d) {
      const int from = rank_of_domain(d, processes);
      if (from == 0 || (own != 0 && own != from)) continue;
      if (own == from) {
        send_to_first(bytes_of(std::exchange(superelements[d], {})));
        send_to_first(text_of(figures[d]));
      } else {
        superelements[d] = superelement_of(receive(from));
        const auto condition = superelements[d].conditioning;
        figures[d] = figures_of(receive(from));
        if (condition) figures[d].reduction.condition = *condition;
      }
    }
  };
  return share;
}

}  // namespace cbr
