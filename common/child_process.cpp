// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/child_process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

// Of the sanitizers: nobody is to hear of the child's end but its parent.
extern "C" __attribute__((weak)) void __sanitizer_set_death_callback(void (*callback)());

namespace cbr {
namespace {

[[noreturn]] void act_and_end(const std::function<void()>& action, unsigned seconds, const sigset_t& signals) {
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU, SIGTERM, SIGINT, SIGHUP}) signal(number, SIG_DFL);
  sigprocmask(SIG_SETMASK, &signals, nullptr);
  if (__sanitizer_set_death_callback != nullptr) __sanitizer_set_death_callback(nullptr);
  const rlimit none{0, 0}, time{seconds, seconds};
  setrlimit(RLIMIT_CORE, &none);
  setrlimit(RLIMIT_CPU, &time);
  if (const int nowhere = open("/dev/null", O_WRONLY); nowhere >= 0) dup2(nowhere, 1), dup2(nowhere, 2);
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

bool survives_in_child(const std::function<void()>& action, unsigned seconds) {
  sigset_t all, before;  // until the child has left the parent's handlers, which would speak twice
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const pid_t child = fork();
  if (child == 0) act_and_end(action, seconds, before);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (child < 0) return true;
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return true;
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace cbr
