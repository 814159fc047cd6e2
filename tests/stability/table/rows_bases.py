# SPDX-License-Identifier: GPL-3.0-or-later
"""Massless interfaces, domains and second reductions on what is hard for the others too."""
import h5py
import numpy as np

from parts import box
from runs import block_scene
from rows_contact import EXACT_HITS, PAIR, impact, reduced_mass, scene
from rows_elements import SIDES, STEEL, compliance, contrast, face_weights, patch_error, stretching, tensor
from rows_input import impact_in
from rows_reduction import with_points
from rows_steps import drift, ringing
from table import below, holds, refused, row

CHAPTER = "Other bases, and domains"
WAYS = {"massless, free modes": {"basis": "massless"},
        "2 domains": {"domains": 2}, "2 domains and a second reduction": {"domains": 2, "second_reduction": {"modes": 6}}}


def each(run):
    return [(name, *run(way)) for name, way in WAYS.items()]


BLOCK = box((4, 2, 2))  # with enough inside to carry the faces' mass


def blocks(folder, way, instances, contact=PAIR, **more):
    return with_way(scene(folder, instances, contact, part=BLOCK, modes=16, **more), way)


UNLIKE = box((4, 2, 2), (1, 1.1, 1.25))  # no two frequencies alike, between which a number of modes could cut by round-off


def is_massless(way):
    return "basis" in way


def with_way(scene, way):
    scene["components"]["block"]["reduction"].update(way)
    return scene


def joined(made):
    """K_cc of a group's domains put together, with nodes/id and nodes/coordinates: what patch_error and stretching read."""
    with h5py.File(made.file) as f:
        if "domains" not in f:
            return {name: f[name][()] for name in ("nodes/id", "nodes/coordinates", "matrices/K_cc")}
        domains = [{name: d[name][()] for name in ("nodes/id", "nodes/coordinates", "matrices/K_cc", "dofs/node", "dofs/component")} for d in f["domains"].values()]
    ids, first = np.unique(np.concatenate([d["nodes/id"] for d in domains]), return_index=True)
    K = np.zeros((3 * len(ids), 3 * len(ids)))
    for d in domains:
        at = 3 * np.searchsorted(ids, d["nodes/id"])[d["dofs/node"]] + d["dofs/component"]
        K[np.ix_(at, at)] += d["matrices/K_cc"]
    return {"nodes/id": ids, "nodes/coordinates": np.vstack([d["nodes/coordinates"] for d in domains])[first], "matrices/K_cc": K}


def condensed(made, kept):
    """Without the nodes, shared by domains, that `kept` leaves out."""
    x, K = made["nodes/coordinates"], made["matrices/K_cc"]
    a, b = (np.flatnonzero(np.repeat(at, 3)) for at in (kept(x), ~kept(x)))
    K_aa = K[np.ix_(a, a)] - K[np.ix_(a, b)] @ np.linalg.solve(K[np.ix_(b, b)], K[np.ix_(b, a)])
    return {"nodes/coordinates": x[kept(x)], "matrices/K_cc": K_aa}


def response(made, f):
    """Of a massless interface to forces in balance, rigid motion left out; n x 3."""
    V, F, lam = made["massless/V"], made["massless/F"], made["matrices/eigenvalues"]
    elastic = lam > 1e-9 * lam.max()
    return (V[:, elastic] @ (V[:, elastic].T @ f.ravel() / lam[elastic]) + F @ f.ravel()).reshape(-1, 3)


def without_rigid(x, u):
    x = x - x.mean(axis=0)
    R = np.hstack([np.tile(np.eye(3), (len(x), 1)), np.vstack([np.cross(np.eye(3), p).T for p in x])])
    return u - (R @ np.linalg.lstsq(R, u.ravel(), rcond=None)[0]).reshape(-1, 3)


def displacement_error(made, part):
    """Worst over the six uniform stresses of the displacements' error, rigid motion left out."""
    x, weight, S = made["nodes/coordinates"], face_weights(part, SIDES)[made["nodes/id"] - 1], compliance(STEEL["youngs_modulus"], STEEL["poissons_ratio"])
    worst = 0
    for stress in np.eye(6):
        expected, found = without_rigid(x, x @ tensor(S @ stress)), without_rigid(x, response(made, weight @ tensor(stress)))
        worst = max(worst, np.abs(found - expected).max() / np.abs(expected).max())
    return worst


@row(CHAPTER, "Tets with angles of 1 degree between faces: uniform stress, error of the forces, or of the displacements where there are compliances")
def slivers(folder):
    part = box((4, 4, 4), (1, 1, np.tan(np.radians(1))), kind="tet4")

    def run(way):
        made = folder.reduce(with_way(block_scene(folder.mesh(part), SIDES, 6), way)).done()
        error = displacement_error(made, part) if is_massless(way) else patch_error(joined(made), part, STEEL)
        return below(error, 1e-10)
    return each(run)


@row(CHAPTER, "Stiffness ratio 1e6 and 1e12 in one component: two bars in series, error of the stiffness; of 1e12 a named error will do")
def stiffness_ratio(folder):
    answers = []
    for ratio, bound in ((1e6, 4e-9), (1e12, 1e-2)):
        for name, way in WAYS.items():
            ran = contrast(folder, ratio, clamp=("x_min", "x_max"), modes=16, **way)
            if ran.code != 0 and ratio > 1e6:
                answers.append((f"{name}, {ratio:g}", *refused(ran, "component 'block'")))
                continue
            made = ran.done()
            if is_massless(way):
                end = np.where(made["nodes/coordinates"][:, 0] > 1, 1.0, -1.0)
                u = response(made, np.outer(end / 4, [1, 0, 0]))[:, 0]
                stiffness = 1 / (u[end > 0].mean() - u[end < 0].mean())
            else:
                stiffness = stretching(condensed(joined(made), lambda x: x[:, 0] != 1))
            answers.append((f"{name}, {ratio:g}", *below(abs(stiffness / (100 / (1 + 1 / ratio)) - 1), bound)))
    return answers


