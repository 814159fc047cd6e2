// SPDX-License-Identifier: GPL-3.0-or-later
// Face-face contact: gaps integrated over the shared area of two surfaces.
#pragma once


#include "dynamics/contact/search/detection.hpp"
#include "dynamics/contact/surfaces/broad_phase.hpp"
#include "dynamics/contact/surfaces/contact_point.hpp"
#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

// One point per slave node j whose support meets the master. Multiplier shape functions are the
// slave's own N_j, so that uniform pressure gives consistent nodal forces on both sides (contact
// patch test). Its terms, which sum to 1 and -1, are
//   D_jk / D_j on slave nodes k,  -M_jl / D_j on master nodes l,
//   D_jk = int N_j N_k dA, M_jl = int N_j N_l dA, D_j = int N_j dA
// over the shared area; area = D_j. Segments are faces clipped against each other in the plane of
// the slave face, as in Puso and Laursen 2004, doi 10.1016/j.cma.2003.10.010. The normal n_m is
// that of the master, averaged over the shared area. When the bodies move by d, distances along the
// slave's normal n_s close by n_m . d / (n_m . n_s). Impulses along any other direction than n_m
// would do work that the gaps of the next step do not contain. With n_s a coarse ball left a plate
// with six times its energy. A node on an edge of the body has one point per direction.
// Second-order faces (ContactSurface::middle) have points at corners only, with linear N_j, and
// terms on all nodes, as in Puso, Laursen, Solberg 2008, doi 10.1016/j.cma.2007.08.009. So a
// pressure is not negative where nodal forces are. A node with less than 5 % of its faces shared
// adds its N_j to its neighbours. Appends to `list`. Options, memory and `initial` as for detect().
void detect_mortar(const ContactSurface& slave, const ContactBody& slave_body,
                   const ContactSurface& master, const ContactBody& master_body, bool initial,
                   const DetectionOptions& options, PairMemory& memory, ContactList& list);

}  // namespace cbr
