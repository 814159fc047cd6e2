#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields as Exodus II (`output.format: exodus`) hold what the file of fields has: read by a reader of our own for netCDF, by Debian's
libexodusii and by VTK's reader, which is ParaView's, where they are installed (libexodusii5, python3-vtk9).
usage: exodus_results.py CBR_REDUCE CBR_DYN. Exit 77 without h5py and numpy."""
import ctypes
import ctypes.util
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
from netcdf3 import Netcdf  # noqa: E402
from running import h5py, np, run, write_mesh  # noqa: E402

SCENE = """
materials: {steel: {youngs_modulus: 2.1e11, poissons_ratio: 0.3, density: 7850}}
components:
  block:
    mesh: box.msh
    material: steel
    reduction: {interface: [contact], modes: 7, recovery: true}
instances:
  left: {component: block, position: [-1.0001, 0, 0], velocity: [20, 0, 0]}
  right: {component: block, as: mesh, position: [1, 0, 0], rotation: [0, 0, 10], mirror: x}
contact: [{between: [left.contact, right.contact]}]
time: {end: 2.0e-4, step: 2.0e-6}
output: {every: 2.0e-5, fields: [displacement, velocity, stress, contact_pressure], format: FORMATCHECKPOINT}
"""
STRESSES = ["stress_" + name for name in "xx yy zz xy yz xz von_mises principal_1 principal_2 principal_3".split()]
TYPES = {"Hexahedron": "HEX8", "Quadrilateral": "SHELL4"}


def write_scene(folder, form, checkpoint=""):
    (folder / "scene.yaml").write_text(SCENE.replace("FORMAT", form).replace("CHECKPOINT", checkpoint))


def fields_of(path):
    """Of each grid its attributes and arrays, and of each step the fields."""
    with h5py.File(path) as file:
        grids = [(dict(file[f"grids/{g}"].attrs), {name: item[()] for name, item in file[f"grids/{g}"].items()})
                 for g in range(len(file["grids"]))]
        steps = [[{name: item[()] for name, item in file[f"steps/{s}/{g}"].items()} for g in range(len(grids))]
                 for s in range(len(file["times"]))]
        return file["times"][()], grids, steps


def check_exodus(path, times, grids, steps):
    file = Netcdf(path)
    assert file.attributes["title"].startswith("cbr-dyn ")
    np.testing.assert_array_equal(file["time_whole"], times)
    ids = file["node_num_map"]
    assert len(set(ids)) == len(ids) and len(set(file["elem_num_map"])) == len(file["elem_num_map"])
    points = np.stack([file["coord" + axis] for axis in "xyz"], axis=1)
    nodal = {name: file[f"vals_nod_var{i}"] for i, name in enumerate(file.strings("name_nod_var"), 1)}
    element = file.strings("name_elem_var")
    assert element == STRESSES and sorted(nodal) == sorted(
        [f"{field}_{axis}" for field in ("displacement", "velocity") for axis in "xyz"] + ["contact_pressure"])
    power = 10 ** max(len(str(arrays["node_ids"].max())) for _, arrays in grids)
    names = file.strings("eb_names")
    assert names == [attributes["name"] for attributes, _ in grids] and len(names) == 3, names
    for b, (attributes, arrays) in enumerate(grids):
        connect = f"connect{b + 1}"
        assert file.attributes_of(connect)["elem_type"] == TYPES[attributes["topology"]]
        cells = file[connect] - 1
        np.testing.assert_array_equal(points[cells], arrays["points"][arrays["cells"]])
        np.testing.assert_array_equal(ids[cells] % power, arrays["node_ids"][arrays["cells"]])
        has_stress = attributes["topology"] == "Hexahedron"
        assert list(file["elem_var_tab"][b]) == [int(has_stress)] * len(STRESSES)
        for s, step in enumerate(steps):
            for field in ("displacement", "velocity"):
                found = np.stack([nodal[f"{field}_{axis}"][s] for axis in "xyz"], axis=1)
                np.testing.assert_array_equal(found[cells], step[b][field][arrays["cells"]])
            np.testing.assert_array_equal(nodal["contact_pressure"][s][cells], step[b]["contact_pressure"][:, 0][arrays["cells"]])
            for i, name in enumerate(STRESSES if has_stress else []):
                np.testing.assert_array_equal(file[f"vals_elem_var{i + 1}eb{b + 1}"][s], step[b][name][:, 0])
    assert max(step[1]["stress_von_mises"].max() for step in steps) > 1e6  # they met
    assert {i // power for i in ids} == {0, 1, 2}  # of three sets of points


def check_library(path, times, steps):
    """Debian's libexodusii: times, names and values by its own calls."""
    name = ctypes.util.find_library("exoIIv2c")
    if name is None:
        return "libexodusii5 is not installed"
    library = ctypes.CDLL(name)
    real, size, version = ctypes.c_int(8), ctypes.c_int(0), ctypes.c_float()
    library.ex_open_int.argtypes = [ctypes.c_char_p, ctypes.c_int, ctypes.POINTER(ctypes.c_int), ctypes.POINTER(ctypes.c_int),
                                    ctypes.POINTER(ctypes.c_float), ctypes.c_int]
    for api in (602, *range(400, 900)):  # ex_open() is a macro that hands on the version of the header, which the library compares
        file = library.ex_open_int(str(path).encode(), 0, real, size, version, api)
        if file >= 0:
            break
    assert file >= 0, "libexodusii does not open the file"
    found = np.zeros(len(times))
    assert library.ex_get_all_times(file, found.ctypes.data_as(ctypes.c_void_p)) >= 0
    np.testing.assert_array_equal(found, times)
    title, counts = ctypes.create_string_buffer(1024), [ctypes.c_int() for _ in range(6)]
    assert library.ex_get_init(file, title, *[ctypes.byref(c) for c in counts]) >= 0
    dimension, n_nodes, n_elements, n_blocks = (c.value for c in counts[:4])
    assert (dimension, n_blocks) == (3, 3) and title.value.startswith(b"cbr-dyn")
    n = ctypes.c_int()
    assert library.ex_get_var_param(file, b"n", ctypes.byref(n)) >= 0 and n.value == 7
    values = np.zeros(n_nodes)
    pointer = values.ctypes.data_as(ctypes.c_void_p)
    assert library.ex_get_nodal_var(file, len(times), 1, ctypes.c_int64(n_nodes), pointer) >= 0
    expected = np.concatenate([steps[-1][b]["displacement"][:, 0] for b in range(3)])
    np.testing.assert_array_equal(values, expected)
    elements = steps[-1][2]["stress_von_mises"][:, 0]
    values = np.zeros(len(elements))
    assert library.ex_get_elem_var(file, len(times), 7, ctypes.c_int64(3), ctypes.c_int64(len(elements)),
                                   values.ctypes.data_as(ctypes.c_void_p)) >= 0
    np.testing.assert_array_equal(values, elements)
    library.ex_close(file)
    return ""


