// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/dynamics/mortar_run.hpp"

namespace cbr::test {

ContactList run(FaceGrid& slave, FaceGrid& master, PairMemory& memory, bool initial) {
  slave.surface.body = 0;
  master.surface.body = 1;
  ContactList list;
  detect_mortar(slave.surface, slave.body, master.surface, master.body, initial, {}, memory, list);
  return list;
}

ContactList run(FaceGrid& slave, FaceGrid& master) {
  PairMemory memory;
  return run(slave, master, memory);
}

Vector3 apply(const ContactList& list, const ContactPoint& point, const Points& slave,
              const Points& master) {
  Vector3 sum = Vector3::Zero();
  for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
    const ContactTerm& term = list.terms[t];
    sum += term.coefficient * (term.body == 0 ? slave : master).row(term.node).transpose();
  }
  return sum;
}

double shared_area(const ContactList& list) {
  double sum = 0;
  for (const auto& point : list.points) sum += point.area;
  return sum;
}

Vector pressure_forces(const ContactList& list, Index body, Index n_nodes) {
  Vector force = Vector::Zero(n_nodes);
  for (const auto& point : list.points)
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t)
      if (list.terms[t].body == body)
        force[list.terms[t].node] += point.area * list.terms[t].coefficient;
  return force;
}

}  // namespace cbr::test
