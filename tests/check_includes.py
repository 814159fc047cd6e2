#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Holds the directions of includes and the house's other rules that a script can see.

reducer, skinner and dynamics include common and themselves, never each other; common includes nothing above it; dynamics/contact sees
no body; each third-party C header stands in one .cpp; only report.cpp and program.cpp print. Exit 1 and a line per breach.
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
}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.M)
PRINTS = re.compile(r"std::(cerr|cout|clog)\b|\b(f?printf|puts)\s*\(")
MAY_PRINT = {"common/report.cpp", "common/program.cpp"}


def main():
    breaches, users = [], {}
    for part in PARTS:
        for path in sorted((ROOT / part).rglob("*.[ch]pp")):
            name, text = path.relative_to(ROOT).as_posix(), path.read_text()
            for header in INCLUDE.findall(text):
                target = header.split("/")[0]
                if target in PARTS and target not in ALLOWED[part]:
                    breaches.append(f"{name}: {part} includes {header}: only {', '.join(sorted(ALLOWED[part]))} may be included")
                if target in PARTS and not (ROOT / header).exists():
                    breaches.append(f"{name}: includes {header}, which does not exist")
                if name.startswith("dynamics/contact/") and header.startswith(("dynamics/bodies/", "common/superelement")):
                    breaches.append(f"{name}: contact sees points, velocities and faces, not {header}")
                for wanted in ONE_PLACE:
                    if header == wanted or header.endswith("/" + wanted):
                        users.setdefault(wanted, []).append(name)
            if PRINTS.search(text) and name not in MAY_PRINT:
                breaches.append(f"{name}: prints: only {', '.join(sorted(MAY_PRINT))} may")
            if path.name == "main.cpp" and text.count("\n") > 60:
                breaches.append(f"{name}: {text.count(chr(10))} lines: main.cpp has at most 60")
    for header, names in users.items():
        if len(names) > ONE_PLACE[header] or any(not n.endswith(".cpp") for n in names if ONE_PLACE[header] == 1):
            breaches.append(f"{header} is included in {', '.join(names)}: at most {ONE_PLACE[header]} .cpp may")
    for breach in breaches:
        print(breach, file=sys.stderr)
    print(f"include check: {len(breaches)} breaches", file=sys.stderr)
    return 1 if breaches else 0


if __name__ == "__main__":
    sys.exit(main())
