#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The impact itself: waves of stress run through the blocks. Six instants and an animation, from fields.

    waves.py out/waves.fields.h5     out/waves.png, out/waves.gif
"""
import pathlib
import sys

import h5py
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.collections import PolyCollection

sys.path.append("..")
from plotting import plt, save

# Corners of a hex8 and of its sides.
SIDES = np.array([[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [0, 4, 7, 3], [0, 3, 2, 1], [4, 5, 6, 7]])
INSTANTS = (3.9, 4.6, 5.6, 6.6, 7.8, 9.4)  # microseconds: flight, the front starts, runs, comes back, they part
PERCENTILE = 99.5  # of all stresses: the end of the colours


class Body:
    """The view of a block along y: its sides at the lowest y."""

    def __init__(self, f, number):
        grid = f[f"grids/{number}"]
        self.f, self.number = f, number
        self.points, cells = grid["points"][:], grid["cells"][:]
        y = self.points[:, 1]
        seen = (y[cells[:, SIDES]] < y.min() + 1e-9 * np.ptp(y)).all(axis=2)  # cells x sides
        self.cell, side = np.nonzero(seen)
        self.nodes = cells[self.cell[:, None], SIDES[side]]

    def at(self, step):
        """Corners in mm (faces x 4 x 2: x and z) and stress in GPa."""
        values = self.f[f"steps/{step}/{self.number}"]
        x = 1e3 * (self.points + values["displacement"][:])[:, [0, 2]]
        return x[self.nodes], 1e-9 * values["stress_von_mises"][:, 0][self.cell]


def artist(axis, bodies, largest):
    collections = [PolyCollection([], cmap="magma_r", edgecolors="none", antialiased=False) for _ in bodies]
    for collection in collections:
        collection.set_clim(0, largest)
        axis.add_collection(collection)
    axis.set(xlim=(-57, 90), ylim=(-26, 26), aspect="equal")
    axis.axis("off")
    return collections


def show(collections, bodies, step):
    for collection, body in zip(collections, bodies):
        corners, stress = body.at(step)
        collection.set_verts(corners)
        collection.set_array(stress)


def main():
    path = pathlib.Path(sys.argv[1])
    with h5py.File(path) as f:
        times = 1e6 * f["times"][:]
        bodies = [Body(f, number) for number in f["grids"]]
        largest = np.percentile([body.at(step)[1] for step in range(len(times)) for body in bodies], PERCENTILE)

        fig, axes = plt.subplots(3, 2, figsize=(9, 5.4), layout="constrained")
        for axis, instant in zip(axes.flat, INSTANTS):
            step = int(np.argmin(np.abs(times - instant)))
            collections = artist(axis, bodies, largest)
            show(collections, bodies, step)
            axis.set_title(f"{times[step]:.1f} µs", loc="left", fontsize=9)
        fig.colorbar(collections[0], ax=axes, label="von Mises stress [GPa]", shrink=0.7)
        save(fig, path.parent / "waves.png")

        fig, axis = plt.subplots(figsize=(6.4, 2.5), layout="constrained")
        collections = artist(axis, bodies, largest)

        def draw(step):
            show(collections, bodies, step)
            axis.set_title(f"{times[step]:.1f} µs", loc="left", fontsize=9)
            return collections

        steps = np.flatnonzero(times > 3)
        FuncAnimation(fig, draw, frames=steps, blit=False).save(path.parent / "waves.gif", writer=PillowWriter(fps=12), dpi=80)
    print(f"plots: {path.parent}/waves.png {path.parent}/waves.gif")


if __name__ == "__main__":
    main()
