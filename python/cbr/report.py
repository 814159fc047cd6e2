# SPDX-License-Identifier: GPL-3.0-or-later
"""cbr-report: a page of a run, in one HTML file that needs no network."""
from __future__ import annotations

import argparse
import collections
import contextlib
import os
import pathlib
import sys
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from cbr import pictures
from cbr.files import Refused, replace_text, require_replaceable
from cbr.page import Curve, Panel, Row, Runs, components, document, escape, figure, image, largest, listed, number, percent, size, table
from cbr.pictures import COLOURS, Fields
from cbr.results import Results, results
from cbr.superelement import FileError, Superelement, open_file, read, superelement
from cbr.trust import WORKS, checks, warned

MOST_CURVES = 12  # instances or surfaces in one figure
MOST_FRAMES = 40  # of an animation
MOST_MODES = 12  # whose shapes are drawn
MOST_KEYS = 40  # in which two scenes differ


def kinds(run: Results) -> dict[str, str]:
    """The kind of each instance. Results before version 1.8 do not name superelements."""
    if run.warnings is None:
        return dict.fromkeys(run.instances, "kind unknown")
    told = dict.fromkeys(run.instances, "mesh or rigid body")
    for name, (file, content_hash) in run.superelements.items():
        told[name] = "superelement"
        with contextlib.suppress(FileError):
            s = superelement(file)
            if s.content_hash == content_hash:
                told[name] = f"superelement, {s.basis}, {len(s.K)} coordinates"
    return told


def of_what_ran(run: Results) -> dict[str, str | float]:
    steps, end = float(run.attributes.get("steps", 0)), float(run.time[-1])
    rows: dict[str, str | float] = {
        "program": str(run.attributes.get("generator", "?")), "instances": ", ".join(run.instances),
        "dofs": float(run.attributes.get("n_dofs", 0)), "steps": steps}
    if steps > 0 and end > 0:
        rows["step length, mean"] = end / steps
    rows["end"] = end
    rows |= {f"instance {name}": kind for name, kind in kinds(run).items()}
    if run.attributes.get("partial", 0):
        rows["state"] = "the run was stopped before its end"
    return rows


def what_ran(run: Results, other: Results | None = None) -> str:
    """A column for each run, and below them a line for each key in which their scenes differ."""
    mine = of_what_ran(run)
    if other is None:
        return table(["what ran", ""], [[name, value] for name, value in mine.items()])
    theirs = of_what_ran(other)
    names = [pathlib.Path(r.path).name for r in (run, other)]
    rows: list[Row] = [[name, mine.get(name, "-"), theirs.get(name, "-")] for name in {**mine, **theirs}]
    try:
        lines = unlike(entries(run.scene), entries(other.scene), names) if run.scene and other.scene else []
    except FileError as error:
        lines = [f"The scenes are not compared: {error}."]
    if len(lines) > MOST_KEYS:
        lines[MOST_KEYS:] = [f"And in {len(lines) - MOST_KEYS} more."]
    return table(["what ran", *names], rows) + listed(lines)


def entries(scene: Any, above: str = "") -> dict[str, str]:
    """The keys of a scene, joined by dots, and their values.

    >>> entries({"time": {"end": "1"}, "contact": [{"between": ["a.s", "b.s"]}]})
    {'time.end': '1', 'contact.0.between': 'a.s, b.s'}
    """
    if isinstance(scene, list) and any(isinstance(entry, dict) for entry in scene):
        scene = {str(i): entry for i, entry in enumerate(scene)}
    if isinstance(scene, dict):
        return {key: value for name, of in scene.items() for key, value in entries(of, f"{above}.{name}" if above else name).items()}
    return {above: ", ".join(str(entry) for entry in scene) if isinstance(scene, list) else str(scene)}


