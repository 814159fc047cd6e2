#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints how large the house is, and fails when a count grows past its bound.

Bounds only fall: who deletes lowers them. Raising one needs a record in docs/decisions that says why
nothing could be folded instead, with the measurements.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
BOUNDS = {
    "lines of product": 85505,
    "files of product": 535,
    "lines of python/cbr": 1979,
    "lines of tests": 64501,
    "files of tests": 379,
    "numbers in contact/solve": 50,  # but for 0, 1, 2, 3 and 0.5
    "lines with InputError(": 355,
    "classes derived from Body": 4,
    "members of the largest class": 30,
}
CODE = {".cpp", ".hpp"}
COMMENT_OR_TEXT = re.compile(r'//[^\n]*|"(?:\\.|[^"\\\n])*"')
NUMBER = re.compile(r"(?<![\w.])\d[\d']*\.?\d*(?:e[-+]?\d+)?(?![\w.])")
PLAIN = {0, 0.5, 1, 2, 3}
CLASS = re.compile(r"\b(?:class|struct) (\w+)(?: final)?(?:\s*:([^{;]*))?\s*\{")
MEMBER = re.compile(r"\b[a-zA-Z]\w*_\b")


def texts(folders, kinds):
    return {path: path.read_text() for folder in folders for path in sorted((ROOT / folder).rglob("*"))
            if path.suffix in kinds and path.is_file() and not {"out", "__pycache__"} & set(path.parts)}


def lines(sources):
    return sum(text.count("\n") for text in sources.values())


def block(text, start):
    """The text from an opening brace at `start` to the brace that closes it."""
    depth = 0
    for mark in re.finditer(r"[{}]", text[start:]):
        depth += 1 if mark.group() == "{" else -1
        if depth == 0:
            return text[start:start + mark.end()]
    return text[start:]


def derived(bases, root):
    """Classes that derive from `root`, directly or not. bases: class -> names of its bases."""
    found = {root}
    while more := {name for name in bases.keys() - found if bases[name] & found}:
        found |= more
    return found - {root}


def counts():
    product = texts(["common", "reducer", "skinner", "dynamics"], CODE)
    python, tests = texts(["python/cbr"], {".py"}), texts(["tests"], CODE | {".py"})
    code = {path: COMMENT_OR_TEXT.sub("", text) for path, text in product.items()}
    bases, members = {}, {}
    for text in code.values():
        for found in CLASS.finditer(text):
            bases.setdefault(found[1], set()).update(re.findall(r"public (\w+)", found[2] or ""))
            names = set(MEMBER.findall(block(text, found.end() - 1)))
            members[found[1]] = max(members.get(found[1], 0), len(names))
    solve = [text for path, text in code.items() if "dynamics/contact/solve" in path.as_posix()]
    numbers = [float(n.replace("'", "")) for text in solve for n in NUMBER.findall(text)]
    return {
        "lines of product": lines(product),
        "files of product": len(product),
        "lines of python/cbr": lines(python),
        "lines of tests": lines(tests),
        "files of tests": len(tests),
        "numbers in contact/solve": sum(n not in PLAIN for n in numbers),
        "lines with InputError(": sum("InputError(" in line for text in product.values() for line in text.splitlines()),
        "classes derived from Body": len(derived(bases, "Body")),
        "members of the largest class": max(members.values()),
    }, max(members, key=members.get)


def main():
    found, largest = counts()
    for name, bound in BOUNDS.items():
        note = f" ({largest})" if "largest" in name else ""
        print(f"{found[name]:6} of {bound:6} {name}{note}{': too many' * (found[name] > bound)}", file=sys.stderr)
    return 1 if any(found[name] > bound for name, bound in BOUNDS.items()) else 0


if __name__ == "__main__":
    sys.exit(main())
