# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures and table of the decomposition study from OUT/times.csv: plot.py OUT"""
import csv
import os
import sys

sys.path.append("..")
from plotting import plt, save

NUMBERS = {"n": int, "domains": int, "threads": int, "coordinates": int, "joined_dofs": int, "steps": int}


def read(out):
    rows = []
    with open(os.path.join(out, "times.csv")) as file:
        for row in csv.DictReader(file):
            for key, text in row.items():
                if key in NUMBERS:
                    row[key] = NUMBERS[key](text) if text else None
                elif key not in ("interface", "kind", "modes"):
                    row[key] = float(text) if text else None
            row["run_s"] = row["setup_s"] + row["steps"] * row["step_s"]
            rows.append(row)
    return rows


def rate(row):
    """Bytes a step reads over its time, the best one."""
    return row["step_bytes"] / row["step_low_s"]


def pick(rows, **wanted):
    return sorted((r for r in rows if all(r[k] == v for k, v in wanted.items())), key=lambda r: (r["n"], r["domains"], r["threads"]))


def curves(axis, rows, value, interface, kind, mesh_kind=None):
    sizes = sorted({r["n"] for r in pick(rows, interface=interface, kind=kind, modes="50")})
    for colour, n in enumerate(sizes):
        for threads, style in ((2, "-o"), (1, "--s")):
            found = pick(rows, interface=interface, kind=kind, n=n, threads=threads, modes="50")
            if found:
                axis.plot([r["domains"] for r in found], [value(r) for r in found], style, color=f"C{colour}", markersize=4,
                          markerfacecolor="none" if threads == 1 else None, label=f"{n}³ elements" if threads == 2 else None)
        mesh = pick(rows, kind=mesh_kind, n=n, threads=2, modes="50") if mesh_kind else []
        if mesh:
            axis.axhline(value(mesh[0]), color=f"C{colour}", linestyle=":", linewidth=1)
    axis.set_xscale("log", base=2)
    axis.set_yscale("log")
    ticks = sorted({r["domains"] for r in rows})
    axis.set_xticks(ticks, [str(t) for t in ticks])
    axis.minorticks_off()
    axis.set_xlabel("domains")
    axis.grid(True, which="major", alpha=0.3)


def figure12(rows, out):
    """The shape of the paper's Fig 12: computational time against the number of domains, explicit and implicit."""
    interfaces = [i for i in ("faces", "surface") if pick(rows, interface=i, kind="central", modes="50")]
    figure, axes = plt.subplots(len(interfaces), 2, figsize=(11, 4.2 * len(interfaces)), squeeze=False)
    titles = {"faces": "held and loaded face kept", "surface": "whole surface kept"}
    for line, interface in zip(axes, interfaces):
        for axis, kind, name in zip(line, ("central", "newmark"), ("explicit", "implicit")):
            curves(axis, rows, lambda r: r["run_s"], interface, kind, "mesh-" + kind)
            axis.set_title(f"{name}, {titles[interface]}")
            axis.set_ylabel("set-up and steps to 3 µs, s")
        line[0].legend(fontsize=8)
    figure.text(0.5, 0.005, "filled, solid: 2 processors; open, dashed: 1; dotted: the full mesh, 2 processors", ha="center", fontsize=9)
    figure.tight_layout(rect=(0, 0.03, 1, 1))
    save(figure, os.path.join(out, "fig12.png"), dpi=130)


def parts(rows, out):
    """The parts of that time: reduction, set-up, one step; and how fast a step reads."""
    figure, axes = plt.subplots(2, 2, figsize=(11, 8))
    curves(axes[0, 0], rows, lambda r: r["reduce_s"], "faces", "newmark")
    axes[0, 0].set_title("reduction")
    curves(axes[0, 1], rows, lambda r: r["setup_s"], "faces", "central")
    axes[0, 1].set_title("set-up of the explicit run")
    curves(axes[1, 0], rows, lambda r: r["step_s"], "faces", "central", "mesh-central")
    axes[1, 0].set_title("one explicit step")
    curves(axes[1, 1], rows, lambda r: 1e-9 * rate(r), "faces", "central")
    axes[1, 1].set_title("GB/s that an explicit step reads, its best run")
    axes[1, 1].set_ylabel("GB/s")
    for axis in axes.flat[:3]:
        axis.set_ylabel("s")
    axes[1, 1].set_yscale("linear")
    axes[1, 1].set_ylim(0, None)
    axes[0, 0].legend(fontsize=8)
    figure.tight_layout()
    save(figure, os.path.join(out, "parts.png"), dpi=130)


def table(rows, out):
    head = ["mesh", "interface", "domains", "kind", "threads", "coordinates", "reduce s", "set-up s", "steps", "step ms", "low-high",
            "MB a step", "predicted", "GB/s", "run s"]
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]

    def text(value, form="{:.3g}"):
        return form.format(value) if value is not None else ""

    for r in sorted(rows, key=lambda r: (r["n"], r["modes"], r["interface"], r["kind"], r["domains"], -r["threads"])):
        counted = r["step_bytes"] is not None
        modes = " all modes" if r["modes"] == "all" else ""
        lines.append("| " + " | ".join([
            f"{r['n']}³{modes}", r["interface"], str(r["domains"]), r["kind"], str(r["threads"]), str(r["coordinates"]),
            text(r["reduce_s"]), text(r["setup_s"]), str(r["steps"]), text(1e3 * r["step_s"]),
            f"{1e3 * r['step_low_s']:.3g}-{1e3 * r['step_high_s']:.3g}",
            text(1e-6 * r["step_bytes"] if counted else None), text(1e-6 * r["predicted_bytes"] if counted else None),
            text(1e-9 * rate(r) if counted else None), text(r["run_s"])]) + " |")
    with open(os.path.join(out, "table.md"), "w") as file:
        file.write("\n".join(lines) + "\n")


def main():
    out = sys.argv[1]
    rows = read(out)
    figure12(rows, out)
    parts(rows, out)
    table(rows, out)
    print(f"plot: {out}/fig12.png, {out}/parts.png, {out}/table.md")


if __name__ == "__main__":
    main()
