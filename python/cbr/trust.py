# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a run can be trusted: its warnings, and figures beside their limits."""
from __future__ import annotations

import contextlib

import numpy as np

from cbr import pictures
from cbr.page import Row, listed, number, size, table
from cbr.results import Results
from cbr.superelement import FileError

WORKS = ["work_external", "work_contact", "work_friction", "work_damping", "work_numerical"]
MOST_WARNINGS = 20


def warned(run: Results) -> str:
    """The warnings of cbr-dyn, the last first: those of the finished run may mean that the results are wrong."""
    if run.warnings is None:
        return "<p>Results before version 1.8 do not hold the warnings of their run.</p>"
    if not run.warnings:
        return "<p>cbr-dyn warned of nothing.</p>"
    more = len(run.warnings) - MOST_WARNINGS
    return listed(run.warnings[::-1][:MOST_WARNINGS]) + (f"\n<p>And {more} more, which were told before these.</p>" if more > 0 else "")


def keeps_momentum(run: Results) -> bool:
    """Whether nothing outside the instances acts on them, by the datasets that there are.

    Loads, walls and supports that move do work. Supports at rest leave a reaction, walls a pair without
    a surface, the ground a joint. Mass-proportional damping takes momentum, and results do not name the kind of damping.
    """
    works = [f"energy/{w}" for w in ("work_external", "work_damping")]
    if not run.instances or any(name not in run or run[name].any() for name in works):
        return False
    bodies = [f"instances/{i}/" for i in run.instances]
    if any(name.startswith("joints/") or name.startswith(tuple(f"{b}reaction" for b in bodies)) for name in run):
        return False
    sides = [side for pair in run.pairs for side in pair.split(" - ")]
    return all(any(side.startswith(f"{i}.") for i in run.instances) for side in sides)


def judged(what: str, figure: float, limit: float, good: str, meaning: str) -> Row:
    """A row of `checks`: a figure from its limit on is marked, with its meaning.

    >>> judged("drift", 0.5, 1e-10, "below 1e-10", "momentum is lost")
    ['drift', 0.5, 'below 1e-10', 'above: momentum is lost']
    """
    return [what, figure, good, "" if figure < limit else f"above: {meaning}"]


def face_size(run: Results, pair: str) -> float:
    """The root of the mean area of the smaller faces of a pair, of those that superelements keep; infinite: none does."""
    sizes = [np.inf]
    for instance, _, surface in (side.partition(".") for side in pair.split(" - ")):
        with contextlib.suppress(FileError, KeyError):
            _, points, faces = pictures.kept_faces(*run.superelements[instance])
            corners = [points[of] for name, of in faces.items() if surface in (name, "all")]
            sizes += [float(np.sqrt(size(np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])).mean() / 2)) for x in corners]
    return min(sizes)


def checks(run: Results) -> str:
    """Figures by which a user can trust the run or not, each with its limit; those beyond it are marked."""
    rows: list[Row] = []
    if run.warnings:
        rows.append(judged("warnings, told above", float(len(run.warnings)), 1, "0", "read them"))
    if "energy/total" in run:
        total = run["energy/total"]
        works = np.sum([run[f"energy/{w}"] for w in WORKS if f"energy/{w}" in run], axis=0)
        scale = max(np.abs(total).max(), np.abs(works).max())
        if scale > 0:
            off = np.abs(total - total[0] - (works - works[0])).max() / scale
            rows.append(judged("energy that work does not account for", float(off), 1e-8, "below 1e-8",
                               "an error, where the energy itself is not round-off"))
            gain = (total - total[0] - (run["energy/work_external"] if "energy/work_external" in run else 0)).max()
            rows.append(judged("energy above that of the start and of loads, share", float(max(gain, 0) / scale), 1e-3,
                               "below 1e-3", "contact brought energy: take a smaller step"))
    if run.outside_basis is not None:
        rows.append(judged("energy outside the basis, share", run.outside_basis, 0.05, "below 0.05, a few per cent",
                           "contact took it from short waves, which go on in the real bodies; forces and the rebound "
                           "of whole bodies are right to less than that. More modes or a finer mesh at the face lower it"))
    if keeps_momentum(run):
        momenta = [run[f"instances/{i}/momentum"] for i in run.instances]
        p, most = np.sum(momenta, axis=0), max(float(size(m).max()) for m in momenta)
        if most > 0:
            rows.append(judged("drift of momentum, share", float(np.linalg.norm(p[-1] - p[0]) / most), 1e-10,
                               "below 1e-10", "an error"))
        spins = [run[f"instances/{i}/angular_momentum"] for i in run.instances if f"instances/{i}/angular_momentum" in run]
        arm = max(float(size(run[f"instances/{i}/center_of_mass"]).max()) for i in run.instances) if spins else 0
        about, most = np.sum(spins, axis=0), max((float(size(L).max()) for L in spins), default=0) + arm * most
        if most > 0:
            is_exact = all(f"instances/{i}/orientation" in run for i in run.instances)
            rows.append(judged("drift of angular momentum, share", float(np.linalg.norm(about[-1] - about[0]) / most),
                               1e-10 if is_exact else 1e-2, "below 1e-10" if is_exact else "below 1e-2, as rotations are taken as small",
                               "an error" if is_exact else "instances rotate too far for small rotations: time.rotations: large"))
    for pair in run.pairs:
        tenth = 0.1 * face_size(run, pair)
        deep = f"below {number(tenth)}, a tenth of a face" if tenth < np.inf else "small beside the elements; 0 with impulse"
        for what, good, limit, meaning in (("residual", "below 1e-6", 1e-6, "not all gaps could be closed or opened"),
                                           ("penetration", deep, tenth, "refine the coarser surface, or take shorter steps")):
            if f"contact/{pair}/{what}" in run:
                rows.append(judged(f"{what} of {pair}, largest", float(run[f"contact/{pair}/{what}"].max()), limit, good, meaning))
    return table(["check", "figure", "good", "mark"], rows) if rows else ""
