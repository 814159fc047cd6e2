#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""quality.py MESH.msh: nodes, tetrahedra, their sizes and shapes (gmsh 4.1, ASCII, tet4 or tet10). Exit 1 when one is inverted.

Size of a tetrahedron: the edge of the regular one of its volume. Quality: 12 (3 V)^(2/3) / (sum of squared edges), 1 for a regular
one, 0 for a flat one (Liu and Joe 1994). Corner vertices only; of tet10 also the smallest over the largest Jacobian at the corners.
"""
import sys

import numpy as np

CORNERS = {4: 4, 11: 10}  # gmsh's element type: nodes
EDGES = [(0, 1), (1, 2), (2, 0), (3, 0), (3, 2), (3, 1)]  # the order of gmsh's mid-edge nodes 4 ... 9; Exodus' own is another


def read(path):
    """Coordinates (n x 3) and nodes of the tetrahedra (e x 4 or e x 10, indices)."""
    lines = iter(open(path).read().split("\n"))
    tags, points, tets = [], [], []
    for line in lines:
        if line == "$Nodes":
            for _ in range(int(next(lines).split()[0])):
                count = int(next(lines).split()[3])
                tags += [int(next(lines)) for _ in range(count)]
                points += [next(lines).split()[:3] for _ in range(count)]
        elif line == "$Elements":
            for _ in range(int(next(lines).split()[0])):
                _, _, kind, count = (int(w) for w in next(lines).split())
                rows = [next(lines).split()[1:] for _ in range(count)]
                if kind in CORNERS:
                    tets += rows
    index = np.zeros(max(tags) + 1, dtype=int)
    index[tags] = np.arange(len(tags))
    return np.array(points, dtype=float), index[np.array(tets, dtype=int)]


def corner_jacobians(x):
    """det of dx/dxi at the four corners of tet10 (e x 10 x 3): from the quadratic shape functions' derivatives there."""
    corner = np.eye(4)
    derivative = np.array([[-1, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)  # of L0 ... L3 by xi
    values = []
    for L in corner:
        d = np.zeros((10, 3))
        for i in range(4):
            d[i] = (4 * L[i] - 1) * derivative[i]
        for m, (i, j) in enumerate(EDGES):
            d[4 + m] = 4 * (L[i] * derivative[j] + L[j] * derivative[i])
        values.append(np.linalg.det(np.einsum("eni,nj->eij", x, d)))
    return np.array(values).T


def figures(path):
    points, tets = read(path)
    x = points[tets]
    volume = np.einsum("ei,ei->e", np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), x[:, 3] - x[:, 0]) / 6
    size = np.cbrt(6 * np.sqrt(2) * np.abs(volume))
    squares = sum(((x[:, i] - x[:, j]) ** 2).sum(axis=1) for i, j in EDGES)
    quality = np.sign(volume) * 12 * np.cbrt(3 * np.abs(volume)) ** 2 / squares
    areas = [np.linalg.norm(np.cross(x[:, b] - x[:, a], x[:, c] - x[:, a]), axis=1) / 2 for a, b, c in ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))]
    height = 3 * volume / np.max(areas, axis=0)
    found = {"nodes": len(np.unique(tets)), "tets": len(tets), "volume": volume.sum(), "smallest": size.min(), "largest": size.max(), "ratio": size.max() / size.min(),
             "lowest": height.min(), "worst": quality.min(), "mean": quality.mean(), "jacobian": 1.0}
    if tets.shape[1] == 10:
        j = corner_jacobians(x)
        found["jacobian"] = (j.min(axis=1) / j.max(axis=1)).min()
    return found


def main():
    found = figures(sys.argv[1])
    print(f"{found['nodes']} nodes, {3 * found['nodes']} dofs, {found['tets']} tetrahedra, volume {found['volume']:.6g} m3")
    print(f"size {1e3 * found['smallest']:.3g} to {1e3 * found['largest']:.3g} mm, 1 : {found['ratio']:.1f}; smallest height {1e3 * found['lowest']:.3g} mm")
    print(f"quality (1 regular, 0 flat): worst {found['worst']:.3f}, mean {found['mean']:.3f}; Jacobians, smallest over largest of an element: {found['jacobian']:.3f}")
    return 0 if found["worst"] > 0 and found["jacobian"] > 0 else 1


if __name__ == "__main__":
    sys.exit(main())
