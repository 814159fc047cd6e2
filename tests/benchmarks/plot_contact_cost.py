#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Seconds a step over contact nodes, by phase, from the CSV of bench_contact_cost: plot_contact_cost.py contact-cost.csv contact-cost.png"""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

PHASES = (("step s", "whole step", "#222222"), ("bodies s", "bodies", "#999999"), ("search s", "search", "#1f3b73"),
          ("response s", "response", "#3a9e5f"), ("contact s", "contact", "#e07b00"))


def main():
    with open(sys.argv[1], newline="") as f:
        rows = [row for row in csv.DictReader(line for line in f if not line.startswith("growth"))]
    kinds = list(dict.fromkeys((row["model"], row["formulation"]) for row in rows))
    fig, axes = plt.subplots(1, len(kinds), figsize=(3.6 * len(kinds), 3.8), layout="constrained", sharex=True, sharey=True, squeeze=False)
    for axis, kind in zip(axes[0], kinds):
        of = [row for row in rows if (row["model"], row["formulation"]) == kind]
        nodes = [int(row["slave nodes"]) for row in of]
        for column, label, colour in PHASES:
            axis.loglog(nodes, [float(row[column]) for row in of], "o-", color=colour, label=label, linewidth=2 if column == "step s" else 1.2, markersize=3)
        axis.set_title(", ".join(kind), fontsize=10, loc="left")
        axis.set_xlabel("slave nodes in contact")
        axis.grid(True, color="#e6e6e6", linewidth=0.6)
        axis.spines[["top", "right"]].set_visible(False)
    axes[0, 0].set_ylabel("seconds a step")
    axes[0, 0].legend(frameon=False, fontsize=8)
    fig.savefig(sys.argv[2], dpi=110)


if __name__ == "__main__":
    main()
