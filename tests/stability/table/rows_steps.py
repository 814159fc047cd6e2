# SPDX-License-Identifier: GPL-3.0-or-later
"""Time: a million steps, steps at their limit, of changing and of tiny length, decay to nothing, threads."""
import re

import h5py
import numpy as np

from parts import box
from runs import STEEL, Failed, changed, reduction
from rows_contact import PAIR
from table import below, holds, refused, row

CHAPTER = "Time steps"
PULSE = {"time": [0, 0.05, 0.1], "value": [0, 1, 0]}


def ringing(folder, kind, time, output, part=None, contact=True, material=None, modes=6):
    """A block that two opposite pulses, without a couple, have set ringing; `contact`: a wall so near that no step can be skipped."""
    part = part or box((2, 2, 2))
    loads = [{"instance": "a", "surface": s, "traction": [t, 0.0, 0.0], "history": PULSE} for s, t in (("x_min", -0.1), ("x_max", 0.1))]
    scene = {"materials": {"steel": dict(STEEL, **(material or {}))},
             "components": {"block": {"mesh": folder.mesh(part), "material": "steel", "reduction": reduction(["x_min", "x_max"], modes)}},
             "instances": {"a": {"component": "block", "as": kind}}, "loads": loads, "time": time, "output": output}
    if contact:
        scene["walls"] = {"wall": {"plane": {"point": [1.0 + WALL, 0, 0], "normal": [-1, 0, 0]}}}
        scene["contact"] = [{"between": ["a.x_max", "wall"]}]
    return scene


WALL = 0.004


def drift(ran, after=0.2):
    E, t = ran["energy/total"] - ran["energy/work_numerical"], ran["time"]
    E = E[t > after]
    return np.abs(E - E[0]).max() / E[0]


WAYS = [("superelement, exact", "superelement", {"integrator": "exact"}),
        ("mesh in an exact run", "mesh", {"integrator": "exact"}), ("superelement, central differences", "superelement", {"integrator": "central-difference"}),
        ("mesh, central differences", "mesh", {"integrator": "central-difference"}), ("superelement, newmark", "superelement", {"integrator": "newmark"}),
        ("mesh, newmark", "mesh", {"integrator": "newmark"})]


@row(CHAPTER, "One million free steps (20 000 in the quick run): drift of the energy")
def million(folder):
    n, h, answers = 1_000_000 if folder.full else 20_000, 0.01, []
    for name, kind, time in WAYS:
        every = h if kind == "superelement" and time["integrator"] == "exact" else n * h / 100  # exact motion jumps between outputs
        ran = folder.dyn(ringing(folder, kind, {"end": n * h, "step": h, **time}, {"every": every}, contact=False)).done()
        figure, bound, held = below(drift(ran), 2e-12)
        steps = int(ran.attribute("steps"))
        answers.append((name, f"{figure} in {steps} steps", bound, held and steps >= n))
    return answers


@row(CHAPTER, "Central differences at 0.99 of the critical step: drift of the energy in 100 000 steps")
def at_limit(folder):
    answers = []
    for kind in ("mesh", "superelement"):
        critical = critical_step(folder, kind)
        ran = folder.dyn(ringing(folder, kind, {"end": 1e5 * 0.99 * critical, "step": 0.99 * critical, "integrator": "central-difference"},
                                 {"every": 1e3 * 0.99 * critical}, contact=False)).done()
        answers.append((kind, *below(drift(ran), 4e-13)))
    return answers


def critical_step(folder, kind):
    ran = folder.dyn(ringing(folder, kind, {"end": 1.0, "step": 10.0, "integrator": "central-difference"}, {"every": 1.0}, contact=False))
    return float(re.search(r"critical step ([0-9.e+-]+) s", ran.error()).group(1))


@row(CHAPTER, "Central differences at 1.01 of the critical step")
def above_limit(folder):
    answers = []
    for kind in ("mesh", "superelement"):
        h = 1.01 * critical_step(folder, kind)
        time = {"end": 2000 * h, "step": h, "integrator": "central-difference"}
        scene = ringing(folder, kind, time, {"every": 20 * h}, contact=False)
        answers += [(kind, *refused(folder.dyn(scene), "above the critical step", "force: true")),
                    (f"{kind}, forced all the same", *refused(folder.dyn(changed(scene, "time", "force", to=True)), "no longer finite", "instance 'a'", code=1))]
    return answers


@row(CHAPTER, "Outputs that are no multiples of the step, and an end that is none of either: drift of the energy; motion of a face against a run without outputs "
              "between (steps of 1/8, unless each is exact); its error at all outputs falls to a quarter with half the step")
