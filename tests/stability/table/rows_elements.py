# SPDX-License-Identifier: GPL-3.0-or-later
"""Elements and meshes: bad shapes, bad contrasts, bad numbers."""
import numpy as np

from parts import Part, box, face_weights, join
from runs import STEEL, block_scene
from table import below, holds, refused, row

CHAPTER = "Elements and meshes"
SIDES = ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"]


def compliance(E, nu):
    """Strain of a stress, both in the order xx yy zz xy yz zx; shears as tensor components."""
    S = np.diag([1 / E] * 3 + [(1 + nu) / E] * 3)
    S[:3, :3] = (np.eye(3) * (1 + nu) - nu) / E
    return S


def tensor(v):
    return np.array([[v[0], v[3], v[5]], [v[3], v[1], v[4]], [v[5], v[4], v[2]]])


def patch_error(made, part, material, names=SIDES):
    """Worst over the six uniform stresses of |K_cc u - f| / |f|: u linear on the interface, f what the stress puts on the faces."""
    ids, x = made["nodes/id"], made["nodes/coordinates"]
    weight = face_weights(part, names)[ids - 1]
    S, worst = compliance(material["youngs_modulus"], material["poissons_ratio"]), 0
    for stress in np.eye(6):
        u, f = x @ tensor(S @ stress), weight @ tensor(stress)
        worst = max(worst, np.abs(made["matrices/K_cc"] @ u.ravel() - f.ravel()).max() / np.abs(f).max())
    return worst


def patch(folder, part, nu=0.25, **component):
    material = dict(STEEL, poissons_ratio=nu)
    return patch_error(folder.superelement(part, SIDES, 2, material, **component).done(), part, material)


def warped(x):
    return x + 0.05 * np.array([np.sin(3 * x[1] + x[2]), np.sin(2 * x[2] + x[0]), np.cos(3 * x[0] + 2 * x[1])])


def each_kind(folder, part, bound, **options):
    """`part`: kind -> Part."""
    formulations = [("hex8", "hex8"), ("hex8", "hex8-incompatible"), ("hex8", "hex8-hourglass"), ("tet4", None)]
    return [(element or kind, *below(patch(folder, part(kind), **options, **({"element": element} if element else {})), bound))
            for kind, element in formulations]


@row(CHAPTER, "Poisson's ratio 0.0: uniform stress on a block, error of the forces")
def poisson_zero(folder):
    return each_kind(folder, lambda kind: box((3, 3, 3), kind=kind), 3e-14, nu=0.0)


@row(CHAPTER, "Poisson's ratio 0.4999: uniform stress on a block, error of the forces")
def poisson_high(folder):
    return each_kind(folder, lambda kind: box((3, 3, 3), kind=kind), 5e-11, nu=0.4999)


@row(CHAPTER, "Poisson's ratio -0.99: uniform stress on a block, error of the forces")
def poisson_low(folder):
    return each_kind(folder, lambda kind: box((3, 3, 3), kind=kind), 3e-12, nu=-0.99)


@row(CHAPTER, "A known weakness, not a proof of soundness: a bar of one hex in 12 in bending, tip deflection over a beam's, as Poisson's ratio nears 0.5; "
              "hex8-incompatible does better than hex8, a ratio of 0.3 or finer hexes do better than 0.4999")
