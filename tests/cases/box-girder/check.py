#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the girder: the sag and the bending frequencies of a thin-walled tube in closed form, and a superelement that
moves as its mesh."""
import sys

import h5py
import numpy as np

sys.path.append("..")
from checks import report

E, NU, DENSITY, SIDE, THICKNESS, LENGTH, FORCE = 2.1e11, 0.3, 7850.0, 0.1, 0.004, 1.0, 1000.0
G = E / (2 * (1 + NU))
I = 2 / 3 * SIDE**3 * THICKNESS + SIDE * THICKNESS**3 / 6  # thin walls: their middle lines, and the flat ones about their own
A, WEBS = 4 * SIDE * THICKNESS, 2 * SIDE * THICKNESS
G_A = G * WEBS * 0.85  # Cowper's share of the webs' shear, about
# Where the tube leaves the plug it gives a little, and so it turns there by some angle. It has no part in this difference:
# F L^3 / (3 E I) at the tip, less twice 5 F L^3 / (48 E I) at the middle.
bending_of_theory = FORCE * LENGTH**3 / (8 * E * I)


def first_hz(spring, n=200):
    """Of a Timoshenko beam on a spring against rotation, by many short elements with one point of integration for shear."""
    h, size = LENGTH / n, 2 * (n + 1)
    K, M = np.zeros((size, size)), np.zeros((size, size))
    for e in range(n):
        at = np.ix_(range(2 * e, 2 * e + 4), range(2 * e, 2 * e + 4))
        b, s = np.array([0, -1, 0, 1]) / h, np.array([-1 / h, -0.5, 1 / h, -0.5])
        K[at] += h * (E * I * np.outer(b, b) + G_A * np.outer(s, s))
        m = h / 6 * DENSITY * np.kron(np.array([[2, 1], [1, 2]]), np.diag([A, I]))
        M[at] += m
    M[-2, -2] += DENSITY * SIDE**2 * THICKNESS  # the lid
    K[1, 1] += spring
    K, M = K[1:, 1:], M[1:, 1:]
    L = np.linalg.cholesky(M)
    X = np.linalg.solve(L, np.linalg.solve(L, K).T)
    return np.sqrt(np.linalg.eigvalsh(X)[0]) / (2 * np.pi)


with h5py.File(sys.argv[1] + "/modes.h5") as f:
    hz = {name: group["frequency_hz"][:] for name, group in f["instances"].items()}
with h5py.File(sys.argv[1] + "/girder.h5") as f:
    tips = {name: f[f"surfaces/{name}/mean_position"][:] for name in ("mesh.tip", "mesh.middle", "reduced.tip")}
    reaction = {name: f[f"instances/{name}/reaction"][-1] for name in ("mesh", "reduced")}
    total = f["energy/total"][-1]
sag = {name: x[0, 2] - x[-1, 2] for name, x in tips.items()}
bending = sag["mesh.tip"] - 2 * sag["mesh.middle"]
angle = (sag["mesh.tip"] - FORCE * LENGTH**3 / (3 * E * I) - FORCE * LENGTH / G_A) / LENGTH
beam_hz = first_hz(FORCE * LENGTH / angle)

checks = [
    ("bending of the mesh, from beam theory", abs(bending / bending_of_theory - 1), 1.5e-2),
    # round-off of two factorisations of a slender part, in orders of their own
    ("sag of the superelement, from the mesh", abs(sag["reduced.tip"] / sag["mesh.tip"] - 1), 1.1e-9),
    ("two frequencies of bending, from a beam", np.abs(hz["mesh"][:2] / beam_hz - 1).max(), 5e-3),
    ("eight frequencies of the superelement, from the mesh", np.abs(hz["reduced"] / hz["mesh"] - 1).max(), 5e-3),
    ("reactions, share of the force", max(np.abs(r - [0, 0, FORCE]).max() for r in reaction.values()) / FORCE, 1e-9),
    ("strain energy, from the forces' work", abs(total / (0.5 * FORCE * (sag["mesh.tip"] + sag["reduced.tip"])) - 1), 1e-11),
]
print(f"sag {sag['mesh.tip'] * 1e3:.4f} mm, of which {angle * LENGTH * 1e3:.4f} mm by the angle at the plug; "
      f"first frequency {hz['mesh'][0]:.3f} Hz; beam {beam_hz:.3f} Hz")
print("frequencies of the mesh " + ", ".join(f"{f:.3f}" for f in hz["mesh"]) + " Hz")
sys.exit(report(checks))
