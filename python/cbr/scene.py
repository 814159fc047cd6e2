# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes: what all programs read."""
from __future__ import annotations

import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Callable
from typing import Any

import numpy as np

from cbr.files import replace_text
from cbr.results import Results


class Failed(Exception):
    """A program ended with an error. `program`: its path. `returncode`: its exit code, 2 for bad input, or
    minus the number of the signal that ended it. `line`: the error as the program printed it, empty without one.
    As text: that line, the line of the scene that it names, and the name of a signal.

    >>> str(Failed("bin/cbr-dyn", 2, ["cbr-dyn: error: <stdin>:2: time.end: must be above 0"], '{\\n  "time": {"end": -1}\\n}'))
    'cbr-dyn: error: <stdin>:2: time.end: must be above 0; line 2: "time": {"end": -1}'
    >>> str(Failed("bin/cbr-dyn", -11, ["reading"], ""))
    'cbr-dyn: ended by SIGSEGV after the line: reading'
    """

    def __init__(self, program: str, returncode: int, lines: list[str], scene: str):
        self.program, self.returncode = program, returncode
        self.line = next((line for line in reversed(lines) if ": error: " in line), "")
        text, name = self.line, os.path.basename(program)
        if returncode < 0:
            text = f"{name}: ended by {signal.Signals(-returncode).name}" + (f" after the line: {lines[-1]}" if lines else "")
        elif not text:
            text = f"{name}: ended with exit code {returncode}" + "".join("\n" + line for line in lines)
        at, of_scene = re.search(r"<stdin>:(\d+):", text), scene.splitlines()
        if at and 0 < int(at[1]) <= len(of_scene):
            text += f"; line {at[1]}: {of_scene[int(at[1]) - 1].strip()}"
        super().__init__(text)


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
    told: list[str] = []
    with tempfile.TemporaryFile("w+", encoding="utf-8") as given:
        given.write(scene)
        given.seek(0)
        running = subprocess.Popen(command, cwd=cwd, encoding="utf-8", errors="replace", stdin=given, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE)
    with running:
        assert running.stderr is not None
        for line in running.stderr:
            told.append(line.rstrip("\n"))
            if progress:
                progress(told[-1])
    if running.returncode != 0:
        raise Failed(command[0], running.returncode, told, scene)


def _plain(value: Any) -> Any:
    """Of a value that JSON does not have. TypeError: a scene does not have it either."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{value!r}: a scene has dictionaries, lists, numbers, strings, paths and arrays, not a {type(value).__name__}")


def _is_written_scene(data: bytes) -> bool:
    """Of Scene.write: an object of JSON with keys of a scene."""
    try:
        found = json.loads(data)
    except ValueError:
        return False
    return isinstance(found, dict) and bool({"components", "instances", "materials"} & set(found))


class Scene(dict[str, Any]):
    """The keys of a scene (docs/formats.md) with Python's dictionaries, lists, numbers, strings and paths, and
    with numpy's numbers and arrays, whose rows are lists.

    >>> s = scene(materials={"steel": {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3, "density": 7850}})
    >>> s["time"] = {"end": np.float64(1e-3)}
    >>> sorted(s)
    ['materials', 'time']
    """

    def write(self, path: str | os.PathLike[str]) -> None:
        """As JSON, which is YAML too. File names in it are relative to the folder of `path`. OSError: a file
        is there that is no scene of this kind. TypeError: a value is none of a scene."""
        replace_text(path, self._text(), "a scene", _is_written_scene)

    def _text(self) -> str:
        return json.dumps(self, indent=2, default=_plain, ensure_ascii=False) + "\n"

    def run(self, path: str | os.PathLike[str], bin: str | os.PathLike[str] | None = None,
            progress: Callable[[str], object] | None = None) -> Results:
        """Reduces what has to be, runs the scene, and opens the results: NAME.h5 for a path NAME.yaml or
        NAME.h5. File names in the scene are relative to the folder of `path`. The scene itself goes to the
        programs' standard input; write() saves it. `bin`: the programs' folder, else $CBR_BIN, else PATH.
        `progress` is called with each line that the programs print while they run: progress=print.
        Failed: a program says what is wrong. FileNotFoundError: there is no such program. TypeError: as write().
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
