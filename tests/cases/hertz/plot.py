#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""plot.py FOLDER [--check]: hertz.png and figures.txt from the runs in a folder; --check: exit 1 when a figure is missed."""
import pathlib
import sys

import h5py
import numpy as np

from reference import SPEED, finite_ball, hertz, hertz_history

sys.path.append("..")
from checks import Checks
from plotting import GREY, INK, bare, plt, save
from results import write_table

SHADES = ["#f2b57a", "#e07b00", "#7fc08f", "#2a9d4a", "#5b7fc7", "#1f3b73"]


def largest_pressure(path):
    """Over nodes and time, of runs that write it."""
    fields = path.with_suffix(".fields.h5")
    if not fields.exists():
        return None
    with h5py.File(fields) as f:
        return max(f[f"steps/{i}/0/contact_pressure"][:].max() for i in range(len(f["steps"])))


def load(path, reference):
    partner, kind, m = path.stem.split("-")
    plane, share = partner == "plane", 0.25 if kind == "mesh" else 1
    with h5py.File(path) as f:
        t = f["time"][:]
        force = f["surfaces/a.contact/force"][:, 2] / share
        fall = f["instances/a/center_of_mass"][0, 2] - f["instances/a/center_of_mass"][:, 2] - 1e-8  # from the first touch on
        if not plane:
            fall += f["instances/b/center_of_mass"][:, 2] - f["instances/b/center_of_mass"][0, 2]
        energy = f["energy/total"][-1] / f["energy/total"][0] - 1
        contact = f["contact"]
        radius = np.sqrt(contact[list(contact)[0]]["area"][:] / (np.pi * share))
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
        "all_force": force, "radius": radius, "pressure": largest_pressure(path),
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
    write_table(folder / "figures.txt", rows)


def draw_partner(partner, runs, reference, top, bottom):
    plane = partner == "plane"
    radius = hertz(plane)[3]
    t, force, *_ = hertz_history(plane)
    top.plot(1e6 * t, force, color=INK, linewidth=1.2, linestyle="--", label="Hertz", zorder=5)
    times, forces, _, peak, _ = reference
    top.plot(1e6 * times, forces, color=INK, linewidth=1.2, label="finite ball", zorder=5)
    bottom.plot(1e6 * t, 100 * (force - np.interp(t, times, forces, right=0)) / peak, color=INK, linewidth=1.2, linestyle="--")

    def error(r):
        return 100 * (r["force"] - np.interp(r["t"], times, forces, left=0, right=0)) / peak

    for r, colour in zip([r for r in runs if r["kind"] == "mesh"], SHADES):
        top.plot(1e6 * r["t"], r["force"], color=colour, linewidth=1.4, label=f"a / h = {radius * r['m'] / 1e-3:.1f}")
        bottom.plot(1e6 * r["t"], error(r), color=colour, linewidth=1.2)
    for kind, marker in (("superelement", "o"), ("shapes", "x")):
        r = [r for r in runs if r["kind"] == kind][-1]
        style = dict(color=INK, linestyle="none", marker=marker, markersize=3, markerfacecolor="none")
        top.plot(1e6 * r["t"][::6], r["force"][::6], label=f"{kind}, {radius * r['m'] / 1e-3:.1f}", **style)
        bottom.plot(1e6 * r["t"][::6], error(r)[::6], **style)
    top.set_ylabel("contact force [N]")
    top.set_title("two steel balls of 10 mm, 1 m/s" if not plane else "the ball on a rigid plane", fontsize=10, loc="left")
    top.set_ylim(0, None)
    top.legend(frameon=False, fontsize=7, loc="lower center")
    bottom.set_ylabel("off the finite ball [%]")
    bottom.set_xlabel("time [µs]")
    bottom.set_ylim(-4, 4)


