#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""scene.py PARTNER-KIND-M FOLDER: the scene of a run; PARTNER ball or plane, KIND mesh,
superelement (basis craig-bampton) or shapes (basis characteristic)."""
import pathlib
import sys

import numpy as np

from reference import DENSITY, MODULUS, POISSON, RADIUS, SPEED, hertz

partner, kind, m = sys.argv[1].split("-")
plane, whole = partner == "plane", kind != "mesh"
mesh = f"{'whole' if whole else 'quarter'}-{m}.msh"
volume = float((pathlib.Path(sys.argv[2]) / f"{mesh}.txt").read_text())
density = DENSITY * 4 / 3 * np.pi * RADIUS**3 * (1 if whole else 0.25) / volume
speed = SPEED if plane else SPEED / 2
end = float(1.15 * hertz(plane)[2])
basis = ", basis: characteristic" if kind == "shapes" else ""
reduction = f", reduction: {{interface: [contact], modes: 10{basis}, superelement: {kind}-{m}.cbr.h5}}" if whole else ""
lines = [
    f"materials: {{steel: {{youngs_modulus: {MODULUS!r}, poissons_ratio: {POISSON}, density: {float(density)!r}}}}}",
    f"components: {{ball: {{mesh: {mesh}, material: steel{reduction}}}}}",
    "instances:",
    f"  a: {{component: ball, as: {'superelement' if whole else 'mesh'}, position: [0, 0, 1.0e-8], velocity: [0, 0, {-speed!r}]}}",
]
if plane:
    lines += ["walls: {b: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}"]
else:
    lines += [f"  b: {{component: ball, as: {'superelement' if whole else 'mesh'}, mirror: z, velocity: [0, 0, {speed!r}]}}"]
if not whole:
    lines += ["boundary:"]
    for body in "a" if plane else "ab":
        lines += [f"  - {{instance: {body}, nodes: {axis}_plane, fix: [{axis}]}}" for axis in "xy"]
lines += [
    f"contact: [{{between: [a.contact, {'b' if plane else 'b.contact'}]}}]",
    f"time: {{end: {end!r}, step: {{cfl: {0.3 if whole else 0.9}}}}}",
    f"output: {{every: {end / 200!r}, history: [a.contact]{', fields: [contact_pressure]' if whole else ''}}}",
]
print("\n".join(lines))
