#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Figs 3, 5 and 6 of the paper from the results in a folder, and a table of what the blocks do after the impact.

    plot.py out            all figures: out/fig3.png, fig5.png, fig6.png, figures.txt
    plot.py out --quick    one run: out/quick.png
"""
import pathlib
import sys

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

SPEED = 3810.0
CONVERGED = (300.4, 3509.6)  # mean velocities after the impact, mesh-converged: ../../../docs/theory.md
INK, GREY = "#222222", "#999999"
COLOURS = {"full": "#1f3b73", "a": "#2a9d4a", "b": "#e07b00", "c": "#b3202c", "shapes": "#7b2d8e"}
LABELS = {"full": "full mesh", "a": "(a) contact face", "b": "(b) both x faces", "c": "(c) whole surface",
          "shapes": "(a) by few shapes (ours)"}


def load(path):
    """Times, mean x of the two facing surfaces, mean velocities of the bodies, drift of the momentum, steps, dofs, seconds of stepping."""
    with h5py.File(path) as f:
        t = f["time"][:]
        surfaces = {name.split(".")[0]: f["surfaces"][name]["mean_position"][:, 0] for name in f["surfaces"]}
        momentum = {name: f["instances"][name]["momentum"][:, 0] for name in ("left", "right")}
        mass = momentum["left"][0] / SPEED  # both blocks are the same
        total = momentum["left"] + momentum["right"]
        return {
            "t": t, "x": surfaces, "v": {n: p / mass for n, p in momentum.items()},
            "drift": np.abs(total - total[0]).max() / abs(total[0]),
            "energy": f["energy"]["total"][-1] / f["energy"]["total"][0],
            "steps": int(f.attrs["steps"]), "dofs": int(f.attrs["n_dofs"]), "seconds": float(f.attrs["wall_seconds_steps"]),
        }


def style(axis, title):
    axis.set_title(title, fontsize=10, loc="left", color=INK)
    axis.set_xlabel("time [µs]")
    axis.set_ylabel("mean x of the facing faces [mm]")
    axis.spines[["top", "right"]].set_visible(False)
    axis.grid(True, color="#e6e6e6", linewidth=0.6)


def draw(axis, run, colour, label, **options):
    for i, body in enumerate(("left", "right")):
        axis.plot(1e6 * run["t"], 1e3 * run["x"][body], color=colour, label=label if i == 0 else None, **options)


def mark_segments(axis):
    for t, text in ((2.0, "approach"), (6.1, "contact"), (10.1, "separated")):
        axis.text(t, 0.03, text, color=GREY, fontsize=9, ha="center", transform=axis.get_xaxis_transform())
    for t in (3.99, 8.24):
        axis.axvline(t, color=GREY, linewidth=0.8, linestyle=":")


def figure3(folder):
    fig, axis = plt.subplots(figsize=(6, 4), layout="constrained")
    run = load(folder / "full-impulse.h5")
    draw(axis, run, COLOURS["full"], "full mesh, impulse", linewidth=1.8)
    mark_segments(axis)
    style(axis, "Fig 3: two equal blocks, 3810 m/s")
    axis.legend(frameon=False, fontsize=9)
    fig.savefig(folder / "fig3.png", dpi=130)


TITLES = {"nodal": "nodal: the paper's enforcement, (a) sticks", "penalty": "penalty", "impulse": "impulse: every interface rebounds"}


def figure5(folder, enforcements, file):
    fig, axes = plt.subplots(1, len(enforcements), figsize=(4.4 * len(enforcements), 4.2), layout="constrained", sharey=True)
    for axis, enforcement in zip(axes, enforcements):
        for name in ("full", "c", "b", "a") + (("shapes",) if enforcement == "impulse" else ()):
            run = load(folder / f"{name}-{enforcement}.h5")
            draw(axis, run, COLOURS[name], f"{LABELS[name]}, {run['dofs'] // 2} dofs a block",
                 linewidth=3.2 if name == "full" else 1.4, alpha=0.55 if name == "full" else 1.0)
        style(axis, TITLES[enforcement])
        axis.legend(frameon=False, fontsize=8)
    fig.suptitle("Fig 5: the choice of interface", x=0.01, ha="left")
    fig.savefig(folder / file, dpi=110)


def figure6(folder):
    fig, axes = plt.subplots(1, 2, figsize=(9.5, 4.2), layout="constrained", sharey=True)
    full = load(folder / "full-impulse.h5")
    for axis, enforcement in zip(axes, ("nodal", "impulse")):
        draw(axis, full, COLOURS["full"], "full mesh, impulse", linewidth=3.2, alpha=0.45)
        for modes, colour in ((5, "#9bd3a9"), (100, "#4bb36a"), (500, "#14632b")):
            draw(axis, load(folder / f"a{modes}-{enforcement}.h5"), colour, f"(a), {modes} modes", linewidth=1.4)
        style(axis, enforcement)
        axis.legend(frameon=False, fontsize=8)
    fig.suptitle("Fig 6: the number of fixed-interface modes behind the contact face", x=0.01, ha="left")
    fig.savefig(folder / "fig6.png", dpi=130)


def table(folder):
    rows = [f"{'run':16s} {'dofs':>7s} {'steps':>6s} {'stepping s':>10s} {'v left':>8s} {'v right':>8s} {'error %':>8s} {'energy':>7s} {'momentum drift':>15s}"]
    for path in sorted(folder.glob("*.h5")):
        if path.name.endswith(".cbr.h5"):
            continue
        run = load(path)
        v = run["v"]["left"][-1], run["v"]["right"][-1]
        error = 100 * max(abs(v[0] - CONVERGED[0]), abs(v[1] - CONVERGED[1])) / SPEED
        rows.append(f"{path.stem:16s} {run['dofs']:7d} {run['steps']:6d} {run['seconds']:10.3f} {v[0]:8.1f} {v[1]:8.1f} {error:8.2f} {run['energy']:7.4f} {run['drift']:15.1e}")
    rows.append(f"converged: {CONVERGED[0]} and {CONVERGED[1]} m/s; error: the larger of the two, in % of {SPEED:.0f} m/s")
    rows.append("dofs: those that are stepped; with impulses the fastest modes of a superelement follow at once, as statics (docs/decisions/truncation.md)")
    text = "\n".join(rows) + "\n"
    (folder / "figures.txt").write_text(text)
    print(text, end="")


def main():
    folder = pathlib.Path(sys.argv[1])
    if "--quick" in sys.argv:
        fig, axis = plt.subplots(figsize=(6, 4), layout="constrained")
        run = load(folder / "a-impulse.h5")
        draw(axis, run, COLOURS["a"], f"superelements, {run['dofs'] // 2} dofs each", linewidth=1.8)
        style(axis, "Block impact: position of the facing faces")
        axis.legend(frameon=False, fontsize=9)
        fig.savefig(folder / "quick.png", dpi=130)
        return
    figure3(folder)
    figure5(folder, ("nodal", "penalty", "impulse"), "fig5.png")
    figure5(folder, ("nodal", "impulse"), "block-impact.png")  # README's picture
    figure6(folder)
    table(folder)
    print(f"plots: {folder}/block-impact.png {folder}/fig3.png {folder}/fig5.png {folder}/fig6.png")


if __name__ == "__main__":
    main()
