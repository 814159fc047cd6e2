#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""scene.py NUMBER: prints scene NUMBER of N (environment; 100 by default). Speeds go up with the number, frictions in turn."""
import os
import pathlib
import sys

FRICTIONS = [0.05, 0.1, 0.2, 0.3]


def parameters(number, n):
    """Speed down and friction coefficient of scene `number` of `n`."""
    return 0.5 + 2.5 * number / max(1, n - 1), FRICTIONS[number % len(FRICTIONS)]


if __name__ == "__main__":
    speed, friction = parameters(int(sys.argv[1]), int(os.environ.get("N", "100")))
    scene = (pathlib.Path(__file__).parent / "drop.yaml").read_text()
    print(scene.replace("VX", "20").replace("VZ", f"{speed:g}").replace("FRICTION", f"{friction:g}"), end="")