def bending(folder):
    def ratio(element, nu, n=(12, 1, 1)):
        made = folder.superelement(box(n, (12, 1, 1)), ["x_min", "x_max"], 0, dict(STEEL, poissons_ratio=nu), element=element).done()
        x, K = made["nodes/coordinates"], made["matrices/K_cc"]
        end = x[:, 0] > 6
        f = np.zeros((len(x), 3))
        f[end, 2] = 1 / end.sum()
        free = np.repeat(end, 3)
        u = np.linalg.solve(K[np.ix_(free, free)], f.ravel()[free]).reshape(-1, 3)
        return u[:, 2].mean() / (12**3 / (3 * 100 / 12) + 12 * 1.2 / (100 / (2 * (1 + nu))))
    good, fine = ratio("hex8-incompatible", 0.4999), ratio("hex8-incompatible", 0.4999, (24, 2, 2))
    usual, locked = ratio("hex8-incompatible", 0.3), ratio("hex8", 0.4999)
    limp, soft = ratio("hex8-hourglass", 0.3), ratio("hex8-hourglass", 0.4999)
    return [("hex8-incompatible, 0.3", *holds(f"{usual:.3f}", "0.98 to 1.02", abs(usual - 1) < 0.02)),
            ("hex8-incompatible, 0.4999", *holds(f"{good:.3f}, with hexes of half the size {fine:.3f}", "0.75 to 1, the second nearer to 1", 0.75 < good < fine < 1)),
            ("hex8, 0.4999", *holds(f"{locked:.2g}: locks", "above 0, below hex8-incompatible's", 0 < locked < good)),
            ("hex8-hourglass, 0.4999", *holds(f"{soft:.3f}, at 0.3 {limp:.3f}", "too soft by the same share at both, within 1 %", abs(soft / limp - 1) < 0.01))]


@row(CHAPTER, "Aspect ratio 1e4 (flat): uniform stress, error of the forces")
def flat(folder):
    return each_kind(folder, lambda kind: box((3, 3, 3), (1, 1, 1e-4), kind=kind), 1e-6)


@row(CHAPTER, "Aspect ratio 1e4 (long): uniform stress, error of the forces")
def long(folder):
    return each_kind(folder, lambda kind: box((3, 3, 3), (1, 1, 1e4), kind=kind), 1e-7)


@row(CHAPTER, "Tets with angles of 1 degree between faces: uniform stress, error of the forces")
def slivers(folder):
    return below(patch(folder, box((3, 3, 3), (1, 1, np.tan(np.radians(1))), kind="tet4")), 3e-11)


@row(CHAPTER, "Sizes 1 : 1e6 of neighbouring elements: uniform stress, error of the forces")
def graded(folder):
    grow = lambda x: x if x[0] < 0.5 else np.array([0.5 + (x[0] - 0.5) * 1e-6, x[1], x[2]])
    return each_kind(folder, lambda kind: box((4, 2, 2), kind=kind, map=grow), 3e-8)


def contrast(folder, ratio, density_ratio=1.0, clamp=("x_min",), modes=1, **more):
    """Two half bars of different material, held at one end."""
    part = join(box((4, 1, 1), block="soft"), box((4, 1, 1), origin=(1, 0, 0), block="stiff"))
    part.faces["joint"] = part.faces["x_min"][1:]
    part.faces["x_min"], part.faces["x_max"] = part.faces["x_min"][:1], part.faces["x_max"][1:]
    scene = {"materials": {"soft": {"youngs_modulus": 100.0, "poissons_ratio": 0.0, "density": 1.0},
                           "stiff": {"youngs_modulus": 100.0 * ratio, "poissons_ratio": 0.0, "density": density_ratio}},
             "components": {"block": {"mesh": folder.mesh(part, sets=["x_min", "x_max"]), "reduction": {"interface": list(clamp), "modes": modes, **more},
                                      "blocks": {"soft": {"material": "soft"}, "stiff": {"material": "stiff"}}}},
             "instances": {"a": {"component": "block"}}}
    return folder.reduce(scene)


def stretching(made):
    """Stiffness between the two ends: pull per unit of relative displacement along x."""
    x, K = made["nodes/coordinates"], made["matrices/K_cc"]
    u = np.zeros((len(x), 3))
    u[:, 0] = x[:, 0] > 1
    return (K @ u.ravel()).reshape(-1, 3)[x[:, 0] > 1, 0].sum()


