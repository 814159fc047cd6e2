#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs tests with each set of kernels that OpenBLAS has for x86 and this processor can run, with one thread and with two.
usage: kernels.py BUILD [OPTION OF CTEST...]. Bounds on round-off hold with all of them."""
import os
import pathlib
import subprocess
import sys

# What each set needs of the processor. Others of OpenBLAS run the code of one of these, or need instructions (FMA4) that are gone.
NEEDS = {"Prescott": {"pni"}, "Core2": {"ssse3"}, "Penryn": {"sse4_1"}, "Nehalem": {"sse4_2"}, "Atom": {"ssse3"}, "Barcelona": {"pni"},
         "Sandybridge": {"avx"}, "Haswell": {"avx2", "fma"}, "Zen": {"avx2", "fma"},
         "SkylakeX": {"avx512f", "avx512dq", "avx512bw", "avx512vl"}, "Cooperlake": {"avx512f", "avx512dq", "avx512bw", "avx512vl", "avx512_bf16"}}


def main() -> int:
    lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    flags = set(next((line for line in lines if line.startswith("flags")), "").split())
    wanted = os.environ.get("KERNELS", "").split() or [name for name, needs in NEEDS.items() if needs <= flags]
    failed = []
    for kernels in wanted:
        for threads in ("1", "2"):
            print(f"kernels {kernels}, threads {threads}", flush=True)
            environment = {**os.environ, "OPENBLAS_CORETYPE": kernels, "OPENBLAS_NUM_THREADS": threads}
            done = subprocess.run(["ctest", "--test-dir", sys.argv[1], "--output-on-failure", *sys.argv[2:]], env=environment)
            if done.returncode != 0:
                failed.append(f"{kernels} with {threads}")
    print(f"all {len(wanted)} sets of kernels hold" if not failed else f"failed: {', '.join(failed)}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
