# SPDX-License-Identifier: GPL-3.0-or-later
"""Small meshes made in code, and the .msh file (2.2, text) that holds them."""
import itertools

import numpy as np

FACES = {  # of a hex, outward: corners by the offsets of hex8's nodes
    "x_min": (0, 4, 7, 3), "x_max": (1, 2, 6, 5), "y_min": (0, 1, 5, 4),
    "y_max": (3, 7, 6, 2), "z_min": (0, 3, 2, 1), "z_max": (4, 5, 6, 7)}
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
GMSH = {"hex8": 5, "tet4": 4, "quad4": 3, "tri3": 2, "point": 15}
OFFSET = {corner: i for i, corner in enumerate(CORNERS)}


def kuhn_tets():
    """A hex as six tets about its diagonal 0-6; faces are cut along the diagonal from their lowest corner to their highest."""
    tets = []
    for order in itertools.permutations(range(3)):
        at, path = [0, 0, 0], [0]
        for axis in order:
            at[axis] = 1
            path.append(OFFSET[tuple(at)])
        even = order in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
        tets.append(path if even else [path[0], path[2], path[1], path[3]])
    return tets


class Part:
    """nodes (n x 3); cells: (kind, block, rows of node indices); faces: set -> list of node tuples; points: set -> node indices."""

    def __init__(self, nodes, cells, faces=None, points=None):
        self.nodes, self.cells = np.array(nodes, float), [(kind, block, np.array(rows, int)) for kind, block, rows in cells]
        self.faces, self.points = dict(faces or {}), dict(points or {})

    def nodes_of(self, name):
        return sorted({int(n) for face in self.faces[name] for n in face})

    def moved(self, by):
        return Part(self.nodes + np.array(by, float), self.cells, self.faces, self.points)

    def scaled(self, factor):
        return Part(self.nodes * factor, self.cells, self.faces, self.points)

    def write(self, path, sets=None):
        """`sets`: names of the face sets to write, all unless given. Numbers are written as they are, NaN included."""
        blocks = list(dict.fromkeys(block for _, block, _ in self.cells))
        faces = [name for name in self.faces if sets is None or name in sets]
        groups = [(3, name) for name in blocks] + [(2, name) for name in faces] + [(0, name) for name in self.points]
        tag = {group: i + 1 for i, group in enumerate(groups)}
        elements = []
        for name in self.points:
            elements += [("point", tag[0, name], (node,)) for node in self.points[name]]
        for name in faces:
            elements += [("quad4" if len(face) == 4 else "tri3", tag[2, name], face) for face in self.faces[name]]
        for kind, block, rows in self.cells:
            elements += [(kind, tag[3, block], row) for row in rows]
        lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(groups))]
        lines += [f'{dim} {i + 1} "{name}"' for i, (dim, name) in enumerate(groups)]
        lines += ["$EndPhysicalNames", "$Nodes", str(len(self.nodes))]
        lines += [f"{i + 1} {x[0]!r} {x[1]!r} {x[2]!r}" for i, x in enumerate(self.nodes.tolist())]
        lines += ["$EndNodes", "$Elements", str(len(elements))]
        lines += [f"{i + 1} {GMSH[kind]} 2 {t} {t} " + " ".join(str(int(n) + 1) for n in row) for i, (kind, t, row) in enumerate(elements)]
        path.write_text("\n".join(lines + ["$EndElements", ""]))


def box(n=(2, 2, 2), size=(1, 1, 1), origin=(0, 0, 0), block="block", kind="hex8", map=None):
    """n hexes (or six tets for each) along x, y, z, from `origin`; face sets x_min ... z_max."""
    n = np.array(n, int)
    axes = [np.linspace(0, size[d], n[d] + 1) + origin[d] for d in range(3)]
    nodes = np.array([(x, y, z) for z in axes[2] for y in axes[1] for x in axes[0]])
    number = lambda i, j, k: i + (n[0] + 1) * (j + (n[1] + 1) * k)
    cells, faces = [], {name: [] for name in FACES}
    for k, j, i in itertools.product(range(n[2]), range(n[1]), range(n[0])):
        corner = [number(i + a, j + b, k + c) for a, b, c in CORNERS]
        cells += [corner] if kind == "hex8" else [[corner[a] for a in tet] for tet in kuhn_tets()]
        at = {"x": (i, n[0]), "y": (j, n[1]), "z": (k, n[2])}
        for name, face in FACES.items():
            place, end = at[name[0]]
            if place != (0 if name.endswith("min") else end - 1):
                continue
            quad = [corner[a] for a in face]
            if kind == "hex8":
                faces[name].append(tuple(quad))
                continue
            low = min(range(4), key=lambda a: sum(CORNERS[face[a]]))  # the face's lowest corner: its diagonal starts there
            q = quad[low:] + quad[:low]
            faces[name] += [(q[0], q[1], q[2]), (q[0], q[2], q[3])]
    if map is not None:
        nodes = np.array([map(x) for x in nodes])
    return Part(nodes, [(kind, block, cells)], faces)


def join(*parts, merge=True):
    """One part of several; nodes at the same place are one (`merge`). Face and point sets of one name are put together."""
    known, nodes, cells, faces, points = {}, [], [], {}, {}
    for number, part in enumerate(parts):
        new = []
        for x in part.nodes:
            key = tuple(np.round(x, 9)) + (() if merge else (number,))
            if key not in known:
                known[key] = len(nodes)
                nodes.append(x)
            new.append(known[key])
        new = np.array(new)
        cells += [(kind, block, new[rows]) for kind, block, rows in part.cells]
        for name, list_of in part.faces.items():
            faces.setdefault(name, []).extend(tuple(new[list(face)]) for face in list_of)
        for name, list_of in part.points.items():
            points.setdefault(name, []).extend(new[list(list_of)])
    return Part(nodes, cells, faces, points)


def face_weights(part, names):
    """Per node of plane, straight-sided faces the area vector that it carries: n x 3."""
    weight = np.zeros((len(part.nodes), 3))
    for name in names:
        for face in part.faces[name]:
            x = part.nodes[list(face)]
            normal = 0.5 * np.cross(x[2] - x[0], x[3] - x[1]) if len(face) == 4 else 0.5 * np.cross(x[1] - x[0], x[2] - x[0])
            weight[list(face)] += normal / len(face)
    return weight
