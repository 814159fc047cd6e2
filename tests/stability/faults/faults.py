#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The three programs on disks that are full or closed, killed, and side by side: what was there stays whole, the message names the
path, the exit code is 1; an interrupted run goes on to the same bytes. usage: faults.py BIN_DIR [CASE ...]. Exit 77 without h5py."""
import os
import signal
import sys
import tempfile
import time
from pathlib import Path

import interrupted
import outputs


def main():
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: sys.exit(1))  # nohup, and shells' background jobs, ignore some, and programs inherit that
    cases = {name[5:]: case for module in (outputs, interrupted) for name, case in vars(module).items() if name.startswith("case_")}
    for name in sys.argv[2:] or cases:
        begin = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            os.chmod(folder, 0o755)
            note = cases[name](Path(folder)) or ""
        print(f"{name}: {time.monotonic() - begin:.1f} s {note}", flush=True)


if __name__ == "__main__":
    main()
