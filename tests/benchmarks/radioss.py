# SPDX-License-Identifier: GPL-3.0-or-later
"""OpenRadioss's input files of the cases in peers.py, in its block format, and its time histories. Keywords: Altair Radioss Reference Guide.
A field of 0 is the program's default."""
import functools
import re

import numpy as np

import calculix
import t1

ELEMENTS = {4: "TETRA4", 8: "BRICK", 10: "TETRA10"}
MOTION = ("DX", "DY", "DZ", "VX", "VY", "VZ")
# Small strains from the start, no bulk viscosity, the step of the nodes, sums in any order
EXPERT = {"small": 1, "viscosity": 1e-20, "engine": ["/DT/NODA", "0.9 0.", "/PARITH/OFF"]}
# Hexahedra of one point with physical hourglass stiffness (HEPH); contact three times as stiff, which needs shorter steps
EXPERT_IMPACT = {**EXPERT, "hexes": 24, "stiffness": 3.0, "engine": ["/DT", "0.5 0.", "/PARITH/OFF"]}


def card(*words):
    """A line of fields: whole numbers have ten columns, others twenty."""
    return "".join(f"{word:>10}" if isinstance(word, (int, np.integer)) else f"{word:>20.13g}" for word in words)


class Deck:
    """The starter's lines. Parts, surfaces and groups of nodes are numbered from 1; a group of nodes has the number of its surface."""

    def __init__(self, steel, hexes=0, tets=0, small=0, viscosity=0.0, engine=()):
        self.lines, self.parts, self.sides, self.n_nodes, self.n_cells, self.engine = [], 0, 0, 0, 0, engine
        self.say("/MAT/ELAST/1", "steel", card(steel[2]), card(*steel[:2]), "/PROP/SOLID/1", "solid", card(hexes, small, 0, 0, tets), card(viscosity, viscosity), card(0.0), card(0, 0, 0))

    def say(self, *lines):
        self.lines += lines

    def body(self, name, mesh, side, velocity, scale=(1, 1, 1), shift=(0, 0, 0)):
        """A mesh, scaled and then moved, with the velocity as a part; the number of its side."""
        mirrored, self.parts, self.sides = np.prod(scale) < 0, self.parts + 1, self.sides + 1
        number, part = np.arange(len(mesh.nodes)) + self.n_nodes + 1, self.parts
        cells = number[mesh.cells[:, calculix.MIRRORED] if mirrored else mesh.cells]
        self.say("/NODE", *(card(n, *x) for n, x in zip(number, mesh.nodes * np.array(scale) + shift)), f"/{ELEMENTS[cells.shape[1]]}/{part}")
        for n, cell in enumerate(cells, self.n_cells + 1):
            self.say(*([card(n), card(*cell)] if len(cell) == 10 else [card(n, *cell)]))
        self.say(f"/PART/{part}", name, card(1, 1), f"/GRNOD/PART/{100 + part}", name, card(part), f"/INIVEL/TRA/{part}", name, card(*map(float, velocity), 100 + part), card(0.0))
        of_side, corners = mesh.sides[side]
        self.say(f"/GRNOD/NODE/{part}", side, *(card(*some) for some in np.split(number[of_side], range(10, len(of_side), 10))))
        self.say(f"/SURF/SEG/{part}", side, *(card(n, *face) for n, face in enumerate(number[corners[:, ::-1] if mirrored else corners], 1)))
        self.say(f"/TH/NODE/{part}", name, "".join(f"{word:<10}" for word in MOTION), *(card(n, 0) for n in number))
        self.n_nodes, self.n_cells = self.n_nodes + len(number), self.n_cells + len(cells)

    def write(self, stem, end):
        unit = f"{'kg':>20}{'m':>20}{'s':>20}"
        last = ["/TH/PART/1", "parts", f"{'IE':<10}{'KE':<10}", card(*range(1, self.parts + 1)), "/END"]
        (stem.parent / f"{stem.name}_0000.rad").write_text("\n".join(["#RADIOSS STARTER", "/BEGIN", stem.name, card(2026, 0), unit, unit, *self.lines, *last, ""]))
        (stem.parent / f"{stem.name}_0001.rad").write_text("\n".join([f"/RUN/{stem.name}/1", f"{end:.9g}", "/TFILE/4", f"{end / calculix.OUTPUTS:.9g}", *self.engine, ""]))


def write_impact(stem, mesh, interface=24, stiffness=0.0, **options):
    """T1. stiffness: of the contact, times the program's own."""
    deck = Deck(calculix.STEEL_T1, **options)
    deck.body("left", mesh, "contact", (t1.SPEED, 0, 0), shift=(-0.0279, 0, 0))
    deck.body("right", mesh, "contact", (0, 0, 0), scale=(-1, 1, 1), shift=(0.0381, 0, 0))
    deck.say(f"/INTER/TYPE{interface}/1", "contact", card(1, 2, 0), card(0), card(0), card(stiffness), card(0), card(0))
    deck.write(stem, t1.END)


def write_strike(stem, mesh, side, velocity, height, end, friction=0.0, **options):
    """A part strikes with one side, along z, a rigid wall at `height`."""
    deck = Deck(calculix.STEEL_M, **options)
    deck.body("part", mesh, side, velocity)
    deck.say("/RWALL/PLANE/1", "wall", card(0, 2 if friction else 0, 1), card(0.0, friction), card(0.0, 0.0, height), card(0.0, 0.0, height - np.sign(velocity[2])))
    deck.write(stem, end)


def command(stem):
    """Both programs, one after the other."""
    return ["sh", "-c", f"starter_linux64_gf -i {stem.name}_0000.rad -np 1 -nt 1 && engine_linux64_gf -i {stem.name}_0001.rad -nt 1"]


def steps(stem):
    """Seconds of the engine's cycles."""
    return float(re.search(r"TOTAL\.+: *(\S+)", (stem.parent / f"{stem.name}_0001.out").read_text())[1])


@functools.lru_cache(maxsize=1)
def history(stem):
    """t (n), energy of each part (n x parts), displacement and velocity of each part's nodes (n x nodes x 6). The momenta and centres of
    mass that the program itself has of parts differ from those of the nodes by up to a tenth of the momentum at impact, so they are not read."""
    data, at, records = (stem.parent / f"{stem.name}T01").read_bytes(), 0, []
    while at < len(data):
        size = int.from_bytes(data[at:at + 4], "big")
        records.append(np.frombuffer(data, ">f4", size // 4, at + 4))
        at += size + 8
    # A time, its totals, its parts and a record for each group of nodes, again and again to the end of the file
    starts = [k for k, record in enumerate(records) if len(record) == 1]
    period = len(records) - starts[-1]
    kinds = list(zip(*(records[k:k + period] for k in starts if [len(r) for r in records[k:k + period]] == [len(r) for r in records[-period:]])))
    t, _, parts, *nodes = (np.array(kind, dtype=float) for kind in kinds)
    return t[:, 0], parts.reshape(len(t), -1, 2).sum(axis=2), [of.reshape(len(t), -1, len(MOTION)) for of in nodes]


def reached(stem):
    """Time of the last output; None before the first."""
    return history(stem)[0][-1] if (stem.parent / f"{stem.name}T01").exists() else None
