#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""scene.py KIND N END: N L-shaped parts (as KIND: superelement, mesh or rigid) thrown into a box with spins of their own, for END seconds. YAML on stdout."""
import random
import sys

kind, n, end = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
a_side, apart, half = 5, 0.12, 0.33
random.seed(3)


def text(numbers):
    return "[" + ", ".join(f"{x:.4g}" for x in numbers) + "]"


print("""# L-shaped parts of rubber thrown into a box. SI units.
materials:
  rubber: {youngs_modulus: 5.0e7, poissons_ratio: 0.4, density: 1100}
components:
  part: {mesh: part.msh, material: rubber, reduction: {interface: [skin], modes: 27, superelement: part.cbr.h5}}
walls:
  floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}""")
for name, axis, sign in (("west", 0, 1), ("east", 0, -1), ("south", 1, 1), ("north", 1, -1)):
    normal = [sign * (axis == i) for i in range(3)]
    print(f"  {name}: {{plane: {{point: {text([-half * x for x in normal])}, normal: {text(normal)}}}}}")
print("instances:")
for i in range(n):
    place = [(i % a_side - 2) * apart, (i // a_side % a_side - 2) * apart, 0.08 + i // a_side**2 * apart]
    turn = [random.uniform(-180, 180) for _ in range(3)]
    spin = [random.uniform(-20, 20) for _ in range(3)]
    speed = [random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), -1]
    print(f"  p{i}: {{component: part, as: {kind}, position: {text(place)}, rotation: {text(turn)}, "
          f"velocity: {text(speed)}, angular_velocity: {text(spin)}}}")
# rigid bodies have no critical step, and no waves by which they rebound
step, rebound = ("1.0e-4", ", restitution: 0.5") if kind == "rigid" else ("auto", "")
print(f"""contact:
  - {{between: all, friction: 0.4{rebound}}}
loads:
  - {{gravity: [0, 0, -9.81]}}
time: {{end: {end:g}, step: {step}, rotations: large}}
output:
  every: {end / 50:g}
  fields: [displacement]""")
