#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the paper's block impact on the results in a folder: a line for each figure, and exit code 1 if one is missed.

    check.py out
    check.py out MODES_A MODES_B MODES_C FIGURE ...    what fig3, fig5 and fig6 of plot.py must show
"""
import pathlib
import sys

from plot import CONVERGED, PAPER, SPEED, Run, paper_models, runs_of

sys.path.append("..")
from checks import Checks

COMMON = SPEED / 2  # both blocks after a perfectly plastic impact


class Check(Checks):
    def __init__(self, folder):
        self.folder, self.runs = folder, runs_of(folder)

    def left(self, name, wanted=CONVERGED[0], tolerance=0.005):
        """Velocity after the impact; the tolerance is a share of the speed before."""
        self.near(name, "left, m/s", self.runs[name].after[0], wanted, tolerance * SPEED)

    def both(self, name, wanted, tolerance):
        self.left(name, wanted[0], tolerance)
        self.near(name, "right, m/s", self.runs[name].after[1], wanted[1], tolerance * SPEED)

    def more_interface(self, names):
        """The paper: with the contact face alone the blocks stay together; with more interface the rebound returns in part."""
        lefts = [self.runs[f"{name}-nodal"].after[0] for name in names]
        ordered = all(more > less + 0.05 * SPEED for more, less in zip(lefts, lefts[1:]))
        self.near("nodal", "a > b > c > full", float(ordered), 1, 0)

    def drift(self, name):
        self.near(name, "momentum drift", self.runs[name].drift(), 0, 1e-10)

    def all_runs(self):
        # The impulse on superelements of any interface, and on the full mesh: the converged answer
        for name in ("a-impulse", "b-impulse", "c-impulse", "shapes-impulse", "full-impulse", "a100-impulse", "a500-impulse"):
            self.both(name, CONVERGED, 0.005)
        # The paper's finding: with node-lumped contact the contact face alone sticks, whatever the number of modes
        for name in ("a5-nodal", "a-nodal", "a100-nodal", "a500-nodal"):
            self.both(name, (COMMON, COMMON), 1e-3)
        self.more_interface(("a", "b", "c", "full"))
        for name in self.runs.paths:
            self.drift(name)
            # Nothing below a plastic impact, nothing gained
            self.near(name, "energy, end / start", self.runs[name].kept, 0.75, 0.26)

    def symmetry(self):
        """Half and quarter models against the whole mesh."""
        runs = {part: Run(self.folder / f"symmetry/{part}.h5")
                for part in (f"{size}-{kind}" for size in ("full", "half", "quarter") for kind in ("mesh", "superelement"))}
        for part, run in runs.items():
            tolerance = 1e-11 if part.endswith("mesh") else 0.005
            for block in ("left", "right"):
                self.near(part, f"{block}, m/s", run.v[block][-1], runs["full-mesh"].v[block][-1], tolerance * SPEED)

    def fig3(self, models):
        """The blocks touch when the gap has closed, and are apart again, with the converged velocities, before the end."""
        run = self.runs["full-impulse"]
        gap = run.x["right"] - run.x["left"]
        touching = run.t[gap < 1e-3 * gap[0]]
        self.near("fig 3", "first touch, us", 1e6 * touching[0], 3.99, 0.11)
        self.near("fig 3", "last touch, us", 1e6 * touching[-1], 8.1, 0.4)
        self.left(run.name)

    def fig5(self, models):
        names = [models[interface][0] for interface in ("a", "b", "c", "full")]
        dofs = [self.runs[f"{name}-nodal"].dofs for name in names[:3]]
        self.near("fig 5", "dofs differ by", max(dofs) - min(dofs), 0, 0)
        self.left(f"{names[0]}-nodal", COMMON, 1e-3)
        self.more_interface(names)
        # With the full reduced mass every interface gives what the full mesh does
        for name in names:
            self.left(f"{name}-impulse")

    def fig6(self, models):
        for k in (5, 100, 500, models["a"][1]):
            self.left(f"a{k}-nodal", COMMON, 1e-3)
            self.left(f"a{k}-impulse", tolerance=0.005 if k > 5 else 0.04)
            for enforcement in PAPER:
                self.drift(f"a{k}-{enforcement}")


def main():
    check = Check(pathlib.Path(sys.argv[1]))
    for figure in sys.argv[5:]:
        getattr(check, figure)(paper_models(*map(int, sys.argv[2:5])))
    if len(sys.argv) == 2:
        check.all_runs()
        check.symmetry()
    return check.exit_code()


if __name__ == "__main__":
    sys.exit(main())