def unlike(mine: dict[str, str], theirs: dict[str, str], names: list[str]) -> list[str]:
    """Sentences on the keys in which two scenes differ, from entries() of each.

    >>> unlike({"time.end": "1", "time.cfl": "0.5"}, {"time.end": "2"}, ["p.h5", "q.h5"])
    ['The runs differ in time.end: 1 in p.h5, 2 in q.h5.', 'Only p.h5 has the key time.cfl: 0.5.']
    """
    say = []
    for key in {**mine, **theirs}:
        if key not in mine or key not in theirs:
            say.append(f"Only {names[key not in mine]} has the key {key}: {mine.get(key, theirs.get(key))}.")
        elif mine[key] != theirs[key]:
            say.append(f"The runs differ in {key}: {mine[key]} in {names[0]}, {theirs[key]} in {names[1]}.")
    return say


def timings(run: Results) -> str:
    def draw(axis: Axes) -> None:
        names = list(run.seconds)
        axis.barh(names, [run.seconds[n] for n in names], color=COLOURS[0])
        axis.invert_yaxis()
        axis.set_title("Wall time of the phases", loc="left")
        axis.set_xlabel("s")

    return figure(draw, height=1.8) if run.seconds else ""


def motion(runs: Runs) -> str:
    run = runs.run
    parts = [runs.curves(Panel("Energy", "energy", [(w.replace("_", " "), f"energy/{w}", np.asarray) for w in ["total", *WORKS]
                                                    if f"energy/{w}" in run and (w == "total" or run[f"energy/{w}"].any())]))]
    most = max((np.abs(run[f"instances/{i}/momentum"]).max() for i in run.instances), default=0)
    for axis in range(3):
        names = [i for i in run.instances if np.ptp(run[f"instances/{i}/momentum"][:, axis]) > 0][:MOST_CURVES]
        if any(np.abs(run[f"instances/{i}/momentum"][:, axis]).max() > 1e-6 * most for i in names):
            curves: list[Curve] = [(i, *components(f"instances/{i}/momentum")[axis][1:]) for i in names]
            parts.append(runs.curves(Panel(f"Momentum along {'xyz'[axis]}", "momentum", curves)))
    return "\n".join(parts)


def histories(runs: Runs) -> str:
    """Of each surface or point in output.history: displacement, velocity, acceleration, and the rotation of points."""
    parts, run = [], runs.run
    covered = run.covered_hz if run.surfaces else {}
    for name in run.surfaces[:MOST_CURVES]:
        instance = name.split(".")[0]
        drawn = (("displacement", "mean_position", True), ("velocity", "mean_velocity", False),
                 ("acceleration", "mean_acceleration", False), ("rotation, rad", "rotation", False))
        parts += [f"<h3>{escape(name)}</h3>", runs.curves(*(
            Panel(title, "", components(f"surfaces/{name}/{of}", from_start)) for title, of, from_start in drawn
            if f"surfaces/{name}/{of}" in run), height=2.4)]
        if instance in covered:
            parts.append(f"<p>Frequencies of {escape(instance)} are right to 1 % up to {number(covered[instance])} Hz: filter above it.</p>")
    return "\n".join(parts)


def reactions(runs: Runs) -> str:
    """Forces of supports, and forces and moments of the sets of output.reactions."""
    names = [name.rsplit("/", 1)[0] for name in runs.run if name.startswith("instances/") and name.endswith("/force")]
    of_all = [name for name in runs.run if name.startswith("instances/") and name.endswith("/reaction")]
    parts = [runs.curves(Panel(f"All supports of {name.split('/')[1]}", "force", components(name))) for name in of_all]
    for name in names:
        instance, set_name = name.split("/")[1], name.split("/", 3)[3]
        parts.append(runs.curves(Panel(f"{instance}.{set_name}: force", "force", components(f"{name}/force")),
                                 Panel("moment", "moment", components(f"{name}/moment"))))
    return "\n".join(parts)


def stress(runs: Runs) -> str:
    """Of output.stress: the largest von Mises stress of each set over time, and where and when it is largest."""
    run = runs.run
    rows: list[Row] = []
    names = [name for name in run if name.startswith("stress/") and name.endswith("/von_mises")]
    for name in names:
        values, group = run[name], name.rsplit("/", 1)[0]
        ids = next((run[f"{group}/{kind}_id"] for kind in ("node", "element") if f"{group}/{kind}_id" in run), None)
        if ids is None or values.size == 0:
            continue
        at = np.unravel_index(values.argmax(), values.shape)
        when = run[f"{name}_time"][at] if f"{name}_time" in run else run.time[at[0]]
        rows.append([group[len("stress/"):], float(values[at]), f"{'node' if f'{group}/node_id' in run else 'element'} "
                     f"{ids[at if ids.shape == values.shape else at[-1]]}", float(when)])
    curves: list[Curve] = [(name[len("stress/"):-len("/von_mises")], name, largest) for name in names if "/envelope/" not in name]
    return (runs.curves(Panel("Largest von Mises stress", "stress", curves[:MOST_CURVES])) +
            table(["where", "largest von Mises stress", "at", "time"], rows)) if names else ""


