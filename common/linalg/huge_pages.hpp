// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/base/types.hpp"

namespace cbr {

// Asks the system for pages of 2 MB for a large matrix that has not been written yet: a matrix of
// 30 MB then costs 15 page faults and not 7600 (8 ms here), and products with it look few pages up.
// A hint: nothing else changes.
void prefer_huge_pages(const Matrix& A);
Matrix on_huge_pages(Index rows, Index columns);  // not yet written
Matrix zeros_on_huge_pages(Index rows, Index columns);

// The same for memory of any kind; for the .cpp that has asked for it from elsewhere.
void prefer_huge_pages(const void* start, double bytes);

// First in main(): freed memory stays with the program, and the next bytes (256 MB if not given)
// that the heap grows by are asked for in such pages. They are only reserved, and use no memory
// before they are written. Matrices of a step come and go: giving their pages back each time costs
// more than the step. docs/decisions/contact-cost.md, "Pages", has what page faults cost.
void keep_heap_on_huge_pages(double ahead = 268435456);
// All threads allocate from that heap, which else each do from one of their own: for work whose
// allocations are large and few.
void one_heap_for_all_threads();
// Gives pages back to the system that the heap keeps and nobody uses, if they are this many bytes
// or more.
void return_unused_heap(double at_least);

}  // namespace cbr
