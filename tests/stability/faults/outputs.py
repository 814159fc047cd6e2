# SPDX-License-Identifier: GPL-3.0-or-later
"""Disks that are full or closed, files that are replaced meanwhile, programs side by side, checkpoints that do not fit."""
import os
import resource
import subprocess
import time

import h5py

from programs import BIN, CALLS, FIELDS, write_mesh, scene, start, run, require_same, require_no_temporary, prepared

NOBODY = 65534


def require_refused(folder, says, before):
    """Each program, with `before`(path) called in its process: exit 1, the path in the message, all files as they were."""
    old = {name: (folder / name).read_bytes() for name in os.listdir(folder)}
    for path, call in CALLS.items():
        errors = run(folder, *call, expect=1, before=before(path))
        assert path in errors and says in errors, errors
        now = {name: (folder / name).read_bytes() for name in os.listdir(folder)}
        assert now == old, (path, [name for name in old.keys() | now.keys() if old.get(name) != now.get(name)])


def case_disk_full(folder):
    """Room for so many bytes in any file: none, some, most. RLIMIT_FSIZE fails a write as a full disk does."""
    prepared(folder)
    size = {}
    for path, call in CALLS.items():
        run(folder, *call)
        size[path] = (folder / path).stat().st_size
    for share in (0, 0.3, 0.9):
        require_refused(folder, "File too large" if share == 0 else "", lambda path: lambda: resource.setrlimit(
            resource.RLIMIT_FSIZE, (int(share * size[path]), int(share * size[path]))))
    # A filter's scene to a full disk
    with open("/dev/full", "w") as full:
        errors = run(folder, "cbr-reduce", "scene.yaml", expect=1, stdout=full)
    assert "standard output" in errors, errors
    # Fields that no longer fit end the run, checkpoints do not
    scene(folder, FIELDS, name="fields.yaml")
    old = set(os.listdir(folder))
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size["results.h5"], size["results.h5"]))
    assert "run.fields.h5" in run(folder, "cbr-dyn", "fields.yaml", "-o", "run.h5", expect=1, before=limit)
    assert set(os.listdir(folder)) - old <= {"run.h5"}, set(os.listdir(folder)) ^ old  # the results themselves had room
    scene(folder, ", checkpoint: {every_steps: 10}", name="kept.yaml")
    run(folder, "cbr-dyn", "kept.yaml", "-o", "kept.h5")
    # Room for the results, which HDF5 shortens when it closes them, and not for the checkpoint
    before = (folder / "kept.checkpoint.h5").read_bytes()
    room = (folder / "kept.h5").stat().st_size + 4096
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))
    if len(before) > room:
        errors = run(folder, "cbr-dyn", "kept.yaml", "-o", "kept.h5", before=limit)
        assert errors.count("\n") == 1 and "warning: checkpoint" in errors and "kept.checkpoint.h5" in errors, errors
        assert (folder / "kept.checkpoint.h5").read_bytes() == before
    require_no_temporary(folder)


def case_address_space(folder):
    """Limited (ulimit -v) to less than BLAS takes, which would ask for it for ever."""
    prepared(folder)
    if any(b"__asan_init" in (BIN / call[0]).read_bytes() for call in CALLS.values()):
        return "(not under the address sanitizer)"
    for call in CALLS.values():
        errors = run(folder, *call, expect=1, before=lambda: resource.setrlimit(resource.RLIMIT_AS, (200 << 20, 200 << 20)))
        assert "address space" in errors and "ulimit -v" in errors, errors
    require_no_temporary(folder)


def case_small_disk(folder):
    """The same on a real disk of 3 MB, where one can be made."""
    disk = folder / "disk"
    disk.mkdir()
    if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m", "none", disk], capture_output=True).returncode:
        return "left out: no disk can be mounted here"
    try:
        prepared(disk)
        filler = os.open(disk / "filler", os.O_WRONLY | os.O_CREAT)
        try:
            while True:
                os.write(filler, bytes(4096))
        except OSError:
            os.close(filler)
        require_refused(disk, "No space left", lambda path: None)
    finally:
        subprocess.run(["umount", "-l", disk], check=True)
    return ""


def case_no_permission(folder):
    """A folder that may be read and not written to; root becomes nobody for it."""
    prepared(folder)
    as_nobody = (lambda: os.setuid(NOBODY)) if os.geteuid() == 0 else None
    try:  # in a folder of root's own nobody comes neither to the programs nor to their files
        sees_all = subprocess.run(["test", "-x", BIN / "cbr-dyn", "-a", "-r", folder / "box.msh"], preexec_fn=as_nobody).returncode == 0
    except (subprocess.SubprocessError, OSError):
        sees_all = False
    if not sees_all:
        return "left out: there is nobody here who may run the programs and not write"
    os.chmod(folder, 0o555)
    try:
        require_refused(folder, "Permission denied", lambda path: as_nobody)
    finally:
        os.chmod(folder, 0o755)
    # Inputs that may not be read
    os.chmod(folder / "box.msh", 0o000)
    errors = run(folder, "cbr-reduce", "scene.yaml", "--force", expect=2, before=as_nobody)
    assert "box.msh" in errors and "Permission denied" in errors, errors


