# SPDX-License-Identifier: GPL-3.0-or-later
"""Which basis when: five scenes with every basis (bases.csv), each against a reference that its row names.

    impact    T1, the paper's block impact            mean position of the faces, against the converged answer (reference/t1.txt)
    unlike    T2, a brick against a dense block       the brick's centre of mass, against full meshes of the same elements
    bounce    a bar falls on a wall, ten periods      position of the end that lands, exact (Doyen, Ern, Piperno 2011)
    rattle    T1's block between two walls, 6 impacts its centre of mass, against a mesh four times as fine (reference/rattle.txt)
    joint     two blocks pressed together, one is shaken until they slip: the loaded face, against full meshes of the same elements at a quarter of the step

A row more: an entry in BASES. What a program refuses is a row with its reason.
"""
import pathlib

import h5py
import numpy as np

import t1
from runs import Refused, block_mesh, in_turns, median, run

HERE = pathlib.Path(__file__).resolve().parent
COLUMNS = ["scene", "basis", "row", "dofs", "steps", "step_s", "error_percent", "error_all_percent", "energy", "stepping_s", "total_s", "reduction_s", "reference", "note"]

# Name: entries of `reduction` (None: full meshes; INTERFACE: the scene's), entries of `time`
BASES = {
    "full mesh": (None, ""),
    "craig-bampton": ("", ""),
    "craig-bampton, picked": ("pick: participation", ""),
    "craig-bampton, picked, two critical steps": ("pick: participation", "step: {cfl: 2}"),
    "craig-bampton, central differences": ("", "integrator: central-difference"),
    "massless, free": ("basis: massless", ""),
    "massless, tapered": ("basis: massless, massless_modes: tapered", ""),
    "characteristic": ("basis: characteristic", ""),
}

SMOKE = ("full mesh", "craig-bampton", "massless, free")  # of the smallest run

STEEL = "steel: {youngs_modulus: 5.17e12, poissons_ratio: 0.3, density: 7836}"


def entries(*texts):
    return ", ".join(text for text in texts if text)


def l2(difference, of):
    return 100 * np.sqrt(np.sum(difference**2) / np.sum(of**2))


