#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports of a superelement, read by other readers than ours: scipy (Matrix Market; skipped without it), and parsers written here from
the formats' descriptions (DMIG, OUTPUT4, Abaqus, CalculiX, Sierra/SD). The layout of Sierra/SD's files is compared with a file that it
wrote, where CBR_SHARED_DATA has one. usage: export_readers.py CBR_REDUCE. Exit 77 without h5py or numpy."""
import csv
import os
import re
import sys
from pathlib import Path

try:
    import scipy.io
except ImportError:
    scipy = None
    print("Matrix Market is not read by scipy: it is not installed")

sys.dont_write_bytecode = True
from netcdf3 import Netcdf  # noqa: E402
from running import MATERIAL, check_in_turn, h5py, np, write_mesh  # noqa: E402
from running import run as run_program  # noqa: E402


def run(folder, *arguments, expect=0):
    return run_program(folder, sys.argv[1], *arguments, expect=expect)


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
    for name, A in (("K", K), ("M", M)) if scipy else ():
        np.testing.assert_array_equal(scipy.io.mmread(folder / f"box.{name}.mtx").toarray(), A)

    run(folder, "--export", "dmig", "box.cbr.h5", "-o", "out")
    found, points = read_dmig(folder / "out.dmig")
    place = {(int(r["node"]), int(r["dof"])): i for i, r in enumerate(rows)}
    assert points == [int(r["node"]) for r in rows if r["dof"] == "0"]
    for name, A in (("KAAX", K), ("MAAX", M)):
        np.testing.assert_allclose(symmetric(found[name], place, n), A, rtol=5.1e-10, atol=0)

    run(folder, "--export", "dmig", "box.cbr.h5", "-o", "moved", "--first-modal-node", "9001")
    assert read_dmig(folder / "moved.dmig")[1] == list(range(9001, 9001 + len(eigenvalues)))

    run(folder, "--export", "abaqus", "box.cbr.h5", "-o", "out")
    place = {(int(r["node"]), max(int(r["dof"]), 1)): i for i, r in enumerate(rows)}
    for name, A in (("K", K), ("M", M)):
        np.testing.assert_array_equal(symmetric(read_abaqus(folder / f"out.{name}.abaqus.mtx"), place, n), A)

    run(folder, "--export", "mtx", "box.cbr.h5", "-o", "out")
    for name, A in (("K", K), ("M", M)):
        np.testing.assert_array_equal(symmetric(read_abaqus(folder / f"out.{name}.ccx.mtx"), place, n), A)
    # CalculiX makes room by the stiffness alone
    places = [{(i, j) for i, j, _ in read_abaqus(folder / f"out.{name}.ccx.mtx")} for name in "KM"]
    assert places[1] <= places[0], sorted(places[1] - places[0])[:3]
    check_calculix_input(folder / "out.ccx.inp", rows)
    for form, read in (("op4", read_op4), ("op4-binary", read_op4_binary)):
        run(folder, "--export", form, "box.cbr.h5", "-o", "out")
        found = read(folder / "out.op4")
        assert sorted(found) == ["KAAX", "MAAX"]
        for name, A in (("KAAX", K), ("MAAX", M)):
            np.testing.assert_array_equal(found[name], A, err_msg=form)
    run(folder, "--export", "sierra", "box.cbr.h5", "-o", "out")
    check_sierra(Netcdf(folder / "out.nc"), K, M, dofs, len(eigenvalues))
    run(folder, "--export", "sierra-older", "box.cbr.h5", "-o", "out")
    check_sierra_older(Netcdf(folder / "out.nc"), K, M, dofs, len(eigenvalues))


def check_calculix_input(path, rows):
    """Nodes with their places, and the card that names both files."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("**")]
    assert lines[0].startswith("*NODE") and lines[-1] == "*MATRIX ASSEMBLE, NAME=CBR, STIFFNESS FILE=out.K.ccx.mtx, MASS FILE=out.M.ccx.mtx"
    nodes = {int(n): [float(x) for x in xyz] for n, *xyz in (line.split(",") for line in lines[1:-1])}
    assert set(nodes) == {int(r["node"]) for r in rows}
    for r in rows:
        assert r["dof"] == "0" or nodes[int(r["node"])] == [float(r[axis]) for axis in "xyz"], r