def contact(runs: Runs) -> str:
    parts = []
    for pair in runs.run.pairs:
        parts.append(f"<h3>{escape(pair)}</h3>")
        curves: list[Curve] = [("force", f"contact/{pair}/force", size), ("area", f"contact/{pair}/area", np.asarray)]
        parts += [runs.curves(Panel(curve[0].capitalize(), unit, [curve])) for curve, unit in zip(curves, ("force", "area in contact"))
                  if curve[1] in runs.run]
    return "\n".join(parts)


def at_the_start(run: Results) -> str:
    """A picture of the instances with the names of surfaces, and the pairs by number."""
    try:
        parts = pictures.at_start(run)
        data = pictures.start_picture(run, parts, MOST_CURVES)
    except FileError as error:
        return f"<p>No picture: {escape(str(error))}</p>"
    pairs = listed(run.pairs[:MOST_CURVES], "ol")
    return image(data, "png", "The instances before the run") + (f"<p>Contact pairs:</p>{pairs}" if pairs else "")


def nice(x: float) -> float:
    """The largest 1, 2 or 5 times a power of ten that is not above x.

    >>> nice(37.0), nice(0.6)
    (20.0, 0.5)
    """
    power = 10.0**np.floor(np.log10(x))
    return float(max(m * power for m in (1, 2, 5) if m * power <= x * (1 + 1e-12)))


def animation(run: Results) -> str:
    """The motion in up to MOST_FRAMES outputs, in colours of the von Mises stress where fields have it."""
    fields = Fields(run.path)
    steps = np.unique(np.linspace(0, len(fields.times) - 1, MOST_FRAMES).round().astype(int)).tolist()
    moved = [fields.displacements(step) for step in steps]
    if any(u is None for u in moved):
        raise FileError(f"{fields.path}: has no displacement to animate: give output.fields: [displacement] in the scene")
    stresses = [fields.stresses(step) for step in steps]
    most = max((float(of.max(initial=0)) for values in stresses for of in values or ()), default=0)
    reach = max(float(np.abs(x).max(initial=0)) for u in moved for x in u or ())
    whole = float(np.ptp(np.vstack([part.points for part in fields.parts]), axis=0).max())
    scale = nice(0.05 * whole / reach) if 0 < reach < 0.02 * whole else 1.0
    frames = [(f"time {number(float(fields.times[step]))}", [part.points + scale * x for part, x in zip(fields.parts, u or ())], values)
              for step, u, values in zip(steps, moved, stresses)]
    caption = ["Displacements" + (f" {scale:.15g} times as large" if scale != 1 else ""),
               f"colours: von Mises stress from 0 to {number(most)}" if most > 0 else "colours: instances"]
    return image(pictures.gif(fields.parts, frames, most), "gif", "; ".join(caption))


