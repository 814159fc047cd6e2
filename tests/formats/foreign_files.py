#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A stranger's folder does a user no harm: the programs replace no files but their own, follow no links out of the folder, and run
no code that lies beside a mesh. Names that results cannot hold are refused before the first step.
usage: foreign_files.py CBR_REDUCE CBR_SKIN CBR_DYN PLUGIN, a library that makes the file $CBR_PLUGIN_RAN as it is loaded.
Exit 77 without gmsh or h5py."""
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
from running import ended, h5py  # noqa: E402
from running import run as run_program  # noqa: E402

PLUGIN = sys.argv[4]
REDUCE, SKIN, DYN = (os.path.abspath(program) for program in sys.argv[1:4])
MATERIAL = ["--youngs-modulus", "1e4", "--poissons-ratio", "0.3", "--density", "1"]
BOX = """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
Physical Volume("v") = {1};
Physical Surface("c") = {1};
Mesh.MeshSizeMax = 0.5;
"""


def run(folder, program, *arguments, expect=0, words=(), environment=None):
    error = run_program(folder, program, *arguments, expect=expect, env={**os.environ, **(environment or {})})
    assert not expect or error.count("\n") == 1, error
    for word in words:
        assert word in error, (word, error)
    return error


def write_mesh(folder, name="box.msh", *options):
    subprocess.run(["gmsh", "-3", "-v", "0", "box.geo", *options, "-o", name], cwd=folder, check=True, stdout=subprocess.DEVNULL)


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
materials: {s: {youngs_modulus: 1.0e4, poissons_ratio: 0.3, density: 1}}
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


def check_scripts(folder):
    """gmsh runs .opt files beside what it reads, and those of the home folder: here it finds none."""
    for suffix, form in (("unv", "unv"), ("vtk", "vtk")):
        write_mesh(folder, f"box.{suffix}", "-format", form)
        home = folder / f"home-{suffix}"
        home.mkdir()
        script = f'SystemCall "touch {folder}/ran";\n'
        for name in (f"box.{suffix}.opt", ".gmshrc", ".gmsh-options", f"home-{suffix}/.gmshrc", f"home-{suffix}/.gmsh-options"):
            (folder / name).write_text(script)
        scratch = folder / f"scratch-{suffix}"
        scratch.mkdir()
        for variable in ("HOME", "GMSH_HOME"):
            words = ["--interface", "c" if suffix == "unv" else "nothing", "--modes", "2", *MATERIAL, "-o", "u.cbr.h5"]
            run(folder, REDUCE, f"box.{suffix}", *words, expect=0 if suffix == "unv" else 2,
                environment={variable: str(home), "TMPDIR": str(scratch)})
        assert not (folder / "ran").exists(), suffix
        assert list(scratch.iterdir()) == []


def check_hdf5(folder):
    """A file names filters, and files of its values, at will: no plugin is loaded, and no other file is read."""
    reduce(folder)
    plugins = folder / "plugins"
    plugins.mkdir()
    shutil.copy(PLUGIN, plugins / "libfilter.so")
    with h5py.File(folder / "x.cbr.h5") as file:
        K = file["matrices/K_cc"][()]
    with h5py.File(folder / "x.cbr.h5") as file, h5py.File(folder / "filtered.cbr.h5", "w") as out:
        objects = [""]
        file.visit(objects.append)
        for name in objects:
            source, filtered = file[f"/{name}"], name == "matrices/K_cc"
            if isinstance(source, h5py.Dataset):
                made = out.create_dataset(name, data=source[()], **({"chunks": K.shape, "compression": "gzip"} if filtered else {}))
            else:
                made = out.require_group(f"/{name}")
            for key, value in source.attrs.items():
                made.attrs[key] = value
    data = (folder / "filtered.cbr.h5").read_bytes()
    at = data.index(b"deflate\0")
    assert data[at - 8:at - 6] == b"\1\0", data[at - 8:at]
    (folder / "filtered.cbr.h5").write_bytes(data[:at - 8] + (32015).to_bytes(2, "little") + data[at - 6:])
    environment = {"HDF5_PLUGIN_PATH": str(plugins), "CBR_PLUGIN_RAN": str(folder / "ran")}
    run(folder, REDUCE, "--export", "dmig", "filtered.cbr.h5", "-o", "m", expect=2, words=("filtered.cbr.h5", "K_cc"), environment=environment)
    assert not (folder / "ran").exists()
    K.tofile(folder / "mine.bin")
    for name in ("link", "data"):
        shutil.copy(folder / "x.cbr.h5", folder / "other.cbr.h5")
        with h5py.File(folder / "other.cbr.h5", "r+") as file:
            attributes = dict(file["matrices/K_cc"].attrs)
            del file["matrices/K_cc"]
            if name == "link":
                file["matrices/K_cc"] = h5py.ExternalLink("x.cbr.h5", "/matrices/K_cc")
            else:
                file.create_dataset("matrices/K_cc", K.shape, K.dtype, external=[("mine.bin", 0, h5py.h5f.UNLIMITED)])
                file["matrices/K_cc"].attrs.update(attributes)
        run(folder, REDUCE, "--export", "dmig", "other.cbr.h5", "-o", "m", expect=2, words=("other.cbr.h5: /matrices/K_cc", "another file"))


SCENE = """
materials: {s: {youngs_modulus: 1.0e4, poissons_ratio: 0.3, density: 1}}
components: {box: {mesh: box.msh, material: s}}
instances: {a: {component: box, as: mesh, velocity: [1, 0, 0]}}
time: {end: 1.0e-2}
"""


def check_names(folder):
    """Names that results cannot hold are refused before the first step, in one line."""
    (folder / "box.geo").write_text(BOX.replace('Physical Surface("c") = {1};', 'Physical Surface("c/t") = {1};\nPhysical Surface("c_t") = {2};'))
    write_mesh(folder)
    history = SCENE + "output: {history: [a.c/t, a.c_t]}\nsweep: {from_hz: 0.1, to_hz: 1}\nloads: [{instance: a, surface: c_t, force: [1, 0, 0]}]\n"
    (folder / "scene.yaml").write_text(history)
    for options in ((), ("--sweep",)):
        run(folder, DYN, "scene.yaml", *options, "-o", "r.h5", expect=2, words=("'a.c/t' and 'a.c_t'", "one group"))
    assert not (folder / "r.h5").exists()
    (folder / "scene.yaml").write_text(history.replace("a.c/t, ", ""))
    run(folder, DYN, "scene.yaml", "-o", "r.h5")
    long = "o" * 300
    for name, words in ((long, "300 bytes, at most 255"), (long[:290] + ".h5", "293 bytes"), ("r\x07.h5", "control character (code 7)"),
                        (os.fsdecode(b"r\xff.h5"), "not UTF-8")):
        run(folder, DYN, "scene.yaml", "-o", name, expect=2, words=(words, "name"))
        run(folder, REDUCE, "box.msh", "--interface", "c_t", "--modes", "2", *MATERIAL, "-o", name, expect=2, words=(words,))
        run(folder, SKIN, "box.msh", "--sideset", "c_t", "-o", name.removesuffix(".h5") + ".msh", expect=2, words=("name",))
    for name, words in ((rb'"a\x07"', "control character (code 7)"), (rb'"a\0"', "code 0"), (b"a\xe9", "not UTF-8"), (rb'"a\nb"', "code 10")):
        (folder / "odd.yaml").write_bytes(SCENE.encode().replace(b"instances: {a:", b"instances: {" + name + b":"))
        run(folder, DYN, "odd.yaml", "-o", "odd.h5", expect=2, words=("odd.yaml:4: ", words))
    (folder / "odd.yaml").write_text(SCENE.replace("{a:", "{\u00e4\u2192\U0001f600:"))
    run(folder, DYN, "odd.yaml", "-o", "odd.h5")


def check_tables(folder):
    """A table that Excel saved begins with a mark."""
    for name, head in (("plain", b""), ("excel", b"\xef\xbb\xbf"), ("names", b"\xef\xbb\xbftime,value\n"), ("rem", b"\xef\xbb\xbf# force\n")):
        (folder / "force.csv").write_bytes(head + b"0,0\r\n0.1,1\r\n")
        (folder / "scene.yaml").write_text(SCENE + "loads: [{instance: a, surface: c, force: [1, 0, 0], history: {file: force.csv}}]\n")
        run(folder, DYN, "scene.yaml", "-o", f"{name}.h5")
        with h5py.File(folder / f"{name}.h5") as file, h5py.File(folder / "plain.h5") as plain:
            assert (file["instances/a/momentum"][()] == plain["instances/a/momentum"][()]).all(), name


def told(folder, *command):
    done = subprocess.run([DYN, *command], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stderr


def check_ties(folder):
    """A tie that holds two of four nodes is a hinge; contact that --modes leaves out is told, and nothing of a whole tie."""
    (folder / "box.geo").write_text(BOX.replace("0.5;", "1;\nTransfinite Curve{:} = 2; Transfinite Surface{:}; Transfinite Volume{:}; "
                                                "Recombine Surface{:};").replace('Physical Surface("c") = {1};', """