def case_replaced_meanwhile(folder):
    """A mesh that is written to while a program reads it."""
    prepared(folder)
    write_mesh(folder / "large.msh", (12, 12, 12))
    (folder / "large.yaml").write_text((folder / "scene.yaml").read_text().replace("box.msh", "large.msh"))
    run(folder, "cbr-reduce", "large.yaml")
    run(folder, *CALLS["skinned.msh"])
    files = {name: (folder / name).read_bytes() for name in os.listdir(folder)}
    for call in (("cbr-reduce", "large.yaml", "--force"), ("cbr-dyn", "large.yaml", "-o", "results.h5"),
                 ("cbr-skin", "large.msh", "--sideset", "contact", "-o", "skinned.msh")):
        for _ in range(40):  # one that has read it before it is touched, as a busy machine may have it, ends well: again
            process = start(folder, *call)
            while process.poll() is None:
                os.utime(folder / "large.msh")
                time.sleep(0.001)
            errors = process.communicate()[1]
            if process.returncode != 0:
                break
            for name in os.listdir(folder):
                (folder / name).write_bytes(files[name]) if name in files else os.remove(folder / name)
        assert process.returncode == 1 and "large.msh: was replaced or changed while it was read" in errors, (call, errors)
        assert {name: (folder / name).read_bytes() for name in os.listdir(folder)} == files, call


def case_side_by_side(folder):
    """Runs that write the same files at the same time: each ends well, and what is there is whole."""
    prepared(folder)
    run(folder, "cbr-dyn", scene(folder, FIELDS), "-o", "whole.h5")
    superelement = (folder / "block.cbr.h5").read_bytes()
    scene(folder, ", checkpoint: {every_steps: 5}" + FIELDS)
    run(folder, *CALLS["skinned.msh"])
    skinned = (folder / "skinned.msh").read_bytes()
    for program in CALLS.values():
        together = [start(folder, *program) for _ in range(4)]
        for process in together:
            errors = process.communicate()[1]
            assert process.returncode == 0, errors
    require_same(folder / "whole.h5", folder / "results.h5", "results of four at a time")
    require_same(folder / "whole.fields.h5", folder / "results.fields.h5", "fields of four at a time")
    assert (folder / "block.cbr.h5").read_bytes() == superelement
    assert (folder / "skinned.msh").read_bytes() == skinned
    require_no_temporary(folder)


def case_checkpoints_that_do_not_fit(folder):
    """Damaged, of another run, of nothing, in the wrong place: refused by name, and nothing is written."""
    prepared(folder)
    run(folder, "cbr-dyn", scene(folder, ", checkpoint: {every_steps: 10, file: run.h5}" + FIELDS), "-o", "results.h5")
    whole = (folder / "run.h5").read_bytes()
    os.remove(folder / "results.h5")
    go_on = ("cbr-dyn", "scene.yaml", "-o", "results.h5", "--restart", "run.h5")

    def refused(expected, *call):
        errors = run(folder, *(call or go_on), expect=2)
        assert expected in errors and "run.h5" in errors, errors
        assert not (folder / "results.h5").exists()
        require_no_temporary(folder)

    with h5py.File(folder / "run.h5", "r+") as file:
        file["state"][len(file["state"]) // 2] += 1
    refused("damaged")
    for size in (0, 100, len(whole) // 2, len(whole) - 8):
        (folder / "run.h5").write_bytes(whole[:size])
        errors = run(folder, *go_on, expect=2)
        assert "run.h5" in errors, errors
    (folder / "run.h5").write_bytes(whole)
    with h5py.File(folder / "run.h5", "r+") as file:
        file.attrs["generator"] = "cbr-dyn 0.0.1"
        del file.attrs["checksums_of_texts"]
    refused("0.0.1")
    (folder / "run.h5").write_bytes(whole)
    refused("diagonal-limit", *go_on, "--diagonal-limit", 10)
    scene(folder, ", checkpoint: {every_steps: 10, file: run.h5}" + FIELDS, end=5)
    refused("another scene")
    scene(folder, ", checkpoint: {every_steps: 10, file: box.msh}")
    errors = run(folder, "cbr-dyn", "scene.yaml", "-o", "results.h5", expect=2)
    assert "box.msh" in errors and "is not a checkpoint" in errors and "scene.yaml:" in errors, errors
    scene(folder, ", checkpoint: {every_steps: 10, file: results.h5}")
    assert "results file" in run(folder, "cbr-dyn", "scene.yaml", "-o", "results.h5", expect=2)
    scene(folder, FIELDS)  # without checkpoints of its own it goes on all the same
    fields = (folder / "run.fields.h5").read_bytes()
    os.remove(folder / "run.fields.h5")
    assert "run.fields.h5" in run(folder, *go_on, expect=2)
    (folder / "run.fields.h5").write_bytes(fields)
    assert "replace" in run(folder, "cbr-dyn", "scene.yaml", "-o", "run.h5", "--restart", "run.h5", expect=2)
    run(folder, *go_on)
    run(folder, "cbr-dyn", "scene.yaml", "-o", "whole.h5")
    require_same(folder / "whole.h5", folder / "results.h5", "without checkpoints of its own")
    # The superelement made anew in another way between run and restart
    (folder / "scene.yaml").write_text((folder / "scene.yaml").read_text().replace("modes: 20", "modes: 21"))
    run(folder, "cbr-reduce", "scene.yaml")
    os.remove(folder / "results.h5")
    refused("superelements")
