// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/distributed/domain_share.hpp"

#include <mpi.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
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

// For files that live as long as it takes to read them: what a superelement is made of is written
// and read in one place.
std::filesystem::path scratch() { return std::filesystem::temp_directory_path() / "cbr-domain"; }

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

// What the summary tells of a domain beside its superelement, as lines.
std::string text_of(const DomainFigures& f) {
  std::ostringstream text;
  text.precision(17);
  text << f.n_elements << '\n'
       << f.modes_missing << '\n'
       << f.reduction.n_interior << '\n'
       << f.reduction.factor_nonzeros << '\n'
       << f.reduction.mode_method << '\n';
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
  while (std::getline(in, line)) f.warnings.push_back(line);
  return f;
}

// MPI counts in 32 bits.
constexpr std::size_t piece = std::size_t{1} << 30;

void send_to_first(const std::string& bytes) {
  auto size = static_cast<long long>(bytes.size());
  MPI_Send(&size, 1, MPI_LONG_LONG, 0, 0, MPI_COMM_WORLD);
  for (std::size_t at = 0; at < bytes.size(); at += piece)
    MPI_Send(bytes.data() + at, static_cast<int>(std::min(piece, bytes.size() - at)), MPI_CHAR, 0,
             0, MPI_COMM_WORLD);
}

std::string receive_from(int rank) {
  long long size = 0;
  MPI_Recv(&size, 1, MPI_LONG_LONG, rank, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  for (std::size_t at = 0; at < bytes.size(); at += piece)
    MPI_Recv(bytes.data() + at, static_cast<int>(std::min(piece, bytes.size() - at)), MPI_CHAR,
             rank, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return bytes;
}

}  // namespace

DomainShare share_of_domains() {
  int own = 0, processes = 1, here = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &own);
  MPI_Comm_size(MPI_COMM_WORLD, &processes);
  MPI_Comm machine;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  MPI_Comm_size(machine, &here);
  MPI_Comm_free(&machine);
  DomainShare share;
  share.is_first = own == 0;
  share.here = here;
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
        superelements[d] = superelement_of(receive_from(from));
        const auto condition = superelements[d].conditioning;
        figures[d] = figures_of(receive_from(from));
        if (condition) figures[d].reduction.condition = *condition;
      }
    }
  };
  return share;
}

}  // namespace cbr
