#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the bracket with small features on the results in a folder: a line for each figure, and exit code 1 if one is missed. No times."""
import pathlib
import sys

import numpy as np

from runs import Runs, rms, rms_force

sys.path.append("..")
from checks import Checks


class Check(Checks):
    def __init__(self, folder):
        self.runs, self.folder = Runs(folder), folder

    def balances(self, run):
        """Momentum and energy: to round-off, each run by itself."""
        brought = run.p[0, 2]
        self.below(run.name, "momentum less what the wall gave, share", abs(run.p[-1, 2] - brought + run.impulse) / brought, 1e-10)
        self.below(run.name, "momentum along the wall (no friction), share", np.abs(run.p[:, :2]).max() / brought, 1e-10)
        self.below(run.name, "energy that no work accounts for, share", run.balance, 1e-10)
        self.below(run.name, "energy kept, above 1 (the contact brings none)", run.kept - 1, 1e-10)
        # The wall pulls at nothing: forces point out of it at any time.
        self.below(run.name, "pull of the wall, over the largest push", run.force.max() / np.abs(run.force).max(), 1e-10)

    def agrees(self, run, full):
        """A superelement against the full mesh. What it loses, rho_res of the energy in a flat blow, is fast motion of the pad's own layer, which takes
        no part in the rebound but through what is left in bending between the two blows. Bounds: rms 1 % of the way at 5 m/s over the contact time (measured: 0.1 to
        0.3 % with 80 modes, 0.8 % with 20), rebound 1 % of the speed with 80 modes, 3 % with 20 (0.3 %, 2 %). tet10 in place of
        tet4 changes the mesh's own rebound by 9 %."""
        if run.modes < 20 or (run.factor or 1) > 4:
            return
        self.below(run.name, "rms of the pad's position against the full mesh", rms(run, full), 0.01)
        self.below(run.name, "rebound, off the full mesh's, share of the speed", abs(run.rebound - full.rebound), 0.01 if run.modes >= 80 else 0.03)
        self.below(run.name, "rms of the force in windows of 6 us against the full mesh", rms_force(run, full), 0.05)
        if not run.factor:
            # Both blows lose at most rho_res each, on top of what the mesh loses by its own face layer.
            self.below(run.name, "energy lost beyond the mesh, over rho_res", (full.kept - run.kept) / run.rho_res, 2)
        # The step of the mesh is that of its smallest tetrahedra, ours that of the pad.
        self.below(run.name, "its steps over the mesh's", run.steps / full.steps, 1 / 5)

    def modes(self, mesh):
        """More modes leave less mass without coordinates on the pad, and keep more energy."""
        found = [r for r in self.runs.all if r.mesh == mesh and r.kind == "k" and not r.factor]
        for fewer, more in zip(found, found[1:]):
            self.below(more.name, f"rho_res, over that of {fewer.modes} modes", more.rho_res / fewer.rho_res, 1)
            self.below(more.name, f"energy lost, over that with {fewer.modes} modes", (1 - more.kept) / (1 - fewer.kept), 1)


def main():
    check = Check(pathlib.Path(sys.argv[1]))
    for run in check.runs.all:
        check.balances(run)
        full = check.runs.full(run)
        if full and run is not full:
            check.agrees(run, full)
    for mesh in check.runs.meshes():
        check.modes(mesh)
    return check.exit_code()


if __name__ == "__main__":
    sys.exit(main())
