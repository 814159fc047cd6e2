#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Holds the rule of one statement a line: no statement joins others by commas, as in `a = 1, b = 2;`.

Declarations (`double a = 1, b = 2;`), headers of `for` and Eigen's `m << 1, 2;` may have commas. Exit 1
and a line for each breach.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDERS = ["common", "reducer", "skinner", "dynamics", "tests"]
# Comments, preprocessor lines and text; the text of a raw string has its own end.
NO_CODE = re.compile(
    r'R"(?P<end>[^(\s]*)\(.*?\)(?P=end)"|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])+\''
    r"|//[^\n]*|/\*.*?\*/|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", re.S | re.M)
# Innermost arguments of a template, as in `f<A, B>(x)`.
TEMPLATE = re.compile(r"(?<=\w)<(?:[\w:,\s*&()]|\.\.\.)*>")
CLOSING = {"(": ")", "[": "]", "{": "}"}
MARK = re.compile(r"[(){}\[\];]")
CONTROL = re.compile(r"\s*(?:(?:if|for|while|switch|catch)\b(?:\s+constexpr)?\s*\(\)|(?:else|do|try)\b"
                     r"|(?:inline\s+)?namespace\b[\s\w:]*|extern\s*\"\"\s*"
                     r"|case\b(?:[^:]|::)*:(?!:)|(?:default|public|private|protected)\s*:(?!:))")
# An assignment, a call or a step: what stands before the first comma of joined statements. A group in
# brackets is () or [] here, whatever it holds. A declaration has two words and is none of these.
ACTION = re.compile(r"\s*(?:(?:\+\+|--|\*+|\(\))\s*)*[\w:]+(?:\s*(?:\.|->|::)\s*[\w~]+|\s*\(\)|\s*\[\])*\s*"
                    r"(?:\+\+|--)?\s*(?:(?:<<|>>|[-+*/%&|^])?=(?!=)|,)")


def blank(match):
    """A match as spaces, or as "" for text; its lines stay."""
    found = match.group()
    kept = '""' if found[0] in "\"'R" else ""
    return kept + re.sub(r"[^\n]", " ", found[len(kept):])


def without_control(statement):
    """A statement without the `if ()`, `else`, `case` and the like before it."""
    while (control := CONTROL.match(statement)) is not None:
        statement = statement[control.end():]
    return statement


def is_joined(statement):
    """Whether a statement, its brackets emptied, is several that are joined by commas."""
    statement = without_control(statement)
    if re.match(r"\s*return\b", statement):
        return "," in statement
    return "," in statement and ACTION.match(statement) is not None


def group(text, start, found):
    """The position after the bracket that opens at `start`. Statements are read in braces alone."""
    close, position = CLOSING[text[start]], start + 1
    statement, begin = "", position  # its brackets emptied, and where it begins
    while True:
        mark = MARK.search(text, position)
        if mark is None:  # both branches of an #if open a brace that they share the end of
            return len(text)
        statement += text[position:mark.start()]
        position, character = mark.end(), mark.group()
        if character in CLOSING:
            starts_block = character == "{" and not without_control(statement).strip()
            position = group(text, mark.start(), found)
            statement += character + CLOSING[character]
            if starts_block:
                statement, begin = "", position
        elif character == ";":
            if close == "}" and is_joined(statement):
                found.append(mark.start() - len(text[begin:mark.start()].lstrip()))
            statement, begin = "", position
        else:
            return position


def joined_statements(source):
    """The lines of `source` at which statements begin that are joined by commas."""
    text = NO_CODE.sub(blank, source)
    while (shorter := TEMPLATE.sub(lambda m: re.sub(r"[^\n]", " ", m.group()), text)) != text:
        text = shorter
    found = []
    group("{" + text + "}", 0, found)
    return [text.count("\n", 0, place - 1) + 1 for place in sorted(found)]


def self_test():
    """The check must see what it is for, and nothing else."""
    for bad in ("a = 1, b = 2;", "if (x) a[i] += f(1, 2), b->c = 3;", "++i, ++j;", "f(a), g(b);", "return a = 1, b;",
                "call([&](int i) { a = i, b = 2; });", "if (x) { f(); } a.b(1).c = g<A, B>(), d *= 2;",
                "*p = 1, q = 2;", "case A::b: a = 1, b = 2;", "auto f = [] {}; f(), g();", "for (;;) a = {1, 2}, b = c;",
                "else x.noalias() -= a, y = b;", "(void)a, (void)b;", "do a = 1, b = 2; while (x);"):
        assert joined_statements("void f() {\n  " + bad + "\n}") == [2], bad
    for good in ("double a = 1, b = 2;", "for (a = 1, b = 2; a < b; ++a, --b) f(a, b);", "m << 1, 2, 3;",
                 "auto [a, b] = f(c, d);", "return {a, b};", "x = std::map<A, B>{};", "enum class A { b = 1, c = 2 };",
                 "const Matrix &a = f(), &b = g();", 'a = "b, c"; // d = 1, e = 2;', "std::vector<int> a, b(3);",
                 "Point p{1, 2}, q{3, 4};", "x = Point{.a = 1, .b = 2};", "m.row(0) << 1, 2;", "return f<A, B>(a);"):
        assert not joined_statements("void f() {\n  " + good + "\n}"), good
    assert not joined_statements("A::A(int b) : b_(b), c_{b} { d(); }\nstruct B {\n  int c = 1, d = 2;\n};")


def main():
    self_test()
    breaches = []
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.[ch]pp")):
            name = path.relative_to(ROOT).as_posix()
            breaches += [f"{name}:{line}: statements joined by commas: one statement a line" for line in
                         joined_statements(path.read_text())]
    for breach in breaches:
        print(breach, file=sys.stderr)
    print(f"statement check: {len(breaches)} breaches", file=sys.stderr)
    return 1 if breaches else 0


if __name__ == "__main__":
    sys.exit(main())
