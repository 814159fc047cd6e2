#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""CalculiX and ours on the same hexahedra: its matrices become superelements with our matrices and its frequencies; where a CalculiX of
2.21 or later is installed, our superelement runs in it. usage: calculix.py CBR_REDUCE. Exit 77 without h5py or numpy."""
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
from running import h5py, np  # noqa: E402

FILES = Path(__file__).parent / "calculix"
OURS = ["--element", "hex8", "--mass", "consistent"]  # what CalculiX's C3D8 is


def reduce(folder, *arguments, expect=0):
    done = subprocess.run([sys.argv[1], *arguments], cwd=folder, capture_output=True, text=True)
    assert done.returncode == expect, (arguments, done.returncode, done.stderr)
    return done.stdout + done.stderr


def matrices(path):
    with h5py.File(path) as file:
        node = file["nodes/id"][()][file["dofs/node"][()]]
        order = np.lexsort((file["dofs/component"][()], node))
        K, M, M_kc = (file[f"matrices/{name}"][()] for name in ("K_cc", "M_cc", "M_kc"))
        return K[np.ix_(order, order)], M[np.ix_(order, order)], M_kc[:, order], file["matrices/eigenvalues"][()]


def close(found, expected, tolerance):
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * np.abs(expected).max())


def storage(folder):
    """CalculiX's K and M, and the node and dof of each row."""
    rows = [tuple(map(int, line.split("."))) for line in (folder / "block.dof").read_text().split()]
    full = []
    for name in ("sti", "mas"):
        A = np.zeros((len(rows), len(rows)))
        i, j, values = np.loadtxt(folder / f"block.{name}").T
        A[i.astype(int) - 1, j.astype(int) - 1] = values
        full.append(A + A.T - np.diag(A.diagonal()))
    return rows, *full


def check_storage(folder):
    text = reduce(folder, "--import", "matrix-storage", "block", "--faces", "block.inp", "-o", "theirs.cbr.h5")
    assert "48 of the interface (16 nodes), 0 modes" in text, text
    reduce(folder, "block.inp", "--interface", "all", "--modes", "0", *OURS, "-o", "ours.cbr.h5")
    for theirs, ours in zip(matrices(folder / "theirs.cbr.h5")[:2], matrices(folder / "ours.cbr.h5")[:2]):
        close(theirs, ours, 1e-12)
    found = re.search(r"free part: ([\d., ]+) Hz", reduce(folder, "--info", "theirs.cbr.h5")).group(1).split(", ")
    printed = re.search(r"gives ([\d., ]+) Hz", (folder / "block.inp").read_text()).group(1).split(", ")
    np.testing.assert_allclose([float(f) for f in found[:3]], [float(f) for f in printed], rtol=1e-5)


def triangle(A):
    """As CalculiX writes it: four numbers a line, each row on lines of its own."""
    lines = [row[at:at + 4] for i, row in enumerate(A) for row in [row[:i + 1]] for at in range(0, i + 1, 4)]
    return "".join(",".join(f"{value:20.13E}" for value in line) + ",\n" for line in lines)


def check_substructure(folder):
    """CalculiX's stiffness of x_max, with the mass that its matrices give; then with modes, which are nodes of their own."""
    rows, K, M = storage(folder)
    kept = [i for i, (node, _) in enumerate(rows) if node in (2, 4, 6, 7)]
    inner = [i for i in range(len(rows)) if i not in kept]
    Psi = -np.linalg.solve(K[np.ix_(inner, inner)], K[np.ix_(inner, kept)])
    T = np.zeros((len(rows), len(kept)))
    T[kept], T[inner] = np.eye(len(kept)), Psi
    stiffness = (folder / "substructure.mtx").read_text()
    (folder / "guyan.mtx").write_text(stiffness + "*MATRIX,TYPE=MASS\n" + triangle(T.T @ M @ T))
    reduce(folder, "--import", "substructure", "guyan.mtx", "--faces", "block.inp", "-o", "theirs.cbr.h5")
    reduce(folder, "block.inp", "--interface", "x_max", "--modes", "0", *OURS, "-o", "ours.cbr.h5")
    for theirs, ours in zip(matrices(folder / "theirs.cbr.h5")[:2], matrices(folder / "ours.cbr.h5")[:2]):
        close(theirs, ours, 1e-12)
    with h5py.File(folder / "theirs.cbr.h5") as file:
        assert set(file["interface"]) == {"x_max"} and file["interface/x_max/faces"].shape == (1, 4)
    # K_ii Phi = M_ii Phi Lambda, Phi^T M_ii Phi = I
    L = np.linalg.inv(np.linalg.cholesky(M[np.ix_(inner, inner)]))
    eigenvalues, vectors = np.linalg.eigh(L @ K[np.ix_(inner, inner)] @ L.T)
    Phi = np.zeros((len(rows), 3))
    Phi[inner] = L.T @ vectors[:, :3]
    T = np.hstack([T, Phi])
    nodes = [rows[i][0] for i in kept] + [901, 902, 903]
    dofs = [rows[i][1] for i in kept] + [1, 1, 1]
    text = f"*USER ELEMENT, NODES={len(nodes)}, LINEAR\n** ELEMENT NODES\n**{', '.join(map(str, nodes))}\n{dofs[0]}\n"
    text += "".join(f"{place}, {dof}\n" for place, dof in enumerate(dofs[1:], 2))
    (folder / "modes.mtx").write_text(f"{text}*MATRIX, TYPE=STIFFNESS\n{triangle(T.T @ K @ T)}*Matrix, type=mass\n{triangle(T.T @ M @ T)}")
    reduce(folder, "--import", "substructure", "modes.mtx", "--faces", "block.inp", "-o", "theirs.cbr.h5")
    reduce(folder, "block.inp", "--interface", "x_max", "--modes", "3", *OURS, "-o", "ours.cbr.h5")
    theirs, ours = matrices(folder / "theirs.cbr.h5"), matrices(folder / "ours.cbr.h5")
    for one, other in zip(theirs[:2], ours[:2]):
        close(one, other, 1e-12)
    np.testing.assert_allclose(theirs[3], ours[3], rtol=1e-11)
    close(np.abs(theirs[2]), np.abs(ours[2]), 1e-10)


