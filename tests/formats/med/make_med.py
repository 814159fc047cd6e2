#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the .med files beside it with libmed, the library of Salome and code_aster. No test runs it: it needs python3-med,
python3-meshio and gmsh. usage: make_med.py FOLDER_OF_MESHES

hex8.med, hex20.med: what gmsh makes of block.geo. tet10.med: a tetrahedron. mixed.med: a hexahedron with a pyramid on top, a wedge
to the right, and a tetrahedron on a face of the pyramid; with groups of all kinds."""
import subprocess
import sys
import tempfile
from pathlib import Path

import meshio
import numpy as np
from med import medenum as m
from med.medfamily import MEDfamilyCr
from med.medfile import MEDfileClose, MEDfileOpen
from med.medmesh import (MEDCHAR, MEDFLOAT, MEDINT, MEDmeshCr, MEDmeshElementConnectivityWr, MEDmeshEntityFamilyNumberWr,
                         MEDmeshNodeCoordinateWr)

FOLDER = Path(__file__).parent
# Solids of MED are reflected: their first face looks inwards where that of others looks outwards. Node i of MED is node ORDER[i] here.
HEX = [0, 3, 2, 1, 4, 7, 6, 5]
TYPES = {"vertex": (m.MED_POINT1, [0]), "line": (m.MED_SEG2, [0, 1]), "line3": (m.MED_SEG3, [0, 1, 2]),
         "triangle": (m.MED_TRIA3, range(3)), "triangle6": (m.MED_TRIA6, range(6)), "quad": (m.MED_QUAD4, range(4)),
         "quad8": (m.MED_QUAD8, range(8)), "tetra": (m.MED_TETRA4, [0, 2, 1, 3]),
         "tetra10": (m.MED_TETRA10, [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]), "pyramid": (m.MED_PYRA5, [0, 3, 2, 1, 4]),
         "wedge": (m.MED_PENTA6, [0, 2, 1, 3, 5, 4]), "hexahedron": (m.MED_HEXA8, HEX),
         "hexahedron20": (m.MED_HEXA20, HEX + [11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17])}
DIMENSION = {"vertex": 0, "line": 1, "line3": 1, "triangle": 2, "triangle6": 2, "quad": 2, "quad8": 2}


def write_med(file, points, cells, groups, node_groups):
    """cells: {type of meshio: connectivity}; groups: {name: {type: rows}}; node_groups: {name: nodes}."""
    fid = MEDfileOpen(str(file), m.MED_ACC_CREAT)
    name, step = "mesh", (m.MED_NO_DT, m.MED_NO_IT)
    MEDmeshCr(fid, name, 3, 3, m.MED_UNSTRUCTURED_MESH, "", "", m.MED_SORT_DTIT, m.MED_CARTESIAN, " " * 48, " " * 48)
    MEDmeshNodeCoordinateWr(fid, name, *step, m.MED_UNDEF_DT, m.MED_FULL_INTERLACE, len(points),
                            MEDFLOAT(np.asarray(points, float).ravel().tolist()))
    MEDfamilyCr(fid, name, "FAMILLE_ZERO", 0, 0, MEDCHAR(""))
    families = {}

    def family(names, sign):
        """The number of the family that is in these groups and no other."""
        if not names:
            return 0
        key = (sign, tuple(names))
        if key not in families:
            families[key] = sign * (len(families) + 1)
            text = "".join(f"{n:\0<80}" for n in names)
            MEDfamilyCr(fid, name, f"FAM_{families[key]}", families[key], len(names), MEDCHAR(text))
        return families[key]

    of_node = [family([g for g, nodes in node_groups.items() if i in nodes], 1) for i in range(len(points))]
    MEDmeshEntityFamilyNumberWr(fid, name, *step, m.MED_NODE, m.MED_NONE, len(points), MEDINT(of_node))
    for kind, connectivity in cells.items():
        number, order = TYPES[kind]
        nodes = (np.asarray(connectivity)[:, list(order)] + 1).ravel().tolist()
        MEDmeshElementConnectivityWr(fid, name, *step, m.MED_UNDEF_DT, m.MED_CELL, number, m.MED_NODAL, m.MED_FULL_INTERLACE,
                                     len(connectivity), MEDINT(nodes))
        of_cell = [family([g for g, rows in groups.items() if row in rows.get(kind, ())], -1) for row in range(len(connectivity))]
        MEDmeshEntityFamilyNumberWr(fid, name, *step, m.MED_CELL, number, len(connectivity), MEDINT(of_cell))
    MEDfileClose(fid)


def from_gmsh(msh, med):
    mesh = meshio.read(msh)
    cells, groups = {}, {}
    for place, block in enumerate(mesh.cells):
        rows = cells.setdefault(block.type, [])
        for name, sets in mesh.cell_sets.items():
            if name.startswith("gmsh:"):
                continue
            mine = groups.setdefault(name, {}).setdefault(block.type, set())
            mine.update(len(rows) + int(row) for row in sets[place])
        rows.extend(block.data.tolist())
    x = mesh.points[:, 0]
    write_med(med, mesh.points, cells, groups, {"clamp": set(np.flatnonzero(x < x.min() + 1e-9))})


def mixed(med):
    points = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]  # 0 to 7: the hexahedron
    points += [(0.5, 0.5, 1.5), (2, 0, 0), (2, 0, 1), (0.5, -0.5, 1.5)]                # 8: apex; 9, 10: the wedge; 11: the tetrahedron
    cells = {"hexahedron": [range(8)], "pyramid": [(4, 5, 6, 7, 8)], "wedge": [(1, 9, 2, 5, 10, 6)], "tetra": [(4, 5, 8, 11)],
             "quad": [(0, 3, 2, 1), (1, 9, 10, 5)], "triangle": [(1, 2, 9), (5, 6, 8)], "line": [(0, 3)], "vertex": [(9,)]}
    cells = {kind: [list(row) for row in rows] for kind, rows in cells.items()}
    groups = {"all": {"hexahedron": {0}, "pyramid": {0}, "wedge": {0}, "tetra": {0}}, "roof": {"pyramid": {0}, "tetra": {0}},
              "floor": {"quad": {0}, "triangle": {0}}, "floor and wall": {"quad": {0, 1}, "triangle": {0}},
              "edge": {"line": {0}}, "corner": {"vertex": {0}}}
    write_med(med, points, cells, groups, {"clamp": {0, 3, 4, 7}, "ar~te": {0, 3}})
    # Older Salome writes Latin-1, which libmed's Python does not take.
    med.write_bytes(med.read_bytes().replace(b"ar~te", "ar\u00eate".encode("latin-1")))


def main():
    with tempfile.TemporaryDirectory() as folder:
        for order, name in ((1, "hex8"), (2, "hex20")):
            msh = Path(folder) / f"{name}.msh"
            subprocess.run(["gmsh", "-3", "-v", "1", Path(sys.argv[1]) / "block.geo", "-setnumber", "nx", "2", "-setnumber", "ny", "1",
                            "-setnumber", "nz", "1", "-setnumber", "order", str(order), "-o", msh], check=True)
            from_gmsh(msh, FOLDER / f"{name}.med")
    mixed(FOLDER / "mixed.med")
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], float)
    edges = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
    points = np.vstack([corners, [corners[list(edge)].mean(axis=0) for edge in edges]])
    write_med(FOLDER / "tet10.med", points, {"tetra10": [list(range(10))], "triangle6": [[0, 2, 1, 6, 5, 4]]},
              {"tetrahedron": {"tetra10": {0}}, "floor": {"triangle6": {0}}}, {})


if __name__ == "__main__":
    main()
