# SPDX-License-Identifier: GPL-3.0-or-later
"""CalculiX's input files of the cases in peers.py, and its results. Keywords: Dhondt, CalculiX CrunchiX User's Manual, "Input deck format".
CalculiX has no default stiffness of contact: in motion it is 0.3 E over the length of an element, ten times as much gains energy in explicit steps."""
import functools
import pathlib
import re
import subprocess

import numpy as np

import t1

# Corners of the faces S1 .. of a brick and of a tetrahedron of second order, from 0
FACES = {8: ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)), 10: ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))}
FACES[4] = FACES[10]
MIRRORED = (4, 5, 6, 7, 0, 1, 2, 3)  # a mirrored hex is right-handed again when its top becomes its bottom
STEEL_M, STEEL_MM, STEEL_T1 = (2.1e11, 0.3, 7850.0), (2.1e5, 0.3, 7.85e-9), (5.17e12, 0.3, 7836.0)
OUTPUTS = 24  # points of time; an explicit step prints every increment for them


class Mesh:
    """nodes (n x 3); cells (n_e x 4, 8 or 10) of node numbers from 0; sides {name: (nodes, corners of the faces)}. Of gmsh's file, which gmsh rewrites."""

    def __init__(self, path):
        inp, rows, kinds = pathlib.Path(path).with_suffix(".inp"), {}, {}
        subprocess.run(["gmsh", "-v", "1", path, "-save", "-o", inp], check=True)
        for line in inp.read_text().splitlines():
            if line.startswith("*"):
                title = line.strip()
                rows[title] = []
            else:
                rows[title].append([word for word in line.split(",") if word.strip()])
        self.nodes = np.array(rows["*NODE"], dtype=float)[:, 1:]
        for title, of in rows.items():
            if title.startswith("*ELEMENT"):
                kinds.setdefault(title.split("=")[1][:3], []).append(np.array(of, dtype=int) - 1)
        self.cells = np.concatenate(kinds["C3D"])[:, 1:]
        plane = {row[0] + 1: row[1:] for of in kinds["CPS"] for row in of}
        self.sides, corners = {}, len(FACES[self.cells.shape[1]][0])
        for title, of in rows.items():
            faces = [plane[int(word)] for row in of for word in row if int(word) in plane] if title.startswith("*ELSET") else []
            if faces:
                self.sides[title.split("=")[-1]] = (np.unique(faces), np.array(faces)[:, :corners])

    def weights(self):
        """Share of each node in the mass: consistent for straight tetrahedra, equal for equal boxes."""
        weights = np.zeros(len(self.nodes))
        a, b, c, d = (self.nodes[self.cells[:, k]] for k in range(4))
        volume = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)
        of_a_node = {4: volume[:, None], 8: np.ones(8), 10: volume[:, None] * np.array([-1 / 20] * 4 + [1 / 5] * 6)}[self.cells.shape[1]]
        np.add.at(weights, self.cells, of_a_node)
        return weights / weights.sum()


