#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the slider-crank: the stroke, the loss by friction and the buffer's force against closed forms, superelement against mesh."""
import sys

import h5py
import numpy as np

sys.path.append("..")
from checks import report

CRANK, ROD, SPEED, RAMP = 0.1, 0.3, 100.0, 0.02
HINGE, SLIDE, BUFFER, GAP = 0.05, 20.0, 1.0e5, 0.185


def angle(t):
    return np.where(t < RAMP, SPEED * t**2 / (2 * RAMP), SPEED * (t - RAMP / 2))


def piston(t):
    return CRANK * np.cos(angle(t)) + np.sqrt(ROD**2 - (CRANK * np.sin(angle(t))) ** 2)


def read(name):
    with h5py.File(f"{sys.argv[1]}/{name}.h5") as f:
        energy = {key: f["energy/" + key][:] for key in f["energy"]}
        pin = f["surfaces/piston.pin/mean_position"][:, 0]
        tip = f["surfaces/crank.tip/mean_position"][:, :2]
        buffer = f["joints/piston.pin - ground/strain_energy"][:]
        return f["time"][:], pin, tip, energy, buffer


t, pin, tip, energy, stored = read("engine")
mesh = read("mesh")
dense = np.linspace(0, t[-1], 20001)
rod_angle = np.arcsin(-CRANK / ROD * np.sin(angle(dense)))
travel = [np.abs(np.diff(x)).sum() for x in (piston(dense), rod_angle - angle(dense), rod_angle)]
lost = SLIDE * travel[0] + HINGE * (travel[1] + travel[2])
pressed = np.maximum(0, CRANK + ROD - GAP - piston(t))
works = sum(energy[key] for key in energy if key.startswith("work_"))
top = np.abs(energy["total"]).max()
checks = [
    ("crank's pin, from its circle, share of the crank", np.abs(tip - CRANK * np.array([np.cos(angle(t)), np.sin(angle(t))]).T).max() / CRANK, 8e-13),
    ("piston, from a rigid rod, share of its stroke", np.abs(pin - piston(t)).max() / (2 * CRANK), 2e-4),
    ("piston, superelement against mesh, share of its stroke", np.abs(pin - mesh[1]).max() / (2 * CRANK), 1.5e-4),
    ("loss by friction, share of the closed form", abs(-energy["work_damping"][-1] / lost - 1), 6e-4),
    ("energy of the buffer, share of its largest", np.abs(stored - BUFFER * pressed**2 / 2).max() / (BUFFER * pressed.max() ** 2 / 2), 8e-3),
    ("energy that no work accounts for, share", np.abs(energy["total"] - energy["total"][0] - works).max() / top, 5e-14),
]
print(f"{angle(t[-1]) / (2 * np.pi):.2f} turns; loss {lost:.3f} J; buffer pressed by {1e3 * pressed.max():.2f} mm")
sys.exit(report(checks))
