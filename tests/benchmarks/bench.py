#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmarks of `make bench`: bench.py PART ... with PART of machine, t1, projected, reduction, interior, skipping, features,
ordinary, bases, few_shapes, peers, largest, plots; all but peers (in a smoke run with it) and largest without any.

BIN and BENCH (folders of the programs and of bench_machine), OUT (folder of the CSV files and plots) and as options SMOKE=1 (smallest
sizes, one run each), REPEATS (3), REFINEMENTS ("1 2 4") come from the environment: tests/benchmarks/Makefile. When each part was
measured, of which commit and beside how much other work goes into runs.csv.
"""
import csv
import datetime
import io
import os
import pathlib
import subprocess
import sys

import bases
import few_shapes
import limits
import machine
import peers
import plots
import projected
import reduction
import skipping
import t1
from runs import read_csv, write_csv


class Settings:
    def __init__(self):
        environment = os.environ
        self.bin = pathlib.Path(environment["BIN"]).resolve()
        self.bench = pathlib.Path(environment["BENCH"]).resolve()
        self.out = pathlib.Path(environment["OUT"]).resolve()
        self.python = environment.get("PYTHON") or sys.executable
        self.smoke = environment.get("SMOKE", "") not in ("", "0")
        self.repeats = 1 if self.smoke else int(environment.get("REPEATS") or 3)
        self.refinements = [1] if self.smoke else [int(word) for word in (environment.get("REFINEMENTS") or "1 2 4").split()]

    def rates(self):
        rows = read_csv(self.out / "machine.csv")
        if not rows:
            measure_machine(self)
            rows = read_csv(self.out / "machine.csv")
        return limits.Rates(rows, machine.second_cache())


def measure_machine(settings):
    settings.out.mkdir(parents=True, exist_ok=True)
    size = ["200"] if settings.smoke else []
    text = subprocess.run([settings.bench / "bench_machine", *size], check=True, capture_output=True, text=True).stdout
    (settings.out / "machine.csv").write_text(text)
    write_csv(settings.out / "versions.csv", machine.versions(), ["what", "value"])


def merge(path, rows, columns, of):
    """Rows of `of` (a column's value) replaced in a CSV that keeps its others."""
    column, value = of
    kept = [row for row in read_csv(path) if row.get(column) != value]
    write_csv(path, kept + rows, columns)


def measure_t1(settings):
    steps = next((row["steps"] for row in read_csv(settings.out / "t1.csv") if row["row"] == "r1 full"), None)
    for r in settings.refinements:
        print(f"T1, r = {r}")
        rows, full_steps = t1.measure(r, settings.out / "t1", settings.bin, settings.rates(), settings.repeats if r < 4 else min(settings.repeats, 2),
                                      settings.smoke, steps_per_r=steps if r > 1 else None)
        steps = full_steps if r == 1 else steps
        merge(settings.out / "t1.csv", rows, t1.COLUMNS, ("r", float(r)))


def measure_reduction(settings):
    rows, again = reduction.measure(settings, settings.rates())
    write_csv(settings.out / "reduction.csv", rows, reduction.COLUMNS)
    write_csv(settings.out / "again.csv", again, reduction.AGAIN)


def measure_interior(settings):
    write_csv(settings.out / "interior.csv", reduction.interior(settings), reduction.INTERIOR)


def measure_largest(settings):
    hexes = [int(word) for word in (os.environ.get("HEXES") or "166 36 53").split()]
    write_csv(settings.out / "largest.csv", reduction.largest(settings, settings.rates(), hexes), reduction.COLUMNS)


def measure_module(module):
    """The part of a module that measures one table."""
    return lambda settings: write_csv(settings.out / f"{module.__name__}.csv", module.measure(settings), module.COLUMNS)


def measure_case(case, name):
    """The part of a case that prints its own rows: `make bench-rows`. Its runs may take minutes."""
    def measure(settings):
        # Results of an earlier program go first: make would keep them, with their times
        for old in (settings.out / name).glob("*.h5"):
            old.unlink()
        done = reduction.make_case(settings, case, settings.out / name, "bench-rows")
        rows, columns = [{"run": "all", "note": "left out: the case did not run"}], ["run", "note"]
        if done.returncode == 0:
            # make's recipes may say something before the table
            reader = csv.DictReader(io.StringIO(done.stdout[done.stdout.index("run,dofs,"):]))
            rows, columns = list(reader), reader.fieldnames
        write_csv(settings.out / f"{name}.csv", rows, columns)

    return measure


PARTS = {"machine": measure_machine, "t1": measure_t1, "projected": measure_module(projected), "reduction": measure_reduction,
         "interior": measure_interior, "skipping": measure_module(skipping), "features": measure_case("small-features", "features"),
         "ordinary": measure_case("ordinary-part", "ordinary"), "bases": measure_module(bases), "few_shapes": measure_module(few_shapes),
         "peers": peers.measure, "largest": measure_largest, "plots": lambda settings: plots.make(settings.out)}


def record(settings, part):
    """A row of runs.csv: the tables of several runs may stand side by side, and this tells."""
    described = subprocess.run(["git", "-C", pathlib.Path(__file__).parent, "describe", "--always", "--dirty"], capture_output=True, text=True)
    row = {"part": part, "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M"), "commit": "git " + (described.stdout.strip() or "unknown"),
           "repeats": settings.repeats, "load": f"{os.getloadavg()[0]:.1f}"}
    merge(settings.out / "runs.csv", [row], list(row), ("part", part))


def main():
    settings = Settings()
    wanted = sys.argv[1:] or [part for part in PARTS if part != "largest" and (part != "peers" or settings.smoke)]
    for part in wanted:
        if part not in PARTS:
            sys.exit(f"bench.py: no part '{part}'; there are {', '.join(PARTS)}")
        if part != "plots":
            record(settings, part)
        PARTS[part](settings)


if __name__ == "__main__":
    main()
