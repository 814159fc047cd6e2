#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Figs 9, 10 and 11 of the paper from the results in a folder: fig9.png, fig10.png, fig11.png; modes.png: fewer modes; table.txt.

    plot.py out
"""
import pathlib
import sys

import numpy as np

from runs import Runs, load_impulse
from scene import HEXES, MESHES, dofs, shell

sys.path.append("..")
from plotting import GREY, INK, plt, save, style
from results import write_table

BLUE = "#1f3b73"
COLOURS = {"full": INK, "a": "#2a9d4a", "b": "#e07b00", "c": "#b3202c"}
MODELS = {"full": "full mesh", "all": "superelement (a), every mode", "a": "superelement (a)", "b": "superelement (b)", "c": "superelement (c)"}
STEPS = {0.25: "#e07b00", 0.5: "#2a9d4a", 0.9: "#b3202c", 1.0: "#b3202c", 2.0: "#7b4fa3", 5.0: "#1f78b4", 10.0: "#999999"}
FLOOR = 1e-16


def panels(runs, title, path):
    """Of each mesh its name and two axes, displacements above and differences below. Saves the figure when all are drawn."""
    meshes = runs.meshes()
    fig, axes = plt.subplots(2, len(meshes), figsize=(5.6 * len(meshes), 7.4), layout="constrained", sharex=True, squeeze=False)
    for column, mesh in enumerate(meshes):
        elements = " x ".join(map(str, MESHES[mesh]))
        style(axes[0, column], f"{title}: {elements} hexes, {dofs(mesh, 'full')[0]} dofs", "", "mean x of the loaded face, from its start [nm]" if not column else "")
        style(axes[1, column], "largest difference so far", "time [µs]", "share of the largest displacement" if not column else "")
        axes[1, column].set_yscale("log")
        axes[1, column].set_ylim(FLOOR, 1)
        axes[1, column].set_yticks(10.0 ** np.arange(-16, 1, 4))
        yield mesh, axes[0, column], axes[1, column]
    legends(axes)
    save(fig, path)


def legends(axes):
    for axis in axes.flat:
        if axis.get_legend_handles_labels()[0]:
            log = axis.get_yscale() == "log"
            axis.legend(frameon=not log, edgecolor="none", fontsize=7.5, loc="best" if not log else "lower right", bbox_to_anchor=(0, 0, 1, 1) if not log or axis.get_ylim()[0] > 1e-10 else (0, 0.29, 1, 0.5))


def curve(axis, run, label=None, **options):
    axis.plot(1e6 * run.t, 1e9 * run.x["contact"], label=label, **options)


def so_far(axis, t, difference, label, **options):
    axis.plot(1e6 * t, np.maximum(np.maximum.accumulate(difference), FLOOR), label=f"{label}: {difference.max():.1e}", **options)


def to_reference(runs, axis, run, label, hexes="bubble", **options):
    """Distance over time from the exact solution of the full mesh."""
    reference = runs.reference(run.mesh, hexes)
    difference = np.abs(run.x["contact"] - reference.at(run.t, "contact")) / reference.largest["contact"]
    so_far(axis, run.t, difference, label, **options)


def to_runs(axis, pairs, label, **options):
    """Largest distance over time between the runs of each pair, whose times are the same."""
    if pairs:
        largest = np.abs(pairs[0][1].x["contact"]).max()
        difference = np.max([np.abs(r.x["contact"] - s.x["contact"]) for r, s in pairs], axis=0) / largest
        so_far(axis, pairs[0][0].t, difference, label, **options)


def pick(runs, *names):
    return next((runs[n] for n in names if n in runs), None)


def with_shells(runs, mesh, scheme):
    """Pairs of runs: with shells of one of the paper's settings, and without."""
    found = [r for r in runs.all(mesh=mesh, hexes="bubble", scheme=scheme) if r.skin and r.skin != "zero"]
    return [(r, runs[r.name.removesuffix("-" + r.skin)]) for r in found if r.name.removesuffix("-" + r.skin) in runs]


