# SPDX-License-Identifier: GPL-3.0-or-later
"""Results: what cbr-dyn writes."""
from __future__ import annotations

import contextlib
import functools
import os
from collections.abc import Iterator, Mapping
from typing import Any

import h5py

from cbr.superelement import Array, FileError, attributes, child, open_file, read


class Results(Mapping[str, Array]):
    """Every dataset of a results file by its name, read when it is asked for.

    >>> import cbr, tempfile, h5py, os
    >>> path = os.path.join(tempfile.mkdtemp(), "r.h5")
    >>> with h5py.File(path, "w") as f:
    ...     f.attrs["format"] = "cbr-results"
    ...     f.attrs["warnings"] = "the energy balance does not close"
    ...     f["time"] = [0.0, 1.0]
    ...     f["instances/left/momentum"] = [[1.0, 0.0, 0.0], [0.5, 0.0, 0.0]]
    >>> r = cbr.results(path)
    >>> r.instances
    ['left']
    >>> r.warnings
    ['the energy balance does not close']
    >>> r["instances/left/momentum"][-1]
    array([0.5, 0. , 0. ])
    """

    def __init__(self, path: str | os.PathLike[str]):
        self.path = os.fspath(path)
        self._names: list[str] = []
        with open_file(path, "cbr-results") as f:
            self.attributes = attributes(f)
            bodies = {name: attributes(body) for name, body in child(f, "instances").items()}
            self._superelements = {name: (str(of["superelement"]), str(of.get("superelement_hash", "")))
                                   for name, of in bodies.items() if "superelement" in of}
            share = f["energy"].attrs.get("outside_basis") if child(f, "energy") else None
            self.outside_basis: float | None = None if share is None else float(share)  # share of the energy; None: unknown
            f.visititems(lambda name, item: self._names.append(name) if isinstance(item, h5py.Dataset) else None)

    def __getitem__(self, name: str) -> Array:
        if name not in self._names:
            raise KeyError(f"{self.path}: no dataset '{name}'; there are: {', '.join(self._names)}")
        with open_file(self.path, "cbr-results") as f:
            values: Array = read(f[name])
        return values

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def _groups(self, above: str) -> list[str]:
        names = [name.split("/") for name in self._names if name.startswith(above + "/")]
        return list(dict.fromkeys(parts[1] for parts in names if len(parts) > 2))

    @property
    def time(self) -> Array:
        """Of each output."""
        return self["time"]

    @property
    def instances(self) -> list[str]:
        return self._groups("instances")

    @property
    def pairs(self) -> list[str]:
        """Names of the contact pairs: 'left.contact - right.contact'."""
        return self._groups("contact")

    @property
    def surfaces(self) -> list[str]:
        """Surfaces with a history."""
        return self._groups("surfaces")

    @property
    def warnings(self) -> list[str] | None:
        """The warnings of cbr-dyn, in order. None: the file is older than version 1.8 and has none."""
        return str(self.attributes["warnings"]).splitlines() if "warnings" in self.attributes else None

    @functools.cached_property
    def scene(self) -> dict[str, Any]:
        """The scene of the run: dictionaries and lists of texts; empty before version 1.12. FileError: no PyYAML, or damaged."""
        try:
            import yaml
        except ImportError as error:
            raise FileError(f"{self.path}: its scene needs Debian's python3-yaml (PyYAML), which is not installed") from error
        try:
            found = yaml.load(str(self.attributes.get("scene", "{}")), Loader=yaml.BaseLoader)
        except yaml.YAMLError:
            found = None
        if not isinstance(found, dict):
            raise FileError(f"{self.path}: attribute 'scene' is damaged")
        return found

    @property
    def superelements(self) -> dict[str, tuple[str, str]]:
        """Of the instances that are superelements, since version 1.8: file, and content_hash that it had."""
        folder = os.path.dirname(self.path)
        return {name: (os.path.join(folder, file), content_hash) for name, (file, content_hash) in self._superelements.items()}

    @property
    def covered_hz(self) -> dict[str, float]:
        """Of instances that are superelements: the frequency, Hz, up to which theirs are right to 1 %, and histories of
        them with them; 0: none is. Left out: without that figure, or where the file is gone or has been made again."""
        found = {}
        for name, (file, content_hash) in self.superelements.items():
            with contextlib.suppress(FileError), open_file(file, "cbr-superelement") as f:
                figures = child(f, "accuracy")
                if "covered_hz" in figures and f.attrs.get("content_hash") == content_hash:
                    found[name] = float(read(figures["covered_hz"])[0])
        return found

    @property
    def seconds(self) -> dict[str, float]:
        """Wall time of each phase of the run."""
        start = "wall_seconds_"
        return {k[len(start):]: float(v) for k, v in self.attributes.items() if k.startswith(start)}


def results(path: str | os.PathLike[str]) -> Results:
    """Opens the results of a run. FileError: the file is none."""
    return Results(path)
