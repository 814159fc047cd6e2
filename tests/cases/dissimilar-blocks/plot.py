#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fig 8 of the paper and the studies beside it from the results in a folder: fig8.png, force.png, modes.png, meshes.png, row.png,
table.txt.

    plot.py out
"""
import pathlib
import re
import sys

import h5py
import numpy as np

sys.path.append("..")
from plotting import GREY, plt, save, style
from results import Run, Runs, write_table

SPEED = 3810.0
MASS_LEFT = 7.836e4 * 0.0762 * 0.1016 * 0.1016
TOUCH = 0.0152 / SPEED
# Of the impactor, m/s: where the full meshes' velocities after the impact go as the mesh is refined. See README.md.
CONVERGED = {"sphere": (3724.5, 1.5), "brick": (2966.0, 12.0)}
SIZES = {"sphere": (1.5, 1, 1 / 2, 1 / 3), "brick": (2, 1, 1 / 2, 1 / 3)}  # element sizes of the mesh levels over the paper's
STYLES = {
    "full-impulse": ("full mesh", "#1f3b73", dict(linewidth=3.4, alpha=0.5)),
    "k200-impulse": ("superelements, 200 modes", "#2a9d4a", dict(linewidth=1.4)),
    "k200-nodal": ("the same, node-lumped contact", "#b3202c", dict(linewidth=1.2, linestyle="--")),
}


class Impact(Run):
    """A run of two blocks. x, v: body -> n, mean position and velocity in x; force (n): in x, on the impactor."""

    def __init__(self, path):
        super().__init__(path)
        p = {name: self.momentum[name][:, 0] for name in ("left", "right")}
        mass = {"left": MASS_LEFT, "right": p["right"][0] / -SPEED}  # of the mesh: the sphere is a polyhedron
        self.v = {name: p[name] / mass[name] for name in mass}
        with h5py.File(path) as f:
            surface = next(name for name in f["surfaces"] if name.startswith("right"))
            self.x = {name: f["instances"][name]["center_of_mass"][:, 0] for name in mass}
            self.force = f["surfaces"][surface]["force"][:, 0]


def contact_time(run):
    acting = run.t[np.abs(run.force) > 1e-3 * np.abs(run.force).max()]
    return acting[-1] - TOUCH


def rms(run, reference):
    """Of the impactor's position after first touch, in percent of its way at 3810 m/s over the contact time of the reference."""
    after = run.t > TOUCH
    return 100 * np.sqrt(np.mean((run.x["right"] - reference.x["right"])[after] ** 2)) / (SPEED * contact_time(reference))


class Impacts(Runs):
    """The impacts of a folder by name (sphere-full-impulse-m1x1)."""

    def __init__(self, folder):
        super().__init__(folder.glob("*-m?x?.h5"), Impact)

    def names(self, shape):
        return [n for n in self.paths if n.startswith(shape)]

    def level(self, shape):
        """The mesh of the paper, or the coarse one of a FAST run."""
        return "m1x1" if f"{shape}-full-impulse-m1x1" in self.paths else "m0x0"

    def full(self, name):
        """The full mesh with impulses on the mesh of `name`."""
        return self[re.sub(r"^(\w+?)-.*-(m.x.)$", r"\1-full-impulse-\2", name)]


def figure8(runs, folder):
    fig, axes = plt.subplots(3, 2, figsize=(9.5, 9.5), layout="constrained", sharex=True, sharey="row", height_ratios=(1.5, 1, 1))
    for column, (shape, letter) in enumerate((("sphere", "a"), ("brick", "b"))):
        for kind, (label, colour, options) in STYLES.items():
            name = f"{shape}-{kind}-{runs.level(shape)}"
            if name not in runs:
                continue
            run = runs[name]
            t = 1e6 * run.t
            for body in ("right", "left"):
                axes[0, column].plot(t, 1e3 * run.x[body], color=colour, label=f"{label}, {run.dofs} dofs" if body == "left" else None, **options)
            axes[1, column].plot(t, run.v["right"], color=colour, **options)
            axes[2, column].plot(t, run.v["left"], color=colour, **options)
        axes[0, column].text(0.2, 26, shape, color=GREY, fontsize=9)
        axes[0, column].text(0.2, -26, "block", color=GREY, fontsize=9)
        style(axes[0, column], f"({letter}) {shape}: mean position of each body (Fig 8{letter})", "", "mean x [mm]")
        style(axes[1, column], f"velocity of the {shape}", "", "mean velocity [m/s]")
        style(axes[2, column], "velocity of the block", "time [µs]", "mean velocity [m/s]")
        axes[0, column].legend(frameon=False, fontsize=8, loc="center right")
    save(fig, folder / "fig8.png")