Physical Surface("low") = Surface In BoundingBox{-0.1, -0.1, -0.1, 0.1, 1.1, 1.1};
Physical Surface("high") = Surface In BoundingBox{0.9, -0.1, -0.1, 1.1, 1.1, 1.1};"""))
    write_mesh(folder)
    for shift, free, nodes in ((0, 6, 4), (0.5, 7, 2)):
        (folder / "tie.yaml").write_text(SCENE.replace("time:", f"""  b: {{component: box, as: mesh, position: [1, {shift}, 0]}}
contact: [{{between: [a.high, b.low], tied: true}}]
time:""").replace("instances: {a: {component: box, as: mesh, velocity: [1, 0, 0]}}", "instances:\n  a: {component: box, as: mesh}")
                                         + "output: {history: [b.high]}\nsweep: {from_hz: 0.01, to_hz: 0.02}\n"
                                           "loads: [{instance: b, surface: high, force: [1, 0, 0]}]\n")
        modes = ended(folder, DYN, "tie.yaml", "--modes", "9")
        assert sum(float(row.split(",")[2]) == 0 for row in modes.stdout.split()[1:]) == free, modes.stdout
        for command in (("tie.yaml", "--modes", "9"), ("tie.yaml", "--sweep", "-o", f"s{nodes}.h5"), ("tie.yaml", "-o", f"r{nodes}.h5")):
            hinge = [line for line in told(folder, *command).splitlines() if "a hinge" in line]
            assert len(hinge) == (nodes == 2), (command, hinge)
            assert not hinge or ("2 of the 4 nodes" in hinge[0] and "warning" in hinge[0]), hinge
    text = (folder / "tie.yaml").read_text()
    (folder / "tie.yaml").write_text(text.replace("tied: true", "enforcement: impulse"))
    assert "note: contact that is not tied is left out" in told(folder, "tie.yaml", "--modes", "3")


def main():
    if shutil.which("gmsh") is None:
        print("skipped: gmsh is not there")
        return 77
    for check in (check_replaced_files, check_links, check_scripts, check_hdf5, check_names, check_tables, check_ties):
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            (folder / "box.geo").write_text(BOX)
            write_mesh(folder)
            check(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
