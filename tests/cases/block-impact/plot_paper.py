#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Figs 3, 5 and 6 of the paper with its number of dofs in each superelement, and whether they show what they must.

    plot_paper.py out MODES_A MODES_B MODES_C [fig3] [fig5] [fig6]

Writes out/paper-fig5.png, ... and beside each a table. A line for each thing that is checked; exit 1 when one is missed.
"""
import pathlib
import sys

import matplotlib.pyplot as plt

from plot import COLOURS, CONVERGED, LABELS, SPEED, draw, figure3, load, style

COMMON = SPEED / 2
GREENS = ("#9bd3a9", "#4bb36a", "#14632b", "#f2b705")
TITLES = {"nodal": "contact by nodal masses", "impulse": "contact by impulses on the full reduced mass"}


def table(folder, names, file):
    """Superelement dofs, modes kept, velocities after the impact and errors, for both enforcements."""
    rows = ["| run | dofs in a block | modes | left m/s | right m/s | error % | energy kept |", "|---|---|---|---|---|---|---|"]
    for name, modes in names:
        run = load(folder / f"{name}.h5")
        v = run["v"]["left"][-1], run["v"]["right"][-1]
        error = 100 * max(abs(v[0] - CONVERGED[0]), abs(v[1] - CONVERGED[1])) / SPEED
        rows.append(f"| {name} | {run['dofs'] // 2} | {modes} | {v[0]:.1f} | {v[1]:.1f} | {error:.2f} | {run['energy']:.4f} |")
    rows.append(f"\nConverged: {CONVERGED[0]} and {CONVERGED[1]} m/s. Error: the larger of the two, in % of {SPEED:.0f} m/s.")
    (folder / file).write_text("\n".join(rows) + "\n")
    print("\n".join(rows))


def panels(title):
    fig, axes = plt.subplots(1, 2, figsize=(9.5, 4.2), layout="constrained", sharey=True)
    fig.suptitle(title, x=0.01, ha="left")
    return fig, zip(axes, TITLES)


def figure5(folder, models):
    fig, pairs = panels("Fig 5: the choice of interface, as many dofs in each superelement")
    for axis, enforcement in pairs:
        for name in ("full", "c", "b", "a"):
            run = load(folder / f"{models[name][0]}-{enforcement}.h5")
            draw(axis, run, COLOURS[name], f"{LABELS[name]}, {run['dofs'] // 2} dofs a block",
                 linewidth=3.2 if name == "full" else 1.4, alpha=0.55 if name == "full" else 1.0)
        style(axis, TITLES[enforcement])
        axis.legend(frameon=False, fontsize=8)
    fig.savefig(folder / "paper-fig5.png", dpi=100)
    table(folder, [(f"{models[i][0]}-{e}", models[i][1]) for e in TITLES for i in ("a", "b", "c", "full")], "paper-fig5.md")


def figure6(folder, counts):
    fig, pairs = panels("Fig 6: the number of fixed-interface modes behind the contact face")
    full = load(folder / "full-impulse.h5")
    for axis, enforcement in pairs:
        draw(axis, full, COLOURS["full"], "full mesh, impulses", linewidth=3.2, alpha=0.45)
        for i, (modes, colour) in enumerate(zip(counts, GREENS)):
            draw(axis, load(folder / f"a{modes}-{enforcement}.h5"), colour, f"(a), {modes} modes", linewidth=2.6 - 0.5 * i)
        style(axis, TITLES[enforcement])
        axis.legend(frameon=False, fontsize=8)
    fig.savefig(folder / "paper-fig6.png", dpi=100)
    table(folder, [(f"a{k}-{e}", k) for e in TITLES for k in counts], "paper-fig6.md")


def held(run, what, value, wanted, tolerance):
    is_so = abs(value - wanted) <= tolerance
    print(f"{run:14s} {what:28s} {value:12.6g}  wanted {wanted:10.6g} +- {tolerance:.2g}  {'held' if is_so else 'MISSED'}")
    return is_so


def check3(folder):
    """They touch when the gap has closed, and are apart again, with the converged velocities, before the end."""
    run = load(folder / "full-impulse.h5")
    gap = run["x"]["right"] - run["x"]["left"]
    touching = run["t"][gap < 1e-3 * gap[0]]
    return [held("fig 3", "first touch, us", 1e6 * touching[0], 3.99, 0.11), held("fig 3", "last touch, us", 1e6 * touching[-1], 8.1, 0.4),
            held("full-impulse", "left, m/s", run["v"]["left"][-1], CONVERGED[0], 0.005 * SPEED)]


def check5(folder, models):
    runs = {(i, e): load(folder / f"{name}-{e}.h5") for i, (name, _) in models.items() for e in TITLES}
    left = {key: run["v"]["left"][-1] for key, run in runs.items()}
    dofs = [runs[i, "nodal"]["dofs"] for i in "abc"]
    checks = [held("fig 5", "dofs differ by", max(dofs) - min(dofs), 0, 0)]
    # The paper: with the contact face alone the blocks stay together; the more interface, the nearer to the mesh.
    checks.append(held("a-nodal", "left, m/s", left["a", "nodal"], COMMON, 1e-3 * SPEED))
    ordered = all(left[less, "nodal"] > left[more, "nodal"] + 0.05 * SPEED for less, more in zip(("a", "b", "c"), ("b", "c", "full")))
    checks.append(held("nodal", "a > b > c > full", float(ordered), 1, 0))
    # Right: with the full reduced mass every interface gives what the full mesh does, and that is the converged answer.
    for i in models:
        checks.append(held(f"{i}-impulse", "left, m/s", left[i, "impulse"], CONVERGED[0], 0.005 * SPEED))
    return checks


def check6(folder, counts):
    checks = []
    for k in counts:
        for e, wanted, tolerance in (("nodal", COMMON, 1e-3 * SPEED), ("impulse", CONVERGED[0], (0.005 if k > 5 else 0.04) * SPEED)):
            run = load(folder / f"a{k}-{e}.h5")
            checks.append(held(f"a{k}-{e}", "left, m/s", run["v"]["left"][-1], wanted, tolerance))
            checks.append(held(f"a{k}-{e}", "momentum drift", run["drift"], 0, 1e-10))
    return checks


def main():
    folder, (modes_a, modes_b, modes_c), wanted = pathlib.Path(sys.argv[1]), map(int, sys.argv[2:5]), sys.argv[5:]
    models = {"a": (f"a{modes_a}", modes_a), "b": (f"b{modes_b}", modes_b), "c": ("c", modes_c), "full": ("full", "")}
    counts = (5, 100, 500, modes_a)
    checks = []
    if "fig3" in wanted:
        figure3(folder)
        (folder / "fig3.png").replace(folder / "paper-fig3.png")
        table(folder, [("full-impulse", "")], "paper-fig3.md")
        checks += check3(folder)
    if "fig5" in wanted:
        figure5(folder, models)
        checks += check5(folder, models)
    if "fig6" in wanted:
        figure6(folder, counts)
        checks += check6(folder, counts)
    return 0 if all(checks) else 1


if __name__ == "__main__":
    sys.exit(main())
