# SPDX-License-Identifier: GPL-3.0-or-later
"""Units, magnitudes, and input that is wrong."""
import numpy as np

from parts import box
from runs import STEEL, block_scene, changed, reduction
from rows_contact import PAIR, impact, scene
from rows_reduction import FREE, sound
from table import below, holds, refused, row

UNITS, BAD = "Units and magnitudes", "Bad input"


def impact_in(folder, kind, length=1.0, mass=1.0, time=1.0, part=None, modes=6, way=None):
    """Momenta of an impact in other units, brought back. Edges and nodes of one block meet edges of the other but for round-off."""
    part = (part or box((2, 2, 2))).scaled(length)
    speed = length / time
    s = scene(folder, {"a": {"as": kind, "velocity": [0.1 * speed, 0, 0]}, "b": {"as": kind, "position": [1.001 * length, 0.1 * length, 0]}}, PAIR, 1.0 * time,
              part, modes=modes, material={"youngs_modulus": 100 * mass / (length * time**2), "density": mass / length**3})
    s["components"]["block"]["reduction"].update(way or {})
    return folder.dyn(s).done()["instances/b/momentum"] / (mass * speed)


@row(UNITS, "The same impact in units 1e-6 to 1e6 of length, mass and time: change of the momenta")
def units(folder):
    answers = []
    for kind in ("superelement", "mesh"):
        one = impact_in(folder, kind)
        for name, factors in (("micrometres", (1e6, 1, 1)), ("kilometres", (1e-3, 1, 1)), ("megametres", (1e-6, 1, 1)), ("micrograms", (1, 1e9, 1)),
                              ("gigagrams", (1, 1e-9, 1)), ("nanoseconds", (1, 1, 1e9)), ("years", (1, 1, 3e-8)), ("mm t s", (1e3, 1e-3, 1))):
            other = impact_in(folder, kind, *factors)
            answers.append((f"{name}, {kind}", *below(np.abs(other - one).max() / np.abs(one).max(), 8e-14)))
    return answers


@row(UNITS, "Magnitudes near the ends of double: an impact with E = 1e-150 to 1e150 and the density to fit")
def magnitudes(folder):
    answers = []
    for kind in ("superelement", "mesh"):
        one = impact_in(folder, kind)
        for mass in (1e-150, 1e-100, 1e100, 1e150):
            other = impact_in(folder, kind, mass=mass)
            answers.append((f"masses by {mass:g}, {kind}", *below(np.abs(other - one).max() / np.abs(one).max(), 8e-14)))
    return answers


@row(UNITS, "Masses and stiffnesses by 1e-300 to 1e300 in an impact with friction, tied, mortar, newmark: change of the momenta, or a named error")
def extreme_magnitudes(folder):
    ways = {"friction": {"friction": 0.3}, "tied": {"tied": True, "adjust": 0.01}, "mortar": {"formulation": "mortar", "friction": 0.3},
            "penalty": {"enforcement": "penalty"}, "newmark": {"friction": 0.3}, "newmark, tied": {"tied": True, "adjust": 0.01}}
    answers = []
    for name, contact in ways.items():
        for kind in ("superelement", "mesh"):
            one = None
            for mass in (1.0, 1e-300, 1e-250, 1e-200, 1e200, 1e250, 1e300) if folder.full else (1.0, 1e-250, 1e300):
                s = scene(folder, {"a": {"as": kind, "velocity": [0.1, 0, 0]}, "b": {"as": kind, "position": [1.001, 0.1, 0]}}, [PAIR[0] | contact], 1.0,
                          box((2, 2, 2)), modes=6, material={"youngs_modulus": 100 * mass, "density": mass},
                          integrator="newmark" if "newmark" in name else "exact")
                ran = folder.dyn(s)
                if mass == 1:
                    one = ran.done()["instances/b/momentum"]
                elif ran.code:
                    answers.append((f"by {mass:g}, {name}, {kind}", *refused(ran, "no longer finite" if ran.code == 1 else "", code=ran.code if ran.code in (1, 2) else 1)))
                else:
                    answers.append((f"by {mass:g}, {name}, {kind}", *below(np.abs(ran.done()["instances/b/momentum"] / mass - one).max() / np.abs(one).max(), 1e-11)))
    return answers


@row(UNITS, "Young's modulus 1e300, 1e-300; density 1e300, 1e-300: a named error, or sound")
def extreme_material(folder):
    answers = []
    for key in ("youngs_modulus", "density"):
        for value in (1e300, 1e-300):
            for kind in ("superelement", "mesh"):
                s = scene(folder, {"a": {"as": kind, "velocity": [0.1, 0, 0]}}, end=1.0, material={key: value}, modes=4)
                ran = folder.dyn(s)
                if ran.code != 0:
                    answers.append((f"{key} {value:g}, {kind}", *refused(ran, key)))
                    continue
                p = ran.done()["instances/a/momentum"]
                answers.append((f"{key} {value:g}, {kind}", *below(np.abs(p - p[0]).max() / np.abs(p[0]).max(), 1e-14)))
    return answers


