// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/base/types.hpp"

namespace cbr {

// A large matrix for which the system is asked for pages of 2 MB. A matrix of 30 MB then costs 15
// page faults, not 7600 (8 ms here), and fewer look-ups of pages. A hint: nothing else changes.
Matrix on_huge_pages(Index rows, Index columns);  // not yet written
Matrix zeros_on_huge_pages(Index rows, Index columns);

// First in main(): freed memory stays with the program, and the heap's next `ahead` bytes are
// requested in such pages. They are only reserved, and use no memory before they are written.
// Returning the pages of a step's matrices costs more than the step. Costs of page faults:
// docs/decisions/contact-cost.md, "Pages".
void keep_heap_on_huge_pages(double ahead = 268435456);
// All threads allocate from that heap, which else each do from one of their own: for work whose
// allocations are large and few.
void one_heap_for_all_threads();
// Gives pages back to the system that the heap keeps and nobody uses, if they are this many bytes
// or more.
void return_unused_heap(double at_least);

}  // namespace cbr
