# SPDX-License-Identifier: GPL-3.0-or-later
"""The three programs, a small scene for them, and what is required of what they leave behind."""
import itertools
import os
import subprocess
import sys
import time
from pathlib import Path

import h5py

BIN = Path(sys.argv[1]).resolve()
CELLS, SIZE = (5, 6, 6), (1.0, 1.0, 1.0)
SCENE = """
materials: {m: {youngs_modulus: 1, poissons_ratio: 0.3, density: 1}}
components:
  block: {mesh: box.msh, material: m, reduction: {interface: contact, modes: 20}}
  full: {mesh: box.msh, material: m}
instances:
  left: {component: block, as: superelement, position: [-1.001, 0, 0], velocity: [0.02, 0.005, 0]}
  right: {component: full, as: mesh, position: [1.02, 0.03, 0.02], mirror: x}
contact: [{between: [left.contact, right.contact], friction: 0.2}]
time: {end: END, integrator: exact, rotations: ROTATIONS}
output: {every: 0.1, history: [left.contact, right.contact]MORE}
"""
FIELDS = ", fields: [displacement, contact_pressure]"
CALLS = {"block.cbr.h5": ("cbr-reduce", "scene.yaml", "--force"),
         "skinned.msh": ("cbr-skin", "box.msh", "--sideset", "contact", "-o", "skinned.msh"),
         "results.h5": ("cbr-dyn", "scene.yaml", "-o", "results.h5")}


def write_mesh(name, cells=CELLS):
    """A box of hexes, its face at x = 1 named 'contact' (gmsh 2.2)."""
    number = {at: 1 + i for i, at in enumerate(itertools.product(*(range(n + 1) for n in cells)))}
    nodes = [f"{i} " + " ".join(str(a * s / n) for a, s, n in zip(at, SIZE, cells)) for at, i in number.items()]
    ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
    elements = []
    for x, y, z in itertools.product(*(range(n) for n in cells)):
        elements.append("5 2 1 1 " + " ".join(str(number[x + a, y + b, z + c]) for c in (0, 1) for a, b in ring))
    for y, z in itertools.product(range(cells[1]), range(cells[2])):
        elements.append("3 2 2 2 " + " ".join(str(number[cells[0], y + a, z + b]) for a, b in ring))
    parts = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "2", '3 1 "solid"', '2 2 "contact"', "$EndPhysicalNames",
             "$Nodes", str(len(nodes)), *nodes, "$EndNodes",
             "$Elements", str(len(elements)), *(f"{i} {e}" for i, e in enumerate(elements, 1)), "$EndElements", ""]
    name.write_text("\n".join(parts))


def scene(folder, more="", end=4, name="scene.yaml", rotations="auto"):
    (folder / name).write_text(SCENE.replace("END", str(end)).replace("ROTATIONS", rotations).replace("MORE", more))
    return name


def start(folder, program, *arguments, before=None, **options):
    environment = dict(os.environ, OPENBLAS_NUM_THREADS="1")
    return subprocess.Popen([BIN / program, "-q", *map(str, arguments)], cwd=folder, stdout=options.pop("stdout", subprocess.DEVNULL),
                            stderr=subprocess.PIPE, text=True, preexec_fn=before, env=environment, **options)


def run(folder, program, *arguments, expect=0, **options):
    """Runs to the end; the text of its errors."""
    process = start(folder, program, *arguments, **options)
    errors = process.communicate()[1]
    assert process.returncode == expect, f"{program} {arguments}: exit {process.returncode}, not {expect}: {errors}"
    if expect:
        told = [line for line in errors.splitlines() if ": warning: " not in line]
        assert len(told) == 1 and ": error: " in told[0], errors
    return errors


def datasets(path):
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: (item.dtype, item.shape, item[()].tobytes())})
                        if isinstance(item, h5py.Dataset) else None)
    return found


def require_same(a, b, what):
    a, b = datasets(a), datasets(b)
    assert len(a) > 10, what
    differing = sorted(name for name in a.keys() | b.keys() if a.get(name) != b.get(name))
    assert not differing, f"{what}: {len(differing)} of {len(a)} datasets differ: {differing[:5]}"


def require_no_temporary(folder, what=""):
    left = [name for name in os.listdir(folder) if name.endswith(".tmp")]
    assert not left, (what, left)


def prepared(folder):
    write_mesh(folder / "box.msh")
    run(folder, "cbr-reduce", scene(folder))


def wait_for(condition, process, seconds=120):
    until = time.monotonic() + seconds
    while not condition() and process.poll() is None:
        assert time.monotonic() < until, f"nothing came of {process.args} in {seconds} s"
        time.sleep(0.002)


def long_scene(folder, more=", checkpoint: {every_steps: 40}", name="long.yaml", rotations="auto"):
    return scene(folder, more, 60, name, rotations)
