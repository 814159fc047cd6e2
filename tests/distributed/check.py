#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""check.py BIN_DIR MPI_DIR: reductions in 1, 2 and 3 processes against one without MPI; what is refused; processes that die.

Needs mpirun of Open MPI and gmsh. A line per check; exit 1 when one fails.
"""
import concurrent.futures
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

import numpy as np
import h5py

from compare import differences

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BIN = pathlib.Path(sys.argv[1]).resolve()
REDUCE = str(pathlib.Path(sys.argv[2]).resolve() / "cbr-reduce")  # with MPI
STEEL = ["--youngs-modulus", "2.1e11", "--poissons-ratio", "0.3", "--density", "7850", "--exact-modes"]  # as several processes have
MESHES = {
    "block": ("meshes/block.geo", ["nx", "10", "ny", "5", "nz", "8"]),
    "large": ("meshes/block.geo", ["nx", "20", "ny", "20", "nz", "20"]),
    "pedestal": ("meshes/pedestal.geo", ["size", "11e-3"]),
    "bracket": ("meshes/bracket.geo", ["size", "1.2e-3", "ratio", "5"]),
    "plate": ("tests/cases/stress/plate.geo", []),
}
CASES = {
    "hexahedra, a face, the lowest modes": ["block.msh", "--interface", "contact", "--modes", "20", "--pick", "frequency"],
    "modes below a cutoff": ["block.msh", "--interface", "contact", "--cutoff-hz", "90000", "--pick", "frequency"],
    "no modes": ["block.msh", "--interface", "contact", "--modes", "0"],
    "tet10, consistent mass, modes by participation": ["pedestal.msh", "--interface", "foot", "--modes", "12"],
    "characteristic, hexahedra": ["block.msh", "--interface", "contact", "--basis", "characteristic", "--modes", "20"],
    "characteristic, tet4": ["bracket.msh", "--interface", "contact", "--basis", "characteristic", "--modes", "20"],
    "characteristic, the motion inside": ["bracket.msh", "--interface", "contact", "--basis", "characteristic", "--modes", "20", "--recovery"],
    "tet4, two faces, the motion inside": ["bracket.msh", "--interface", "contact", "--interface", "bore", "--modes", "10", "--pick", "frequency", "--recovery"],
}
LOADED = """materials:
  steel: {youngs_modulus: 2.1e11, poissons_ratio: 0.3, density: 7850}
components:
  plate:
    mesh: plate.msh
    material: steel
    reduction: {interface: [symmetry_x, symmetry_y, pulled], modes: 20, exact_modes: true, recovery: true, superelement: plate.cbr.h5}
instances:
  plate: {component: plate}
loads:
  - {instance: plate, surface: hole, traction: [1.0e6, 0, 0], history: {time: [0, 0.02], value: [0, 1]}}
time: {end: 0.025}
output: {every: 5.0e-4, history: [plate.pulled]}
"""
IMPACT = """materials:
  steel: {youngs_modulus: 5.17e12, poissons_ratio: 0.3, density: 7836}
components:
  block: {mesh: block.msh, material: steel, reduction: {interface: [contact], modes: 20, exact_modes: true, superelement: block.cbr.h5}}
instances:
  left:  {component: block, as: superelement, position: [-0.0279, 0, 0], velocity: [3810, 0, 0]}
  right: {component: block, as: superelement, position: [ 0.0381, 0, 0], mirror: x}
contact:
  - {between: [left.contact, right.contact], enforcement: impulse}
time: {end: 1.2e-5}
output: {every: 1.0e-6, history: [left.contact, right.contact]}
"""
REFUSED = {
    "basis: massless": ["--basis", "massless", "--modes", "20"],
    "tolerance": ["--tolerance", "0.01"],
}
ENVIRONMENT = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
failures = 0


def tell(what, wrong=""):
    global failures
    failures += bool(wrong)
    print(("FAILED  " if wrong else "passed  ") + what + (": " + wrong if wrong else ""), flush=True)


def several(n):
    """-q and the rest: mpirun's own words are left out, more processes than processors do not wait for each other in vain."""
    return ["mpirun", "-q", "--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1", "-n", str(n)]


def run(command, **options):
    return subprocess.run(command, env=ENVIRONMENT, text=True, capture_output=True, timeout=300, **options)


def reduced(where, arguments, n):
    """n processes; 0: the ordinary program, 1: --engine petsc."""
    command = (several(n) if n > 1 else []) + [REDUCE if n > 0 else str(BIN / "cbr-reduce"), *arguments, "--force", *(["--engine", "petsc"] if n == 1 else [])]
    done = run(command, cwd=where)
    if done.returncode != 0:
        raise RuntimeError(f"exit {done.returncode}: {done.stderr.strip()}")


