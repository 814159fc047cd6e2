# SPDX-License-Identifier: GPL-3.0-or-later
"""Large scenes, made in code: many instances, contact nodes, outputs, lines. Each function writes its files into `folder` and returns
the scene's name."""
import math

import numpy as np

STEEL = "{youngs_modulus: 100, poissons_ratio: 0.25, density: 1}"  # waves at 11, over bodies of size 1
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
FACES = {"bottom": (2, 0, (0, 3, 2, 1)), "top": (2, 1, (4, 5, 6, 7)), "left": (0, 0, (0, 4, 7, 3)), "right": (0, 1, (1, 2, 6, 5)),
         "front": (1, 0, (0, 1, 5, 4)), "back": (1, 1, (3, 7, 6, 2))}  # axis, end, corners outward


def write_box(path, n, size=(1, 1, 1), sets=("bottom", "top")):
    """n = (nx, ny, nz) hexes in a box at the origin, with sidesets (gmsh 2.2). Fast for millions of numbers."""
    points = [np.linspace(0, size[d], n[d] + 1) for d in range(3)]
    z, y, x = np.meshgrid(points[2], points[1], points[0], indexing="ij")
    nodes = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    k, j, i = (a.ravel() for a in np.meshgrid(*(np.arange(n[d]) for d in (2, 1, 0)), indexing="ij"))
    number = lambda a, b, c: 1 + (i + a) + (n[0] + 1) * ((j + b) + (n[1] + 1) * (k + c))
    cells = np.column_stack([number(*corner) for corner in CORNERS])
    place = (i, j, k)
    parts = [(2, 3, tag, cells[place[axis] == end * (n[axis] - 1)][:, corners])
             for tag, (axis, end, corners) in enumerate((FACES[name] for name in sets), 2)]
    parts.append((3, 5, 1, cells))
    with open(path, "w") as out:
        out.write(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{len(parts)}\n3 1 \"block\"\n")
        out.writelines(f'2 {tag} "{name}"\n' for tag, name in enumerate(sets, 2))
        out.write(f"$EndPhysicalNames\n$Nodes\n{len(nodes)}\n")
        out.writelines(f"{a} {p[0]!r} {p[1]!r} {p[2]!r}\n" for a, p in enumerate(nodes.tolist(), 1))
        out.write(f"$EndNodes\n$Elements\n{sum(len(rows) for *_, rows in parts)}\n")
        first = 1
        for _, kind, tag, rows in parts:
            out.writelines(f"{first + a} {kind} 2 {tag} {tag} {' '.join(map(str, row))}\n" for a, row in enumerate(rows.tolist()))
            first += len(rows)
        out.write("$EndElements\n")


def write_scene(folder, instances, rest, component="", modes=2, interface=("bottom", "top"), name="scene.yaml", end=0.4, every=0.1, time=""):
    """`instances`: lines; `component`: more of the one component, which has a reduction when modes is not None."""
    reduction = f", reduction: {{interface: [{', '.join(interface)}], modes: {modes}}}" if modes is not None else ""
    with open(folder / name, "w") as out:
        out.write(f"materials: {{m: {STEEL}}}\ncomponents: {{block: {{mesh: box.msh, material: m{reduction}{component}}}}}\ninstances:\n")
        out.writelines(instances)
        out.writelines(rest)
        out.write(f"time: {{end: {end}{time}}}\n")
        out.write(f"output: {{every: {every}}}\n" if "output:" not in "".join(rest[-1:]) else "")
    return name


