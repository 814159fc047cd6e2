# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run knows about its own accuracy: figures of --verbose, and warnings that say where and what to do."""
import re

from parts import box
from rows_elements import contrast
from rows_reduction import linked, with_points
from table import holds, refused, row

CHAPTER = "Conditioning"
FIGURES = {"K_II": r"condition of K_II: (\S+), scaled by its diagonal (\S+); weakest pivot (\S+) at node id \d+ of block 'block'",
           "reduced mass": r"condition of the reduced mass: (\S+), scaled by its diagonal (\S+)",
           "modes": r"modes: Phi\^T M Phi - I (\S+), residual (\S+);", "inertia": r"inertia counts (\d+) below (\S+) Hz, (\d+) found",
           "rigid motions": r"rigid motions: forces of K (\S+), of the reduced K (\S+)",
           "frequencies": r"reduced frequencies: (\d+) are 0, lowest other (\S+) Hz, highest (\S+) Hz", "rho_res": r"rho_res +x (\S+) +y (\S+) +z (\S+):"}


@row(CHAPTER, "A sound component: figures of --verbose, and no warning")
def sound(folder):
    ran = folder.superelement(box((6, 6, 8), (1, 1, 1.3)), ["z_min"], 24, options=["--verbose"]).done()
    answers = []
    for name, pattern in FIGURES.items():
        found = re.search(pattern, ran.text)
        answers.append((name, *holds(" ".join(found.groups()).rstrip(":") if found else "missing", "there", found)))
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
    return tells(folder.superelement(part, ["tip"]), "reduced mass", "interface")


@row(CHAPTER, "A hinge among the kept nodes")
def hinge(folder):
    part = with_points(linked(lambda x: x[2] == 0), kept=list(range(45)))
    return tells(folder.superelement(part, ["x_min", "kept"], 0), "without stiffness", "node id", "block '")


@row(CHAPTER, "No mode kept: the mass left on the interface")
def residual_mass(folder):
    return tells(folder.superelement(box((4, 4, 4)), ["x_min"], 0), "rho_res", "modes")
