# SPDX-License-Identifier: GPL-3.0-or-later
# What ParaView's readers and meshio make of the fields: each stress under its own name. Skipped where neither is installed
# (python3-paraview, python3-meshio).
#
#   fields_readers.py CBR_DYN FOLDER_OF_MESHES
import os
import shutil
import subprocess
import sys
import tempfile

NAMES = ["stress_" + name for name in "xx yy zz xy yz xz von_mises principal_1 principal_2 principal_3".split()]
ONE = "  a: {component: block, rotation: [10, 20, 30]}\n"
TWO = ONE + "  b: {component: block, position: [0.2, 0, 0], velocity: [9, 7, 5]}\n"
SCENE = """materials: {steel: {youngs_modulus: 2.0e11, poissons_ratio: 0.3, density: 7800}}
components: {block: {mesh: block.msh, material: steel}}
instances:
%sboundary: [{instance: a, nodes: x_min, fix: [x, y, z]}]
loads: [{instance: a, surface: x_max, traction: [1.0e6, 2.0e6, -3.0e6]}]
time: {end: 4.0e-6}
output: {every: 2.0e-6, fields: [displacement, stress]}
"""
# The file is read in a process of its own: h5py and ParaView may bring two HDF5 libraries.
DUMP = """import sys, h5py, numpy
data = {}
with h5py.File(sys.argv[1]) as file:
    file.visititems(lambda name, item: data.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
numpy.savez(sys.argv[2], **data)
"""


def leaves(data):
    """Grids of whatever nesting a reader makes."""
    if data.IsA("vtkMultiBlockDataSet"):
        children = [data.GetBlock(i) for i in range(data.GetNumberOfBlocks())]
    elif data.IsA("vtkPartitionedDataSet"):
        children = [data.GetPartition(i) for i in range(data.GetNumberOfPartitions())]
    else:
        return [data]
    return [leaf for child in children if child is not None for leaf in leaves(child)]


def check_paraview(xdmf, data, n_grids):
    from paraview import servermanager, simple
    from paraview.vtk.util.numpy_support import vtk_to_numpy

    readers = {
        "XDMFReader": lambda: simple.XDMFReader(FileNames=[xdmf]),
        "Xdmf3ReaderS": lambda: simple.Xdmf3ReaderS(FileName=[xdmf]),
        "Xdmf3ReaderT": lambda: simple.Xdmf3ReaderT(FileName=[xdmf]),
    }
    for name, make in readers.items():
        reader = make()
        reader.UpdatePipelineInformation()
        assert list(reader.TimestepValues) == list(data["times"]), name
        reader.UpdatePipeline(data["times"][-1])
        grids = leaves(servermanager.Fetch(reader))
        assert len(grids) == n_grids, name
        for g, grid in enumerate(grids):
            cells = grid.GetCellData()
            assert sorted(cells.GetArray(i).GetName() for i in range(cells.GetNumberOfArrays())) == sorted(NAMES), name
            for stress in NAMES:
                found, expected = vtk_to_numpy(cells.GetArray(stress)), data["steps/2/%d/%s" % (g, stress)][:, 0]
                assert (found == expected).all(), (name, stress)


def check_picture(fields, data, n_grids, script):
    """The script for ParaView: the largest stress of all times, and a picture. Without a display by Xvfb."""
    picture = fields + ".png"
    done = subprocess.run(["xvfb-run", "-a", "-s", "-noreset", "pvpython", script, fields, picture], capture_output=True, text=True)
    largest = max(data["steps/%d/%d/stress_von_mises" % (step, g)].max() for step in range(3) for g in range(n_grids))
    assert f"3 times, largest von Mises stress {largest:.6g} at" in done.stdout, (done.stdout, done.stderr[-500:])
    assert os.path.getsize(picture) > 10000


def check_meshio(xdmf, data):
    import meshio

    with meshio.xdmf.TimeSeriesReader(xdmf) as reader:
        points, _ = reader.read_points_cells()
        time, _, cells = reader.read_data(2)
    assert time == data["times"][-1]
    assert (points == data["grids/0/points"]).all()
    for stress in NAMES:
        assert (cells[stress][0].ravel() == data["steps/2/0/" + stress][:, 0]).all(), stress


def check_missing(folder, script):
    """The script on no file, on results, and on fields whose numbers are elsewhere: one line, no picture."""
    os.makedirs(os.path.join(folder, "alone"), exist_ok=True)
    shutil.copy(os.path.join(folder, "r.xdmf"), os.path.join(folder, "alone/r.xdmf"))
    for name, words in (("none.xdmf", "no such file"), ("r.h5", ".xdmf or .exo"), ("alone/r.xdmf", "alone/r.fields.h5: no such file")):
        done = subprocess.run(["pvpython", script, name, "none.png"], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 1 and words in done.stderr and "Traceback" not in done.stderr, (name, done.stderr)
        assert not os.path.exists(os.path.join(folder, "none.png"))


def main():
    import importlib.util

    has = {name: importlib.util.find_spec(name) is not None for name in ("h5py", "numpy", "paraview", "meshio")}
    if not (has["h5py"] and has["numpy"] and (has["paraview"] or has["meshio"])):
        print("skipped: needs h5py, and paraview or meshio")
        return 77
    import numpy

    program, meshes = sys.argv[1:]
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../python/examples/paraview_stress.py")
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    with tempfile.TemporaryDirectory() as folder:
        geo = os.path.join(meshes, "block.geo")
        subprocess.run(["gmsh", "-3", geo, "-o", os.path.join(folder, "block.msh")], check=True, stdout=subprocess.DEVNULL)
        for n_grids, instances in ((1, ONE), (2, TWO)):
            scene = os.path.join(folder, "scene.yaml")
            with open(scene, "w") as out:
                out.write(SCENE % instances)
            subprocess.run([program, scene, "-o", os.path.join(folder, "r.h5"), "--quiet"], check=True)
            dump = os.path.join(folder, "data.npz")
            subprocess.run([sys.executable, "-c", DUMP, os.path.join(folder, "r.fields.h5"), dump], check=True)
            data, xdmf = numpy.load(dump), os.path.join(folder, "r.xdmf")
            if has["meshio"] and n_grids == 1:  # it knows series of one grid
                check_meshio(xdmf, data)
            if has["paraview"]:
                check_paraview(xdmf, data, n_grids)
            if shutil.which("pvpython") and shutil.which("xvfb-run"):
                check_picture(xdmf, data, n_grids, script)
            if shutil.which("pvpython"):
                check_missing(folder, script)
    return 0


if __name__ == "__main__":
    sys.exit(main())
