# SPDX-License-Identifier: GPL-3.0-or-later
"""The three programs, a small scene for them, and what is required of what they leave behind."""
import os
import subprocess
import sys
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2] / "formats"))
import running  # noqa: E402
from running import datasets, differing  # noqa: E402, F401

BIN = Path(sys.argv[1]).resolve()
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


def write_mesh(name, cells=(5, 6, 6)):
    running.write_mesh(name, cells, (1.0, 1.0, 1.0))


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


def require_same(a, b, what):
    names = differing(a, b)
    assert not names, f"{what}: {len(names)} datasets differ: {names[:5]}"


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
