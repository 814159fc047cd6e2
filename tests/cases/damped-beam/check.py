#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the damped beam: superelement and mesh alike, energy accounted for, the first mode's decay."""
import sys

import h5py
import numpy as np

sys.path.append("..")
from checks import report

with h5py.File(sys.argv[1] + "/beam.h5") as f:
    t = f["time"][:]
    z = {name: f[f"surfaces/{name}.z_max/mean_position"][:, 2] for name in ("reduced", "full", "measured")}
    energy = {name: f[f"energy/{name}"][:] for name in ("total", "work_external", "work_damping", "work_numerical")}

z = {name: at - at[0] for name, at in z.items()}
largest = np.abs(z["full"]).max()
left = energy["total"] - energy["work_external"] - energy["work_damping"] - energy["work_numerical"]


def decay(name):
    """Rate of the envelope of the free swing, 1/s, from its peaks after 40 ms."""
    up = np.abs(z[name])
    peaks = [i for i in range(40, len(t) - 1) if up[i] >= up[i - 1] and up[i] > up[i + 1]]
    return -np.polyfit(t[peaks], np.log(up[peaks]), 1)[0]


# First bending mode, 1.875^2 / (2 pi) sqrt(E I / (rho A L^4)) = 33.4 Hz: (alpha + beta omega^2) / 2, and ratio omega.
omega = 2 * np.pi * 33.4
expected = {"full": (10 + 1e-6 * omega**2) / 2, "measured": np.interp(33.4, [30, 200], [0.03, 0.01]) * omega}
checks = [
    ("superelement from mesh, share of the largest move", np.abs(z["reduced"] - z["full"]).max() / largest, 0.01),
    ("energy that no work accounts for, share", np.abs(left - left[0]).max() / energy["total"].max(), 1e-9),
    ("energy that damping gave", np.diff(energy["work_damping"]).max(), 1e-12),
    ("decay of the mesh's swing, from the first mode's", abs(decay("full") / expected["full"] - 1), 0.05),
    ("decay of the measured beam's swing, likewise", abs(decay("measured") / expected["measured"] - 1), 0.05),
]
sys.exit(report(checks))
