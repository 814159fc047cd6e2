# SPDX-License-Identifier: GPL-3.0-or-later
"""Plots of the benchmarks from their CSV files: OUT/bench-t1.png, bench-ratio.png, bench-phases.png, bench-peers.png, bench-curves.png.

    plots.py contact-cost.csv contact-cost.png    seconds a step over contact nodes, by phase, of bench_contact_cost
"""
import csv
import pathlib
import sys

from matplotlib.lines import Line2D

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "cases"))
from plotting import plt, save, style  # noqa: E402
from runs import read_csv  # noqa: E402

MARKERS = {1: "o", 2: "s", 4: "^"}
KINDS = {"full": ("full mesh", "#1f3b73"), "a": ("(a) contact face", "#2a9d4a"), "a long": ("(a), long steps", "#8ac926"),
         "b": ("(b) both x faces", "#e07b00"), "c": ("(c) whole surface", "#b3202c"),
         "shapes": ("(a), basis characteristic", "#7b3fa0")}
TARGETS = {1: 10, 2: 30, 4: 60}
ERROR = "rms_percent_of_half_speed"
CONTACT_COST = (("step s", "whole step", "#222222"), ("bodies s", "bodies", "#999999"), ("search s", "search", "#1f3b73"),
                ("response s", "response", "#3a9e5f"), ("contact s", "contact", "#e07b00"))


def kind(row):
    return "a long" if "cfl" in str(row["step_option"]) and row["model"] == "a" else row["model"]


def measured(rows):
    """Rows with impulses: what is compared. Others are in the table."""
    return [row for row in rows if not row["note"] and row["enforcement"] == "impulse"]


def legend(axis, rows):
    kinds = [k for k in KINDS if k in {kind(row) for row in rows}]
    handles = [Line2D([], [], color=KINDS[k][1], marker="o", linestyle="", label=KINDS[k][0]) for k in kinds]
    handles += [Line2D([], [], color="#555555", marker=MARKERS[r], linestyle="", label=f"r = {r}") for r in sorted({int(row["r"]) for row in rows})]
    axis.legend(handles=handles, frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1, 1))


def plot_time_and_error(rows, file):
    fig, axes = plt.subplots(1, 2, figsize=(10.5, 4.4), layout="constrained", sharey=True)
    for axis, column, title in ((axes[0], "stepping_s", "stepping alone"), (axes[1], "total_s", "the whole run: reading, setup, stepping, writing")):
        for row in rows:
            axis.loglog(row[column], row[ERROR], MARKERS[int(row["r"])], color=KINDS[kind(row)][1], markersize=7, alpha=0.85)
        axis.axhline(0.5, color="#999999", linestyle=":", linewidth=1)
        style(axis, title, "seconds", "rms error of the face, % of 1905 m/s x 4.25 us" if axis is axes[0] else "", "both")
    legend(axes[1], rows)
    save(fig, file)


def plot_ratio(rows, file):
    fig, axis = plt.subplots(figsize=(6.4, 4.4), layout="constrained")
    for row in rows:
        if row["model"] != "full":
            axis.loglog(row["speedup"], row[ERROR], MARKERS[int(row["r"])], color=KINDS[kind(row)][1], markersize=7, alpha=0.85)
    for r in sorted({int(row["r"]) for row in rows}):
        if r in TARGETS:
            axis.plot([TARGETS[r]], [0.5], MARKERS[r], markerfacecolor="none", color="#222222", markersize=12)
            axis.annotate(f"r = {r}", (TARGETS[r], 0.5), xytext=(0, 9), textcoords="offset points", fontsize=8, ha="center")
    axis.annotate("targets:", (TARGETS[1], 0.5), xytext=(-16, 9), textcoords="offset points", fontsize=8, ha="right")
    axis.axhline(0.5, color="#999999", linestyle=":", linewidth=1)
    axis.axvline(1, color="#1f3b73", linewidth=1)
    style(axis, "stepping, times faster than the full mesh of the same r", "full mesh's seconds over these", "rms error, % of 1905 m/s x 4.25 us", "both")
    legend(axis, [row for row in rows if row["model"] != "full"])
    save(fig, file)


def stacked(axis, names, parts, title):
    """parts: phase -> list of seconds. Shares, with the sum beside the name."""
    colours = plt.get_cmap("tab10").colors
    sums = [sum(values[i] for values in parts.values()) for i in range(len(names))]
    labels = [f"{name}: {total:.3g} s" for name, total in zip(names, sums)]
    left = [0.0] * len(names)
    for i, (phase, values) in enumerate(parts.items()):
        shares = [100 * value / total for value, total in zip(values, sums)]
        axis.barh(labels, shares, left=left, color=colours[i % 10], label=phase)
        left = [a + b for a, b in zip(left, shares)]
    axis.invert_yaxis()
    style(axis, title, "% of the time", "", "both")
    axis.tick_params(axis="y", labelsize=7)
    if names:
        axis.legend(frameon=False, fontsize=7, loc="upper left", bbox_to_anchor=(0, -0.14), ncols=4)


