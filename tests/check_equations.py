#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Holds references to docs/theory.md against its equations and headings.

Equations are numbered (1), (2), ... in the order of the text, each once. A reference is `theory.md, (12)`,
`theory.md, (12) to (14)` or `theory.md, "Heading"`, in any document, source, script or test. Exit 1 and a
line for each breach.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
THEORY = "docs/theory.md"
FOLDERS = ["common", "reducer", "skinner", "dynamics", "tests", "docs", "python", "scripts", "cmake"]
ENDINGS = {".cpp", ".hpp", ".h", ".py", ".md", ".txt", ".yaml", ".sh"}
# An equation is indented by four spaces and ends with its number.
LABEL = re.compile(r"^    .*\s\((\d+[a-z]?'?)\)[.,]?$", re.M)
# Years, as in "MacNeal (1971)", have four digits; f(2) and 7825(89) are no references.
NUMBER = re.compile(r"(?<![\w)\]])\((\d{1,3}[a-z]?'?)\)")
# A comment's next line begins with // or #.
WRAP = re.compile(r"\s*\n\s*(?://+|#)?\s*")
AFTER = re.compile(r"theory\.md(?:\]\([\w./#-]*\))?[,:;]? (.{0,120})")
LIST = re.compile(r"(?:after )?(?:\(\d+[a-z]?'?\)(?:, | and | to |-)?)+")


def labels_in_order(text):
    """Breaches of the order (1), (2), ... of the equations of `text`."""
    labels = LABEL.findall(text)
    for place, label in enumerate(labels, 1):
        if label != str(place):
            yield f"{THEORY}: equation ({label}) is number {place} of the text: number equations (1), (2), ... in order"
            return


def has_heading(text, heading):
    return re.search(r"^#+ (\d+\. )?%s$|\*%s[.*]" % ((re.escape(heading),) * 2), text, re.M) is not None


def references(name, text, theory):
    """Breaches of the references of one file; theory is the text of docs/theory.md."""
    labels = set(LABEL.findall(theory))
    if name == THEORY:
        for number in NUMBER.findall(text):
            if number not in labels:
                yield f"{name}: refers to ({number}), which no equation has"
        return
    for after in AFTER.findall(WRAP.sub(" ", text)):
        numbers, quoted = LIST.match(after), re.match(r'"([^"]+)"', after)
        if numbers:
            for number in re.findall(r"\((\d+[a-z]?'?)\)", numbers.group()):
                if number not in labels:
                    yield f"{name}: refers to theory.md, ({number}), which no equation has"
        elif quoted and not has_heading(theory, quoted.group(1).rstrip(".,")):
            yield f'{name}: refers to theory.md, "{quoted.group(1)}", which is no heading there'
        elif re.match(r"(section )?\d", after):
            yield f'{name}: refers to theory.md, {after[:20]}...: name an equation, (12), or a heading, "Contact"'


def self_test():
    """The check must see what it is for."""
    theory = "# T\n\n## 1. Motion\n\n    a = b   (1)\n\n**Rest.** By (1).\n\n    c = d.   (2)\n"
    assert not list(labels_in_order(theory)) and not list(references(THEORY, theory, theory))
    assert list(labels_in_order(theory.replace("(2)", "(1a)")))
    assert list(labels_in_order(theory.replace("(2)", "(1)")))
    assert list(references(THEORY, theory + "By (3).", theory))
    good = '// theory.md, (1), (2); theory.md,\n// "Motion"; theory.md, "Rest". [theory.md](../docs/theory.md), (2) holds.'
    assert not list(references("good.cpp", good, theory)), list(references("good.cpp", good, theory))
    for bad in ("theory.md, (1) and (3)", "theory.md, 2a", 'theory.md, "Motion of"', "theory.md, section 4",
                "[theory.md](theory.md), (4)"):
        assert list(references("bad.cpp", bad, theory)), bad


def main():
    self_test()
    theory = (ROOT / THEORY).read_text()
    breaches = list(labels_in_order(theory))
    files = [p for p in ROOT.iterdir() if p.suffix in ENDINGS]
    for folder in FOLDERS:
        files += [p for p in (ROOT / folder).rglob("*") if p.suffix in ENDINGS]
    for path in sorted(files):
        name = path.relative_to(ROOT).as_posix()
        if name == "tests/check_equations.py":
            continue
        breaches += references(name, path.read_text(errors="replace"), theory)
    for breach in breaches:
        print(breach, file=sys.stderr)
    print(f"equation check: {len(breaches)} breaches", file=sys.stderr)
    return 1 if breaches else 0


if __name__ == "__main__":
    sys.exit(main())