def modes(path: str, animate: bool = False) -> str:
    """The page of cbr-dyn --modes: frequencies, and pictures of the first elastic mode shapes, at most MOST_MODES.
    FileError: there are none, or no fields with displacements beside them."""
    fields, shapes = Fields(path), []
    rows: list[Row] = []
    with open_file(path, "cbr-modes") as f:
        for name, group in f["instances"].items():
            found = zip(*(read(group[what]) for what in ("frequency_hz", "damping_ratio", "field_step")))
            for i, (hz, ratio, step) in enumerate(found):
                rows.append([name, float(i + 1), float(hz), float(ratio)])
                if hz > 0:
                    shapes.append((f"{name}, mode {i + 1}: {number(float(hz))} Hz", name.split("+"), int(step)))
    parts = ["<h2>Frequencies</h2>", table(["instance", "mode", "Hz", "damping ratio"], rows)]
    rigid = collections.Counter(str(name) for name, _, hz, _ in rows if hz == 0)
    parts += [f"<p>{escape(name)}: rigid motions (0 Hz), not drawn: {n}.</p>" for name, n in rigid.items()]
    parts += ["<h2>Shapes</h2>"] if shapes else []
    for title, instances, step in shapes[:MOST_MODES]:
        u = fields.displacements(step)
        if u is None:
            raise FileError(f"{fields.path}: has no displacement: give output.fields: [displacement] in the scene")
        moving = [(part, x) for part, x in zip(fields.parts, u) if part.instance in instances]
        amount = [np.linalg.norm(x[part.faces], axis=2).mean(axis=1) for part, x in moving]
        most, shown = max(float(of.max(initial=0)) for of in amount), [part for part, _ in moving]
        scale = 0.1 * float(np.ptp(np.vstack([part.points for part in shown]), axis=0).max()) / (most or 1)
        frames = [("", [part.points + scale * factor * x for part, x in moving], amount)
                  for factor in (np.cos(np.arange(20) * np.pi / 10) if animate else [1.0])]
        if animate:
            parts.append(image(pictures.gif(shown, frames, most), "gif", title))
            continue
        corners = pictures.extent([frames[0][1]])
        fig, axis = pictures.sheet(corners)
        pictures.draw(axis, shown, frames[0][1], corners, amount, most)
        parts.append(image(pictures.png(fig), "png", title))
    if len(shapes) > MOST_MODES:
        parts.append(f"<p>The other {len(shapes) - MOST_MODES} are in {escape(fields.path)}.</p>")
    return document(pathlib.Path(path).name, parts)


def is_round_off(run: Results, name: str) -> bool:
    """Whether a dataset is zero but for round-off, or measures round-off."""
    if name.endswith(("/residual", "/penetration")):
        return True
    if not name.endswith("/angular_momentum"):
        return False
    body = name.rsplit("/", 1)[0]
    arm = np.abs(run[f"{body}/center_of_mass"]).max()
    return bool(np.abs(run[name]).max() <= 1e-9 * arm * np.abs(run[f"{body}/momentum"]).max())


def differences(run: Results, other: Results) -> str:
    """Of each dataset that both have: the largest difference over time, and that at the end, of its largest value."""
    rows: list[Row] = []
    for name in run:
        if (name == "time" or name not in other or run[name].shape[1:] != other[name].shape[1:]
                or run[name].dtype.kind != "f" or is_round_off(run, name)):
            continue
        inside = run.time <= other.time[-1]
        if "/envelope/" in name or name.endswith("/point"):  # once for all outputs
            a, at_a = run[name].reshape(1, -1), other[name].reshape(1, -1)
            inside = np.full(1, a.shape == at_a.shape)
        else:
            a, b = run[name].reshape(len(run.time), -1), other[name].reshape(len(other.time), -1)
            at_a = np.column_stack([np.interp(run.time[inside], other.time, column) for column in b.T])
        scale = np.abs(a).max(initial=0)
        if scale > 0 and inside.any():
            off = np.abs(a[inside] - at_a) / scale
            rows.append([name, float(scale), float(off.max()), float(off[-1].max())])
    rows.sort(key=lambda row: -float(row[2]))
    return table(["dataset", "largest value", "largest difference, share", "at the last common time"], rows)


def in_words(s: Superelement) -> str:
    """The error figures of a superelement as sentences."""
    say = [f"{s.path}: basis {s.basis}, {len(s.K)} coordinates, {len(s.node)} interface dofs, mass {number(s.mass)}."]
    if "covered_hz" in s.accuracy:
        covered, complete = s.accuracy["covered_hz"], s.accuracy["complete_hz"]
        say.append(f"Frequencies are right to 1 % up to {number(covered)} Hz." if covered > 0
                   else "No frequency is known to be right to 1 %.")
        say.append(f"No mode is missing below {number(complete)} Hz.")
    if s.accuracy.get("largest_left_out", 0) > 0:
        say.append(f"Accelerations of the interface leave out {percent(s.accuracy['largest_left_out'])} of the "
                   "interior's strain energy at most.")
    # Those of the file cost nothing, the others all eigenvalues of the matrices
    told = np.atleast_1d(s.accuracy["frequency_hz"]) if "frequency_hz" in s.accuracy else s.frequencies()
    elastic = [f for f in told if f > 0][:10]
    if elastic:
        say.append("Lowest frequencies, Hz: " + ", ".join(number(f) for f in elastic) + ".")
    return "<p>" + escape(" ".join(say)) + "</p>"


