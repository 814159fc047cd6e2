# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs that are ended by signals or killed at any moment: what was there stays whole, and they go on to the same bytes."""
import os
import random
import re
import resource
import signal
import time
from pathlib import Path

import h5py

from programs import (CALLS, FIELDS, write_mesh, scene, start, run, datasets, require_same, require_no_temporary, prepared, wait_for, long_scene)

HDF5_BEFORE = b"\x89HDF\r\n\x1a\nbefore"  # a damaged file may be replaced, another kind of file not


def case_signals(folder):
    """The first ends a run at the next step with what there is, the previous file of the others stays; nothing is left behind."""
    prepared(folder)
    # With `auto` what is ended early may be of linear bodies, and the whole run of bodies that turn
    run(folder, "cbr-dyn", long_scene(folder, FIELDS, "plain.yaml", "large"), "-o", "whole.h5")
    long_scene(folder, ", checkpoint: {every_steps: 40}" + FIELDS, rotations="large")
    for number in (signal.SIGINT, signal.SIGTERM):
        for attempt in range(10):  # on a busy machine a run may be done before it is seen to have begun
            process = start(folder, "cbr-dyn", "long.yaml", "-o", "part.h5")
            wait_for((folder / "part.checkpoint.h5").exists, process)
            process.send_signal(number)
            errors = process.communicate()[1]
            if process.returncode != 0:
                break
            os.remove(folder / "part.checkpoint.h5")
        assert process.returncode == 1, (process.returncode, errors)
        assert errors.count("\n") == 1 and "part.h5" in errors and number.name in errors and "--restart part.checkpoint.h5" in errors, errors
        reached, planned = map(int, re.search(r", after (\d+) of (\d+) steps", errors).groups())
        assert 0 < reached < planned, errors
        require_no_temporary(folder)
        with h5py.File(folder / "part.h5") as part, h5py.File(folder / "whole.h5") as whole:
            n = len(part["time"])
            assert part.attrs["partial"] == 1 and whole.attrs["partial"] == 0 and 0 < n < len(whole["time"]), n
            names = []
            part.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
            for name in names:
                assert len(part[name]) == n and part[name][:].tobytes() == whole[name][:n].tobytes(), name
        with h5py.File(folder / "part.fields.h5") as fields:
            assert len(fields["steps"]) == n
        run(folder, "cbr-dyn", "long.yaml", "-o", "part.h5", "--restart", "part.checkpoint.h5")
        require_same(folder / "whole.h5", folder / "part.h5", number.name)
        require_same(folder / "whole.fields.h5", folder / "part.fields.h5", number.name)
        assert (folder / "whole.xdmf").read_text().replace("whole.", "part.") == (folder / "part.xdmf").read_text()
        os.remove(folder / "part.checkpoint.h5")
    # Programs that have nothing to hand over yet
    write_mesh(folder / "large.msh", (14, 14, 14))
    (folder / "large.cbr.h5").write_bytes(HDF5_BEFORE)
    run(folder, *CALLS["skinned.msh"])
    files = set(os.listdir(folder))
    material = ("--youngs-modulus", 1, "--poissons-ratio", 0.3, "--density", 1)
    for call in (("cbr-reduce", "large.msh", "--interface", "contact", "--modes", 200, *material, "-o", "large.cbr.h5"),
                 ("cbr-skin", "large.msh", "--sideset", "contact", "-o", "skinned.msh")):
        for number, wait in ((signal.SIGINT, 0.02), (signal.SIGTERM, 0.04), (signal.SIGHUP, 0.03)):
            process = start(folder, *call)
            time.sleep(wait)
            process.send_signal(number)
            errors = process.communicate()[1]
            if process.returncode == 0:
                continue  # was faster
            assert process.returncode in (1, -number), (call, process.returncode, errors)  # -: before it had come to its handler
            assert process.returncode != 1 or number.name in errors, errors
            assert set(os.listdir(folder)) == files, set(os.listdir(folder)) ^ files


def case_signal_on_a_full_disk(folder):
    """The disk is full by the time that the signal comes: the results of before stay, and the checkpoint of before is named."""
    prepared(folder)
    long_scene(folder)
    for attempt in range(10):
        (folder / "part.h5").write_bytes(HDF5_BEFORE)
        process = start(folder, "cbr-dyn", "long.yaml", "-o", "part.h5")
        wait_for((folder / "part.checkpoint.h5").exists, process)
        if process.poll() is None:
            resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (1000, 1000))
            process.send_signal(signal.SIGTERM)
        errors = process.communicate()[1]
        if process.returncode != 0:
            break
        os.remove(folder / "part.checkpoint.h5")
    told = [line for line in errors.splitlines() if ": warning: checkpoint" not in line]
    assert process.returncode == 1 and len(told) == 1, (process.returncode, errors)
    for word in ("part.h5", "File too large", "SIGTERM", "--restart part.checkpoint.h5"):
        assert word in told[0], errors
    assert (folder / "part.h5").read_bytes() == HDF5_BEFORE
    require_no_temporary(folder)
    os.remove(folder / "part.h5")
    run(folder, "cbr-dyn", "long.yaml", "-o", "part.h5", "--restart", "part.checkpoint.h5")
    scene(folder, "", 60, "plain.yaml")
    run(folder, "cbr-dyn", "plain.yaml", "-o", "whole.h5")
    require_same(folder / "whole.h5", folder / "part.h5", "full disk")


