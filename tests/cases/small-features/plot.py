#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""plot.py FOLDER: small-features.png (pad's position, wall's force, over time; superelements on the full mesh) and table.txt."""
import pathlib
import sys

from runs import SPEED, TOUCH, Runs

sys.path.append("..")
from plotting import bare, plt, save
from results import aligned, write_table

COLOURS = ["#e07b00", "#2a9d4a", "#b3202c", "#5b7fc7"]
SHOWN = ("k20", "k80", "k80-s2", "k80-s4")


def draw(runs, folder):
    meshes = runs.meshes()
    fig, axes = plt.subplots(2, len(meshes), figsize=(6.5 * len(meshes), 6.5), layout="constrained", squeeze=False, sharex=True)
    for column, mesh in enumerate(meshes):
        top, bottom = axes[:, column]
        full = runs[f"{mesh}-full"]
        wide = dict(color="#1f3b73", linewidth=3.4, alpha=0.45, label=f"full mesh, {full.dofs} dofs, {full.steps} steps")
        top.plot(1e6 * full.t, 1e6 * (full.x - full.x[0] - SPEED * TOUCH), **wide)
        middle = (full.t[1:] + full.t[:-1]) / 2
        bottom.plot(1e6 * middle, -1e-3 * full.force[1:], **wide)
        for name, colour in zip((f"{mesh}-{s}" for s in SHOWN), COLOURS):
            if name in runs:
                run = runs[name]
                what = f"{run.modes} modes" + (f", {run.factor:g} critical steps" if run.factor else "")
                thin = dict(color=colour, linewidth=1.2, label=f"{what}: {run.dofs} dofs, {run.steps} steps")
                top.plot(1e6 * run.t, 1e6 * (run.x - run.x[0] - SPEED * TOUCH), **thin)
                bottom.plot(1e6 * middle, -1e-3 * run.force[1:], **thin)
        top.set_title(f"bracket, {mesh}", fontsize=10, loc="left")
        top.set_ylabel("pad past the wall [um]")
        bottom.set_ylabel("wall's force, mean of 2 us [kN]")
        bottom.set_xlabel("time [us]")
        top.legend(frameon=False, fontsize=8)
        for axis in (top, bottom):
            bare(axis)
    save(fig, folder / "small-features.png", dpi=100)


HEADINGS = (("run", "run", "{:14s}"), ("dofs", "dofs", "{:6d}"), ("step, ns", "step_s", "{:8.1f}", 1e9), ("steps", "steps", "{:6d}"),
            ("ms/step", "ms_per_step", "{:8.4f}"), ("stepping s", "steps_s", "{:10.4f}"), ("ratio", "seconds_ratio", "{:7.1f}"),
            ("steps ratio", "steps_ratio", "{:11.1f}"), ("rms %", "rms", "{:6.3f}", 100), ("force %", "rms_force", "{:7.2f}", 100),
            ("rebound", "rebound", "{:7.4f}"), ("off", "rebound_off", "{:+7.4f}"), ("push off", "first_push_off", "{:+8.4f}"),
            ("kept", "energy_kept", "{:6.3f}"), ("rho_res", "rho_res", "{:7.4f}"),
            ("setup s", "setup_s", "{:7.3f}"), ("reduction s", "reduction_s", "{:11.2f}"), ("breaks even", "break_even_runs", "{:11.1f}"))
NOTE = ("ratio: the full mesh's stepping seconds over ours, same mesh; rms: pad's position after the first touch, of 5 m/s x contact time; force: rms in windows of\n"
        "6 us, of the largest; rebound: momentum after over before; push off: momentum given in the first of two blows, of that brought; breaks even: runs after which\n"
        "the reduction is paid for")


def main():
    folder = pathlib.Path(sys.argv[1])
    runs = Runs(folder)
    draw(runs, folder)
    write_table(folder / "table.txt", [*aligned(HEADINGS, runs.rows()), NOTE])


if __name__ == "__main__":
    main()