def facing_pairs(n, gap=0.02, speed=0.1, spread=3.0):
    """Instances b0 b1, b2 b3, ... on a lattice; each two fly towards each other along z and meet; pairs are out of each other's way."""
    side = math.ceil((n / 2) ** (1 / 3))
    for b in range(n):
        pair, upper = divmod(b, 2)
        x, y, z = spread * (pair % side), spread * (pair // side % side), 2 * spread * (pair // side ** 2)
        z += (1 + gap) * upper
        yield f"  b{b}: {{component: block, position: [{x}, {y}, {z}], velocity: [0, 0, {-speed if upper else speed}]}}\n"


def all_pairs(folder, n):
    write_box(folder / "box.msh", (2, 2, 2), sets=tuple(FACES))
    return write_scene(folder, facing_pairs(n), ["contact: all\n"], interface=tuple(FACES))


def all_meshes(folder, n):
    write_box(folder / "box.msh", (2, 2, 2), sets=tuple(FACES))
    return write_scene(folder, facing_pairs(n), ["contact: all\n"], modes=None)


def named_pairs(folder, n):
    write_box(folder / "box.msh", (2, 2, 2))
    between = [f"  - {{between: [b{b}.top, b{b + 1}.bottom]}}\n" for b in range(0, n - 1, 2)]
    return write_scene(folder, facing_pairs(n), ["contact:\n", *between])


def falling(folder, n):
    """n superelements with 25 contact nodes each fall onto one floor, from heights that differ, so that some come as others rebound."""
    write_box(folder / "box.msh", (4, 4, 4), sets=("bottom",))
    side = math.ceil(math.sqrt(n))
    with open(folder / "scene.yaml", "w") as out:
        out.write(f"materials: {{m: {STEEL}}}\n"
                  "components: {block: {mesh: box.msh, material: m, reduction: {basis: characteristic, interface: [bottom], modes: 20}}}\n"
                  "instances:\n")
        out.writelines(f"  b{b}: {{component: block, position: [{1.5 * (b % side)}, {1.5 * (b // side)}, {0.001 + 2e-5 * (7919 * b % 1000)}], "
                       "velocity: [0, 0, -0.1]}\n" for b in range(n))
        out.write("walls: {floor: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}\ncontact:\n")
        out.writelines(f"  - {{between: [b{b}.bottom, floor]}}\n" for b in range(n))
        out.write("loads: [{gravity: [0, 0, -0.05]}]\ntime: {end: 1.0}\noutput: {every: 0.5}\n")
    return "scene.yaml"


def every_pair_named(folder, n):
    """As many entries of `between` as there are pairs of some instances: n is the number of entries."""
    count = math.ceil(0.5 + math.sqrt(0.25 + 2 * n))
    write_box(folder / "box.msh", (2, 2, 2))
    pairs = [(a, b) for b in range(count) for a in range(b)][:n]
    between = [f"  - {{between: [b{a}.top, b{b}.bottom]}}\n" for a, b in pairs]
    return write_scene(folder, facing_pairs(count), ["contact:\n", *between])


def contact_nodes(folder, n):
    """n contact nodes on instances of one superelement with 200 each, which meet two by two all over."""
    write_box(folder / "box.msh", (19, 9, 2), size=(1, 0.5, 0.2))
    count = n // 200
    instances = [line.replace("position", "mirror: z, position") if b % 2 == 0 else line
                 for b, line in enumerate(facing_pairs(count, gap=-0.999, spread=1.5))]
    between = [f"  - {{between: [b{b}.bottom, b{b + 1}.bottom]}}\n" for b in range(0, count - 1, 2)]
    return write_scene(folder, instances, ["contact:\n", *between], modes=10, interface=("bottom",), end=0.1, every=0.05)


def large_pair(folder, n, formulation="node-face"):
    """Two full meshes of plates that do not match, with n contact nodes in all, pressed together all over for 20 steps."""
    fine = round(math.sqrt(n / 1.81)) - 1
    for name, cells in (("fine", fine), ("coarse", round(0.9 * fine))):
        write_box(folder / f"{name}.msh", (cells, cells, 2), size=(1, 1, 2 / fine))
    (folder / "scene.yaml").write_text(f"""materials: {{m: {STEEL}}}
components: {{fine: {{mesh: fine.msh, material: m}}, coarse: {{mesh: coarse.msh, material: m}}}}
instances:
  lower: {{component: coarse, velocity: [0, 0, 0.1]}}
  upper: {{component: fine, position: [0, 0, {2 / fine + 1e-4 / fine}], velocity: [0, 0, -0.1]}}
contact: [{{between: [lower.top, upper.bottom], formulation: {formulation}}}]
time: {{end: {0.6 / fine}, step: {0.03 / fine}}}
output: {{every: {0.15 / fine}, history: [lower.top]}}
""")
    return "scene.yaml"


def mortar_pair(folder, n):
    return large_pair(folder, n, "mortar")


def outputs(folder, n, count=20):
    """n output values: `count` instances that fly free, so that only outputs are stepped to."""
    write_box(folder / "box.msh", (2, 2, 2))
    times = max(1, round(n / (11 * count)))
    instances = [f"  b{b}: {{component: block, position: [{2 * b}, 0, 0], velocity: [0, {1e-3 * b}, 0]}}\n" for b in range(count)]
    return write_scene(folder, instances, [], end=times * 0.01, every=0.01)


def outputs_and_checkpoints(folder, n, often):
    name = outputs(folder, n)
    text = (folder / name).read_text()
    if often:
        end = float(text.split("end: ")[1].split("}")[0])
        text = text.replace("output: {every: 0.01}", f"output: {{every: 0.01, checkpoint: {{every: {end / 10}}}}}")
    (folder / name).write_text(text)
    return name


def outputs_of_many(folder, n):
    return outputs(folder, n, 1000)


def fields(folder, n, checkpoints=0):
    """n values of fields, of 50 instances."""
    write_box(folder / "box.msh", (4, 4, 4))
    times = max(1, round(n / (50 * 50 * 6)))
    instances = [f"  b{b}: {{component: block, position: [{2 * b}, 0, 0], velocity: [0, {1e-3 * b}, 0]}}\n" for b in range(50)]
    more = f", checkpoint: {{every: {times * 0.01 / checkpoints}}}" if checkpoints else ""
    return write_scene(folder, instances, [f"output: {{every: 0.01, fields: [displacement, velocity]{more}}}\n"], end=times * 0.01)


def load_lines(folder, n):
    """A scene of n MB of loads, each with a history of its own, on 100 instances."""
    write_box(folder / "box.msh", (2, 2, 2))
    lines = round(1e6 * n / 104)
    instances = [f"  b{b}: {{component: block, position: [{2 * b}, 0, 0]}}\n" for b in range(100)]
    loads = (f"  - {{instance: b{i % 100}, surface: {'top' if i % 3 else 'bottom'}, force: [0, 0, {i % 17 - 8}], "
             f"history: {{time: [0, 0.1, 0.2], value: [0, {1e-3 * (i % 9973):.4f}, {i}]}}}}\n" for i in range(lines))
    return write_scene(folder, instances, ["loads:\n", *loads], end=0.1, every=0.05)


def long_table(folder, n):
    """A scene of n MB that is the table of one history, of a gravity on 100 instances. The run sees the first thousandth of it."""
    write_box(folder / "box.msh", (2, 2, 2))
    points = round(1e6 * n / 25)
    instances = [f"  b{b}: {{component: block, position: [{2 * b}, 0, 0]}}\n" for b in range(100)]
    times = (", ".join(f"{1e-3 * i:.3f}" if i % 10 else f"\n      {1e-3 * i:.3f}" for i in range(points)))
    values = (", ".join(f"{math.sin(0.01 * i):.9f}" if i % 10 else f"\n      {math.sin(0.01 * i):.9f}" for i in range(points)))
    loads = ["loads:\n", "  - gravity: [0, 0, -9.81]\n", f"    history: {{time: [{times}],\n      value: [{values}]}}\n"]
    return write_scene(folder, instances, loads, end=0.02, every=0.01)


def boundary_lines(folder, n):
    """A scene of n MB of boundary conditions, many on the same nodes, on 100 instances."""
    write_box(folder / "box.msh", (2, 2, 2))
    instances = [f"  b{b}: {{component: block, position: [{2 * b}, 0, 0]}}\n" for b in range(100)]
    lines = (f"  - {{instance: b{i % 100}, nodes: bottom, fix: [{'xyz'[i % 3]}]}}\n" for i in range(round(1e6 * n / 47)))
    return write_scene(folder, instances, ["boundary:\n", *lines], end=0.1, every=0.05)


def whole_interface(folder, n):
    """A superelement all of whose nodes are kept, with n MB of K_cc and M_cc; no modes, no diagonal form."""
    side = round(math.sqrt(math.sqrt(1e6 * n / 16) / 6))
    write_box(folder / "box.msh", (side - 1, side - 1, 1))
    return write_scene(folder, ["  b0: {component: block, velocity: [0, 0, 1]}\n"], [], modes=0, end=0.01, every=0.005,
                       time=", integrator: central-difference")


def padded(folder, n):
    """A small superelement in a file with n MB of data that a reader does not know: what the trial of the file costs."""
    write_box(folder / "box.msh", (2, 2, 2))
    return write_scene(folder, ["  b0: {component: block, velocity: [0, 0, 1]}\n"], [], end=0.02, every=0.01)


def checkpoints(folder, n, often=True):
    """Two instances of one superelement with n contact nodes each, pressed together: their W is full. A checkpoint after each step."""
    side = round(math.sqrt(n)) - 1
    write_box(folder / "box.msh", (side, side, 2), size=(1, 1, 2 / side))
    instances = [line.replace("position", "mirror: z, position") if b % 2 == 0 else line for b, line in enumerate(facing_pairs(2, gap=-0.9999))]
    rest = ["contact: [{between: [b0.bottom, b1.bottom]}]\n", "output: {every: %s%s}\n" % (0.5 / side, ", checkpoint: {every_steps: 1}" * often)]
    return write_scene(folder, instances, rest, modes=5, interface=("bottom",), end=0.5 / side)
