#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the ordinary part on the results in a folder; no times are judged.

Exit 1 and a line per figure that is missed.
"""
import sys

from runs import Runs, against

sys.path.append("..")
from checks import Checks


class Check(Checks):
    def __init__(self, folder):
        self.runs = Runs(folder)

    def holds(self, run):
        """Laws that every run obeys by itself, to round-off or to the solver's tolerance."""
        self.below(run.name, "energy that no work accounts for, share", run.balance, 1e-10)
        self.below(run.name, "energy above what there was at the start, share", run.gained, 1e-3)
        self.below(run.name, "largest residual of the contact laws", run.residual, 1e-8)
        brought = abs(run.p[0, 0])
        if not run.friction:
            change = abs(run.p[:, 0] - run.p[0, 0]).max() / brought
            self.below(run.name, "momentum along a floor without friction, share", change, 1e-10)

    def agrees(self, run, full):
        """A superelement against the full mesh `part`: 1.5 % of the way without friction, 4 % with
        it, and 15 % of the momentum along the floor. The small mesh of the tests is coarser than
        its wave lengths, so that the bounds are doubled there."""
        factor = 2 if run.mesh == "small" else 1
        off = against(run, full)
        way = 4 if run.friction else 1.5
        self.below(run.name, "centre of mass off, % of its way", off["way_percent"], way * factor)
        if run.friction:
            along = abs(off["momentum_off_percent"])
            self.below(run.name, "momentum along the floor off, %", along, 15 * factor)
        self.below(run.name, "its steps over the mesh's", run.steps / full.steps, 1)


def main():
    check = Check(sys.argv[1])
    for run in check.runs.all:
        check.holds(run)
        full = check.runs.full(run)
        if full and run is not full:
            check.agrees(run, full)
    return check.exit_code()


if __name__ == "__main__":
    sys.exit(main())
