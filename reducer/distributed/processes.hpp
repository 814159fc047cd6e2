// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of reducer/distributed: one reduction in several processes, by PETSc, MUMPS and SLEPc.
//
// The processes that mpirun started, and how they speak and end as one. A build without MPI has one
// (without_mpi.cpp).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "reducer/bases/reduce.hpp"
#include "reducer/domains/domains.hpp"

namespace cbr {

// One object a program, first thing in main(). Of several processes only the first prints.
class Processes {
 public:
  Processes();
  ~Processes();
  Processes(const Processes&) = delete;
  Processes& operator=(const Processes&) = delete;

  // MPI and PETSc, where mpirun started several processes or `asked`. InputError: this build has
  // none of them.
  void start(bool asked);
  bool is_started() const { return is_started_; }
  int count() const { return count_; }
  bool is_first() const { return rank_ == 0; }
  int threads() const;  // processors of the machine for each of its processes, at least 1

  // Ends MPI, or, where a process failed alone, all of them. Returns the exit code.
  int end(int code);

 private:
  bool is_started_ = false;
  int rank_ = 0, count_ = 1;
  [[maybe_unused]] int voice_ = -1;  // former stderr of a process that may not print
};

// All processes call the following at the same time, once they are started.

// Does `work` in each; the error of the first process that has one is thrown in all.
void together(const std::function<void()>& work);
// The same in the first process alone.
void in_first(const std::function<void()>& work);

struct ProcessNumbers {
  int own = 0, all = 1, here = 1;  // here: how many are on this machine
};
ProcessNumbers process_numbers();

// For two processes alone: from this one to the first, which waits for it.
void send_to_first(const std::string& bytes);
std::string receive(int from);

Matrix sum(const Matrix& part);             // over the processes, to all of them
Matrix sum_to_first(const Matrix& part);    // empty in the others
Matrix from_first(const Matrix& of_first);  // the first process's, to all
double largest(double value);
bool any(bool value);
// From the rows of each process to those of all, one process after another, in the first (empty in
// the others), and back.
Vector gather_in_first(const Vector& own);
Vector scatter_from_first(const Vector& all, Index n_own);

// Reductions by all processes at once: of one component, or of its domains.
//
// Called in all processes with the same arguments. The first returns the
// superelement, others an empty one. The numbers are those of reduce(): matrices and frequencies to
// 1e-9, modes up to their signs. InputError naming any unsupported option. All processes throw
// errors, as those of reduce().
Superelement reduce_in_processes(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                                 MassKind mass, const ReductionOptions& options,
                                 const ReduceSettings& settings, Report& report,
                                 ReductionFigures* figures);

// Domains of this process, which it reduces as one process does, without a message. The first gets
// the superelements of all.
DomainShare share_of_domains();

}  // namespace cbr