def skinned(folder, integrator, **skin):
    """An impact of blocks with a skin, and without one."""
    values = {"youngs_modulus": 100.0, "poissons_ratio": 0.25, "density": 1.0, "thickness": 1e-3, **skin}
    s = scene(folder, {"a": {"velocity": [0.1, 0, 0]}, "b": {"as": "mesh", "position": [1.001, 0, 0]}}, PAIR, integrator=integrator)
    return s | {"skin": {"surfaces": ["x_min", "x_max"], **values}}, s


@row(UNITS, "Shell parameters down to 1e-300: change of the momenta against no skin")
def faint_shells(folder):
    answers = []
    for integrator in ("exact", "central-difference", "newmark"):
        for name, skin in (("all 1e-300", dict(youngs_modulus=1e-300, density=1e-300, thickness=1e-300)), ("thickness 1e-300", dict(thickness=1e-300)),
                           ("modulus 1e-300", dict(youngs_modulus=1e-300, density=1e-12)), ("density 1e-300", dict(density=1e-300, youngs_modulus=1e-6)),
                           ("thickness 1e-150", dict(thickness=1e-150))):
            with_skin, without = skinned(folder, integrator, **skin)
            ran = folder.dyn(with_skin)
            if ran.code != 0:
                answers.append((f"{name}, {integrator}", *refused(ran, "skin", "density", code=ran.code)))
                continue
            a, b = ran.done()["instances/b/momentum"], folder.dyn(without).done()["instances/b/momentum"]
            answers.append((f"{name}, {integrator}", *below(np.abs(a - b).max() / np.abs(b).max(), 1e-13)))
    return answers


@row(UNITS, "Shell parameters of 1e300: a named error, or finite")
def heavy_shells(folder):
    answers = []
    for integrator in ("exact", "central-difference", "newmark"):
        for key in ("youngs_modulus", "density", "thickness"):
            ran = folder.dyn(skinned(folder, integrator, **{key: 1e300})[0])
            answers.append((f"{key}, {integrator}", *(refused(ran, "skin", key, code=ran.code) if ran.code else holds("finite", "finite", ran.done().code == 0))))
    return answers


@row(UNITS, "Speeds of 1e-300 and 1e100; loads of 1e-300 and 1e100: finite, or a named error")
def extreme_motion(folder):
    answers = []
    for kind in ("superelement", "mesh"):
        for speed in (1e-300, 1e100, 1e200):
            s = scene(folder, {"a": {"as": kind, "velocity": [speed, 0, 0]}, "b": {"as": kind, "position": [1.001, 0, 0]}}, PAIR, 1.0)
            ran = folder.dyn(s)
            answers.append((f"speed {speed:g}, {kind}", *(refused(ran, "velocity") if ran.code == 2 else refused(ran, "no longer finite", code=1) if ran.code
                                                         else holds("finite", "finite", ran.done().code == 0))))
        for force in (1e-300, 1e100, 1e200):
            ran = folder.dyn(scene(folder, {"a": {"as": kind}}, loads=[{"instance": "a", "surface": "x_min", "force": [force, 0, 0]}]))
            answers.append((f"force {force:g}, {kind}", *(refused(ran, "the loads and their units" if "turns by" in ran.error() else "no longer finite", code=1) if ran.code else holds("finite", "finite", ran.done().code == 0))))
    return answers


@row(UNITS, "A component of size 1e-150, of 1e150, and with coordinates of 1e300: a named error, or sound")
def extreme_sizes(folder):
    answers = []
    for size in (1e-150, 1e-100, 1e-40, 1e40, 1e100, 1e150, 1e300):
        ran = folder.superelement(FREE.scaled(size), ["x_min"])
        answers.append((f"{size:g}", *(refused(ran) if ran.code else sound(ran.done()))))
    return answers


