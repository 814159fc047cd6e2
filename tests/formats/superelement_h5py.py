#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a superelement file as a user's script would and holds it against docs/formats.md: names, shapes, types, order in memory.

And the other way round: what h5py writes in its own manner is read by us.
usage: superelement_h5py.py PROGRAM, which is tests/formats/sample_file.cpp.
Exit 77 (skipped) without h5py.
"""
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
from running import h5py, np  # noqa: E402

F, I = np.dtype("<f8"), np.dtype("<i8")
k, c, n = 4, 12, 4
EXPECTED = {
    "matrices/eigenvalues": (F, (k,)), "matrices/K_cc": (F, (c, c)), "matrices/M_cc": (F, (c, c)), "matrices/M_kc": (F, (k, c)),
    "dofs/node": (I, (c,)), "dofs/component": (I, (c,)),
    "nodes/id": (I, (n,)), "nodes/coordinates": (F, (n, 3)),
    "interface/contact/faces": (I, (1, 4)), "interface/contact/element": (I, (1,)), "interface/contact/side": (I, (1,)),
    "interface/other side/faces": (I, (2, 3)), "interface/other side/element": (I, (2,)), "interface/other side/side": (I, (2,)),
    "nodesets/clamp": (I, (2,)),
    "rigid_body/mass": (F, (1,)), "rigid_body/center": (F, (3,)), "rigid_body/inertia": (F, (3, 3)),
    "diagonal/omega": (F, (k + c,)), "diagonal/V": (F, (k + c, k + c)),
    "recovery/nodes/id": (I, (2,)), "recovery/nodes/coordinates": (F, (2, 3)),
    "recovery/Psi": (F, (6, c)), "recovery/Phi": (F, (6, k)),
    "recovery/blocks/000000/connectivity": (I, (2, 4)), "recovery/blocks/000000/element_id": (I, (2,)),
}
ATTRIBUTES = {"format": "cbr-superelement", "format_version": "1.16", "content_hash": "0123456789abcdef0123456789abcdef",
              "basis": "craig-bampton", "n_modes": k, "n_interface": c}


def check_names(file):
    found = {}
    file.visititems(lambda name, item: found.update({name: item}) if isinstance(item, h5py.Dataset) else None)
    assert set(found) == set(EXPECTED), set(found) ^ set(EXPECTED)
    for name, (dtype, shape) in EXPECTED.items():
        assert found[name].dtype == dtype, (name, found[name].dtype)
        assert found[name].shape == shape, (name, found[name].shape)
        assert found[name].chunks is None and found[name].compression is None, name


def check_attributes(file):
    for name, value in ATTRIBUTES.items():
        assert file.attrs[name] == value, (name, file.attrs[name])
        assert isinstance(file.attrs[name], type(value)) or isinstance(file.attrs[name], np.integer), (name, type(file.attrs[name]))
    assert isinstance(file.attrs["generator"], str) and file.attrs["generator"].startswith("cbr ")
    assert set(file.attrs) == set(ATTRIBUTES) | {"generator", "checksums_of_texts"}, set(file.attrs)
    assert file["interface/contact/faces"].attrs["kind"] == "quad4"
    assert file["interface/other side/faces"].attrs["kind"] == "tri3"
    assert file["provenance"].attrs["mesh"] == "block.msh"
    assert file["provenance"].attrs["material"].endswith("(épreuve)")
    assert file["provenance"].attrs["options"] == ""
    block = file["recovery/blocks/000000"].attrs
    assert (block["name"], block["type"], block["id"]) == ("core / 1", "tet4", 3)


def check_order(file):
    """Row-major: a transposed M_kc, V or face would not fit the other datasets."""
    K, M = np.zeros((k + c, k + c)), np.eye(k + c)
    K[:k, :k] = np.diag(file["matrices/eigenvalues"])
    K[k:, k:] = file["matrices/K_cc"]
    M[:k, k:] = file["matrices/M_kc"]
    M[k:, :k] = M[:k, k:].T
    M[k:, k:] = file["matrices/M_cc"]
    V, omega = file["diagonal/V"][()], file["diagonal/omega"][()]
    assert np.abs(V.T @ M @ V - np.eye(k + c)).max() < 1e-11
    assert np.abs(V.T @ K @ V - np.diag(omega**2)).max() < 1e-11 * omega.max() ** 2
    assert file["interface/other side/faces"][()].tolist() == [[0, 2, 1], [0, 3, 2]]
    assert file["recovery/blocks/000000/connectivity"][()].tolist() == [[0, 1, 2, 4], [1, 2, 3, 5]]
    assert file["nodes/coordinates"][()].tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.25]]
    assert file["nodes/id"][()].tolist() == [11, 12, 23, 34]
    assert file["dofs/node"][()].tolist() == [i // 3 for i in range(c)]
    assert file["dofs/component"][()].tolist() == [i % 3 for i in range(c)]
    assert file["rigid_body/inertia"][()].tolist() == [[1, 0.125, 0], [0.125, 2, 0], [0, 0, 2.5]]


def check_no_time_stamps(file):
    def look(name, item):
        properties = item.id.get_create_plist()
        if isinstance(item, h5py.Dataset):
            assert not properties.get_obj_track_times(), name
    file.visititems(look)


def copy_as_h5py_would(source, target, how):
    """The same contents as another program may store them."""
    def put(name, item):
        if isinstance(item, h5py.Group):
            target.require_group(name)
        else:
            values = item[()]
            if how == "other types":
                values = values.astype(np.dtype(">i4" if values.dtype.kind == "i" else ">f8"))
            compressed = {"compression": "gzip", "shuffle": True} if how == "compressed" else {}
            target.create_dataset(name, data=values, track_times=True, **compressed)
        copy_attributes(item, target[name])

    def copy_attributes(item, copy):
        for key, value in item.attrs.items():
            is_text = isinstance(value, str)
            copy.attrs[key] = np.bytes_(value.encode()) if is_text and how == "fixed-length strings" else value
            copy.attrs[key] = copy.attrs[key]  # written twice: leaves a gap where the first one was

    copy_attributes(source, target)
    source.visititems(put)


def check_files_of_h5py(program, name):
    for how in ("as it is", "compressed", "fixed-length strings", "other types"):
        for libver in ("earliest", "latest"):
            copy = name.with_name(f"{how} {libver}.h5")
            with h5py.File(name, "r") as source, h5py.File(copy, "w", libver=libver) as target:
                copy_as_h5py_would(source, target, how)
            done = subprocess.run([program, "read", str(copy)], capture_output=True, text=True)
            assert done.returncode == 0, (how, libver, done.stderr)


def check_edits(program, name):
    """A dataset that a script changes in place is refused until the script removes its checksum; a new dataset has none."""
    copy = name.with_name("edited.h5")

    def read(edit):
        shutil.copy(name, copy)
        with h5py.File(copy, "r+") as file:
            edit(file, "recovery/Psi")
        return subprocess.run([program, "read", str(copy)], capture_output=True, text=True)

    def in_place(file, dataset):
        file[dataset][2, 1] += 1e-9

    def meant(file, dataset):
        in_place(file, dataset)
        del file[dataset].attrs["checksum"]

    def anew(file, dataset):
        values = 2 * file[dataset][()]
        del file[dataset]
        file[dataset] = values

    told = read(in_place)
    assert told.returncode == 2 and "/recovery/Psi: its numbers are not those" in told.stderr, told
    for edit in (meant, anew):
        assert read(edit).returncode == 1, edit  # read, and another superelement


def main():
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as folder:
        name = Path(folder) / "sample.cbr.h5"
        subprocess.run([program, "write", str(name)], check=True)
        with h5py.File(name, "r") as file:
            for check in (check_names, check_attributes, check_order, check_no_time_stamps):
                check(file)
                print("ok", check.__name__)
        check_files_of_h5py(program, name)
        print("ok check_files_of_h5py")
        check_edits(program, name)
        print("ok check_edits")


if __name__ == "__main__":
    main()
