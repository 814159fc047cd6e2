#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Figs 3, 5 and 6 of the paper from the results in a folder, and a table of what the blocks do after the impact.

    plot.py out            all figures: out/fig3.png, fig5.png, fig6.png, figures.txt
    plot.py out --quick    one run: out/quick.png
    plot.py out MODES_A MODES_B MODES_C FIGURE ...    out/paper-FIGURE.png of fig3, fig5, fig6, with the paper's number of
                           dofs in each superelement, and beside each a table: out/paper-FIGURE.md
"""
import pathlib
import sys

import h5py

sys.path.append("..")
import results
from plotting import GREY, plt, save, style
from results import write_table

SPEED = 3810.0
CONVERGED = (300.4, 3509.6)  # mean velocities after the impact, mesh-converged: ../../../docs/theory.md
COLOURS = {"full": "#1f3b73", "a": "#2a9d4a", "b": "#e07b00", "c": "#b3202c", "shapes": "#7b2d8e"}
LABELS = {"full": "full mesh", "a": "(a) contact face", "b": "(b) both x faces", "c": "(c) whole surface",
          "shapes": "(a) by few shapes (ours)"}
GREENS = ("#9bd3a9", "#4bb36a", "#14632b", "#f2b705")
ENFORCEMENTS = {"nodal": "nodal: the paper's enforcement, (a) sticks", "penalty": "penalty", "impulse": "impulse: every interface rebounds"}
PAPER = {"nodal": "contact by nodal masses", "impulse": "contact by impulses on the full reduced mass"}


class Run(results.Run):
    """x: body -> n, mean x of its facing surface; v: body -> n, its mean velocity; error: of the velocities after the impact, %."""

    def __init__(self, path):
        super().__init__(path)
        with h5py.File(path) as f:
            self.x = {name.split(".")[0]: surface["mean_position"][:, 0] for name, surface in f["surfaces"].items()}
        mass = self.momentum["left"][0, 0] / SPEED  # both blocks are the same
        self.v = {name: p[:, 0] / mass for name, p in self.momentum.items()}
        self.after = self.v["left"][-1], self.v["right"][-1]
        self.error = 100 * max(abs(v - converged) for v, converged in zip(self.after, CONVERGED)) / SPEED


def runs_of(folder):
    return results.Runs((path for path in folder.glob("*.h5") if not path.name.endswith(".cbr.h5")), Run)


def paper_models(modes_a, modes_b, modes_c):
    """Interface -> name of its runs, modes."""
    return {"full": ("full", ""), "c": ("c", modes_c), "b": (f"b{modes_b}", modes_b), "a": (f"a{modes_a}", modes_a)}


def dress(axis, title):
    style(axis, title, "time [µs]", "mean x of the facing faces [mm]")
    axis.legend(frameon=False, fontsize=8)


def draw(axis, run, colour, label, **options):
    for i, body in enumerate(("left", "right")):
        axis.plot(1e6 * run.t, 1e3 * run.x[body], color=colour, label=label if i == 0 else None, **options)


def single(run, colour, label, title, path, marks=()):
    """A figure of one run."""
    fig, axis = plt.subplots(figsize=(6, 4), layout="constrained")
    draw(axis, run, colour, label, linewidth=1.8)
    for t, text in marks:
        axis.text(t, 0.03, text, color=GREY, fontsize=9, ha="center", transform=axis.get_xaxis_transform())
    if marks:
        for t in (3.99, 8.24):
            axis.axvline(t, color=GREY, linewidth=0.8, linestyle=":")
    dress(axis, title)
    save(fig, path, dpi=130)


def figure3(runs, path):
    single(runs["full-impulse"], COLOURS["full"], "full mesh, impulse", "Fig 3: two equal blocks, 3810 m/s", path,
           ((2.0, "approach"), (6.1, "contact"), (10.1, "separated")))


def panels(titles, title, path, draw_panel):
    """A panel for each enforcement, titles: enforcement -> title; draw_panel(axis, enforcement)."""
    fig, axes = plt.subplots(1, len(titles), figsize=(4.6 * len(titles), 4.2), layout="constrained", sharey=True)
    for axis, enforcement in zip(axes, titles):
        draw_panel(axis, enforcement)
        dress(axis, titles[enforcement])
    fig.suptitle(title, x=0.01, ha="left")
    save(fig, path)


def figure5(runs, names, titles, path):
    """names: interface -> name of its runs."""
    def draw_panel(axis, enforcement):
        for interface, name in names.items():
            if f"{name}-{enforcement}" in runs:
                run = runs[f"{name}-{enforcement}"]
                draw(axis, run, COLOURS[interface], f"{LABELS[interface]}, {run.dofs // 2} dofs a block",
                     linewidth=3.2 if interface == "full" else 1.4, alpha=0.55 if interface == "full" else 1.0)

    panels(titles, "Fig 5: the choice of interface", path, draw_panel)


def figure6(runs, counts, titles, path):
    def draw_panel(axis, enforcement):
        draw(axis, runs["full-impulse"], COLOURS["full"], "full mesh, impulse", linewidth=3.2, alpha=0.45)
        for i, (modes, colour) in enumerate(zip(counts, GREENS)):
            draw(axis, runs[f"a{modes}-{enforcement}"], colour, f"(a), {modes} modes", linewidth=2.6 - 0.5 * i)

    panels(titles, "Fig 6: the number of fixed-interface modes behind the contact face", path, draw_panel)


def table(runs, path):
    rows = [f"{'run':16s} {'dofs':>7s} {'steps':>6s} {'stepping s':>10s} {'v left':>8s} {'v right':>8s} {'error %':>8s} {'energy':>7s} {'momentum drift':>15s}"]
    for run in map(runs.get, runs.paths):
        rows.append(f"{run.name:16s} {run.dofs:7d} {run.steps:6d} {run.seconds:10.3f} {run.after[0]:8.1f} {run.after[1]:8.1f} {run.error:8.2f} {run.kept:7.4f} {run.drift():15.1e}")
    rows.append(f"converged: {CONVERGED[0]} and {CONVERGED[1]} m/s; error: the larger of the two, in % of {SPEED:.0f} m/s")
    rows.append("dofs: those that are stepped; with impulses the fastest modes of a superelement follow at once, as statics (docs/decisions/truncation.md)")
    write_table(path, rows)


def paper_table(runs, names, path):
    """names: pairs of a run and the modes that it keeps."""
    rows = ["| run | dofs in a block | modes | left m/s | right m/s | error % | energy kept |", "|---|---|---|---|---|---|---|"]
    for run, modes in ((runs[name], modes) for name, modes in names):
        rows.append(f"| {run.name} | {run.dofs // 2} | {modes} | {run.after[0]:.1f} | {run.after[1]:.1f} | {run.error:.2f} | {run.kept:.4f} |")
    rows.append(f"\nConverged: {CONVERGED[0]} and {CONVERGED[1]} m/s. Error: the larger of the two, in % of {SPEED:.0f} m/s.")
    write_table(path, rows)


def paper_figures(runs, folder, models, wanted):
    counts = (5, 100, 500, models["a"][1])
    if "fig3" in wanted:
        figure3(runs, folder / "paper-fig3.png")
        paper_table(runs, [("full-impulse", "")], folder / "paper-fig3.md")
    if "fig5" in wanted:
        figure5(runs, {interface: name for interface, (name, _) in models.items()}, PAPER, folder / "paper-fig5.png")
        paper_table(runs, [(f"{models[i][0]}-{e}", models[i][1]) for e in PAPER for i in ("a", "b", "c", "full")], folder / "paper-fig5.md")
    if "fig6" in wanted:
        figure6(runs, counts, PAPER, folder / "paper-fig6.png")
        paper_table(runs, [(f"a{k}-{e}", k) for e in PAPER for k in counts], folder / "paper-fig6.md")


def main():
    folder = pathlib.Path(sys.argv[1])
    runs = runs_of(folder)
    if "--quick" in sys.argv:
        run = runs["a-impulse"]
        single(run, COLOURS["a"], f"superelements, {run.dofs // 2} dofs each", "Block impact: position of the facing faces", folder / "quick.png")
        return
    if len(sys.argv) > 2:
        paper_figures(runs, folder, paper_models(*map(int, sys.argv[2:5])), sys.argv[5:])
        return
    names = {name: name for name in ("full", "c", "b", "a", "shapes")}
    both = {enforcement: ENFORCEMENTS[enforcement] for enforcement in PAPER}
    figure3(runs, folder / "fig3.png")
    figure5(runs, names, ENFORCEMENTS, folder / "fig5.png")
    figure5(runs, names, both, folder / "block-impact.png")  # README's picture
    figure6(runs, (5, 100, 500), both, folder / "fig6.png")
    table(runs, folder / "figures.txt")
    print(f"plots: {folder}/block-impact.png {folder}/fig3.png {folder}/fig5.png {folder}/fig6.png")


if __name__ == "__main__":
    main()
