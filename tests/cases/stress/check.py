#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the plate with a hole: 3.03 times the tension at the edge of the hole, and what is written fits together."""
import sys

import h5py
import numpy as np

sys.path.append("..")
from checks import report

TENSION, HOLE, WIDTH = 1e8, 0.1, 1.0
# Of a plate of finite width, over the tension far away (Heywood 1952): (2 + (1 - d / w)^3) / (1 - d / w)
factor = (2 + (1 - HOLE / WIDTH) ** 3) / (1 - HOLE / WIDTH)

with h5py.File(sys.argv[1] + "/plate.h5") as f:
    t = f["time"][:]
    hole, envelope, worst = f["stress/plate.hole"], f["stress/plate/envelope/nodes"], f["stress/plate/worst"]
    principal, smallest, ids = hole["principal_1"][:], hole["principal_3"][:], hole["node_id"][:]
    of_hole = np.isin(envelope["node_id"][:], ids)
    largest = envelope["principal_1"][:][of_hole].max()
    elements, von_mises = worst["element_id"][:], worst["von_mises"][:]

edge = principal[-1].max()
checks = [
    ("stress at the edge over the tension, from Heywood's", abs(edge / TENSION / factor - 1), 0.03),
    ("compression at its two ends, from the tension", abs(smallest[-1].min() / TENSION + 1), 0.1),
    ("envelope, from the largest of the history", abs(largest / principal.max() - 1), 1e-12),
    ("worst elements that change at the end, share", np.mean(elements[-10:] != elements[-1]), 0),
    ("worst elements that are not sorted, share", np.mean(np.diff(von_mises, axis=1) > 0), 0),
]
print(f"largest principal stress at node {ids[principal[-1].argmax()]}: {edge / 1e6:.1f} MPa, {edge / TENSION:.3f} times the tension")
sys.exit(report(checks))
