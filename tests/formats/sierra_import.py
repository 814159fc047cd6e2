#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A superelement that Sierra/SD wrote runs with contact: cbr-reduce --import sierra takes the faces from the companion Exodus mesh. The
impact of two such blocks is that of our own reduction of the same mesh, motion by motion.
usage: sierra_import.py CBR_REDUCE CBR_DYN. Exit 77 without CBR_SHARED_DATA (CONTRIBUTING.md), h5py or numpy."""
import os
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
from netcdf3 import Netcdf  # noqa: E402
from running import h5py, np, run  # noqa: E402

DATA = Path(os.environ.get("CBR_SHARED_DATA", "nowhere")) / "sierra"
SPEED = 2.0
# Sierra's block: 320 hexes from x = 0.0625 on, where the 25 nodes of nodeset 1 are its interface.
SCENE = """
components: {block: COMPONENT}
instances:
  left: {component: block, position: [0.06249, 0, 0], mirror: x, velocity: [2, 0, 0]}
  right: {component: block, position: [-0.0625, 0, 0]}
contact: [{between: [left.SURFACE, right.SURFACE]}]
time: {end: 4.0e-4}
output: {every: 2.0e-6, history: [left.SURFACE, right.SURFACE]}
"""


def write_own_mesh(path):
    """Sierra's mesh with the contact face as a surface: sides of hexes on the plane x = 0.0625 (gmsh 2.2)."""
    file = Netcdf(DATA / "block_1-eig.exo")
    ids, elements = file["node_num_map"], file["elem_num_map"]
    x = np.stack([file["coord" + axis] for axis in "xyz"], axis=1)
    hexes = file["connect1"] - 1
    sides = [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (0, 4, 7, 3), (0, 3, 2, 1), (4, 5, 6, 7)]
    faces = [row[list(side)] for row in hexes for side in sides if (np.abs(x[row[list(side)], 0] - 0.0625) < 1e-9).all()]
    assert hexes.shape == (320, 8) and len(faces) == 16
    lines = [f"{e} 5 2 1 1 {' '.join(map(str, ids[row]))}" for e, row in zip(elements, hexes)]
    lines += [f"{max(elements) + i} 3 2 2 2 {' '.join(map(str, ids[face]))}" for i, face in enumerate(faces, 1)]
    nodes = [f"{i} {a!r} {b!r} {c!r}" for i, (a, b, c) in zip(ids.tolist(), x.tolist())]
    path.write_text("\n".join(["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "2", '3 1 "solid"', '2 2 "contact"',
                               "$EndPhysicalNames", "$Nodes", str(len(nodes)), *nodes, "$EndNodes", "$Elements", str(len(lines)), *lines,
                               "$EndElements", ""]))


def check_own_reduction(folder, reducer, runner, surface):
    """The same impact with our reduction of the mesh: aluminium, incompatible modes, consistent mass, 30 modes, as Sierra/SD has it."""
    write_own_mesh(folder / "own.msh")
    run(folder, reducer, "own.msh", "--interface", "contact", "--modes", "30", "--youngs-modulus", "70.33e9", "--poissons-ratio", "0.33",
        "--density", "2704.32669", "--mass", "consistent", "--exact-modes", "-o", "own.cbr.h5")
    (folder / "own.yaml").write_text(SCENE.replace("COMPONENT", "{superelement: own.cbr.h5}").replace("SURFACE", "contact"))
    run(folder, runner, "own.yaml", "-o", "own.h5")
    worst = {}
    with h5py.File(folder / "results.h5") as theirs, h5py.File(folder / "own.h5") as ours:
        for what in ("mean_position", "mean_velocity", "force"):
            for side in ("left", "right"):
                a, b = theirs[f"surfaces/{side}.{surface}/{what}"][()], ours[f"surfaces/{side}.contact/{what}"][()]
                worst[what] = max(worst.get(what, 0), np.abs(a - b).max() / np.abs(b).max())
        for name in ("energy/total", "instances/left/momentum", "instances/right/momentum"):
            a, b = theirs[name][()], ours[name][()]
            worst[name] = np.abs(a - b).max() / np.abs(b).max()
        np.testing.assert_array_equal(theirs["contact/active"][()] > 0, ours["contact/active"][()] > 0)
    print("Sierra/SD's superelement and ours, differences as shares of the largest value: " +
          ", ".join(f"{name} {value:.1e}" for name, value in worst.items()))
    assert max(worst.values()) < 1.5e-11, worst