def plot_phases(t1_rows, reduction_rows, file):
    """Of each r the full mesh, and the fastest (a) with an error below 0.5 %; and the reductions."""
    chosen = []
    for r in sorted({row["r"] for row in t1_rows}):
        of = [row for row in t1_rows if row["r"] == r]
        chosen += [row for row in of if row["model"] == "full"][:1]
        good = [row for row in of if row["model"] in ("a", "shapes") and row[ERROR] < 0.5]
        chosen += sorted(good, key=lambda row: row["stepping_s"])[:1]
    fig, axes = plt.subplots(1, 2, figsize=(11, 3.6), layout="constrained")
    parts = {name: [row[column] for row in chosen] for name, column in (("read", "read_s"), ("setup", "setup_s"), ("steps", "stepping_s"), ("write", "write_s"))}
    stacked(axes[0], [row["row"] for row in chosen], parts, "runs")
    names = list(dict.fromkeys(row["row"] for row in reduction_rows))
    phases = [p for p in dict.fromkeys(row["phase"] for row in reduction_rows) if p not in ("total", "")]
    table = {(row["row"], row["phase"]): row["seconds"] for row in reduction_rows}
    stacked(axes[1], names, {p: [table.get((n, p)) or 0.0 for n in names] for p in phases}, "reductions")
    save(fig, file)


def plot_peers(rows, file):
    """A panel for each case; a dashed line where a run ended without an answer."""
    rows = [row for row in rows if isinstance(row["seconds"], float)]
    cases = [case for case in dict.fromkeys(row["case"] for row in rows) if len({row["program"] for row in rows if row["case"] == case}) > 1]
    if not cases:
        return
    columns = min(len(cases), 3)
    fig, axes = plt.subplots(-(-len(cases) // columns), columns, figsize=(4.4 * columns, 5 * -(-len(cases) // columns)), layout="constrained", squeeze=False)
    for axis in axes.flat[len(cases):]:
        axis.set_visible(False)
    for axis, case in zip(axes.flat, cases):
        for number, row in enumerate([row for row in rows if row["case"] == case]):
            colour, label = plt.get_cmap("tab10").colors[number % 10], f"{row['program']}: {row['setting']}"
            if isinstance(row["error_percent"], float):
                axis.loglog(row["seconds"], max(row["error_percent"], 1e-8), "o" if row["program"] == "cbr" else "s", color=colour, markersize=7, linestyle="", label=label)
            else:
                axis.axvline(row["seconds"], color=colour, linestyle="--", label=f"{label}: no answer")
        style(axis, case, "seconds of the processor", "error, %", "both")
        axis.margins(y=0.3)
        axis.legend(frameon=False, fontsize=7, loc="upper left", bbox_to_anchor=(0, -0.14))
    save(fig, file)


def plot_curves(rows, file):
    """Force of the contact and energy over time: a row of two panels for each case that several programs have."""
    cases = [case for case in dict.fromkeys(row["case"] for row in rows) if len({row["program"] for row in rows if row["case"] == case}) > 1]
    if not cases:
        return
    fig, axes = plt.subplots(len(cases), 2, figsize=(11, 3.6 * len(cases)), layout="constrained", squeeze=False)
    for pair, case in zip(axes, cases):
        of = [row for row in rows if row["case"] == case]
        for number, key in enumerate(dict.fromkeys((row["program"], row["setting"]) for row in of)):
            for axis, curve in zip(pair, ("force", "energy")):
                points = [(row["t"], row["value"]) for row in of if (row["program"], row["setting"], row["curve"]) == (*key, curve)]
                axis.plot(*zip(*points), "-" if key[0] == "cbr" else "--", color=plt.get_cmap("tab10").colors[number % 10], linewidth=1.2, label=": ".join(key))
        style(pair[0], f"{case}: force of the contact", "s", "N", "both")
        style(pair[1], f"{case}: energy", "s", "% of the start", "both")
        pair[1].legend(frameon=False, fontsize=7, loc="upper left", bbox_to_anchor=(1, 1))
    save(fig, file)


def make(out):
    plot_peers(read_csv(out / "peers.csv"), out / "bench-peers.png")
    plot_curves(read_csv(out / "peer-curves.csv"), out / "bench-curves.png")
    rows = measured(read_csv(out / "t1.csv"))
    if rows:
        plot_time_and_error(rows, out / "bench-t1.png")
        plot_ratio(rows, out / "bench-ratio.png")
        plot_phases(rows, [row for row in read_csv(out / "reduction.csv") if not row["note"]], out / "bench-phases.png")


def plot_contact_cost(table, file):
    with open(table, newline="") as f:
        rows = list(csv.DictReader(line for line in f if not line.startswith("growth")))
    kinds = list(dict.fromkeys((row["model"], row["formulation"]) for row in rows))
    fig, axes = plt.subplots(1, len(kinds), figsize=(3.6 * len(kinds), 3.8), layout="constrained", sharex=True, sharey=True, squeeze=False)
    for axis, kind in zip(axes[0], kinds):
        of = [row for row in rows if (row["model"], row["formulation"]) == kind]
        nodes = [int(row["slave nodes"]) for row in of]
        for column, label, colour in CONTACT_COST:
            axis.loglog(nodes, [float(row[column]) for row in of], "o-", color=colour, label=label, linewidth=2 if column == "step s" else 1.2, markersize=3)
        style(axis, ", ".join(kind), "slave nodes in contact", "seconds a step" if kind == kinds[0] else "")
    axes[0, 0].legend(frameon=False, fontsize=8)
    save(fig, file)


if __name__ == "__main__":
    plot_contact_cost(*sys.argv[1:])
