#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The programs load no library of the current folder, and keep the loader's tables read-only: hardening_test.py CONFIG
PROGRAM..."""
import os
import re
import subprocess
import sys
import tempfile
import unittest

PROGRAMS = [os.path.abspath(program) for program in sys.argv[2:]]


def dynamic(program: str) -> str:
    return subprocess.run(["readelf", "-dW", program], check=True, capture_output=True, text=True).stdout


class Hardening(unittest.TestCase):
    def test_paths_of_libraries_have_no_empty_or_relative_entry(self) -> None:
        for program in PROGRAMS:
            for entries in re.findall(r"\((?:RPATH|RUNPATH)\).*\[(.*)\]", dynamic(program)):
                for entry in entries.split(":"):
                    self.assertTrue(entry.startswith("/"), f"{program}: {entries}")

    def test_a_library_of_the_current_folder_is_not_loaded(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            for library in re.findall(r"\(NEEDED\).*\[(.*)\]", dynamic(PROGRAMS[0])):
                with open(os.path.join(folder, library), "w") as file:
                    file.write("no library")  # the loader would end the program
            for program in PROGRAMS:
                done = subprocess.run([program, "--version"], cwd=folder, capture_output=True, text=True)
                self.assertEqual(done.returncode, 0, done.stderr)

    def test_tables_of_the_loader_are_read_only(self) -> None:
        for program in PROGRAMS:
            self.assertRegex(dynamic(program), r"\(FLAGS\).*BIND_NOW|\(BIND_NOW\)|\(FLAGS_1\).*NOW")
            headers = subprocess.run(["readelf", "-lW", program], check=True, capture_output=True, text=True).stdout
            self.assertIn("GNU_RELRO", headers)

    @unittest.skipUnless(sys.argv[1] == "Release", "other builds have the sanitizers")
    def test_stack_and_buffers_are_checked(self) -> None:
        for program in PROGRAMS:
            symbols = subprocess.run(["readelf", "-W", "--dyn-syms", program], check=True, capture_output=True, text=True).stdout
            self.assertIn("__stack_chk_fail@", symbols)
            self.assertRegex(symbols, r"__\w+_chk@GLIBC")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
