# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the decomposition study and writes its times: study.py BIN OUT [fast]

OUT/times.csv gets one row for each run; rows that are there already are not run again. Times are wall times of the programs' own
clocks: cbr-reduce's total, and cbr-dyn's set-up and steps; the median of several runs.
"""
import csv
import os
import re
import statistics
import subprocess
import sys

import h5py
import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
FIELDS = ["n", "interface", "domains", "modes", "kind", "threads", "coordinates", "joined_dofs", "reduce_s", "setup_s", "steps", "step_s",
          "step_low_s", "step_high_s", "step_bytes", "predicted_bytes", "file_bytes"]
INTERFACES = {"faces": "[x_min, x_max]", "surface": "[surface]"}
# The text in place of TIME
KINDS = {
    "newmark": "integrator: newmark, step: 2.0e-8",
    "central": "integrator: central-difference",
    "exact": "integrator: exact",
    "second": "integrator: exact",
    "newmark-6": "integrator: newmark, step: 6.25e-9",
    "newmark-12": "integrator: newmark, step: 1.25e-8",
    "central-6": "integrator: central-difference, step: 6.25e-9",
    "central-12": "integrator: central-difference, step: 1.25e-8",
    "mesh-newmark": "integrator: newmark, step: 2.0e-8",
    "mesh-central": "integrator: central-difference",
}


def plan(fast):
    """(n, interface, domains, modes, kind, threads, repeats), cheap ones first."""
    runs = []
    # Every mode of every domain: the answers must be the same.
    for kind in ("newmark", "central", "exact"):
        runs += [(4, i, d, "all", kind, 2, 1) for i in INTERFACES for d in (1, 2, 4, 8)]
    runs += [(4, "faces", 1, "all", kind, 2, 1) for kind in ("mesh-newmark", "mesh-central")]
    # Order of the integrators, against the exact motion.
    runs += [(8, "faces", d, 50, kind, 2, 1) for d in (1, 4, 8) for kind in ("newmark-12", "newmark-6", "central-12", "central-6")]
    sizes = (8,) if fast else (8, 12, 16, 24)
    for n in sizes:
        cuts = (1, 2, 4, 8) if fast else (1, 2, 4, 8, 16) + ((27, 64) if n >= 12 else ())
        repeats = 1 if fast else 3
        for threads in (2,) if fast else (2, 1):
            for kind in ("mesh-newmark", "mesh-central"):
                runs.append((n, "faces", 1, 50, kind, threads, repeats))
            for d in cuts:
                runs += [(n, "faces", d, 50, kind, threads, repeats) for kind in ("newmark", "central")]
                if n <= 16 and not fast:
                    runs += [(n, "surface", d, 50, kind, threads, repeats) for kind in ("newmark", "central")]
        for d in cuts:
            if n <= 12:
                runs.append((n, "faces", d, 50, "exact", 2, repeats))
            if d > 1 and not fast:
                runs.append((n, "faces", d, 50, "second", 2, repeats))
    return runs


def name_of(n, interface, domains, modes, kind, threads):
    return f"{n}-{interface}-{domains}-{modes}-{kind}-t{threads}"


def scene(out, n, interface, domains, modes, kind, threads):
    """Path of the scene, cube.yaml with the run's values."""
    text = open(os.path.join(HERE, "cube.yaml")).read()

    def put(mark, value):
        nonlocal text
        pattern = re.compile(r"^(\s*[a-z_]+: )[^#\n]*(# " + mark + ")", re.M)
        text, count = pattern.subn(lambda m: f"{m[1]}{value}   {m[2]}", text)
        assert count == 1, mark

    second = "\n      second_reduction: {modes: 100}" if kind == "second" else ""
    keeps = "second" if kind == "second" else "joined"
    put("MESH", f"cube-{n}.msh")
    put("INTERFACE", INTERFACES[interface])
    put("DOMAINS", f"{domains}{second}")
    put("SUPERELEMENT", f"{n}-{interface}-{domains}-{modes}-{keeps}.cbr.h5")
    put("TIME", "{end: 3.0e-6, " + KINDS[kind] + "}")
    if modes == "all":
        text = re.sub(r"modes: 50 .*", "cutoff_hz: 1.0e12", text, count=1)
    else:
        put("MODES", modes)
    if kind.startswith("mesh"):
        text = text.replace("as: superelement", "as: mesh")
    path = os.path.join(out, name_of(n, interface, domains, modes, kind, threads) + ".yaml")
    with open(path, "w") as file:
        file.write(text)
    return path


def run(command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"study: {' '.join(command)} ended with {done.returncode}:\n{done.stderr}")
    return done


def make_mesh(out, n):
    path = os.path.join(out, f"cube-{n}.msh")
    if not os.path.exists(path):
        sides = [w for d in "xyz" for w in ("-setnumber", "n" + d, str(n), "-setnumber", "l" + d, "0.0191")]
        run(["gmsh", "-3", "-v", "2", os.path.join(HERE, "../../../meshes/block.geo"), *sides, "-o", path + ".tmp.msh"])
        os.replace(path + ".tmp.msh", path)


