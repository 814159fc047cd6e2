# SPDX-License-Identifier: GPL-3.0-or-later
"""The error of a reduction in one scene: a run beside that of the full meshes."""
from __future__ import annotations

import copy
import os
import pathlib
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cbr.results import Results
from cbr.scene import Scene
from cbr.superelement import Array


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.sum(np.square(values), axis=-1))))


def _share(difference: float, size: float) -> float:
    return 0.0 if difference == 0 else difference / size if size > 0 else float("inf")


@dataclass
class ErrorCheck:
    """Shares by which a run differs from that of the full meshes, of each surface with a history and
    of each instance; `run` and `reference` are the results.

    position, velocity: rms over the outputs, of the rms motion and velocity of the surface in the
    reference. momentum: the largest difference, of the largest momentum. energy: the largest difference
    of kinetic plus strain energy, of the largest total energy.

    >>> check = ErrorCheck({"a.tip": {"position": 0.02, "velocity": 0.1}}, {"a": {"momentum": 0.0, "energy": 0.03}})
    >>> check.largest
    0.1
    >>> print(check)
    a.tip: position 2 %, velocity 10 %
    a: momentum 0 %, energy 3 %
    """

    surfaces: dict[str, dict[str, float]]
    instances: dict[str, dict[str, float]]
    run: Results | None = None
    reference: Results | None = None

    @property
    def largest(self) -> float:
        return max(share for shares in (*self.surfaces.values(), *self.instances.values()) for share in shares.values())

    def __str__(self) -> str:
        return "\n".join(f"{name}: " + ", ".join(f"{what} {100 * share:.2g} %" for what, share in shares.items())
                         for name, shares in (*self.surfaces.items(), *self.instances.items()))


def compare(run: Results, reference: Results) -> ErrorCheck:
    """Of two runs with the same outputs. ValueError: their times differ."""
    if len(run.time) != len(reference.time) or not np.allclose(run.time, reference.time, rtol=1e-9, atol=0):
        raise ValueError(f"{run.path} and {reference.path} have outputs at other times: give output.every")
    surfaces, instances = {}, {}
    for name in run.surfaces:
        of = {what: (run[f"surfaces/{name}/mean_{what}"], reference[f"surfaces/{name}/mean_{what}"]) for what in ("position", "velocity")}
        sizes = {"position": _rms(of["position"][1] - of["position"][1][0]), "velocity": _rms(of["velocity"][1])}
        surfaces[name] = {what: _share(_rms(ours - theirs), sizes[what]) for what, (ours, theirs) in of.items()}
    total = float(np.abs(reference["energy/total"]).max())
    for name in run.instances:
        p, exact = (of[f"instances/{name}/momentum"] for of in (run, reference))
        energy, exact_energy = (of[f"instances/{name}/kinetic_energy"] + of[f"instances/{name}/strain_energy"] for of in (run, reference))
        instances[name] = {"momentum": _share(float(np.linalg.norm(p - exact, axis=1).max()), float(np.linalg.norm(exact, axis=1).max())),
                           "energy": _share(float(np.abs(energy - exact_energy).max()), total)}
    return ErrorCheck(surfaces, instances, run, reference)


def check_error(scene: Scene, path: str | os.PathLike[str] = "check.h5", bin: str | os.PathLike[str] | None = None,
                progress: Callable[[str], object] | None = None) -> ErrorCheck:
    """Runs the scene twice, as Scene.run() does: as it is, and with the full mesh of every superelement
    (NAME-mesh.h5 beside NAME.h5), with short steps, as its own error must be small beside it. So the figures are the error itself, whatever the basis: fewer modes
    or shorter steps show how a run changes, which is less than its error wherever the error falls slowly.
    Both have 200 outputs where the scene does not say how many (`output.every`).
    The second run takes five times as long as the full meshes do: shorten `time.end` to check a long run.
    ValueError: the scene has no superelement, or one without a mesh. Failed: as of Scene.run(), also
    where the full meshes cannot do what the scene asks (damping of modes).
    """
    path, scene = pathlib.Path(path), Scene(copy.deepcopy(dict(scene)))
    every = scene.setdefault("output", {}).get("every", 0)
    if not every and not scene.get("time", {}).get("static"):
        scene["output"]["every"] = scene["time"]["end"] / 200
    reference = Scene(copy.deepcopy(dict(scene)))
    reduced = [name for name, of in reference["instances"].items() if of.get("as", "superelement") == "superelement"
               and ("reduction" in reference["components"][of["component"]] or "superelement" in reference["components"][of["component"]])]
    if not reduced:
        raise ValueError("the scene has no superelement: nothing is reduced in it")
    for name in reduced:
        instance = reference["instances"][name]
        if "mesh" not in reference["components"][instance["component"]]:
            raise ValueError(f"component '{instance['component']}' of instance '{name}' is a superelement alone: its error needs its mesh")
        instance["as"] = "mesh"
    contact = reference.get("contact", [])
    is_soft = isinstance(contact, list) and any(pair.get("enforcement") == "penalty" for pair in contact)
    if not is_soft and reference["time"].get("integrator") != "newmark" and not reference["time"].get("static"):
        reference["time"]["step"] = {"cfl": 0.2}  # the error of the step of auto is of the size of a good reduction's
    full = reference.run(path.with_name(path.stem + "-mesh" + path.suffix), bin, progress)
    return compare(scene.run(path, bin, progress), full)
