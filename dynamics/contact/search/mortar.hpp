// SPDX-License-Identifier: GPL-3.0-or-later
// Face-face contact: gaps integrated over what two surfaces share.
#pragma once

#include <vector>

#include "dynamics/contact/search/detection.hpp"
#include "dynamics/contact/surfaces/broad_phase.hpp"
#include "dynamics/contact/surfaces/contact_point.hpp"
#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

// One point per slave node j whose support meets the master (multiplier shape functions = the
// slave's own N_j, so that uniform pressure gives both sides their consistent nodal forces: the
// contact patch test). Its terms are
//   D_jk / D_j on slave nodes k,  -M_jl / D_j on master nodes l,    D_jk = int N_j N_k dA, M_jl =
//   int N_j N_l dA, D_j = int N_j dA
// over the shared area (segments: faces clipped against each other in the plane of the slave face,
// as in Puso and Laursen 2004, doi 10.1016/j.cma.2003.10.010), so that they sum to 1 and -1. area =
// D_j. The normal is that of the master, averaged over the shared area: distances along the slave's
// normal n_s close by n_m . d / (n_m . n_s) when the bodies move by d, so that pushes along any
// other direction than n_m do work that the next step's gaps know nothing of (a coarse ball left a
// plate with six times its energy). A node on an edge of the body has one point per direction.
// Faces of second order (ContactSurface::middle) have points at their corners only, of linear N_j,
// and terms on all nodes (as Puso, Laursen, Solberg 2008, doi 10.1016/j.cma.2007.08.009): a
// pressure is then not negative where nodal forces are. Where less than 5 % of a node's faces is
// shared, its N_j goes to its neighbours. Appends to `list`. Options, memory and `initial` as for
// detect().
void detect_mortar(const ContactSurface& slave, const ContactBody& slave_body,
                   const ContactSurface& master, const ContactBody& master_body, bool initial,
                   const DetectionOptions& options, PairMemory& memory, ContactList& list);

}  // namespace cbr
