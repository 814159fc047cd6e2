#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""plot.py FOLDER [--check]: hertz.png and figures.txt from the runs in a folder; --check: exit 1 when a figure is missed."""
import pathlib
import sys

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from reference import MASS, SPEED, finite_ball, hertz, hertz_history

INK, GREY = "#222222", "#999999"
SHADES = ["#f2b57a", "#e07b00", "#7fc08f", "#2a9d4a", "#5b7fc7", "#1f3b73"]


def load(path, reference):
    partner, kind, m = path.stem.split("-")
    plane, share = partner == "plane", 1 if kind == "superelement" else 0.25
    with h5py.File(path) as f:
        t = f["time"][:]
        force = f["surfaces/a.contact/force"][:, 2] / share
        fall = 1e-8 - (f["instances/a/center_of_mass"][:, 2] - f["instances/a/center_of_mass"][0, 2]) - 2e-8
        if not plane:
            fall += f["instances/b/center_of_mass"][:, 2] - f["instances/b/center_of_mass"][0, 2]
        energy = f["energy/total"][-1] / f["energy/total"][0] - 1
        steps, seconds, dofs = int(f.attrs["steps"]), float(f.attrs["wall_seconds_steps"]), int(f.attrs["n_dofs"])
    begin = 1e-8 / SPEED
    last = np.nonzero(fall > 0)[0][-1]
    end = t[last] + fall[last] / (fall[last] - fall[last + 1]) * (t[last + 1] - t[last])
    times, forces, approach, peak, duration = reference
    middle = (t[1:] + t[:-1]) / 2
    difference = force[1:] - np.interp(middle - begin, times, forces, right=0)
    return {
        "partner": partner, "kind": kind, "m": int(m), "t": middle - begin, "force": force[1:], "dofs": dofs, "steps": steps,
        "seconds": seconds, "approach": fall.max() / approach - 1, "duration": (end - begin) / duration - 1, "peak": force.max() / peak - 1,
        "rms": np.sqrt(np.sum(difference**2 * np.diff(t)) / duration) / peak, "energy": energy, "largest": (fall.max(), force.max(), end - begin),
    }


def table(runs, folder):
    rows = [f"{'run':24s} {'h / a':>6s} {'dofs':>7s} {'steps':>6s} {'s':>7s} {'approach':>9s} {'duration':>9s} {'peak':>9s} {'rms force':>9s}"
            f" {'energy':>9s}   against Hertz: approach, peak, duration"]
    for r in runs:
        plane = r["partner"] == "plane"
        exact = hertz(plane)
        off = [value / wanted - 1 for value, wanted in zip(r["largest"], exact)]
        rows.append(f"{r['partner'] + ' ' + r['kind'] + ' ' + str(r['m']):24s} {1e-3 / r['m'] / exact[3]:6.3f} {r['dofs']:7d} {r['steps']:6d}"
                    f" {r['seconds']:7.1f} {r['approach']:+9.5f} {r['duration']:+9.5f} {r['peak']:+9.5f} {r['rms']:9.5f} {r['energy']:+9.1e}"
                    f"   {off[0]:+.4f} {off[1]:+.4f} {off[2]:+.4f}")
    rows.append("errors are shares of the quasi-static answer of a finite ball; h: elements of the contact patch, a: largest contact radius")
    text = "\n".join(rows) + "\n"
    (folder / "figures.txt").write_text(text)
    print(text, end="")


