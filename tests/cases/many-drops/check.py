#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""check.py SUMMARY: the block slides all the time, so friction's impulse is the coefficient times the normal impulse.

It is a little less along the block's way, as the foot also slips sideways where it spreads: by 1 m/s at most beside 20 m/s.
"""
import csv
import sys

sys.path.append("..")
from checks import report

with open(sys.argv[1]) as file:
    rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
largest = max(row["normal_impulse"] for row in rows)
off = max(abs(row["friction_impulse"] - row["friction"] * row["normal_impulse"]) for row in rows) / largest
checks = [
    ("friction's impulse off Coulomb's law, share", off, 1e-3),
    ("scenes that do not rebound", sum(row["rebound"] <= 0 for row in rows), 0),
    ("rebound above the speed of the drop", max(0.0, max(row["rebound"] for row in rows) - 1), 0),
]
print(f"{len(rows)} scenes")
sys.exit(report(checks))
