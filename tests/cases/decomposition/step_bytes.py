# SPDX-License-Identifier: GPL-3.0-or-later
"""Bytes that one step of a coupled run reads, counted on the superelement file: step_bytes(file, held set)

Half of each K_cc (it is symmetric), each M_kc twice, and the factor of the joined nodes that are free, forward and backward. The factor
is that of an elimination by least degree, as in cbr-reduce --estimate, which does not know what a scene holds.
"""
import h5py
import numpy as np


def read_parts(path, held):
    """(modes, ids of the nodes) of each domain, ids of the nodes of the held sideset."""
    parts, fixed = [], set()
    with h5py.File(path) as file:
        groups = [file[f"domains/{d}"] for d in file["domains"]] if "domains" in file else [file]
        for group in groups:
            ids = group["nodes/id"][:]
            parts.append((len(group["matrices/eigenvalues"]), ids))
            if held in group.get("interface", {}):
                fixed.update(ids[np.unique(group[f"interface/{held}/faces"][:])])
    return parts, fixed


def factor_nonzeros(parts, fixed):
    of_node = {}
    for d, (_, ids) in enumerate(parts):
        for i in ids:
            if i not in fixed:
                of_node.setdefault(i, []).append(d)
    weight = {}  # nodes of the same domains are one
    for domains in of_node.values():
        weight[tuple(domains)] = weight.get(tuple(domains), 0) + 3
    near = {a: {b for b in weight if set(a) & set(b)} for a in weight}
    total = 0
    while near:
        one = min(near, key=lambda a: sum(weight[b] for b in near[a]))
        rows, w = sum(weight[b] for b in near[one]), weight[one]
        total += w * rows - w * (w - 1) // 2
        others = near.pop(one) - {one}
        for a in others:
            near[a] = (near[a] | others) - {one}
    return total


def step_bytes(path, held):
    parts, fixed = read_parts(path, held)
    blocks = sum(c * (c + 1) // 2 + 2 * k * c for k, c in ((k, 3 * len(ids)) for k, ids in parts))
    return 8 * (blocks + 2 * factor_nonzeros(parts, fixed))
