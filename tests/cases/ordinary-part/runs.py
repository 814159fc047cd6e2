#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The runs of a folder and their figures. As a program: runs.py FOLDER prints them as CSV."""
import pathlib
import sys

import h5py
import numpy as np

from scene import NAME, reduction_of

sys.path.append("..")
import results


class Run(results.Run):
    """x, p, force (n x 3): centre of mass, momentum, the floor's force."""

    def __init__(self, path):
        super().__init__(path)
        self.mesh, self.model, friction = NAME.fullmatch(self.name).groups()
        self.friction = friction is not None
        self.p = self.momentum["pedestal"]
        with h5py.File(path) as f:
            self.x = f["instances/pedestal/center_of_mass"][:]
            self.force = f["surfaces/pedestal.foot/force"][:]
            self.residual = f["contact/pedestal.foot - floor/residual"][:].max()
        self.gained = self.energy["total"].max() / self.energy["total"][0] - 1
        self.rubbed = -self.energy["work_friction"][-1]
        self.reduction = results.said(path.parent / f"{reduction_of(self.name)}.reduce.txt", results.TOTAL)

    def way(self):
        """Length of the centre of mass's way, m."""
        return np.linalg.norm(np.diff(self.x, axis=0), axis=1).sum()


class Runs(results.Runs):
    def __init__(self, folder):
        super().__init__((p for p in pathlib.Path(folder).glob("*-*.h5") if NAME.fullmatch(p.stem)), Run)
        order = ["full", "shapes", "nodes"]
        self.all = sorted(map(self.get, self.paths), key=lambda r: (r.friction, r.mesh, order.index(r.model)))

    def full(self, run):
        return self.get(f"{run.mesh}-full" + ("-friction" if run.friction else ""))

    def rows(self):
        """The figures of every run."""
        return [row(r, self.full(r) if r.mesh != "fine" else None) for r in self.all]


COLUMNS = ("run", "dofs", "steps", "steps_s", "setup_s", "reduction_s", "way_percent", "rebound",
           "momentum_along", "momentum_off_percent", "energy_kept", "friction_J", "residual",
           "seconds_ratio", "break_even_runs")


def against(run, other):
    """Errors against another run of the same scene: per cent of its way, and of its momentum."""
    far = np.linalg.norm(run.x - other.x, axis=1).max() / other.way()
    along = (run.p[-1, 0] - other.p[-1, 0]) / other.p[-1, 0]
    return {"way_percent": 100 * far, "momentum_off_percent": 100 * along}


def row(run, full):
    """COLUMNS -> value; ratios and errors are against the full mesh on the same mesh."""
    down = -run.p[0, 2]
    values = run.costs(full) | dict(rebound=run.p[-1, 2] / down, momentum_along=run.p[-1, 0] / run.p[0, 0],
                                    friction_J=run.rubbed, residual=run.residual)
    if full and full is not run:
        values |= against(run, full)
    return {c: values.get(c) for c in COLUMNS}


if __name__ == "__main__":
    results.print_csv(COLUMNS, Runs(sys.argv[1]).rows())
