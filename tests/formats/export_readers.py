#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports of a superelement, read by other readers than ours: scipy (Matrix Market), and parsers written here from the formats'
descriptions (DMIG, Abaqus). usage: export_readers.py CBR_REDUCE. Exit 77 without h5py, numpy or scipy."""
import csv
import re
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import h5py
    import numpy as np
    import scipy.io
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

sys.dont_write_bytecode = True
from results_h5py import write_mesh  # noqa: E402

MATERIAL = ["--youngs-modulus", "2.1e11", "--poissons-ratio", "0.3", "--density", "7850"]


def run(folder, *arguments, expect=0):
    done = subprocess.run([sys.argv[1], "-q", *arguments], cwd=folder, capture_output=True, text=True)
    assert done.returncode == expect, (arguments, done.returncode, done.stderr)
    return done.stderr


def matrices_of_file(path):
    """K and M, interface dofs first, from the datasets that docs/formats.md describes."""
    with h5py.File(path) as file:
        K_cc, M_cc, M_kc = (file["matrices"][name][()] for name in ("K_cc", "M_cc", "M_kc"))
        eigenvalues = file["matrices/eigenvalues"][()]
        nodes, coordinates = file["nodes/id"][()], file["nodes/coordinates"][()]
        place, component = file["dofs/node"][()], file["dofs/component"][()]
    c, k = len(K_cc), len(eigenvalues)
    K, M = np.zeros((c + k, c + k)), np.eye(c + k)
    K[:c, :c], K[range(c, c + k), range(c, c + k)] = K_cc, eigenvalues
    M[:c, :c], M[c:, :c], M[:c, c:] = M_cc, M_kc, M_kc.T
    return K, M, [(int(nodes[p]), int(d) + 1, *coordinates[p]) for p, d in zip(place, component)], eigenvalues


def rows_of(table):
    with open(table, newline="") as lines:
        return list(csv.DictReader(lines))


def check_table(rows, dofs, eigenvalues):
    assert [int(r["row"]) for r in rows] == list(range(1, len(dofs) + len(eigenvalues) + 1))
    for row, (node, dof, *x) in zip(rows, dofs):
        assert (int(row["node"]), int(row["dof"])) == (node, dof), row
        assert [float(row[axis]) for axis in "xyz"] == x, row
    modal = rows[len(dofs):]
    assert all(r["dof"] == "0" for r in modal) and len({r["node"] for r in modal}) == len(modal)
    assert min(int(r["node"]) for r in modal) > max(d[0] for d in dofs)
    np.testing.assert_allclose([float(r["frequency_hz"]) for r in modal], np.sqrt(eigenvalues) / (2 * np.pi), rtol=1e-14)


def symmetric(entries, place, n):
    A = np.zeros((n, n))
    for row, column, value in entries:
        i, j = place[row], place[column]
        assert A[i, j] == 0, "an entry twice"
        A[i, j] = A[j, i] = value
    return A


def read_dmig(path):
    """{name: [((G1, C1), (GJ, CJ), A1)]} of large fields, and the SPOINTs."""
    found, points, name, column = {}, [], None, None
    for line in path.read_text().splitlines():
        assert len(line) <= 80 or line.startswith("$"), line
        fields = [line[8 + 16 * i:24 + 16 * i].strip() for i in range(4)]
        if line.startswith("SPOINT"):
            points.append(int(line[8:24]))
        elif line.startswith("DMIG*"):
            name, column = fields[0], (int(fields[1]), int(fields[2]))
        elif line.startswith("DMIG"):
            assert line[24:32].strip() == "6" and line[32:40].strip() == "2", line  # symmetric, real double
            found[line[8:16].strip()] = []
        elif line.startswith("*"):
            value = float(re.sub("D", "E", fields[2]))
            found[name].append(((int(fields[0]), int(fields[1])), column, value))
        else:
            assert line.startswith("$"), line
    return found, points


def read_abaqus(path):
    lines = (line.split(",") for line in path.read_text().splitlines())
    return [((int(a), int(b)), (int(c), int(d)), float(v)) for a, b, c, d, v in lines]


def check_formats(folder):
    write_mesh(folder / "box.msh")
    run(folder, "box.msh", "--interface", "contact", "--modes", "7", *MATERIAL, "-o", "box.cbr.h5")
    K, M, dofs, eigenvalues = matrices_of_file(folder / "box.cbr.h5")
    n = len(K)

    run(folder, "--export", "matrix-market", "box.cbr.h5")
    rows = rows_of(folder / "box.dofs.csv")
    check_table(rows, dofs, eigenvalues)
    for name, A in (("K", K), ("M", M)):
        np.testing.assert_array_equal(scipy.io.mmread(folder / f"box.{name}.mtx").toarray(), A)

    run(folder, "--export", "dmig", "box.cbr.h5", "-o", "out")
    found, points = read_dmig(folder / "out.dmig")
    place = {(int(r["node"]), int(r["dof"])): i for i, r in enumerate(rows)}
    assert points == [int(r["node"]) for r in rows if r["dof"] == "0"]
    for name, A in (("KAAX", K), ("MAAX", M)):
        np.testing.assert_allclose(symmetric(found[name], place, n), A, rtol=5.1e-10, atol=0)

    run(folder, "--export", "abaqus", "box.cbr.h5", "-o", "out")
    place = {(int(r["node"]), max(int(r["dof"]), 1)): i for i, r in enumerate(rows)}
    for name, A in (("K", K), ("M", M)):
        np.testing.assert_array_equal(symmetric(read_abaqus(folder / f"out.{name}.abaqus.mtx"), place, n), A)


def check_refusals(folder):
    error = run(folder, "--export", "nastrn", "box.cbr.h5", expect=2)
    assert "'nastrn' found" in error and "matrix-market, dmig, abaqus" in error, error
    error = run(folder, "--export", "dmig", "box.msh", expect=2)
    assert "box.msh" in error and error.count("\n") == 1, error
    run(folder, "box.msh", "--interface", "contact", "--modes", "7", "--basis", "massless", *MATERIAL, "-o", "bare.cbr.h5")
    error = run(folder, "--export", "dmig", "bare.cbr.h5", "-o", "bare", expect=2)
    assert "basis massless found" in error and "basis: craig-bampton" in error and error.count("\n") == 1, error
    assert not list(folder.glob("bare.d*"))
    run(folder, "--export", "dmig", "box.cbr.h5", "-o", "nowhere/out", expect=2)


def main():
    with tempfile.TemporaryDirectory() as name:
        check_formats(Path(name))
        check_refusals(Path(name))
    print("ok")


if __name__ == "__main__":
    main()
