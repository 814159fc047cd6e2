#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""plot.py FOLDER: ordinary-part.png (momentum across and along the floor) and table.txt."""
import pathlib
import sys

from runs import Runs

sys.path.append("..")
from plotting import bare, plt, save
from results import aligned, write_table

STYLES = {"full": dict(color="#1f3b73", linewidth=3.4, alpha=0.45),
          "shapes": dict(color="#b3202c", linewidth=1.2),
          "nodes": dict(color="#2a9d4a", linewidth=1.2, linestyle="--")}
WORDS = {"full": "full mesh", "shapes": "basis characteristic", "nodes": "basis craig-bampton"}


def draw(runs, folder):
    fig, axes = plt.subplots(2, 2, figsize=(11, 6), layout="constrained", sharex=True)
    for column, friction in enumerate((False, True)):
        for run in runs.all:
            if run.friction != friction or run.mesh == "fine":
                continue
            words = f"{WORDS[run.model]}, {run.dofs} dofs, {run.steps} steps"
            for axis, d in zip(axes[:, column], (2, 0)):
                scale = abs(run.p[0, d])
                axis.plot(1e6 * run.t, run.p[:, d] / scale, label=words, **STYLES[run.model])
        axes[0, column].set_title("friction 0.3" if friction else "no friction", loc="left")
        axes[0, column].legend(frameon=False, fontsize=8)
        axes[1, column].set_xlabel("time [us]")
    for axis, what in zip(axes[:, 0], ("across", "along")):
        axis.set_ylabel(f"momentum {what} the floor,\nshare of what it was")
    for axis in axes.flat:
        bare(axis)
    save(fig, folder / "ordinary-part.png", dpi=100)


HEADINGS = (("run", "run", "{:22s}"), ("dofs", "dofs", "{:6d}"), ("steps", "steps", "{:6d}"),
            ("stepping s", "steps_s", "{:10.4f}"), ("setup s", "setup_s", "{:7.3f}"),
            ("reduction s", "reduction_s", "{:11.2f}"), ("way %", "way_percent", "{:6.3f}"),
            ("rebound", "rebound", "{:7.4f}"), ("along", "momentum_along", "{:6.4f}"),
            ("along off %", "momentum_off_percent", "{:11.2f}"),
            ("kept", "energy_kept", "{:6.4f}"), ("friction J", "friction_J", "{:10.4g}"),
            ("residual", "residual", "{:8.1e}"), ("ratio", "seconds_ratio", "{:6.2f}"),
            ("breaks even", "break_even_runs", "{:11.1f}"))
NOTE = ("way: largest distance of the centre of mass from the full mesh's, of its way; "
        "rebound, along: momentum across\nand along the floor at the end, of what it was; "
        "ratio: the full mesh's stepping seconds over ours")


def main():
    folder = pathlib.Path(sys.argv[1])
    runs = Runs(folder)
    draw(runs, folder)
    write_table(folder / "table.txt", [*aligned(HEADINGS, runs.rows()), NOTE])


if __name__ == "__main__":
    main()