def figure9(runs, folder):
    """Explicit superelements, with and without shells, against the implicit full mesh."""
    for mesh, top, below in panels(runs, "Fig 9", folder / "fig9.png"):
        implicit = pick(runs, f"{mesh}-bubble-full-newmark-n12", f"{mesh}-bubble-all-exact", f"{mesh}-bubble-full-explicit-n48")
        scheme = {"newmark": "implicit", "explicit": "explicit", "exact": "exact in time"}[implicit.scheme]
        curve(top, implicit, f"full mesh, {scheme} (as the paper's SD)", color=BLUE, linewidth=4, alpha=0.45)
        shells = with_shells(runs, mesh, "explicit")
        for run, _ in shells:
            curve(top, run, color=COLOURS[run.model], linewidth=0.8)
        if shells:
            top.plot([], [], color=GREY, linewidth=0.8, label=f"{len(shells)} runs with shells, explicit")
        full = pick(runs, f"{mesh}-bubble-full-explicit-n6")
        found = [r for r in runs.all(mesh=mesh, hexes="bubble", scheme="explicit", skin=None, model=("a", "b", "c")) if r.h == full.h]
        for run, dashes in zip(found, ((6, 6), (4, 4), (2, 3))):
            curve(top, run, f"{MODELS[run.model]}, explicit", color=COLOURS[run.model], linewidth=1.3, dashes=dashes)
        if implicit.scheme != "exact":
            to_reference(runs, below, implicit, f"full mesh, {scheme}, {1e9 * implicit.h:.3g} ns, to exact", color=BLUE, linewidth=1.2)
        for run in found[:1]:
            to_reference(runs, below, run, f"superelements, explicit, {1e9 * run.h:.0f} ns, to exact", color=INK, linewidth=1.2)
        to_runs(below, shells, "shells, all settings, to no shells", color="#7b4fa3", linewidth=1.2)
        for run in found:
            to_runs(below, [(run, full)], f"{MODELS[run.model]} to full mesh, both explicit", color=COLOURS[run.model], linewidth=1, dashes=(3, 2))


def figure10(runs, folder):
    """The same scheme for full mesh and superelements, at several steps: implicit, as in Sierra/SD."""
    for mesh, top, below in panels(runs, "Fig 10", folder / "fig10.png"):
        scheme = "newmark" if runs.all(mesh=mesh, scheme="newmark") else "explicit"
        found = runs.all(mesh=mesh, hexes="bubble", scheme=scheme, skin=None)
        multiples = sorted({r.multiple for r in found if r.multiple and r.model == "full"})
        for multiple in multiples:
            same = {r.model: r for r in found if r.multiple == multiple}
            blind = ": sees no load" if same["full"].impulse == 0 else ""
            curve(top, same["full"], f"full mesh, step {multiple:g} x critical{blind}", color=STEPS[multiple], linewidth=3.6, alpha=0.4)
            for model, dashes in zip("abc", ((6, 6), (4, 4), (2, 3))):
                if model in same:
                    curve(top, same[model], color=STEPS[multiple], linewidth=1.1, dashes=dashes)
            to_reference(runs, below, same["full"], f"full mesh, {multiple:g} x critical, to exact", color=STEPS[multiple], linewidth=1.1)
        if any(r.model in "abc" and r.multiple for r in found):
            top.plot([], [], color=GREY, linewidth=1.1, dashes=(4, 4), label="superelements (a), (b), (c), the same steps")
        full = pick(runs, f"{mesh}-bubble-full-{scheme}-n6")
        to_runs(below, [(r, full) for r in found if full and r.h == full.h and r.model in "abc"], "superelements to full mesh, same step", color=GREY, linewidth=1.2)


def figure11(runs, folder):
    """The full mesh of Sierra/SM's kind of hex, explicit, at several steps, against that of Sierra/SD's."""
    for mesh, top, below in panels(runs, "Fig 11", folder / "fig11.png"):
        implicit = pick(runs, f"{mesh}-bubble-full-newmark-n12", f"{mesh}-bubble-all-exact", f"{mesh}-bubble-full-explicit-n48")
        curve(top, implicit, "incompatible modes (as the paper's SD)", color=BLUE, linewidth=4, alpha=0.45)
        for run in runs.all(mesh=mesh, hexes="under", model="full", scheme="explicit", skin=None):
            if run.multiple:
                curve(top, run, f"under-integrated, explicit, {run.multiple:g} x critical", color=STEPS[run.multiple], linewidth=1.2)
                to_reference(runs, below, run, f"{run.multiple:g} x critical, to its own hex's exact", hexes="under", color=STEPS[run.multiple], linewidth=1.1)
        for hexes, colour, dashes in (("under", INK, (1, 0)), ("plain", GREY, (4, 2))):
            reference = runs.reference(mesh, hexes)
            if reference:
                base = runs.reference(mesh, "bubble")
                gap = np.abs(reference.x["contact"] - base.at(reference.t, "contact")) / base.largest["contact"]
                so_far(below, reference.t, gap, f"{HEXES[hexes]} to hex8-incompatible, both exact", color=colour, linewidth=1.4, dashes=dashes)
        below.set_ylim(1e-5, 1)
        below.set_yticks(10.0 ** np.arange(-5, 1))