def draw(runs, references, folder):
    fig, axes = plt.subplots(1, 3, figsize=(13, 4.2), layout="constrained")
    for axis, partner in zip(axes, ("ball", "plane")):
        t, force, *_ = hertz_history(partner == "plane")
        axis.plot(1e6 * t, force, color=INK, linewidth=1.2, linestyle="--", label="Hertz", zorder=5)
        t, force, *_ = references[partner]
        axis.plot(1e6 * t, force, color=INK, linewidth=1.2, label="finite ball", zorder=5)
        meshes = [r for r in runs if r["partner"] == partner and r["kind"] == "mesh"]
        for r, colour in zip(meshes, SHADES):
            axis.plot(1e6 * r["t"], r["force"], color=colour, linewidth=1.4, label=f"mesh, a / h = {hertz(partner == 'plane')[3] * r['m'] / 1e-3:.1f}")
        for r in [r for r in runs if r["partner"] == partner and r["kind"] == "superelement"][-1:]:
            axis.plot(1e6 * r["t"][::6], r["force"][::6], color=INK, linestyle="none", marker="o", markersize=3, markerfacecolor="none",
                      label=f"superelement, 10 modes, a / h = {hertz(partner == 'plane')[3] * r['m'] / 1e-3:.1f}")
        axis.set_xlabel("time [µs]")
        axis.set_ylabel("contact force [N]")
        axis.set_title("two steel balls of 10 mm, 1 m/s" if partner == "ball" else "the ball on a rigid plane", fontsize=10, loc="left")
        axis.set_ylim(0, None)
        axis.legend(frameon=False, fontsize=7.5)
    axis = axes[2]
    for (partner, kind), colour, marker in zip((("ball", "mesh"), ("plane", "mesh"), ("ball", "superelement"), ("plane", "superelement")),
                                               ("#1f3b73", "#e07b00", "#5b7fc7", "#f2b57a"), "osox"):
        chosen = [r for r in runs if r["partner"] == partner and r["kind"] == kind]
        axis.loglog([1e-3 / r["m"] / hertz(partner == "plane")[3] for r in chosen], [r["rms"] for r in chosen], color=colour, marker=marker,
                    linewidth=1.4 if kind == "mesh" else 0, label=f"{partner}, {kind}")
    x = np.array([0.2, 0.7])
    axis.loglog(x, 0.05 * x**2 / 0.49, color=GREY, linestyle=":", label="second order")
    axis.set_xlabel("element / contact radius")
    axis.set_ylabel("rms error of the force / largest force")
    axis.set_title("against the quasi-static finite ball", fontsize=10, loc="left")
    axis.legend(frameon=False, fontsize=8)
    for axis in axes:
        axis.spines[["top", "right"]].set_visible(False)
        axis.grid(True, which="both", color="#e6e6e6", linewidth=0.6)
    fig.savefig(folder / "hertz.png", dpi=110)


def check(runs):
    missed = 0
    for partner in ("ball", "plane"):
        meshes = [r for r in runs if r["partner"] == partner and r["kind"] == "mesh"]
        finest = meshes[-1]
        h = np.log([1 / r["m"] for r in meshes])
        order = np.polyfit(h, np.log([r["rms"] for r in meshes]), 1)[0]
        figures = [("order of the force's error", order > 1.1, order), ("rms error of the force", finest["rms"] < 0.012, finest["rms"]),
                   ("approach", abs(finest["approach"]) < 0.006, finest["approach"]), ("duration", abs(finest["duration"]) < 0.006, finest["duration"])]
        for r in runs:
            if r["partner"] != partner:
                continue
            figures.append((f"energy, {r['kind']} {r['m']}", abs(r["energy"]) < 1e-4, r["energy"]))
            for full in meshes:
                if r["kind"] == "superelement" and r["m"] == full["m"]:
                    gap = r["approach"] - full["approach"]
                    figures.append((f"superelement - mesh {r['m']}", abs(gap) < 3e-3, gap))
        for what, held, value in figures:
            print(f"{partner:6s} {what:32s} {value:12.4g}  {'held' if held else 'MISSED'}")
            missed += not held
    return 1 if missed else 0


def main():
    folder = pathlib.Path(sys.argv[1])
    references = {"ball": finite_ball(False), "plane": finite_ball(True)}
    runs = [load(path, references[path.stem.split("-")[0]]) for path in folder.glob("*-*-*.h5")]
    runs.sort(key=lambda r: (r["partner"], r["kind"], r["m"]))
    if "--check" in sys.argv:
        return check(runs)
    table(runs, folder)
    draw(runs, references, folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
