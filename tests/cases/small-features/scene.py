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

sys.path.append("..")
from variants import print_variant

NAME = re.compile(r"(small|tet4|tet10|fine)-(full|([klm])(\d+))(?:-s([\d.]+))?")


def changes(name):
    found = NAME.fullmatch(name)
    if not found or (found[2] == "full" and found[5]):
        return None
    mesh, model, kind, modes, factor = found.groups()
    pairs = [("mesh: tet4.msh", f"mesh: {mesh}.msh")]
    if model == "full":
        pairs.append(("as: superelement", "as: mesh"))
    else:
        pairs += [("modes: 80", f"modes: {modes}"), ("superelement: tet4-k80", f"superelement: {mesh}-{model}")]
        if kind == "l":
            pairs.append(("pick: participation", "pick: frequency"))
        if kind == "m":
            pairs.append(("interface: [contact]", "interface: [contact, mount]"))
    if factor:
        pairs.append(("end: 1.0e-4", f"end: 1.0e-4, step: {{cfl: {factor}}}"))
    return pairs


if __name__ == "__main__":
    print_variant(__doc__, changes)
