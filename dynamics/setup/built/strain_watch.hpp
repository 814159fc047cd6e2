// SPDX-License-Identifier: GPL-3.0-or-later
// Detects statics beyond the validity of linear bodies.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "dynamics/run/simulation/simulation.hpp"
#include "dynamics/setup/components/geometry.hpp"

namespace cbr {

// Watches strains of face edges and relative displacements of nodes in equilibrium. A load in
// another unit than the stiffness makes both too large.
class StrainWatch {
 public:
  // For an elastic body, before Body::prepare(); size: of the part.
  void add(Simulation& simulation, Index body, double size, const Geometry& geometry);
  // Call at an output of statics, and at time 0 after a preload.
  void look(const Simulation& simulation, double t);

  struct Worst {
    Index body = 0;
    double value = 0, t = 0;
  };
  // Largest relative change of an edge's length, if too large for small strains.
  std::optional<Worst> strain() const;
  // Largest difference of two nodes' displacements over the size, if above one.
  std::optional<Worst> displacement() const;

 private:
  struct Watched {
    Index body = 0, set = 0;
    double size = 0;
    std::vector<Index> nodes;                 // nodes of the set with displacements
    std::vector<std::array<Index, 2>> edges;  // as positions in `nodes`
  };
  std::vector<Watched> watched_;
  Worst strain_, displacement_;
};

}  // namespace cbr
