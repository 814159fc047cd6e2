#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The runs of a folder and their figures. As a program: runs.py FOLDER prints them as CSV, a row for each run."""
import pathlib
import sys

import h5py
import numpy as np

from scene import NAME

sys.path.append("..")
import results

SPEED, TOUCH, MARGIN = 5.0, 1e-6, 0.9  # m/s, s; the share of the full mesh's critical step that it is run at


class Run(results.Run):
    """x, v, force (n): the pad's mean position and velocity, the wall's force on it, all in z."""

    def __init__(self, path):
        super().__init__(path)
        self.mesh, self.model, self.kind, modes, factor = NAME.fullmatch(self.name).groups()
        self.modes, self.factor = modes and int(modes), factor and float(factor)
        with h5py.File(path) as f:
            pad = f["surfaces/bracket.contact"]
            self.x, self.v, self.force = (pad[name][:, 2] for name in ("mean_position", "mean_velocity", "force"))
        self.p = self.momentum["bracket"]
        self.rebound = -self.p[-1, 2] / self.p[0, 2]
        self.impulse = -np.cumsum(self.force[1:] * np.diff(self.t)).take(-1)  # force: the mean since the last output
        printed = path.parent / f"{self.mesh}-{self.model}.reduce.txt"
        self.reduction, self.rho_res = (results.said(printed, what) for what in (results.TOTAL, r"rho_res .* z ([\d.]+)"))

    def contact_time(self):
        """From the first touch to the last force, s."""
        return self.t[np.abs(self.force) > 1e-3 * np.abs(self.force).max()][-1] - TOUCH

    def first_push(self):
        """Momentum that the wall has given until the pad first lets go, N s: the first of the two blows that the plate's bending makes."""
        acting = np.abs(self.force) > 1e-3 * np.abs(self.force).max()
        begin = np.argmax(acting)
        end = begin + np.argmin(acting[begin:])
        return -np.sum(self.force[begin:end] * np.diff(self.t)[begin - 1:end - 1])


def rms(run, reference):
    """Of the pad's mean position after the first touch, over the impact speed times the contact time."""
    assert run.t.size == reference.t.size, f"{run.name}, {reference.name}: other times"
    after = run.t > TOUCH
    return np.sqrt(np.mean((run.x - reference.x)[after] ** 2)) / (SPEED * reference.contact_time())


def rms_force(run, reference, window=6e-6):
    """Of the momentum that the wall gives within `window`, over the largest of it. A single output's force is ringing of the pad's own
    mesh: the window is a twentieth of the run, and shorter than any mode that moves the body."""
    n = max(1, int(round(window / (run.t[1] - run.t[0]))))
    smooth = [np.convolve(r.force, np.ones(n) / n, mode="same") for r in (run, reference)]
    return np.sqrt(np.mean((smooth[0] - smooth[1]) ** 2)) / np.abs(smooth[1]).max()


class Runs(results.Runs):
    def __init__(self, folder):
        super().__init__((p for p in pathlib.Path(folder).glob("*-*.h5") if NAME.fullmatch(p.stem)), Run)
        self.all = sorted(map(self.get, self.paths), key=lambda r: (r.mesh, r.model != "full", r.kind or "", r.modes or 0, r.factor or 0))

    def meshes(self):
        return sorted({r.mesh for r in self.all if r.mesh != "fine"}, key=lambda m: (len(m), m))

    def full(self, run):
        return self.get(f"{run.mesh}-full")

    def rows(self):
        """The figures of every run."""
        return [row(r, self.full(r)) for r in self.all]


COLUMNS = ("run", "dofs", "steps", "step_s", "ms_per_step", "steps_s", "setup_s", "reduction_s", "rms", "rms_force", "rebound", "rebound_off", "first_push_off",
           "energy_kept", "rho_res", "steps_ratio", "seconds_ratio", "break_even_runs")


def row(run, full):
    """COLUMNS -> value. Ratios and errors are against the full mesh on the same mesh; None where that says nothing."""
    values = run.costs(full) | dict(step_s=run.t[-1] / run.steps, ms_per_step=1e3 * run.seconds / run.steps, rebound=run.rebound,
                                    rho_res=run.rho_res)
    if full and full is not run:
        values.update(rms=rms(run, full), rms_force=rms_force(run, full), rebound_off=run.rebound - full.rebound,
                      first_push_off=(run.first_push() - full.first_push()) / run.p[0, 2], steps_ratio=full.steps / run.steps)
    return {c: values.get(c) for c in COLUMNS}


if __name__ == "__main__":
    results.print_csv(COLUMNS, Runs(sys.argv[1]).rows())
