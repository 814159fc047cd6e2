#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The press fit must show Lame's pressure and widening in plane stress, of superelements as of meshes."""
import sys

import h5py
import numpy as np

sys.path.append("..")
from checks import report

E, NU, BORE, OUTER, INTERFERENCE, THICKNESS = 2.1e5, 0.3, 10.0, 20.0, 0.01, 1.0
ratio = (OUTER**2 + BORE**2) / (OUTER**2 - BORE**2)
# Radial interference over the radius: the hub's (ratio + nu) p / E, and of a solid shaft (1 - nu) p / E
PRESSURE = {"hub": E * INTERFERENCE / BORE / (ratio + 1), "other": E * INTERFERENCE / BORE / (ratio + NU)}
PRESSURE["third"] = PRESSURE["hub"]
PAIR = {"hub": "shaft.outside - hub.inside", "other": "other.inside - arbor", "third": "drawn.outside - third.inside"}


def read(name, hub):
    """Pressure, from the force along x on the quarter, and the widening of the outside along x, a mean over its nodes."""
    with h5py.File(f"{sys.argv[1]}/{name}.h5") as f:
        x = f[f"surfaces/{hub}.outside/mean_position"][-1, 0]
        return abs(f[f"contact/{PAIR[hub]}/force"][-1, 0]) / (BORE * THICKNESS), x


angles = np.linspace(0, np.pi / 2, 13)  # of the nodes
checks = []
for hub, pressure in PRESSURE.items():
    widening = pressure * 2 * BORE**2 * OUTER / E / (OUTER**2 - BORE**2)
    for name in ("superelement", "mesh"):
        found, x = read(name, hub)
        checks += [
            (f"{hub}, {name}: pressure, from Lame's", abs(found / pressure - 1), 5e-3),
            (f"{hub}, {name}: widening, from Lame's", abs((x / np.cos(angles).mean() - OUTER) / widening - 1), 2e-3),
        ]
    checks.append((f"{hub}: pressure of the superelement, from the mesh", abs(read("superelement", hub)[0] / read("mesh", hub)[0] - 1), 1e-8))
    print(f"{hub}: {read('mesh', hub)[0]:.2f} MPa, in closed form {pressure:.2f}")
sys.exit(report(checks))