@row(CHAPTER, "Three interface nodes 1e-6 off one line: a named error, after a warning if it is cbr-dyn's, or a fall with the momentum of its weight (error)")
def needle(folder):
    part = with_points(box((3, 3, 3)), tip=[0, 1, 3])
    part.nodes[1] += [0, 1e-6, 0]

    def run(way):
        s = with_way(scene(folder, {"a": {}}, part=part, interface=["tip"], loads=[{"gravity": [0.1, 0.2, -0.3]}]), way)
        made = folder.reduce(s)
        if made.code != 0:
            return refused(made, "component 'block'", "interface")
        told = [w for w in made.done().warnings() if "ill-conditioned" in w]
        ran = folder.dyn(s)
        if ran.code != 0:
            figure, bound, held = refused(ran, "component 'block'", code=ran.code)
            return f"warning: {(told or ['none'])[0]}; {figure}", f"a warning; {bound}", held and told
        weight = folder.reduce(s, "--force").done()["rigid_body/mass"] * np.array([0.1, 0.2, -0.3])
        p = ran.done()["instances/a/momentum"] - np.outer(ran["time"], weight)
        figure, bound, held = below(np.abs(p).max() / np.abs(weight).max(), 1e-9)
        return f"{figure}; {(told or ['no warning'])[0]}", bound, held
    return each(run)


@row(CHAPTER, "One million free steps (20 000 in the quick run): drift of the energy")
def many_steps(folder):
    answers, n, h = [], 1_000_000 if folder.full else 20_000, 0.01
    for name, way in {**WAYS, "massless, tapered modes": {"basis": "massless", "massless_modes": "tapered"},
                      "characteristic": {"basis": "characteristic", "characteristic": {"modes": 12}}}.items():
        for integrator in ("exact", "central-difference", "newmark"):
            every = h if integrator == "exact" else n * h / 100
            s = ringing(folder, "superelement", {"end": n * h, "step": h, "integrator": integrator}, {"every": every}, contact=False, part=BLOCK, modes=16)
            ran = folder.dyn(with_way(s, way))
            if integrator == "newmark" and way.get("basis") == "massless":
                answers.append((f"{name}, {integrator}", *refused(ran, "massless")))
                continue
            figure, bound, held = below(drift(ran.done()), 2e-12 if folder.full else 2e-13)
            steps = int(ran.attribute("steps"))
            answers.append((f"{name}, {integrator}", f"{figure} in {steps} steps", bound, held and steps >= n))
    return answers


def judged(ran, way, **more):
    """Without mass on the interface nothing is lost at the touch; what is left is the steps' own error, of either sign."""
    return impact(ran, gain=5e-3, lost=0.02, **more) if is_massless(way) else impact(ran, **more)


@row(CHAPTER, "Exact hits: edge on edge, corner on corner, a node on an edge; momentum, energy gained; impulse and loss over a plastic hit's")
def exact_hits(folder):
    answers = []
    for name, way in WAYS.items():
        for hit, y, z in EXACT_HITS:
            ran = folder.dyn(blocks(folder, way, {"a": {"velocity": [0.1, 0, 0]}, "b": {"position": [1.001, y, z]}})).done()
            answers.append((f"{hit}, {name}", *judged(ran, way, mass=reduced_mass(y / 2, z / 2))))
    return answers


@row(CHAPTER, "Symmetric faces, flat: the impact and its mirror image, and what goes sideways, over the momentum; energy gained; impulse and loss over a plastic hit's")
def symmetric(folder):
    def run(way):
        def go(a, b):
            return folder.dyn(blocks(folder, way, {"a": {"velocity": [a, 0, 0]}, "b": {"position": [1.001, 0, 0], "velocity": [b, 0, 0]}})).done()
        one, other = go(0.1, 0.0), go(0.0, -0.1)
        p, q = one["instances/b/momentum"], other["instances/a/momentum"]
        apart, sideways = np.abs(p[:, 0] + q[:, 0]).max() / 0.1, np.abs(p[:, 1:]).max() / 0.1
        figure, bound, held = judged(one, way)
        return f"{apart:.0e}, {sideways:.0e}; {figure}", f"1e-13, 1e-14; {bound}", held and apart < 1e-13 and sideways < 1e-14
    return each(run)


@row(CHAPTER, "The same impact in other units of length, mass and time: change of the momenta")
def units(folder):
    answers = []
    for name, way in WAYS.items():
        one = impact_in(folder, "superelement", part=UNLIKE, modes=16, way=way)
        for unit, factors in (("micrometres", (1e6, 1, 1)), ("gigagrams", (1, 1e-9, 1)), ("nanoseconds", (1, 1, 1e9)), ("mm t s", (1e3, 1e-3, 1))):
            other = impact_in(folder, "superelement", *factors, part=UNLIKE, modes=16, way=way)
            answers.append((f"{unit}, {name}", *below(np.abs(other - one).max() / np.abs(one).max(), 8e-14)))
    return answers
