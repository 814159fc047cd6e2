#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints a line for each scene: its parameters, and what the floor gave the block."""
import os
import pathlib

import h5py

from scene import parameters

n, folder = int(os.environ.get("N", "100")), pathlib.Path(os.environ.get("OUT", "out"))
print("number,speed,friction,normal_impulse,friction_impulse,rebound,work_of_friction")
for number in range(n):
    speed, friction = parameters(number, n)
    with h5py.File(folder / f"drop-{number}.h5") as f:
        momentum = f["instances/block/momentum"][:]
        work = f["energy/work_friction"][-1]
    change = momentum[-1] - momentum[0]
    rebound = -momentum[-1, 2] / momentum[0, 2]
    print(f"{number},{speed:.6g},{friction:g},{change[2]:.9g},{-change[0]:.9g},{rebound:.6g},{work:.6g}")
