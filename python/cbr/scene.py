# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes: what all programs read."""
from __future__ import annotations

import json
import os
import pathlib
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from typing import Any

from cbr.files import replace_text
from cbr.results import Results


class Failed(Exception):
    """A program ended with an error; `returncode` is its exit code, 2 when the input is to blame."""

    def __init__(self, program: str, returncode: int, message: str):
        super().__init__(f"{program}: {message}")
        self.program, self.returncode = program, returncode


def _program(name: str, folder: str | os.PathLike[str] | None) -> str:
    folder = folder or os.environ.get("CBR_BIN")
    found = shutil.which(name, path=os.fspath(folder) if folder else None)
    if found is None:
        where = f"in {folder}" if folder else "on PATH"
        raise FileNotFoundError(f"{name} is not {where}: set CBR_BIN to the folder of the programs")
    return os.path.abspath(found)


def _run(program: str, *arguments: str, scene: str, cwd: pathlib.Path, bin: str | os.PathLike[str] | None,
         progress: Callable[[str], object] | None) -> None:
    command = [_program(program, bin), *([] if progress else ["--quiet"]), "-", *arguments]
    told = []
    with tempfile.TemporaryFile("w+") as given:
        given.write(scene)
        given.seek(0)
        running = subprocess.Popen(command, cwd=cwd, text=True, stdin=given, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    with running:
        assert running.stderr is not None
        for line in running.stderr:
            told.append(line.rstrip("\n"))
            if progress:
                progress(told[-1])
    if running.returncode != 0:
        errors = [line for line in told if ": error: " in line]
        message = errors[-1].split(": error: ", 1)[1] if errors else "\n".join(told)
        raise Failed(program, running.returncode, message)


def _is_written_scene(data: bytes) -> bool:
    """Of Scene.write: an object of JSON with keys of a scene."""
    try:
        found = json.loads(data)
    except ValueError:
        return False
    return isinstance(found, dict) and bool({"components", "instances", "materials"} & set(found))


class Scene(dict[str, Any]):
    """The keys of a scene (docs/formats.md) with Python's dictionaries, lists, numbers and strings.

    >>> s = scene(materials={"steel": {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3, "density": 7850}})
    >>> s["time"] = {"end": 1e-3}
    >>> sorted(s)
    ['materials', 'time']
    """

    def write(self, path: str | os.PathLike[str]) -> None:
        """As JSON, which is YAML too. File names in it are relative to the folder of `path`. OSError: a file
        is there that is no scene of this kind."""
        replace_text(path, self._text(), "a scene", _is_written_scene)

    def _text(self) -> str:
        return json.dumps(self, indent=2) + "\n"

    def run(self, path: str | os.PathLike[str], bin: str | os.PathLike[str] | None = None,
            progress: Callable[[str], object] | None = None) -> Results:
        """Reduces what has to be, runs the scene, and opens the results: NAME.h5 for a path NAME.yaml or
        NAME.h5. File names in the scene are relative to the folder of `path`. The scene itself goes to the
        programs' standard input; write() saves it. `bin`: the programs' folder, else $CBR_BIN, else PATH.
        `progress` is called with each line that the programs print while they run: progress=print.
        Failed: a program says what is wrong. FileNotFoundError: there is no such program.
        """
        path = pathlib.Path(path)
        out = path.with_suffix(".h5")
        scene = self._text()
        if any(i.get("as") not in ("mesh", "rigid") for i in self.get("instances", {}).values()):
            _run("cbr-reduce", scene=scene, cwd=path.parent, bin=bin, progress=progress)
        if "skin" in self:
            _run("cbr-skin", scene=scene, cwd=path.parent, bin=bin, progress=progress)
        _run("cbr-dyn", "-o", out.name, scene=scene, cwd=path.parent, bin=bin, progress=progress)
        return Results(out)


def scene(**keys: Any) -> Scene:
    """A scene of these keys: materials, components, instances, walls, contact, time, output, ..."""
    return Scene(keys)