def uneven(folder):
    answers = []
    for name, kind, time in WAYS:
        def run(h, every, end=0.777):
            ran = folder.dyn(ringing(folder, kind, {"end": end, "step": h, **time}, {"every": every, "history": ["a.x_max"]}, contact=False)).done()
            return ran, ran["surfaces/a.x_max/mean_position"]
        (coarse, x), (_, half), (_, fine), (_, alone) = (run(*way) for way in ((0.002, 0.0137), (0.001, 0.0137), (0.00025, 0.0137), (0.00025, 0.777)))
        error = lambda a, b: np.abs(a - b).max() / np.abs(fine - fine[0]).max()
        figure, bound, held = below(drift(coarse), 2e-14)
        apart, exact = error(fine[-1], alone[-1]), kind == "superelement" and time["integrator"] == "exact"
        allowed = 1e-14 if exact else 1e-5
        if exact:
            falls = error(x, fine)
            text, asked, right = f"{falls:.0e}", "1e-14", falls < 1e-14
        else:
            falls = error(x, fine) / error(half, fine)
            text, asked, right = f"{falls:.2f}", "3.8 to 4.6", 3.8 < falls < 4.6
        answers.append((name, f"{figure}; {apart:.0e}; {text}", f"{bound}; {allowed:g}; {asked}", held and apart < allowed and right))
    return answers


@row(CHAPTER, "Tiny steps, 1e-9 of the critical one: drift of the energy in 10 000 steps")
def tiny(folder):
    answers = []
    for name, kind, time in WAYS:
        scene = ringing(folder, kind, {"end": 1e-6, "step": 1e-10, **time}, {"every": 1e-8}, contact=False)
        for load in scene["loads"]:
            load["history"] = {"time": [0, 1e-7, 2e-7], "value": [0, 1e7, 0]}
        answers.append((name, *below(drift(folder.dyn(scene).done(), 3e-7), 4e-14)))
    return answers


@row(CHAPTER, "Decay of a held block to nothing (newmark, alpha -1/3, 40 000 steps): denormal numbers, which slow a processor, in fields and results; amplitude "
              "when it falls no more (for information: a step's mean time over that of the first quarter, least of three runs of each)")
