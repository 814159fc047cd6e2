// SPDX-License-Identifier: GPL-3.0-or-later
// How far statics leave what linear bodies are right for.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "dynamics/run/simulation/simulation.hpp"
#include "dynamics/setup/components/geometry.hpp"

namespace cbr {

// Watches the edges of faces, and how far nodes move apart, of bodies in equilibrium: a load in
// another unit than the stiffness gives strains and displacements that no small ones are.
class StrainWatch {
 public:
  // A body that strains, before Body::prepare(); size: of the part.
  void add(Simulation& simulation, Index body, double size, const Geometry& geometry);
  // At an output of statics, and at the time 0 after a preload.
  void look(const Simulation& simulation, double t);

  struct Worst {
    Index body = 0;
    double value = 0, t = 0;
  };
  // Change of an edge's length over the length, where it is too much for small strains.
  std::optional<Worst> strain() const;
  // Largest difference of two nodes' displacements over the size, where it is more than one.
  std::optional<Worst> displacement() const;

 private:
  struct Watched {
    Index body = 0, set = 0;
    double size = 0;
    std::vector<Index> nodes;                 // of the set: those that have displacements
    std::vector<std::array<Index, 2>> edges;  // by their places in `nodes`
  };
  std::vector<Watched> watched_;
  Worst strain_, displacement_;
};

}  // namespace cbr
