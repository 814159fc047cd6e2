# SPDX-License-Identifier: GPL-3.0-or-later
"""The programs, run in a folder of their own, and what they wrote."""
import copy
import json
import os
import pathlib
import resource
import subprocess

import h5py
import numpy as np

BIN = pathlib.Path(os.environ.get("BIN", "../../build/bin")).resolve()
SECONDS = 900      # a run that takes longer hangs
MEMORY = 6 << 30   # bytes of address space: none of these small runs needs more


class Failed(Exception):
    """A run ended otherwise than its row says."""


def is_sanitized():
    """Of a build under the address sanitizer, which keeps shadows of terabytes."""
    program = BIN / "cbr-dyn"
    return program.exists() and b"__asan_init" in program.read_bytes()


IS_SANITIZED = is_sanitized()


def limits():
    if not IS_SANITIZED:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


class Ran:
    """How a program ended, and what it said; `file`: what it was to write."""

    def __init__(self, folder, command, file):
        environment = dict(os.environ, OPENBLAS_NUM_THREADS=os.environ.get("OPENBLAS_NUM_THREADS", "1"))
        before = (folder / file).exists()
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace", timeout=SECONDS, preexec_fn=limits,
                              env=environment)
        self.code, self.stdout, self.file = done.returncode, done.stdout, folder / file
        self.text = done.stderr.replace(str(folder.resolve()) + "/", "").replace(str(folder) + "/", "")
        if self.code not in (0, 1, 2):
            raise Failed(f"{pathlib.Path(command[0]).name} ended with code {self.code}: {self.text[-300:]}")
        if self.code != 0 and (not self.error() or self.file.exists() > before):
            raise Failed("no message, or a file in spite of it: " + self.text[-300:])

    def error(self):
        lines = [line for line in self.text.splitlines() if ": error: " in line]
        return lines[-1].split(": error: ", 1)[1] if len(lines) == 1 else ""

    def warnings(self):
        return [line.split(": warning: ", 1)[1] for line in self.text.splitlines() if ": warning: " in line]

    def warned(self, words):
        return any(words in line for line in self.warnings())

    def done(self):
        """Ended well, and every number in the file is finite."""
        if self.code != 0:
            raise Failed(self.error())
        with h5py.File(self.file) as f:
            def check(name, item):
                if isinstance(item, h5py.Dataset) and item.dtype.kind == "f" and not np.isfinite(item[()]).all():
                    raise Failed(f"{name} in {self.file.name} is not finite")
            f.visititems(check)
        return self

    def __getitem__(self, name):
        with h5py.File(self.file) as f:
            return f[name][()]

    def __contains__(self, name):
        with h5py.File(self.file) as f:
            return name in f

    def attribute(self, name):
        with h5py.File(self.file) as f:
            return f.attrs[name]


STEEL = {"youngs_modulus": 100.0, "poissons_ratio": 0.25, "density": 1.0}  # waves at 11, over blocks of size 1


class Folder:
    """Where one row's files are. `full`: the long runs, as of make stress."""

    def __init__(self, path, full):
        self.path, self.full, self.count = pathlib.Path(path), full, 0

    def mesh(self, part, name="mesh.msh", **options):
        part.write(self.path / name, **options)
        return name

    def program(self, name, *arguments, file):
        return Ran(self.path, [str(BIN / name), *map(str, arguments)], file)

    def scene(self, scene):
        self.count += 1
        name = f"scene{self.count}.yaml"
        text = scene if isinstance(scene, str) else json.dumps(scene, indent=1)
        (self.path / name).write_text(text)
        return name

    def reduce(self, scene, *options, component="block"):
        """cbr-reduce; what it wrote is the file of `component`."""
        return self.program("cbr-reduce", "--threads", 1, *options, self.scene(scene), file=f"{component}.cbr.h5")

    def dyn(self, scene, *options, reduce=True, threads=1):
        """cbr-reduce, where the scene has superelements, and cbr-dyn."""
        name = self.scene(scene)
        if reduce and '"reduction"' in (self.path / name).read_text():
            made = self.program("cbr-reduce", "--threads", threads, name, file="never")
            if made.code != 0:
                return made
        results = f"results{self.count}.h5"
        return self.program("cbr-dyn", "--threads", threads, *options, name, "-o", results, file=results)

    def superelement(self, part, interface, modes=4, material=None, options=(), sets=None, **component):
        """The component of this part alone, reduced."""
        return self.reduce(block_scene(self.mesh(part, sets=sets), interface, modes, material, **component), *options)


def reduction(interface, modes=4, **more):
    return {"interface": list(interface), "modes": modes, **more}


def block_scene(mesh, interface, modes=4, material=None, **component):
    part = {"mesh": mesh, "material": "steel", "reduction": reduction(interface, modes), **component}
    return {"materials": {"steel": dict(material or STEEL)}, "components": {"block": part}, "instances": {"a": {"component": "block"}}}


def changed(scene, *path, to):
    """A copy of the scene with the value at this path changed."""
    new = copy.deepcopy(scene)
    at = new
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = to
    return new
