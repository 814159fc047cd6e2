// SPDX-License-Identifier: GPL-3.0-or-later
// Which mass matrix a component has where the scene does not say: measured in
// docs/decisions/mass.md.
#pragma once

#include <string>

#include "common/mesh/mesh.hpp"
#include "common/scene/scene.hpp"

namespace cbr {

// Of a full mesh in motion. Lumped unless the scene says otherwise: explicit steps divide by it.
MassKind mass_of_mesh(const Component& component);

// As the scene says; else consistent when the mesh has elements that lumping spoils, and lumped for
// all others. Frequencies and harmonic response of full meshes have the same.
MassKind mass_of_superelement(const Component& component, const Mesh& mesh);

// Whether lumped mass spoils frequencies and inertia of such elements ("hex20", "hex20-reduced",
// "tet10", and shells, whose lumped rotary inertia is large).
bool is_spoilt_by_lumping(const std::string& element);

}  // namespace cbr