def read_op4(path):
    """{name: matrix} of a text file: header 4I8, A8, format; a column: number, first row, count; a last one above all."""
    lines, found = iter(path.read_text().splitlines()), {}
    for header in lines:
        columns, rows, form, kind = (int(header[8 * i:8 * i + 8]) for i in range(4))
        assert (form, kind) == (6 if rows == columns else 2, 2) and header[40:] == "1P,3E24.16", header
        A = np.zeros((rows, columns))
        while True:
            column, first, count = (int(x) for x in next(lines).split())
            values = "".join(next(lines).ljust(72) for _ in range((count + 2) // 3))
            if column > columns:
                break
            A[first - 1:first - 1 + count, column - 1] = [float(values[24 * i:24 * i + 24]) for i in range(count)]
        found[header[32:40].strip()] = A
    return found


def read_op4_binary(path):
    """The same of Fortran's records: length, contents, length."""
    data, at, found, A = path.read_bytes(), 0, {}, None
    while at < len(data):
        (length,) = np.frombuffer(data, "<i4", 1, at)
        record, at = data[at + 4:at + 4 + length], at + 8 + length
        assert np.frombuffer(data, "<i4", 1, at - 4)[0] == length
        if A is None:
            columns, rows, form, kind = np.frombuffer(record, "<i4", 4)
            assert length == 24 and (form, kind) == (6 if rows == columns else 2, 2)
            A, name = np.zeros((rows, columns)), record[16:].decode().strip()
            continue
        column, first, words = np.frombuffer(record, "<i4", 3)
        assert length == 12 + 4 * words
        if column > columns:
            found[name], A = A, None
        else:
            A[first - 1:first - 1 + words // 2, column - 1] = np.frombuffer(record, "<f8", words // 2, 12)
    return found


def check_sierra(file, K, M, dofs, k):
    check_sierra_matrices(file, K, M, dofs, k, np.stack([file["coord" + axis] for axis in "xyz"], axis=1))
    assert (file["Cr"] == 0).all() and file["Cr"].shape == K.shape
    np.testing.assert_array_equal(file["cbmap"], [(0, 0)] * k + [(node, dof) for node, dof, *_ in dofs])
    check_sierra_layout(file, "block_1-cbr.nc4", set())


def check_sierra_older(file, K, M, dofs, k):
    check_sierra_matrices(file, K, M, dofs, k, file["coord"].T)
    np.testing.assert_array_equal(file["cbmap"], [(node, dof) for node, dof, *_ in dofs])
    # recovery of the interior, which is not written
    check_sierra_layout(file, "cbr2.ncf", {"OTM", "OutMap", "OTM_col", "NumNode_out", "len_line"})


def check_sierra_matrices(file, K, M, dofs, k, x):
    n, c = len(K), len(dofs)
    order = [*range(c, n), *range(c)]  # modes first
    for name, A in (("Kr", K), ("Mr", M)):
        np.testing.assert_array_equal(file[name], A[np.ix_(order, order)], err_msg=name)
    ids = list(file["node_num_map"])
    for node, _, *position in dofs:
        np.testing.assert_array_equal(x[ids.index(node)], position)
    assert (file.dimensions["NumEig"], file.dimensions["NumConstraints"], file.dimensions["NumInterfaceNodes"]) == (k, c, len(ids))


def check_sierra_layout(file, sample, left_out):
    theirs = Path(os.environ.get("CBR_SHARED_DATA", "nowhere")) / "sierra" / sample
    if not theirs.exists():
        print(f"the layout is not compared with Sierra/SD's: no {theirs}: set CBR_SHARED_DATA")
        return
    theirs = Netcdf(theirs)
    assert set(file.dimensions) == set(theirs.dimensions) - left_out, set(file.dimensions) ^ set(theirs.dimensions)
    names = [name for name in theirs.names() if name not in left_out]
    assert sorted(file.names()) == sorted(names)
    for name in names:
        assert file.dimensions_of(name) == theirs.dimensions_of(name) and file[name].dtype == theirs[name].dtype, name
    assert set(file.attributes) == set(theirs.attributes)
    assert file.attributes_of("connect1")["elem_type"] == theirs.attributes_of("connect1")["elem_type"].rstrip("\0")


POINTS = """materials: {steel: {youngs_modulus: 2.1e11, poissons_ratio: 0.3, density: 7850}}
components:
  box:
    mesh: ends.msh
    material: steel
    points: {near: {surface: contact, coupling: rigid}, away: {surface: far, coupling: rigid, at: [-0.5, 0.25, 0.125]}}
    reduction: {points: [near, away], modes: 5, superelement: ends.cbr.h5}
instances: {a: {component: box}}
"""


def grids_of(path):
    """{id: [x, y, z]} of GRID cards in large fields, two lines each."""
    lines, grids = iter(path.read_text().splitlines()), {}
    for line in lines:
        if line.startswith("GRID*"):
            grids[int(line[8:24])] = [float(x) for x in (line[40:56], line[56:72], next(lines)[8:24])]
    return grids


def check_points(folder):
    """Nodes of six dofs: 1 to 6 in every format, GRID cards for Nastran, and the way back."""
    write_mesh(folder / "ends.msh", far=True)
    (folder / "points.yaml").write_text(POINTS)
    run(folder, "points.yaml")
    K, M, dofs, eigenvalues = matrices_of_file(folder / "ends.cbr.h5")
    (away, near) = sorted({d[0] for d in dofs})
    assert [d[:2] for d in dofs] == [(node, dof) for node in (away, near) for dof in range(1, 7)]
    assert dofs[0][2:] == (-0.5, 0.25, 0.125)
    for name in ("dmig", "abaqus", "matrix-market", "op4"):
        run(folder, "--export", name, "ends.cbr.h5", "-o", f"ends-{name}")
        rows = rows_of(folder / f"ends-{name}.dofs.csv")
        check_table(rows, dofs, eigenvalues)
        run(folder, "--import", name, f"ends-{name}", "-o", f"{name}-back.cbr.h5")
        K_back, M_back, dofs_back, _ = matrices_of_file(folder / f"{name}-back.cbr.h5")
        assert dofs_back == dofs
        scale = np.sqrt(np.outer(np.diag(K), np.diag(K)))
        np.testing.assert_allclose(K_back / scale, K / scale, atol=1e-9 if name == "dmig" else 1e-15)
        with h5py.File(folder / f"{name}-back.cbr.h5") as file:
            assert sorted(file["nodesets"]) == sorted(f"node_{node}" for node in (away, near))
    place = {(int(r["node"]), int(r["dof"])): i for i, r in enumerate(rows)}
    path = folder / "ends-dmig.dmig"
    np.testing.assert_allclose(list(grids_of(path)[away]), [-0.5, 0.25, 0.125])
    assert sorted(grids_of(path)) == [away, near]
    bare = folder / "without-grids.dmig"
    lines = path.read_text().splitlines()
    bare.write_text("\n".join(line for i, line in enumerate(lines)
                              if not line.startswith("GRID*") and not lines[i - 1].startswith("GRID*")) + "\n")
    found, _ = read_dmig(bare)
    for name, A in (("KAAX", K), ("MAAX", M)):
        np.testing.assert_allclose(symmetric(found[name], place, len(A)), A, rtol=5.1e-10, atol=0)
    # Rigid motions of six dofs a node: no force, and the mass of the whole
    R = np.zeros((len(K), 6))
    for i, (_, dof, *x) in enumerate(dofs):
        axis = (dof - 1) % 3
        R[i, axis if dof < 4 else 3 + axis] = 1
        if dof < 4:
            R[i, 3:] = np.cross(np.eye(3), x)[:, axis]
    assert np.abs(K @ R).max() < 1e-10 * np.abs(K).max()
    with h5py.File(folder / "ends.cbr.h5") as file:
        mass = float(file["rigid_body/mass"][0])
    np.testing.assert_allclose((R.T @ M @ R)[:3, :3], mass * np.eye(3), atol=1e-9 * mass)


def equations_of_deck(text):
    """*EQUATION of CalculiX: {(node, dof): {node of q: T}}, the dependent dof first, with -1."""
    found = {}
    for part in text.split("*EQUATION\n")[1:]:
        count, *terms = re.split(r"[,\s]+", part.strip())
        terms = [(int(a), int(b), float(v)) for a, b, v in zip(terms[::3], terms[1::3], terms[2::3])]
        assert len(terms) == int(count) and terms[0][2] == -1 and all(dof == 1 for _, dof, _ in terms[1:])
        found[terms[0][:2]] = {node: v for node, _, v in terms[1:]}
    return found


def equations_of_bulk(lines):
    """MPC of Nastran in large fields: two terms in two lines, the second without its first field."""
    found = {}
    for line in lines:
        fields = [line[8 + 16 * i:24 + 16 * i].strip().replace("D", "E") for i in range(4)]
        if line.startswith("MPC*"):
            assert fields[0] == "1" and float(fields[3]) == -1, line
            current = found.setdefault((int(fields[1]), int(fields[2])), {})
        elif line.startswith("*") and found:
            node, dof, value = fields[:3] if fields[0] else fields[1:]
            assert int(dof) == 0, line
            current[int(node)] = float(value)
    return found


def check_modal(folder):
    """Bases whose interface follows modes: frequencies and receptances of the exported files are those of the superelement, of its mesh
    where the basis is exact, and with the interface fixed those of the fixed modes."""
    run(folder, "box.msh", "--interface", "contact", "--modes", "40", *MATERIAL, "--mass", "lumped", "-o", "fixed.cbr.h5")
    with h5py.File(folder / "fixed.cbr.h5") as file:
        closed = file["matrices/eigenvalues"][()]
    for basis, options in (("massless", ["--modes", "40"]), ("characteristic", ["--modes", "30", "--characteristic-modes", "6"])):
        run(folder, "box.msh", "--interface", "contact", "--basis", basis, *options, *MATERIAL, "--mass", "lumped", "-o", "modal.cbr.h5")
        with h5py.File(folder / "modal.cbr.h5") as file:
            eigenvalues, V = file["matrices/eigenvalues"][()], file[f"{basis}/V"][()]
            nodes, place, component = (file[name][()] for name in ("nodes/id", "dofs/node", "dofs/component"))
            if basis == "massless":
                F = file["massless/F"][()]
            else:
                statics = file["characteristic/statics"]
                B = np.zeros((len(V), len(statics["F"])))
                for j, (node, n) in enumerate(zip(statics["node"][()], statics["direction"][()])):
                    B[place == node, j] = n[component[place == node]]
                F = B @ statics["F"][()] @ B.T
        k, scale = len(eigenvalues), np.abs(F).max()
        for name in ("matrix-market", "op4", "op4-binary", "dmig", "mtx"):
            run(folder, "--export", name, "modal.cbr.h5", "-o", "modal")
            rows, interface = rows_of(folder / "modal.dofs.csv"), rows_of(folder / "modal.interface.csv")
            assert [(int(r["node"]), int(r["dof"])) for r in interface] == [(nodes[p], d + 1) for p, d in zip(place, component)]
            assert all(r["dof"] == "0" and (r["frequency_hz"] == "") == (i >= k) for i, r in enumerate(rows))
            n, of_q = len(rows), [int(r["node"]) for r in rows]
            if name == "matrix-market":
                if not scipy:
                    continue
                K, M, T = (np.asarray(A.todense() if hasattr(A, "todense") else A) for A in (scipy.io.mmread(folder / f"modal.{x}.mtx") for x in "KMT"))
            elif name.startswith("op4"):
                found = (read_op4 if name == "op4" else read_op4_binary)(folder / "modal.op4")
                K, M, T = (found[x] for x in ("KAAX", "MAAX", "TCAX"))
            else:
                dof = 0 if name == "dmig" else 1
                index = {(node, dof): i for i, node in enumerate(of_q)}
                if name == "dmig":
                    lines = (folder / "modal.dmig").read_text().splitlines()
                    first = next(i for i, line in enumerate(lines) if line.startswith("MPC*"))
                    (folder / "matrices.dmig").write_text("\n".join(lines[:first]) + "\n")
                    found, _ = read_dmig(folder / "matrices.dmig")
                    entries, equations = (found["KAAX"], found["MAAX"]), equations_of_bulk(lines[first:])
                else:
                    entries = [read_abaqus(folder / f"modal.{x}.ccx.mtx") for x in "KM"]
                    assert entries[0].pop()[:2] == ((of_q[-1], 3),) * 2  # beside all others, as CalculiX wants three dofs a node
                    equations = equations_of_deck((folder / "modal.ccx.inp").read_text())
                K, M = (symmetric(of, index, n) for of in entries)
                T = np.array([[equations[int(r["node"]), int(r["dof"])][q] for q in of_q] for r in interface])
            digits = 1e-8 if name == "dmig" else 1e-12
            # Receptance of the interface, at rest and between its frequencies
            elastic = np.sort(eigenvalues)[6:]
            for shift in (-elastic[0], 0.5 * (elastic[0] + elastic[1])):
                wanted = V / (eigenvalues - shift) @ V.T + F
                np.testing.assert_allclose(T @ np.linalg.solve(K - shift * M, T.T), wanted, rtol=0, atol=digits * np.abs(wanted).max())
            # A solver's frequencies: mu = 1 / (lambda + shift), 0 for residual vectors
            mu = np.sort(np.linalg.eigvals(np.linalg.solve(K + elastic[0] * M, M)).real)[::-1]
            np.testing.assert_allclose(1 / mu[:k] - elastic[0], np.sort(eigenvalues), rtol=digits, atol=digits * elastic[0])
            assert np.abs(mu[k:]).max(initial=0) < 1e-12 * mu[0] and (basis == "characteristic" or n == k + len(T))
            if basis == "massless":  # T q = 0: what CalculiX and Nastran do with the equations and a fixed interface
                N = np.linalg.svd(T)[2][len(T):].T
                mu = np.linalg.eigvals(np.linalg.solve(N.T @ K @ N, N.T @ M @ N)).real
                fixed = np.sqrt(np.sort(1 / mu[mu > 1e-12 * mu.max()])[:3] / closed[:3])
                np.testing.assert_allclose(fixed, 1, atol=5e-3)  # 1.2e-3: forty modes of a coarse block


def check_refusals(folder):
    error = run(folder, "--export", "nastrn", "box.cbr.h5", expect=2)
    assert "'nastrn' found" in error and "matrix-market, dmig, op4, op4-binary, abaqus, mtx, sierra, sierra-older" in error, error
    error = run(folder, "--export", "dmig", "box.cbr.h5", "--first-modal-node", "1", expect=2)
    assert "box.cbr.h5: --export: --first-modal-node 1 found, expected above" in error and error.count("\n") == 1, error
    error = run(folder, "--export", "dmig", "box.cbr.h5", "--first-modal-node", "99999994", expect=2)
    assert "Nastran's numbers end at 99999999: give a lower --first-modal-node" in error and error.count("\n") == 1, error
    error = run(folder, "--export", "dmig", "box.msh", expect=2)
    assert "box.msh" in error and error.count("\n") == 1, error
    run(folder, "box.msh", "--interface", "contact", "--modes", "7", "--basis", "massless", *MATERIAL, "-o", "bare.cbr.h5")
    for name in ("abaqus", "sierra"):
        error = run(folder, "--export", name, "bare.cbr.h5", "-o", "bare", expect=2)
        assert f"basis massless found, whose interface follows modes: {name} has no form" in error and error.count("\n") == 1, error
    assert not list(folder.glob("bare.d*"))
    run(folder, "--export", "dmig", "box.cbr.h5", "-o", "nowhere/out", expect=2)


if __name__ == "__main__":
    check_in_turn(check_formats, check_points, check_modal, check_refusals)