def same(what, where, arguments, output, counts):
    try:
        reduced(where, arguments, 0)
        one = (where / output).rename(where / f"one-{output}")
        for n in counts:
            reduced(where, arguments, n)
            tell(f"{what}, {n} process{'es' if n > 1 else ''}", "; ".join(differences(one, where / output)))
    except RuntimeError as error:
        tell(what, str(error))


def domains(where):
    """Each process reduces its own domains by the ordinary way, so that the file is the ordinary one, byte by byte."""
    for what, more in (("domains", []), ("domains by a tolerance, with their interiors", ["--tolerance", "0.1", "--recovery"])):
        arguments = ["block.msh", "--interface", "contact", "--threads", "1", "--domains", "5", *(more or ["--modes", "8"]), *STEEL, "-o", "domains.cbr.h5"]
        reduced(where, arguments, 0)
        one = (where / "domains.cbr.h5").read_bytes()
        for n in (2, 3):
            reduced(where, arguments, n)
            tell(f"{what}, {n} processes", "" if (where / "domains.cbr.h5").read_bytes() == one else "the file is another")


def impact(where):
    """The ordinary cbr-dyn runs what several processes wrote."""
    (where / "impact.yaml").write_text(IMPACT)
    forces = []
    for n in (0, 2):
        reduced(where, ["impact.yaml", "-q"], n)
        done = run([str(BIN / "cbr-dyn"), "-q", "impact.yaml", "-o", f"impact-{n}.h5"], cwd=where)
        if done.returncode != 0:
            return tell("cbr-dyn", done.stderr)
        found = {}
        with h5py.File(where / f"impact-{n}.h5", "r") as file:
            file.visititems(lambda name, item: found.update({name: item[()]}) if isinstance(item, h5py.Dataset) and item.dtype.kind == "f" else None)
        forces.append({name: x for name, x in found.items() if "history" in name or "energy" in name})
    assert forces[0]
    worst = max(np.abs(x - forces[1][name]).max() / max(np.abs(x).max(), 1e-12) for name, x in forces[0].items())
    tell("cbr-dyn with the superelement of two processes", "" if worst < 1e-6 else f"histories differ by {worst:.1e}")


def one_line(done, word):
    """What is wrong with how a run was refused."""
    lines = [line for line in done.stderr.splitlines() if "error" in line]
    if done.returncode != 2:
        return f"exit {done.returncode}: {done.stderr.strip()}"
    return "" if len(lines) == 1 and word in lines[0] else f"{len(lines)} lines: {done.stderr.strip()}"


def refusals(where):
    for word, options in REFUSED.items():
        done = run([*several(2), REDUCE, "block.msh", "--interface", "contact", *options, *STEEL, "-o", "refused.cbr.h5"], cwd=where)
        tell("refused: " + word, one_line(done, word))
    for what, arguments, word in [("a mesh that is not there", ["nothing.msh", "--interface", "contact", "--modes", "5", *STEEL], "nothing.msh"),
                                  ("an unknown option", ["block.msh", "--no-such-option"], "--no-such-option"),
                                  ("an interface that is not there", ["block.msh", "--interface", "nowhere", "--modes", "5", *STEEL], "nowhere"),
                                  ("an engine of one process", ["block.msh", "--interface", "contact", "--engine", "cholmod", "--modes", "5", *STEEL], "--engine cholmod"),
                                  ("a scene on standard input", ["-"], "standard input")]:
        tell("refused: " + what, one_line(run([*several(2), REDUCE, *arguments], cwd=where, stdin=subprocess.DEVNULL), word))
    inverted(where)
    if list(where.glob("*refused*")):
        tell("refused runs", "leave a file")


def inverted(where):
    """An element that is wrong in one process's part alone."""
    lines = (where / "block.msh").read_text().splitlines()
    hexes = [i for i, line in enumerate(lines) if len(line.split()) == 9]
    tags = lines[hexes[-1]].split()
    lines[hexes[-1]] = " ".join([tags[0], *tags[5:9], *tags[1:5]])
    (where / "inverted.msh").write_text("\n".join(lines) + "\n")
    done = run([*several(3), REDUCE, "inverted.msh", "--interface", "contact", "--modes", "5", *STEEL, "-o", "refused.cbr.h5"], cwd=where)
    tell("refused: an inverted element", one_line(done, "inverted"))


def children(pid):
    text = pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return [int(child) for child in text]