@row(CHAPTER, "Stiffness ratio 1e12 in one component: two bars in series, error of the stiffness")
def stiffness_ratio(folder):
    made = contrast(folder, 1e12, clamp=("x_min", "x_max"), modes=0).done()
    return below(abs(stretching(made) / (100 / (1 + 1e-12)) - 1), 1e-2)


@row(CHAPTER, "Density ratio 1e9 in one component: a heavy bar on a light one, error of the lowest frequency")
def density_ratio(folder):
    # Sideways it is softer: the first mode is a cantilever's that carries a rigid bar, so pull it out by the clamp's symmetric shape
    made = contrast(folder, 1e6, 1e9, modes=8).done()
    omega = np.sqrt(made["matrices/eigenvalues"])
    expected = np.sqrt(100 / 1e9)
    return below(np.abs(omega / expected - 1).min(), 1e-5)


def broken(folder, change, *words, kind="hex8"):
    part = box((2, 2, 2), kind=kind)
    change(part)
    scene = block_scene(folder.mesh(part, sets=["x_min"]), ["x_min"])
    scene["time"] = {"end": 0.1}
    as_mesh = {**scene, "instances": {"a": {"component": "block", "as": "mesh"}}}
    return [("superelement", *refused(folder.reduce(scene), *words)), ("full mesh", *refused(folder.dyn(as_mesh, reduce=False), *words))]


@row(CHAPTER, "An inverted hex")
def inverted_hex(folder):
    def turn(part):
        rows = part.cells[0][2]
        rows[5] = rows[5][[4, 5, 6, 7, 0, 1, 2, 3]]
    return broken(folder, turn, "block 'block'", "(hex8) is inverted")


@row(CHAPTER, "An inverted tet")
def inverted_tet(folder):
    def turn(part):
        rows = part.cells[0][2]
        rows[17] = rows[17][[0, 2, 1, 3]]
    return broken(folder, turn, "(tet4) is inverted", kind="tet4")


@row(CHAPTER, "A hex with one node moved through the opposite face")
def folded(folder):
    def move(part):
        part.nodes[13] += [3, 3, 3]
    return broken(folder, move, "is inverted")


@row(CHAPTER, "An element with a node twice")
def repeated(folder):
    def twice(part):
        part.cells[0][2][3][2] = part.cells[0][2][3][1]
    return broken(folder, twice, "has node", "twice")


@row(CHAPTER, "A flat element: two nodes at one place")
def flat_tet(folder):
    def flatten(part):
        rows = part.cells[0][2]
        a, b = rows[7][0], rows[7][1]
        part.nodes[a] = part.nodes[b]
    return broken(folder, flatten, "is degenerate", kind="tet4")


@row(CHAPTER, "The same element twice")
def doubled(folder):
    def double(part):
        kind, block, rows = part.cells[0]
        part.cells[0] = (kind, block, np.vstack([rows, rows[2:3]]))
    return broken(folder, double, "element", "same nodes")


@row(CHAPTER, "A node that no element uses: left alone")
def unused(folder):
    part = box()
    with_node = Part(np.vstack([part.nodes, [[9, 9, 9]]]), part.cells, part.faces)
    one, two = (folder.superelement(p, ["x_min"], 4).done()["matrices/K_cc"] for p in (part, with_node))
    return below(np.abs(one - two).max() / np.abs(one).max(), 0)


@row(CHAPTER, "A node that no element uses, in the interface")
def unused_in_interface(folder):
    part = box()
    with_node = Part(np.vstack([part.nodes, [[9, 9, 9]]]), part.cells, part.faces, {"tip": [len(part.nodes)]})
    return refused(folder.superelement(with_node, ["x_min", "tip"], 4), "tip", "node id 28", "no volume element")


@row(CHAPTER, "A coordinate that is not a number, or infinite")
def not_finite(folder):
    answers = []
    for value in (np.nan, np.inf):
        part = box()
        part.nodes[4, 1] = value
        answers.append((str(value), *refused(folder.superelement(part, ["x_min"], 4), "mesh.msh", "5")))
    return answers
