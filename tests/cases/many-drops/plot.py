#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""plot.py SUMMARY PICTURE: rebound and work of friction over the speed of the drop."""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

with open(sys.argv[1]) as file:
    rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6))
for friction in sorted({row["friction"] for row in rows}):
    of = [row for row in rows if row["friction"] == friction]
    left.plot([row["speed"] for row in of], [row["rebound"] for row in of], ".-", label=f"friction {friction:g}")
    right.plot([row["speed"] for row in of], [-row["work_of_friction"] for row in of], ".-")
left.set(xlabel="speed of the drop [m/s]", ylabel="rebound / speed")
right.set(xlabel="speed of the drop [m/s]", ylabel="work lost to friction [J]")
left.legend(fontsize=8)
figure.tight_layout()
figure.savefig(sys.argv[2], dpi=120)
