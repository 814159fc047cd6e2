#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tries decks of other codes: each is read, with a material of the scene, and its lowest frequency computed, or refused with one line.
Prints a table of counts for docs/translation.md. usage: peer_decks.py CBR_DYN FOLDER [LIST]. FOLDER may hold .inp, .bdf, .nas and .dat
files, also .gz; LIST is a file for the answer to each deck. Exit 1 if a deck ends in anything but a result or an error with its cure."""
import collections
import concurrent.futures
import gzip
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

SCENE = """materials: {m: {youngs_modulus: 2.1e11, poissons_ratio: 0.3, density: 7850}}
components: {part: {mesh: "%s", material: m}}
instances: {a: {component: part, as: mesh}}
"""
KINDS = {".inp", ".bdf", ".nas", ".dat"}
# Kinds of answers by their errors; the first that is found counts.
REASONS = {
    "fluids and fluid networks": r"element type '(D'|F3D)",
    "constraints: `*EQUATION`, `*TIE`, `*COUPLING`, `*MPC`, `*RIGID BODY`": r"\*(EQUATION|TIE|COUPLING|MPC|RIGID ?BODY)|'DCOUP3D'",
    "beams and trusses, springs, gaps and masses": r"beam or truss|'(SPRING|DASHPOT|GAPUNI|MASS)",
    "shells or plane elements without solids, axisymmetric elements": r"no volume elements|element type 'CAX|only sides of volume",
    "user elements": r"element type 'US?\d",
    "elements that are inverted": r"is inverted",
    "parts that change: `*MODEL CHANGE`, `*MATRIX ASSEMBLE`": r"\*(MODEL CHANGE|MATRIX ASSEMBLE)",
    "no deck alone: without nodes, or with a missing file": r"no \*NODE|no such file",
}


def answer(program, deck):
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.yaml"
        scene.write_text(SCENE % deck)
        try:
            run = subprocess.run([program, "scene.yaml", "--modes", "1", "-o", "out.h5", "--threads", "1"], cwd=folder, capture_output=True,
                                 text=True, errors="replace", timeout=300)
        except subprocess.TimeoutExpired:
            return -1, "longer than 300 s"
    errors = [line for line in run.stderr.splitlines() if "error:" in line]
    return run.returncode, (errors or run.stderr.splitlines() or [""])[-1]


def main():
    program, folder = os.path.abspath(sys.argv[1]), Path(sys.argv[2])
    with tempfile.TemporaryDirectory() as plain:
        for packed in folder.rglob("*.gz"):  # beside the others, which may include it
            (Path(plain) / packed.name[:-3]).write_bytes(gzip.decompress(packed.read_bytes()))
        for file in folder.rglob("*"):
            if file.is_file() and file.suffix != ".gz" and not (Path(plain) / file.name).exists():
                os.symlink(file.resolve(), Path(plain) / file.name)
        decks = sorted(file for file in Path(plain).iterdir() if file.suffix in KINDS)
        with concurrent.futures.ThreadPoolExecutor(max(1, (os.cpu_count() or 2) // 2)) as pool:
            answers = list(pool.map(lambda deck: answer(program, deck), decks))
    if len(sys.argv) > 3:
        Path(sys.argv[3]).write_text("".join(f"{deck.name}\t{code}\t{text}\n" for deck, (code, text) in zip(decks, answers)))
    counts, crashes = collections.Counter(), []
    for deck, (code, text) in zip(decks, answers):
        if code in (0, 1):  # 1: a model that has no frequencies without its supports
            counts["read" if code == 0 else "read; no frequencies without the deck's supports"] += 1
        elif code == 2:
            counts[next((name for name, words in REASONS.items() if re.search(words, text)), "other errors")] += 1
        else:
            crashes.append(f"{deck.name}: exit code {code}: {text}")
    print(f"{len(decks)} decks\n\n| decks | found |\n|---|---|")
    for name, count in counts.most_common():
        print(f"| {count} | {name} |")
    print("\n".join(crashes), file=sys.stderr)
    return 1 if crashes or not decks else 0


if __name__ == "__main__":
    sys.exit(main())