def main():
    for file in ("block_1-cbr.nc4", "block_1-eig.exo", "cbr2.ncf"):
        if not (DATA / file).exists():
            print(f"skipped: no {DATA / file}: set CBR_SHARED_DATA")
            return 77
    reducer, runner = sys.argv[1:3]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        mesh = DATA / "block_1-eig.exo"
        run(folder, reducer, "--import", "sierra", DATA / "block_1-cbr.nc4", "--faces", mesh, "-o", "block.cbr.h5")
        with h5py.File(folder / "block.cbr.h5") as file:
            (surface,) = file["interface"]
            faces, x = file[f"interface/{surface}/faces"][()], file["nodes/coordinates"][()]
            assert faces.shape == (16, 4) and len(x) == 25
            normals = np.cross(x[faces[:, 2]] - x[faces[:, 0]], x[faces[:, 3]] - x[faces[:, 1]]) / 2
            np.testing.assert_allclose(normals.sum(0), [-0.01, 0, 0], rtol=0, atol=1e-12)  # outward, 0.1 x 0.1
            mass = file["rigid_body/mass"][()].item()
            K_cc, M_kc = file["matrices/K_cc"][()], file["matrices/M_kc"][()]
        assert K_cc.shape == (75, 75) and M_kc.shape == (30, 75)
        # Aluminium, 2704.32669 kg/m^3
        np.testing.assert_allclose(mass, 2704.32669 * 0.1 * 0.1 * 0.5, rtol=1e-9)

        (folder / "scene.yaml").write_text(
            SCENE.replace("COMPONENT", "{superelement: block.cbr.h5}").replace("SURFACE", surface))
        run(folder, runner, "scene.yaml", "-o", "results.h5")
        with h5py.File(folder / "results.h5") as file:
            left, right = (file[f"instances/{which}/momentum"][()][:, 0] for which in ("left", "right"))
            active, energy = file["contact/active"][()], file["energy/total"][()]
        assert active.max() > 0 and active[0] == 0 and active[-1] == 0, active
        np.testing.assert_allclose(left + right, mass * SPEED, rtol=1e-9)
        assert abs(energy[0] / (0.5 * mass * SPEED**2) - 1) < 1e-9 and energy.max() < energy[0] * (1 + 1e-9)
        assert right[-1] > 0.8 * mass * SPEED, right[-1]  # equal blocks exchange their velocities

        check_own_reduction(folder, reducer, runner, surface)
        # Rotations are refused by name, and a mesh that is another's
        error = run(folder, reducer, "--import", "sierra", DATA / "cbr2.ncf", "-o", "old.cbr.h5", expect=2)
        assert "rotational dof" in error and error.count("\n") == 1, error
        (folder / "cut.nc4").write_bytes((DATA / "block_1-cbr.nc4").read_bytes()[:100000])
        error = run(folder, reducer, "--import", "sierra", "cut.nc4", "-o", "old.cbr.h5", expect=2)
        assert "cut.nc4" in error and error.count("\n") == 1, error
        error = run(folder, reducer, "--import", "sierra", mesh, "-o", "old.cbr.h5", expect=2)
        assert "not a Sierra/SD superelement" in error and error.count("\n") == 1, error
        assert not (folder / "old.cbr.h5").exists()
        print(f"mass {mass:.9g}, momentum given on {right[-1] / (mass * SPEED):.4f}, energy kept {energy[-1] / energy[0]:.4f}")
    print("ok")
    return 0


if __name__ == "__main__":
    sys.exit(main())