def reduce(binaries, path, n, threads, kind, repeats):
    """Median wall time, and what --estimate says: {row: its cells}."""
    # Without the diagonal form: it belongs to `exact`, and is no part of what the paper times.
    options = ["--threads", str(threads)] + ([] if kind == "second" else ["--diagonal-limit", "0"])
    reducer = os.path.join(binaries, "cbr-reduce")
    table = run([reducer, path, "--estimate", *options]).stdout
    rows = {}
    for line in table.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("|") and len(cells) in (2, 3):
            rows[cells[0]] = cells
    seconds = []
    for _ in range(repeats if n <= 12 else 1):
        told = run([reducer, path, "--force", *options]).stderr
        seconds.append(float(re.search(r"^\s*total\s+([0-9.]+) s", told, re.M)[1]))
    return statistics.median(seconds), rows


def bytes_of(text):
    number, unit = text.split()
    return float(number) * {"B": 1, "kB": 1e3, "MB": 1e6, "GB": 1e9}[unit]


def read_parts(path, held):
    """(modes, ids of the nodes) of each domain, ids of the nodes of the held sideset."""
    parts, fixed = [], set()
    with h5py.File(path) as file:
        groups = [file[f"domains/{d}"] for d in file["domains"]] if "domains" in file else [file]
        for group in groups:
            ids = group["nodes/id"][:]
            parts.append((len(group["matrices/eigenvalues"]), ids))
            if held in group.get("interface", {}):
                fixed.update(ids[np.unique(group[f"interface/{held}/faces"][:])])
    return parts, fixed


def factor_nonzeros(parts, fixed):
    of_node = {}
    for d, (_, ids) in enumerate(parts):
        for i in ids:
            if i not in fixed:
                of_node.setdefault(i, []).append(d)
    weight = {}  # nodes of the same domains are one
    for domains in of_node.values():
        weight[tuple(domains)] = weight.get(tuple(domains), 0) + 3
    near = {a: {b for b in weight if set(a) & set(b)} for a in weight}
    total = 0
    while near:
        one = min(near, key=lambda a: sum(weight[b] for b in near[a]))
        rows, w = sum(weight[b] for b in near[one]), weight[one]
        total += w * rows - w * (w - 1) // 2
        others = near.pop(one) - {one}
        for a in others:
            near[a] = (near[a] | others) - {one}
    return total


def step_bytes(path, held):
    """Bytes that one step of a coupled run reads, counted on the superelement file; `held`: the set that is held.

    Half of each K_cc (it is symmetric), each M_kc twice, and the factor of the joined nodes that are free, forward and
    backward. The factor is that of an elimination by least degree, as in cbr-reduce --estimate, which does not read
    the sets that a scene holds.
    """
    parts, fixed = read_parts(path, held)
    blocks = sum(c * (c + 1) // 2 + 2 * k * c for k, c in ((k, 3 * len(ids)) for k, ids in parts))
    return 8 * (blocks + 2 * factor_nonzeros(parts, fixed))


def measure(binaries, out, case, reductions):
    n, interface, domains, modes, kind, threads, repeats = case
    make_mesh(out, n)
    path = scene(out, *case[:-1])
    row = dict(zip(FIELDS, case[:-1]))
    if not kind.startswith("mesh"):
        key = (n, interface, domains, modes, kind == "second", threads)
        if key not in reductions:
            reductions[key] = reduce(binaries, path, n, threads, kind, repeats)
        row["reduce_s"], rows = reductions[key]
        step = {"newmark": "newmark", "central": "central-difference"}.get(kind)
        if step:
            row["step_bytes"] = step_bytes(superelement_of(out, path), "x_min")
            row["predicted_bytes"] = bytes_of(rows[step + ", of what is stored"][1])
        row["joined_dofs"] = int(rows["interface dofs, those of all domains once"][2])
        row["file_bytes"] = os.path.getsize(superelement_of(out, path))
    # 0: steps in the coordinates of the parts, whose mass is a full matrix, as the paper's; else in modal coordinates, where it is not.
    limit = ["--diagonal-limit", "0"] if kind.startswith(("central", "newmark")) else []
    setup, steps = [], []
    for _ in range(repeats):
        result = path[:-5] + ".h5"
        run([os.path.join(binaries, "cbr-dyn"), path, "-o", result, "--threads", str(threads), "--quiet", *limit])
        with h5py.File(result) as file:
            row["steps"], row["coordinates"] = int(file.attrs["steps"]), int(file.attrs["n_dofs"])
            setup.append(float(file.attrs["wall_seconds_setup"]))
            steps.append(float(file.attrs["wall_seconds_steps"]) / row["steps"])
    row["setup_s"] = statistics.median(setup)
    row["step_s"], row["step_low_s"], row["step_high_s"] = statistics.median(steps), min(steps), max(steps)
    return row


def superelement_of(out, path):
    return os.path.join(out, re.search(r"superelement: (\S+)", open(path).read())[1])


def main():
    binaries, out, fast = sys.argv[1], sys.argv[2], sys.argv[3:] == ["fast"]
    os.makedirs(out, exist_ok=True)
    table = os.path.join(out, "times.csv")
    done, reductions = {}, {}
    if os.path.exists(table):
        with open(table) as file:
            done = {tuple(r[f] for f in FIELDS[:6]): r for r in csv.DictReader(file)}
    for case in plan(fast):
        key = tuple(str(v) for v in case[:-1])
        if key in done:
            continue
        print("study:", name_of(*case[:-1]), flush=True)
        done[key] = measure(binaries, out, case, reductions)
        with open(table + ".tmp", "w", newline="") as file:
            writer = csv.DictWriter(file, FIELDS)
            writer.writeheader()
            writer.writerows(done.values())
        os.replace(table + ".tmp", table)


if __name__ == "__main__":
    main()