class Deck:
    """Lines of an input file; the first node number of each body."""

    def __init__(self, steel):
        self.lines, self.first, self.pairs, self.n_nodes, self.n_cells = [], {}, [], 0, 0
        self.say("*MATERIAL, NAME=STEEL", "*ELASTIC", f"{steel[0]:g}, {steel[1]:g}", "*DENSITY", f"{steel[2]:g}")

    def say(self, *lines):
        self.lines += lines

    def body(self, name, nodes, cells, sides, element, scale=(1, 1, 1), shift=(0, 0, 0), joined=None):
        """A mesh, scaled and then moved: sets Nname, Ename, Nname_side, surfaces name_side. joined: a body of the same mesh, and the side whose nodes both have."""
        number = np.arange(len(nodes)) + self.n_nodes + 1
        if joined:
            same = sides[joined[1]][0]
            number[same] = self.first[joined[0]] + same
        self.first[name] = self.n_nodes + 1
        self.say("*NODE", *(f"{n}, {x:.12e}, {y:.12e}, {z:.12e}" for n, (x, y, z) in zip(number, nodes * np.array(scale) + shift) if n > self.n_nodes))
        cells = number[cells[:, MIRRORED] if np.prod(scale) < 0 else cells]
        self.say(f"*ELEMENT, TYPE={element}, ELSET=E{name}", *(", ".join(map(str, [self.n_cells + 1 + c, *cell])) for c, cell in enumerate(cells)))
        self.say(f"*NSET, NSET=N{name}", *(f"{n}," for n in np.unique(cells)))
        faces = {frozenset(cell[list(face)]): f"{self.n_cells + 1 + c}, S{s + 1}" for c, cell in enumerate(cells) for s, face in enumerate(FACES[cells.shape[1]])}
        for side, (of_side, corners) in sides.items():
            self.say(f"*NSET, NSET=N{name}_{side}", *(f"{n}," for n in number[of_side]))
            self.say(f"*SURFACE, NAME={name}_{side}, TYPE=ELEMENT", *(faces[frozenset(number[of])] for of in corners))
        self.say(f"*SOLID SECTION, ELSET=E{name}, MATERIAL=STEEL")
        self.n_nodes, self.n_cells = self.n_nodes + len(nodes), self.n_cells + len(cells)

    def mesh(self, name, mesh, element, **place):
        self.body(name, mesh.nodes, mesh.cells, mesh.sides, element, **place)

    def contact(self, pairs, stiffness, friction=0.0, contact="SURFACE TO SURFACE"):
        self.say("*SURFACE INTERACTION, NAME=TOUCH")
        if contact != "MASSLESS":
            self.say("*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{stiffness:g}" + (f", {1e-6 * stiffness:g}" if contact.startswith("NODE") else ""))
        if friction:
            self.say("*FRICTION", f"{friction}, {stiffness / 10:g}")  # the slope of sticking that the manual advises
        self.pairs = pairs
        for slave, master in pairs:
            self.say(f"*CONTACT PAIR, INTERACTION=TOUCH, TYPE={contact}", f"{slave}, {master}")

    def motion(self, end, bodies, implicit, step, alpha):
        """One step that prints displacements and energies of the bodies and the forces of contact at times. A step for each
        output would shift bodies in contact at each start, by some half an increment of the speed (docs/benchmarks.md)."""
        self.say("*TIME POINTS, NAME=OUT, GENERATE", f"{end / OUTPUTS:.9g}, {end:.9g}, {end / OUTPUTS:.9g}")
        self.say("*STEP, INC=1000000", "*DYNAMIC" + (f", ALPHA={alpha:g}" if implicit else ", EXPLICIT") + (", DIRECT" if step else ""))
        self.say(f"{step or end / 200:g}, {end:.9g}")
        often = f"FREQUENCY={max(1, round(end / OUTPUTS / step)) if step else 1}" if implicit else "TIME POINTS=OUT"
        for name in bodies:
            self.say(f"*NODE PRINT, NSET=N{name}, {often}", "U", f"*EL PRINT, ELSET=E{name}, TOTALS=ONLY, {often}", "ELSE, ELKE")
        for slave, master in self.pairs:
            self.say(f"*CONTACT PRINT, SLAVE={slave}, MASTER={master}, {often}", "CF")
        self.say("*END STEP")

    def write(self, path):
        path.write_text("\n".join(self.lines) + "\n")


def write_impact(path, mesh, contact="SURFACE TO SURFACE", implicit=False, step=0.0, alpha=-0.05):
    """T1. step 0: CalculiX's own; alpha: damping of implicit steps, by default -0.05."""
    deck = Deck(STEEL_T1)
    deck.mesh("LEFT", mesh, "C3D8", shift=(-0.0279, 0, 0))
    deck.mesh("RIGHT", mesh, "C3D8", scale=(-1, 1, 1), shift=(0.0381, 0, 0))
    face = mesh.nodes[mesh.sides["contact"][1][0]]
    deck.contact([("LEFT_contact", "RIGHT_contact")], 0.3 * STEEL_T1[0] / np.ptp(face, axis=0).max(), contact=contact)
    deck.say("*INITIAL CONDITIONS, TYPE=VELOCITY", f"NLEFT, 1, {t1.SPEED}")
    deck.motion(t1.END, ("LEFT", "RIGHT"), implicit, step, alpha)
    deck.write(path)


