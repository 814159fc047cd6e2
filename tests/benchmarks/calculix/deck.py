#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""CalculiX input deck of the paper's block impact from the block's .msh (gmsh 4.1, text, hexes, physical surface `contact`).

    deck.py block.msh impact.inp --method explicit|implicit --element C3D8|C3D8I|C3D8R --contact massless|node|face --step SECONDS
"""
import argparse
import pathlib

SPEED, OUTPUT, END = 3810.0, 1e-7, 1.2e-5
# Node numbers from 0 of CalculiX' faces S1 .. S6 of an 8-node brick; its node order is gmsh's.
FACES = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))
MIRRORED = (4, 5, 6, 7, 0, 1, 2, 3)  # a mirrored hex is right-handed again when its top becomes its bottom


def read_msh(path):
    """Nodes {tag: (x, y, z)}, hexes [8 tags], quads of the physical surface `contact` as sets of tags."""
    lines = iter(pathlib.Path(path).read_text().splitlines())
    contact_tag, surfaces, nodes, hexes, quads = None, set(), {}, [], []
    for line in lines:
        if line == "$PhysicalNames":
            for _ in range(int(next(lines))):
                dimension, tag, name = next(lines).split(maxsplit=2)
                if dimension == "2" and name == '"contact"':
                    contact_tag = int(tag)
        elif line == "$Entities":
            counts = [int(c) for c in next(lines).split()]
            for dimension, count in enumerate(counts):
                for _ in range(count):
                    words = next(lines).split()
                    at = 4 if dimension == 0 else 7
                    physical = [int(w) for w in words[at + 1:at + 1 + int(words[at])]]
                    if dimension == 2 and contact_tag in physical:
                        surfaces.add(int(words[0]))
        elif line == "$Nodes":
            for _ in range(int(next(lines).split()[0])):
                count = int(next(lines).split()[3])
                tags = [int(next(lines)) for _ in range(count)]
                for tag in tags:
                    nodes[tag] = tuple(float(w) for w in next(lines).split()[:3])
        elif line == "$Elements":
            for _ in range(int(next(lines).split()[0])):
                dimension, entity, kind, count = (int(w) for w in next(lines).split())
                for _ in range(count):
                    tags = [int(w) for w in next(lines).split()][1:]
                    if kind == 5:
                        hexes.append(tags)
                    elif dimension == 2 and entity in surfaces:
                        quads.append(frozenset(tags))
    return nodes, hexes, set(quads)


def write_deck(path, mesh, o):
    nodes, hexes, quads = mesh
    n, n_e = max(nodes), len(hexes)
    sign = {"left": 1, "right": -1}
    shift = {"left": -0.0279, "right": 0.0381}
    with open(path, "w") as f:
        say = lambda text: print(text, file=f)
        say("*NODE, NSET=NALL")
        for k, body in enumerate(("left", "right")):
            for tag, (x, y, z) in nodes.items():
                say(f"{tag + k * n}, {sign[body] * x + shift[body]:.12e}, {y:.12e}, {z:.12e}")
        for k, body in enumerate(("left", "right")):
            say(f"*ELEMENT, TYPE={o.element}, ELSET=E{body}")
            for e, tags in enumerate(hexes):
                ordered = tags if k == 0 else [tags[i] for i in MIRRORED]
                say(", ".join(str(i) for i in [e + 1 + k * n_e] + [t + k * n for t in ordered]))
        face_nodes = sorted(set().union(*quads))
        for k, body in enumerate(("left", "right")):
            say(f"*NSET, NSET=N{body}")
            for tag in nodes:
                say(f"{tag + k * n},")
            say(f"*NSET, NSET=F{body}")
            for tag in face_nodes:
                say(f"{tag + k * n},")
            say(f"*SURFACE, NAME=S{body}, TYPE=ELEMENT")
            for e, tags in enumerate(hexes):
                ordered = tags if k == 0 else [tags[i] for i in MIRRORED]
                for s, face in enumerate(FACES):
                    if frozenset(ordered[i] for i in face) in quads:
                        say(f"{e + 1 + k * n_e}, S{s + 1}")
        if o.contact == "node":
            say("*SURFACE, NAME=Nslave, TYPE=NODE\nFleft")
        say("*MATERIAL, NAME=steel\n*ELASTIC\n5.17e12, 0.3\n*DENSITY\n7836.")
        for body in ("left", "right"):
            say(f"*SOLID SECTION, ELSET=E{body}, MATERIAL=steel")
        kind = {"node": "NODE TO SURFACE", "face": "SURFACE TO SURFACE", "massless": "MASSLESS"}[o.contact]
        slave = "Nslave" if o.contact == "node" else "Sleft"
        say("*SURFACE INTERACTION, NAME=touch")
        if o.contact != "massless":
            say(f"*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n{o.stiffness:g}, 0." if o.contact == "face"
                else f"*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n{o.stiffness:g}, 1.e3, 1.e-9")
        say(f"*CONTACT PAIR, INTERACTION=touch, TYPE={kind}\n{slave}, Sright")
        say(f"*INITIAL CONDITIONS, TYPE=VELOCITY\nNleft, 1, {SPEED}")
        # Explicit runs print at the end of a step only: so a step for each output.
        n_steps = o.outputs if o.method == "explicit" else 1
        every = max(1, round(OUTPUT / o.step)) if o.step else 1
        for k in range(n_steps):
            say(f"*STEP, INC=1000000{', NLGEOM' if o.nlgeom else ''}")
            direct = ", DIRECT" if o.step else ""
            say(f"*DYNAMIC{direct}, {'EXPLICIT' if o.method == 'explicit' else f'ALPHA={o.alpha:g}'}")
            say(f"{o.step or OUTPUT:g}, {END / n_steps:g}")
            for body in ("left", "right"):
                say(f"*NODE PRINT, NSET=F{body}, FREQUENCY={every}\nU")
            if k == n_steps - 1:
                say("*NODE PRINT, NSET=NALL, FREQUENCY=1000000\nV")
            say("*END STEP")


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("mesh")
    p.add_argument("deck")
    p.add_argument("--method", choices=("explicit", "implicit"), default="explicit")
    p.add_argument("--element", default="C3D8", help="C3D8I with a fixed explicit step did not end in the time given (CalculiX 2.20)")
    p.add_argument("--contact", choices=("massless", "node", "face"), default="face")
    p.add_argument("--step", type=float, default=0, help="fixed step, s; 0: CalculiX' own")
    p.add_argument("--stiffness", type=float, default=0.3 * 5.17e12 / 2.54e-3,
                   help="of the contact, Pa/m; default: 0.3 E / element; ten times as much gains energy in explicit steps")
    p.add_argument("--outputs", type=int, default=1, help="of an explicit run: more of them change its answer a little")
    p.add_argument("--alpha", type=float, default=0.0, help="numerical damping of the implicit scheme")
    p.add_argument("--nlgeom", action="store_true")
    o = p.parse_args()
    write_deck(o.deck, read_msh(o.mesh), o)


if __name__ == "__main__":
    main()
