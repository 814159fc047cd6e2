#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the bolted joint: the pretension, forces in equilibrium, and superelements as the meshes have it."""
import sys

import h5py

sys.path.append("..")
from checks import report

PRETENSION, PULL = 20000.0, 6000.0


def read(name):
    """Forces along z at the outputs: of the bolt, between the plates, and of the supports."""
    with h5py.File(f"{sys.argv[1]}/{name}.h5") as f:
        force = lambda pair: f[f"contact/{pair}/force"][:, 2]
        return {"bolt": -force("head.cut - nut.cut"), "plates": force("upper.inside - lower.inside"),
                "seat": force("head.seat - upper.top"), "reaction": f["instances/lower/reaction"][:, 2],
                "way": f["surfaces/upper.ends/mean_position"][:, 2]}


mesh, reduced = read("mesh"), read("superelement")
share = (mesh["bolt"][-1] - PRETENSION) / PULL
checks = []
for name, run in (("mesh", mesh), ("superelement", reduced)):
    checks += [
        # The length is locked, and slips of friction begin anew in the load step that finds the time 0
        (f"{name}: the bolt's force before the load, from the pretension", abs(run["bolt"][0] / PRETENSION - 1), 1e-5),
        (f"{name}: the seat of the head has the bolt's force", abs(run["seat"] / run["bolt"] - 1).max(), 1e-6),
        (f"{name}: the plates have what bolt and load leave", abs(run["plates"][-1] / (run["bolt"][-1] - PULL) - 1), 1e-6),
        (f"{name}: the supports have the load", abs(run["reaction"][-1] / -PULL - 1), 1e-6),
    ]
checks += [
    ("superelement beside mesh: the bolt's force", abs(reduced["bolt"] / mesh["bolt"] - 1).max(), 1e-5),
    ("superelement beside mesh: way of the upper plate",
     abs((reduced["way"] - reduced["way"][0]) - (mesh["way"] - mesh["way"][0])).max() / abs(mesh["way"][-1] - mesh["way"][0]), 1e-5),
    ("share of the load that the bolt feels is below one half", share, 0.5),
    ("and above zero", -share, 0.0),
]
print(f"bolt: {mesh['bolt'][0]:.0f} N, {mesh['bolt'][-1]:.0f} N under the load; it feels {share:.1%} of it")
sys.exit(report(checks))
