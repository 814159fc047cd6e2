# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of the stress table: what was done, the figure, the bound, held or not."""
import dataclasses
import html

ROWS = []


@dataclasses.dataclass
class Line:
    what: str
    figure: str
    bound: str
    held: bool


@dataclasses.dataclass
class Row:
    chapter: str
    what: str
    run: object
    slow: bool


def row(chapter, what, slow=False):
    """Registers a row: the function gets a Folder and returns a Line's figure, bound and whether it held, or a list of (more, ...).
    `slow`: with make stress only."""
    def register(function):
        ROWS.append(Row(chapter, what, function, slow))
        return function
    return register


def short(value):
    return "0" if value == 0 else f"{value:.1e}"


def below(value, bound, unit=""):
    """The figure is at most the bound."""
    return f"{short(value)}{unit}", f"{bound:g}{unit}", bool(value <= bound)


def refused(ran, *words, code=2):
    """Ended by an error whose one line holds all the words: the named error is what the row asks for."""
    error = ran.error()
    held = ran.code == code and all(word in error for word in words)
    return "refused: " + (error or f"no error, exit code {ran.code}"), "a named error", held


def holds(figure, bound, held):
    return figure, bound, bool(held)


def lines(row, folder):
    """Runs a row. What goes wrong on the way is its figure."""
    try:
        answers = row.run(folder)
    except Exception as error:  # a row that cannot be judged has not held
        return [Line(row.what, f"{type(error).__name__}: {error}", "", False)]
    if isinstance(answers, tuple):
        answers = [("", *answers)]
    return [Line(row.what + (f": {more}" if more else ""), *rest) for more, *rest in answers]


def markdown(lines):
    """The table of one chapter."""
    cell = lambda text: html.escape(" ".join(text.split()), quote=False).replace("|", "\\|")
    text = "| what was done | figure | bound | held |\n|---|---|---|---|\n"
    return text + "".join(f"| {cell(l.what)} | {cell(l.figure)} | {cell(l.bound)} | {'yes' if l.held else '**no**'} |\n" for l in lines)


def summary(chapters):
    """The table of all chapters: how many rows, how many held, how many record a known weakness."""
    text = "| chapter | rows | held | known weaknesses |\n|---|---|---|---|\n"
    for name, lines in chapters.items():
        weak = sum("known weakness" in line.what for line in lines)
        text += f"| {name} | {len(lines)} | {sum(line.held for line in lines)} | {weak} |\n"
    return text
