#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The three programs on disks that are full or closed, killed, and side by side: what was there stays whole, the message names the
path, the exit code is 1; an interrupted run goes on to the same bytes. usage: faults.py BIN_DIR [CASE ...]. Exit 77 without h5py."""
import itertools
import os
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

try:
    import h5py
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

BIN = Path(sys.argv[1]).resolve()
NOBODY = 65534
CELLS, SIZE = (5, 6, 6), (1.0, 1.0, 1.0)
SCENE = """
materials: {m: {youngs_modulus: 1, poissons_ratio: 0.3, density: 1}}
components:
  block: {mesh: box.msh, material: m, reduction: {interface: contact, modes: 20}}
  full: {mesh: box.msh, material: m}
instances:
  left: {component: block, as: superelement, position: [-1.001, 0, 0], velocity: [0.02, 0.005, 0]}
  right: {component: full, as: mesh, position: [1.02, 0.03, 0.02], mirror: x}
contact: [{between: [left.contact, right.contact], friction: 0.2}]
time: {end: END, integrator: exact}
output: {every: 0.1, history: [left.contact, right.contact]MORE}
"""
FIELDS = ", fields: [displacement, contact_pressure]"


def write_mesh(name, cells=CELLS):
    """A box of hexes, its face at x = 1 named 'contact' (gmsh 2.2)."""
    number = {at: 1 + i for i, at in enumerate(itertools.product(*(range(n + 1) for n in cells)))}
    nodes = [f"{i} " + " ".join(str(a * s / n) for a, s, n in zip(at, SIZE, cells)) for at, i in number.items()]
    ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
    elements = []
    for x, y, z in itertools.product(*(range(n) for n in cells)):
        elements.append("5 2 1 1 " + " ".join(str(number[x + a, y + b, z + c]) for c in (0, 1) for a, b in ring))
    for y, z in itertools.product(range(cells[1]), range(cells[2])):
        elements.append("3 2 2 2 " + " ".join(str(number[cells[0], y + a, z + b]) for a, b in ring))
    parts = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "2", '3 1 "solid"', '2 2 "contact"', "$EndPhysicalNames",
             "$Nodes", str(len(nodes)), *nodes, "$EndNodes",
             "$Elements", str(len(elements)), *(f"{i} {e}" for i, e in enumerate(elements, 1)), "$EndElements", ""]
    name.write_text("\n".join(parts))


def scene(folder, more="", end=4, name="scene.yaml"):
    (folder / name).write_text(SCENE.replace("END", str(end)).replace("MORE", more))
    return name


def start(folder, program, *arguments, before=None, **options):
    environment = dict(os.environ, OPENBLAS_NUM_THREADS="1")
    return subprocess.Popen([BIN / program, "-q", *map(str, arguments)], cwd=folder, stdout=options.pop("stdout", subprocess.DEVNULL),
                            stderr=subprocess.PIPE, text=True, preexec_fn=before, env=environment, **options)


def run(folder, program, *arguments, expect=0, **options):
    """Runs to the end; the text of its errors."""
    process = start(folder, program, *arguments, **options)
    errors = process.communicate()[1]
    assert process.returncode == expect, f"{program} {arguments}: exit {process.returncode}, not {expect}: {errors}"
    if expect:
        told = [line for line in errors.splitlines() if ": warning: " not in line]
        assert len(told) == 1 and ": error: " in told[0], errors
    return errors


def datasets(path):
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: (item.dtype, item.shape, item[()].tobytes())})
                        if isinstance(item, h5py.Dataset) else None)
    return found


def require_same(a, b, what):
    a, b = datasets(a), datasets(b)
    assert len(a) > 10, what
    differing = sorted(name for name in a.keys() | b.keys() if a.get(name) != b.get(name))
    assert not differing, f"{what}: {len(differing)} of {len(a)} datasets differ: {differing[:5]}"


def require_no_temporary(folder, what=""):
    left = [name for name in os.listdir(folder) if name.endswith(".tmp")]
    assert not left, (what, left)


def prepared(folder):
    write_mesh(folder / "box.msh")
    run(folder, "cbr-reduce", scene(folder))


CALLS = {"block.cbr.h5": ("cbr-reduce", "scene.yaml", "--force"),
         "skinned.msh": ("cbr-skin", "box.msh", "--sideset", "contact", "-o", "skinned.msh"),
         "results.h5": ("cbr-dyn", "scene.yaml", "-o", "results.h5")}


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
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size["results.h5"], size["results.h5"]))
    run(folder, "cbr-dyn", "kept.yaml", "-o", "kept.h5")
    if (folder / "kept.checkpoint.h5").stat().st_size > size["results.h5"]:
        before = (folder / "kept.checkpoint.h5").read_bytes()
        errors = run(folder, "cbr-dyn", "kept.yaml", "-o", "kept.h5", before=limit)
        assert errors.count("\n") == 1 and "warning: checkpoint" in errors and "kept.checkpoint.h5" in errors, errors
        assert (folder / "kept.checkpoint.h5").read_bytes() == before
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
    os.chmod(folder, 0o555)
    as_nobody = (lambda: os.setuid(NOBODY)) if os.geteuid() == 0 else None
    try:
        require_refused(folder, "Permission denied", lambda path: as_nobody)
    finally:
        os.chmod(folder, 0o755)
    # Inputs that may not be read
    os.chmod(folder / "box.msh", 0o000)
    errors = run(folder, "cbr-reduce", "scene.yaml", "--force", expect=2, before=as_nobody)
    assert "box.msh" in errors and "Permission denied" in errors, errors


def wait_for(condition, process, seconds=20):
    until = time.monotonic() + seconds
    while not condition() and process.poll() is None and time.monotonic() < until:
        time.sleep(0.002)


def long_scene(folder, more=", checkpoint: {every_steps: 40}", name="long.yaml"):
    return scene(folder, more, 60, name)


def case_signals(folder):
    """The first ends a run at the next step with what there is, the previous file of the others stays; nothing is left behind."""
    prepared(folder)
    run(folder, "cbr-dyn", long_scene(folder, FIELDS, "plain.yaml"), "-o", "whole.h5")
    long_scene(folder, ", checkpoint: {every_steps: 40}" + FIELDS)
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
    (folder / "large.cbr.h5").write_text("before"), (folder / "skinned.msh").write_text("before")
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
        (folder / "part.h5").write_text("before")
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
    assert (folder / "part.h5").read_text() == "before"
    require_no_temporary(folder)
    os.remove(folder / "part.h5")
    run(folder, "cbr-dyn", "long.yaml", "-o", "part.h5", "--restart", "part.checkpoint.h5")
    scene(folder, "", 60, "plain.yaml")
    run(folder, "cbr-dyn", "plain.yaml", "-o", "whole.h5")
    require_same(folder / "whole.h5", folder / "part.h5", "full disk")


def case_signal_in_the_check(folder):
    """--check-error runs twice: a signal in the second run ends it, and the first one's results are whole."""
    prepared(folder)
    long_scene(folder, "")
    for number in (signal.SIGINT, signal.SIGTERM):
        for attempt in range(10):
            process = start(folder, "cbr-dyn", "long.yaml", "-o", "checked.h5", "--check-error", "--timings", "checked.csv")
            wait_for((folder / "checked.h5").exists, process, 60)
            process.send_signal(number)
            errors = process.communicate()[1]
            if process.returncode != 0:
                break
            os.remove(folder / "checked.h5")
        told = [line for line in errors.splitlines() if ": warning: " not in line]
        assert process.returncode == 1 and len(told) == 1, (process.returncode, errors)
        for word in (number.name, "--check-error", "checked.h5"):
            assert word in told[0], errors
        with h5py.File(folder / "checked.h5") as whole:
            assert whole.attrs["partial"] == 0
        assert (folder / "checked.csv").exists()
        require_no_temporary(folder)
        os.remove(folder / "checked.h5")


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