def figure_modes(runs, folder):
    """How many modes the load asks for: distance of superelements of fewer dofs."""
    meshes = [m for m in runs.meshes() if any(r.model[1:].isdigit() for r in runs.all(mesh=m, scheme="exact"))]
    if not meshes:
        return
    fig, axes = plt.subplots(1, len(meshes), figsize=(5.6 * len(meshes), 4.2), layout="constrained", sharey=True, squeeze=False)
    for axis, mesh in zip(axes.flat, meshes):
        for interface in "abc":
            found = sorted((r for r in runs.all(mesh=mesh, hexes="bubble", scheme="exact") if r.model[1:].isdigit() and r.model[0] == interface), key=lambda r: r.dofs)
            dof = [r.dofs / dofs(mesh, "full")[0] for r in found]
            axis.semilogy(dof, [runs.difference(r) for r in found], "o-", color=COLOURS[interface], markersize=4, label=f"({interface}), loaded face")
            axis.semilogy(dof, [runs.difference(r, "load") for r in found], "s--", color=COLOURS[interface], markersize=4, linewidth=1, label=f"({interface}), the two loaded element faces")
        gaps = [runs.difference(r, hexes="bubble") for r in runs.all(mesh=mesh, hexes="under", scheme="exact", model="all")]
        if gaps:
            axis.axhline(gaps[0], color=GREY, linewidth=0.9, linestyle=":", label="full meshes of two hexes, loaded face")
        style(axis, f"{' x '.join(map(str, MESHES[mesh]))} hexes: distance from the full mesh, exact in time", "dofs of the superelement / dofs of the mesh", "share of the largest displacement")
        axis.set_xlim(0, 1.02)
    axes[0, 0].legend(frameon=False, fontsize=7.5, loc="lower left")
    save(fig, folder / "modes.png")


def table(runs, folder):
    rows = []
    for mesh in runs.meshes():
        rows += [f"{'run':38s} {'dofs':>6s} {'steps':>6s} {'step ns':>8s} {'x crit.':>7s} {'own hex':>9s} {'two faces':>9s} {'bubble':>9s} {'no shells':>9s} "
                 f"{'impulse':>9s} {'balance':>8s} {'stepping s':>10s}  shells"]
        for run in runs.all(mesh=mesh):
            plain = dict((r.name, s) for r, s in with_shells(runs, mesh, run.scheme)).get(run.name)
            gap = f"{np.abs(run.x['contact'] - plain.x['contact']).max() / np.abs(plain.x['contact']).max():9.1e}" if plain else f"{'':9s}"
            modulus, density, thickness = shell(run.skin) if run.skin else (0, 0, 0)
            own = [f"{runs.difference(run, s):9.2e}" if runs.reference(mesh, run.hexes) else f"{'':9s}" for s in ("contact", "load")]
            bubble = f"{runs.difference(run, hexes='bubble'):9.2e}" if runs.reference(mesh) else f"{'':9s}"
            rows.append(f"{run.name:38s} {run.dofs:6d} {run.steps:6d} {1e9 * run.h:8.2f} {f'{run.multiple:g}' if run.multiple else '':>7s} {' '.join(own)} {bubble} {gap} "
                        f"{run.impulse / load_impulse(mesh) - 1:9.1e} {run.balance:8.1e} {run.seconds:10.3f}"
                        + (f"  {modulus:g} Pa, {density:g} kg/m3, {thickness:g} m" if run.skin else ""))
        for hexes in HEXES:
            if runs.reference(mesh, hexes):
                rows.append(f"exact, {mesh}, {HEXES[hexes]}: {runs.reference(mesh, hexes).what}; largest displacement {1e9 * runs.reference(mesh, hexes).largest['contact']:.3f} nm")
        rows.append("")
    rows.append("Largest difference over time, in shares of the largest displacement. own hex: mean of the loaded face against the exact solution of the full mesh of the same\n"
                "hexes; two faces: the same for the two loaded element faces; bubble: against the full mesh of hex8-incompatible; no shells: against the same run without.\n"
                "impulse: momentum at the end over that of the load, less 1: a step that misses the load's corners sees another load")
    write_table(folder / "table.txt", rows)


def main():
    folder = pathlib.Path(sys.argv[1])
    runs = Runs(folder)
    figure9(runs, folder)
    figure10(runs, folder)
    figure11(runs, folder)
    figure_modes(runs, folder)
    table(runs, folder)
    print(f"plots in {folder}: fig9.png fig10.png fig11.png modes.png")


if __name__ == "__main__":
    main()
