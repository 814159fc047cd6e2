# SPDX-License-Identifier: GPL-3.0-or-later
"""cbr-report: a page of a run, in one HTML file that needs no network."""
from __future__ import annotations

import argparse
import html
import io
import os
import pathlib
import re
import sys
from collections.abc import Callable

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from cbr.files import Refused, replace_text, require_replaceable
from cbr.results import Array, Results, results
from cbr.superelement import FileError, Superelement, superelement

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; color: #222 }
table { border-collapse: collapse; margin: 1em 0 }
th, td { text-align: left; padding: .2em 1em .2em 0; border-bottom: 1px solid #ddd }
td.number { text-align: right; font-variant-numeric: tabular-nums }
figure { margin: 1em 0 } svg { max-width: 100%; height: auto }
"""
COLOURS = ["#1f3b73", "#b3202c", "#2a9d4a", "#e07b00", "#7b2d8e", "#555555"]
WORKS = ["work_external", "work_contact", "work_friction", "work_damping", "work_numerical"]
MOST_CURVES = 12  # instances or surfaces in one figure
MOST_WARNINGS = 20


def number(x: float) -> str:
    """
    >>> number(0.1234567)
    '0.1235'
    """
    return f"{x:.4g}"


def table(head: list[str], rows: list[list[str | float]]) -> str:
    """A table of HTML; numbers are at the right.

    >>> print(table(["what", "how much"], [["steps <", 12.0]]))
    <table>
    <tr><th>what</th><th>how much</th></tr>
    <tr><td>steps &lt;</td><td class="number">12</td></tr>
    </table>
    """
    def cell(x: str | float) -> str:
        return f"<td>{html.escape(x)}</td>" if isinstance(x, str) else f'<td class="number">{number(x)}</td>'

    lines = ["<table>", "<tr>" + "".join(f"<th>{html.escape(h)}</th>" for h in head) + "</tr>"]
    lines += ["<tr>" + "".join(cell(x) for x in row) + "</tr>" for row in rows]
    return "\n".join(lines + ["</table>"])


def figure(draw: Callable[[Axes], None], height: float = 3.2) -> str:
    """What `draw` puts on a pair of axes, as SVG in the page."""
    with plt.rc_context({"svg.hashsalt": "cbr", "font.size": 9}):
        fig, axis = plt.subplots(figsize=(8, height), layout="constrained")
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


class Runs:
    """The run of the page and, when there is one, that to compare it with; curves of both on one figure."""

    def __init__(self, run: Results, other: Results | None):
        self.run, self.other = run, other

    def curves(self, title: str, unit: str, named: list[tuple[str, str, Callable[[Array], Array]]]) -> str:
        """named: label, dataset, and what to draw of it (n, from n or n x 3)."""
        def draw(axis: Axes) -> None:
            for i, (label, name, of) in enumerate(named):
                colour = COLOURS[i % len(COLOURS)]
                axis.plot(self.run.time, of(self.run[name]), color=colour, label=label)
                if self.other is not None and name in self.other:
                    axis.plot(self.other.time, of(self.other[name]), color=colour, linestyle="--",
                              label=f"{label}, other")
            axis.set_title(title, loc="left")
            axis.set_xlabel("time")
            axis.set_ylabel(unit)
            axis.legend(frameon=False, fontsize=8)

        return figure(draw) if named else ""


def same(x: Array) -> Array:
    return x


def size(x: Array) -> Array:
    """Of each row.

    >>> size(np.array([[3.0, 4.0, 0.0]]))
    array([5.])
    """
    norms: Array = np.linalg.norm(x, axis=1)
    return norms


def along(axis: int) -> Callable[[Array], Array]:
    def component(x: Array) -> Array:
        return x[:, axis]

    return component


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
    """A column for each run, and below them a line for each thing in which their scenes differ."""
    mine = of_what_ran(run)
    if other is None:
        return table(["what ran", ""], [[name, value] for name, value in mine.items()])
    theirs = of_what_ran(other)
    names = [pathlib.Path(r.path).name for r in (run, other)]
    rows: list[list[str | float]] = [[name, mine.get(name, "-"), theirs.get(name, "-")] for name in {**mine, **theirs}]
    lines = [f"<li>{html.escape(line)}</li>" for line in unlike(mine, theirs, names)]
    return "\n".join([table(["what ran", *names], rows), *(["<ul>", *lines, "</ul>"] if lines else [])])


def unlike(mine: dict[str, str | float], theirs: dict[str, str | float], names: list[str]) -> list[str]:
    """Sentences on what makes two runs those of different scenes.

    >>> unlike({"end": 1.0, "instance a": "superelement"}, {"end": 2.0}, ["p.h5", "q.h5"])
    ['The runs differ in end: 1 in p.h5, 2 in q.h5.', 'Only p.h5 has the instance a.']
    """
    say = []
    for what in {**mine, **theirs}:
        if what not in ("end", "dofs") and not what.startswith("instance "):
            continue
        if what not in mine or what not in theirs:
            say.append(f"Only {names[what not in mine]} has the {what}.")
        elif mine[what] != theirs[what]:
            a, b = (x if isinstance(x, str) else f"{x:.10g}" for x in (mine[what], theirs[what]))
            say.append(f"The runs differ in {what}: {a} in {names[0]}, {b} in {names[1]}.")
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


def warnings(run: Results) -> str:
    """What cbr-dyn warned of. What it tells of the finished run comes first: that may make results wrong."""
    if run.warnings is None:
        return "<p>Results before version 1.8 do not hold the warnings of their run.</p>"
    if not run.warnings:
        return "<p>cbr-dyn warned of nothing.</p>"
    shown = run.warnings[::-1][:MOST_WARNINGS]
    lines = ["<ul>", *(f"<li>{html.escape(text)}</li>" for text in shown), "</ul>"]
    if len(run.warnings) > len(shown):
        lines.append(f"<p>And {len(run.warnings) - len(shown)} more, which were told before these.</p>")
    return "\n".join(lines)


def judged(what: str, figure: float, limit: float, good: str, meaning: str) -> list[str | float]:
    """A row of `checks`: a figure from its limit on is marked, with its meaning.

    >>> judged("drift", 0.5, 1e-10, "below 1e-10", "momentum is lost")
    ['drift', 0.5, 'below 1e-10', 'above: momentum is lost']
    """
    return [what, figure, good, "" if figure < limit else f"above: {meaning}"]


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
        p, largest = np.sum(momenta, axis=0), max(float(size(m).max()) for m in momenta)
        if largest > 0:
            rows.append(judged("drift of momentum, share", float(np.linalg.norm(p[-1] - p[0]) / largest), 1e-10,
                               "below 1e-10", "an error"))
    for pair in run.pairs:
        for what, good, limit in (("residual", "below 1e-6", 1e-6),
                                  ("penetration", "small beside the elements; 0 with impulse", np.inf)):
            if f"contact/{pair}/{what}" in run:
                rows.append(judged(f"{what} of {pair}, largest", float(run[f"contact/{pair}/{what}"].max()), limit, good,
                                   "not all gaps could be closed or opened"))
    return table(["check", "figure", "good", "mark"], rows) if rows else ""


def timings(run: Results) -> str:
    def draw(axis: Axes) -> None:
        names = list(run.seconds)
        axis.barh(names, [run.seconds[n] for n in names], color=COLOURS[0])
        axis.invert_yaxis()
        axis.set_title("Wall time of the phases", loc="left")
        axis.set_xlabel("s")

    return figure(draw, 1.8) if run.seconds else ""


def motion(runs: Runs) -> str:
    run = runs.run
    parts = [runs.curves("Energy", "energy", [(w.replace("_", " "), f"energy/{w}", same) for w in ["total", *WORKS]
                                              if f"energy/{w}" in run and (w == "total" or run[f"energy/{w}"].any())])]
    for axis in range(3):
        names = [i for i in run.instances if np.ptp(run[f"instances/{i}/momentum"][:, axis]) > 0][:MOST_CURVES]
        largest = max((np.abs(run[f"instances/{i}/momentum"]).max() for i in run.instances), default=0)
        if any(np.abs(run[f"instances/{i}/momentum"][:, axis]).max() > 1e-6 * largest for i in names):
            parts.append(runs.curves(f"Momentum along {'xyz'[axis]}", "momentum",
                                     [(i, f"instances/{i}/momentum", along(axis)) for i in names]))
    return "\n".join(parts)


def contact(runs: Runs) -> str:
    parts = []
    for pair in runs.run.pairs:
        parts.append(f"<h3>{html.escape(pair)}</h3>")
        for what, of, unit in (("force", size, "force"), ("area", same, "area in contact")):
            if f"contact/{pair}/{what}" in runs.run:
                parts.append(runs.curves(what.capitalize(), unit, [(pair, f"contact/{pair}/{what}", of)]))
    return "\n".join(parts)


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
    return "<p>" + html.escape(" ".join(say)) + "</p>"


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
            words.append(f"<p>{html.escape(str(error))}</p>")
            continue
        words.append(in_words(s))
        if s.content_hash != content_hash:
            words.append(f"<p>{html.escape(file)} has been reduced again since this run.</p>")
    return words


def page(run: Results, other: Results | None = None, superelements: list[Superelement] | None = None) -> str:
    """The whole page, HTML. `superelements`: others than those of the run, which are found by their names."""
    figure.count = 0  # type: ignore[attr-defined]
    name = pathlib.Path(run.path).name
    runs = Runs(run, other)
    parts = [f"<h1>{html.escape(name)}</h1>"]
    if other is not None:
        parts.append(f"<p>Compared with {html.escape(pathlib.Path(other.path).name)}, which is drawn with dashes.</p>")
    parts += [what_ran(run, other), "<h2>Warnings</h2>", warnings(run)]
    if other is not None:
        parts += [f"<h2>Warnings of {html.escape(pathlib.Path(other.path).name)}</h2>", warnings(other)]
    parts += ["<h2>Can it be trusted</h2>", checks(run)]
    if other is not None:
        parts += ["<h2>Differences</h2>", differences(run, other)]
    parts += ["<h2>Motion</h2>", motion(runs)]
    if run.pairs:
        parts += ["<h2>Contact</h2>", contact(runs)]
    given = superelements or []
    words = [*of_run(run, given), *(in_words(s) for s in given)]
    if words:
        parts += ["<h2>Superelements</h2>", *words]
    parts += ["<h2>Time</h2>", timings(run)]
    body = "\n".join(parts)
    return (f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<meta name="generator" content="cbr-report">\n<title>{html.escape(name)}</title>\n'
            f"<style>{STYLE}</style>\n</head>\n<body>\n{body}\n</body>\n</html>\n")


def _is_page(data: bytes) -> bool:
    return b'name="generator" content="cbr-report"' in data[:300]


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="cbr-report", description=__doc__)
    parser.add_argument("results", help="what cbr-dyn wrote")
    parser.add_argument("-o", "--output", required=True, metavar="RUN.html", help="the page")
    parser.add_argument("--compare", metavar="OTHER.h5", help="results to draw on top, with a table of differences")
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
        text = page(results(given.results), results(given.compare) if given.compare else None,
                    [superelement(path) for path in given.superelement])
    except (FileError, OSError, KeyError) as error:
        # A KeyError as text is its words in quotes
        print(f"cbr-report: error: {error.args[0] if isinstance(error, KeyError) else error}", file=sys.stderr)
        return 2
    try:
        replace_text(output, text, "a page", _is_page)
    except OSError as error:
        print(f"cbr-report: error: {output}: cannot be written: {error.strerror}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
