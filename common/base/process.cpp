// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>

#include "common/base/error.hpp"

// Of the sanitizers: nobody is to hear of the child's end but its parent.
extern "C" __attribute__((weak)) void __sanitizer_set_death_callback(void (*callback)());

namespace cbr {
namespace {

[[noreturn]] void act_and_end(const std::function<void()>& action, unsigned seconds, pid_t parent,
                              sigset_t signals) {
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU})
    signal(number, SIG_DFL);
  // The parent handles signals that end the programs, or are ignored; the child goes with it
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, number);
  sigprocmask(SIG_SETMASK, &signals, nullptr);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(0);
  if (__sanitizer_set_death_callback != nullptr) __sanitizer_set_death_callback(nullptr);
  // where both are the same the signal is SIGKILL, which others send, too
  const rlimit none{0, 0}, time{seconds, seconds + 1};
  setrlimit(RLIMIT_CORE, &none);
  setrlimit(RLIMIT_CPU, &time);
  if (const int nowhere = open("/dev/null", O_WRONLY); nowhere >= 0) {
    dup2(nowhere, 1);
    dup2(nowhere, 2);
  }
  try {
    action();
  } catch (...) {  // the parent comes to the same error
  }
  _exit(0);
}

}  // namespace

unsigned seconds_to_read(std::uintmax_t bytes) {
  constexpr std::uintmax_t least = 10, bytes_a_second = 1'000'000;
  return static_cast<unsigned>(least + std::min<std::uintmax_t>(bytes / bytes_a_second, 1'000'000));
}

bool survives_in_child(const std::string& what, const std::function<void()>& action,
                       unsigned seconds) {
  sigset_t all, before;  // until the child has left the parent's handlers, which would speak twice
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const pid_t parent = getpid(), child = fork();
  if (child == 0) act_and_end(action, seconds, parent, before);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (child < 0) return true;
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return true;
  const int number = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  const auto own = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU};
  if (number != 0 && std::find(own.begin(), own.end(), number) == own.end())
    throw RunError(what + ": reading it was stopped by signal " + std::to_string(number) +
                   " from outside (memory or time ran out?)");
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

double machine_memory_bytes() {
  const double physical = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) *
                          static_cast<double>(::sysconf(_SC_PAGE_SIZE));
  double limit = 0;  // of a container (control groups, version 2); "max" is no number
  std::ifstream("/sys/fs/cgroup/memory.max") >> limit;
  return limit > 0 ? std::min(limit, physical) : physical;
}

const char* version() { return CBR_VERSION; }

}  // namespace cbr
