#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a stranger's folder must not do to a user: the programs replace no files but their own, follow no links out of the folder, and run
no code that lies beside a mesh. usage: foreign_files.py CBR_REDUCE CBR_SKIN CBR_DYN. Exit 77 without gmsh."""
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
REDUCE, SKIN, DYN = (os.path.abspath(program) for program in sys.argv[1:4])
MATERIAL = ["--youngs-modulus", "1", "--poissons-ratio", "0.3", "--density", "1"]
BOX = """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
Physical Volume("v") = {1};
Physical Surface("c") = {1};
Mesh.MeshSizeMax = 0.5;
"""


def run(folder, program, *arguments, expect=0, words=(), environment=None):
    done = subprocess.run([program, "-q", *arguments], cwd=folder, capture_output=True, text=True, errors="replace",
                          env={**os.environ, **(environment or {})})
    assert done.returncode == expect, (program, arguments, done.returncode, done.stderr)
    if expect:
        assert done.stderr.count("\n") == 1, done.stderr
    for word in words:
        assert word in done.stderr, (word, done.stderr)
    return done.stderr


def reduce(folder, mesh="box.msh", out="x.cbr.h5", **options):
    return run(folder, REDUCE, mesh, "--interface", "c", "--modes", "2", *MATERIAL, "-o", out, **options)


def refused(folder, file, text, *command, **options):
    """The command replaces `file` where it is ours, or empty, and not where it is not."""
    run(folder, *command)
    run(folder, *command)
    ours = (folder / file).read_bytes()
    (folder / file).write_bytes(text)
    run(folder, *command, expect=2, words=("exists and is", Path(file).name, "another", *options.get("words", ())))
    assert (folder / file).read_bytes() == text, file
    (folder / file).write_bytes(b"")
    run(folder, *command)
    # Results tell their wall times
    assert file.endswith(".h5") or (folder / file).read_bytes() == ours, file


def check_replaced_files(folder):
    """Every output of the programs, in the place of a file of another kind, and of a like one of the user's own."""
    reduce(folder)
    box = (folder / "box.msh").read_bytes()
    refused(folder, "skinned.msh", box, SKIN, "box.msh", "--sideset", "c", "-o", "skinned.msh")
    run(folder, SKIN, "box.msh", "--sideset", "c", "-o", "skinned.exo")
    refused(folder, "skinned.exo", (folder / "skinned.exo").read_bytes().replace(b"cbr\0", b"me \0", 1), SKIN, "box.msh", "--sideset", "c",
            "-o", "skinned.exo")
    for name, suffix, mine in (("dmig", ".dmig", b"DMIG    KAAX           0       6       2       0\n"),
                               ("matrix-market", ".K.mtx", b"%%MatrixMarket matrix coordinate real symmetric\n1 1 1\n1 1 1\n"),
                               ("abaqus", ".K.abaqus.mtx", b"1, 1, 2, 1, 3.0\n"),
                               ("mtx", ".ccx.inp", b"*NODE\n1, 0, 0, 0\n"),
                               ("op4", ".op4", b"       1       1       6       2MINE    1P,3E24.16\n"),
                               ("op4-binary", ".op4", b"\x18\0\0\0notes"),
                               ("sierra", ".nc", b"my notes\n"), ("dmig", ".dofs.csv", b"time,value\n0,1\n")):
        folder.joinpath("mine.op4").unlink(missing_ok=True)
        refused(folder, f"mine{suffix}", mine, REDUCE, "--export", name, "x.cbr.h5", "-o", "mine")
    # Formats without comments: only beside the table of rows of an export
    run(folder, REDUCE, "--export", "abaqus", "x.cbr.h5", "-o", "other")
    (folder / "other.dofs.csv").unlink()
    run(folder, REDUCE, "--export", "abaqus", "x.cbr.h5", "-o", "other", expect=2, words=("other.K.abaqus.mtx: exists and is not",))
    (folder / "scene.yaml").write_text("""
materials: {s: {youngs_modulus: 1, poissons_ratio: 0.3, density: 1}}
components: {box: {mesh: box.msh, material: s}}
instances: {a: {component: box, as: mesh, velocity: [1, 0, 0]}}
time: {end: 1.0e-2}
output: {fields: [displacement]}
skin: {surfaces: [a.c], mesh: shells.msh, youngs_modulus: 1, poissons_ratio: 0.3, density: 1, thickness: 1.0e-3}
""")
    refused(folder, "shells.msh", box, SKIN, "scene.yaml")
    refused(folder, "run.h5", b"my notes\n", DYN, "scene.yaml", "-o", "run.h5")
    refused(folder, "run.xdmf", b'<?xml version="1.0"?>\n<Xdmf Version="3.0">\n<Domain Name="mine">\n', DYN, "scene.yaml", "-o", "run.h5")


def check_links(folder):
    """A link that leads to a file of another folder is not followed; within the folder it is."""
    elsewhere = folder / "elsewhere"
    elsewhere.mkdir()
    run(folder, SKIN, "box.msh", "--sideset", "c", "-o", "elsewhere/ours.msh")
    ours = (elsewhere / "ours.msh").read_bytes()
    (folder / "link.msh").symlink_to("elsewhere/ours.msh")
    (folder / "gone.msh").symlink_to("elsewhere/new.msh")
    for link in ("link.msh", "gone.msh"):
        run(folder, SKIN, "box.msh", "--sideset", "c", "-o", link, expect=2, words=("is a link to", "another folder"))
    assert (elsewhere / "ours.msh").read_bytes() == ours and not (elsewhere / "new.msh").exists()
    (elsewhere / "near.msh").symlink_to("ours.msh")
    run(folder, SKIN, "box.msh", "--sideset", "c", "-o", "elsewhere/near.msh")
    assert (elsewhere / "near.msh").is_symlink()
    # A folder may be a link: it is the user who names it
    (folder / "way").symlink_to("elsewhere")
    run(folder, SKIN, "box.msh", "--sideset", "c", "-o", "way/ours.msh")


def main():
    if shutil.which("gmsh") is None:
        print("skipped: gmsh is not there")
        return 77
    for check in (check_replaced_files, check_links):
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            (folder / "box.geo").write_text(BOX)
            subprocess.run(["gmsh", "-3", "-v", "0", "box.geo", "-o", "box.msh"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
            check(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
