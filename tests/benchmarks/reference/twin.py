#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The converged answer of the paper's block impact (T1), as a curve: twin.py OUT.txt r ... (even, ascending; BIN and OUT_DIR from the environment).

Two equal blocks that meet face to face are, in the frame of their common centre of mass, mirror images; each has two planes of
symmetry more. So a quarter of one block that meets a rigid wall at half the speed moves as the two blocks do, at an eighth of the cost:
full mesh, central differences, impulses, 20 r x 5 r x 7.5 r hexes (r even). The finest mesh is the answer, and its difference from the next one
tells how far it may be trusted: in contact meshes agree, but the faces ring after they part, and the phase of what rings does not converge
in powers of h, so that extrapolation (tried: polynomials in h) adds more than it takes. The mean over the face is the plain mean over its nodes, as
everywhere. OUT.txt: time, distance of the face from the plane of symmetry (below 0: on its side), mean velocity of the quarter.
"""
import os
import pathlib
import subprocess
import sys

import h5py
import numpy as np

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from runs import block_mesh  # noqa: E402

SPEED, END, EVERY = 3810.0, 1.2e-5, 1e-7
LENGTH, GAP = 0.0508, 0.0076  # of a block along x; of its face to the plane of symmetry
CONTACT = 4.25e-6

SCENE = """materials:
  steel: {{youngs_modulus: 5.17e12, poissons_ratio: 0.3, density: 7836}}
components:
  quarter: {{mesh: {mesh}, material: steel}}
instances:
  quarter: {{component: quarter, as: mesh, position: [{x}, 0, 0], velocity: [{speed}, 0, 0]}}
boundary:
  - {{instance: quarter, nodes: y_min, fix: [y]}}
  - {{instance: quarter, nodes: z_min, fix: [z]}}
walls:
  mirror: {{plane: {{point: [0, 0, 0], normal: [-1, 0, 0]}}}}
contact:
  - {{between: [quarter.contact, mirror], enforcement: impulse}}
time: {{end: {end}}}
output: {{every: {every}, history: [quarter.contact]}}
"""


def results_of(scene, name, r, **values):
    """The results of a scene of the quarter, which are computed where they are not there: OUT_DIR/NAME-R.h5."""
    stem = pathlib.Path(os.environ.get("OUT_DIR", ".")) / f"{name}-{r}"
    mesh, text, results = (stem.with_suffix(suffix) for suffix in (".msh", ".yaml", ".h5"))
    if not results.exists():
        block_mesh(mesh, (20 * r, 5 * r, 15 * r // 2), (LENGTH, 0.0127, 0.01905))
        text.write_text(scene.format(mesh=mesh.name, **values))
        subprocess.run([pathlib.Path(os.environ["BIN"]) / "cbr-dyn", text, "-o", results], check=True)
    return results


def run(r):
    """Times, distance of the face from the plane, mean velocity of the quarter, share of the energy that is kept."""
    with h5py.File(results_of(SCENE, "twin", r, x=-LENGTH / 2 - GAP, speed=SPEED / 2, end=END, every=EVERY)) as f:
        s = f["surfaces/quarter.contact/mean_position"][:, 0]
        momentum = f["instances/quarter/momentum"][:, 0]
        energy = f["energy/total"][:]
        return f["time"][:], s, momentum / momentum[0] * SPEED / 2, energy[-1] / energy[0]


def rms(difference):
    """Per cent of the speed of approach, 3810 m/s, times the duration of contact."""
    return 100 * np.sqrt(np.mean(difference**2)) / (SPEED * CONTACT)


def main():
    target = pathlib.Path(sys.argv[1])
    refinements = [int(word) for word in sys.argv[2:]]
    runs = [run(r) for r in refinements]
    t, position, velocity, _ = runs[-1]
    notes = [f"# r = {r}: rms {rms(of[1] - position):.3f} % of 3810 m/s x 4.25 us from the curve below, rebound {-of[2][-1] / (SPEED / 2):.4f}, "
             f"energy kept {of[3]:.4f}" for r, of in zip(refinements, runs)]
    for note in notes:
        print(note)
    with open(target, "w") as out:
        out.write("# Symmetric twin of T1; the curve: r = " + str(refinements[-1]) + "; made by tests/benchmarks/reference/twin.py\n")
        out.write("\n".join(notes) + "\n# time s, distance of the face from the plane of symmetry m, mean velocity m/s\n")
        for row in zip(t, position, velocity):
            out.write("%.6e %.7e %.5e\n" % row)


if __name__ == "__main__":
    main()
