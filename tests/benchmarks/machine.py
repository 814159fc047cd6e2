# SPDX-License-Identifier: GPL-3.0-or-later
"""What was measured on, without names of machines or folders: processor, caches, memory, versions."""
import os
import pathlib
import platform
import re
import subprocess

PACKAGES = ("g++", "libopenblas0-pthread", "libcholmod3", "libarpack2", "libmetis5", "libhdf5-103-1", "libeigen3-dev", "calculix-ccx")


def second_cache():
    """Bytes of the second cache of a core."""
    for index in sorted(pathlib.Path("/sys/devices/system/cpu/cpu0/cache").glob("index*")):
        if (index / "level").read_text().strip() == "2":
            return parse_size((index / "size").read_text().strip())
    return 1 << 20


def parse_size(text):
    return int(text[:-1]) * {"K": 1 << 10, "M": 1 << 20, "G": 1 << 30}[text[-1]]


def caches():
    found = []
    for index in sorted(pathlib.Path("/sys/devices/system/cpu/cpu0/cache").glob("index*")):
        kind = (index / "type").read_text().strip()
        if kind != "Instruction":
            found.append(f"L{(index / 'level').read_text().strip()} {(index / 'size').read_text().strip()}")
    return ", ".join(found)


def package(name):
    done = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", name], capture_output=True, text=True)
    return done.stdout if done.returncode == 0 else ""


def versions():
    model = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    memory = int(re.search(r"MemTotal:\s*(\d+)", pathlib.Path("/proc/meminfo").read_text()).group(1))
    rows = [("processor", model.group(1) if model else platform.machine()), ("processors", len(os.sched_getaffinity(0))), ("caches", caches()),
            ("memory", f"{memory / 1e6:.0f} GB"), ("kernel", platform.release()), ("other processes waiting for a processor, at the start", round(os.getloadavg()[0], 1))]
    rows += [(name, package(name)) for name in PACKAGES if package(name)]
    return [{"what": what, "value": value} for what, value in rows]
