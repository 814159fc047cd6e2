# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the decomposition study on the results in OUT: check.py OUT. Exit code 1 if a figure is missed.

No time is judged: only answers, and the counts that --estimate gave before.
"""
import glob
import os
import sys

import h5py
import numpy as np

from plot import pick, read

sys.path.append("..")
from checks import Checks

# Of velocity and strain energy; ten times what was measured. `exact` goes through an eigenproblem of its own for each decomposition.
SAME = {"newmark": 4e-14, "central": 4e-14, "exact": 5e-13}


class Check(Checks):
    def __init__(self, out):
        self.out, self.rows = out, read(out)

    def path(self, row):
        return os.path.join(self.out, "{n}-{interface}-{domains}-{modes}-{kind}-t{threads}.h5".format(**row))

    def motion(self, row):
        """(time, mean displacement of the loaded face in x)."""
        with h5py.File(self.path(row)) as file:
            x = file["surfaces/cube.x_max/mean_position"][:, 0]
            return file["time"][:], x - x[0]

    def difference(self, row, other):
        """Largest difference of two motions, relative to the largest displacement."""
        (t, u), (s, v) = self.motion(row), self.motion(other)
        assert np.allclose(t, s, rtol=0, atol=1e-12)
        return np.abs(u - v).max() / np.abs(v).max()

    def worst(self, row, other):
        """Of velocity and strain energy: positions have no more than 12 digits of a displacement."""
        names = ("surfaces/cube.x_max/mean_velocity", "instances/cube/strain_energy")
        with h5py.File(self.path(row)) as a, h5py.File(self.path(other)) as b:
            return max(np.abs(a[n][:] - b[n][:]).max() / np.abs(b[n][:]).max() for n in names)

    def all_modes(self):
        """With every mode of every domain, one answer: whatever the domains, and it is the full mesh's."""
        for interface in ("faces", "surface"):
            for kind, bound in SAME.items():
                first, *others = pick(self.rows, modes="all", interface=interface, kind=kind)
                for row in others:
                    self.below(f"{interface}, {kind}, all modes: {row['domains']} domains against 1", self.worst(row, first), bound)
                if kind != "exact":  # the mesh's own steps
                    mesh = pick(self.rows, modes="all", kind="mesh-" + kind)[0]
                    self.below(f"{interface}, {kind}, all modes: 1 domain against the full mesh", self.worst(first, mesh), bound)

    def fifty_modes(self):
        """Truncation costs less than halving the mesh of 8^3 elements does, and the less the more domains keep 50 modes each."""
        def mesh(n):
            return pick(self.rows, n=n, kind="mesh-newmark", threads=2)[0]

        halved = self.difference(mesh(4), mesh(8))
        for n in sorted({r["n"] for r in pick(self.rows, modes="50")}):
            for interface in ("faces", "surface"):
                found = {r["domains"]: self.difference(r, mesh(n))
                         for r in pick(self.rows, n=n, modes="50", interface=interface, kind="newmark", threads=2)}
                for domains, error in found.items():
                    self.below(f"{n}^3, {interface}, 50 modes: {domains} domains against the full mesh", error, halved)
                    if domains >= 8:
                        self.below(f"{n}^3, {interface}, 50 modes: {domains} domains nearer than 1", error, found[1])

    def integrators(self):
        """Second order: half the step, a quarter of the difference from the exact motion."""
        for exact in pick(self.rows, n=8, modes="50", interface="faces", kind="exact"):
            for kind in ("newmark", "central"):
                errors = [self.difference(r, exact) for half in ("-12", "-6")
                          for r in pick(self.rows, n=8, modes="50", interface="faces", kind=kind + half, domains=exact["domains"])]
                if len(errors) == 2:
                    order = np.log2(errors[0] / errors[1])
                    self.below(f"8^3, {exact['domains']} domains, {kind}: order off 2 by (error {errors[1]:.1e})", abs(order - 2), 0.15)

    def threads(self):
        for row in pick(self.rows, threads=1, modes="50"):
            other = dict(row, threads=2)
            if pick(self.rows, **{k: other[k] for k in ("n", "interface", "domains", "modes", "kind", "threads")}):
                self.below(f"{row['n']}^3, {row['interface']}, {row['kind']}, {row['domains']} domains: 1 thread against 2", self.worst(row, other), 1e-12)

    def energy(self):
        """Kinetic and strain energy are the work done, to round-off."""
        worst = 0
        for path in glob.glob(os.path.join(self.out, "*.h5")):
            if path.endswith(".cbr.h5"):
                continue
            with h5py.File(path) as file:
                energy, work = file["energy/total"][:], file["energy/work_external"][:]
                worst = max(worst, np.abs(energy - energy[0] - work).max() / np.abs(work).max())
        self.below("energy that no work accounts for, the worst of all runs", worst, 2e-14)


def main():
    check = Check(sys.argv[1])
    check.all_modes()
    check.fifty_modes()
    check.integrators()
    check.threads()
    check.energy()
    sys.exit(check.exit_code())


if __name__ == "__main__":
    main()
