#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""plot.py FOLDER: tumbling-parts.png, the parts in their box from the side at three instants; as superelements, as full meshes and as rigid bodies."""
import pathlib
import sys

import h5py
import numpy as np

sys.path.append("..")
from plotting import plt, save, side_view

folder = pathlib.Path(sys.argv[1])
# of a hexahedron; a grid of faces has one
sides = {8: [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (0, 3, 2, 1), (4, 5, 6, 7)], 4: [(0, 1, 2, 3)]}


def quads_at(fields, step):
    """Each (faces, 4, 3), with the number of its part."""
    for number, grid in enumerate(fields["grids"].values()):
        key = list(fields["grids"])[number]
        x = grid["points"][:] + fields[f"steps/{step}/{key}/displacement"][:]
        cells = grid["cells"][:]
        if cells.shape[1] in sides:
            for side in sides[cells.shape[1]]:
                yield number, x[cells[:, side]]


figure, axes = plt.subplots(3, 3, figsize=(11, 6), layout="constrained", sharex=True, sharey=True)
for row, name in zip(axes, ("superelement", "mesh", "rigid")):
    with h5py.File(folder / f"{name}.fields.h5") as fields:
        times = fields["times"][:]
        for axis, step in zip(row, (0, len(times) // 2, len(times) - 1)):
            found = list(quads_at(fields, step))
            part = np.concatenate([np.full(len(q), number) for number, q in found])
            colours = plt.cm.viridis(0.1 + 0.8 * (part * 0.618 % 1))
            side_view(axis, np.concatenate([q for _, q in found]), colours, f"as: {name}, {1e3 * times[step]:.0f} ms")
for axis in axes[:, 0]:
    axis.set_ylabel("height [mm]")
save(figure, folder / "tumbling-parts.png", dpi=90)
