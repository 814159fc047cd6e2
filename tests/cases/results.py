#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of the cases' runs: what each file has, what a run costs, and tables with a row for each run.

    results.py A.h5 B.h5    whether two files have the same datasets, byte for byte; attributes hold wall times and are left out
"""
import csv
import math
import re
import sys

import h5py
import numpy as np


TOTAL = r"^ +total +([\d.]+) s"  # what cbr-reduce --verbose prints of the whole reduction


class Run:
    """One results file; a case adds its own figures.

    t (n), s; momentum: instance -> n x 3, N s; kept: energy at the end over that at the start; balance: the
    largest energy that no work accounts for, over the largest energy; seconds of stepping, of set-up, and of
    the reduction, which only a case can find.
    """

    reduction = None

    def __init__(self, path):
        self.name = path.stem
        with h5py.File(path) as f:
            self.t = f["time"][:]
            self.momentum = {name: body["momentum"][:] for name, body in f["instances"].items()}
            self.energy = {name: data[:] for name, data in f["energy"].items()}
            self.steps, self.dofs = int(f.attrs["steps"]), int(f.attrs["n_dofs"])
            self.setup = float(f.attrs["wall_seconds_read"] + f.attrs["wall_seconds_setup"])
            self.seconds = float(f.attrs["wall_seconds_steps"])
        total = self.energy["total"]
        left = 2 * total - sum(self.energy.values())
        self.balance = np.abs(left - left[0]).max() / (np.abs(total).max() or 1)
        self.kept = total[-1] / (total[0] or 1)

    def drift(self):
        """Largest change of the momentum of all instances, share of the first."""
        whole = sum(self.momentum.values())
        return np.linalg.norm(whole - whole[0], axis=1).max() / np.linalg.norm(whole[0])

    def costs(self, full):
        """Sizes and seconds; beside a full mesh also how many runs pay for the reduction."""
        costs = dict(run=self.name, dofs=self.dofs, steps=self.steps, steps_s=self.seconds, setup_s=self.setup,
                     reduction_s=self.reduction, energy_kept=self.kept)
        if full and full is not self:
            gain = full.seconds + full.setup - self.seconds - self.setup
            costs["seconds_ratio"] = full.seconds / self.seconds
            costs["break_even_runs"] = self.reduction / gain if self.reduction and gain > 0 else None
        return costs


class Runs:
    """The runs of some paths by name, read when they are asked for. kind: Run, or a class that derives from it."""

    def __init__(self, paths, kind):
        self.paths, self.kind, self.read = {p.stem: p for p in sorted(paths)}, kind, {}

    def __contains__(self, name):
        return name in self.paths

    def __getitem__(self, name):
        if name not in self.read:
            self.read[name] = self.kind(self.paths[name])
        return self.read[name]

    def get(self, name):
        """The run, or None."""
        return self[name] if name in self else None


def said(path, pattern):
    """The figure that a program printed into a file; None where it is not there."""
    found = re.search(pattern, path.read_text(), re.M) if path.exists() else None
    return float(found[1]) if found else None


def write_table(path, lines):
    """Prints the lines of a table, and writes them to a file."""
    text = "\n".join(lines) + "\n"
    path.write_text(text)
    print(text, end="")


def aligned(headings, rows):
    """Lines of a table. headings: (title, key, format, factor of the figure if it is not 1); rows: key -> figure or None."""
    def place(text, title, form):
        is_text = form.endswith("s}")
        width = max(len(title), len(form.format("" if is_text else 0)))
        return text.ljust(width) if is_text else text.rjust(width)

    lines = ["  ".join(place(title, title, form) for title, _, form, *_ in headings)]
    for row in rows:
        cells = ["" if row[key] is None else form.format(row[key] * math.prod(unit) if unit else row[key]) for _, key, form, *unit in headings]
        lines.append("  ".join(place(cell, title, form) for cell, (title, _, form, *_) in zip(cells, headings)))
    return lines


def print_csv(columns, rows):
    """rows: column -> text, figure or None."""
    writer = csv.DictWriter(sys.stdout, columns, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({c: "" if v is None else f"{v:.6g}" if isinstance(v, float) else v for c, v in row.items()})


def datasets(path):
    """Name -> type, shape and bytes."""
    found = {}
    with h5py.File(path) as f:
        f.visititems(lambda name, item: found.update({name: (item.dtype, item.shape, item[()].tobytes())}) if isinstance(item, h5py.Dataset) else None)
    return found


def differing(path, other):
    """Names of the datasets that are not in both files with the same bytes."""
    a, b = datasets(path), datasets(other)
    return sorted(name for name in a.keys() | b.keys() if a.get(name) != b.get(name))


def main():
    found, names = len(datasets(sys.argv[1])), differing(*sys.argv[1:])
    print(f"{found} datasets, {len(names)} differ: {' '.join(names)}")
    return 1 if names or not found else 0


if __name__ == "__main__":
    sys.exit(main())