def of_run(run: Results, given: list[Superelement]) -> list[str]:
    """Words on the superelements of the run's instances, but for those that are given."""
    words, files = [], {os.path.realpath(of[0]): of for of in run.superelements.values()}
    for file, content_hash in (of for path, of in files.items() if path not in {os.path.realpath(s.path) for s in given}):
        try:
            s = superelement(file)
        except FileError as error:  # gone since, or several domains
            words.append(f"<p>{escape(str(error))}</p>")
            continue
        words.append(in_words(s))
        if s.content_hash != content_hash:
            words.append(f"<p>{escape(file)} has been reduced again since this run.</p>")
    return words


def page(run: Results, other: Results | None = None, superelements: list[Superelement] | None = None, animate: bool = False) -> str:
    """The whole page, HTML. `superelements`: others than those of the run, which are found by their names.
    FileError: a file is damaged, or has no fields to animate."""
    runs, given = Runs(run, other), superelements or []
    compared = "" if other is None else escape(pathlib.Path(other.path).name)
    sections = [
        ("", f"<p>Compared with {compared}, which is drawn with dashes.</p>" if compared else ""), ("", what_ran(run, other)),
        ("Start", at_the_start(run)), ("Warnings", warned(run)),
        (f"Warnings of {compared}", warned(other) if other is not None else ""), ("Can it be trusted", checks(run)),
        ("Differences", differences(run, other) if other is not None else ""), ("Motion", motion(runs)),
        ("Animation", animation(run) if animate else ""), ("Histories", histories(runs)), ("Reactions", reactions(runs)),
        ("Stress", stress(runs)), ("Contact", contact(runs)),
        ("Superelements", "\n".join([*of_run(run, given), *(in_words(s) for s in given)])), ("Time", timings(run))]
    return document(pathlib.Path(run.path).name, [f"<h2>{title}</h2>\n{text}" if title else text for title, text in sections if text])


def _is_page(data: bytes) -> bool:
    return b'name="generator" content="cbr-report"' in data[:300]


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="cbr-report", description=__doc__)
    parser.add_argument("results", help="what cbr-dyn wrote: results, or the modes of --modes")
    parser.add_argument("-o", "--output", required=True, metavar="RUN.html", help="the page")
    parser.add_argument("--compare", metavar="OTHER.h5", help="results to draw on top, with a table of differences")
    parser.add_argument("--animate", action="store_true", help="show the motion of the fields, or of the mode shapes")
    parser.add_argument("--superelement", action="append", default=[], metavar="FILE.cbr.h5",
                        help="a superelement whose frequencies and errors to tell too, beside those of the run; may be given again")
    given = parser.parse_args(arguments)
    output = pathlib.Path(given.output)
    try:
        if not output.parent.is_dir():
            raise Refused(f"{output}: cannot be written, there is no folder '{output.parent}': make it first")
        if output.is_dir():
            raise Refused(f"{output}: cannot be written, it is a folder: give the name of a page")
        require_replaceable(output, "a page", _is_page)
        with open_file(given.results, "cbr-results", "cbr-modes") as f:
            is_modes = f.attrs["format"] == "cbr-modes"
        text = modes(given.results, given.animate) if is_modes else page(
            results(given.results), results(given.compare) if given.compare else None,
            [superelement(path) for path in given.superelement], given.animate)
    except (FileError, Refused) as error:
        print(f"cbr-report: error: {error}", file=sys.stderr)
        return 2
    try:
        replace_text(output, text, "a page", _is_page)
    except OSError as error:
        print(f"cbr-report: error: {output}: cannot be written: {error.strerror}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
