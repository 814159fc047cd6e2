# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of a page in HTML: texts, tables, pictures, and curves of one run or of two."""
from __future__ import annotations

import base64
import functools
import html
import io
import itertools
import re
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from cbr.pictures import COLOURS, label, printable
from cbr.results import Results
from cbr.superelement import Array

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; color: #222 }
table { border-collapse: collapse; margin: 1em 0 }
th, td { text-align: left; padding: .2em 1em .2em 0; border-bottom: 1px solid #ddd }
tr.missed { background: #fde3e1 }
td.number { text-align: right; font-variant-numeric: tabular-nums }
figure { margin: 1em 0 } svg, img { max-width: 100%; height: auto }
"""
Row = list[str | float]  # of a table
Curve = tuple[str, str, Callable[[Array], Array]]  # label, dataset, and its figures to draw (n, from n x anything)


def number(x: float) -> str:
    """
    >>> number(0.1234567)
    '0.1235'
    """
    return f"{x:.4g}"


def percent(share: float) -> str:
    """Two digits, and never an exponent above.

    >>> percent(1.0), percent(0.9961), percent(0.0123)
    ('100 %', '100 %', '1.2 %')
    """
    x = 100 * share
    return f"{x:.0f} %" if x >= 10 else f"{x:.2g} %"


def escape(name: str) -> str:
    """A name as HTML shows it.

    >>> escape("a<b\\a")
    'a&lt;b\\\\x07'
    """
    return html.escape(printable(name))


def table(head: list[str], rows: list[Row]) -> str:
    """A table of HTML; numbers are at the right, and rows that end with the mark of judged() are marked.

    >>> print(table(["what", "how much"], [["steps <", 12.0]]))
    <table>
    <tr><th>what</th><th>how much</th></tr>
    <tr><td>steps &lt;</td><td class="number">12</td></tr>
    </table>
    """
    def cell(x: str | float) -> str:
        return f"<td>{escape(x)}</td>" if isinstance(x, str) else f'<td class="number">{number(x)}</td>'

    def is_missed(row: Row) -> bool:
        return isinstance(row[-1], str) and row[-1].startswith("above: ")

    lines = ["<table>", "<tr>" + "".join(f"<th>{escape(h)}</th>" for h in head) + "</tr>"]
    lines += ["<tr" + ' class="missed"' * is_missed(row) + ">" + "".join(cell(x) for x in row) + "</tr>" for row in rows]
    return "\n".join(lines + ["</table>"])


def listed(texts: list[str], kind: str = "ul") -> str:
    """A list of HTML (ul or ol), empty without texts."""
    return f"<{kind}>{''.join(f'<li>{escape(text)}</li>' for text in texts)}</{kind}>" if texts else ""


def figure(*draws: Callable[[Axes], None], height: float = 3.2) -> str:
    """Axes side by side as SVG in the page; each of `draws` draws on its own."""
    with plt.rc_context({"svg.hashsalt": "cbr", "font.size": 9, "svg.fonttype": "none"}), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing")  # a browser has fonts of its own
        fig, axes = plt.subplots(1, len(draws), figsize=(8, height), layout="constrained", squeeze=False)
        for draw, axis in zip(draws, axes[0]):
            draw(axis)
            axis.spines[["top", "right"]].set_visible(False)
        out = io.StringIO()
        fig.savefig(out, format="svg", metadata={"Date": None, "Creator": None})
        plt.close(fig)
    return f"<figure>{out.getvalue()[out.getvalue().index('<svg'):]}</figure>"


def image(data: bytes, kind: str, caption: str) -> str:
    """A picture in the page."""
    text = base64.b64encode(data).decode()
    return f'<figure><img alt="{escape(caption)}" src="data:image/{kind};base64,{text}"><figcaption>{escape(caption)}</figcaption></figure>'


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

        def draw(panel: Panel, axis: Axes) -> None:
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

        return figure(*(functools.partial(draw, panel) for panel in shown), height=height) if shown else ""


def size(x: Array) -> Array:
    """Of each row.

    >>> size(np.array([[3.0, 4.0, 0.0]]))
    array([5.])
    """
    return np.asarray(np.linalg.norm(x, axis=1))


def largest(x: Array) -> Array:
    """Of each row.

    >>> largest(np.array([[3.0, 4.0], [2.0, 1.0]]))
    array([4., 2.])
    """
    return np.asarray(np.max(np.reshape(x, (len(x), -1)), axis=1))


def components(dataset: str, from_start: bool = False) -> list[Curve]:
    """Curves of the x, y and z of a dataset."""
    def component(axis: int, x: Array) -> Array:
        return np.subtract(x[:, axis], from_start * x[0, axis])

    return [(name, dataset, functools.partial(component, axis)) for axis, name in enumerate("xyz")]


def document(name: str, parts: list[str]) -> str:
    """The whole page. matplotlib gives all figures the same ids: each figure gets its own."""
    numbers = itertools.count(1)

    def own_ids(svg: re.Match[str]) -> str:
        return re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>f{next(numbers)}-", svg[0])

    title, body = escape(name), re.sub("<svg.*?</svg>", own_ids, "\n".join(parts), flags=re.S)
    return (f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<meta name="generator" content="cbr-report">\n<title>{title}</title>\n'
            f"<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{body}\n</body>\n</html>\n")
