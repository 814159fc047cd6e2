#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the shaken beam: tip and reaction as the transfer function of its matrices has them, work and energy in balance."""
import sys

import h5py
import numpy as np

sys.path.append("..")
from checks import report

HZ, ACCELERATION, ALPHA, BETA = 25.0, 10.0, 30.0, 1e-6
omega = 2 * np.pi * HZ

with h5py.File(sys.argv[1] + "/beam.cbr.h5") as f:
    eigenvalues, K_cc, M_cc, M_kc = (f["matrices/" + name][:] for name in ("eigenvalues", "K_cc", "M_cc", "M_kc"))
    node, component, X = f["dofs/node"][:], f["dofs/component"][:], f["nodes/coordinates"][:]
    x = X[:, 0]
    mass = float(f["rigid_body/mass"][()].item())
k, c = len(eigenvalues), len(node)
K = np.block([[np.diag(eigenvalues), np.zeros((k, c))], [np.zeros((c, k)), K_cc]])
M = np.block([[np.eye(k), M_kc], [M_kc.T, M_cc]])
held = k + np.flatnonzero(x[node] < x.min() + 1e-9)
free = np.setdiff1d(np.arange(k + c), held)
tip = k + np.flatnonzero((x[node] > x.max() - 1e-9) & (component == 2))
along = np.zeros(k + c)
along[k + np.flatnonzero(component == 2)] = 1
# A rotation about y through the centre of the clamped end
root = X[x < x.min() + 1e-9].mean(axis=0)
turned = np.zeros(k + c)
for i in range(c):
    turned[k + i] = (X[node[i], 2] - root[2], 0, -(X[node[i], 0] - root[0]))[component[i]]


def relative_motion(omega):
    """Of all coordinates, relative to the base: (K + i omega C - omega^2 M) w = -M 1 a; damping acts on it alone."""
    w = np.zeros(k + c, complex)
    D = K + 1j * omega * (ALPHA * M + BETA * K) - omega**2 * M
    w[free] = np.linalg.solve(D[np.ix_(free, free)], -(M @ along)[free] * ACCELERATION)
    return w


w = relative_motion(omega)
tip_expected = w[tip].mean()
# The supports' force is what changes the momentum
force_expected = mass * ACCELERATION - omega**2 * (along @ M @ w)
# and the angular momentum about the clamped end
moment_expected = turned @ M @ (along * ACCELERATION - omega**2 * w)

with h5py.File(sys.argv[1] + "/beam.h5") as f:
    t = f["time"][:]
    z = {name: f[f"surfaces/beam.{name}/mean_position"][:, 2] for name in ("x_min", "x_max")}
    reaction = f["instances/beam/reaction"][:, 2]
    moment = f["instances/beam/reactions/x_min/moment"][:, 1]
    apart = np.abs(f["instances/beam/reactions/x_min/force"][:, 2] - reaction).max() / np.abs(reaction).max()
    total, external, damping = (f["energy/" + name][:] for name in ("total", "work_external", "work_damping"))

with h5py.File(sys.argv[1] + "/sweep.h5") as f:
    hz = f["frequency_hz"][:]
    swept = f["surfaces/beam.x_max/displacement_real"][:, 2] + 1j * f["surfaces/beam.x_max/displacement_imag"][:, 2]
sweep_expected = np.array([relative_motion(2 * np.pi * f)[tip].mean() - ACCELERATION / (2 * np.pi * f) ** 2 for f in hz])


def amplitude(value, at):
    """Complex amplitude of the sine in the last fifth of the run, when the start has died away, beside a straight line."""
    late = at > 0.8
    columns = [np.sin(omega * at[late]), np.cos(omega * at[late]), np.ones(late.sum()), at[late]]
    s, c, _, _ = np.linalg.lstsq(np.array(columns).T, value[late], rcond=None)[0]
    return s + 1j * c


interval = t[1] - t[0]
mean = np.sinc(HZ * interval)  # of a sine over the interval between two outputs, which a reaction is the mean of
tip_found = amplitude(z["x_max"] - z["x_min"], t)
force_found = amplitude(reaction, t - interval / 2) / mean
moment_found = amplitude(moment, t - interval / 2) / mean
# The sine is a table of 200 points a period, whose amplitude is 8e-5 too small
checks = [
    ("tip beside the base, from the transfer function", abs(tip_found / tip_expected - 1), 2e-4),
    ("force of the shaker, likewise", abs(force_found / force_expected - 1), 2e-4),
    ("moment of the shaker, likewise", abs(moment_found / moment_expected - 1), 2e-4),
    ("reaction of the set beside that of the instance", apart, 1e-9),
    ("base, from its double integral", abs(amplitude(z["x_min"], t) / (-ACCELERATION / omega**2) - 1), 2e-4),
    ("sweep of the tip, from the transfer function", np.abs(swept / sweep_expected - 1).max(), 1e-7),
    ("energy that no work accounts for, share", np.abs(total - total[0] - external - damping).max() / total.max(), 1e-9),
]
print(f"tip: {abs(tip_found) * 1e3:.3f} mm, {abs(tip_found) * omega**2 / ACCELERATION:.2f} times the base's swing")
sys.exit(report(checks))
