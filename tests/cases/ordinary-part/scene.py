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

NAME = re.compile(r"(small|part|fine)-(full|shapes|nodes)(?:-(friction))?")


def reduction_of(name):
    """Name of the superelement that a run uses. Friction asks for other statics of the foot."""
    mesh, model, friction = NAME.fullmatch(name).groups()
    return f"{mesh}-{model}" + ("-friction" if friction and model == "shapes" else "")


def variant(text, name):
    found = NAME.fullmatch(name)
    if not found:
        sys.exit(f"scene.py: {name}: see --help")
    mesh, model, friction = found.groups()
    changes = [("mesh: part.msh", f"mesh: {mesh}.msh")]
    if model == "full":
        changes.append(("as: superelement", "as: mesh"))
    if model != "shapes":
        changes.append(("      basis: characteristic\n", ""))
    changes.append(("superelement: part-shapes", f"superelement: {reduction_of(name)}"))
    if friction:
        changes.append(("floor]}", "floor], friction: 0.3}"))
    for old, new in changes:
        if old not in text:
            sys.exit(f"scene.py: impact.yaml has no '{old.strip()}'")
        text = text.replace(old, new)
    return text


def main():
    if len(sys.argv) != 3 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    with open(sys.argv[1]) as f:
        print(variant(f.read(), sys.argv[2]), end="")


if __name__ == "__main__":
    main()
