#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Load: large scenes at several sizes, what they take and how that grows, into docs/stability-load.md.

load.py [--quick] [--only WORDS] [--write FILE]; BIN: folder of the programs. --quick: small sizes, whose runs, memory and counts of
work are judged (what ctest runs); times are only told. Exits 1 when a run fails or a bound is not held."""
import argparse
import csv
import dataclasses
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import h5py

import scenes

BIN = pathlib.Path(os.environ.get("BIN", "../../build/bin")).resolve()
MARKS = "<!-- load: written by `make load` -->", "<!-- end of load -->"
PHASES = ["read", "setup", "steps", "write"]
# Under the address sanitizer memory is not judged
IS_SANITIZED = (BIN / "cbr-dyn").exists() and b"__asan_init" in (BIN / "cbr-dyn").read_bytes()
LEAST_SECONDS = 0.05  # shorter times are round-off of the clock and the start of a process


@dataclasses.dataclass
class Case:
    """`make`(folder, n) writes a scene. `sizes`, and the one of --quick. `should`: exponents of what grows otherwise than as n."""
    what: str
    unit: str
    make: object
    sizes: list
    quick: list
    should: dict = dataclasses.field(default_factory=dict)
    after_reduction: object = None
    memory: float = 400  # MB, the most of the largest --quick size


def pad(kind):
    def add(folder, n):
        with h5py.File(folder / "block.cbr.h5", "a") as file:
            whole = file.create_dataset("padding", (n * 125000,), "f8", **({"chunks": (125000,)} if kind == "chunked" else {}))
            for i in range(n):
                whole[i * 125000:(i + 1) * 125000] = i + 1.5
    return add


CASES = [
    Case("Instances under `contact: all`, half of n pairs meet", "instances", scenes.all_pairs, [100, 316, 1000], [20, 60], {"setup": 2}),
    Case("The same, as full meshes", "instances", scenes.all_meshes, [100, 316, 1000], [20, 60], {"setup": 2}),
    Case("Instances in n / 2 pairs that are named", "instances", scenes.named_pairs, [100, 316, 1000], [20, 60]),
    Case("Superelements that fall onto a floor", "instances", scenes.falling, [1000, 3160, 10000], [40, 120]),
    Case("Entries of `between`, few of which meet", "entries", scenes.every_pair_named, [1000, 10000, 100000], [100, 1000]),
    Case("Contact nodes on instances of one superelement, all in contact", "nodes", scenes.contact_nodes, [20000, 63200, 200000], [1200]),
    Case("Contact nodes of one pair of full meshes, all in contact", "nodes", scenes.large_pair, [20000, 63200, 200000], [1000, 3000]),
    Case("The same, `mortar`", "nodes", scenes.mortar_pair, [6320, 20000, 63200], [500]),
    Case("Output values, 20 instances", "values", scenes.outputs, [100000, 1000000, 10000000], [10000]),
    Case("Output values, 1000 instances", "values", scenes.outputs_of_many, [100000, 1000000, 10000000], [11000]),
    Case("Values of fields, 50 instances", "values", scenes.fields, [150000, 1500000, 15000000], [15000]),
    Case("Loads with histories of their own, a scene of n MB", "MB", scenes.load_lines, [1, 10, 100], [0.1]),
    Case("A table of one history, a scene of n MB", "MB", scenes.long_table, [1, 10, 100], [0.1]),
    Case("Boundary conditions, a scene of n MB", "MB", scenes.boundary_lines, [1, 10, 100], [0.05]),
    Case("A superelement of n MB, all of its nodes kept", "MB", scenes.whole_interface, [20, 200, 2000], [2], {"setup": 1.5}),
    Case("A superelement's file with n MB of foreign data in one piece", "MB", scenes.padded, [20, 200, 2000], [2], {}, pad("whole")),
    Case("The same, in chunks", "MB", scenes.padded, [20, 200, 2000], [2], {}, pad("chunked")),
]


# What checkpoints cost: what is in them, a scene without and with some, sizes, and the one of --quick
CHECKPOINTS = [
    ("the W of n rows between two superelements, after each step", lambda folder, n, often: scenes.checkpoints(folder, n, often), [100, 400, 900], [25]),
    ("n values of fields, five times a run", lambda folder, n, often: scenes.fields(folder, n, 5 if often else 0), [1500000, 15000000], [150000]),
    ("n values of results, ten times a run", scenes.outputs_and_checkpoints, [1000000, 10000000], [10000]),
]


def timings(file):
    """{"phase": {name: seconds}, "part": {name: seconds}, "count": {name: number}}"""
    table = {"phase": {}, "part": {}, "count": {}}
    with open(file) as text:
        for row in csv.DictReader(text):
            table[row["kind"]][row["name"]] = float(row["value"])
    return table


def run(folder, program, *arguments, threads=1):
    """The program's timings; an error is one of the scene."""
    file = folder / f"{program}.csv"
    done = subprocess.run([BIN / program, "-q", "--threads", str(threads), "--timings", file, *arguments], cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{program} ended with code {done.returncode}: {done.stderr[-400:]}")
    return timings(file)


def largest_files(folder):
    """MB of the scene, and of the largest file of results."""
    results = [f for f in folder.iterdir() if f.name.startswith("results")]
    return (folder / "scene.yaml").stat().st_size / 1e6, sum(f.stat().st_size for f in results) / 1e6


def measure(case, n):
    """One size: a row of figures."""
    with tempfile.TemporaryDirectory(prefix="cbr-load-") as name:
        folder = pathlib.Path(name)
        scene = case.make(folder, n)
        has_reduction = "reduction" in (folder / scene).open().read(4000)
        reduction = run(folder, "cbr-reduce", scene) if has_reduction else None
        if case.after_reduction:
            case.after_reduction(folder, n)
        table = run(folder, "cbr-dyn", scene, "-o", "results.h5")
        row = {"n": n, "cbr-reduce": reduction["phase"]["total"] if reduction else 0}
        row.update({phase: table["phase"].get(phase, 0) for phase in PHASES})
        row["total"] = table["phase"]["total"]
        row["memory"] = table["count"]["peak_memory_bytes"] / 1e6
        row["scene"], row["results"] = largest_files(folder)
        row["counts"] = table["count"]
        return row


def checkpoint_row(make, n):
    """Seconds and MB of one checkpoint: a run with some less one without."""
    steps = {}
    for often in (False, True):
        with tempfile.TemporaryDirectory(prefix="cbr-load-") as name:
            folder = pathlib.Path(name)
            scene = make(folder, n, often)
            run(folder, "cbr-reduce", scene)
            done = subprocess.run([BIN / "cbr-dyn", "-v", "--threads", "1", "--timings", folder / "t.csv", scene, "-o", "results.h5"], cwd=folder,
                                  capture_output=True, text=True)
            if done.returncode != 0:
                raise RuntimeError(done.stderr[-400:])
            steps[often] = timings(folder / "t.csv")["phase"]["steps"]
            count = done.stderr.count("checkpoint at t = ")
            size = sum(f.stat().st_size for f in folder.iterdir() if ".checkpoint" in f.name) / 1e6
    return count, size, (steps[True] - steps[False]) / max(count, 1)


def checkpoint_table(quick, wrong):
    text = "\n**What a checkpoint costs**\n\n| what it holds | n | checkpoints | MB each | s each |\n|---|---|---|---|---|\n"
    for what, make, sizes, small in CHECKPOINTS:
        for n in small if quick else sizes:
            try:
                count, size, seconds = checkpoint_row(make, n)
            except RuntimeError as error:
                wrong.append(f"checkpoint: {what}, {number(n)}: {error}")
                continue
            text += f"| {what} | {number(n)} | {count} | {size:.1f} | {max(seconds, 0):.3f} |\n"
            print(f"checkpoint: {what}: {number(n)}: {count} of {size:.1f} MB, {seconds:.3f} s each", flush=True)
            if count == 0:
                wrong.append(f"checkpoint: {what}, {number(n)}: none was written")
    return text


# Instances that fall onto a floor: number of them, and the one of --quick
FALLING = [10000], [120]


def numbers_of(file):
    """All that a run has found: every dataset's bytes. (Attributes tell how long it took.)"""
    found = {}
    with h5py.File(file, "r") as results:
        results.visititems(lambda name, item: found.update({name: item[()].tobytes()}) if isinstance(item, h5py.Dataset) else None)
    return found


def thread_table(quick, wrong):
    """Steps a second with one thread and two, and whether the results are the same, byte by byte."""
    text = "\n**Superelements that fall onto a floor, by threads**\n\n| instances | threads | steps | steps a second | memory of an instance, kB |\n|---|---|---|---|---|\n"
    for n in FALLING[quick]:
        with tempfile.TemporaryDirectory(prefix="cbr-load-") as name:
            folder = pathlib.Path(name)
            scene = scenes.falling(folder, n)
            run(folder, "cbr-reduce", scene)
            results = []
            for threads in (1, 2, 2):
                table = run(folder, "cbr-dyn", scene, "-o", "results.h5", threads=threads)
                results.append(numbers_of(folder / "results.h5"))
                steps, memory = table["count"]["steps"], table["count"]["peak_memory_bytes"] / n / 1e3
                line = f"| {number(n)} | {threads} | {steps:.0f} | {steps / table['phase']['steps']:.3g} | {memory:.0f} |\n"
                print(line, end="", flush=True)
                if len(results) < 3:
                    text += line
            if results[1] != results[2]:
                wrong.append(f"{number(n)} instances, 2 threads: two runs give other bytes")
            if results[0] != results[1]:
                wrong.append(f"{number(n)} instances: 1 and 2 threads give other bytes, although bodies and contact share nothing")
    return text


COLUMNS = ["cbr-reduce", *PHASES, "total", "memory", "results"]


def exponent(rows, column, base):
    """Of the growth between the last two sizes; None where there is too little of it to tell."""
    if len(rows) < 2:
        return None
    least = LEAST_SECONDS if column not in ("memory", "results") else 1
    a, b = (row[column] - (base if column == "memory" else 0) for row in rows[-2:])
    if a < least or b < least:
        return None
    return math.log(b / a) / math.log(rows[-1]["n"] / rows[-2]["n"])


def figure(value, column):
    if column in ("memory", "results"):
        return f"{value:.0f}" if value >= 10 else f"{value:.1f}"
    return f"{value:.2f}" if value >= 0.005 else "0"


def number(n):
    return f"{n:,}".replace(",", " ") if isinstance(n, int) else f"{n:g}"


def markdown(case, rows, base):
    heads = [f"{c}, s" if c not in ("memory", "results") else f"{c}, MB" for c in COLUMNS]
    text = f"\n**{case.what}**\n\n| {case.unit} | " + " | ".join(heads) + " |\n|" + "---|" * (len(heads) + 1) + "\n"
    for row in rows:
        text += f"| {number(row['n'])} | " + " | ".join(figure(row[c], c) for c in COLUMNS) + " |\n"
    if len(rows) < 2:
        return text
    found = [exponent(rows, c, base) for c in COLUMNS]
    return text + "| grows as n^ | " + " | ".join("" if e is None else f"{e:.2f}" for e in found) + " |\n"


def excesses(case, rows, base):
    """What grows faster than it should, by more than a quarter in the exponent."""
    for column in COLUMNS:
        found, should = exponent(rows, column, base), case.should.get(column, max([1, *case.should.values()]) if column in ("total", "memory") else 1)
        if found is not None and found > should + 0.25:
            yield f"{case.what}: {column} grows as n^{found:.2f}, should as n^{should:g}"


def write(file, text):
    """Only what stands between the marks is replaced."""
    whole = file.read_text()
    before, rest = whole.split(MARKS[0])
    file.write_text(before + MARKS[0] + "\n" + text + "\n" + MARKS[1] + rest.split(MARKS[1])[1])


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", default="", help="cases whose text holds these words")
    parser.add_argument("--largest", type=int, default=99, help="sizes of each case to run")
    parser.add_argument("--write", type=pathlib.Path, help="the document whose tables are renewed")
    return parser.parse_args()


def main():
    options = arguments()
    cases = [case for case in CASES if options.only.lower() in case.what.lower()]
    base = measure(Case("", "", scenes.named_pairs, [], []), 2)["memory"]
    text, wrong = "", []
    for case in cases:
        rows = []
        for n in (case.quick if options.quick else case.sizes)[:options.largest]:
            start = time.monotonic()
            try:
                rows.append(measure(case, n))
            except RuntimeError as error:
                wrong.append(f"{case.what}, {number(n)} {case.unit}: {error}")
                break
            print(f"{case.what}: {number(n)} {case.unit}: " + ", ".join(f"{c} {figure(rows[-1][c], c)}" for c in COLUMNS) +
                  f" ({time.monotonic() - start:.0f} s in all)", flush=True)
        text += markdown(case, rows, base)
        faster = list(excesses(case, rows, base))
        for line in faster:
            print(("" if options.quick else "too fast: ") + line)
        if options.quick and not IS_SANITIZED:
            wrong += [f"{case.what}: {row['memory']:.0f} MB, at most {case.memory}" for row in rows[-1:] if row["memory"] > case.memory]
    if options.only.lower() in "checkpoint":
        text += checkpoint_table(options.quick, wrong)
    if options.only.lower() in "threads":
        text += thread_table(options.quick, wrong)
    for line in wrong:
        print("FAILED:", line)
    if options.write and not wrong:
        write(options.write, text)
    return 1 if wrong or not text else 0


if __name__ == "__main__":
    sys.exit(main())