def draw(runs, references, folder):
    fig = plt.figure(figsize=(13, 5), layout="constrained")
    grid = fig.add_gridspec(2, 3, height_ratios=(2, 1))
    axes = []
    for column, partner in enumerate(("ball", "plane")):
        axes += [fig.add_subplot(grid[0, column]), fig.add_subplot(grid[1, column])]
        draw_partner(partner, [r for r in runs if r["partner"] == partner], references[partner], *axes[-2:])
    axis = fig.add_subplot(grid[:, 2])
    for (partner, kind), colour, marker in zip((("ball", "mesh"), ("plane", "mesh"), ("ball", "superelement"), ("plane", "superelement")),
                                               ("#1f3b73", "#e07b00", "#5b7fc7", "#f2b57a"), "osxx"):
        chosen = [r for r in runs if r["partner"] == partner and r["kind"] == kind]
        axis.loglog([hertz(partner == "plane")[3] * r["m"] / 1e-3 for r in chosen], [100 * r["rms"] for r in chosen], color=colour,
                    marker=marker, linewidth=1.4 if kind == "mesh" else 0, label=f"{partner}, {kind}")
    x = np.array([1.5, 8])
    axis.loglog(x, 2 * (1.5 / x)**2, color=GREY, linestyle=":", label="second order")
    ticks = [t for t in (1, 2, 4, 8) if t < 1.2 * axis.get_xlim()[1]]
    axis.set_xticks(ticks, [str(t) for t in ticks])
    axis.minorticks_off()
    axis.set_xlabel("elements across the contact radius, a / h")
    axis.set_ylabel("rms error of the force, % of the largest")
    axis.set_title("against the finite ball", fontsize=10, loc="left")
    axis.legend(frameon=False, fontsize=8)
    for axis in [*axes, axis]:
        bare(axis)
    save(fig, folder / "hertz.png", dpi=100)


def against_all_dofs(shapes, runs):
    """Few shapes of the patch and its statics against all of its dofs: what is off, its bound."""
    full = next(r for r in runs if (r["partner"], r["kind"], r["m"]) == (shapes["partner"], "superelement", shapes["m"]))
    force = np.sqrt(np.mean((shapes["all_force"] - full["all_force"])**2)) / full["all_force"].max()
    radius = np.abs(shapes["radius"] - full["radius"]).max() * shapes["m"] / 1e-3
    return [("force, rms", force, 0.01), ("largest pressure", abs(shapes["pressure"] / full["pressure"] - 1), 0.05),
            ("contact radius, elements", radius, 1)]


def check(runs):
    checks = Checks()
    for partner in ("ball", "plane"):
        meshes = [r for r in runs if r["partner"] == partner and r["kind"] == "mesh"]
        finest = meshes[-1]
        h = np.log([1 / r["m"] for r in meshes])
        order = np.polyfit(h, np.log([r["rms"] for r in meshes]), 1)[0]
        figures = [("order of the force's error", order > 1.8, order), ("rms error of the force", finest["rms"] < 0.8 / finest["m"]**2, finest["rms"]),
                   ("approach", abs(finest["approach"]) < 0.4 / finest["m"]**2, finest["approach"]), ("duration", abs(finest["duration"]) < 0.4 / finest["m"]**2, finest["duration"])]
        for r in runs:
            if r["partner"] != partner:
                continue
            few = r["kind"] == "shapes"
            figures.append((f"energy, {r['kind']} {r['m']}", abs(r["energy"]) < (3e-3 if few else 1e-4), r["energy"]))
            for what, off, bound in against_all_dofs(r, runs) if few else []:
                figures.append((f"shapes {r['m']}: {what}", off < bound, off))
            for full in meshes:
                if r["kind"] == "superelement" and r["m"] == full["m"]:
                    gap = r["approach"] - full["approach"]
                    figures.append((f"superelement - mesh {r['m']}", abs(gap) < 3e-3, gap))
        for what, held, value in figures:
            checks.condition(f"{partner:6s} {what:32s} {value:12.4g}", held)
    return checks.exit_code()


def main():
    folder = pathlib.Path(sys.argv[1])
    references = {"ball": finite_ball(False), "plane": finite_ball(True)}
    runs = [load(path, references[path.stem.split("-")[0]]) for path in folder.glob("*-*-*.h5")
            if not path.name.endswith(".fields.h5")]
    runs.sort(key=lambda r: (r["partner"], r["kind"], r["m"]))
    if "--check" in sys.argv:
        return check(runs)
    table(runs, folder)
    draw(runs, references, folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
