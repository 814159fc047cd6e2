#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tries decks of other codes: each is read, with a material of the scene, and its lowest frequency computed, or refused with one line.
Frequencies of decks with *FREQUENCY and references (NAME.dat.ref), without prestress and contact, are compared, with the materials and
supports of the deck. Prints a table of counts for docs/translation.md. usage: peer_decks.py CBR_DYN FOLDER [LIST]. FOLDER may hold .inp, .bdf, .nas and .dat
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
    "beams and trusses, springs, gaps and masses": r"a mass on node|beam or truss|'(SPRING|DASHPOT|GAPUNI)",
    "constraints: `*EQUATION`, `*TIE`, `*COUPLING`, `*MPC`, `*RIGID BODY`": r"\*(EQUATION|TIE|COUPLING|DISTRIBUTING|MPC|RIGID ?BODY)|'DCOUP3D'",
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


def references(deck):
    """Frequencies in Hz of the first table of NAME.dat.ref that CalculiX printed; none: no such file, or of another kind of step."""
    text, file = deck.read_text(errors="replace").upper(), deck.with_suffix(".dat.ref")
    if not re.search(r"^\*FREQUENCY", text, re.M) or re.search(r"^\*(STATIC|CONTACT PAIR|INITIAL|COMPLEX)|PERTURBATION", text, re.M) or not file.exists():
        return []
    table = file.read_text(errors="replace").partition("E I G E N V A L U E   O U T P U T")[2].partition("P A R T I")[0]
    return [float(row[3]) for row in map(str.split, table.splitlines()) if len(row) == 5 and row[0].isdigit()]


def supported(deck, folder):
    """The deck without its steps, and a scene with its *BOUNDARY: a node set for each axis."""
    lines, fixed, kept, is_boundary = deck.read_text(errors="replace").splitlines(), {}, [], False
    for line in lines:
        card = line.upper().replace(" ", "")
        if card.startswith("*") and not card.startswith("**"):
            is_boundary = card.startswith("*BOUNDARY")
        if is_boundary and not card.startswith("*") and card:
            of, first, *last = [field.strip() for field in line.split(",")][:3]
            for dof in range(int(first), int(last[0] if last and last[0] else first) + 1):
                fixed.setdefault(dof, []).append(of)
        elif not is_boundary:
            kept.append(line)
    steps = next((i for i, line in enumerate(kept) if line.upper().startswith("*STEP")), len(kept))
    sets = [f"*NSET, NSET=FIXED{dof}\n" + ",\n".join(of) + "," for dof, of in fixed.items() if dof < 4]
    (folder / deck.name).write_text("\n".join(kept[:steps] + sets) + "\n")
    supports = ", ".join(f"{{instance: a, nodes: FIXED{dof}, fix: [{'xyz'[dof - 1]}]}}" for dof in fixed if dof < 4)
    return f"components: {{part: {{mesh: {deck.name}, mass: consistent}}}}\ninstances: {{a: {{component: part, as: mesh}}}}\nboundary: [{supports}]\n"


def difference(program, deck):
    """Largest relative one of the frequencies that are not nearly rigid; None: there is nothing to compare with."""
    wanted = references(deck)
    if not wanted:
        return None
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "scene.yaml").write_text(supported(deck, Path(name)))
        run = subprocess.run([program, "scene.yaml", "-q", "--modes", str(len(wanted)), "-o", "out.h5"], cwd=name, capture_output=True, text=True)
    found = [float(line.split(",")[2]) for line in run.stdout.splitlines() if line.startswith("a,")]
    return max((abs(a / b - 1) for a, b in zip(found, wanted) if b > 0.01 * max(wanted)), default=float("nan"))


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
            read = [deck for deck, (code, _) in zip(decks, answers) if code == 0 and deck.suffix == ".inp"]
            compared = [(deck, off) for deck, off in zip(read, pool.map(lambda deck: difference(program, deck), read)) if off is not None]
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
    good = sum(off < 1e-5 for _, off in compared)
    print(f"\n{len(compared)} decks with frequencies to compare: {good} agree to {max((off for _, off in compared if off < 1e-5), default=0):.1e}")
    print("\n".join([f"{deck.name}: frequencies differ by {off:.1e}" for deck, off in compared if not off < 1e-5] + crashes), file=sys.stderr)
    return 1 if crashes or not decks else 0


if __name__ == "__main__":
    sys.exit(main())