def decay(folder):
    answers, n = [], 40_000
    for kind in ("superelement", "mesh"):
        def run(steps):
            scene = ringing(folder, kind, {"end": 0.2 * steps, "step": 0.2, "integrator": "newmark", "alpha": -0.3333},
                            {"every": 0.2 * n / 400, "fields": ["displacement", "velocity"]}, contact=False)
            scene["loads"] = [dict(scene["loads"][1], traction=[0.1, 0.05, 0.0], history={"time": [0, 1, 2], "value": [0, 1, 0]})]
            scene["boundary"] = [{"instance": "a", "nodes": "x_min", "fix": ["x", "y", "z"]}]  # a free one would drift at round-off's speed for ever
            return folder.dyn(scene).done()
        repeats = [(run(n // 4), run(n)) for _ in range(3)]
        ran = repeats[-1][1]
        values, u = [], []
        with h5py.File(ran.file.with_suffix(".fields.h5")) as f:
            f.visititems(lambda name, item: values.append(item[()].ravel()) if isinstance(item, h5py.Dataset) and item.dtype.kind == "f" else None)
            u = [np.abs(f[f"steps/{k}/0/displacement"][()]).max() for k in sorted(f["steps"], key=int)]
        with h5py.File(ran.file) as f:
            f.visititems(lambda name, item: values.append(item[()].ravel()) if isinstance(item, h5py.Dataset) and item.dtype.kind == "f" else None)
        values = np.abs(np.concatenate(values))
        denormal = int(((values > 0) & (values < np.finfo(float).tiny)).sum())
        quarter, whole = (min(r.attribute("wall_seconds_steps") for r in of) for of in zip(*repeats))
        slower = whole / quarter / 4
        held = denormal == 0 and np.isfinite(values).all() and max(u) > 1e-6 and u[-1] < 1e-303
        answers.append((kind, *holds(f"{denormal}; from {max(u):.0e} to {u[-1]:.0e} ({slower:.1f})", "0; from above 1e-6 to below 1e-303", held)))
    return answers


def same_bytes(a, b):
    found = [{}, {}]
    for ran, into in zip((a, b), found):
        with h5py.File(ran) as f:
            f.visititems(lambda name, item: into.update({name: item[()].tobytes() if item.dtype.kind in "fi" else str(item[()])}) if isinstance(item, h5py.Dataset) else None)
    return sorted(name for name in found[0].keys() | found[1].keys() if found[0].get(name) != found[1].get(name))


def difference(a, b):
    """Largest difference of a dataset over its largest entry, forces and residuals of contact left out: those are of round-off's size."""
    worst = 0
    with h5py.File(a) as f, h5py.File(b) as g:
        for group in ("instances", "surfaces", "energy"):
            def compare(name, item):
                nonlocal worst
                if isinstance(item, h5py.Dataset) and not name.endswith("force") and "work" not in name:
                    x, y = item[()], g[group][name][()]
                    worst = max(worst, np.abs(x - y).max() / max(np.abs(x).max(), 1e-300) if np.abs(x).max() > 1e-9 else 0)
            f[group].visititems(compare)
    return worst


@row(CHAPTER, "Threads: --threads 1 and 2; byte for byte (datasets that differ) where the full mesh steps explicitly, else to round-off, as BLAS adds in another order")
def threads(folder):
    answers = []
    n = 14 if folder.full else 6
    part = box((n, n, n), (1, 1.1, 1.25))  # no two frequencies alike
    for name, kind, time in WAYS:
        for n in (1, 2):
            scene = {"materials": {"steel": STEEL}, "components": {"block": {"mesh": folder.mesh(part), "material": "steel", "reduction": reduction(["x_min", "x_max"], 20)}},
                     "instances": {"a": {"component": "block", "as": kind, "velocity": [0.1, 0, 0]}, "b": {"component": "block", "as": kind, "position": [1.001, 0.1, 0]}},
                     "contact": PAIR, "time": {"end": 0.3, **time}, "output": {"every": 0.01, "history": ["a.x_max", "b.x_min"]}}
            ran = folder.dyn(scene, threads=n).done()
            (folder.path / f"threads{n}.h5").write_bytes(ran.file.read_bytes())
            (folder.path / "block.cbr.h5").unlink(missing_ok=True)
        if kind == "superelement" or time["integrator"] == "newmark":
            bound = 2e-13 if time["integrator"] == "newmark" else 5e-13  # fewer steps, less round-off
            answers.append((name, *below(difference(folder.path / "threads1.h5", folder.path / "threads2.h5"), bound)))
            continue
        differing = same_bytes(folder.path / "threads1.h5", folder.path / "threads2.h5")
        answers.append((name, *holds(f"{len(differing)} ({differing[0]}, ...)" if differing else "0", "0", not differing)))
    return answers


@row(CHAPTER, "Held at 1 node, at 2, on a line, and everywhere, under gravity, three integrators: residual of the energy balance; free rotations kept")
def held(folder):
    answers = []
    for kind in ("superelement", "mesh"):
        for name, nodes in (("1 node", [0]), ("2 nodes", [0, 2]), ("a line", [0, 1, 2]), ("everywhere", range(27))):
            part = box((2, 2, 2))
            part.points["held"] = list(nodes)
            worst, ways = 0, []
            for integrator in ("exact", "central-difference", "newmark"):
                modes = 0 if name == "everywhere" else 6
                scene = {"materials": {"steel": STEEL},
                         "components": {"block": {"mesh": folder.mesh(part), "material": "steel", "reduction": reduction(["x_min", "x_max", "held"], modes)}},
                         "instances": {"a": {"component": "block", "as": kind, "rotation": [20.0, 30.0, 40.0]}}, "loads": [{"gravity": [0.3, 0.1, -0.2]}],
                         "boundary": [{"instance": "a", "nodes": "held", "fix": ["x", "y", "z"]}], "time": {"end": 0.5, "integrator": integrator, "step": 0.005},
                         "output": {"every": 0.05}}
                ran = folder.dyn(scene).done()
                E = ran["energy/total"] - ran["energy/work_external"] - ran["energy/work_numerical"]
                x = ran["instances/a/center_of_mass"]
                ways.append(np.abs(x - x[0]).max())
                worst = max(worst, np.abs(E - E[0]).max() / max(np.abs(ran["energy/total"]).max(), 1e-300) if ways[-1] else 0)
            free = max(ways) == 0 if name == "everywhere" else min(ways) > 1e-3
            answers.append((f"{name}, {kind}", *holds(f"{worst:.0e}; way of the centre {min(ways):.0e}", "2e-14; " + ("0" if name == "everywhere" else "above 1e-3"),
                                                     worst < 2e-14 and free)))
    return answers


@row(CHAPTER, "Odd times: an end below a step, outputs beyond the end, an end of 1e-200, of 1e200, a step of the end")
def odd_times(folder):
    answers = []
    for kind in ("superelement", "mesh"):
        for name, time, every in (("end below a step", {"end": 1e-5}, 1e-5), ("outputs beyond the end", {"end": 0.1}, 5.0), ("end 1e-200", {"end": 1e-200}, 1e-201),
                                  ("end 1e200", {"end": 1e200}, 1e199), ("step of the end", {"end": 0.01, "step": 0.01}, 0.0), ("step beyond the end", {"end": 0.01, "step": 0.02}, 0.0)):
            ran = folder.dyn(ringing(folder, kind, time, {"every": every}, contact=False))
            if ran.code == 2:
                answers.append((f"{name}, {kind}", *refused(ran, "time")))
                continue
            if ran.code == 1:
                answers.append((f"{name}, {kind}", *refused(ran, "no longer finite", code=1)))
                continue
            t = ran.done()["time"]
            answers.append((f"{name}, {kind}", *holds(f"{len(t)} outputs, the last at {t[-1]:g}", "the end", t[-1] == time["end"] and (np.diff(t) > 0).all())))
    return answers
