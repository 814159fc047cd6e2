# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run knows about its own accuracy: figures of --verbose, and warnings that say where and what to do."""
import re

import numpy as np
import scipy.linalg

from parts import box
from rows_elements import contrast
from rows_reduction import linked, reduced_matrices, with_points
from runs import block_scene, changed
from table import holds, refused, row

CHAPTER = "Conditioning"
FIGURES = {"K_II": r"condition of K_II: (\S+), scaled by its diagonal (\S+); weakest pivot (\S+) at node id \d+ of block 'block'",
           "reduced mass": r"condition of the reduced mass: (\S+), scaled by its diagonal (\S+)",
           "modes": r"modes: Phi\^T M Phi - I (\S+), residual (\S+);", "inertia": r"inertia counts (\d+) below (\S+) Hz, (\d+) found",
           "rigid motions": r"rigid motions: forces of K (\S+), of the reduced K (\S+)",
           "frequencies": r"reduced frequencies: (\d+) are 0, lowest other (\S+) Hz, highest (\S+) Hz", "rho_res": r"rho_res +x (\S+) +y (\S+) +z (\S+):"}


def scaled(A):
    D = 1 / np.sqrt(np.diag(A))
    return A * np.outer(D, D)


def rigid_motions(x):
    R = np.zeros((x.size, 6))
    for d, axis in enumerate(np.eye(3)):
        R[d::3, d] = 1
        R[:, 3 + d] = np.cross(axis, x - x.mean(axis=0)).ravel()
    return R


