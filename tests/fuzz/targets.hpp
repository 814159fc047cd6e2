// SPDX-License-Identifier: GPL-3.0-or-later
// Targets of the fuzzers. Each takes any bytes as a file of one kind. It aborts if a reader accepts
// invalid data, or accepted data do harm later. InputError and RunError are correct results. How to
// run them: CONTRIBUTING.md.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>

namespace cbr::fuzz {

using Bytes = std::span<const std::uint8_t>;

void scene(Bytes bytes);         // YAML: parsed, written, parsed again
void gmsh(Bytes bytes);          // .msh: read, assembled, written, read again
void exodus(Bytes bytes);        // Exodus II and Sierra's superelements: likewise
void med(Bytes bytes);           // Salome's meshes: likewise
void superelement(Bytes bytes);  // HDF5: read, checked, written, read again
// bytes are edits of a valid superelement file, which is then read and run
void edits(Bytes bytes);
void program(Bytes bytes);  // YAML: reduced, built and run on small meshes
// bytes are damage to a checkpoint or its fields, from which a run then continues
void checkpoint(Bytes bytes);

struct Target {
  const char* name;
  void (*run)(Bytes);
};
inline constexpr Target targets[] = {{"scene", scene},
                                     {"gmsh", gmsh},
                                     {"exodus", exodus},
                                     {"med", med},
                                     {"superelement", superelement},
                                     {"edits", edits},
                                     {"program", program},
                                     {"checkpoint", checkpoint}};

// A condition that holds for every input.
inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "fuzz: %s\n", what);
  std::abort();
}

}  // namespace cbr::fuzz
