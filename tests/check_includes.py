#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Holds the directions of includes and the house's other rules that a script can see.

reducer, skinner and dynamics include common and themselves, never each other; common includes nothing above it; dynamics/contact sees
no body; each third-party C header stands in one .cpp; only report.cpp and program.cpp print. Eigen's decompositions, which take the
compiler seconds a file, stand in common/linalg, in tests too. Folders include what the table of docs/architecture.md says, all of it, in
the order of its rows; the arrows of its picture and the files that it names exist. No header declares a function that is cloned for
several processors. Exit 1 and a line per breach.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PARTS = ["common", "reducer", "skinner", "dynamics"]
ALLOWED = {"common": {"common"}, "reducer": {"reducer", "common"}, "skinner": {"skinner", "common"}, "dynamics": {"dynamics", "common"}}
# Header -> the one file that may include it.
ONE_PLACE = {
    "hdf5.h": 2, "gmsh.h": 1, "netcdf.h": 2, "cholmod.h": 1, "arpack.h": 1, "metis.h": 1, "yaml-cpp/yaml.h": 4, "xxhash.h": 1,
    "slepceps.h": 2, "petscmat.h": 1, "petscsys.h": 2, "mpi.h": 1,
}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.M)
PRINTS = re.compile(r"std::(cerr|cout|clog)\b|\b(f?printf|puts)\s*\(")
MAY_PRINT = {"common/app/report.cpp", "common/app/program.cpp"}
# Eigen/LU is more than a decomposition: inverse() and determinant() of small matrices.
DECOMPOSITION_HEADER = re.compile(
    r"^(unsupported/)?Eigen/(Dense|Eigen|Sparse|Cholesky|QR|SVD|Eigenvalues|SparseCholesky|SparseLU|SparseQR|IterativeLinearSolvers)$")
DECOMPOSITION = re.compile(
    r"\b(LLT|LDLT|\w*HouseholderQR|\w*EigenSolver|CompleteOrthogonalDecomposition|JacobiSVD|BDCSVD|FullPivLU|PartialPivLU|SparseLU"
    r"|Simplicial\w+)\s*<"
    r"|\.(llt|ldlt|lu|partialPivLu|fullPivLu|\w*[hH]ouseholderQr|jacobiSvd|bdcSvd|eigenvalues)\(\)")
# The element matrix of every hexahedron: 9 x 9, unrolled.
MAY_DECOMPOSE = {"common/fem/elements/hex8.cpp"}


def decompositions(name, text):
    """Breaches of the rule that a decomposition is instantiated in common/linalg alone."""
    if name.startswith("common/linalg/dense") or name == "dynamics/contact/solve/newton/set_matrix.cpp" or name in MAY_DECOMPOSE:
        return
    for header in INCLUDE.findall(text):
        if DECOMPOSITION_HEADER.match(header):
            yield f"{name}: includes {header}: use common/linalg/dense.hpp, or Eigen/Geometry and Eigen/LU for small matrices"
    for line in text.splitlines():
        found = DECOMPOSITION.search(line.split("//")[0])
        if found:
            yield f"{name}: {found.group().strip()}: use common/linalg/dense.hpp, which is compiled once"


CLONES = re.compile(r"^CBR_CLONES \w+ (\w+)\(", re.M)


def declared_clones(name, text, headers):
    """Functions for several instruction sets that a header of their folder declares: common/linalg/kernels/clones.hpp says why not."""
    for function in CLONES.findall(text):
        for header in headers:
            if re.search(r"^[\w:<> ]+ \*?%s\(" % function, header.read_text(), re.M):
                yield f"{name}: {function} is compiled for several processors and declared in {header.name}: wrap it"


ARCHITECTURE = ROOT / "docs" / "architecture.md"
PICTURE_LINE = re.compile(r"^ (\w+)/ +(\w+(?: --> \w+)+)", re.M)
TABLE_ROW = re.compile(r"^\| `([\w/]+)` \|[^|]*\|([^|]*)\|$", re.M)


def folder_includes():
    """Folder -> {folder that it includes: one of its files that does}."""
    found = {}
    for part in PARTS:
        for path in sorted((ROOT / part).rglob("*.[ch]pp")):
            name = path.relative_to(ROOT)
            own = found.setdefault(name.parent.as_posix(), {})
            for header in INCLUDE.findall(path.read_text()):
                target = pathlib.PurePosixPath(header).parent.as_posix()
                if target.split("/")[0] in PARTS and target != name.parent.as_posix():
                    own.setdefault(target, name.as_posix())
    return found


