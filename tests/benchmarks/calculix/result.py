#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a CalculiX run of deck.py's block impact gave, against the converged answer.

    result.py impact.inp impact.dat reference/t1.txt [seconds of wall time]

Prints rms of the two faces' mean positions over 3810 m/s x 4.25 us, the mean velocities of the blocks at the end (lumped by volume of
elements) and of the faces, and when the faces are closest and part."""
import collections
import re
import sys

import numpy as np

SPEED, CONTACT = 3810.0, 4.25e-6
CENTRE = 0.0051  # x of the plane of symmetry at the start


def read_deck(path):
    """x of the nodes, hexes, node sets of the two contact faces."""
    x, hexes, sets, mode = {}, [], collections.defaultdict(list), None
    with open(path) as f:
        for line in f:
            if line.startswith("*"):
                mode = line.strip()
            elif mode.startswith("*NODE, "):
                words = line.split(",")
                x[int(words[0])] = float(words[1])
            elif mode.startswith("*ELEMENT"):
                hexes.append([int(w) for w in line.split(",")][1:])
            elif mode.startswith("*NSET"):
                sets[mode.split("=")[1]].append(int(line.split(",")[0]))
    return x, np.array(hexes), sets


def read_dat(path):
    """(kind, set, time, {node: (x, y, z)}) of each printed block."""
    header = re.compile(r"(displacements|velocities).* for set (\S+) and time\s+(\S+)")
    blocks = []
    with open(path) as f:
        for line in f:
            match = header.search(line)
            if match:
                blocks.append((match[1], match[2], float(match[3]), {}))
            elif line.strip() and blocks:
                words = line.split()
                blocks[-1][3][int(words[0])] = tuple(float(w) for w in words[1:4])
    return blocks


def main():
    x, hexes, sets = read_deck(sys.argv[1])
    blocks = read_dat(sys.argv[2])
    t_ref, s_ref = np.loadtxt(sys.argv[3]).T[:2]
    squares, curves = [], {}
    for body, sign in (("left", 1), ("right", -1)):
        of_face = [b for b in blocks if b[0] == "displacements" and b[1] == f"F{body.upper()}"]
        start = np.mean([x[n] for n in sets[f"F{body}"]])
        t = np.array([b[2] for b in of_face])
        d = start + np.array([np.mean([u[0] for u in b[3].values()]) for b in of_face]) - (CENTRE + SPEED / 2 * t)
        curves[body] = (t, d)
        squares.append((d - sign * np.interp(t, t_ref, s_ref)) ** 2)
    rms = np.sqrt(np.mean(np.concatenate(squares))) / (SPEED * CONTACT)
    t, gap = curves["left"][0], curves["right"][1] - curves["left"][1]
    closed = t[gap < 1e-7] if (gap < 1e-7).any() else np.array([np.nan])
    print(f"outputs {len(t)}, end {t[-1]:.3e} s, rms {100 * rms:.3f} %, smallest gap {gap.min():.3e} m, closed {closed[0]:.3e} .. {closed[-1]:.3e} s")
    weight = collections.Counter()
    for hexa in hexes:
        weight.update(hexa.tolist())
    for _, _, time, v in [b for b in blocks if b[0] == "velocities"][-1:]:
        for body in ("left", "right"):
            nodes = sets[f"N{body}"]
            w = np.array([weight[n] for n in nodes])
            print(f"mean velocity of {body} at {time:.3e} s: {np.dot(w, [v[n][0] for n in nodes]) / w.sum():.1f} m/s")


if __name__ == "__main__":
    main()
