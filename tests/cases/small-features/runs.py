#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The runs of a folder and their figures. As a program: runs.py FOLDER prints them as CSV, a row for each run."""
import csv
import pathlib
import re
import sys

import h5py
import numpy as np

from scene import NAME

SPEED, TOUCH, MARGIN = 5.0, 1e-6, 0.9  # m/s, s; the share of the full mesh's critical step that it is run at


class Run:
    """One results file. t (n); x, v, force (n): the pad's mean position and velocity, the wall's force on it, all in z."""

    def __init__(self, path):
        self.name = path.stem
        self.mesh, self.model, self.kind, modes, factor = NAME.fullmatch(self.name).groups()
        self.modes, self.factor = modes and int(modes), factor and float(factor)
        with h5py.File(path) as f:
            pad, body = f["surfaces/bracket.contact"], f["instances/bracket"]
            self.t, self.x, self.v = f["time"][:], pad["mean_position"][:, 2], pad["mean_velocity"][:, 2]
            self.force, self.momentum = pad["force"][:, 2], body["momentum"][:]
            total = f["energy/total"][:]
            self.kept = total[-1] / total[0]
            self.balance = np.abs(total - total[0] - f["energy/work_contact"][:]).max() / total[0]
            self.steps, self.dofs = int(f.attrs["steps"]), int(f.attrs["n_dofs"])
            self.setup = float(f.attrs["wall_seconds_read"] + f.attrs["wall_seconds_setup"])
            self.seconds = float(f.attrs["wall_seconds_steps"])
        self.mass = self.momentum[0, 2] / SPEED
        self.rebound = -self.momentum[-1, 2] / self.momentum[0, 2]
        self.impulse = -np.cumsum(self.force[1:] * np.diff(self.t)).take(-1)  # force: the mean since the last output
        self.reduction, self.rho_res = reduction_figures(path.parent / f"{self.mesh}-{self.model}.reduce.txt")

    def contact_time(self):
        """From the first touch to the last force, s."""
        return self.t[np.abs(self.force) > 1e-3 * np.abs(self.force).max()][-1] - TOUCH

    def first_push(self):
        """Momentum that the wall has given until the pad first lets go, N s: the first of the two blows that the plate's bending makes."""
        acting = np.abs(self.force) > 1e-3 * np.abs(self.force).max()
        begin = np.argmax(acting)
        end = begin + np.argmin(acting[begin:])
        return -np.sum(self.force[begin:end] * np.diff(self.t)[begin - 1:end - 1])


def reduction_figures(path):
    """Seconds of the reduction and rho_res in z, from what cbr-reduce --verbose printed; None for a full mesh."""
    if not path.exists():
        return None, None
    text = path.read_text()
    total, rho = re.search(r"^ +total +([\d.]+) s", text, re.M), re.search(r"rho_res .* z ([\d.]+)", text)
    return total and float(total[1]), rho and float(rho[1])


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


class Runs:
    def __init__(self, folder):
        found = [Run(p) for p in sorted(pathlib.Path(folder).glob("*-*.h5")) if NAME.fullmatch(p.stem)]
        self.all = sorted(found, key=lambda r: (r.mesh, r.model != "full", r.kind or "", r.modes or 0, r.factor or 0))
        self.by_name = {r.name: r for r in self.all}

    def __contains__(self, name):
        return name in self.by_name

    def __getitem__(self, name):
        return self.by_name[name]

    def meshes(self):
        return sorted({r.mesh for r in self.all if r.mesh != "fine"}, key=lambda m: (len(m), m))

    def full(self, run):
        return self.by_name.get(f"{run.mesh}-full")


COLUMNS = ("run", "dofs", "steps", "step_s", "ms_per_step", "steps_s", "setup_s", "reduction_s", "rms", "rms_force", "rebound", "rebound_off", "first_push_off",
           "energy_kept", "rho_res", "steps_ratio", "seconds_ratio", "break_even_runs")


def row(run, full):
    """COLUMNS -> value. Ratios and errors are against the full mesh on the same mesh; None where that says nothing."""
    values = dict(run=run.name, dofs=run.dofs, steps=run.steps, step_s=run.t[-1] / run.steps, ms_per_step=1e3 * run.seconds / run.steps, steps_s=run.seconds,
                  setup_s=run.setup, reduction_s=run.reduction, rebound=run.rebound, energy_kept=run.kept, rho_res=run.rho_res)
    if full and full is not run:
        gain = full.seconds + full.setup - run.seconds - run.setup
        values.update(rms=rms(run, full), rms_force=rms_force(run, full), rebound_off=run.rebound - full.rebound,
                      first_push_off=(run.first_push() - full.first_push()) / run.momentum[0, 2],
                      steps_ratio=full.steps / run.steps, seconds_ratio=full.seconds / run.seconds,
                      break_even_runs=run.reduction / gain if run.reduction and gain > 0 else None)
    return {c: values.get(c) for c in COLUMNS}


def rows(folder):
    """The figures of every run in a folder, a dict of COLUMNS each."""
    runs = Runs(folder)
    return [row(r, runs.full(r)) for r in runs.all]


def main():
    writer = csv.DictWriter(sys.stdout, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for figures in rows(sys.argv[1]):
        writer.writerow({c: "" if v is None else f"{v:.6g}" if isinstance(v, float) else v for c, v in figures.items()})


if __name__ == "__main__":
    main()
