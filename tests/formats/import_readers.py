#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of other codes made to superelements: our own exports come back with the same matrices, the mesh gives the faces, and damaged
files are refused with one line. usage: import_readers.py CBR_REDUCE CBR_DYN. Exit 77 without h5py or numpy."""
import sys

try:
    from scipy.io import netcdf_file
except ImportError:
    netcdf_file = None

sys.dont_write_bytecode = True
from running import MATERIAL, check_in_turn, contents, h5py, np, run, write_mesh  # noqa: E402

FILES = {"matrix-market": ["out.K.mtx", "out.M.mtx"], "dmig": ["out.dmig"], "op4": ["out.op4"],
         "abaqus": ["out.K.abaqus.mtx", "out.M.abaqus.mtx"], "mtx": ["out.K.ccx.mtx", "out.M.ccx.mtx"]}
SCENE = """
components: {block: {superelement: NAME.cbr.h5}}
instances:
  left: {component: block, position: [-1.0001, 0, 0], velocity: [20, 0, 0]}
  right: {component: block, position: [1, 0, 0], mirror: x}
contact: [{between: [left.contact, right.contact]}]
time: {end: 6.0e-4}
output: {every: 1.0e-5, history: [left.contact, right.contact]}
"""


def reduce(folder, *arguments, expect=0):
    return run(folder, sys.argv[1], *arguments, expect=expect)


def check_formats(folder):
    write_mesh(folder / "box.msh")
    reduce(folder, "box.msh", "--interface", "contact", "--modes", "7", *MATERIAL, "-o", "box.cbr.h5")
    original = contents(folder / "box.cbr.h5")
    for name in FILES:
        reduce(folder, "--export", name, "box.cbr.h5", "-o", "out")
        digits = 1e-9 if name == "dmig" else 0
        for given in ("out", FILES[name][0]):
            reduce(folder, "--import", name, given, "--faces", "box.msh", "-o", f"{name}.cbr.h5")
            back = contents(folder / f"{name}.cbr.h5")
            for key, values in original.items():
                group = key.split("/")[0]
                if group in ("matrices", "dofs", "nodes", "interface", "nodesets"):
                    tolerance = digits if group == "matrices" else 0
                    np.testing.assert_allclose(back[key], values, rtol=tolerance, atol=0, err_msg=f"{name} {key}")
            np.testing.assert_allclose(back["rigid_body/mass"], original["rigid_body/mass"], rtol=1e-8)
            np.testing.assert_allclose(back["rigid_body/center"], original["rigid_body/center"], rtol=0, atol=1e-8)
            np.testing.assert_allclose(back["rigid_body/inertia"], original["rigid_body/inertia"], rtol=0,
                                       atol=1e-7 * np.abs(original["rigid_body/inertia"]).max())
        assert list(folder.glob("*.dofs.csv")) and not list(folder.glob(".cbr-*"))
    for exported, name, file in (("op4-binary", "op4", "out"), ("sierra", "sierra", "out.nc"), ("sierra-older", "sierra", "out.nc")):
        reduce(folder, "--export", exported, "box.cbr.h5", "-o", "out")
        reduce(folder, "--import", name, file, "--faces", "box.msh", "-o", "back.cbr.h5")
        back = contents(folder / "back.cbr.h5")
        for key, values in original.items():
            if key.split("/")[0] in ("matrices", "dofs", "nodes", "interface", "nodesets"):
                np.testing.assert_array_equal(back[key], values, err_msg=f"{exported} {key}")
    if netcdf_file:  # as older files of Sierra/SD have it
        with netcdf_file(folder / "out.nc", "a") as file:
            file.createDimension("outputs", 6)
            file.createVariable("OTM", "d", ("outputs", file.variables["Kr"].dimensions[0]))[:] = 1
            file.createDimension("NumNode_out", 1)
            file.createVariable("OutMap", "i", ("NumNode_out",))[:] = 1
        told = reduce(folder, "--import", "sierra", "out.nc", "--faces", "box.msh", "-o", "back.cbr.h5")
        assert "out.nc: its OTM is left out" in told and told.count("\n") == 1, told
    with h5py.File(folder / "dmig.cbr.h5") as file:
        assert file["provenance"].attrs["import"] == "dmig" and file["interface/contact/faces"].attrs["kind"] == "quad4"
    # The same bytes again; without a mesh no faces, and a warning
    first = (folder / "abaqus.cbr.h5").read_bytes()
    reduce(folder, "--import", "abaqus", FILES["abaqus"][0], "--faces", "box.msh", "-o", "abaqus.cbr.h5")
    assert (folder / "abaqus.cbr.h5").read_bytes() == first
    warning = reduce(folder, "--import", "abaqus", "out")
    assert "give --faces MESH" in warning and "interface" not in contents(folder / "out.cbr.h5"), warning


def op4_text(matrices, is_big):
    """Sparse columns in strings of at most two entries, as Nastran's OUTPUT4 writes them in text."""
    lines = []
    for name, A in matrices.items():
        rows, columns = A.shape
        lines.append(f"{columns:8d}{-rows if is_big else rows:8d}{6:8d}{2:8d}{name:<8s}1P,3E24.16")
        for j in range(columns):
            strings = [(i, A[i:i + 2, j]) for i in range(0, rows, 2) if A[i:i + 2, j].any()]
            if strings:
                lines.append(f"{j + 1:8d}{0:8d}{sum(2 * len(s) + 1 + is_big for _, s in strings):8d}")
            for i, s in strings:
                length = 2 * len(s) + 1
                lines.append(f"{length:8d}{i + 1:8d}" if is_big else f"{i + 1 + 65536 * length:8d}")
                lines.append("".join(f"{x:24.16E}" for x in s))
        lines += [f"{columns + 1:8d}{1:8d}{1:8d}", f"{1:24.16E}"]
    return "\n".join(lines) + "\n"


