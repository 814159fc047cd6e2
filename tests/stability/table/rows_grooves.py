# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact in hollow corners: cubes that fall into a groove, from anywhere and turned anyhow, and slide to and fro in it."""
import h5py
import numpy as np

from parts import FACES, box
from runs import STEEL, reduction
from table import row

CHAPTER = "Contact"
HALF, SLOPES, RIDGES = 3.0, (0.1, 0.2, 0.5, 1.0, 2.0), (-0.3, -0.6, -1.2)  # half the groove's width and length; of its sides


def turn(rng):
    """A rotation, and the angles about fixed axes x, y, z in degrees by which a scene names it."""
    angles = rng.uniform(-180, 180, 3)
    R = np.eye(3)
    for axis, angle in enumerate(np.radians(angles)):
        c, s = np.cos(angle), np.sin(angle)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        A = np.eye(3)
        A[i, i], A[i, j], A[j, i], A[j, j] = c, -s, s, c
        R = A @ R
    return R, angles.tolist()


def groove(rng, slope):
    """z = slope |x|, below it three layers of thickness 2; the edge in the middle is one of elements too."""
    part = box((2 * int(rng.integers(1, 4)), int(rng.integers(1, 4)), 2), (2 * HALF, 2 * HALF, 2), (-HALF, -HALF, -2))
    part.nodes[:, 2] += slope * np.abs(part.nodes[:, 0])
    part.points = {"all": list(range(len(part.nodes)))}
    return part


def fall(folder, rng, slope, enforcement, integrator):
    """The run; how deep a node of the cube is in a side of the groove at any output; the most that contact has brought, over the largest energy. Nodes
    of a superelement that `exact` holds swing between the ends of steps, which counts as energy until they are let go: there outputs without contact."""
    cube = box((4, 4, 4), (1, 1, 1), (-0.5, -0.5, -0.5), kind=str(rng.choice(["hex8", "tet4"])))
    cube.faces = {"skin": [face for name in FACES for face in cube.faces[name]]}
    R, angles = turn(rng)
    x = cube.nodes @ R.T + np.append(rng.uniform(-0.6, 0.6, 2), 0)
    position = x.mean(0)
    position[2] += (slope * np.abs(x[:, 0]) - x[:, 2]).max() + 0.01
    velocity = 0.5 * rng.normal(size=3)
    velocity[2] = -abs(velocity[2]) - 0.3
    kind = str(rng.choice(["mesh", "superelement"]))
    mass = "consistent" if integrator == "central-difference" and rng.integers(2) else "lumped"
    scene = {"materials": {"soft": dict(STEEL, youngs_modulus=300.0)},
             "components": {"groove": {"mesh": folder.mesh(groove(rng, slope), "groove.msh"), "material": "soft"},
                            "cube": {"mesh": folder.mesh(cube, "cube.msh"), "material": "soft", "mass": mass, "reduction": reduction(["skin"], 12)}},
             "instances": {"groove": {"component": "groove", "as": "mesh"},
                           "cube": {"component": "cube", "as": kind, "position": position.tolist(), "rotation": angles, "velocity": velocity.tolist()}},
             "boundary": [{"instance": "groove", "nodes": "all", "fix": ["x", "y", "z"]}], "loads": [{"gravity": [0, 0, -2]}],
             "contact": [{"between": ["groove.z_max", "cube.skin"], **enforcement}],
             "time": {"end": 1.5, "step": "auto", "integrator": integrator, "rotations": "small"},
             "output": {"every": 0.02 if integrator == "newmark" else 0.05, "fields": ["displacement"]}}
    ran = folder.dyn(scene).done()
    with h5py.File(ran.file.with_suffix(".fields.h5")) as f:
        start = f["grids/1/points"][()]
        at = np.array([start + f[f"steps/{k}/1/displacement"][()] for k in sorted(f["steps"], key=int)])
    over = (np.abs(at[..., :2]) < HALF - 0.1).all(-1)
    depth = np.where(over, (slope * np.abs(at[..., 0]) - at[..., 2]) / np.hypot(1, slope), 0).max()
    brought = ran["energy/work_contact"]
    if integrator == "exact" and kind == "superelement":
        brought = brought[ran["contact/active"] == 0]
    return ran, max(depth, 0), max(brought.max(), 0) / ran["energy/total"].max()


def worst(folder, slope, seeds, ways):
    depth = gained = 0
    touched = True
    for seed in seeds:
        rng = np.random.default_rng([int(100 * abs(slope)), seed])
        enforcement, integrators = ways[seed % len(ways)]
        ran, deep, brought = fall(folder, rng, slope, enforcement, str(rng.choice(integrators)))
        depth, gained = max(depth, deep), max(gained, brought)
        touched = touched and ran["contact/groove.z_max - cube.skin/active"].max() > 0
    return depth, gained, touched


EXPLICIT, ANY = ("central-difference", "exact"), ("central-difference", "exact", "newmark")


@row(CHAPTER, "Cubes of 64 elements, full and reduced, that fall into a groove of few faces, held by impulses, with friction and without, in any integrator: depth of a "
              "node in the groove's sides, over the cube's; energy that contact brought, of all")
def impulses_in_groove(folder):
    ways = ({}, ANY), ({"friction": 0.3}, ANY)
    answers = []
    for slope in SLOPES:
        n = 24 if folder.full else 2
        depth, gained, touched = worst(folder, slope, range(n), ways)
        deepest, most = (2e-11, 1e-12) if slope > 0.1 else (5e-3, 0.01)  # sides that meet at less than 15 degrees hold a node one at a time
        answers.append((f"slope {slope:g}, {n} cubes", f"{depth:.0e}; {gained:.0e}", f"{deepest:g}; {most:g}", touched and depth < deepest and gained < most))
    return answers


@row(CHAPTER, "The same by springs: depth; energy that contact brought")
def springs_in_groove(folder):
    ways = (({"enforcement": "penalty"}, EXPLICIT),)
    answers = []
    for slope in SLOPES:
        n = 24 if folder.full else 2
        depth, gained, touched = worst(folder, slope, range(n), ways)
        answers.append((f"slope {slope:g}, {n} cubes", f"{depth:.2g}; {gained:.0e}", "0.15; 0.01", touched and depth < 0.15 and gained < 0.01))
    return answers


@row(CHAPTER, "The same by mortar, with friction and without, in any integrator, and over ridges (slopes below 0): depth of a node, where gaps are means over faces; energy that "
              "contact brought")
def mortar_in_groove(folder):
    ways = ({"formulation": "mortar"}, ANY), ({"formulation": "mortar", "friction": 0.3}, ANY)
    answers = []
    for slope in SLOPES + RIDGES:
        n = 24 if folder.full else 2
        depth, gained, touched = worst(folder, slope, range(n), ways)
        answers.append((f"slope {slope:g}, {n} cubes", f"{depth:.2g}; {gained:.0e}", "0.25; 0.02", touched and depth < 0.25 and gained < 0.02))
    return answers