def write_strike(path, mesh, side, velocity, height, end, friction=0.0, implicit=False, step=0.0, alpha=-0.05):
    """A part strikes with one side, along z, a fixed brick whose face is at `height`."""
    deck = Deck(STEEL_M)
    deck.mesh("PART", mesh, f"C3D{mesh.cells.shape[1]}")
    low, high = mesh.nodes.min(axis=0)[:2] - 0.03, mesh.nodes.max(axis=0)[:2] + 0.03
    # Its face is toward the part: below it, or above with the sign of the velocity
    brick = np.array([[x, y, z] for z in (0.05 * np.sign(velocity[2]), 0) for x, y in ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1]))])
    cell = np.arange(8)[list(MIRRORED) if velocity[2] > 0 else list(range(8))]
    deck.body("WALL", brick, cell[None], {"face": (np.arange(4, 8), np.arange(4, 8)[None])}, "C3D8", shift=(0, 0, height))
    edge = np.ptp(mesh.nodes[mesh.sides[side][1]], axis=1).max(axis=1).mean()
    deck.contact([(f"PART_{side}", "WALL_face")], 0.3 * STEEL_M[0] / edge, friction)
    deck.say("*BOUNDARY", "NWALL, 1, 3", "*INITIAL CONDITIONS, TYPE=VELOCITY", *(f"NPART, {axis + 1}, {v}" for axis, v in enumerate(velocity) if v))
    deck.motion(end, ("PART",), implicit, step, alpha)
    deck.write(path)


def write_joint(path, folder, stiffness=1e7, springs=0.0, contact="SURFACE TO SURFACE"):
    """The bolted lap joint: pretension, its length locked, 100 N, and two cycles of 600 N; `springs` N/mm hold what friction alone would hold."""
    meshes = {name: Mesh(folder / f"{name}.msh") for name in ("plate", "washer", "bolt")}
    deck = Deck(STEEL_MM)
    for name, mesh, scale, joined in (("UPPER", "plate", (1, 1, 1), None), ("LOWER", "plate", (-1, 1, -1), None), ("WASHER", "washer", (1, 1, 1), None),
                                      ("WASHER2", "washer", (1, 1, -1), None), ("HEAD", "bolt", (1, 1, 1), None), ("NUT", "bolt", (1, 1, -1), ("HEAD", "cut"))):
        deck.mesh(name, meshes[mesh], "C3D8I", scale=scale, joined=joined)
        if springs and name not in ("LOWER", "NUT"):
            held = deck.first[name] + np.linspace(0, len(meshes[mesh].nodes) - 1, 4).astype(int)
            for dof in (1, 2, 3):
                deck.say(f"*ELEMENT, TYPE=SPRING1, ELSET=SPRING{dof}", *(f"{deck.n_cells + 1 + k}, {node}" for k, node in enumerate(held)))
                deck.n_cells += len(held)
    for dof in (1, 2, 3) if springs else ():
        deck.say(f"*SPRING, ELSET=SPRING{dof}", str(dof), f"{springs:.6f}")
    bolt = deck.n_nodes + 1
    deck.say("*NODE, NSET=BOLT", f"{bolt}, 0., 0., 0.", f"*PRE-TENSION SECTION, SURFACE=HEAD_cut, NODE={bolt}", "0., 0., -1.")
    deck.contact([("UPPER_inside", "LOWER_inside"), ("WASHER_below", "UPPER_outside"), ("WASHER2_below", "LOWER_outside"), ("HEAD_seat", "WASHER_above"),
                  ("NUT_seat", "WASHER2_above")], stiffness, 0.2, contact)
    plate, share = meshes["plate"], {}
    for face in plate.sides["end"][1]:
        a, b, c, d = plate.nodes[face]
        for node in face + deck.first["UPPER"]:
            share[node] = share.get(node, 0) + np.linalg.norm(np.cross(c - a, d - b)) / 8
    whole = sum(share.values())
    deck.say("*BOUNDARY", "NLOWER_end, 1, 3")
    for k, force in enumerate((0, 100, 600, -600, 600, -600, 600)):
        deck.say("*STEP, INC=1000", "*STATIC", "0.5, 1.", *(["*BOUNDARY, FIXED", f"{bolt}, 1, 1"] if k == 1 else []), "*CLOAD, OP=NEW")
        deck.say(*([f"{node}, 1, {-force * of / whole:.9g}" for node, of in share.items()] if k else [f"{bolt}, 1, 5000."]))
        deck.say("*NODE PRINT, NSET=NUPPER_end, FREQUENCY=1000", "U", "*NODE PRINT, NSET=BOLT, FREQUENCY=1000", "RF", "*END STEP")
    deck.write(path)


