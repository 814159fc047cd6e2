#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Another scene from impact.yaml, on stdout: scene.py impact.yaml MESH-MODEL[-sF]

    MESH    small: for tests; tet4; tet10; fine: tet10, to see the others' error. Sizes in the Makefile
    MODEL   full: the finite element mesh; kN: superelement, the N modes that the pad takes most part in; lN: the N lowest;
            mN: as kN, and the mounting face is interface too
    sF      superelements: steps F times the critical one, whose highest modes are quasi-static
"""
import re
import sys

NAME = re.compile(r"(small|tet4|tet10|fine)-(full|([klm])(\d+))(?:-s([\d.]+))?")


def variant(text, name):
    found = NAME.fullmatch(name)
    if not found or (found[2] == "full" and found[5]):
        sys.exit(f"scene.py: {name}: see --help")
    mesh, model, kind, modes, factor = found.groups()
    changes = [("mesh: tet4.msh", f"mesh: {mesh}.msh")]
    if model == "full":
        changes.append(("as: superelement", "as: mesh"))
    else:
        changes += [("modes: 80", f"modes: {modes}"), ("superelement: tet4-k80", f"superelement: {mesh}-{model}")]
        if kind == "l":
            changes.append(("pick: participation", "pick: frequency"))
        if kind == "m":
            changes.append(("interface: [contact]", "interface: [contact, mount]"))
    if factor:
        changes.append(("end: 1.0e-4", f"end: 1.0e-4, step: {{cfl: {factor}}}"))
    for old, new in changes:
        if old not in text:
            sys.exit(f"scene.py: impact.yaml has no '{old}'")
        text = text.replace(old, new)
    return text


def main():
    if len(sys.argv) != 3 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    with open(sys.argv[1]) as f:
        print(variant(f.read(), sys.argv[2]), end="")


if __name__ == "__main__":
    main()
