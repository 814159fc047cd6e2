# SPDX-License-Identifier: GPL-3.0-or-later
"""Thin sheets and extreme sizes, reduced in every way and let fall: mass, momentum and way have to be those of their weight."""
import numpy as np

from parts import Part, box, join
from rows_condition import tells
from rows_reduction import linked
from runs import block_scene, reduction
from table import below, holds, refused, row

STEEL = {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3, "density": 7850.0}
ALL_WAYS = {"craig-bampton": {}, "tolerance": {"modes": None, "tolerance": 0.01}, "participation": {"pick": "participation"},
            "massless, free modes": {"basis": "massless"},
            "characteristic": {"basis": "characteristic", "characteristic": {"modes": 6}},
            "2 domains": {"domains": 2}, "2 domains and a second reduction": {"domains": 2, "second_reduction": {"modes": 6}}}


def falling(folder, part, way, interface, material, gravity, end, modes=12):
    """A free component under its weight."""
    options = {key: value for key, value in {**reduction(interface, modes), **way}.items() if value is not None}
    s = block_scene(folder.mesh(part), interface, modes, material)
    s["components"]["block"]["reduction"] = options
    return s | {"loads": [{"gravity": list(gravity)}], "time": {"end": end}, "output": {"every": end / 5, "history": ["a." + interface[0]]}}


def fall_error(folder, s, mass, gravity):
    """Errors of the momentum, of the way fallen and of the mass, or the Ran that ended in an error."""
    made = folder.reduce(s)
    if made.code != 0:
        return made
    ran = folder.dyn(s)
    if ran.code != 0:
        return ran
    found = float(np.ravel(made.done()["rigid_body/mass"])[0])
    p, t = ran.done()["instances/a/momentum"], ran["time"]
    own = np.outer(t, gravity) * found
    surface = s["output"]["history"][0]
    x = ran[f"surfaces/{surface}/mean_position"]
    way = np.outer(t**2 / 2, gravity)
    return np.abs(p - own).max() / np.abs(own).max(), np.abs(x - x[0] - way).max() / np.abs(way).max(), abs(found / mass - 1)


def judged(answer, bound, told=()):
    """`told`: words of the error that will do instead."""
    if not isinstance(answer, tuple):
        return refused(answer, *told) if told else (f"refused: {answer.error()}", f"{bound:g}", False)
    return ", ".join(f"{error:.0e}" for error in answer), f"{bound:g}", max(answer) <= bound


@row("Other bases, and domains", "Sheets of aspect ratio 10 to 1e4, free under gravity: errors of momentum, way and mass; from 1e3 (massless) or 1e4 on an error that names node and cure will do")
def thin_sheets(folder):
    answers, gravity = [], np.array([1.0, 2.0, -3.0])
    for aspect in (10, 100, 1000, 10000):
        part = box((6, 6, 1), (1, 1, 1 / aspect))
        for name, way in ALL_WAYS.items():
            s = falling(folder, part, way, ("x_min", "x_max"), STEEL, gravity, 1.0)
            told = ("component 'block'", "thin") if aspect == 10000 else ("component 'block'", "modes") if aspect == 1000 and "massless" in name else ()
            answers.append((f"{aspect}, {name}", *judged(fall_error(folder, s, STEEL["density"] / aspect, gravity), 1e-10, told)))
    return answers


@row("Other bases, and domains", "Sheets of steel in SI units, held at an edge, free under gravity: errors of momentum, way and mass", slow=True)
def steel_sheets(folder):
    answers, gravity = [], np.array([0, 0, -9.81])
    for size, thickness, n in ((1.0, 2e-3, 20), (0.3, 1e-3, 10), (0.3, 1e-3, 20)):
        for name, way in ALL_WAYS.items():
            s = falling(folder, box((n, n, 1), (size, size, thickness)), way, ["x_min"], STEEL, gravity, 1.0, 20)
            told = ("component 'block'", "modes") if "massless" in name else ()
            answers.append((f"{size:g} x {size:g} x {thickness:g}, {n} x {n}, {name}", *judged(fall_error(folder, s, STEEL["density"] * size * size * thickness, gravity), 1e-12, told)))
    return answers


@row("Conditioning", "A sheet of aspect ratio 1e4: what round-off does to rigid motions is told")
def lag_is_told(folder):
    return tells(folder.superelement(box((6, 6, 1), (1, 1, 1e-4)), ["x_min", "x_max"], 4), "rigid motions", "node id", "thin")


@row("Units and magnitudes", "Sizes of 1e-40 to 1e40, reduced in every way, free under gravity: errors of momentum, way and mass")
def any_size(folder):
    answers = []
    for size in (1e-40, 1e-30, 1e30, 1e40):
        gravity = np.array([0.1, 0.2, -0.3]) / size
        for name, way in ALL_WAYS.items():
            s = falling(folder, box((3, 2, 2)).scaled(size), way, ("x_min", "x_max"), {"youngs_modulus": 100.0, "poissons_ratio": 0.25, "density": 1.0}, gravity, 0.2 * size)
            answers.append((f"{size:g}, {name}", *judged(fall_error(folder, s, size**3, gravity), 1e-12)))
    return answers


@row("Conditioning", "A hinge and one common node among the kept nodes, in every way that keeps a mass there: named")
def mechanisms(folder):
    answers = []
    for joint, where in (("hinge", lambda x: x[2] == 0), ("one node", lambda x: x[1] == 0 and x[2] == 0)):
        part = linked(where)
        part.points["kept"] = list(range(len(part.nodes)))
        for name, way in ALL_WAYS.items():
            if "massless" in name or name in ("tolerance", "participation", "2 domains and a second reduction"):
                continue
            s = block_scene(folder.mesh(part), ["x_min", "kept"], 0, {"youngs_modulus": 100.0, "poissons_ratio": 0.25, "density": 1.0})
            s["components"]["block"]["reduction"].update(way)
            answers.append((f"{joint}, {name}", *tells(folder.reduce(s), "mechanism", "node id", "block '")))
    return answers


@row("Reduction", "Two blocks whose common nodes differ by the round-off of 7 digits: told")
def rounded_nodes(folder):
    body, rest = box((3, 3, 3), block="body"), box((3, 3, 3), origin=(1, 0, 0), block="rest")
    part = join(body, rest, merge=False)
    x = np.array(part.nodes) * 0.1234567 + [10.7, 0, 0]
    x[len(body.nodes):] += np.random.default_rng(1).uniform(-5e-7, 5e-7, (len(rest.nodes), 3))
    part = Part(x, part.cells, {"x_min": body.faces["x_min"], "x_max": part.faces["x_max"][-9:]})
    ran = folder.superelement(part, ["x_min", "x_max"], 12)
    figure, bound, held = tells(ran, "16 pairs of nodes", "apart", "join the nodes")
    return figure, bound, held and "2 parts that share no node" in ran.text