def check_refusals(folder):
    whole = (folder / "guyan.mtx").read_text()
    cases = [("substructure.mtx", ["TYPE=MASS", "matrix storage"], None),
             ("odd.mtx", ["*MATRIX, TYPE=MASS", "74 numbers, expected 78"], "".join(whole.splitlines(True)[:-1])),
             ("odd.mtx", ["*MATRIX, TYPE=STIFFNESS", "expected 78"], whole.replace("0.1601041191094E+09,", "", 1)),
             ("odd.mtx", ["odd.mtx:19:", "VISCOUS"], whole.replace("TYPE=STIFFNESS", "TYPE=VISCOUS")),
             ("odd.mtx", ["odd.mtx:20:", "0.1601x"], whole.replace("0.1601", "0.1601x", 1)),
             ("odd.mtx", ["node 12 of 11"], whole.replace("7,         7,\n", "7,\n", 1)),
             ("odd.mtx", ["dof 4 of node 2"], whole.replace("3,         3\n", "3,         4\n", 1)),
             ("odd.mtx", ["place 1 found", "above 2"], whole.replace("         3,         3\n", "         1,         3\n", 1)),
             ("odd.mtx", ["no *USER ELEMENT"], whole.replace("*USER ELEMENT", "*ELEMENT", 1)),
             ("odd.mtx", ["block.inp: has no node 99"], whole.replace("  2,         2,         2,", " 99,        99,        99,", 1))]
    for name, words, text in cases:
        if text is not None:
            (folder / name).write_text(text)
        error = reduce(folder, "--import", "substructure", name, "--faces", "block.inp", "-o", "odd.cbr.h5", expect=2)
        assert error.count("\n") == 1 and all(word in error for word in words), (words, error)
    error = reduce(folder, "--import", "substructure", "guyan.mtx", "-o", "odd.cbr.h5", expect=2)
    assert "--faces" in error and error.count("\n") == 1, error
    for suffix, old, new, words in (("dof", "1.1\n", "1.7\n", ["block.dof:1:", "dof 7"]), ("dof", "1.1\n", "1\n", ["block.dof:1:"]),
                                    ("sti", "1 1 ", "1 49 ", ["block.sti:1:", "row 49", "1 to 48"]),
                                    ("mas", "1 2 ", "1 1 ", ["block.mas:2:", "twice"]), ("mas", "1 1 ", "1 ", ["block.mas:1:"])):
        file = folder / f"block.{suffix}"
        kept = file.read_text()
        file.write_text(kept.replace(old, new, 1))
        error = reduce(folder, "--import", "matrix-storage", "block", "--faces", "block.inp", "-o", "odd.cbr.h5", expect=2)
        assert error.count("\n") == 1 and all(word in error for word in words), (words, error)
        file.write_text(kept)
    (folder / "block.mas").unlink()
    error = reduce(folder, "--import", "matrix-storage", "block", "--faces", "block.inp", "-o", "odd.cbr.h5", expect=2)
    assert "block.mas: no such file" in error and "--export" not in error, error
    assert not (folder / "odd.cbr.h5").exists()


def check_run(folder):
    """*MATRIX ASSEMBLE with a density somewhere, as CalculiX asks of every model that vibrates."""
    program = shutil.which("ccx")
    version = subprocess.run([program, "-v"], capture_output=True, text=True).stdout if program else ""
    number = re.search(r"Version (\d+)\.(\d+)", version)
    if number is None or (int(number[1]), int(number[2])) < (2, 21):
        return "no CalculiX of 2.21 or later to run it in"
    reduce(folder, "block.inp", "--interface", "x_max", "--modes", "12", *OURS, "-o", "run.cbr.h5")
    reduce(folder, "--export", "mtx", "run.cbr.h5", "-o", "run")
    (folder / "job.inp").write_text("*INCLUDE, INPUT=run.ccx.inp\n*MATERIAL, NAME=NONE\n*ELASTIC\n1., 0.\n*DENSITY\n1.\n"
                                    "*STEP\n*FREQUENCY\n10\n*END STEP\n")
    done = subprocess.run([program, "job"], cwd=folder, capture_output=True, text=True)
    assert "Job finished" in done.stdout, done.stdout[-500:]
    lines = [line.split() for line in (folder / "job.dat").read_text().splitlines()]
    theirs = [float(line[3]) for line in lines if len(line) == 5 and line[0].isdigit()][6:10]
    ours = re.search(r"free part: ([\d., ]+) Hz", reduce(folder, "--info", "run.cbr.h5")).group(1).split(", ")
    np.testing.assert_allclose(theirs[:3], [float(f) for f in ours[:3]], rtol=1e-5)
    return f"ran in CalculiX {number[1]}.{number[2]}"


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file in FILES.iterdir():
            shutil.copy(file, folder)
        check_storage(folder)
        check_substructure(folder)
        check_refusals(folder)
        print(check_run(folder))


if __name__ == "__main__":
    main()
