# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of cases under tests/cases that print their own rows: `make bench-rows`."""
import csv
import io
import pathlib
import subprocess

CASES = pathlib.Path(__file__).resolve().parents[1] / "cases"


def measure(settings, case, folder):
    """(rows, columns) of a case's table; `folder` is made below OUT. Its runs may be minutes.

    Results of an earlier program go first: make would keep them, with their times."""
    for old in (settings.out / folder).glob("*.h5"):
        old.unlink()
    command = ["make", "--no-print-directory", "-s", "-C", CASES / case, "bench-rows",
               f"OUT={settings.out / folder}", f"BIN={settings.bin}", f"PYTHON={settings.python}",
               f"FAST={'1' if settings.smoke else ''}"]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if done.returncode != 0:
        return [{"run": "all", "note": "left out: the case did not run"}], ["run", "note"]
    text = done.stdout
    # make's recipes may say something before the table
    table = text[text.index("run,dofs,"):]
    reader = csv.DictReader(io.StringIO(table))
    return list(reader), reader.fieldnames