def is_alive(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def are_gone(pids, seconds=10):
    end = time.monotonic() + seconds
    while any(map(is_alive, pids)) and time.monotonic() < end:
        time.sleep(0.1)
    return not any(map(is_alive, pids))


def ended(what, where, end):
    """A long run, of which `end` stops something after three seconds: an exit code, one line of ours, no file, no process."""
    command = [*several(2), REDUCE, "large.msh", "--interface", "contact", "--modes", "100", "--pick", "frequency", *STEEL, "-o", "ended.cbr.h5"]
    run_of_two = subprocess.Popen(command, cwd=where, env=ENVIRONMENT, text=True, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, start_new_session=True)
    ranks = []
    for _ in range(600):  # a machine that is busy starts them late
        ranks = children(run_of_two.pid)
        if len(ranks) == 2 or run_of_two.poll() is not None:
            break
        time.sleep(0.1)
    time.sleep(3)
    if len(ranks) != 2:
        return tell(what, f"{len(ranks)} processes: the run was over, or never began")
    end(run_of_two.pid, ranks)
    start = time.monotonic()
    try:
        _, words = run_of_two.communicate(timeout=30)
    except subprocess.TimeoutExpired:
        run_of_two.kill()
        return tell(what, "mpirun goes on")
    wrong = []
    if run_of_two.returncode == 0:
        wrong.append("exit 0")
    if not are_gone(ranks):
        wrong.append("a process is left")
    if list(where.glob("*ended*")):
        wrong.append("a file is left: " + str(list(where.glob("*ended*"))))
    lines = [line for line in words.splitlines() if line.startswith("cbr-reduce: error")]
    if len(lines) > 1:
        wrong.append(f"{len(lines)} messages")
    tell(f"{what} ({time.monotonic() - start:.1f} s, exit {run_of_two.returncode})", "; ".join(wrong))


def ends(where):
    ended("a process is killed", where, lambda mpirun, ranks: os.kill(ranks[1], signal.SIGKILL))
    ended("the first process is killed", where, lambda mpirun, ranks: os.kill(ranks[0], signal.SIGKILL))
    ended("Ctrl-C", where, lambda mpirun, ranks: os.kill(mpirun, signal.SIGINT))


def full_disk(where):
    """The first process may write files of 64 kB at most; shared memory of MPI is a file, too, so that they speak by TCP."""
    command = [*several(2), "--mca", "btl", "self,tcp", "sh", "-c", 'ulimit -f 64; exec "$@"', "sh", REDUCE, "block.msh",
               "--interface", "contact", "--modes", "20", *STEEL, "-o", "full.cbr.h5"]
    done = run(command, cwd=where)
    lines = [line for line in done.stderr.splitlines() if "cbr-reduce: error" in line]
    left = list(where.glob("*full*"))
    tell("a full disk", "" if done.returncode == 1 and len(lines) == 1 and not left else f"exit {done.returncode}, {left}: {done.stderr}")


def second_fails_alone(where):
    """It has no folder for its domains' files; the first waits for it. Its own words tell the cause."""
    script = '[ "$OMPI_COMM_WORLD_RANK" = 1 ] && export TMPDIR=/nonexistent; exec "$@"'
    command = [*several(2), "sh", "-c", script, "sh", REDUCE, "block.msh", "--interface", "contact", "--modes", "5",
               "--domains", "4", *STEEL, "-o", "alone.cbr.h5"]
    done = run(command, cwd=where)
    told = "TMPDIR is no folder" in done.stderr and "(in process 1)" in done.stderr
    left = list(where.glob("*alone*"))
    tell("the second process fails alone", "" if done.returncode == 1 and told and not left else f"exit {done.returncode}, {left}: {done.stderr}")


def main():
    with tempfile.TemporaryDirectory() as folder:
        where = pathlib.Path(folder)
        for name, (geo, numbers) in MESHES.items():
            options = [word for i in range(0, len(numbers), 2) for word in ["-setnumber", numbers[i], numbers[i + 1]]]
            subprocess.run(["gmsh", "-3", "-v", "1", str(ROOT / geo), *options, "-o", str(where / f"{name}.msh")], check=True)
        (where / "loaded.yaml").write_text(LOADED)
        # mpirun waits for most of its time: three pieces at once
        with concurrent.futures.ThreadPoolExecutor(3) as pool:
            pieces = [pool.submit(piece, where) for piece in (ends, domains, impact, refusals, full_disk, second_fails_alone)]
            pieces += [pool.submit(same, what, where, [*arguments, *STEEL, "-o", f"part-{i}.cbr.h5"], f"part-{i}.cbr.h5",
                                   (1, 2, 3) if "20" in arguments else (2, 3)) for i, (what, arguments) in enumerate(CASES.items())]
            pieces.append(pool.submit(same, "a load inside, residual vectors, the motion inside", where, ["loaded.yaml", "-q"], "plate.cbr.h5", (2, 3)))
        for piece in pieces:
            piece.result()  # throws what a piece has thrown
    sys.exit(1 if failures else 0)


main()
