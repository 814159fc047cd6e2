#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bouncing bar must keep its energy with basis massless, and its impacts must be those of a bar of length L and wave speed c: every
1 mm of path and 2 L / c apart. craig-bampton loses energy to the mass of the end's nodes."""
import sys

import h5py
import numpy as np

sys.path.append("..")
from checks import report
from results import differing

CONTACT = 2 * 0.1 / np.sqrt(2.1e11 / 7850)


def read(name):
    """Times of the reversals, and energy over the first."""
    with h5py.File(f"{sys.argv[1]}/{name}.h5") as f:
        t, v, energy = f["time"][:], f["instances/bar/momentum"][:, 0], f["energy/total"][:]
    at = np.flatnonzero(v[1:] * v[:-1] < 0)
    return t[at] + (t[at + 1] - t[at]) * v[at] / (v[at] - v[at + 1]), energy / energy[0]


reversals, energy = read("massless")
expected = 0.5e-3 + CONTACT / 2 + (1e-3 + CONTACT) * np.arange(10)
print(f"energy after ten impacts: massless {energy[-1]:.4f}, craig-bampton {read('craig-bampton')[1][-1]:.4f}")
sys.exit(report([
    ("datasets that a restart makes otherwise", len(differing(*(f"{sys.argv[1]}/{name}.h5" for name in ("massless", "restarted")))), 0),
    ("impacts other than ten", abs(len(reversals) - 10), 0),
    ("first reversal, share of the contact time", abs(reversals[0] - expected[0]) / CONTACT, 0.01),
    ("ten reversals, share of the time", np.abs(reversals / expected - 1).max(), 0.002),
    ("energy that contact took or gave", np.abs(energy[-1] - 1), 1e-3),
    ("energy of craig-bampton at the end is less", read("craig-bampton")[1][-1], 0.9),
]))
