#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""plot.py FOLDER: thrown-part.png, the thrown part seen from the side at some instants; above as it turns, below as a linear body."""
import pathlib
import sys

import h5py
import numpy as np

sys.path.append("..")
from plotting import plt, save, side_view


def faces_at(fields, instants):
    """Quads of the surface at some times, each (faces, 4, 3)."""
    points, cells = fields["grids/0/points"][:], fields["grids/0/cells"][:]
    times = fields["times"][:]
    for instant in instants:
        step = int(np.argmin(abs(times - instant)))
        yield (points + fields[f"steps/{step}/0/displacement"][:])[cells]


def draw(axis, file, instants, title):
    with h5py.File(file) as fields:
        for share, quads in zip(np.linspace(0, 1, len(instants)), faces_at(fields, instants)):
            side_view(axis, quads, plt.cm.viridis(0.15 + 0.75 * share), title)
    axis.set_ylabel("height [mm]")


folder = pathlib.Path(sys.argv[1])
instants = [0, 0.06, 0.12, 0.2, 0.28, 0.36, 0.65]
figure, axes = plt.subplots(2, 1, figsize=(9, 6.5), layout="constrained", sharex=True)
draw(axes[0], folder / "large.fields.h5", instants, "rotations: large")
draw(axes[1], folder / "small.fields.h5", instants, "rotations: small: a linear body grows as it turns")
axes[1].set_xlabel("along the throw [mm]; " + ", ".join(f"{1e3 * t:.0f}" for t in instants) + " ms")
save(figure, folder / "thrown-part.png", dpi=100)