def case_replaced_meanwhile(folder):
    """A mesh that is written to while a program reads it."""
    prepared(folder)
    write_mesh(folder / "large.msh", (12, 12, 12))
    (folder / "large.yaml").write_text((folder / "scene.yaml").read_text().replace("box.msh", "large.msh"))
    run(folder, "cbr-reduce", "large.yaml")
    (folder / "skinned.msh").write_text("before")
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
    refused("0.0.1")
    (folder / "run.h5").write_bytes(whole)
    refused("diagonal-limit", *go_on, "--diagonal-limit", 10)
    scene(folder, ", checkpoint: {every_steps: 10, file: run.h5}" + FIELDS, end=5)
    refused("another scene")
    scene(folder, ", checkpoint: {every_steps: 10, file: box.msh}")
    errors = run(folder, "cbr-dyn", "scene.yaml", "-o", "results.h5", expect=2)
    assert "box.msh" in errors and "is no checkpoint" in errors and "scene.yaml:" in errors, errors
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


def main():
    cases = {name[5:]: function for name, function in globals().items() if name.startswith("case_")}
    for name in sys.argv[2:] or cases:
        begin = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            os.chmod(folder, 0o755)
            note = cases[name](Path(folder)) or ""
        print(f"{name}: {time.monotonic() - begin:.1f} s {note}", flush=True)


if __name__ == "__main__":
    main()