def op4_binary(matrices, is_big):
    def record(words, values=b""):
        body = np.array(words, "<i4").tobytes() + values
        return len(body).to_bytes(4, "little") + body + len(body).to_bytes(4, "little")

    out = b""
    for name, A in matrices.items():
        rows, columns = A.shape
        out += record([columns, -rows if is_big else rows, 6, 2], name.ljust(8).encode())
        for j in range(columns):
            strings = b""
            for i in range(0, rows, 2):
                s = A[i:i + 2, j]
                length = 2 * len(s) + 1
                mark = [length, i + 1] if is_big else [i + 1 + 65536 * length]
                strings += (np.array(mark, "<i4").tobytes() + s.astype("<f8").tobytes()) * bool(s.any())
            if strings:
                out += record([j + 1, 0, len(strings) // 4], strings)
        out += record([columns + 1, 1, 1], np.ones(1).tobytes())  # words counted as some versions do
    return out


def check_external(folder):
    """EXTSEOUT of Nastran: .op4 with .pch or .asm, sparse or dense, text or binary, with one node's displacements along axes of its own."""
    with h5py.File(folder / "box.cbr.h5") as file:
        K_cc, M_cc, M_kc = (file[f"matrices/{name}"][()] for name in ("K_cc", "M_cc", "M_kc"))
        eigenvalues, nodes, x = file["matrices/eigenvalues"][()], file["nodes/id"][()], file["nodes/coordinates"][()]
    c, k = len(K_cc), len(eigenvalues)
    K, M = np.block([[K_cc, np.zeros((c, k))], [np.zeros((k, c)), np.diag(eigenvalues)]]), np.block([[M_cc, M_kc.T], [M_kc, np.eye(k)]])
    turned, modal = 3, range(9001, 9001 + k)
    axes = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])  # columns: x along z, y along x
    T = np.eye(c + k)
    T[3 * turned:3 * turned + 3, 3 * turned:3 * turned + 3] = axes
    matrices = {"KAA": T.T @ K @ T, "MAA": T.T @ M @ T, "BAA": np.zeros((1, 1)), "MUG1": np.ones((5, c + k))}
    system = ["CORD2R*              70               0 1.000000000E+00 0.", "*       0.               1.000000000E+00 1.000000000E+00 0.",
              "*       1.000000000E+00 0.000000000E+00 1.000000000E+00"]
    grids = [f"GRID*   {n:16d}{0:16d}{a:16.9E}{b:16.9E}\n*       {z:16.9E}{70 if i == turned else 0:16d}"
             for i, (n, (a, b, z)) in enumerate(zip(nodes, x))]

    def card(name, numbers):  # small fields
        fields = [f"{number:>8}" for number in numbers]
        return "\n".join(f"{name if i == 0 else '':<8s}" + "".join(fields[i:i + 8]) for i in range(0, len(fields), 8))

    spoint = card("SPOINT", [9001, "THRU", modal[-1]])
    rows = [number for n in nodes for number in (n, 123)] + [number for n in modal for number in (n, 0)]
    here = [number for n in nodes for number in (n, n)] + [""] * (2 * len(nodes) % 8 and 8 - 2 * len(nodes) % 8)
    pch = ["$ EXTSEOUT", "BEGIN SUPER     101", *system, card("EXTRN", rows), *grids, spoint, card("DTI", ["SELOAD", 0, 1130, "ENDREC"])]
    asm = ["SEBULK       101  EXTOP4          MANUAL                     101", *system,
           card("SECONCT", [101, 0, "", "NO", "", "", "", "", *here, 9001, "THRU", modal[-1], 9001, "THRU", modal[-1]]), *grids, spoint]
    original = contents(folder / "box.cbr.h5")
    for table, lines in ((".pch", pch), (".asm", asm)):
        (folder / f"part{table}").write_text("\n".join(lines) + "\n")
        for is_big in (False, True):
            for write in (op4_text, op4_binary):
                data = write(matrices, is_big)
                (folder / "part.op4").write_bytes(data if isinstance(data, bytes) else data.encode())
                told = reduce(folder, "--import", "op4", f"part{table}", "--faces", "box.msh", "-o", "part.cbr.h5")
                assert not told, told
                back = contents(folder / "part.cbr.h5")
                for key in ("matrices/K_cc", "matrices/M_cc", "matrices/M_kc", "matrices/eigenvalues", "nodes/id", "interface/contact/faces"):
                    np.testing.assert_allclose(back[key], original[key], rtol=1e-14, atol=1e-14 * np.abs(original[key]).max(), err_msg=key)
        for first, second in (("KAA", "MAA"), ("MAA", "KAA")):  # one of them without the modal dofs
            (folder / "part.op4").write_text(op4_text({first: matrices[first][:c, :c], second: matrices[second]}, True))
            assert "found, expected" in reduce(folder, "--import", "op4", "part", "-o", "none.cbr.h5", expect=2)
        (folder / "part.op4").write_text(op4_text({**matrices, "BAA": np.ones((1, 1))}, True))
        assert "damping matrix is left out" in reduce(folder, "--import", "op4", "part", "--faces", "box.msh", "-o", "part.cbr.h5")
        for text, words in (("\n".join(lines).replace("     123", "      19"), "has dofs 19"),
                            ("\n".join(line for line in lines if not line.startswith("CORD2R")), "is no CORD2R"),
                            ("\n".join(lines[:3]), "no EXTRN and no SECONCT"), (f"GRID,{nodes[0]},5,0.,0.,0.", "expected 0 (basic)"),
                            ("\n".join(lines).replace(f"GRID*   {nodes[0]:16d}", f"GRID*   {777:16d}"), f"GRID {nodes[0]} is not in the file")):
            if "123" not in "".join(lines) and "dofs 19" in words:
                continue
            (folder / f"part{table}").write_text(text + "\n")
            error = reduce(folder, "--import", "op4", "part", "-o", "none.cbr.h5", expect=2)
            assert words in error and error.count("\n") == 1, (words, error)
        (folder / f"part{table}").unlink()
    (folder / "part.op4").unlink()
    # EXTSEOUT(EXTBULK,DMIGPCH): matrices in the .pch, too
    entry = "{:8s}{:16d}{:16d}{:16.9E}"
    ids = [(n, dof) for n in nodes for dof in (1, 2, 3)] + [(n, 0) for n in modal]
    for name, A in (("KAAX", matrices["KAA"]), ("MAAX", matrices["MAA"]), ("BAAX", np.eye(1)), ("VAX", np.eye(2))):
        pch.append(f"DMIG    {name:8s}       0       6       2       0")
        for j in range(len(A)):
            pch.append("DMIG*   {:16s}{:16d}{:16d}".format(name, *ids[j]))
            pch += [entry.format("*", *ids[i], A[i, j]).replace("E", "D") for i in range(j, len(A)) if A[i, j]]
    (folder / "part.pch").write_text("\n".join(pch) + "\n")
    assert "damping matrix is left out" in reduce(folder, "--import", "dmig", "part.pch", "--faces", "box.msh", "-o", "part.cbr.h5")
    back = contents(folder / "part.cbr.h5")
    for key in ("matrices/K_cc", "matrices/M_cc", "matrices/M_kc", "matrices/eigenvalues"):
        np.testing.assert_allclose(back[key], original[key], rtol=0, atol=1e-9 * np.abs(original[key]).max(), err_msg=key)
    (folder / "part.pch").unlink()
    (folder / "part.cbr.h5").unlink()