def write_matrices(path, mesh, steel, kept=None):
    """K and M of all dofs; with the side `kept` its stiffness alone."""
    deck = Deck(steel)
    deck.mesh("PART", mesh, f"C3D{mesh.cells.shape[1]}")
    deck.say("*STEP", *(["*FREQUENCY, SOLVER=MATRIXSTORAGE", "1"] if kept is None else
                        ["*SUBSTRUCTURE GENERATE", "*RETAINED NODAL DOFS, SORTED=NO", f"NPART_{kept}, 1, 3", f"*SUBSTRUCTURE MATRIX OUTPUT, FILE NAME={path.stem}, STIFFNESS=YES"]), "*END STEP")
    deck.write(path)


@functools.lru_cache(maxsize=1)
def blocks(stem):
    """(quantity, set, time, rows of node and components) of each table that was printed; a total has one number, the force of a contact six."""
    parts = re.split(r"^ *([a-z][a-z ]*?)(?: \([^\n]*\))? for (?:slave )?set (\S+?)(?:, master set \S+)? and time +(\S+)\n", pathlib.Path(f"{stem}.dat").read_text(), flags=re.M)
    found = []
    for kind, name, t, rows in zip(parts[1::4], parts[2::4], parts[3::4], parts[4::4]):
        values = np.fromstring(rows.split("(mx,my,mz)")[1].strip().split("\n")[0] if kind == "statistics" else rows, sep=" ")
        found.append((kind, name, float(t), values if kind == "statistics" or kind.startswith("total") else values.reshape(-1, 4)))
    return found


def command(stem):
    return ["ccx", "-i", stem.name]


def reached(stem):
    """Time of the last increment or table; None before the first."""
    rows = [line.split() for line in pathlib.Path(f"{stem}.sta").read_text().splitlines()[2:]]
    times = [float(row[4]) for row in rows if len(row) > 4 and not row[2].endswith("U")] + [t for _, _, t, _ in blocks(stem)]
    return max(times, default=None)


def path(stem, name, weights):
    """t (n) and displacement (n x 3) of a body, the mean of its nodes with these weights."""
    found = [(t, np.average(rows[:, 1:], axis=0, weights=weights)) for kind, of, t, rows in blocks(stem) if kind == "displacements" and of == f"N{name}"]
    return np.array([0.0] + [t for t, _ in found]), np.array([np.zeros(3)] + [u for _, u in found])


def history(stem, axis):
    """t, force of the contact along an axis, energy of all bodies (n)."""
    force, energy = {}, {}
    for kind, _, t, values in blocks(stem):
        if kind == "statistics":
            force[t] = force.get(t, 0) + values[axis]
        elif kind.startswith("total"):
            energy[t] = energy.get(t, 0) + values[0]
    t = np.array(sorted(energy))
    return t, np.array([force.get(at, 0) for at in t]), np.array([energy[at] for at in t])


def joint_figures(stem):
    """Travel of the end in the second cycle, mm; the bolt's force at the end, N, by the share of the reaction to 5000 N, which has a factor."""
    ends = [rows[:, 1].mean() for kind, name, _, rows in blocks(stem) if name == "NUPPER_END"]
    bolt = [rows[0, 1] for kind, name, _, rows in blocks(stem) if name == "BOLT"]
    return np.ptp(ends[-3:]), 5000 * bolt[-1] / bolt[0]


def triangle(path, n):
    """The symmetric n x n matrix whose lower triangle a substructure's file has."""
    words = re.split(r"\*MATRIX[^\n]*\n", pathlib.Path(path).read_text(), flags=re.I)[1]
    K, rows = np.zeros((n, n)), np.tril_indices(n)
    K[rows] = np.fromstring(words.replace(",", " "), sep=" ")[:len(rows[0])]
    return K + K.T - np.diag(K.diagonal())
