// SPDX-License-Identifier: GPL-3.0-or-later
// Messages of all programs about blocks of a mesh: those that none computes with, shells without a
// thickness and beams, and those whose material or elements can hardly be meant; and the mass that
// its elements ask for.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/mesh/mesh.hpp"
#include "common/scene/scene.hpp"

namespace cbr {

// InputError when the scene gives a material or an element to such a block.
void refuse_left_out_blocks(const Component& component, const Mesh& mesh);

// "fin (25 quad4), web (12 tri3), beam (11 of its 11 nodes are of no element)"; empty when
// all is structure.
std::string left_out_blocks(const Mesh& mesh);

// Warns, by the component's name; `blocks`: as above, nothing is said when it is empty. InputError
// when the scene names one.
void warn_of_left_out_blocks(const Component& component, const std::string& blocks, Report& report);

// Of each block its material and element by "block NAME: youngs_modulus", and "left_out": what
// /provenance of a superelement has of its mesh.
std::map<std::string, std::string> block_provenance(const Mesh& mesh,
                                                    const std::vector<BlockProperties>& properties);

// Warns of what /provenance, or block_provenance(), says of the blocks: those left out, a speed of
// waves that no consistent units give, a metal's weight as its density, and elements that lock near
// incompressibility (isotropic materials alone). InputError as above.
void warn_of_blocks(const Component& component,
                    const std::map<std::string, std::string>& provenance, Report& report);
// Of what the component's file says and is not read (Mesh::dropped), and of hex20 of reduced
// integration in rows, if there are any.
void warn_of_mesh(const Component& component, const Mesh& mesh,
                  const std::vector<BlockProperties>& properties, Report& report);

// Which mass matrix a component has where the scene does not say (docs/decisions/mass.md).
//
// Of a full mesh in motion. Lumped unless the scene says otherwise: explicit steps divide by it.
MassKind mass_of_mesh(const Component& component);

// As the scene says; else consistent when the mesh has elements that lumping spoils, and lumped for
// all others. Frequencies and harmonic response of full meshes have the same.
MassKind mass_of_superelement(const Component& component, const Mesh& mesh);

// Whether lumped mass spoils frequencies and inertia of such elements ("hex20", "hex20-reduced",
// "tet10", and shells, whose lumped rotary inertia is large).
bool is_spoilt_by_lumping(const std::string& element);

}  // namespace cbr
