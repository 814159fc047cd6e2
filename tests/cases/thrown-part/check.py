#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""check.py FOLDER: what the thrown part must show: it turns over, keeps its size, takes no energy from contact, and comes to rest."""
import pathlib
import sys

import h5py
import numpy as np

sys.path.append("..")
from checks import report

folder = pathlib.Path(sys.argv[1])


def size(name):
    """Largest distance of two nodes at each output, as a share of the first."""
    with h5py.File(folder / f"{name}.fields.h5") as fields:
        points = fields["grids/0/points"][:]
        a, b = np.unravel_index(np.argmax(((points[:, None] - points[None]) ** 2).sum(-1)), (len(points),) * 2)
        moved = [fields[f"steps/{i}/0/displacement"][:] for i in range(len(fields["times"]))]
        length = np.array([np.linalg.norm(points[a] + u[a] - points[b] - u[b]) for u in moved])
    return length / length[0]


with h5py.File(folder / "large.h5") as f:
    energy = {name: f[f"energy/{name}"][:] for name in ("total", "work_external", "work_contact", "work_friction", "work_damping", "work_numerical")}
    kinetic = f["instances/part/kinetic_energy"][:]
    w = f["instances/part/orientation"][:, 0]
    height = f["instances/part/center_of_mass"][:, 2]
    flies = f["contact/active"][:] == 0

left = energy["total"] - sum(energy[name] for name in energy if name != "total")
turned = np.degrees(2 * np.arccos(np.clip(abs(w), 0, 1))).max()
checks = [
    ("turned at most, 180 less degrees", 180 - turned, 45),
    ("energy that no work accounts for, share", abs(left - left[0]).max() / energy["total"].max(), 1e-13),
    ("energy that contact has given whenever it flies, share", (energy["work_contact"] + energy["work_friction"])[flies].max() / energy["total"][0], 1e-9),
    ("kinetic energy left, share", kinetic[-1] / kinetic[0], 5e-5),
    ("height of the centre at rest, from 10 mm", abs(height[-1] - 0.01), 2e-7),
    ("change of size", abs(size("large") - 1).max(), 0.01),
    ("share of that of the linear body", abs(size("large") - 1).max() / abs(size("small") - 1).max(), 0.02),
]
sys.exit(report(checks))
