#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""check.py FOLDER: a table of the runs, and what they must show: momentum is that of gravity and walls, energy is accounted for and contact adds none."""
import pathlib
import sys

import h5py
import numpy as np

sys.path.append("..")
from checks import Checks

folder = pathlib.Path(sys.argv[1])
walls = ("floor", "west", "east", "south", "north")
checks = Checks()
print(f"{'parts':14s} {'coordinates':>11s} {'steps':>7s} {'stepping s':>11s} {'pairs that touch':>17s} {'energy lost':>12s} {'turned up to':>13s}")
runs = {name: h5py.File(folder / f"{name}.h5") for name in ("superelement", "mesh", "rigid")}
for name, f in runs.items():
    total, loads = f["energy/total"][:], f["energy/work_external"][:]
    w = max(abs(2 * np.degrees(np.arccos(np.clip(abs(body["orientation"][:, 0]), 0, 1)))).max() for body in f["instances"].values())
    pairs = sum(isinstance(pair, h5py.Group) and np.any(pair["active"][:]) for pair in f["contact"].values())
    lost = (total[0] + loads[-1] - total[-1]) / (total[0] + loads[-1])
    print(f"{name:14s} {f.attrs['n_dofs']:11d} {f.attrs['steps']:7d} {f.attrs['wall_seconds_steps']:11.3g} {pairs:17d} {100 * lost:10.1f} % {w:9.0f} deg")
for name, f in runs.items():
    time = f["time"][:]
    energy = {key: f[f"energy/{key}"][:] for key in f["energy"]}
    left = energy["total"] - sum(energy[key] for key in energy if key != "total")
    checks.below(f"{name}: energy that no work accounts for, share", abs(left - left[0]).max() / energy["total"].max(), 1e-12)
    if name == "mesh":
        # Central differences of what turns keep no energy exactly, and book what is left
        checks.below(f"{name}: energy that the steps give or take, share", abs(energy["work_numerical"]).max() / energy["total"].max(), 1e-4)
    given = energy["work_contact"] + energy["work_friction"]
    # The energy that contact takes swings while parts touch
    flies = f["contact/active"][:] == 0
    checks.below(f"{name}: energy that contact has given whenever all fly, share", given[flies].max() / energy["total"][0], 1e-9)
    bodies = list(f["instances"].values())
    momentum = sum(body["momentum"][:] for body in bodies)
    # Gravity moves the mass, walls give impulses: forces are means since the last output, on the first-named surface
    pushed = np.zeros_like(momentum)
    for pair, of in f["contact"].items():
        if isinstance(of, h5py.Group) and pair.split(" - ")[-1] in walls and len(of["force"]) == len(time):
            pushed[1:] += np.cumsum(of["force"][1:] * np.diff(time)[:, None], axis=0)
    free = momentum - pushed
    slope = np.polyfit(time, free[:, 2], 1)[0]  # the weight of all parts
    drift = free - free[0] - np.outer(time, [0, 0, slope])
    checks.below(f"{name}: momentum beside gravity's and the walls', share", abs(drift).max() / np.linalg.norm(momentum, axis=1).max(), 1e-12)
    checks.below(f"{name}: deepest penetration at an output, m", max(pair["penetration"][:].max() for pair in f["contact"].values() if isinstance(pair, h5py.Group)), 1e-9)
sys.exit(checks.exit_code())
