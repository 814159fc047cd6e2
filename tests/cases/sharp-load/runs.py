# SPDX-License-Identifier: GPL-3.0-or-later
"""The runs of a folder, and how far they are from the full mesh's exact solution."""
import sys

import h5py
import numpy as np

from scene import NAME

sys.path.append("..")
import results

SURFACES = ("contact", "load")  # the loaded face of the block; its two loaded element faces
PEAK, CORNER = 6.9e8, 3e-7      # Pa, s: the triangle of Table 3


class Run(results.Run):
    """x, v: surface -> n, mean displacement and velocity in x; impulse: the momentum at the end."""

    def __init__(self, path):
        super().__init__(path)
        self.mesh, self.hexes, self.model, self.scheme, unit, amount, self.skin = NAME.fullmatch(self.name).groups()
        self.multiple = float(amount) if unit == "x" else None  # of the critical step
        with h5py.File(path) as f:
            groups = {s: f["surfaces"]["block." + s] for s in SURFACES}
            self.x = {s: g["mean_position"][:, 0] for s, g in groups.items()}
            self.v = {s: g["mean_velocity"][:, 0] for s, g in groups.items()}
        self.impulse = -self.momentum["block"][-1, 0]
        self.h = self.t[-1] / self.steps
        self.numerical = np.abs(self.energy.get("work_numerical", np.zeros(1))).max()


class Reference:
    """Mean displacements of the full mesh, exact in time, at any time: cubic Hermite between known positions and velocities.
    The load's corners are among the known times, so that the error of the interpolation is h^4 / 384 of the fourth derivative."""

    def __init__(self, t, x, v, what):
        self.t, self.x, self.v, self.what = t, x, v, what
        self.largest = {s: np.abs(x[s]).max() for s in SURFACES}

    def at(self, t, surface):
        i = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, self.t.size - 2)
        h = self.t[i + 1] - self.t[i]
        s, x, v = (t - self.t[i]) / h, self.x[surface], self.v[surface]
        return (x[i] * (1 + 2 * s) * (1 - s) ** 2 + x[i + 1] * s**2 * (3 - 2 * s) + h * (v[i] * s * (1 - s) ** 2 + v[i + 1] * s**2 * (s - 1)))


def extrapolated(coarse, fine):
    """Of two runs, one with steps half as long: what central differences go to, to order 4, at the times of the first."""
    every = {q: {s: (4 * getattr(fine, q)[s][::2] - getattr(coarse, q)[s]) / 3 for s in SURFACES} for q in "xv"}
    return Reference(coarse.t, every["x"], every["v"], f"full mesh, explicit, extrapolated from steps of {1e9 * coarse.h:.3g} and {1e9 * fine.h:.3g} ns")


class Runs(results.Runs):
    def __init__(self, folder):
        super().__init__((p for p in folder.glob("*.h5") if NAME.fullmatch(p.stem)), Run)
        self.references = {}

    def all(self, **wanted):
        """Runs whose attributes are as given; a tuple allows several."""
        found = []
        for name in self.paths:
            run = self[name]
            if all(getattr(run, k) in (v if isinstance(v, tuple) else (v,)) for k, v in wanted.items()):
                found.append(run)
        order = {"full": "0", "all": "1"}
        return sorted(found, key=lambda r: (r.mesh, r.hexes, r.scheme, order.get(r.model, r.model[0]), len(r.model), r.model, r.skin or "", r.multiple is None, r.h))

    def meshes(self):
        return [m for m in ("coarse", "fine") if any(n.startswith(m) for n in self.paths)]

    def reference(self, mesh, hexes="bubble"):
        """The mesh with every mode in diagonal form, moved exactly, where there is one; else central differences, extrapolated."""
        key = f"{mesh}-{hexes}"
        if key not in self.references:
            exact = f"{key}-all-exact"
            if exact in self:
                run = self[exact]
                self.references[key] = Reference(run.t, run.x, run.v, "full mesh in diagonal form, exact")
            else:
                pairs = [(f"{key}-full-explicit-n{m}", f"{key}-full-explicit-n{2 * m}") for m in (96, 48, 24, 12)]
                pair = next((p for p in pairs if p[0] in self and p[1] in self), None)
                self.references[key] = extrapolated(self[pair[0]], self[pair[1]]) if pair else None
        return self.references[key]

    def difference(self, run, surface="contact", hexes=None, start=0.0):
        """Largest distance from the full mesh's exact solution, of its largest displacement."""
        reference = self.reference(run.mesh, hexes or run.hexes)
        return np.abs(run.x[surface] - reference.at(run.t, surface)).max() / reference.largest[surface]


def apart(first, second, surface="contact"):
    """Largest distance of two runs with the same times, of the largest displacement of the second."""
    assert first.t.size == second.t.size, f"{first.name}, {second.name}: other times"
    largest, gap = np.abs(second.x[surface]).max(), np.abs(first.x[surface] - second.x[surface]).max()
    return gap / largest if largest > 0 else gap  # a step longer than the load sees none of it: 0


def load_impulse(mesh):
    """Of the triangle on two element faces, N s."""
    ny, nz = {"coarse": (5, 8), "fine": (10, 15)}[mesh]
    return PEAK * CORNER * 2 * (0.0254 / ny) * (0.0381 / nz)
