// SPDX-License-Identifier: GPL-3.0-or-later
// Figures that are watched at outputs, for the summary of a run.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "dynamics/run/simulation/simulation.hpp"
#include "dynamics/setup/components/geometry.hpp"

namespace cbr {

// The least gap of surfaces that never touch: contact's search has a limited reach. Watches pairs
// that are not tied, if there are few. Until a pair has touched it evaluates only the mean motion
// of its surfaces, at outputs. Distances are computed on request.
class GapWatch {
 public:
  // Call when all pairs exist, before the first step and scale().
  void start(Simulation& simulation);
  // Call at each output, with all bodies at that time. A restarted run is watched from there on.
  void look(const Simulation& simulation);
  // Initial distance; none for a pair that is not watched.
  std::optional<double> initial(const Simulation& simulation, Index pair) const;
  // Least distance at an output, with surfaces moved by their mean displacement, without rotation.
  // Call after the run.
  std::optional<double> nearest(const Simulation& simulation, Index pair) const;

 private:
  struct Side {
    Index body = -1, mean_set = 0;
    Points sample;  // a subset of the undeformed nodes
    Vector3 start = Vector3::Zero(), shift = Vector3::Zero();
  };
  struct Watched {
    Index pair = 0;
    Side slave, master;  // a wall has no body
    double least = 0;    // least squared distance of the samples so far
    Vector3 slave_shift = Vector3::Zero(), master_shift = Vector3::Zero();  // at that time
  };
  Side side_of(Simulation& simulation, const ContactSurface& surface) const;
  const Watched* find(Index pair) const;
  static double sampled(const Simulation& simulation, const Watched& watched);
  static double distance(const Simulation& simulation, const Watched& watched,
                         const Vector3& slave_shift, const Vector3& master_shift);

  std::vector<Watched> watched_;
};

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
