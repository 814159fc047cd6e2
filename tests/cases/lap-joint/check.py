#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the lap joint: the bolt's force, equilibrium, a loop whose area is what friction takes, and superelements as the
meshes have it. Prints the table of README.md."""
import sys

import h5py
import numpy as np

sys.path.append("..")
from checks import report

PRETENSION = 5000.0
EXACT = ("craig-bampton", "massless", "characteristic")  # statics are those of the mesh


class Joint:
    """One run. Times: 0 the bolt is locked, 1 100 N, 2 to 6 a cycle of load, 6 to 10 another."""

    def __init__(self, name):
        with h5py.File(f"{sys.argv[1]}/{name}.h5") as f:
            def force(pair):
                return f[f"contact/{pair}/force"][:]

            def along(surface):
                return f[f"surfaces/{surface}/mean_position"][:, 0]

            self.time = f["time"][:]
            self.bolt = -force("head.cut - nut.cut")[:, 2]
            self.seat = force("washer.below - upper.outside")[:, 2]
            # On the upper plate: by the lower one and by the washer
            self.held = force("upper.inside - lower.inside")[:, 0] - force("washer.below - upper.outside")[:, 0]
            self.pull = f["instances/lower/reaction"][:, 0]
            self.end = along("upper.end")[0] - along("upper.end")
            self.slip = along("lower.inside") - along("upper.inside")
            self.friction, self.external = f["energy/work_friction"][:], f["energy/work_external"][:]
            self.contact, self.total = f["energy/work_contact"][:], f["energy/total"][:]
            self.seconds = f.attrs["wall_seconds_steps"]
        self.cycle = self.time >= 6 - 1e-9

    def change(self, values):
        """Over the second cycle."""
        return values[self.cycle][-1] - values[self.cycle][0]

    def area(self):
        """Of the second loop: force over displacement at the end."""
        u, pull = self.end[self.cycle], self.pull[self.cycle]
        return np.sum((pull[1:] + pull[:-1]) / 2 * np.diff(u))

    def figures(self):
        """mm, N, mJ"""
        return {"end": np.interp(1, self.time, self.end), "cycle": np.ptp(self.end[self.cycle]), "slip": np.ptp(self.slip[self.cycle]),
                "bolt": self.bolt[-1], "lost": -self.change(self.friction)}


names = ("mesh", *EXACT, "coarse-mesh", "coarse-craig-bampton")
runs = {name: Joint(name) for name in names}
print(f"| {'run':20s} | {'100 N, um':>10s} | {'cycle, um':>10s} | {'slip, um':>10s} | {'bolt, N':>10s} | {'lost, uJ':>10s} | {'s':>6s} |")
for name, run in runs.items():
    of = run.figures()
    print(f"| {name:20s} | {1e3 * of['end']:10.4f} | {1e3 * of['cycle']:10.4f} | {1e3 * of['slip']:10.4f} | {of['bolt']:10.2f} |"
          f" {1e3 * of['lost']:10.4f} | {run.seconds:6.1f} |")
# Where points slip a load step may end at 1e-5 of its displacements, and round-off says where: 4e-5 is the
# worst of OpenBLAS's kernels
SLIP = 4e-4
checks = []
for name, run in runs.items():
    checks += [
        # The length is locked, and slips of friction begin anew in the load step that finds the time 0
        (f"{name}: the bolt's force before the load, from the pretension", abs(run.bolt[0] / PRETENSION - 1), 2e-5),
        (f"{name}: the washer has the bolt's force", abs(run.seat / run.bolt - 1).max(), 1e-9),
        (f"{name}: friction holds the load, of 600 N", abs(run.held - run.pull).max() / 600, 1e-9),
        # The load is shared by areas, the displacement is a mean of nodes
        (f"{name}: the loop's area, from the work of the load", abs(run.area() / run.change(run.external) - 1), 1e-3),
        (f"{name}: energy is stored or lost, of what is stored",
         abs(run.change(run.total - run.external - run.contact - run.friction)) / run.total.max(), 1e-9),
        # Points of contact go with the faces from load step to load step
        (f"{name}: what contact itself takes, of what friction takes", abs(run.change(run.contact) / run.change(run.friction)), 0.02),
    ]


def slips(name):
    """mm: at the nodes of the upper plate, washers, ... in /grids, at the end of the run"""
    with h5py.File(f"{sys.argv[1]}/{name}.fields.h5") as f:
        steps = f["steps"]
        return [grid["contact_slip"][:, 0] for _, grid in sorted(steps[str(len(steps) - 1)].items())]


def compare(name, other, bound):
    one, two = runs[name].figures(), runs[other].figures()
    return [(f"{name}, {key}, from {other}", abs(one[key] / two[key] - 1), bound) for key in one]


print("largest slip of the mesh, um, in the order of instances:", *(f"{1e3 * slip.max():.4g}" for slip in slips("mesh")))
for name in EXACT:
    checks += compare(name, "mesh", SLIP)
    checks += [(f"{name}: largest slip of grid {g}, from mesh", abs(one.max() - two.max()), SLIP * two.max())
               for g, (one, two) in enumerate(zip(slips(name), slips("mesh"))) if two.max() > 0]
checks += compare("coarse-craig-bampton", "coarse-mesh", SLIP)
# The lower plate has elements a third longer
checks += compare("coarse-mesh", "mesh", 0.1)


class Tight:
    """The joint after its pretension: frequencies (Hz), a sweep (mm along x and z), and a pulse in motion."""

    def __init__(self, name):
        at = f"{sys.argv[1]}/{name}"
        self.frequencies, self.loose = (
            np.genfromtxt(f"{at}-{kind}.csv", delimiter=",", skip_header=1, usecols=2) for kind in ("modes", "loose")
        )
        with h5py.File(f"{at}-sweep.h5") as f:
            end = f["surfaces/upper.end"]
            self.sweep = np.hypot(end["displacement_real"][:], end["displacement_imag"][:])[:, [0, 2]]
        with h5py.File(f"{at}-pulse.h5") as f:
            end = f["surfaces/upper.end/mean_position"][:]
            self.end = end - end[0]
            self.lost = -f["energy/work_friction"][-1]
            self.seconds = f.attrs["wall_seconds_steps"]


mesh, reduced = Tight("mesh"), Tight("craig-bampton")
print("loose, Hz:", *(f"{hz:.5g}" for hz in mesh.loose))
print("tight, Hz:", *(f"{hz:.5g}" for hz in mesh.frequencies), f"; pulse: mesh {mesh.seconds:.1f} s, craig-bampton {reduced.seconds:.1f} s")
far = np.abs(reduced.end - mesh.end).max(axis=0) / np.ptp(mesh.end, axis=0)
checks += [
    ("tight: frequencies of craig-bampton from the mesh's", abs(reduced.frequencies / mesh.frequencies - 1).max(), 3e-3),
    ("loose: frequencies of craig-bampton from the mesh's", abs(reduced.loose / mesh.loose - 1).max(), 3e-3),
    # Linear as long as points stay closed and stick
    ("loose: its frequencies from those of the tight joint", abs(mesh.loose / mesh.frequencies - 1).max(), 1e-4),
    ("sweep: craig-bampton from the mesh", abs(reduced.sweep / mesh.sweep - 1).max(), 0.01),
    ("pulse: path of the end, x, of its length, from the mesh", far[0], 0.01),
    ("pulse: path of the end, z, of its length, from the mesh", far[2], 0.002),
    ("pulse: what friction takes, from the mesh", abs(reduced.lost / mesh.lost - 1), 0.02),
]
sys.exit(report(checks))
