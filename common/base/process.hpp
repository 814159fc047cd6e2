// SPDX-License-Identifier: GPL-3.0-or-later
// This process and its machine, and trials in a process of their own.
#pragma once

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

#include <cstdint>
#include <functional>
#include <string>

namespace cbr {

// Runs `action` in a forked child; returns whether it ended after at most so many
// seconds of a processor's time: for libraries that crash on damaged files, or go round in them for
// ever. Side effects are lost. True without a trial where the system makes no copy. RunError
// names `what` if somebody else ended the copy.
bool survives_in_child(const std::string& what, const std::function<void()>& action,
                       unsigned seconds);

// More than a library takes for all of a sound file of this size, however it is compressed.
unsigned seconds_to_read(std::uintmax_t bytes);

// physical memory, whoever uses it, or what the container may have of it
double machine_memory_bytes();

// of cbr: "0.1.0"
const char* version();

// While it lives, results below 2.2e-308 are 0 in this thread and in those that it starts: what has
// decayed so far would cost a hundred times a step's time in denormal numbers, which no result can
// show. Where the processor has no such mode, nothing happens.
class FlushDenormals {
 public:
#if defined(__SSE2__)
  FlushDenormals() : before_(_mm_getcsr()) {
    _mm_setcsr(before_ | flush_to_zero | denormals_are_zero);
  }
  ~FlushDenormals() { _mm_setcsr(before_); }

 private:
  static constexpr unsigned flush_to_zero = 0x8000, denormals_are_zero = 0x0040;
  unsigned before_;

 public:
#else
  FlushDenormals() = default;
#endif
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;
};

}  // namespace cbr
