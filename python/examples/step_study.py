#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Two blocks meet, with ever shorter steps: how far the speeds after it are from those of the shortest.

    step_study.py BLOCK.msh FOLDER
"""
import pathlib
import sys

import numpy as np

import cbr


def impact(mesh: pathlib.Path) -> cbr.Scene:
    reduction = {"basis": "characteristic", "interface": ["contact"], "modes": 20}
    return cbr.scene(
        materials={"steel": {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3, "density": 7850}},
        components={"block": {"mesh": mesh.resolve(), "material": "steel", "reduction": reduction}},
        instances={"left": {"component": "block", "position": [-0.0255, 0, 0], "velocity": [1, 0, 0]},
                   "right": {"component": "block", "position": [0.0255, 0, 0], "mirror": "x"}},
        contact=[{"between": ["left.contact", "right.contact"]}],
        time={"end": 3e-4}, output={"every": 3e-4})


def speed(run: cbr.Results) -> float:
    """Of the right block at the end, relative to that of the left one at the start."""
    return float(run["instances/right/momentum"][-1, 0] / run["instances/left/momentum"][0, 0])


def main() -> None:
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    mesh, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    steps = 1e-6 / 2.0**np.arange(5)
    table = cbr.study(impact(mesh), "time.step", steps, folder / "step.h5", {"speed": speed})
    speeds = table.columns["speed"]
    for step, of_right in zip(steps, speeds):
        print(f"step {step:.3e} s: speed of the right block {of_right:.5f}, {abs(of_right - speeds[-1]):.1e} from the finest")


if __name__ == "__main__":
    main()
