#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Two blocks meet, with ever shorter steps: how far the speeds after it are from those of the shortest.

    step_study.py BLOCK.msh FOLDER
"""
import pathlib
import sys

import cbr


def impact(mesh: pathlib.Path, step: float) -> cbr.Scene:
    reduction = {"basis": "characteristic", "interface": ["contact"], "modes": 20}
    return cbr.scene(
        materials={"steel": {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3, "density": 7850}},
        components={"block": {"mesh": str(mesh.resolve()), "material": "steel", "reduction": reduction}},
        instances={"left": {"component": "block", "position": [-0.0255, 0, 0], "velocity": [1, 0, 0]},
                   "right": {"component": "block", "position": [0.0255, 0, 0], "mirror": "x"}},
        contact=[{"between": ["left.contact", "right.contact"]}],
        time={"end": 3e-4, "step": step}, output={"every": 3e-4})


def main() -> None:
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    mesh, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    speeds = {}
    for halvings in range(5):
        step = 1e-6 / 2**halvings
        run = impact(mesh, step).run(folder / f"step-{halvings}.yaml")
        momentum = run["instances/right/momentum"][:, 0]
        speeds[step] = momentum[-1] / run["instances/left/momentum"][0, 0]
    finest = speeds[min(speeds)]
    for step, speed in speeds.items():
        print(f"step {step:.3e} s: speed of the right block {speed:.5f}, {abs(speed - finest):.1e} from the finest")


if __name__ == "__main__":
    main()