def numbers(value, at=()):
    """Paths of all numbers in a scene."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield from numbers(item, (*at, key))
    if isinstance(value, float):
        yield at


FULL = {"materials": {"steel": {"youngs_modulus": 100.0, "poissons_ratio": 0.25, "density": 1.0}},
        "components": {"block": {"mesh": "mesh.msh", "material": "steel", "reduction": {"interface": ["x_min", "x_max"], "cutoff_hz": 3.0}}},
        "instances": {"a": {"component": "block", "position": [0.0, 0.0, 0.0], "rotation": [0.0, 0.0, 0.0], "velocity": [0.1, 0.0, 0.0]},
                      "b": {"component": "block", "as": "mesh", "position": [1.001, 0.0, 0.0]}},
        "skin": {"surfaces": ["x_max"], "youngs_modulus": 1.0, "poissons_ratio": 0.25, "density": 0.1, "thickness": 0.001},
        "loads": [{"instance": "a", "surface": "x_min", "traction": [0.1, 0.0, 0.0], "history": {"time": [0.0, 0.1], "value": [0.0, 1.0]}}, {"gravity": [0.0, 0.0, -0.1]}],
        "walls": {"floor": {"plane": {"point": [0.0, 0.0, -1.0], "normal": [0.0, 0.0, 1.0]}}, "ball": {"sphere": {"center": [0.0, 9.0, 0.0], "radius": 1.0}}},
        "contact": [{"between": ["a.x_max", "b.x_min"], "friction": 0.1, "adjust": 0.01}, {"between": ["a.x_min", "floor"], "enforcement": "penalty", "damping": 0.1},
                    {"between": ["b.x_max", "ball"]}],
        "time": {"end": 0.1, "step": 0.001}, "output": {"every": 0.01}}


@row(BAD, "A number that is not finite, at every number of a scene with everything in it")
def not_finite(folder):
    folder.mesh(box((2, 2, 2)))
    folder.dyn(FULL).done()
    answers, missed, count = [], [], 0
    for value in (float("nan"), float("inf"), float("-inf")):
        for path in numbers(FULL):
            text = {"nan": ".nan", "inf": ".inf", "-inf": "-.inf"}[str(value)]
            name = folder.scene(changed(FULL, *path, to=f"@{text}@"))
            file = folder.path / name
            file.write_text(file.read_text().replace(f'"@{text}@"', text))
            ran = folder.program("cbr-dyn", "--threads", 1, name, "-o", "other.h5", file="other.h5")
            count += 1
            key = ".".join(str(p) for p in path if not isinstance(p, int))
            if ran.code != 2 or not all(str(p) in ran.error() for p in path if not isinstance(p, int)) or "finite" not in ran.error():
                missed.append(f"{key} {text}: {ran.error()}")
    return holds(f"{count - len(missed)} of {count} refused by name" + "".join("; " + m for m in missed[:3]), "all", not missed)


@row(BAD, "Every number of that scene at 1e300, -1e300 and 0: finite results, or a named error; none else", slow=True)
def absurd(folder):
    folder.mesh(box((2, 2, 2)))
    bad, count, named, weak = [], 0, 0, []
    for value in (1e300, -1e300, 0.0):
        for path in numbers(FULL):
            if path[0] == "output" and value == 0:
                continue
            count += 1
            place = ".".join(map(str, path)) + f" = {value:g}"
            try:
                ran = folder.dyn(changed(FULL, *path, to=value))
                if ran.code == 0:
                    ran.done()
                    continue
                named += 1
                if "unexpected" in ran.error():
                    bad.append(f"{place}: {ran.error()}")
                elif path[0] in ran.error() or (isinstance(path[1], str) and path[1] in ran.error()) or "scene" in ran.error():
                    continue
                else:
                    weak.append(f"{place}: {ran.error()}")
            except Exception as error:
                bad.append(f"{place}: {error}")
    return holds(f"{count} runs, {named} refused" + "".join("; " + b for b in bad + weak), "no other end", not bad and not weak)


REFUSED = [("density 0", ("materials", "steel", "density"), 0.0), ("a negative modulus", ("materials", "steel", "youngs_modulus"), -1.0),
           ("Poisson's ratio 0.5", ("materials", "steel", "poissons_ratio"), 0.5), ("a negative gap to adjust", ("contact", 0, "adjust"), -0.01),
           ("negative friction", ("contact", 0, "friction"), -0.1), ("a restitution above 1", ("contact", 0, "restitution"), 2.0),
           ("damping with impulses", ("contact", 0, "damping"), 0.1), ("a time of 0", ("time", "end"), 0.0), ("a negative step", ("time", "step"), -1e-3),
           ("a step of 1e-300", ("time", "step"), 1e-300), ("outputs every 1e-12", ("output", "every"), 1e-12), ("cfl 0", ("time", "step"), {"cfl": 0.0}),
           ("times that do not ascend", ("loads", 0, "history", "time"), [0.1, 0.1]), ("a normal of length 0", ("walls", "floor", "plane", "normal"), [0.0, 0.0, 0.0]),
           ("a radius of 0", ("walls", "ball", "sphere", "radius"), 0.0), ("-1 modes", ("components", "block", "reduction"), {"interface": ["x_min"], "modes": -1}),
           ("modes and a cutoff", ("components", "block", "reduction"), {"interface": ["x_min"], "modes": 1, "cutoff_hz": 1.0}),
           ("0 domains", ("components", "block", "reduction", "domains"), 0), ("an instance that is not there", ("contact", 0, "between"), ["a.x_max", "c.x_min"]),
           ("a surface that is not there", ("contact", 0, "between"), ["a.x_max", "b.nose"]), ("a surface against itself", ("contact", 0, "between"), ["a.x_max", "a.x_max"])]


@row(BAD, "What a scene cannot mean")
def meaningless(folder):
    folder.mesh(box((2, 2, 2)))
    answers = []
    for name, path, value in REFUSED:
        words = [key for key in path if isinstance(key, str)][:2]
        ran = folder.dyn(changed(FULL, *path, to=value))
        if name == "a surface that is not there":
            words = ["nose"]
        answers.append((name, *refused(ran, *(words if path[0] not in ("contact", "time") else words[:1]))))
    return answers
