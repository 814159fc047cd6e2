#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Another scene from impact.yaml, on stdout: scene.py impact.yaml SHAPE-MODEL-CONTACT-mLEFTxRIGHT

    SHAPE    sphere | brick
    MODEL    full: finite element meshes; kN: superelements, N modes in the impactor behind its whole surface; faceN: behind its
             side that looks at the block; bN: behind the whole surface, and N modes in the block instead of 200;
             mixed: the block a mesh, the impactor a superelement of 200 modes
    CONTACT  impulse | mortar | penalty | twoway (penalty) | nodal; of-left, of-right, mortar-of-left, mortar-of-right (impulse): the
             impactor moved along the block so that no nodes match, and whose nodes (multipliers) are held. Only where both have
             elements of one size (brick, m2x1): the first-named surface is the slave then, else the finer one
    LEFT     mesh level of the block; RIGHT: of the impactor
"""
import re
import sys

sys.path.append("..")
from variants import print_variant

CONTACT = {"impulse": "enforcement: impulse", "mortar": "enforcement: impulse, formulation: mortar", "penalty": "enforcement: penalty",
           "twoway": "enforcement: penalty, formulation: two-way", "nodal": "enforcement: nodal"}
for side in ("left", "right"):
    CONTACT[f"of-{side}"], CONTACT[f"mortar-of-{side}"] = CONTACT["impulse"], CONTACT["mortar"]


def changes(name):
    found = re.fullmatch(r"(sphere|brick)-(full|mixed|(k|face|b)(\d+))-([\w-]+)-m(\d)x(\d)", name)
    if not found or found[5] not in CONTACT:
        return None
    shape, model, kind, modes, contact, left, right = found.groups()
    of_block, of_impactor = (modes, "200") if kind == "b" else ("200", modes or "200")
    interface = "x_max" if kind == "face" else "surface"
    pairs = [("block-1.msh", f"block-{left}.msh"), ("sphere-1.msh", f"{shape}-{right}.msh"),
             ("modes: 200\n      superelement: block-1-200", f"modes: {of_block}\n      superelement: block-{left}-{of_block}"),
             ("modes: 200\n      superelement: sphere-1-surface-200",
              f"modes: {of_impactor}\n      superelement: {shape}-{right}-{interface}-{of_impactor}"),
             ("interface: [surface]", f"interface: [{interface}]"),
             ("enforcement: impulse", CONTACT[contact])]
    if kind == "face":
        pairs.append(("right.contact]", "right.x_max]"))
    if "of-" in contact:
        pairs.append(("0.0381, 0, 0", "0.0381, 0.00127, 0.00089"))
    if contact.endswith("of-right"):
        pairs.append(("left.contact, right.contact]", "right.contact, left.contact]"))
    if model in ("full", "mixed"):
        pairs.append(("block,    as: superelement", "block,    as: mesh"))
    if model == "full":
        pairs.append(("impactor, as: superelement", "impactor, as: mesh"))
    return pairs


if __name__ == "__main__":
    print_variant(__doc__, changes)
