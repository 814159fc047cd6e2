# SPDX-License-Identifier: GPL-3.0-or-later
"""The part with small features (tests/cases/small-features), whose full mesh must step as its smallest tetrahedra allow."""
import csv
import io
import pathlib
import subprocess

CASE = pathlib.Path(__file__).resolve().parents[1] / "cases" / "small-features"


def measure(settings):
    """(rows, columns) of its table, repeated by hand only: its runs are minutes."""
    command = ["make", "--no-print-directory", "-s", "-C", CASE, "bench-rows", f"OUT={settings.out / 'features'}", f"BIN={settings.bin}", f"PYTHON={settings.python}",
               f"FAST={'1' if settings.smoke else ''}"]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if done.returncode != 0:
        return [{"run": "all", "note": "left out: the case did not run"}], ["run", "note"]
    text = done.stdout
    # make's recipes may say something before the table
    table = text[text.index("run,dofs,"):]
    reader = csv.DictReader(io.StringIO(table))
    return list(reader), reader.fieldnames