def case_killed(folder):
    """SIGKILL at random moments, and on from the last checkpoint until the run comes to its end: the same bytes. Each file is whole
    or not there, at most temporaries are left, and the next run removes them."""
    prepared(folder)
    random.seed(1)
    begin = time.monotonic()
    run(folder, "cbr-dyn", long_scene(folder, "", "plain.yaml"), "-o", "whole.h5", "--threads", 2)
    whole_time = time.monotonic() - begin
    checkpoint = folder / "part.checkpoint.h5"
    n_killed = n_left = 0
    for more in ("", FIELDS):
        long_scene(folder, ", checkpoint: {every_steps: 25}" + more)
        for attempt in range(40):
            go_on = ("--restart", checkpoint.name) if checkpoint.exists() else ("--threads", 2)
            process = start(folder, "cbr-dyn", "long.yaml", "-o", "part.h5", *go_on)
            if attempt == 0:
                wait_for(checkpoint.exists, process)
            elif attempt < 8:
                time.sleep(random.uniform(0.0, 0.4 * whole_time))
            if attempt < 8:
                process.kill()
            errors = process.communicate()[1]
            if process.returncode == 0:
                break
            assert process.returncode == -signal.SIGKILL, (process.returncode, errors)
            n_killed += 1
            n_left += any(name.endswith(".tmp") for name in os.listdir(folder))
            if checkpoint.exists():
                with h5py.File(checkpoint) as file:
                    assert file.attrs["step"] > 0 and len(file["state"]) > 100
            assert not (folder / "part.h5").exists()
        require_same(folder / "whole.h5", folder / "part.h5", f"killed {n_killed} times")
        require_no_temporary(folder)
        os.remove(folder / "part.h5"), os.remove(checkpoint)
    assert n_killed >= 2, n_killed
    return f"killed {n_killed} times, {n_left} times with a temporary file left"


def case_killed_while_writing(folder):
    """SIGKILL at 50 moments of each program, half of them from when it has begun to write: its file is the previous one or the new one,
    whole, which here are of different inputs in turn."""
    prepared(folder)
    write_mesh(folder / "other.msh", (4, 3, 3))
    scene(folder, end=3, name="shorter.yaml")
    (folder / "fewer.yaml").write_text((folder / "scene.yaml").read_text().replace("modes: 20", "modes: 12"))
    calls = {"results.h5": [("cbr-dyn", name, "-o", "results.h5") for name in ("scene.yaml", "shorter.yaml")],
             "block.cbr.h5": [("cbr-reduce", name, "--force") for name in ("scene.yaml", "fewer.yaml")],
             "skinned.msh": [("cbr-skin", name, "--sideset", "contact", "-o", "skinned.msh") for name in ("box.msh", "other.msh")]}
    content = {"results.h5": datasets}  # in its attributes are wall times
    has_temporary = lambda: any(name.endswith(".tmp") for name in os.listdir(folder))
    random.seed(2)
    notes = []
    for path, (one, other) in calls.items():
        read = content.get(path, Path.read_bytes)
        wholes = []
        for call in (other, one):
            begin = time.monotonic()
            run(folder, *call)
            duration = time.monotonic() - begin
            wholes.append(read(folder / path))
        assert wholes[0] != wholes[1], path
        n_killed = n_writing = 0
        for attempt in range(100):
            if n_killed == 50:
                break
            process = start(folder, *(one, other)[attempt // 2 % 2])
            if attempt % 2:
                wait_for(lambda: has_temporary(), process)
                time.sleep(random.uniform(0.0, 0.003))
            else:
                time.sleep(random.uniform(0.0, duration))
            process.kill()
            process.communicate()
            n_killed += process.returncode == -signal.SIGKILL
            n_writing += has_temporary()
            assert read(folder / path) in wholes, (path, attempt)
            for name in os.listdir(folder):
                if name.endswith(".tmp"):
                    os.remove(folder / name)
        assert n_killed >= 10 and n_writing >= 1, (path, n_killed, n_writing)  # others were done before
        notes.append(f"{one[0]}: killed {n_killed} times, {n_writing} of them writing")
    return "; ".join(notes)
