// SPDX-License-Identifier: GPL-3.0-or-later
// Differences of a superelement's file from the present scene, in words.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "common/files/hdf5_file.hpp"
#include "common/scene/scene.hpp"

namespace cbr {

// The mass and the component's reduction options by the names that /provenance has.
std::map<std::string, std::string> option_provenance(const Component& component, MassKind mass);

// Constants of a material by the names that a scene has.
std::map<std::string, std::string> material_provenance(const Material& material);

// Of the points that are nodes of the superelement: "point left" and "x_min at 0 0 0".
// Precondition: the component has a reduction.
std::map<std::string, std::string> point_provenance(const Component& component);

// Of basis characteristic, the scene's needs of each set: "needs patch" and "forces, pressure";
// of contact of all surfaces "needs of all". The second is the way back from /provenance.
std::map<std::string, std::string> needs_provenance(const InterfaceNeeds& needs);
InterfaceNeeds needs_in(const std::map<std::string, std::string>& provenance);

// "patch (forces), low (friction)": needs of the scene that the file was not made for; empty: all
// is there.
std::string missing_needs(const InterfaceNeeds& of_file, const InterfaceNeeds& of_scene);

// The hash of the component for a scene that asks this of its interface.
std::string content_hash(const Scene& scene, const Component& component,
                         const InterfaceNeeds& needs);

// What /provenance of the component's superelement says otherwise than the scene, as "modes: 40 in
// the file, 41 in the scene"; differences are joined by "; ". When there is none: that what
// contact, supports and loads ask of the interface has changed. Precondition: the component has a
// reduction.
std::string stale_text(const Scene& scene, const Component& component);

// Whether /provenance of the component's superelement names another mass than the scene wants of
// such elements. False for a file that cannot be read, or lacks them. Precondition: the
// component has a reduction.
bool is_of_other_mass(const Component& component);

// Whether the file was written before 1.6 and is of hex27, whose faces have no centre nodes in such
// files. False for a file that cannot be read.
bool lacks_face_centres(const std::filesystem::path& superelement);

}  // namespace cbr
