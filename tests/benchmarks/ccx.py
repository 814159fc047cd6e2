# SPDX-License-Identifier: GPL-3.0-or-later
"""CalculiX on T1, r = 1, as a program that users have today. Needs ccx (Debian: calculix-ccx) and calculix/deck.py; a row that says so without."""
import os
import re
import shutil
import subprocess
import time

import t1

COLUMNS = ["row", "seconds", "threads", "rms_percent", "rms_percent_of_half_speed", "outputs", "left_velocity", "right_velocity", "note"]
# Name of the row, arguments of deck.py
RUNS = {"explicit, face to face": ["--method", "explicit", "--contact", "face"],
        "explicit, face to face, 24 outputs": ["--method", "explicit", "--contact", "face", "--outputs", "24"]}
LIMIT = 1800  # seconds


def run(name, arguments, folder, reference, python):
    stem = re.sub(r"\W+", "-", name)
    here = t1.HERE / "calculix"
    subprocess.run([python, here / "deck.py", "block-1.msh", f"{stem}.inp", *arguments], cwd=folder, check=True)
    threads = len(os.sched_getaffinity(0))
    start = time.monotonic()
    try:
        done = subprocess.run(["ccx", "-i", stem], cwd=folder, timeout=LIMIT, stdout=subprocess.DEVNULL, env={**os.environ, "OMP_NUM_THREADS": str(threads)})
    except subprocess.TimeoutExpired:
        return {"row": name, "note": f"left out: not done after {LIMIT} s"}
    seconds = time.monotonic() - start
    if done.returncode != 0:
        return {"row": name, "note": "left out: ccx ended with an error"}
    text = subprocess.run([python, here / "result.py", f"{stem}.inp", f"{stem}.dat", reference], cwd=folder, stdout=subprocess.PIPE, text=True, check=True).stdout
    row = {"row": name, "seconds": seconds, "threads": threads, "note": ""}
    found = re.search(r"outputs (\d+).*rms ([\d.]+) %", text)
    if found:
        row["outputs"] = int(found[1])
        if row["outputs"] > 10:
            row.update(rms_percent=float(found[2]), rms_percent_of_half_speed=2 * float(found[2]))
    row.update({f"{body}_velocity": float(v) for body, v in re.findall(r"mean velocity of (left|right) .*: (\S+) m/s", text)})
    return row


def measure(settings, say=print):
    if settings.smoke or not shutil.which("ccx") or not (t1.HERE / "calculix" / "deck.py").exists():
        reason = "minutes long" if settings.smoke else "ccx is not installed (Debian: calculix-ccx)"
        return [{"row": name, "note": f"left out: {reason}"} for name in RUNS]
    folder = settings.out / "calculix"
    folder.mkdir(parents=True, exist_ok=True)
    t1.make_mesh(1, (20, 10, 15), folder)
    rows = []
    for name, arguments in RUNS.items():
        rows.append(run(name, arguments, folder, t1.HERE / "reference" / "t1.txt", settings.python))
        say(f"  CalculiX, {name}: {rows[-1].get('seconds', rows[-1]['note'])}")
    return rows
