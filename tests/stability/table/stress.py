#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The stress table: runs the programs on what is fragile, and writes its rows and their summary.

stress.py [--quick] [--only WORDS] [--jobs N] [--write ROWS --summary FILE]; BIN: folder of the programs.
--quick leaves the long rows out. Exits 1 when a row has not held."""
import argparse
import concurrent.futures
import os
import pathlib
import sys
import tempfile
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # numpy's own threads and forks from several of ours wait for each other for ever

import table
from runs import Folder

import rows_bases  # noqa: F401  (registers rows)
import rows_condition  # noqa: F401
import rows_contact  # noqa: F401
import rows_elements  # noqa: F401
import rows_grooves  # noqa: F401
import rows_input  # noqa: F401
import rows_reduction  # noqa: F401
import rows_steps  # noqa: F401
import rows_thin  # noqa: F401

CHAPTERS = ["Elements and meshes", "Reduction", "Conditioning", "Time steps", "Contact", "Other bases, and domains", "Units and magnitudes", "Bad input"]
MARKS = "<!-- rows: written by `make stress-table` -->", "<!-- end of rows -->"
SUMMARY_MARKS = "<!-- summary: written by `make stress-table` -->", "<!-- end of summary -->"


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", default="", help="rows whose chapter or text holds these words")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--write", type=pathlib.Path, help="the document whose rows are renewed")
    parser.add_argument("--summary", type=pathlib.Path, help="the document whose counts of rows are renewed")
    return parser.parse_args()


def run_row(row, full):
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="cbr-stress-") as folder:
        done = table.lines(row, Folder(folder, full))
    return done, time.monotonic() - start


def write(file, marks, tables):
    """Only what stands between the marks is replaced."""
    text = file.read_text()
    before, rest = text.split(marks[0])
    after = rest.split(marks[1])[1]
    file.write_text(before + marks[0] + "\n" + tables + "\n" + marks[1] + after)


def main():
    options = arguments()
    rows = [r for r in table.ROWS if options.only.lower() in (r.chapter + " " + r.what).lower() and not (options.quick and r.slow)]
    rows.sort(key=lambda r: CHAPTERS.index(r.chapter))
    chapters, failed, count = {}, [], 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for row, (lines, seconds) in zip(rows, pool.map(lambda r: run_row(r, not options.quick), rows)):
            chapters.setdefault(row.chapter, []).extend(lines)
            count += len(lines)
            failed += [line for line in lines if not line.held]
            for line in lines:
                print(f"{'held' if line.held else 'FAILED':6} {seconds:5.1f} s  {line.what}: {line.figure} ({line.bound})", flush=True)
    print(f"{count} rows, {len(failed)} not held")
    for line in failed:
        print(f"not held: {line.what}: {line.figure} ({line.bound})")
    if options.write:
        write(options.write, MARKS, "".join(f"\n## {name}\n\n{table.markdown(lines)}" for name, lines in chapters.items()))
    if options.summary:
        write(options.summary, SUMMARY_MARKS, "\n" + table.summary(chapters))
    return 1 if failed or not count else 0


if __name__ == "__main__":
    sys.exit(main())
