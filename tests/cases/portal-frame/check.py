#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the portal frame: the sway of frame theory in closed form, and the side load and frequencies of a frame of
Timoshenko beam elements, which is written here."""
import sys

import h5py
import numpy as np
import scipy.linalg

sys.path.append("..")
from checks import report

E, NU, DENSITY, SIDE, HEIGHT, SPAN, FORCE = 2.1e11, 0.3, 7850.0, 0.1, 3.0, 4.0, 1000.0
G, A, I = E / (2 * (1 + NU)), SIDE**2, SIDE**4 / 12
J = 0.140577 * SIDE**4  # Saint-Venant, square
KAPPA = 10 * (1 + NU) / (12 + 11 * NU)  # Cowper, rectangle


def beam(length):
    """K and M (12 x 12) of an element along x, dofs x y z rx ry rz of both ends: Timoshenko's stiffness, and the mass of Hermite's
    shapes with rotary inertia. Many short ones converge to Timoshenko's beam."""
    K, M = np.zeros((12, 12)), np.zeros((12, 12))
    two = np.array([[1, -1], [-1, 1]])
    for i, k, m in ((0, E * A, DENSITY * A), (3, G * J, DENSITY * 2 * I)):
        K[np.ix_([i, i + 6], [i, i + 6])] = k / length * two
        M[np.ix_([i, i + 6], [i, i + 6])] = m * length / 6 * np.array([[2, 1], [1, 2]])
    phi = 12 * E * I / (KAPPA * G * A * length**2)
    for (u, t), s in (((1, 5), length), ((2, 4), -length)):
        at = np.ix_([u, t, u + 6, t + 6], [u, t, u + 6, t + 6])
        K[at] = E * I / (1 + phi) / length**3 * np.array(
            [[12, 6 * s, -12, 6 * s], [6 * s, (4 + phi) * s * s, -6 * s, (2 - phi) * s * s],
             [-12, -6 * s, 12, -6 * s], [6 * s, (2 - phi) * s * s, -6 * s, (4 + phi) * s * s]])
        M[at] = DENSITY * A * length / 420 * np.array(
            [[156, 22 * s, 54, -13 * s], [22 * s, 4 * s * s, 13 * s, -3 * s * s],
             [54, 13 * s, 156, -22 * s], [-13 * s, -3 * s * s, -22 * s, 4 * s * s]])
        M[at] += DENSITY * I / (30 * length) * np.array(
            [[36, 3 * s, -36, 3 * s], [3 * s, 4 * s * s, -3 * s, -s * s],
             [-36, -3 * s, 36, -3 * s], [3 * s, -s * s, -3 * s, 4 * s * s]])
    return K, M


def frame(n):
    """K, M of the frame with n elements a member, its feet held, and the dof of the left corner along x."""
    corners = [np.array(c, float) for c in ((-2, 0, 0), (-2, 0, 3), (2, 0, 3), (2, 0, 0))]
    size = 6 * (3 * n + 1)
    K, M = np.zeros((size, size)), np.zeros((size, size))
    for member in range(3):
        way = corners[member + 1] - corners[member]
        x = way / np.linalg.norm(way)
        y = np.array([0.0, 1.0, 0.0])
        T = np.kron(np.eye(4), np.stack([x, y, np.cross(x, y)]))
        k, m = beam(np.linalg.norm(way) / n)
        for e in range(n):
            dofs = slice(6 * (member * n + e), 6 * (member * n + e) + 12)
            K[dofs, dofs] += T.T @ k @ T
            M[dofs, dofs] += T.T @ m @ T
    free = slice(6, size - 6)
    return K[free, free], M[free, free], 6 * (n - 1)


ratio = HEIGHT / SPAN  # of the girder's I / span to the legs' I / height
sway_of_theory = FORCE * HEIGHT**3 / (12 * E * I) * (3 * ratio + 2) / (6 * ratio + 1)
K, M, dof = frame(30)
pushed = np.zeros(len(K))
pushed[dof] = FORCE
sway_of_beams = np.linalg.solve(K, pushed)[dof]
hz_of_beams = np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True, subset_by_index=[0, 9])) / (2 * np.pi)

with h5py.File(sys.argv[1] + "/modes.h5") as f:
    (group,) = f["instances"].values()
    hz = group["frequency_hz"][:]
with h5py.File(sys.argv[1] + "/frame.h5") as f:
    left, right = (f[f"surfaces/girder.{end}/mean_position"][:] for end in ("left", "right"))
    foot = f["surfaces/left.foot/mean_position"][:]
    turned = f["surfaces/left.foot/rotation"][:]
    reaction = sum(f[f"instances/{leg}/reaction"][-1] for leg in ("left", "right"))
    total = f["energy/total"][-1]
sway, sway_right = (end[-1, 0] - end[0, 0] for end in (left, right))

# The rigid ends of a solid hinder its contraction (0.3) and its warping: it is a bit stiffer than a beam of the same length.
checks = [
    ("sway, from frame theory without shear", abs(sway / sway_of_theory - 1), 1e-2),
    ("sway, from beam elements", abs(sway / sway_of_beams - 1), 1.2e-2),
    ("strain energy, from the force's work", abs(total / (0.5 * FORCE * sway) - 1), 5e-9),
    ("reactions, share of the force", np.abs(reaction + [FORCE, 0, 0]).max() / FORCE, 1e-6),
    ("motion of a foot, share of the sway", max(np.abs(foot - foot[0]).max(), np.abs(turned).max()) / sway, 1e-9),
    ("ten frequencies, from beam elements", np.abs(hz / hz_of_beams - 1).max(), 1.5e-2),
]
print(f"sway {sway * 1e3:.4f} mm at the force, {sway_right * 1e3:.4f} mm at the other corner; theory {sway_of_theory * 1e3:.4f} mm")
print("frequencies " + ", ".join(f"{f:.3f}" for f in hz) + " Hz\nof beams    " + ", ".join(f"{f:.3f}" for f in hz_of_beams) + " Hz")
sys.exit(report(checks))
