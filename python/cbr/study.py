# SPDX-License-Identifier: GPL-3.0-or-later
"""One scene with one parameter after the other."""
from __future__ import annotations

import copy
import os
import pathlib
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cbr.results import Results
from cbr.scene import Failed, Scene
from cbr.superelement import Array


def _text(value: Any) -> str:
    if isinstance(value, (list, tuple, np.ndarray)) and np.ndim(value) > 0:
        return f"[{', '.join(map(_text, value))}]"
    return f"{value:.6g}" if isinstance(value, (float, np.floating)) else str(value)


@dataclass
class Study:
    """What study() made of v values.

    >>> made = Study("time.end", [1e-3, 2e-3], [], {"energy": np.array([1.5, np.nan])}, {1: "cbr-dyn: ended by SIGKILL"})
    >>> print(made)
    time.end  energy
    0.001     1.5
    0.002     nan     cbr-dyn: ended by SIGKILL
    """

    parameter: str
    values: list[Any]            # v, as they were given
    runs: list[Results | None]   # v; None: the run failed
    columns: dict[str, Array]    # name -> v figures; nan where the run failed
    failures: dict[int, str]     # index of a value -> the error of its run

    def __str__(self) -> str:
        """The table: a row for each value, and behind it the error of a run that failed."""
        rows = [[self.parameter, *self.columns, ""]]
        for i, value in enumerate(self.values):
            figures = [f"{column[i]:.6g}" for column in self.columns.values()]
            rows.append([_text(value), *figures, self.failures.get(i, "")])
        widths = [max(len(row[j]) for row in rows) for j in range(len(rows[0]))]
        return "\n".join("  ".join(text.ljust(width) for text, width in zip(row, widths)).rstrip() for row in rows)


def largest_figures(run: Results) -> dict[str, float]:
    """Of a run: the energy at its end; of each contact pair the largest force; of each set with stress the largest
    von Mises stress, in the scene's units."""
    found = {"energy": float(run["energy/total"][-1])}
    found |= {f"force of {pair}": float(np.linalg.norm(run[f"contact/{pair}/force"], axis=1).max()) for pair in run.pairs}
    stress = {name.split("/")[1]: name for name in run if name.startswith("stress/") and name.endswith("/von_mises")}
    return found | {f"von Mises of {name}": float(run[dataset].max(initial=0)) for name, dataset in stress.items()}


def _change(scene: Scene, parameter: str, value: Any) -> Scene:
    """A copy of the scene in which the key PARAMETER (names and numbers of list entries, joined by dots) has a value."""
    changed = Scene(copy.deepcopy(dict(scene)))
    *above, last = parameter.split(".")
    at: Any = changed
    for depth, name in enumerate([*above, last]):
        inside = ".".join(above[:depth]) or "the scene"
        key: Any = name
        if isinstance(at, list):
            if not name.isdecimal() or int(name) >= len(at):
                raise KeyError(f"{parameter}: {inside} has entries 0 to {len(at) - 1}, not '{name}'")
            key = int(name)
        elif not isinstance(at, dict) or (depth < len(above) and name not in at):
            raise KeyError(f"{parameter}: {inside} has no '{name}'; it has: {', '.join(at) if isinstance(at, dict) else at}")
        if depth == len(above):
            at[key] = value
        elif isinstance(at[key], (tuple, np.ndarray)):  # an array of whole numbers would round the value
            at[key] = list(at[key])
        at = at[key]
    return changed


def _show(done: int, n: int, start: float) -> None:
    """A bar on a terminal, else a line."""
    left = f", {(time.monotonic() - start) / done * (n - done):.0f} s left" if 0 < done < n else ""
    bar = f"[{'#' * (30 * done // n):<30}] {done} of {n} runs{left}"
    on_terminal = sys.stderr.isatty()
    print(f"\r{bar:<70}" if on_terminal else bar, end="" if on_terminal and done < n else "\n", file=sys.stderr, flush=True)


def study(scene: Scene, parameter: str, values: Iterable[Any], path: str | os.PathLike[str] = "study.h5",
          measures: Mapping[str, Callable[[Results], float]] | None = None, bin: str | os.PathLike[str] | None = None,
          progress: bool = True) -> Study:
    """Runs the scene once for each of v values of one parameter, and makes a table of the runs.

    parameter: names of keys and numbers of list entries, from 0, joined by dots: 'instances.part.rotation',
    'loads.0.force.2'. Its last key may be new. values: v of them, in the scene's units; rows of an array are lists.
    path: the run of value i is NAME-i.h5, from 1, in its folder, to which file names of the scene are relative. The
    runs share superelements, which are reduced again only where the parameter changes them.
    measures: name of a column -> its figure of a run; the default is largest_figures(). bin: as of Scene.run().
    progress: a bar on the standard error.

    A run that fails, or a value that is refused, leaves nan and its error. Failed: the first value is refused.
    KeyError: the scene has no such parameter. ValueError: there are no values.
    """
    path, values = pathlib.Path(path), list(values)
    scenes = [_change(scene, parameter, value) for value in values]
    if not scenes:
        raise ValueError("values: there are none to study")
    runs: list[Results | None] = []
    rows: list[dict[str, float]] = []
    failures, start = {}, time.monotonic()
    for i, changed in enumerate(scenes):
        if progress:
            _show(i, len(scenes), start)
        try:
            run = changed.run(path.with_name(f"{path.stem}-{i + 1}.h5"), bin)
        except Failed as error:
            if error.returncode == 2 and i == 0:
                raise
            failures[i] = str(error).splitlines()[0]
            runs.append(None)
            rows.append({})
        else:
            runs.append(run)
            try:
                rows.append(largest_figures(run) if measures is None else {name: float(of(run)) for name, of in measures.items()})
            except Exception as error:
                if i == 0:
                    raise
                failures[i] = f"measures: {error!r}"
                rows.append({})
    if progress:
        _show(len(scenes), len(scenes), start)
    names = dict.fromkeys(name for row in rows for name in row)
    columns = {name: np.array([row.get(name, np.nan) for row in rows]) for name in names}
    return Study(parameter, values, runs, columns, failures)
