# SPDX-License-Identifier: GPL-3.0-or-later
"""A steel ball of 10 mm that meets its equal or a rigid plane at 1 m/s: Hertz's closed form, and the quasi-static answer of a ball
that is finite (tests/support/hertz.hpp says how). SI units."""
import numpy as np

RADIUS, SPEED, MODULUS, POISSON, DENSITY = 10e-3, 1.0, 210e9, 0.3, 7850.0
MASS = DENSITY * 4 / 3 * np.pi * RADIUS**3


def hertz(plane):
    """Largest approach, force, duration, contact radius."""
    share = 1 if plane else 0.5
    modulus, radius, mass = share * MODULUS / (1 - POISSON**2), share * RADIUS, share * MASS
    approach = (15 * mass * SPEED**2 / (16 * modulus * np.sqrt(radius)))**0.4
    return approach, 4 / 3 * modulus * np.sqrt(radius) * approach**1.5, 2.943275 * approach / SPEED, np.sqrt(radius * approach)


def hertz_history(plane, n=2000):
    """Times and forces of Hertz's impact: m x'' = -k x^(3/2)."""
    approach, force, duration, _ = hertz(plane)
    return history(plane, np.linspace(0, 1, n) * 1.1 * approach, force * (np.linspace(0, 1, n) * 1.1)**1.5)


def history(plane, approach, force):
    """Times and forces from force against approach; also the largest of both, and the duration."""
    energy = 0.5 * MASS * SPEED**2 * (1 if plane else 0.5)
    work = np.concatenate([[0], np.cumsum((force[1:] + force[:-1]) / 2 * np.diff(approach))])
    largest = np.interp(energy, work, approach)
    n = 4000
    s = (np.arange(n) + 0.5) / n  # approach = largest (1 - s^2)
    speed = SPEED * np.sqrt(1 - np.interp(largest * (1 - s * s), approach, work) / energy)
    time = np.concatenate([[0], np.cumsum(2 * largest * s / speed / n)])
    f = np.interp(largest * (1 - (np.arange(n + 1) / n)**2), approach, force)
    return np.concatenate([time[-1] - time[::-1], time[-1] + time]), np.concatenate([f[::-1], f]), largest, f[0], 2 * time[-1]


def finite_ball(plane):
    mu, nu, R = MODULUS / (2 * (1 + POISSON)), POISSON, RADIUS

    def compliance(a):
        # Legendre series of the pressure, and the traction that it leaves along the surface because it pushes along the axis
        n = np.arange(2.0, int(40 * R / a))
        c = np.concatenate([[2 * (1 - 2 * nu) / (1 + nu), 6 * (1 - 2 * nu) / (5 * (1 + nu))],
                            (4 * (1 - nu) * n**2 + 2 * nu * n - 2 + 4 * nu) / ((n - 1) * (n * n + n + 1 + (2 * n + 1) * nu))])
        n = np.arange(float(len(c)))
        x = (n + 0.5) * a / R
        return np.sum(c * (2 * n + 1) * (3 * (np.sin(x) - x * np.cos(x)) / x**3)**2) / (16 * np.pi * mu * R) - (1 - 2 * nu) / (4 * np.pi * mu * R)

    a = hertz(plane)[3] * np.linspace(0, 1.15, 400)[1:]
    W = np.array([compliance(x) for x in a])
    slope = np.array([compliance(1.001 * x) - compliance(0.999 * x) for x in a]) / (0.002 * a)
    force = -2 * (2 * a / (5 * R)) / slope
    approach = (1 if plane else 2) * (a * a / (5 * R) + force * W)
    # Nearly force ~ approach^(3/2): the trapezoidal rule needs more points than the series
    fine = approach[-1] * np.linspace(0, 1, 20000)**1.5
    return history(plane, fine, np.interp(fine, np.append(0, approach), np.append(0, force)**(2 / 3))**1.5)
