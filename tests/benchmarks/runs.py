# SPDX-License-Identifier: GPL-3.0-or-later
"""Running the three programs for the benchmarks: time by phase, work, memory; repeated, in turns, medians."""
import csv
import os
import pathlib
import re
import statistics
import subprocess
import time


class Refused(Exception):
    """The program did not do it; the text is its error."""


def block_mesh(path, hexes, edges=()):
    """meshes/block.geo with these numbers of hexes and edges (m), where it is not there yet."""
    if not path.exists():
        sizes = zip(("nx", "ny", "nz", "lx", "ly", "lz"), (*hexes, *edges))
        numbers = [word for name, value in sizes for word in ("-setnumber", name, str(value))]
        new = path.with_suffix(".tmp.msh")
        subprocess.run(["gmsh", "-3", "-v", "1", pathlib.Path(__file__).resolve().parents[2] / "meshes" / "block.geo", *numbers, "-o", new], check=True)
        new.rename(path)


def read_table(path):
    """{'phase': {name: seconds}, 'part': {"phase: name": seconds}, 'count': {name: number}} of a file that --timings wrote."""
    table = {"phase": {}, "part": {}, "count": {}}
    with open(path, newline="") as f:
        for row in csv.DictReader(f):
            table.setdefault(row["kind"], {})[row["name"]] = float(row["value"])
    return table


def run(bin_dir, program, *arguments, folder, timings="timings.csv", threads=None):
    """Runs a program in `folder`; its table, with 'wall' and 'user' seconds of the process. Refused when it ends with an error."""
    file = pathlib.Path(folder) / timings
    command = [str(pathlib.Path(bin_dir) / program), *map(str, arguments), "--quiet", "--timings", file.name]
    command += ["--threads", str(threads)] if threads else []
    start = time.monotonic()
    before = os.times()
    done = subprocess.run(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    wall, after = time.monotonic() - start, os.times()
    if done.returncode != 0:
        lines = [line for line in done.stderr.splitlines() if ": error: " in line] or done.stderr.splitlines() or ["no message"]
        raise Refused(re.sub(r"^\S+\.yaml:\d+: ", "", lines[-1].split(": error: ")[-1]))
    table = read_table(file)
    table["wall"], table["user"] = wall, after.children_user - before.children_user
    return table


def in_turns(jobs, repeats, say=print):
    """{name: [result, ...]} of jobs {name: function}: one after another, `repeats` times over, so that a slow minute hits all alike.
    A job that is refused is left out, with the reason under `refused`."""
    results, refused = {name: [] for name in jobs}, {}
    for turn in range(repeats):
        for name, job in jobs.items():
            if name in refused:
                continue
            try:
                results[name].append(job())
                say(f"  {name}: {results[name][-1]['wall']:.2f} s" + (f"  (run {turn + 1})" if repeats > 1 else ""))
            except Refused as error:
                refused[name] = str(error)
                say(f"  {name}: left out: {error}")
    return {name: of for name, of in results.items() if name not in refused}, refused


def median(tables, kind, name, default=0.0):
    """Of a phase or a count over repeated runs; kind 'wall' or 'user': of the whole process."""
    values = [table[kind] if kind in ("wall", "user") else table[kind].get(name, default) for table in tables]
    return statistics.median(values)


def spread(tables, kind, name):
    """Largest over smallest of the repeated runs."""
    values = [table[kind].get(name, 0.0) for table in tables]
    return max(values) / min(values) if min(values) > 0 else 1.0


def write_csv(path, rows, columns):
    """Rows (dictionaries) under these columns; a number with six digits."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(".tmp")
    with open(temporary, "w", newline="") as f:
        out = csv.DictWriter(f, columns, extrasaction="ignore", restval="")
        out.writeheader()
        for row in rows:
            out.writerow({key: f"{value:.6g}" if isinstance(value, float) else value for key, value in row.items()})
    temporary.rename(path)


def read_csv(path):
    """Rows of a CSV, numbers as numbers; none when there is no such file."""
    def value(text):
        try:
            return float(text)
        except ValueError:
            return text

    if not path.exists():
        return []
    with open(path, newline="") as f:
        return [{key: value(text) for key, text in row.items()} for row in csv.DictReader(f)]
