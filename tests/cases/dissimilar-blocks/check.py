#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the dissimilar blocks on the results in a folder: a line for each figure, and exit code 1 if one is missed.

Bounds are errors of another kind measured in the same runs: a superelement may differ from the full mesh by less than that mesh
differs from the converged answer, a formulation from another likewise.
"""
import pathlib
import re
import sys

import numpy as np

from plot import BODIES, CONVERGED, SIZES, Impacts, load_rows, rms

sys.path.append("..")
from checks import Checks


class Check(Checks):
    def __init__(self, runs):
        self.runs = runs

    def velocity(self, name):
        return self.runs[name].v["right"][-1]

    def error(self, name):
        """Against the converged velocity of the impactor after the impact."""
        return abs(self.velocity(name) - CONVERGED[name.split("-")[0]][0])

    def balances(self, name):
        run = self.runs[name]
        self.below(name, "momentum drift", run.drift(), 1e-10)
        self.below(name, "energy that no work accounts for", run.balance, 1e-10)
        if "-penalty-" not in name and "-twoway-" not in name:  # a spring that is let go between two steps may bring some
            self.below(name, "energy gained", run.kept - 1, 1e-12)

    def reduced(self, shape, level):
        """Superelements against the full mesh: with 200 modes and more closer than that mesh to the converged answer, with fewer closer
        than that mesh to the one before."""
        runs, full, coarse = self.runs, f"{shape}-full-impulse-{level}", f"{shape}-full-impulse-m0x0"
        error = self.error(full) + CONVERGED[shape][1]
        step = abs(self.velocity(full) - self.velocity(coarse)) if full != coarse else error
        found = {k: f"{shape}-k{k}-impulse-{level}" for k in (25, 50, 100, 200, 400) if f"{shape}-k{k}-impulse-{level}" in runs}
        others = [f"{shape}-{model}-impulse-{level}" for model in ("face200", "b50", "mixed")]
        for name in (*found.values(), *(n for n in others if n in runs)):
            bound = error if re.search(r"-k[24]00-|-mixed-", name) else step
            self.below(name, "velocity against the full mesh, m/s", abs(self.velocity(name) - self.velocity(full)), bound)
        few, many = min(found), max(found)
        if many >= 8 * few:
            self.below(found[many], f"rms against the full mesh, % ({few} modes: bound)", rms(runs[found[many]], runs[full]), rms(runs[found[few]], runs[full]))
        kept = [runs[found[k]].kept for k in sorted(found)] + [runs[full].kept]
        self.below(full, "energy kept falls with more modes, full mesh last", -np.diff(kept).min(), 0)

    def formulations(self, shape, level):
        """Mortar against node-face, for full meshes and superelements."""
        for model in ("full", "k100", "k200"):
            names = [f"{shape}-{model}-{contact}-{level}" for contact in ("impulse", "mortar")]
            if all(n in self.runs for n in names):
                bound = self.error(names[0]) + CONVERGED[shape][1]
                self.below(names[1], "velocity against node-face, m/s", abs(self.velocity(names[1]) - self.velocity(names[0])), bound)

    def sides(self):
        """Whose nodes are held makes less of a difference than the mesh, and less still with mortar."""
        names = [f"brick-full-{contact}-m2x1" for contact in ("of-left", "of-right", "mortar-of-left", "mortar-of-right")]
        if names[0] in self.runs:
            nodes, mortar = (abs(self.velocity(names[i]) - self.velocity(names[i + 1])) for i in (0, 2))
            self.below(names[0], "velocity against of-right, m/s", nodes, self.error("brick-full-impulse-m2x1") + CONVERGED["brick"][1])
            self.below(names[2], "the same with mortar, m/s", mortar, nodes)

    def meshes(self, shape, contact, order):
        """The error falls with at least this order from mesh to mesh."""
        for coarse, fine, ratio in (("m0x0", "m1x1", SIZES[shape][0]), ("m1x1", "m2x2", 2)):
            names = [f"{shape}-full-{contact}-{m}" for m in (coarse, fine)]
            if all(n in self.runs for n in names):
                bound = ratio**-order * self.error(names[0]) + CONVERGED[shape][1]
                self.below(names[1], f"error against converged, m/s: order {order}", self.error(names[1]), bound)

    def nodal(self, shape, level):
        """The paper's kind of enforcement: right on a lumped mesh, wrong on superelements, where the impulse is right."""
        full, lumped, reduced = (f"{shape}-{m}-{level}" for m in ("full-impulse", "full-nodal", "k200-nodal"))
        if lumped not in self.runs:
            return
        self.below(lumped, "velocity against the impulse, m/s", abs(self.velocity(lumped) - self.velocity(full)), 1e-10 * abs(self.velocity(full)))
        impulse = abs(self.velocity(f"{shape}-k200-impulse-{level}") - self.velocity(full))
        self.below(reduced, "10 x the impulse's error, over the nodal one's", 10 * impulse / abs(self.velocity(reduced) - self.velocity(full)), 1)

    def row(self, rows):
        """Three bodies in a row: who meets whom, `all` like the pairs by name, superelements closer to their mesh than that to the next."""
        momenta = {name: np.array([run.p[body][-1] for body, _ in BODIES]) for name, run in rows.items()}
        for name, run in rows.items():
            self.below(name, "momentum drift", run.drift(), 1e-10)
            self.below(name, "energy that no work accounts for", run.balance, 1e-10)
            self.below(name, "energy gained", run.kept - 1, 1e-12)
            if not name.startswith("row-nodes"):  # the scene is symmetric; a node on an edge is held by one of its faces
                self.below(name, "momentum of the ball across the row, share", run.aside, 1e-8)
            touched = sum(bool(active.any()) for active in run.active.values())
            self.below(name, "pairs that touch, but for the two", abs(touched - 2), 0)
        for level in "01":
            reduced, pairs, full, finer = (f"row-{kind}" for kind in (f"cbr-{level}", f"pairs-{level}", f"full-{level}", f"full-{int(level) + 1}"))
            if pairs in rows:
                self.below(pairs, "momenta against contact: all, N s", np.abs(momenta[pairs] - momenta[reduced]).max(), 1e-9)
            if reduced in rows and finer in rows:
                mesh = np.linalg.norm(momenta[finer] - momenta[full])
                self.below(reduced, "momenta against the full mesh, N s", np.linalg.norm(momenta[reduced] - momenta[full]), mesh)


def main():
    folder = pathlib.Path(sys.argv[1])
    runs = Impacts(folder)
    check = Check(runs)
    for shape in ("sphere", "brick"):
        level = runs.level(shape)
        check.reduced(shape, level)
        check.formulations(shape, level)
        # Sphere: the mesh rounds it off by h^2; brick: the face's layer of nodes is stopped at once, and its mass goes with h
        for contact in ("impulse", "mortar"):
            check.meshes(shape, contact, 1.5 if shape == "sphere" else 1)
        check.nodal(shape, level)
        for name in runs.names(shape):
            check.balances(name)
    check.sides()
    check.row(load_rows(folder))
    return check.exit_code()


if __name__ == "__main__":
    sys.exit(main())