CONTACTS = (("impulse", "node-face, impulse", "#1f3b73"), ("mortar", "mortar, impulse", "#2a9d4a"),
            ("penalty", "node-face, penalty", "#e07b00"), ("twoway", "two-way, penalty", "#b3202c"))


def figure_force(runs, folder):
    fig, axes = plt.subplots(2, 2, figsize=(9.5, 7.2), layout="constrained", sharex=True, sharey="row")
    for row, shape in enumerate(("sphere", "brick")):
        for column, (model, title) in enumerate((("full", "full mesh"), ("k200", "superelements"))):
            axis = axes[row, column]
            for contact, label, colour in CONTACTS:
                name = f"{shape}-{model}-{contact}-{runs.level(shape)}"
                if name in runs:
                    axis.plot(1e6 * runs[name].t, 1e-6 * runs[name].force, color=colour, label=label, linewidth=1.3)
            style(axis, f"{shape}, {title}", "time [µs]" if row else "", "force on the impactor, mean of 0.1 µs [MN]")
            axis.set_xlim(3.7, 7.6)
    axes[0, 0].legend(frameon=False, fontsize=8, loc="upper right")
    save(fig, folder / "force.png")


def figure_modes(runs, folder):
    fig, axes = plt.subplots(1, 2, figsize=(9.5, 3.8), layout="constrained")
    for shape, colour in (("sphere", "#1f3b73"), ("brick", "#e07b00")):
        found = sorted((int(m[1]), n) for n in runs.names(shape) if (m := re.search(rf"-k(\d+)-impulse-{runs.level(shape)}$", n)))
        if not found:
            continue
        modes = [k for k, _ in found]
        full = runs.full(found[0][1])
        axes[0].loglog(modes, [rms(runs[n], full) for _, n in found], "o-", color=colour, label=shape)
        axes[1].semilogx(modes, [runs[n].kept for _, n in found], "o-", color=colour, label=shape)
        axes[1].axhline(full.kept, color=colour, linewidth=0.8, linestyle=":")
    style(axes[0], "rms of the impactor's position against the full mesh", "modes in the impactor", "%")
    style(axes[1], "energy kept (dotted: full mesh)", "modes in the impactor", "share")
    for axis in axes:
        axis.set_xticks([25, 50, 100, 200, 400], ["25", "50", "100", "200", "400"])
        axis.minorticks_off()
    axes[0].set_ylim(0.1, 1)
    axes[0].set_yticks([0.1, 0.2, 0.5, 1], ["0.1", "0.2", "0.5", "1"])
    axes[1].legend(frameon=False, fontsize=9)
    save(fig, folder / "modes.png")


def figure_meshes(runs, folder):
    fig, axes = plt.subplots(1, 2, figsize=(9.5, 3.8), layout="constrained")
    for axis, shape in zip(axes, ("sphere", "brick")):
        for contact, label, colour in CONTACTS:
            found = [(h, n) for m, h in enumerate(SIZES[shape]) if (n := f"{shape}-full-{contact}-m{m}x{m}") in runs]
            if len(found) > 1:
                axis.plot([h for h, _ in found], [runs[n].v["right"][-1] for _, n in found], "o-", color=colour, label=label, linewidth=1.3)
        value, band = CONVERGED[shape]
        axis.axhspan(value - band, value + band, color=GREY, alpha=0.3, linewidth=0)
        axis.set_xlim(left=0)
        style(axis, f"{shape}: velocity after the impact, full meshes", "element size / the paper's", "m/s")
    if axes[0].lines:
        axes[0].legend(frameon=False, fontsize=8)
    save(fig, folder / "meshes.png")


BODIES = (("brick", "#e07b00"), ("bar", "#2a9d4a"), ("ball", "#1f3b73"))