class Scene:
    """folder: of this scene. `meshes` are (name, hexes, edges) of blocks."""
    name, reference, modes, meshes = "", "", 0, ()

    def __init__(self, settings, folder):
        self.smoke, self.folder, self.bin_dir = settings.smoke, folder, settings.bin
        folder.mkdir(parents=True, exist_ok=True)
        for name, hexes, edges in self.meshes:
            block_mesh(folder / f"{name}.msh", [max(2, n // 3) for n in hexes] if self.smoke else hexes, edges)

    def component(self, name, material, interface, reduction, modes=None, more=""):
        text = f"  {name}: {{mesh: {name}.msh, material: {material}{more}"
        if reduction is None:
            return text + "}\n"
        reduction = reduction.replace("INTERFACE", interface)
        modes = modes or f"modes: {8 if self.smoke else self.modes}"
        return text + f", reduction: {{{entries(reduction, f'interface: [{interface}]', modes, f'superelement: {name}-{self.stem}.cbr.h5')}}}}}\n"

    def write(self, basis, reduction, time):
        self.stem = basis.replace(", ", "-").replace(" ", "-")
        (self.folder / f"{self.stem}.yaml").write_text(self.text(reduction, time))
        return self.stem

    def results(self, stem):
        return h5py.File(self.folder / f"{stem}.h5")


class Impact(Scene):
    name, reference, modes = "impact", "converged answer of T1", 80
    meshes = (("block", (20, 10, 15), (0.0508, 0.0254, 0.0381)),)

    def text(self, reduction, time):
        return (f"materials:\n  {STEEL}\ncomponents:\n" + self.component("block", "steel", "contact", reduction) +
                f"instances:\n  left:  {{component: block, position: [-0.0279, 0, 0], velocity: [{t1.SPEED}, 0, 0]}}\n"
                "  right: {component: block, position: [0.0381, 0, 0], mirror: x}\ncontact:\n  - {between: [left.contact, right.contact]}\n"
                f"time: {{{entries(f'end: {t1.END}', time)}}}\noutput: {{every: {t1.END / 120}, history: [left.contact, right.contact]}}\n")

    def judge(self, stem):
        rms, energy = t1.errors(self.folder / f"{stem}.h5")
        return 2 * rms, 2 * rms, energy


class Unlike(Scene):
    name, reference, modes = "unlike", "full meshes of the same elements", 200
    meshes = (("dense", (15, 20, 20), (0.0762, 0.1016, 0.1016)), ("brick", (10, 10, 10), (0.0254,) * 3))

    def text(self, reduction, time):
        return (f"materials:\n  {STEEL}\n  heavy: {{youngs_modulus: 5.17e14, poissons_ratio: 0.3, density: 7.836e4}}\ncomponents:\n" +
                self.component("dense", "heavy", "contact", reduction) + self.component("brick", "steel", "contact", reduction) +
                "instances:\n  left:  {component: dense, position: [-0.0279, 0, 0]}\n"
                "  right: {component: brick, position: [0.0381, 0, 0], mirror: x, velocity: [-3810, 0, 0]}\ncontact:\n  - {between: [left.contact, right.contact]}\n"
                f"time: {{{entries('end: 1.2e-5', time)}}}\noutput: {{every: 5.0e-7}}\n")

    def judge(self, stem):
        with self.results(stem) as f, self.results("full-mesh") as full:
            x, X = (g["instances/right/center_of_mass"][:, 0] for g in (f, full))
            total, mass_brick = f["energy/total"][:], 7836 * 0.0254**3
            mass = mass_brick + 7.836e4 * 0.0762 * 0.1016**2
            common = (mass_brick * 3810) ** 2 / (2 * mass)
            error = 100 * np.sqrt(np.mean((x - X) ** 2)) / (3810 * 2e-6)  # contact lasts 2 us
            return error, error, (total[-1] - common) / (total[0] - common)


class Bounce(Scene):
    name, reference = "bounce", "exact"
    meshes = (("bar", (100, 2, 2), (10, 0.5, 0.5)),)
    period, height = 16 / 3, 5.0

    def text(self, reduction, time):
        end = (1 if self.smoke else 10) * self.period
        step = "" if "step" in time or reduction is None else ("step: 1.0e-2" if self.smoke else "step: 2.0e-3")
        modes = "modes: 8" if self.smoke else "cutoff_hz: 24.75"  # axial ones every 1.5 Hz: 16 and the rigid one
        modes = "modes: 17" if reduction and "participation" in reduction and not self.smoke else modes
        return ("materials:\n  m: {youngs_modulus: 900, poissons_ratio: 0, density: 1}\ncomponents:\n" +
                self.component("bar", "m", "x_min", reduction, modes) + "instances:\n  bar: {component: bar, position: [10, 0, 0]}\n"
                "walls: {floor: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}}\nloads:\n  - {gravity: [-10, 0, 0]}\ncontact:\n  - {between: [bar.x_min, floor]}\n"
                f"time: {{{entries(f'end: {end}', time, step)}}}\noutput: {{every: {self.period / 80}, history: [bar.x_min]}}\n")

    def exact(self, t):
        t = np.mod(t, self.period)
        z = np.mod(3 * (t - 5 / 3), 2)
        return np.select([t < 1, t < 5 / 3, t < 11 / 3, t < 13 / 3], [5 - 5 * t**2, 0 * t, 5 - 5 * (t - 8 / 3) ** 2 + 10 / 9 * z * (z - 2), 0 * t], 5 - 5 * (t - self.period) ** 2)

    def judge(self, stem):
        with self.results(stem) as f:
            t, x = f["time"][:], f["surfaces/bar.x_min/mean_position"][:, 0]
            e, two = self.exact(t), t <= 2 * self.period * (1 + 1e-9)
            work = f["energy/work_contact"][-1] / (10 * 0.25 * 10 * 5)  # of what it fell with
            return l2((x - e)[two], e[two]), l2(x - e, e), 1 + work


class Rattle(Scene):
    name, reference, modes = "rattle", "mesh four times as fine", 120
    meshes = (("block", (20, 10, 16), (0.0508, 0.0254, 0.0381)),)
    gap = 0.0076

    def text(self, reduction, time):
        end = 2e-5 if self.smoke else 1e-4
        return (f"materials:\n  {STEEL}\ncomponents:\n" + self.component("block", "steel", "x_min, x_max", reduction) +
                "instances:\n  block: {component: block, velocity: [1905, 0, 0]}\n"
                "walls:\n  right: {plane: {point: [0.033, 0, 0], normal: [-1, 0, 0]}}\n  left: {plane: {point: [-0.033, 0, 0], normal: [1, 0, 0]}}\n"
                "contact:\n  - {between: [block.x_max, right]}\n  - {between: [block.x_min, left]}\n"
                f"time: {{{entries(f'end: {end}', time)}}}\noutput: {{every: 5.0e-7}}\n")

    def judge(self, stem):
        t_ref, x_ref = np.loadtxt(HERE / "reference" / "rattle.txt").T
        with self.results(stem) as f:
            t, x, total = f["time"][:], f["instances/block/center_of_mass"][:, 0], f["energy/total"][:]
            d = (x - np.interp(t, t_ref, x_ref)) / self.gap * 100
            rms = [np.sqrt(np.mean(d[t <= end * (1 + 1e-9)] ** 2)) for end in (2.5e-5, 1e-4)]
            return rms[0], rms[1], total[-1] / total[0]


class Joint(Scene):
    name, reference, modes = "joint", "full meshes of the same elements, a quarter of the step", 30  # 40 would cut a pair of one frequency in two
    meshes = (("block", (6, 6, 6), (0.5, 0.5, 0.5)),)

    def text(self, reduction, time):
        end = 0.6 if self.smoke else 3
        t = np.arange(0, end + 0.02, 0.02)
        ramp = np.clip((t - 0.5) / 0.5, 0, 1) if not self.smoke else np.clip(t / 0.3, 0, 1)
        shake = np.sin(2 * np.pi * t) * ramp
        listed = lambda values: "[" + ", ".join(f"{value:.6g}" for value in values) + "]"
        return ("materials:\n  m: {youngs_modulus: 1000, poissons_ratio: 0.3, density: 1}\ncomponents:\n" +
                self.component("block", "m", "x_min, x_max", reduction) +
                "instances:\n  held:   {component: block, position: [0.25, 0, 0]}\n  shaken: {component: block, position: [0.75, 0, 0]}\n"
                "boundary:\n  - {instance: held, nodes: x_min, fix: [x, y, z]}\n"
                "loads:\n  - {instance: shaken, surface: x_max, traction: [-20, 0, 0], history: {time: [0, 0.4], value: [0, 1]}}\n"
                f"  - {{instance: shaken, surface: x_max, traction: [0, 1.2, 0], history: {{time: {listed(t)}, value: {listed(shake)}}}}}\n"
                "contact:\n  - {between: [held.x_max, shaken.x_min], friction: 0.1}\n"
                f"time: {{{entries(f'end: {end}', time)}}}\noutput: {{every: 0.02, history: [shaken.x_max]}}\n")

    def judge(self, stem):
        with self.results(stem) as f, self.results("reference") as full:
            x, X = (g["surfaces/shaken.x_max/mean_position"][:, 1] for g in (f, full))
            half = len(X) // 2
            X = X[: len(x)]
            rubbed = f["energy/work_friction"][-1] / full["energy/work_friction"][-1]
            return l2((x - X)[:half], X[:half]), l2(x - X, X), rubbed


SCENES = (Impact, Unlike, Bounce, Rattle, Joint)


def measure(settings, say=print):
    """Rows of bases.csv."""
    rows = []
    for kind in SCENES:
        scene = kind(settings, settings.out / "bases" / kind.name)
        say(f"bases: {scene.name}")
        if scene.name == "joint":
            (scene.folder / "reference.yaml").write_text(scene.text(None, "step: {cfl: 0.25}"))
            run(settings.bin, "cbr-dyn", "reference.yaml", "-o", "reference.h5", folder=scene.folder)
        jobs, reductions = {}, {}
        for basis, (reduction, time) in BASES.items():
            if settings.smoke and basis not in SMOKE:
                continue
            stem = scene.write(basis, reduction, time)
            try:
                reductions[basis] = 0.0 if reduction is None else run(settings.bin, "cbr-reduce", f"{stem}.yaml", "--force", folder=scene.folder)["phase"]["total"]
            except Refused as error:
                rows.append({"scene": scene.name, "basis": basis, "row": f"{scene.name}: {basis}", "note": f"left out: {error}"})
                continue
            jobs[basis] = lambda stem=stem: run(settings.bin, "cbr-dyn", f"{stem}.yaml", "-o", f"{stem}.h5", folder=scene.folder, timings=f"{stem}.csv")
        results, refused = in_turns(jobs, settings.repeats, say)
        rows += [{"scene": scene.name, "basis": basis, "row": f"{scene.name}: {basis}", "note": f"left out: {why}"} for basis, why in refused.items()]
        for basis, tables in results.items():
            stem = basis.replace(", ", "-").replace(" ", "-")
            error, error_all, energy = scene.judge(stem)
            steps = median(tables, "count", "steps_planned")
            with scene.results(stem) as f:
                end = float(f["time"][-1])
            rows.append({"scene": scene.name, "basis": basis, "row": f"{scene.name}: {basis}", "dofs": median(tables, "count", "dofs"), "steps": steps, "step_s": end / steps,
                         "error_percent": error, "error_all_percent": error_all, "energy": energy, "stepping_s": median(tables, "phase", "steps"),
                         "total_s": median(tables, "phase", "total"), "reduction_s": reductions[basis], "reference": scene.reference, "note": ""})
    return rows