def picture(text, found):
    """Arrows of the picture that no include follows; a folder stands for those inside it, too."""
    def parts(folder):
        return [name for name in found if name == folder or name.startswith(folder + "/")]

    for top, chain in PICTURE_LINE.findall(text):
        folders = [f"{'dynamics/' if top == 'contact' else ''}{top}/{name}" for name in re.split(r" --> ", chain)]
        for start, end in zip(folders, folders[1:]):
            if not any(target in found[name] for name in parts(start) for target in parts(end)):
                yield f"docs/architecture.md: the picture has {start} --> {end}, which no file there includes"


def architecture(text, found):
    """Breaches between the table of docs/architecture.md and folder_includes()."""
    table = {folder: set(re.findall(r"`([\w/]+)`", row)) for folder, row in TABLE_ROW.findall(text)}
    for folder in sorted(found.keys() - table.keys()):
        yield f"docs/architecture.md: {folder} has no row"
    for folder in sorted(table.keys() - found.keys()):
        yield f"docs/architecture.md: {folder} has a row and no sources"
    for folder in sorted(table.keys() & found.keys()):
        for target in sorted(found[folder].keys() - table[folder]):
            yield f"{found[folder][target]}: {folder} includes {target}, which its row in docs/architecture.md does not allow"
        for target in sorted(table[folder] - found[folder].keys()):
            yield f"docs/architecture.md: the row of {folder} allows {target}, which no file there includes"
    rows = list(table)
    for i, folder in enumerate(rows):
        for target in sorted(table[folder] & set(rows[i + 1:])):
            yield f"docs/architecture.md: {folder} includes {target}, whose row is below its own"
    yield from picture(text, found)
    for name in re.findall(r"`((?:%s)/[\w/]+\.[ch]pp)`" % "|".join(PARTS), text):
        if not (ROOT / name).exists():
            yield f"docs/architecture.md: names {name}, which does not exist"


def main():
    breaches, users = [], {}
    for path in sorted((ROOT / "tests").rglob("*.[ch]pp")):
        breaches += decompositions(path.relative_to(ROOT).as_posix(), path.read_text())
    for part in PARTS:
        for path in sorted((ROOT / part).rglob("*.[ch]pp")):
            name, text = path.relative_to(ROOT).as_posix(), path.read_text()
            for header in INCLUDE.findall(text):
                target = header.split("/")[0]
                if target in PARTS and target not in ALLOWED[part]:
                    breaches.append(f"{name}: {part} includes {header}: only {', '.join(sorted(ALLOWED[part]))} may be included")
                if target in PARTS and not (ROOT / header).exists():
                    breaches.append(f"{name}: includes {header}, which does not exist")
                if name.startswith("dynamics/contact/") and header.startswith(("dynamics/motion/", "common/superelement/")):
                    breaches.append(f"{name}: contact sees points, velocities and faces, not {header}")
                for wanted in ONE_PLACE:
                    if header == wanted or header.endswith("/" + wanted):
                        users.setdefault(wanted, []).append(name)
            breaches += decompositions(name, text)
            breaches += declared_clones(name, text, path.parent.glob("*.hpp"))
            if PRINTS.search(text) and name not in MAY_PRINT:
                breaches.append(f"{name}: prints: only {', '.join(sorted(MAY_PRINT))} may")
            if path.name == "main.cpp" and text.count("\n") > 70:
                breaches.append(f"{name}: {text.count(chr(10))} lines: main.cpp has at most 70")
    breaches += architecture(ARCHITECTURE.read_text(), folder_includes())
    for header, names in users.items():
        if len(names) > ONE_PLACE[header] or any(not n.endswith(".cpp") for n in names if ONE_PLACE[header] == 1):
            breaches.append(f"{header} is included in {', '.join(names)}: at most {ONE_PLACE[header]} .cpp may")
    for breach in breaches:
        print(breach, file=sys.stderr)
    print(f"include check: {len(breaches)} breaches", file=sys.stderr)
    return 1 if breaches else 0


if __name__ == "__main__":
    sys.exit(main())