class Row(Run):
    """A run of three bodies in a row. p: body -> n, momentum in x; active: pair -> n, how many points are in contact;
    aside: the largest momentum of the ball across the row, share of the first of all."""

    def __init__(self, path):
        super().__init__(path)
        self.p = {name: self.momentum[name][:, 0] for name, _ in BODIES}
        self.aside = np.abs(self.momentum["ball"][:, 1:]).max() / sum(p[0] for p in self.p.values())
        with h5py.File(path) as f:
            self.active = {name: f["contact"][name]["active"][:] for name in f["contact"] if name != "active"}


def load_rows(folder):
    return {p.stem: Row(p) for p in sorted(folder.glob("row-*-[0-9].h5"))}


def figure_row(rows, folder):
    fig, axis = plt.subplots(figsize=(7.2, 4.2), layout="constrained")
    level = max((name[-1] for name in rows if name.startswith("row-cbr")), default=None)
    for kind, label, options in (("full", "full mesh", dict(linewidth=3.4, alpha=0.45)), ("cbr", "superelements", dict(linewidth=1.4))):
        if f"row-{kind}-{level}" not in rows:
            continue
        run = rows[f"row-{kind}-{level}"]
        for name, colour in BODIES:
            axis.plot(1e6 * run.t, run.p[name], color=colour, label=f"{name}, {label}", **options)
    style(axis, "Three unlike bodies in a row, contact: all", "time [µs]", "momentum [N s]")
    axis.legend(frameon=False, fontsize=8, ncol=2)
    save(fig, folder / "row.png")


def row_table(rows):
    lines = [f"{'run':14s} {'dofs':>7s} {'steps':>6s} {'stepping s':>10s}" + "".join(f" {'p ' + name:>9s}" for name, _ in BODIES) + f" {'aside':>8s} {'energy':>7s} {'momentum':>9s}  pairs that touched"]
    for name, run in rows.items():
        lines.append(f"{name:14s} {run.dofs:7d} {run.steps:6d} {run.seconds:10.3f}" + "".join(f" {run.p[b][-1]:9.4f}" for b, _ in BODIES) +
                     f" {run.aside:8.1e} {run.kept:7.4f} {run.drift():9.1e}  " + ", ".join(pair for pair, active in run.active.items() if active.any()))
    return lines + ["p: momentum at the end, N s; aside: largest momentum of the ball across the row, share of the brick's at the start"]


def table(runs, row_runs, folder):
    rows = []
    for shape in ("sphere", "brick"):
        rows.append(f"{'run':30s} {'dofs':>7s} {'steps':>6s} {'stepping s':>10s} {'v left':>8s} {'v right':>9s} {'against full %':>14s} "
                    f"{'conv. %':>8s} {'rms %':>7s} {'energy':>7s} {'momentum':>9s} {'contact us':>10s} {'peak MN':>8s}")
        for name in runs.names(shape):
            run = runs[name]
            full = runs.full(name)
            v = run.v["right"][-1]
            rows.append(f"{name:30s} {run.dofs:7d} {run.steps:6d} {run.seconds:10.3f} {run.v['left'][-1]:8.3f} {v:9.2f} "
                        f"{100 * (v - full.v['right'][-1]) / SPEED:14.2f} {100 * (v - CONVERGED[shape][0]) / SPEED:8.2f} {rms(run, full):7.2f} "
                        f"{run.kept:7.4f} {run.drift():9.1e} {1e6 * contact_time(run):10.2f} {1e-6 * np.abs(run.force).max():8.1f}")
        rows.append(f"converged: {CONVERGED[shape][0]:.0f} +- {CONVERGED[shape][1]:.0f} m/s\n")
    rows.append("against full, conv.: velocity of the impactor after the impact less that of the full mesh (the same mesh, impulse), less the converged\n"
                "one, in % of 3810 m/s; rms: of the impactor's position from first touch, in % of 3810 m/s x contact time; energy: at the end over at\n"
                "the start; momentum: largest drift over the whole; contact us: from first touch to the end of the last 0.1 us with a force")
    rows += ["", *row_table(row_runs)]
    write_table(folder / "table.txt", rows)


def main():
    folder = pathlib.Path(sys.argv[1])
    runs = Impacts(folder)
    figure8(runs, folder)
    figure_force(runs, folder)
    figure_modes(runs, folder)
    figure_meshes(runs, folder)
    row_runs = load_rows(folder)
    figure_row(row_runs, folder)
    table(runs, row_runs, folder)
    print(f"plots in {folder}: fig8.png force.png modes.png meshes.png row.png")


if __name__ == "__main__":
    main()
