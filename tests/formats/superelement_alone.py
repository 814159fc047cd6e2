#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A component that is a superelement file alone moves as the same file beside its mesh, to the last bit: contact, supports, loads,
fields, a restart. usage: superelement_alone.py CBR_REDUCE CBR_DYN CBR_SKIN. Exit 77 without h5py."""
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
from running import differing, ended, h5py, run, write_mesh  # noqa: E402

MATERIAL = "materials: {m: {youngs_modulus: 1, poissons_ratio: 0.3, density: 1}}"
MESH = "mesh: box.msh, material: m, reduction: {interface: contact, REDUCTION, superelement: box.cbr.h5}"
SCENE = """
HEAD
components:
  block: {BLOCK}
instances:
  left: {component: block, position: [-1.0001, 0, 0], velocity: [0.01, 0, 0]DAMPING}
  right: {component: block, position: [1, 0, 0], mirror: x}
BOUNDARY
loads:
  - {instance: left, surface: contact, traction: [0, 0.001, 0], history: {time: [0, 1], value: [0, 1]}}
  - {gravity: [0, 0, -0.001]}
contact: [{between: [left.contact, right.contact], friction: FRICTION}]
time: {end: 2, integrator: INTEGRATOR}
output: {every: 0.05, history: [left.contact, right.contact], fields: [displacement, stress, contact_pressure]CHECKPOINT}
"""
PLAIN = {"DAMPING": "", "BOUNDARY": "", "FRICTION": "0", "INTEGRATOR": "exact", "CHECKPOINT": "", "REDUCTION": "modes: 12"}
CASES = {
    "exact": {"REDUCTION": "modes: 12, recovery: true"},
    "held": {"BOUNDARY": "boundary: [{instance: right, nodes: contact, fix: [y, z]}]", "FRICTION": "0.2", "INTEGRATOR": "newmark"},
    "damped": {"DAMPING": ", damping: {ratio: 0.02}", "CHECKPOINT": ", checkpoint: {every: 0.7}"},
    "characteristic": {"REDUCTION": "basis: characteristic, modes: 12, characteristic: {modes: 4}"},
    "massless": {"REDUCTION": "basis: massless, modes: 12"},
    "domains": {"REDUCTION": "domains: 2, modes: 6, recovery: true", "INTEGRATOR": "central-difference"},
    "picked": {"REDUCTION": "modes: 12, pick: participation, loads: contact"},
}


def fill(case, alone):
    words = {**PLAIN, **case}
    text = SCENE.replace("HEAD", "" if alone else MATERIAL).replace("BLOCK", "superelement: box.cbr.h5" if alone else MESH)
    for word, value in words.items():
        text = text.replace(word, value)
    return text


def check_case(folder, name, case):
    reducer, runner = sys.argv[1:3]
    for alone in (False, True):
        which = "alone" if alone else "beside"
        (folder / f"{which}.yaml").write_text(fill(case, alone))
        if not alone:
            run(folder, reducer, "--force", "beside.yaml")
        before = (folder / "box.cbr.h5").read_bytes()
        if alone:
            (folder / "box.msh").rename(folder / "away.msh")
            passed_on = ended(folder, reducer, "alone.yaml").stdout
            assert "mesh" not in passed_on and str(folder / "box.cbr.h5") in passed_on, passed_on
            (folder / "passed.yaml").write_text(passed_on)
        run(folder, runner, "passed.yaml" if alone else "beside.yaml", "-o", f"{which}.h5", "--threads", "1")
        assert (folder / "box.cbr.h5").read_bytes() == before
        if alone:
            (folder / "away.msh").rename(folder / "box.msh")
    for suffix in (".h5", ".fields.h5"):
        different = differing(folder / f"beside{suffix}", folder / f"alone{suffix}")
        assert not different, (name, suffix, different[:5])
    with h5py.File(folder / "alone.h5") as file:
        assert file["contact/active"][()].max() > 0, name


def check_restart(folder):
    """The file is part of what a checkpoint holds on to, and its bytes alone are: not its name."""
    runner = sys.argv[2]
    (folder / "alone.yaml").write_text(fill(CASES["damped"], True))
    run(folder, sys.argv[1], "--force", "beside.yaml")
    run(folder, runner, "alone.yaml", "-o", "whole.h5", "--threads", "1")
    (folder / "moved").mkdir()
    (folder / "moved/other.cbr.h5").write_bytes((folder / "box.cbr.h5").read_bytes())
    moved = (folder / "alone.yaml").read_text().replace("box.cbr.h5", "moved/other.cbr.h5")
    (folder / "moved.yaml").write_text(moved)
    run(folder, runner, "moved.yaml", "-o", "again.h5", "--restart", "whole.checkpoint.h5")
    assert not differing(folder / "whole.h5", folder / "again.h5")
    with h5py.File(folder / "moved/other.cbr.h5", "r+") as file:
        file.attrs["content_hash"] = "another"
        del file.attrs["checksums_of_texts"]
    error = run(folder, runner, "moved.yaml", "-o", "again.h5", "--restart", "whole.checkpoint.h5", expect=2)
    assert "whole.checkpoint.h5" in error and error.count("\n") == 1, error


def check_programs(folder):
    reducer, runner, skinner = sys.argv[1:4]
    beside = ended(folder, runner, "beside.yaml", "--modes", "9", "--threads", "1").stdout
    assert ended(folder, runner, "passed.yaml", "--modes", "9", "--threads", "1").stdout == beside
    told = run(folder, runner, "passed.yaml", "-o", "half.h5", "--check-error", expect=2)
    assert "retired" in told and "cbr.check_error" in told and told.count("\n") == 1, told
    skin = "skin: {surfaces: [contact], youngs_modulus: 1, poissons_ratio: 0.3, density: 1, thickness: 0}\n"
    (folder / "skin.yaml").write_text((folder / "passed.yaml").read_text() + skin)
    told = run(folder, skinner, "skin.yaml", expect=2)
    assert "no instance has a mesh" in told, told
    run(folder, reducer, "--estimate", "passed.yaml")


def check_refusals(folder):
    runner = sys.argv[2]
    text = (folder / "passed.yaml").read_text()
    for old, new, words in [
            ("box.cbr.h5", "none.cbr.h5", ("none.cbr.h5 does not exist", "component 'block'", "give the path of a superelement")),
            ("box.cbr.h5", "passed.yaml", ("passed.yaml", "component 'block'")),
            ("right.contact", "right.contcat", ("no surface", "available: contact", "did you mean 'contact'?")),
    ]:
        assert old in text
        (folder / "wrong.yaml").write_text(text.replace(old, new))
        error = run(folder, runner, "wrong.yaml", "-o", "wrong.h5", expect=2)
        assert error.count("\n") == 1 and "cbr-reduce" not in error.removeprefix("cbr-dyn"), error
        assert all(word in error for word in words), error
        assert not (folder / "wrong.h5").exists()
    error = run(folder, runner, "passed.yaml", "-o", "box.cbr.h5", expect=2)
    assert "the superelement of component 'block'" in error, error


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_mesh(folder / "box.msh")
        for case, words in CASES.items():
            check_case(folder, case, words)
        check_case(folder, "exact", CASES["exact"])
        check_programs(folder)
        check_refusals(folder)
        check_case(folder, "damped", CASES["damped"])
        check_restart(folder)
    print("ok")


if __name__ == "__main__":
    main()
