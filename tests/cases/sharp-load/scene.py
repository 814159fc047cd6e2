#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Another scene from load.yaml, on stdout: scene.py load.yaml MESH-HEX-MODEL-SCHEME[-STEP][-SHELL]

    MESH    coarse: 10 x 5 x 8 hexes, 1782 dofs; fine: 20 x 10 x 15, 11088
    HEX     bubble: hex8-incompatible, as in Sierra/SD; under: hex8-hourglass, as in Sierra/SM; plain: hex8
    MODEL   full: the mesh; a, b, c: superelement of all dofs but one, interface the loaded face, both x faces, the whole surface;
            all: as a, with every mode; a400: as a, with the 400 lowest modes, likewise b and c
    SCHEME  exact (superelements; its step does not matter) | explicit (central differences) | newmark
    STEP    xF: F times the critical step of the model; nM: 0.3 us / M, so that the load's corners fall on steps
    SHELL   three letters: modulus large (6.9e3) or small (6.9e-5), l | s; density large (0.11) or small (1.1e-5), l | s;
            thickness thin (2.5e-10) or thick (2.5e-4), n | k. zero: shells of modulus and density 0
"""
import re
import sys

sys.path.append("..")
from variants import print_variant

HEXES = {"bubble": "hex8-incompatible", "under": "hex8-hourglass", "plain": "hex8"}
# Hexes along x, y, z
MESHES = {"coarse": (10, 5, 8), "fine": (20, 10, 15)}
INTERFACES = {"a": ["contact"], "b": ["x_min", "contact"], "c": ["surface"]}
SCHEMES = {"exact": "exact", "explicit": "central-difference", "newmark": "newmark"}
MODULUS, DENSITY, THICKNESS = {"l": 6.9e3, "s": 6.9e-5}, {"l": 0.11, "s": 1.1e-5}, {"n": 2.5e-10, "k": 2.5e-4}
CORNER, END = 3e-7, 1.2e-5
NAME = re.compile(r"(coarse|fine)-(bubble|under|plain)-(full|all|[abc]\d*)-(exact|explicit|newmark)(?:-([xn])([\d.]+))?(?:-([ls][ls][nk]|zero))?")


def dofs(mesh, model):
    """Of the mesh, and of the interface of a superelement of it (0: full mesh)."""
    nx, ny, nz = (n + 1 for n in MESHES[mesh])
    surface = nx * ny * nz - (nx - 2) * (ny - 2) * (nz - 2)
    nodes = {"f": 0, "a": ny * nz, "b": 2 * ny * nz, "c": surface}[model[0]]
    return 3 * nx * ny * nz, 3 * nodes


def shell(word):
    """Modulus, density, thickness."""
    return (0.0, 0.0, 2.5e-4) if word == "zero" else (MODULUS[word[0]], DENSITY[word[1]], THICKNESS[word[2]])


def changes(name):
    found = NAME.fullmatch(name)
    if not found or (found[4] == "exact") != (found[5] is None):
        return None
    mesh, hexes, model, scheme, unit, amount, skin = found.groups()
    interface = INTERFACES["a" if model == "full" else model[0]]
    total, kept = dofs(mesh, model)
    modes = int(model[1:]) if model[1:].isdigit() else total - kept - (model != "all")
    pairs = [("mesh: coarse.msh", f"mesh: {mesh}.msh"), ("element: hex8-incompatible", f"element: {HEXES[hexes]}"),
             ("interface: [contact, load]", f"interface: [{', '.join(interface)}, load]"), ("modes: 1619", f"modes: {modes}"),
             ("coarse-bubble-a.cbr", f"{mesh}-{hexes}-{'a' if model == 'full' else model}.cbr"),
             ("integrator: exact", f"integrator: {SCHEMES[scheme]}")]
    if model == "full":
        pairs.append(("as: superelement", "as: mesh"))
    if unit:
        step = f"{{cfl: {amount}}}" if unit == "x" else repr(CORNER / float(amount))
        pairs += [("end: 1.2e-5", f"end: 1.2e-5, step: {step}"), ("every: 1.0e-8", "every: 0")]
    if skin:
        modulus, density, thickness = shell(skin)
        pairs.append(("\nloads:", f"\nskin: {{surfaces: [{', '.join(interface)}], youngs_modulus: {modulus}, poissons_ratio: 0.3, "
                                  f"density: {density}, thickness: {thickness}, mesh: {name}.msh}}\n\nloads:"))
    return pairs


if __name__ == "__main__":
    # Comments on the first scene do not hold for the others
    print_variant(__doc__, changes, keeps_comments=False)
