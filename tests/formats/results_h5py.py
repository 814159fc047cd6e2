#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Two blocks meet; the results file is read as a user's script would and held against docs/formats.md, and against what must be true
of any results: balances, and the same bytes from run to run. usage: results_h5py.py CBR_REDUCE CBR_DYN. Exit 77 without h5py."""
import re
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
from running import CELLS, SIZE, differing, h5py, np, run, write_mesh  # noqa: E402

DOCS = Path(__file__).resolve().parents[2] / "docs" / "formats.md"
SPEED, GAP = 0.01, 1e-4
MASS = SIZE[0] * SIZE[1] * SIZE[2]  # density 1
SCENE = f"""
materials: {{m: {{youngs_modulus: 1, poissons_ratio: 0.3, density: 1}}}}
components:
  block: {{mesh: box.msh, material: m, reduction: {{interface: contact, modes: 20}}}}
instances:
  left: {{component: block, as: superelement, position: [{-1 - GAP}, 0, 0], velocity: [{SPEED}, 0, 0]}}
  right: {{component: block, as: mesh, position: [1, 0, 0], mirror: x}}
contact: [{{between: [left.contact, right.contact]}}]
time: {{end: 3, integrator: exact}}
output: {{every: 0.05, history: [left.contact, right.contact]}}
"""
F = np.dtype("<f8")


def check_contract(file):
    n = len(file["time"])
    expected = {"time": (n,), "contact/active": (n,)}
    for surface in ("left.contact", "right.contact"):
        expected.update({f"surfaces/{surface}/{what}": (n, 3) for what in ("mean_position", "mean_velocity", "mean_acceleration", "force")})
    for instance in ("left", "right"):
        expected.update({f"instances/{instance}/{what}": (n, 3) for what in ("center_of_mass", "momentum", "angular_momentum")})
        expected.update({f"instances/{instance}/{what}": (n,) for what in ("kinetic_energy", "strain_energy")})
    expected.update({f"energy/{what}": (n,) for what in ("total", "work_external", "work_contact", "work_friction", "work_damping", "work_numerical")})
    pair = "contact/left.contact - right.contact"
    rows = re.findall(r"^\| /contact/FIRST - SECOND/(.*?) \| (n|n x 3) \|", DOCS.read_text(), re.M)
    expected.update({f"{pair}/{what}": (n,) if shape == "n" else (n, 3) for names, shape in rows for what in names.split(", /")})
    assert {f"{pair}/{what}" for what in file[pair]} == {name for name in expected if name.startswith(pair)}, list(file[pair])
    assert all("dimension" in of.attrs for of in file[pair].values())
    for name, shape in expected.items():
        assert file[name].shape == shape, (name, file[name].shape)
        assert file[name].dtype == F or name == "contact/active", (name, file[name].dtype)
        assert np.isfinite(file[name][()]).all(), name
    assert (file.attrs["format"], file.attrs["format_version"]) == ("cbr-results", "1.14")
    assert file.attrs["warnings"] == ""
    assert file["instances/left"].attrs["superelement"] == "block.cbr.h5" and len(file["instances/left"].attrs["superelement_hash"]) == 32
    assert "superelement" not in file["instances/right"].attrs
    assert file.attrs["steps"] > 0 and file.attrs["n_dofs"] > 0
    assert isinstance(file.attrs["steps"], np.integer) and isinstance(file.attrs["n_dofs"], np.integer)
    for phase in ("read", "setup", "steps", "write"):
        assert file.attrs[f"wall_seconds_{phase}"] > 0, phase


def check_physics(file):
    time = file["time"][()]
    assert time[0] == 0 and np.allclose(np.diff(time), 0.05) and abs(time[-1] - 3) < 1e-9
    left, right = file["instances/left"], file["instances/right"]
    momentum = left["momentum"][()] + right["momentum"][()]
    assert np.abs(momentum - [MASS * SPEED, 0, 0]).max() < 1e-9 * MASS * SPEED
    assert abs(left["kinetic_energy"][0] / (0.5 * MASS * SPEED**2) - 1) < 1e-9
    assert np.abs(left["center_of_mass"][0] - [-0.5 - GAP, 0.25, 0.25]).max() < 1e-12
    assert np.abs(right["center_of_mass"][0] - [0.5, 0.25, 0.25]).max() < 1e-12
    assert np.abs(file["surfaces/left.contact/mean_position"][0] - [-GAP, 0.25, 0.25]).max() < 1e-12
    assert np.abs(file["surfaces/right.contact/mean_position"][0] - [0, 0.25, 0.25]).max() < 1e-12
    active = file["contact/active"][()]
    assert active[0] == 0 and active.max() > 0 and active[-1] == 0
    pair = file["contact/left.contact - right.contact"]
    force = pair["force"][()]
    assert np.abs(force - file["surfaces/left.contact/force"][()]).max() < 1e-12 * np.abs(force).max()
    area, nodes = pair["area"][()], (CELLS[1] + 1) * (CELLS[2] + 1)
    assert (active == nodes).any() and np.allclose(area[active == nodes], SIZE[1] * SIZE[2], rtol=1e-4)  # seen along the normals, which tilt
    assert ((area > 0) == (active > 0)).all() and area.max() < SIZE[1] * SIZE[2] * (1 + 1e-12)
    met = np.abs(force[:, 0]) > 0
    assert np.abs(pair["center_of_pressure"][met] - [0, 0.25, 0.25]).max() < 0.02 and not pair["center_of_pressure"][~met].any()
    assert left["momentum"][-1, 0] < 0.5 * MASS * SPEED < right["momentum"][-1, 0]
    energies = sum(body[part][()] for body in (left, right) for part in ("kinetic_energy", "strain_energy"))
    assert np.abs(file["energy/total"][()] - energies).max() < 1e-9 * energies[0]


def main():
    reduce, dyn = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        write_mesh(folder / "box.msh")
        (folder / "scene.yaml").write_text(SCENE)
        run(folder, reduce, "scene.yaml")
        for result in ("first.h5", "second.h5"):
            run(folder, dyn, "scene.yaml", "-o", result)
        with h5py.File(folder / "first.h5", "r") as file:
            for check in (check_contract, check_physics):
                check(file)
                print("ok", check.__name__)
        assert not differing(folder / "first.h5", folder / "second.h5")
        print("ok the same bytes")


if __name__ == "__main__":
    main()
