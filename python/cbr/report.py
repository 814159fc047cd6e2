# SPDX-License-Identifier: GPL-3.0-or-later
"""cbr-report: a page of a run, in one HTML file that needs no network."""
from __future__ import annotations

import argparse
import base64
import html
import io
import os
import pathlib
import re
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from cbr import pictures
from cbr.files import Refused, replace_text, require_replaceable
from cbr.pictures import COLOURS, Fields, label, printable
from cbr.results import Results, results
from cbr.superelement import Array, FileError, Superelement, open_file, read, superelement

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; color: #222 }
table { border-collapse: collapse; margin: 1em 0 }
th, td { text-align: left; padding: .2em 1em .2em 0; border-bottom: 1px solid #ddd }
tr.missed { background: #fde3e1 }
td.number { text-align: right; font-variant-numeric: tabular-nums }
figure { margin: 1em 0 } svg, img { max-width: 100%; height: auto }
"""
WORKS = ["work_external", "work_contact", "work_friction", "work_damping", "work_numerical"]
MOST_CURVES = 12  # instances or surfaces in one figure
MOST_WARNINGS = 20
MOST_FRAMES = 40  # of an animation
MOST_MODES = 12  # whose shapes are drawn
MOST_KEYS = 40  # in which two scenes differ


def number(x: float) -> str:
    """
    >>> number(0.1234567)
    '0.1235'
    """
    return f"{x:.4g}"


def escape(name: str) -> str:
    """A name as HTML shows it.

    >>> escape("a<b\\a")
    'a&lt;b\\\\x07'
    """
    return html.escape(printable(name))


def table(head: list[str], rows: list[list[str | float]]) -> str:
    """A table of HTML; numbers are at the right, and rows that end with the mark of judged() are marked.

    >>> print(table(["what", "how much"], [["steps <", 12.0]]))
    <table>
    <tr><th>what</th><th>how much</th></tr>
    <tr><td>steps &lt;</td><td class="number">12</td></tr>
    </table>
    """
    def cell(x: str | float) -> str:
        return f"<td>{escape(x)}</td>" if isinstance(x, str) else f'<td class="number">{number(x)}</td>'

    def is_missed(row: list[str | float]) -> bool:
        return isinstance(row[-1], str) and row[-1].startswith("above: ")

    lines = ["<table>", "<tr>" + "".join(f"<th>{escape(h)}</th>" for h in head) + "</tr>"]
    lines += ["<tr" + ' class="missed"' * is_missed(row) + ">" + "".join(cell(x) for x in row) + "</tr>" for row in rows]
    return "\n".join(lines + ["</table>"])


def figure(*draws: Callable[[Axes], None], height: float = 3.2) -> str:
    """What each of `draws` puts on a pair of axes, side by side, as SVG in the page."""
    with plt.rc_context({"svg.hashsalt": "cbr", "font.size": 9, "svg.fonttype": "none"}), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing")  # a browser has fonts of its own
        fig, axes = plt.subplots(1, len(draws), figsize=(8, height), layout="constrained", squeeze=False)
        for draw, axis in zip(draws, axes[0]):
            draw(axis)
            axis.spines[["top", "right"]].set_visible(False)
        out = io.StringIO()
        fig.savefig(out, format="svg", metadata={"Date": None, "Creator": None})
        plt.close(fig)
    text = out.getvalue()
    # Ids are the same in all figures, and a page has one of each
    figure.count = getattr(figure, "count", 0) + 1  # type: ignore[attr-defined]
    prefix = f"f{figure.count}-"  # type: ignore[attr-defined]
    text = re.sub(r'(\bid="|href="#|url\(#)', lambda m: m.group(0) + prefix, text[text.index("<svg"):])
    return f"<figure>{text}</figure>"


def image(data: bytes, kind: str, caption: str) -> str:
    """A picture in the page."""
    text = base64.b64encode(data).decode()
    return f'<figure><img alt="{escape(caption)}" src="data:image/{kind};base64,{text}"><figcaption>{escape(caption)}</figcaption></figure>'


Curve = tuple[str, str, Callable[[Array], Array]]  # label, dataset, and what to draw of it (n, from n x anything)


@dataclass
class Panel:
    """Curves on one pair of axes."""

    title: str
    unit: str
    named: list[Curve]


class Runs:
    """The run of the page and, when there is one, that to compare it with; curves of both on one figure."""

    def __init__(self, run: Results, other: Results | None):
        self.run, self.other = run, other

    def curves(self, *panels: Panel, height: float = 3.2) -> str:
        """A figure of the panels that have curves; the legend is beside those of the last."""
        shown = [panel for panel in panels if panel.named]

        def drawn(panel: Panel) -> Callable[[Axes], None]:
            def draw(axis: Axes) -> None:
                for i, (name, dataset, of) in enumerate(panel.named):
                    colour = COLOURS[i % len(COLOURS)]
                    axis.plot(self.run.time, of(self.run[dataset]), color=colour, label=label(name))
                    if self.other is not None and dataset in self.other:
                        axis.plot(self.other.time, of(self.other[dataset]), color=colour, linestyle="--", label=label(f"{name}, other"))
                axis.set_title(label(panel.title), loc="left")
                axis.set_xlabel("time")
                axis.set_ylabel(panel.unit)
                if panel is shown[-1]:
                    axis.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))

            return draw

        return figure(*map(drawn, shown), height=height) if shown else ""


def same(x: Array) -> Array:
    return x


def size(x: Array) -> Array:
    """Of each row.

    >>> size(np.array([[3.0, 4.0, 0.0]]))
    array([5.])
    """
    norms: Array = np.linalg.norm(x, axis=1)
    return norms


def largest(x: Array) -> Array:
    """Of each row.

    >>> largest(np.array([[3.0, 4.0], [2.0, 1.0]]))
    array([4., 2.])
    """
    most: Array = np.max(np.reshape(x, (len(x), -1)), axis=1)
    return most


def components(dataset: str, from_start: bool = False) -> list[Curve]:
    """Curves of the x, y and z of a dataset."""
    def component(axis: int) -> Callable[[Array], Array]:
        def of(x: Array) -> Array:
            return np.subtract(x[:, axis], from_start * x[0, axis])

        return of

    return [(name, dataset, component(axis)) for axis, name in enumerate("xyz")]


def percent(share: float) -> str:
    """Two digits, and never an exponent above.

    >>> percent(1.0), percent(0.9961), percent(0.0123)
    ('100 %', '100 %', '1.2 %')
    """
    x = 100 * share
    return f"{x:.0f} %" if x >= 10 else f"{x:.2g} %"


def kinds(run: Results) -> dict[str, str]:
    """What each instance is, as far as the results tell: those before version 1.8 do not name superelements."""
    if run.warnings is None:
        return dict.fromkeys(run.instances, "kind unknown")
    told = dict.fromkeys(run.instances, "mesh or rigid body")
    for name, (file, content_hash) in run.superelements.items():
        told[name] = "superelement"
        try:
            s = superelement(file)
        except FileError:
            continue
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
    rows: list[list[str | float]] = [[name, mine.get(name, "-"), theirs.get(name, "-")] for name in {**mine, **theirs}]
    try:
        lines = unlike(entries(run.scene), entries(other.scene), names) if run.scene and other.scene else []
    except FileError as error:
        lines = [f"The scenes are not compared: {error}."]
    if len(lines) > MOST_KEYS:
        lines[MOST_KEYS:] = [f"And in {len(lines) - MOST_KEYS} more."]
    return "\n".join([table(["what ran", *names], rows), *(["<ul>", *(f"<li>{escape(line)}</li>" for line in lines), "</ul>"] if lines else [])])


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


def keeps_momentum(run: Results) -> bool:
    """Whether the results tell that nothing outside the instances acts on them.

    Loads, walls and supports that move do work. Supports at rest leave a reaction, walls a pair without
    a surface, the ground a joint. Mass-proportional damping takes momentum, and results tell of no kind.
    """
    works = [f"energy/{w}" for w in ("work_external", "work_damping")]
    if not run.instances or any(name not in run or run[name].any() for name in works):
        return False
    bodies = [f"instances/{i}/" for i in run.instances]
    if any(name.startswith("joints/") or name.startswith(tuple(f"{b}reaction" for b in bodies)) for name in run):
        return False
    sides = [side for pair in run.pairs for side in pair.split(" - ")]
    return all(any(side.startswith(f"{i}.") for i in run.instances) for side in sides)


def warned(run: Results) -> str:
    """What cbr-dyn warned of. What it tells of the finished run comes first: that may make results wrong."""
    if run.warnings is None:
        return "<p>Results before version 1.8 do not hold the warnings of their run.</p>"
    if not run.warnings:
        return "<p>cbr-dyn warned of nothing.</p>"
    shown = run.warnings[::-1][:MOST_WARNINGS]
    lines = ["<ul>", *(f"<li>{escape(text)}</li>" for text in shown), "</ul>"]
    if len(run.warnings) > len(shown):
        lines.append(f"<p>And {len(run.warnings) - len(shown)} more, which were told before these.</p>")
    return "\n".join(lines)


def judged(what: str, figure: float, limit: float, good: str, meaning: str) -> list[str | float]:
    """A row of `checks`: a figure from its limit on is marked, with its meaning.

    >>> judged("drift", 0.5, 1e-10, "below 1e-10", "momentum is lost")
    ['drift', 0.5, 'below 1e-10', 'above: momentum is lost']
    """
    return [what, figure, good, "" if figure < limit else f"above: {meaning}"]


def face_size(run: Results, pair: str) -> float:
    """The root of the mean area of the smaller faces of a pair, of those that superelements keep; infinite: none does."""
    sizes = [np.inf]
    for instance, _, surface in (side.partition(".") for side in pair.split(" - ")):
        try:
            _, points, faces = pictures.kept_faces(*run.superelements[instance])
        except (FileError, KeyError):
            continue
        corners = [points[of] for name, of in faces.items() if surface in (name, "all")]
        sizes += [float(np.sqrt(size(np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])).mean() / 2)) for x in corners]
    return min(sizes)


def checks(run: Results) -> str:
    """Figures that tell whether the run can be trusted, each with what is good; others are marked."""
    rows: list[list[str | float]] = []
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
    parts = [runs.curves(Panel("Energy", "energy", [(w.replace("_", " "), f"energy/{w}", same) for w in ["total", *WORKS]
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
    rows: list[list[str | float]] = []
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
        for what, of, unit in (("force", size, "force"), ("area", same, "area in contact")):
            if f"contact/{pair}/{what}" in runs.run:
                parts.append(runs.curves(Panel(what.capitalize(), unit, [(what, f"contact/{pair}/{what}", of)])))
    return "\n".join(parts)


def at_the_start(run: Results) -> str:
    """A picture of the instances with the names of surfaces, and the pairs by number."""
    try:
        parts = pictures.at_start(run)
        data = pictures.start_picture(run, parts, MOST_CURVES)
    except FileError as error:
        return f"<p>No picture: {escape(str(error))}</p>"
    lines = [f"<li>{escape(pair)}</li>" for pair in run.pairs[:MOST_CURVES]]
    return image(data, "png", "The instances before the run") + (f"<p>Contact pairs:</p><ol>{''.join(lines)}</ol>" if lines else "")


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
    """The page of cbr-dyn --modes: frequencies, and pictures of the first mode shapes, at most MOST_MODES.
    FileError: there are none, or no fields with displacements beside them."""
    fields, shapes = Fields(path), []
    rows: list[list[str | float]] = []
    with open_file(path, "cbr-modes") as f:
        for name, group in f["instances"].items():
            found = zip(*(read(group[what]) for what in ("frequency_hz", "damping_ratio", "field_step")))
            for i, (hz, ratio, step) in enumerate(found):
                rows.append([name, float(i + 1), float(hz), float(ratio)])
                shapes.append((f"{name}, mode {i + 1}: {number(float(hz))} Hz", name.split("+"), int(step)))
    parts = ["<h2>Frequencies</h2>", table(["instance", "mode", "Hz", "damping ratio"], rows), "<h2>Shapes</h2>"]
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
    """Whether a dataset is zero but for round-off, or tells of round-off."""
    if name.endswith(("/residual", "/penetration")):
        return True
    if not name.endswith("/angular_momentum"):
        return False
    body = name.rsplit("/", 1)[0]
    arm = np.abs(run[f"{body}/center_of_mass"]).max()
    return bool(np.abs(run[name]).max() <= 1e-9 * arm * np.abs(run[f"{body}/momentum"]).max())


def differences(run: Results, other: Results) -> str:
    """Of each dataset that both have: the largest difference over time, and that at the end, of its largest value."""
    rows: list[list[str | float]] = []
    for name in run:
        if name == "time" or name not in other or run[name].shape[1:] != other[name].shape[1:]:
            continue
        if is_round_off(run, name):
            continue
        a, b = run[name].reshape(len(run.time), -1), other[name].reshape(len(other.time), -1)
        inside = run.time <= other.time[-1]
        at_a = np.column_stack([np.interp(run.time[inside], other.time, column) for column in b.T])
        scale = np.abs(a).max()
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
    words, seen = [], {os.path.realpath(s.path) for s in given}
    for file, content_hash in run.superelements.values():
        if os.path.realpath(file) in seen:
            continue
        seen.add(os.path.realpath(file))
        try:
            s = superelement(file)
        except FileError as error:  # gone since, or several domains
            words.append(f"<p>{escape(str(error))}</p>")
            continue
        words.append(in_words(s))
        if s.content_hash != content_hash:
            words.append(f"<p>{escape(file)} has been reduced again since this run.</p>")
    return words


def document(name: str, parts: list[str]) -> str:
    title, body = escape(name), "\n".join(parts)
    return (f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<meta name="generator" content="cbr-report">\n<title>{title}</title>\n'
            f"<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{body}\n</body>\n</html>\n")


def page(run: Results, other: Results | None = None, superelements: list[Superelement] | None = None, animate: bool = False) -> str:
    """The whole page, HTML. `superelements`: others than those of the run, which are found by their names.
    FileError: a file is damaged, or has no fields to animate."""
    figure.count = 0  # type: ignore[attr-defined]
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
    if not output.parent.is_dir():
        print(f"cbr-report: error: {output}: cannot be written, there is no folder '{output.parent}': make it first", file=sys.stderr)
        return 2
    if output.is_dir():
        print(f"cbr-report: error: {output}: cannot be written, it is a folder: give the name of a page", file=sys.stderr)
        return 2
    try:
        require_replaceable(output, "a page", _is_page)
    except Refused as error:
        print(f"cbr-report: error: {error}", file=sys.stderr)
        return 2
    try:
        with open_file(given.results, "cbr-results", "cbr-modes") as f:
            is_modes = f.attrs["format"] == "cbr-modes"
        text = modes(given.results, given.animate) if is_modes else page(
            results(given.results), results(given.compare) if given.compare else None,
            [superelement(path) for path in given.superelement], given.animate)
    except FileError as error:
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
