#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Another scene from impact.yaml, on stdout: scene.py impact.yaml MESH-MODEL[-friction]

    MESH       small: for tests; part; fine: the full mesh alone, for the error of `part`
    MODEL      full: the finite element mesh; shapes: basis characteristic;
               nodes: basis craig-bampton
    friction   Coulomb's coefficient is 0.3; without it 0
"""
import re
import sys

sys.path.append("..")
from variants import print_variant

NAME = re.compile(r"(small|part|fine)-(full|shapes|nodes)(?:-(friction))?")


def reduction_of(name):
    """Name of the superelement that a run uses. Friction asks for other statics of the foot."""
    mesh, model, friction = NAME.fullmatch(name).groups()
    return f"{mesh}-{model}" + ("-friction" if friction and model == "shapes" else "")


def changes(name):
    found = NAME.fullmatch(name)
    if not found:
        return None
    mesh, model, friction = found.groups()
    pairs = [("mesh: part.msh", f"mesh: {mesh}.msh")]
    if model == "full":
        pairs.append(("as: superelement", "as: mesh"))
    if model != "shapes":
        pairs.append(("      basis: characteristic\n", ""))
    pairs.append(("superelement: part-shapes", f"superelement: {reduction_of(name)}"))
    if friction:
        pairs.append(("floor]}", "floor], friction: 0.3}"))
    return pairs


if __name__ == "__main__":
    print_variant(__doc__, changes)