def check_vtk(path, times, steps):
    """The reader that ParaView has: joined displacements, von Mises' stress by cell, at the last time."""
    try:
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkIOExodus import vtkExodusIIReader
    except ImportError:
        return "python3-vtk9 is not installed"
    reader = vtkExodusIIReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    information = reader.GetOutputInformation(0)
    key = next(k for k in [reader.GetExecutive().TIME_STEPS()])
    np.testing.assert_array_equal([information.Get(key, i) for i in range(information.Length(key))], times)
    reader.SetApplyDisplacements(False)
    for kind in (reader.NODAL, reader.ELEM_BLOCK):
        reader.SetAllArrayStatus(kind, 1)
    reader.UpdateTimeStep(times[-1])
    blocks = reader.GetOutput().GetBlock(0)
    for b in range(blocks.GetNumberOfBlocks()):
        grid = blocks.GetBlock(b)
        moved = vtk_to_numpy(grid.GetPointData().GetArray("displacement_"))
        assert moved.shape[1] == 3
        assert abs(np.abs(moved).max() / np.abs(steps[-1][b]["displacement"]).max() - 1) < 1e-14, b
        stress = grid.GetCellData().GetArray("stress_von_mises")
        if "stress_von_mises" in steps[-1][b]:
            np.testing.assert_array_equal(vtk_to_numpy(stress), steps[-1][b]["stress_von_mises"][:, 0])
    return ""


def check_restart(folder):
    write_scene(folder, "exodus", ", checkpoint: {every: 1.0e-4, file: c.h5}")
    run(folder, sys.argv[2], "scene.yaml", "-o", "whole.h5", "--threads", "1")
    whole = (folder / "whole.exo").read_bytes()
    run(folder, sys.argv[2], "scene.yaml", "-o", "again.h5", "--restart", "c.h5", "--threads", "1")
    assert (folder / "again.exo").read_bytes() == whole


def check_refusals(folder):
    (folder / "run.exo").write_text("my notes\n")
    error = run(folder, sys.argv[2], "scene.yaml", "-o", "run.h5", expect=2)
    assert "run.exo: exists and is not an Exodus file" in error and error.count("\n") == 1, error
    assert (folder / "run.exo").read_text() == "my notes\n"
    (folder / "bare.yaml").write_text((folder / "scene.yaml").read_text().replace("displacement, velocity, stress, contact_pressure", ""))
    error = run(folder, sys.argv[2], "bare.yaml", "-o", "bare.h5", expect=2)
    assert "output.format" in error and error.count("\n") == 1, error


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_mesh(folder / "box.msh")
        write_scene(folder, "xdmf")
        run(folder, sys.argv[1], "scene.yaml")
        run(folder, sys.argv[2], "scene.yaml", "-o", "run.h5", "--threads", "1")
        write_scene(folder, "exodus")
        run(folder, sys.argv[2], "scene.yaml", "-o", "shown.h5", "--threads", "1")
        assert sorted(p.name for p in folder.glob("shown*")) == ["shown.exo", "shown.h5"] and not list(folder.glob(".cbr*"))
        times, grids, steps = fields_of(folder / "run.fields.h5")
        check_exodus(folder / "shown.exo", times, grids, steps)
        # Separate processes would do for libraries that bring an HDF5 of their own; these read classic files
        for check in (check_library, check_vtk):
            missing = check(folder / "shown.exo", times, steps)
            print(f"{check.__name__}: {'skipped: ' + missing if missing else 'ok'}")
        run(folder, sys.argv[2], "scene.yaml", "-o", "shown.h5", "--threads", "1")  # over its own
        check_restart(folder)
        check_refusals(folder)
    print("ok")


if __name__ == "__main__":
    main()