def dense_figures(whole, made):
    """What numpy makes of the figures: name -> values in the order of FIGURES. `whole`: the component with every node kept, so K and M themselves."""
    K, M, all_ids = whole["matrices/K_cc"], whole["matrices/M_cc"], whole["nodes/id"]
    inner = (3 * np.searchsorted(all_ids, made["recovery/nodes/id"])[:, None] + np.arange(3)).ravel()
    K_II, M_II = K[np.ix_(inner, inner)], M[np.ix_(inner, inner)]
    hz = np.sqrt(scipy.linalg.eigh(K_II, M_II, eigvals_only=True)) / (2 * np.pi)
    Phi, eigenvalues = made["recovery/Phi"], made["matrices/eigenvalues"]
    residual = K_II @ (Phi / eigenvalues) - M_II @ Phi
    K_r, M_r = reduced_matrices(made)
    reduced_hz = np.sqrt(scipy.linalg.eigh(K_r, M_r, eigvals_only=True)[6:]) / (2 * np.pi)
    M_res, M_cc, K_cc = made["matrices/M_cc"] - made["matrices/M_kc"].T @ made["matrices/M_kc"], made["matrices/M_cc"], made["matrices/K_cc"]
    shift, R, R_c = np.tile(np.eye(3), (len(M_cc) // 3, 1)), rigid_motions(whole["nodes/coordinates"]), rigid_motions(made["nodes/coordinates"])
    force = lambda K, R, size: (np.abs(K @ R) / size[:, None] / np.abs(R).max(axis=0)).max()
    sums, sums_c = np.abs(K).sum(axis=1), np.abs(K_cc).sum(axis=1)
    own = 1 / (np.diag(K_II) * np.diag(np.linalg.inv(K_II)))  # pivot of a dof that is eliminated last: none is smaller
    return {"K_II": (np.linalg.cond(K_II, 1), np.linalg.cond(scaled(K_II), 1), (own.min(), own.max())),
            "reduced mass": (np.linalg.cond(M_r, 1), np.linalg.cond(scaled(M_r), 1)),
            "modes": (np.abs(Phi.T @ M_II @ Phi - np.eye(len(eigenvalues))).max(), (np.linalg.norm(residual, axis=0) / np.linalg.norm(M_II @ Phi, axis=0)).max()),
            "inertia": hz, "rigid motions": (force(K, R, sums), force(K_cc, R_c, np.full(len(K_cc), sums_c.max()))),
            "frequencies": (6, reduced_hz[0], reduced_hz[-1]),
            "rho_res": tuple(np.diag(shift.T @ M_res @ shift) / np.diag(shift.T @ M_cc @ shift))}


def agrees(name, found, dense):
    """(what is asked, whether): estimates are lower bounds, mostly within a factor of 2, printed to two digits; round-off is of one size, no more."""
    near = lambda low, high: all(low <= v / d <= high for v, d in zip(found, dense))
    if name == "K_II":
        low, high = dense[2]
        return "0.5 to 1.05 of it; between the two", all(0.5 <= v / d <= 1.05 for v, d in zip(found[:2], dense)) and 0.95 * low <= found[2] <= 1.05 * high
    if name == "reduced mass":
        return "0.5 to 1.05 of it", near(0.5, 1.05)
    if name in ("modes", "rigid motions"):
        return "0.05 to 20 times it", near(0.05, 20)
    if name == "inertia":
        return "the count below", found[0] == found[2] == (dense < found[1]).sum()
    digits = 1e-3 if name == "rho_res" else 1e-5  # as many as are printed
    return f"to {digits:g}", near(1 - digits, 1 + digits)


@row(CHAPTER, "A sound component: figures of --verbose against numpy's of dense matrices, and no warning")
def sound(folder):
    part = box((5, 5, 7), (1, 1, 1.3))
    whole = folder.superelement(with_points(part, all=range(len(part.nodes))), ["all"], 0, options=["--diagonal-limit", 0]).done()
    whole = {name: whole[name] for name in ("matrices/K_cc", "matrices/M_cc", "nodes/id", "nodes/coordinates")}  # its file is written anew
    scene = block_scene(folder.mesh(part), ["z_min"], 26)
    ran = folder.reduce(changed(scene, "components", "block", "reduction", "recovery", to=True), "--verbose").done()
    dense, answers = dense_figures(whole, ran), []
    for name, pattern in FIGURES.items():
        found = re.search(pattern, ran.text)
        if not found:
            answers.append((name, "missing", "there", False))
            continue
        values = [float(v.rstrip(":")) for v in found.groups()]
        asked, right = agrees(name, values, dense[name])
        mine = f"{(dense[name] < values[1]).sum()} below" if name == "inertia" else " ".join(
            f"{v[0]:.2g}...{v[1]:.2g}" if isinstance(v, tuple) else f"{v:.4g}" for v in dense[name])
        answers.append((name, *holds(" ".join(f"{v:.6g}" for v in values) + "; numpy " + mine, asked, right)))
    return answers + [("warnings", *holds("; ".join(ran.warnings()) or "none", "none", not ran.warnings()))]


def tells(ran, *words):
    """Ended well, with a warning that holds all the words."""
    found = [w for w in ran.done().warnings() if all(word in w for word in words)]
    return holds((found or ran.warnings() or ["no warning"])[0], "a warning that names " + ", ".join(words), found)


@row(CHAPTER, "Stiffness ratio 1e13 inside the interior")
def ratio(folder):
    return refused(contrast(folder, 1e13), "ill-conditioned", "node id", "block '")


@row(CHAPTER, "Poisson's ratio 0.49999999999")
def incompressible(folder):
    material = {"youngs_modulus": 100.0, "poissons_ratio": 0.49999999999, "density": 1.0}
    return tells(folder.superelement(box((4, 4, 4)), ["x_min"], 4, material), "ill-conditioned", "node id", "Poisson")


@row(CHAPTER, "Plates of aspect ratio 1e4 to 1e6: bending below the round-off of their own stiffness")
def plate(folder):
    answers = []
    for t in (1e-4, 1e-5, 1e-6):
        ran = folder.superelement(box((4, 4, 1), (1, 1, t)), ["x_min", "x_max"], 4)
        answers.append((f"{1 / t:g}", *(refused(ran, "node id", "thin") if ran.code else tells(ran, "digits"))))
    return answers


@row(CHAPTER, "Three interface nodes 1e-6 off one line")
def needle(folder):
    part = with_points(box((3, 3, 3)), tip=[0, 1, 3])
    part.nodes[1] += [0, 1e-6, 0]
    ran = folder.superelement(part, ["tip"])
    return refused(ran, "ill-conditioned", "interface nearly on one line", "node id") if ran.code else tells(ran, "reduced mass", "interface")


@row(CHAPTER, "A hinge among the kept nodes")
def hinge(folder):
    part = with_points(linked(lambda x: x[2] == 0), kept=list(range(45)))
    return tells(folder.superelement(part, ["x_min", "kept"], 0), "without stiffness", "node id", "block '")


@row(CHAPTER, "No mode kept: the mass left on the interface")
def residual_mass(folder):
    return tells(folder.superelement(box((4, 4, 4)), ["x_min"], 0), "rho_res", "modes")


@row(CHAPTER, "rho_res of one superelement, of domains together, of a second reduction: as cbr-reduce printed it, and cbr-dyn --verbose again")
def told_again(folder):
    answers, mesh = [], folder.mesh(box((4, 4, 6)))
    for name, more in {"one": {}, "2 domains": {"domains": 2}, "a second reduction": {"domains": 2, "second_reduction": {"modes": 6}}}.items():
        scene = block_scene(mesh, ["z_min"], 6)
        scene["components"]["block"]["reduction"].update(more)
        scene |= {"time": {"end": 0.1, "step": {"cfl": 0.5}}, "output": {"every": 0.1}}
        first, again = folder.reduce(scene).done(), folder.dyn(scene, "--verbose", reduce=False).done()
        found = [re.findall(r"rho_res +x (\S+) +y (\S+) +z ([0-9.]+)", ran.text) for ran in (first, again)]
        text = [" ".join(f[-1]) if f else "missing" for f in found]  # a second reduction stands after the first
        answers.append((name, *holds("; ".join(text), "the same", text[0] == text[1] != "missing")))
    return answers
