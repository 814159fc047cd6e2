#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the mounted machine: the swing of a mass on a spring and a dashpot, and the six frequencies of a rigid body on its mount."""
import sys

import h5py
import numpy as np
import scipy.linalg

sys.path.append("..")
from checks import report

SIDES, DENSITY, MOTOR, MOTOR_INERTIA, GRAVITY = np.array([0.4, 0.3, 0.2]), 7850, 50.0, np.array([0.4, 0.4, 0.6]), 9.81
STIFFNESS = np.array([4e5, 4e5, 1e6, 1e5, 1e5, 1e5])
DAMPING_Z = 2000.0
block = DENSITY * SIDES.prod()
block_inertia = block / 12 * (np.sum(SIDES**2) - SIDES**2)


def mass_at_foot(mass, inertia, height):
    """Of a body that is `height` above the foot, for the foot's translation and rotation: 6 x 6."""
    r = np.array([[0, -height, 0], [height, 0, 0], [0, 0, 0]])  # r x
    return np.block([[mass * np.eye(3), -mass * r], [mass * r, np.diag(inertia) - mass * r @ r]])


M = mass_at_foot(block, block_inertia, SIDES[2] / 2) + mass_at_foot(MOTOR, MOTOR_INERTIA, SIDES[2])
hz_expected = np.sqrt(scipy.linalg.eigh(np.diag(STIFFNESS), M, eigvals_only=True)) / (2 * np.pi)

mass, k = block + MOTOR, STIFFNESS[2]
decay = DAMPING_Z / (2 * mass)
omega = np.sqrt(k / mass - decay**2)
sag = mass * GRAVITY / k

with h5py.File(sys.argv[1] + "/modes.h5") as f:
    hz = f["instances/machine/frequency_hz"][:]
with h5py.File(sys.argv[1] + "/machine.h5") as f:
    t = f["time"][:]
    z = f["surfaces/machine.foot/mean_position"][:, 2]
    total, external = f["energy/total"][:], f["energy/work_external"][:]
    work = sum(f["energy/" + name][:] for name in f["energy"] if name.startswith("work_"))
with h5py.File(sys.argv[1] + "/at-rest.h5") as f:
    at_rest = f["surfaces/machine.foot/mean_position"][:, 2]
z_expected = -sag * (1 - np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t)))

checks = [
    ("six frequencies, from a rigid body's", np.abs(hz / hz_expected - 1).max(), 1e-4),
    ("way of the foot, share of its sag", np.abs(z - z[0] - z_expected).max() / sag, 5e-5),
    ("foot after a preload, from the sag, share of it", np.abs(at_rest - z[0] + sag).max() / sag, 1e-6),
    ("energy that no work accounts for, share", np.abs(total - total[0] - work).max() / external[-1], 1e-10),
]
print(f"sag {sag * 1e3:.3f} mm; frequencies " + ", ".join(f"{f:.2f}" for f in hz) + " Hz")
sys.exit(report(checks))
