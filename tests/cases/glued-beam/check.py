#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The glued beam must bend as a beam of its length, and have the frequencies of one mesh."""
import sys

import h5py
import numpy as np

sys.path.append("..")
from checks import report

E, NU, DENSITY, SIDE, LENGTH, FORCE = 2.1e11, 0.3, 7850.0, 0.04, 1.0, 1000.0
I, A, KAPPA = SIDE**4 / 12, SIDE**2, 10 * (1 + NU) / (12 + 11 * NU)  # Cowper's shear coefficient
sag = FORCE * LENGTH**3 / (3 * E * I) + FORCE * LENGTH * 2 * (1 + NU) / (KAPPA * E * A)
lowest = 1.8751**2 / (2 * np.pi) * np.sqrt(E * I / (DENSITY * A * LENGTH**4))

with h5py.File(sys.argv[1] + "/beam.h5") as f:
    z = f["surfaces/tip.x_max/mean_position"][:, 2]
hz, whole = (np.genfromtxt(f"{sys.argv[1]}/{name}.csv", delimiter=",", skip_header=1, usecols=2) for name in ("beam", "whole"))
print(f"tip {1e3 * (z[-1] - z[0]):.4f} mm, theory {-1e3 * sag:.4f}; Hz:", *(f"{f:.2f}" for f in hz))
print("one mesh, Hz:", *(f"{f:.2f}" for f in whole))
sys.exit(report([
    ("sag of the tip, from the theory of beams", abs((z[0] - z[-1]) / sag - 1), 0.01),
    ("lowest frequency, from Euler's", abs(hz[0] / lowest - 1), 0.01),
    ("six frequencies, from those of one mesh", np.abs(hz / whole - 1).max(), 2e-3),
]))
