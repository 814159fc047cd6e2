# SPDX-License-Identifier: GPL-3.0-or-later
"""Shared by the tests of this folder: h5py and numpy, without which a test ends with exit code 77 (skipped); a run of a
program; a small mesh."""
import itertools
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import h5py
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

CELLS, SIZE = (4, 2, 2), (1.0, 0.5, 0.5)  # of write_mesh()
MATERIAL = ["--youngs-modulus", "2.1e11", "--poissons-ratio", "0.3", "--density", "7850"]


def ended(folder, program, *arguments, expect=0, **options):
    """A program that has run in a folder and ended with the exit code `expect`."""
    done = subprocess.run([program, "-q", *arguments], cwd=folder, capture_output=True, text=True, errors="replace", **options)
    assert done.returncode == expect, (program, arguments, done.returncode, done.stderr)
    return done


def run(folder, program, *arguments, expect=0, **options):
    """The standard error of that program."""
    return ended(folder, program, *arguments, expect=expect, **options).stderr


def contents(path):
    """Name -> values, of the datasets of a file."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
    return found


def datasets(path):
    """Name -> type, shape and bytes."""
    return {name: (x.dtype, x.shape, x.tobytes()) for name, x in contents(path).items()}


def differing(path, other):
    """Names of the datasets that are not the same in both files. AssertionError: there are none."""
    one, two = datasets(path), datasets(other)
    assert one, path
    return sorted(name for name in one.keys() | two.keys() if one.get(name) != two.get(name))


def write_mesh(name, cells=CELLS, size=SIZE, far=False):
    """A box of hexes, its face at the largest x named 'contact', with `far` that at x = 0 'far' (gmsh 2.2)."""
    nx, ny, nz = cells
    number = {at: 1 + i for i, at in enumerate(itertools.product(*(range(n + 1) for n in cells)))}
    nodes = [f"{i} " + " ".join(str(a * s / n) for a, s, n in zip(at, size, cells)) for at, i in number.items()]
    ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
    elements = []
    for x, y, z in itertools.product(range(nx), range(ny), range(nz)):
        corners = [number[x + a, y + b, z + c] for c in (0, 1) for a, b in ring]
        elements.append(f"5 2 1 1 {' '.join(map(str, corners))}")
    for y, z in itertools.product(range(ny), range(nz)):
        elements.append(f"3 2 2 2 {' '.join(str(number[nx, y + a, z + b]) for a, b in ring)}")
        if far:
            elements.append(f"3 2 3 3 {' '.join(str(number[0, y + a, z + b]) for a, b in reversed(ring))}")
    names = ['3 1 "solid"', '2 2 "contact"'] + ['2 3 "far"'] * far
    parts = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names)), *names, "$EndPhysicalNames",
             "$Nodes", str(len(nodes)), *nodes, "$EndNodes",
             "$Elements", str(len(elements)), *(f"{i} {e}" for i, e in enumerate(elements, 1)), "$EndElements", ""]
    name.write_text("\n".join(parts))


def check_in_turn(*checks):
    """Checks that find in one temporary folder what those before them left."""
    with tempfile.TemporaryDirectory() as name:
        for check in checks:
            check(Path(name))
    print("ok")
