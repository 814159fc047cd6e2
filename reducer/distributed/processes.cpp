// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/distributed/processes.hpp"

#include <slepceps.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <new>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include "common/base/error.hpp"
#include "reducer/distributed/petsc.hpp"

namespace cbr {
namespace {

// This process's number from Open MPI's mpirun, or from another launcher by PMI.
int number_in_environment(std::initializer_list<const char*> names, int otherwise) {
  for (const char* name : names)
    if (const char* text = std::getenv(name)) return std::atoi(text);
  return otherwise;
}

// Redirects the output of this process to memory from here on.
int keep_words() {
  const int voice = ::memfd_create("words", 0);
  if (voice < 0) return voice;
  const int shown = ::dup(STDERR_FILENO);
  ::dup2(voice, STDERR_FILENO);
  ::dup2(voice, STDOUT_FILENO);
  ::dup2(shown, voice);
  ::close(shown);
  return voice;
}

// Prints its last line on the former stderr.
void show_last_words(int voice, int rank) {
  std::string text(std::max<off_t>(::lseek(STDERR_FILENO, 0, SEEK_END), 0), '\0');
  const auto got = ::pread(STDERR_FILENO, text.data(), text.size(), 0);
  text.resize(std::max<ssize_t>(got, 0));
  while (!text.empty() && text.back() == '\n') text.pop_back();
  text = text.substr(text.rfind('\n') + 1) + " (in process " + std::to_string(rank) + ")\n";
  [[maybe_unused]] const auto written = ::write(voice, text.data(), text.size());
}

// True if all processes come here within `seconds`: they have failed alike.
bool all_come(double seconds) {
  MPI_Request request;
  int done = 0;
  MPI_Ibarrier(PETSC_COMM_WORLD, &request);
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (done == 0 && std::chrono::steady_clock::now() < end) {
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    if (done == 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return done != 0;
}

enum class Outcome { done, input_error, run_error };

struct Failure {
  Outcome outcome = Outcome::done;
  std::string text;
};

Failure failure_of(const std::function<void()>& work) {
  try {
    work();
    return {};
  } catch (const InputError& error) {
    return {Outcome::input_error, error.what()};
  } catch (const std::bad_alloc&) {
    return {Outcome::run_error,
            "out of memory: use more processes on more machines, or ask for less"};
  } catch (const std::exception& error) {
    return {Outcome::run_error, error.what()};
  }
}

}  // namespace

Processes::Processes() {
  rank_ = number_in_environment({"OMPI_COMM_WORLD_RANK", "PMI_RANK"}, 0);
  count_ = number_in_environment({"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}, 1);
  if (rank_ > 0) voice_ = keep_words();
}

Processes::~Processes() = default;

void Processes::start(bool asked) {
  if (count_ == 1 && !asked) return;
  // the program's own handlers leave nothing half-written
  PetscOptionsSetValue(nullptr, "-no_signal_handler", nullptr);
  petsc(SlepcInitialize(nullptr, nullptr, nullptr, nullptr));
  petsc(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr));
  is_started_ = true;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank_);
  MPI_Comm_size(PETSC_COMM_WORLD, &count_);
  if (rank_ > 0 && voice_ < 0) voice_ = keep_words();
}

int Processes::threads() const {
  const int here = process_numbers().here;
  // mpirun may have bound the process to some
  const int bound = static_cast<int>(std::thread::hardware_concurrency());
  return std::clamp(static_cast<int>(::sysconf(_SC_NPROCESSORS_ONLN)) / here, 1,
                    std::max(1, bound));
}

int Processes::end(int code) {
  // mpirun reports a process as failed that ends before MPI has begun. Here it has failed, or only
  // prints information
  if (!is_started_) return code;
  // Others may wait for this one for good: the first speaks and ends them
  const double patience = rank_ == 0 ? 2 : 5;
  if (code != 0 && !all_come(patience)) {
    if (voice_ >= 0) show_last_words(voice_, rank_);
    MPI_Abort(PETSC_COMM_WORLD, code);
  }
  // All have failed together, and the first has reported it. mpirun sends SIGTERM to the others as
  // soon as one ends: ignored, as nothing is left to report.
  if (code != 0) std::signal(SIGTERM, SIG_IGN);
  SlepcFinalize();
  return code;
}

void together(const std::function<void()>& work) {
  const Failure own = failure_of(work);
  int rank = 0, count = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &count);
  int first = own.outcome == Outcome::done ? count : rank;
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, PETSC_COMM_WORLD);
  if (first == count) return;
  int head[2] = {static_cast<int>(own.outcome), static_cast<int>(own.text.size())};
  MPI_Bcast(head, 2, MPI_INT, first, PETSC_COMM_WORLD);
  std::string text = own.text;
  text.resize(head[1]);
  MPI_Bcast(text.data(), head[1], MPI_CHAR, first, PETSC_COMM_WORLD);
  if (static_cast<Outcome>(head[0]) == Outcome::input_error) throw InputError(text);
  throw RunError(text);
}

void in_first(const std::function<void()>& work) {
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  together([&] {
    if (rank == 0) work();
  });
}

ProcessNumbers process_numbers() {
  ProcessNumbers numbers;
  MPI_Comm_rank(PETSC_COMM_WORLD, &numbers.own);
  MPI_Comm_size(PETSC_COMM_WORLD, &numbers.all);
  MPI_Comm machine;
  MPI_Comm_split_type(PETSC_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  MPI_Comm_size(machine, &numbers.here);
  MPI_Comm_free(&machine);
  return numbers;
}

namespace {

constexpr std::size_t piece = std::size_t{1} << 30;  // MPI counts in 32 bits

int piece_at(std::size_t at, const std::string& bytes) {
  return static_cast<int>(std::min(piece, bytes.size() - at));
}

}  // namespace

void send_to_first(const std::string& bytes) {
  auto size = static_cast<long long>(bytes.size());
  MPI_Send(&size, 1, MPI_LONG_LONG, 0, 0, PETSC_COMM_WORLD);
  for (std::size_t at = 0; at < bytes.size(); at += piece)
    MPI_Send(bytes.data() + at, piece_at(at, bytes), MPI_CHAR, 0, 0, PETSC_COMM_WORLD);
}

std::string receive(int from) {
  long long size = 0;
  MPI_Recv(&size, 1, MPI_LONG_LONG, from, 0, PETSC_COMM_WORLD, MPI_STATUS_IGNORE);
  std::string bytes(size, '\0');
  for (std::size_t at = 0; at < bytes.size(); at += piece)
    MPI_Recv(bytes.data() + at, piece_at(at, bytes), MPI_CHAR, from, 0, PETSC_COMM_WORLD,
             MPI_STATUS_IGNORE);
  return bytes;
}

Matrix sum(const Matrix& part) {
  Matrix whole = part;
  MPI_Allreduce(MPI_IN_PLACE, whole.data(), static_cast<int>(whole.size()), MPI_DOUBLE, MPI_SUM,
                PETSC_COMM_WORLD);
  return whole;
}

Matrix sum_to_first(const Matrix& part) {
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  Matrix whole(rank == 0 ? part.rows() : 0, part.cols());
  for (Index j = 0; j < part.cols(); ++j)  // by columns, as MPI counts in 32 bits
    MPI_Reduce(part.col(j).data(), rank == 0 ? whole.col(j).data() : nullptr,
               static_cast<int>(part.rows()), MPI_DOUBLE, MPI_SUM, 0, PETSC_COMM_WORLD);
  return whole;
}

Matrix from_first(const Matrix& of_first) {
  Index size[2] = {of_first.rows(), of_first.cols()};
  MPI_Bcast(size, 2, MPI_INT64_T, 0, PETSC_COMM_WORLD);
  Matrix all = of_first;
  all.resize(size[0], size[1]);
  MPI_Bcast(all.data(), static_cast<int>(all.size()), MPI_DOUBLE, 0, PETSC_COMM_WORLD);
  return all;
}

namespace {

struct RowsOfAll {
  std::vector<int> count, first;  // in the first process
};

RowsOfAll rows_of_all(Index n_own) {
  int count = 1, own = static_cast<int>(n_own);
  MPI_Comm_size(PETSC_COMM_WORLD, &count);
  RowsOfAll rows{std::vector<int>(count, 0), std::vector<int>(count, 0)};
  MPI_Allgather(&own, 1, MPI_INT, rows.count.data(), 1, MPI_INT, PETSC_COMM_WORLD);
  std::exclusive_scan(rows.count.begin(), rows.count.end(), rows.first.begin(), 0);
  return rows;
}

}  // namespace

Vector gather_in_first(const Vector& own) {
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  const RowsOfAll rows = rows_of_all(own.size());
  Vector all(rank == 0 ? rows.first.back() + rows.count.back() : 0);
  MPI_Gatherv(own.data(), static_cast<int>(own.size()), MPI_DOUBLE, all.data(), rows.count.data(),
              rows.first.data(), MPI_DOUBLE, 0, PETSC_COMM_WORLD);
  return all;
}

Vector scatter_from_first(const Vector& all, Index n_own) {
  const RowsOfAll rows = rows_of_all(n_own);
  Vector own(n_own);
  MPI_Scatterv(all.data(), rows.count.data(), rows.first.data(), MPI_DOUBLE, own.data(),
               static_cast<int>(n_own), MPI_DOUBLE, 0, PETSC_COMM_WORLD);
  return own;
}

bool any(bool value) { return largest(value ? 1 : 0) > 0; }

double largest(double value) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  return value;
}

}  // namespace cbr
