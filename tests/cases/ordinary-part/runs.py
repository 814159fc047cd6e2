#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The runs of a folder and their figures. As a program: runs.py FOLDER prints them as CSV."""
import csv
import pathlib
import re
import sys

import h5py
import numpy as np

from scene import NAME, reduction_of


class Run:
    """One results file. t (n); x, p (n x 3): centre of mass and momentum; force (n x 3): the floor's."""

    def __init__(self, path):
        self.name = path.stem
        self.mesh, self.model, friction = NAME.fullmatch(self.name).groups()
        self.friction = friction is not None
        with h5py.File(path) as f:
            body = f["instances/pedestal"]
            self.t, self.x, self.p = f["time"][:], body["center_of_mass"][:], body["momentum"][:]
            self.force = f["surfaces/pedestal.foot/force"][:]
            total = f["energy/total"][:]
            self.kept = total[-1] / total[0]
            self.gained = (total.max() - total[0]) / total[0]
            brought = f["energy/work_contact"][:] + f["energy/work_friction"][:]
            self.balance = np.abs(total - total[0] - brought).max() / total[0]
            self.rubbed = -f["energy/work_friction"][-1]
            self.residual = f["contact/pedestal.foot - floor/residual"][:].max()
            self.steps, self.dofs = int(f.attrs["steps"]), int(f.attrs["n_dofs"])
            read, setup = f.attrs["wall_seconds_read"], f.attrs["wall_seconds_setup"]
            self.setup = float(read + setup)
            self.seconds = float(f.attrs["wall_seconds_steps"])
        self.reduction = reduction_seconds(path.parent / f"{reduction_of(self.name)}.reduce.txt")

    def way(self):
        """Length of the centre of mass's way, m."""
        return np.linalg.norm(np.diff(self.x, axis=0), axis=1).sum()


def reduction_seconds(path):
    """Of the whole reduction, from what cbr-reduce --verbose printed; None for a full mesh."""
    if not path.exists():
        return None
    total = re.search(r"^ +total +([\d.]+) s", path.read_text(), re.M)
    return float(total[1]) if total else None


class Runs:
    def __init__(self, folder):
        paths = sorted(pathlib.Path(folder).glob("*-*.h5"))
        found = [Run(p) for p in paths if NAME.fullmatch(p.stem)]
        order = ["full", "shapes", "nodes"]
        self.all = sorted(found, key=lambda r: (r.friction, r.mesh, order.index(r.model)))
        self.by_name = {r.name: r for r in self.all}

    def full(self, run):
        return self.by_name.get(f"{run.mesh}-full" + ("-friction" if run.friction else ""))

    def fine(self, run):
        return self.by_name.get("fine-full" + ("-friction" if run.friction else ""))


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
    values = dict(run=run.name, dofs=run.dofs, steps=run.steps, steps_s=run.seconds,
                  setup_s=run.setup, reduction_s=run.reduction, rebound=run.p[-1, 2] / down,
                  momentum_along=run.p[-1, 0] / run.p[0, 0], energy_kept=run.kept,
                  friction_J=run.rubbed, residual=run.residual)
    if full and full is not run:
        gain = full.seconds + full.setup - run.seconds - run.setup
        values |= against(run, full) | {"seconds_ratio": full.seconds / run.seconds}
        if run.reduction and gain > 0:
            values["break_even_runs"] = run.reduction / gain
    return {c: values.get(c) for c in COLUMNS}


def rows(folder):
    """The figures of every run in a folder, a dict of COLUMNS each."""
    runs = Runs(folder)
    return [row(r, runs.full(r) if r.mesh != "fine" else None) for r in runs.all]


def main():
    writer = csv.DictWriter(sys.stdout, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for figures in rows(sys.argv[1]):
        writer.writerow({c: "" if v is None else f"{v:.6g}" if isinstance(v, float) else v
                         for c, v in figures.items()})


if __name__ == "__main__":
    main()
