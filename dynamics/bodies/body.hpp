// SPDX-License-Identifier: GPL-3.0-or-later
// The one real polymorphism: something that moves, has surface nodes, and answers impulses on them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/types.hpp"

namespace cbr {

// What a body answers about itself, all in the scene's axes.
struct BodyState {
  Vector3 center_of_mass, momentum, angular_momentum;  // angular momentum about the scene's origin
  double kinetic_energy = 0, strain_energy = 0;
};

// A step goes: predict(t, h) computes the end of the step without contact; contact asks positions and response at the
// nodes it cares about and hands back impulses with add_impulses(); accept() makes the end the new state.
// "Contact nodes" are numbered by the body: the union of the nodes of its surfaces that take part in contact or output.
class Body {
 public:
  virtual ~Body() = default;

  virtual const std::string& name() const = 0;
  virtual Index n_dofs() const = 0;
  virtual double largest_frequency() const = 0;        // rad/s, of the body alone; sets the step
  virtual bool is_exact() const = 0;                   // advanced by its exact solution, so any jump is allowed when no contact is near

  // Positions and velocities of nodes (indices into this body's nodes) now, and predicted for the end of the step.
  virtual Index n_nodes() const = 0;
  virtual void positions(const std::vector<Index>& nodes, Points& x) const = 0;
  virtual void velocities(const std::vector<Index>& nodes, Points& v) const = 0;
  virtual void predicted_positions(const std::vector<Index>& nodes, Points& x) const = 0;

  virtual void predict(double t, double h) = 0;
  // Impulses (f s) on nodes, given at the start of the step: changes the predicted end. n x 3, scene axes.
  virtual void add_impulses(const std::vector<Index>& nodes, const Points& impulses) = 0;
  virtual void accept() = 0;

  // Change of predicted position of the nodes' dofs per unit impulse on the nodes' dofs, 3n x 3n in scene axes (dof 3 i + c), for step h.
  virtual Matrix response(const std::vector<Index>& nodes, double h) const = 0;

  virtual BodyState state() const = 0;
};

}  // namespace cbr
