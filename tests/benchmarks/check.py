#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the CSV files of a benchmark run are whole: check.py OUT. No time is judged; shares of the limit must be above 0, and below 1.5 but
in a smoke run (SMOKE=1), whose times are too short to say anything."""
import math
import os
import pathlib
import sys

import t1
from runs import read_csv

# File: columns that every measured row fills, and those that must be above 0
WANTED = {
    "machine.csv": ("value",),
    "projected.csv": ("dofs", "rms_percent", "energy_kept", "energy_of_projection"),
    "reduction.csv": ("seconds", "dofs", "interface_dofs", "factor_nonzeros", "peak_memory_bytes"),
    "interior.csv": ("dofs", "interface_dofs", "factor_flops", "total_s", "grows_flops", "grows_total"),
    "again.csv": ("first_s", "again_s", "ratio"),
    "skipping.csv": ("bodies", "steps", "total_s", "stepping_s"),
    "bases.csv": ("dofs", "steps", "step_s", "stepping_s", "total_s"),
    "few_shapes.csv": ("n", "steps", "separation", "energy", "stepping_s", "reduction_s", "file_bytes"),
    "features.csv": ("dofs", "steps", "steps_s", "setup_s"),
    "ordinary.csv": ("dofs", "steps", "steps_s", "setup_s"),
    "peers.csv": ("runs", "seconds", "megabytes"),
    "t1.csv": ("dofs", "steps", "contact_steps", "mean_rows", "rms_percent", "stepping_s", "setup_s", "limit_s", "share_of_limit", "peak_memory_bytes", "speedup"),
}
SHARES = {"t1.csv": "share_of_limit", "reduction.csv": "share_of_limit"}  # of rows that have one
MUST_RUN = {"t1.csv": ("full", "a")}  # of the column `model`


def main():
    out, missed = pathlib.Path(sys.argv[1]), []
    most = math.inf if os.environ.get("SMOKE") else 1.5
    for name, columns in WANTED.items():
        rows = [row for row in read_csv(out / name) if not row.get("note")]
        if not rows:
            missed.append(f"{name}: no rows")
        for row in rows:
            title = f"{name}: {row.get('row', row.get('name'))}"
            missed += [f"{title}: {c} is {row.get(c)!r}, a number above 0 is wanted" for c in columns
                       if not (isinstance(row.get(c), float) and math.isfinite(row[c]) and row[c] > 0)]
            if name == "t1.csv" and not 0 <= row["energy_kept"] < 1.1:
                missed.append(f"{title}: energy kept {row['energy_kept']}, between 0 and 1.1 is wanted")
            share = SHARES.get(name)
            if share and row[share] != "" and not 0 < row[share] < most:
                missed.append(f"{title}: {share} {row[share]}, between 0 and {most} is wanted")
        missed += [f"{name}: no row of model {model}" for model in MUST_RUN.get(name, ()) if model not in {row["model"] for row in rows}]
    if not any("cfl" in str(row["step_option"]) for row in read_csv(out / "t1.csv") if not row["note"]):
        missed.append("t1.csv: no row with long steps")
    if set(t1.COLUMNS) - set(next(iter(read_csv(out / "t1.csv")), t1.COLUMNS)):
        missed.append("t1.csv: columns are missing")
    for line in missed:
        print("MISSED", line)
    print(f"{sum(len(read_csv(out / name)) for name in WANTED)} rows looked at, {len(missed)} things missed")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
