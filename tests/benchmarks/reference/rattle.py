#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""T1's block between two walls, as a curve: rattle.py OUT.txt r ... (even, ascending; BIN and OUT_DIR from the environment).

A quarter of the block (its planes of symmetry held) as a full mesh of 20 r x 5 r x 7.5 r hexes, central differences, impulses. The finest is the
answer; how far the next one is from it tells how far it may be trusted.
"""
import sys

import h5py
import numpy as np

from twin import results_of

GAP = 0.0076
SCENE = """materials:
  steel: {{youngs_modulus: 5.17e12, poissons_ratio: 0.3, density: 7836}}
components:
  quarter: {{mesh: {mesh}, material: steel}}
instances:
  quarter: {{component: quarter, as: mesh, velocity: [1905, 0, 0]}}
boundary:
  - {{instance: quarter, nodes: y_min, fix: [y]}}
  - {{instance: quarter, nodes: z_min, fix: [z]}}
walls:
  right: {{plane: {{point: [0.033, 0, 0], normal: [-1, 0, 0]}}}}
  left: {{plane: {{point: [-0.033, 0, 0], normal: [1, 0, 0]}}}}
contact:
  - {{between: [quarter.x_max, right]}}
  - {{between: [quarter.x_min, left]}}
time: {{end: 1.0e-4}}
output: {{every: 5.0e-7}}
"""


def run(r):
    """Times and x of the centre of mass."""
    with h5py.File(results_of(SCENE, "rattle", r)) as f:
        return f["time"][:], f["instances/quarter/center_of_mass"][:, 0]


def main():
    refinements = [int(word) for word in sys.argv[2:]]
    runs = [run(r) for r in refinements]
    t, x = runs[-1]
    with open(sys.argv[1], "w") as out:
        out.write(f"# T1's block between two walls, 7.6 mm from either at the start, 1905 m/s; the curve: r = {refinements[-1]}; made by tests/benchmarks/reference/rattle.py\n")
        for r, (_, other) in zip(refinements, runs):
            rms = [100 * np.sqrt(np.mean((other - x)[t <= end] ** 2)) / GAP for end in (2.5e-5, 5e-5, 1e-4)]
            out.write("# r = {}: rms {:.2f}, {:.2f}, {:.2f} % of the gap to 25, 50, 100 us from the curve\n".format(r, *rms))
        out.write("# time s, x of the centre of mass m\n")
        for row in zip(t, x):
            out.write("%.6e %.7e\n" % row)


if __name__ == "__main__":
    main()