def check_run(folder):
    """An impact with the file as it was reduced, and with the one that came back."""
    results = {}
    for name in ("box", "matrix-market", "dmig"):
        (folder / "scene.yaml").write_text(SCENE.replace("NAME", name))
        run(folder, sys.argv[2], "scene.yaml", "-o", "results.h5", "--threads", "1")
        results[name] = contents(folder / "results.h5")
    assert results["box"]["contact/active"].max() > 0
    for name, tolerance in (("matrix-market", 1e-8), ("dmig", 1e-5)):
        for key in ("surfaces/left.contact/mean_velocity", "instances/right/momentum", "energy/total"):
            one, other = results["box"][key], results[name][key]
            np.testing.assert_allclose(other, one, rtol=0, atol=tolerance * np.abs(one).max(), err_msg=f"{name} {key}")


def damage(text, how):
    lines = text.splitlines(keepends=True)
    middle = len(lines) // 2
    if how == "cut":
        return text[: len(text) // 2]
    if how == "without end":
        return text[:-3]
    if how == "without half":
        return "".join(lines[:middle])
    if how == "twice":
        return text + lines[-1]
    if how == "word":
        return "".join(lines[:-1]) + lines[-1][:-2] + "x\n"
    return {"empty": "", "binary": "\0\x01" * 400, "nan": "".join(lines[:-1]) + lines[-1][:-2] + " nan\n"}[how]


def check_damage(folder):
    before = sorted(p.name for p in folder.iterdir())
    for name, files in FILES.items():
        reduce(folder, "--export", name, "box.cbr.h5", "-o", "out")
        for file in [*files, "out.dofs.csv"]:
            whole = (folder / file).read_text()
            for how in ("cut", "without end", "without half", "twice", "word", "empty", "binary", "nan"):
                (folder / file).write_text(damage(whole, how))
                error = reduce(folder, "--import", name, "out", "--faces", "box.msh", "-o", "damaged.cbr.h5", expect=2)
                assert error.count("\n") == 1 and error.startswith("cbr-reduce: "), (file, how, error)
                assert not (folder / "damaged.cbr.h5").exists()
            (folder / file).unlink()
            error = reduce(folder, "--import", name, "out", "-o", "damaged.cbr.h5", expect=2)
            assert f"{file}: no such file" in error and error.count("\n") == 1, error
            (folder / file).write_text(whole)
    reduce(folder, "--export", "op4-binary", "box.cbr.h5", "-o", "out")
    whole = (folder / "out.op4").read_bytes()
    for changed in (whole[:40], whole[:-3], whole[:len(whole) // 2], whole + whole[:100], whole[:30] + b"\xff" * 8 + whole[38:],
                    whole[:4] + b"\7" + whole[5:]):
        (folder / "out.op4").write_bytes(changed)
        error = reduce(folder, "--import", "op4", "out", "-o", "damaged.cbr.h5", expect=2)
        assert error.count("\n") == 1 and "out.op4" in error, error
    assert sorted(p.name for p in folder.iterdir()) == before


def check_missing_lines(folder):
    """A file of DMIG says how many entries it has; of other text the physics tell, as far as they can. Without a mesh."""
    reduce(folder, "--export", "dmig", "box.cbr.h5", "-o", "out")
    lines = (folder / "out.dmig").read_text().splitlines(keepends=True)
    for matrix in ("K", "M"):
        first = lines.index(next(line for line in lines if line.startswith(f"DMIG    {matrix}AAX")))
        for at in (first + 2, first + 3, first + 40):
            (folder / "out.dmig").write_text("".join(lines[:at] + lines[at + 1:]))
            error = reduce(folder, "--import", "dmig", "out", "-o", "less.cbr.h5", expect=2)
            assert f"{matrix}AAX has" in error and "its comment says" in error and error.count("\n") == 1, error
    # As others write it, without the comment: it comes back, too
    (folder / "out.dmig").write_text("".join(line for line in lines if " entries" not in line))
    reduce(folder, "--import", "dmig", "out", "--faces", "box.msh", "-o", "less.cbr.h5")
    reduce(folder, "--export", "abaqus", "box.cbr.h5", "-o", "out")
    for name, other, words in (("out.M.abaqus.mtx", 1.001, "entries of M are missing"), ("out.K.abaqus.mtx", 1 + 1e-5, "an entry may be missing")):
        lines = (folder / name).read_text().splitlines(keepends=True)
        fields = lines[1].split(",")  # of the first node, beside the diagonal
        (folder / name).write_text("".join([lines[0], *lines[2:]]))
        reduce(folder, "--import", "abaqus", "out", "-o", "less.cbr.h5", expect=2)
        fields[-1] = f" {float(fields[-1]) * other!r}\n"
        (folder / name).write_text("".join([lines[0], ",".join(fields), *lines[2:]]))
        told = reduce(folder, "--import", "abaqus", "out", "-o", "less.cbr.h5", expect=2 if "M" in name else 0)
        assert words in told, told
        (folder / name).write_text("".join(lines))
    (folder / "less.cbr.h5").unlink()


def check_refusals(folder):
    def refused(words, *arguments):
        error = reduce(folder, *arguments, expect=2)
        assert error.count("\n") == 1 and all(word in error for word in words), error

    refused(["'nastran' found", "sierra, matrix-market, dmig, op4, abaqus"], "--import", "nastran", "out")
    refused(["--modes", "--import"], "--import", "dmig", "out", "--modes", "7")
    refused(["--faces", "--import"], "box.msh", "--faces", "box.msh")
    refused(["out.dmig", "would replace"], "--import", "dmig", "out", "-o", "out.dmig")
    refused(["box.msh"], "--import", "dmig", "out", "--faces", "box.msh", "-o", "box.msh")
    refused(["box.cbr.h5"], "--import", "sierra", "box.cbr.h5", "-o", "new.cbr.h5")
    refused(["none.exo"], "--import", "dmig", "out", "--faces", "none.exo", "-o", "new.cbr.h5")
    text = (folder / "box.msh").read_text()
    (folder / "moved.msh").write_text(text.replace("1 0.0 0.0 0.0", "1 0.1 0.0 0.0").replace(" 1.0 0.5 0.5", " 1.01 0.5 0.5"))
    refused(["moved.msh", "away from its place"], "--import", "dmig", "out", "--faces", "moved.msh", "-o", "new.cbr.h5")
    # Other physics: modes of another mass, coupled stiffness, a part that is held
    rows = (folder / "out.dofs.csv").read_text().splitlines()
    n = len(rows) - 1
    reduce(folder, "--export", "matrix-market", "box.cbr.h5", "-o", "out")
    for file, change, words in (
        ("out.M.mtx", (n, n, 2.0), ("expected 1", "modal coordinate")),
        ("out.K.mtx", (n, n, -2.0), ("modal coordinate", "positive")),
        ("out.K.mtx", (1, 1, 1e13), ("resists rigid translations",)),
    ):
        whole = (folder / file).read_text()
        i, j, value = change
        lines = whole.splitlines()
        lines[3:] = [line if not line.startswith(f"{i} {j} ") else f"{i} {j} {value!r}" for line in lines[3:]]
        (folder / file).write_text("\n".join(lines) + "\n")
        refused([*words, "out"], "--import", "matrix-market", "out", "-o", "new.cbr.h5")
        (folder / file).write_text(whole)
    assert not (folder / "new.cbr.h5").exists()


if __name__ == "__main__":
    check_in_turn(check_formats, check_external, check_run, check_damage, check_missing_lines, check_refusals)
