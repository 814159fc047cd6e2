# SPDX-License-Identifier: GPL-3.0-or-later
"""Beside the peers: CalculiX, OpenRadioss, Chrono and SciPy, next to cbr-dyn and cbr-reduce. Every process has one thread; its seconds are those of
the processor, user and system, from start to end. ONLY=REGEX of "case; program; setting" measures some rows, the others stay; LIMIT: seconds of a
process. As a program it is the reduction by SciPy: peers.py STEM MODES [symmetric], or frequencies of all dofs: peers.py STEM reference."""
import functools
import importlib.util
import multiprocessing
import os
import re
import resource
import shutil
import signal
import statistics
import subprocess
import sys
import time

import h5py
import numpy as np
import yaml

import calculix
import radioss
import t1
from runs import read_csv, read_table, write_csv

KEY = ("case", "program", "setting")
COLUMNS = [*KEY, "runs", "reduction_s", "seconds", "steps_percent", "megabytes", "error_percent", "second", "note"]
CASES = t1.HERE.parent / "cases"
# Of a case: its name, its instance and side that strikes, its velocity, m/s, the height of the wall, m, and the end, s
PARTS = {"ordinary-part": ("ordinary part", "pedestal", "foot", (0.5, 0, -1.0), -1e-6, 2e-4),
         "small-features": ("bracket", "bracket", "contact", (0, 0, 5.0), 20.005e-3, 1e-4)}
LIMIT = 600
SOLVERS = {"CalculiX": calculix, "OpenRadioss": radioss}
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1"}


def clocked(command, folder, log):
    """(exit code or signal below 0, processor seconds, MB) of a process that is stopped after LIMIT seconds of its processor."""
    most = int(os.environ.get("LIMIT") or LIMIT)
    with open(folder / log, "w") as file:
        process = subprocess.Popen(command, cwd=folder, stdout=file, stderr=file, env={**os.environ, **ONE_THREAD},
                                   preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (most, most + 1)))
        _, status, usage = os.wait4(process.pid, 0)
    return os.waitstatus_to_exitcode(status), usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def apart(function):
    """Its result, from a process of its own: the memory of this one counts as that of the programs which it starts."""
    ours, theirs = multiprocessing.Pipe(False)
    process = multiprocessing.get_context("fork").Process(target=lambda: theirs.send(function()))
    process.start()
    theirs.close()
    result = ours.recv()
    process.join()
    return result


class Job:
    """A row. prepare(): writes what the run reads; command and reduction: words, run in `folder`; judge(): (error in per cent, second
    figure); stem: of the files of a solver; curves(): (times, forces in N, times, energies in per cent) for the plot."""

    def __init__(self, case, program, setting, folder, prepare, command, judge, reduction=None, stem=None, curves=None):
        self.case, self.program, self.setting, self.folder, self.prepare = case, program, setting, folder, prepare
        self.command, self.judge, self.reduction, self.stem, self.curves = command, judge, reduction, stem, curves
        self.timings = folder / command[command.index("--timings") + 1] if "--timings" in command else None

    def why(self, code):
        """Of a run that did not end well: its message, and how far it came."""
        text = (self.folder / "log.txt").read_text(errors="replace")
        found = re.search(r"\*ERROR(?: in)?:?\s*([^*]{,160})", text) or re.search(r"[Ee]rror: (.{,160})", text)
        said = " ".join(found[1].split()) if found else signal.Signals(-code).name if code < 0 else f"exit code {code}"
        stopped = code in (-signal.SIGXCPU, -signal.SIGKILL)
        at = SOLVERS[self.program].reached(self.stem) if self.stem else None
        return (f"stopped after {os.environ.get('LIMIT') or LIMIT} s" if stopped else f"failed: {said}") + ("" if at is None else f", at {at:.3g} s")

    def run(self, repeats):
        row = {"case": self.case, "program": self.program, "setting": self.setting, "note": ""}
        apart(lambda: self.prepare() and None)
        if self.reduction:
            code, row["reduction_s"], _ = clocked(self.reduction, self.folder, "log.txt")
            if code:
                return {**row, "note": self.why(code)}
        seconds, phases = [], []
        # Runs of more than half a minute run once
        while len(seconds) < repeats and (not seconds or seconds[0] < 30):
            code, used, row["megabytes"] = clocked(self.command, self.folder, "log.txt")
            seconds.append(used)
            if code:
                return {**row, "runs": 1, "seconds": used, "note": self.why(code)}
            if self.timings:
                table = read_table(self.timings)
                phases.append(table["phase"])
                row["megabytes"] = table["count"]["peak_memory_bytes"] / 2**20
        row.update(runs=len(seconds), seconds=statistics.median(seconds))
        if phases and "steps" in phases[0]:
            # The program's own clock is of the wall; on a busy machine only its shares mean something
            row["steps_percent"] = statistics.median(100 * phase["steps"] / phase["total"] for phase in phases)
        elif self.program == "OpenRadioss":
            row["steps_percent"] = 100 * radioss.steps(self.stem) / seconds[-1]
        row["error_percent"], row["second"] = apart(self.judge)
        return row


def dyn(settings, scene):
    return [settings.bin / "cbr-dyn", f"{scene}.yaml", "-o", f"{scene}.h5", "--quiet", "--threads", "1", "--timings", f"{scene}.dyn.csv"]


def reduce(settings, *what):
    return [settings.bin / "cbr-reduce", *what, "--quiet", "--force", "--threads", "1"]


def make(settings, case, folder, *targets):
    """Files of a case, by its Makefile."""
    words = ["make", "--no-print-directory", "-s", "-C", CASES / case, f"OUT={folder}", f"BIN={settings.bin}", f"PYTHON={settings.python}", f"FAST={'1' if settings.smoke else ''}"]
    subprocess.run([*words, *(folder / target for target in targets)], check=True, stdout=subprocess.DEVNULL)


def last_speed(t, x):
    """Of a centre of mass that nothing touches at the end."""
    return (x[-1] - x[-2]) / (t[-1] - t[-2])


def solver(program, case, setting, folder, write, judge, curves=None):
    """A row of CalculiX or OpenRadioss. write, judge and curves take the path without an ending of the input file."""
    stem = folder / re.sub(r"\W+", "-", f"{case} {program} {setting}")
    return Job(case, program, setting, folder, lambda: write(stem), SOLVERS[program].command(stem), lambda: judge(stem), stem=stem, curves=curves and (lambda: curves(stem)))


def impact(settings, r):
    """T1: rms of the mean positions of the faces, of 8.1 mm; second: the rebound."""
    case, folder, hexes = f"T1, r = {r:g}", settings.out / "peers", (6, 4, 5) if settings.smoke else tuple(int(n * r) for n in (20, 10, 15))

    @functools.cache
    def mesh():
        t1.make_mesh(r, hexes, folder)
        return calculix.Mesh(folder / f"block-{r}.msh")

    def off(t, *faces):
        """faces: displacements of the left and the right one."""
        t_ref, s_ref = t1.reference()
        # The left face is at -2.5 mm, the right one at 12.7 mm; the plane of symmetry is t1.CENTRE at the start
        off = [x - t1.SPEED / 2 * t - sign * (np.interp(t, t_ref, s_ref) - s_ref[0]) for x, sign in zip(faces, (1, -1))]
        return 200 * np.sqrt(np.mean(np.square(off))) / (t1.SPEED * t1.CONTACT)

    def judge(stem):
        face = np.isin(np.arange(len(mesh().nodes)), mesh().sides["contact"][0])
        (t, left), (_, right) = (calculix.path(stem, name, face) for name in ("LEFT", "RIGHT"))
        speeds = [last_speed(t, calculix.path(stem, name, mesh().weights())[1][:, 0]) for name in ("LEFT", "RIGHT")]
        return off(t, left[:, 0], right[:, 0]), (speeds[1] - speeds[0]) / t1.SPEED

    def judge_radioss(stem):
        t, _, nodes = radioss.history(stem)
        left, right = (mesh().weights() @ of[-1, :, 3] for of in nodes)
        return off(t, *(of[:, mesh().sides["contact"][0], 0].mean(axis=1) for of in nodes)), (right - left) / t1.SPEED

    def ours(model):
        def figures():
            with h5py.File(folder / f"{model.stem}.h5") as f:
                p = [f[f"instances/{name}/momentum"][:, 0] for name in ("left", "right")]
            return 2 * t1.errors(folder / f"{model.stem}.h5")[0], (p[1][-1] - p[0][-1]) / p[0][0]
        return figures

    def curves(t, force, energy):
        """The energy is that in the frame of the common centre of mass, which has half of it at the start."""
        return t, np.abs(force), t, 100 * (2 * energy / energy[0] - 1)

    def radioss_curves(stem):
        """The force is the rate of a block's momentum; its mass is that of the energy at the start."""
        t, energy, nodes = radioss.history(stem)
        p = 2 * energy[0].sum() / t1.SPEED**2 * nodes[0][:, :, 3] @ mesh().weights()
        return curves(t, np.gradient(p, t), energy.sum(axis=1))

    def our_curves(model):
        with h5py.File(folder / f"{model.stem}.h5") as f:
            return curves(f["time"][:], f["contact/left.contact - right.contact/force"][:, 0], f["energy/total"][:])

    n = 5 if settings.smoke else 40
    for setting, rival in (("full mesh", ("full", 0, "frequency")), ("superelement, by default", ("shapes", 2 * n, "frequency")),
                           (f"superelement, {n} picked modes", ("shapes", n, "participation"))):
        model = t1.Case(r, (*rival, "impulse", ""), hexes, folder, settings.bin)
        yield Job(case, "cbr", setting, folder, lambda model=model: mesh() and model.prepare(), dyn(settings, model.stem), ours(model),
                  None if model.is_mesh else reduce(settings, f"{model.stem}.yaml"), curves=lambda model=model: our_curves(model))
    step = 1e-7 / r
    for setting, options in (("explicit", {}), ("explicit, massless contact", {"contact": "MASSLESS"}), ("implicit", {"implicit": True}),
                             (f"implicit, steps of {step:.2g} s", {"implicit": True, "step": step})):
        yield solver("CalculiX", case, setting, folder, lambda stem, options=options: calculix.write_impact(stem.with_suffix(".inp"), mesh(), **options), judge,
                     lambda stem: curves(*calculix.history(stem, 0)))
    for setting, options in (("interface 7", {"interface": 7}), ("interface 24", {}), ("interface 24, as an expert", radioss.EXPERT_IMPACT)):
        yield solver("OpenRadioss", case, setting, folder, lambda stem, options=options: radioss.write_impact(stem, mesh(), **options), judge_radioss, radioss_curves)


def part(settings, case, mesh_name, scenes, rivals, friction=""):
    """A part that strikes a wall along z: path of its centre of mass from that of the mesh `fine`, of its length; second: momentum
    along z at the end, of that before, turned. scenes {setting: model}; rivals {setting: options of CalculiX}."""
    name, instance, side, velocity, height, end = PARTS[case]
    folder = settings.out / f"peers-{case}"
    scenes = {setting: f"{mesh_name}-{model}{friction}" for setting, model in scenes.items()}
    fine = f"fine-full{friction}" if not settings.smoke else scenes["full mesh"]
    title = f"{name}, {mesh_name}" + (", friction" if friction else "")

    @functools.cache
    def mesh():
        make(settings, case, folder, f"{mesh_name}.msh", f"{fine}.h5", *(f"{scene}.yaml" for scene in scenes.values()))
        return calculix.Mesh(folder / f"{mesh_name}.msh")

    def off(t, x):
        with h5py.File(folder / f"{fine}.h5") as f:
            t_ref, x_ref = f["time"][:], f[f"instances/{instance}/center_of_mass"][:]
        moved = x_ref - x_ref[0]
        ours = np.array([np.interp(t, t_ref, moved[:, k]) for k in range(3)]).T
        return 100 * np.linalg.norm(x - x[0] - ours + ours[0], axis=1).max() / np.linalg.norm(np.diff(x_ref, axis=0), axis=1).sum()

    def figures(scene):
        with h5py.File(folder / f"{scene}.h5") as f:
            t, x, p = f["time"][:], f[f"instances/{instance}/center_of_mass"][:], f[f"instances/{instance}/momentum"][:]
        return off(t, x), -p[-1, 2] / p[0, 2]

    def judge(stem):
        t, x = calculix.path(stem, "PART", mesh().weights())
        return off(t, x), -last_speed(t, x[:, 2]) / velocity[2]

    def judge_radioss(stem):
        t, _, (nodes,) = radioss.history(stem)
        x = np.einsum("tnk,n->tk", nodes, mesh().weights())
        return off(t, x[:, :3]), -x[-1, 5] / velocity[2]

    for setting, scene in scenes.items():
        # Superelements of all nodes are the same with friction and without
        yield Job(title, "cbr", setting, folder, mesh, dyn(settings, scene), lambda scene=scene: figures(scene),
                  None if setting == "full mesh" else reduce(settings, f"{scene}.yaml"))
    for setting, options in rivals.items():
        yield solver("CalculiX", title, setting, folder, lambda stem, options=options: calculix.write_strike(
            stem.with_suffix(".inp"), mesh(), side, velocity, height, end, friction=0.3 if friction else 0, **options), judge)
    for setting, options in (("rigid wall", {}), ("rigid wall, as an expert", radioss.EXPERT)):
        yield solver("OpenRadioss", title, setting, folder, lambda stem, options=options: radioss.write_strike(
            stem, mesh(), side, velocity, height, end, friction=0.3 if friction else 0.0, **options), judge_radioss)


def rotation(degrees):
    """Quaternion w x y z of rotations about x, y and z in turn."""
    q = np.array([1.0, 0, 0, 0])
    for axis, half in enumerate(np.radians(degrees) / 2):
        v = np.sin(half) * np.eye(3)[axis]
        q = np.array([np.cos(half) * q[0] - v @ q[1:], *(np.cos(half) * q[1:] + q[0] * v + np.cross(v, q[1:]))])
    return q


def tumbling(settings):
    """Fifty parts in a box: path of their common centre of mass from that of cbr's rigid parts in a tenth of the step, of its length;
    second: energy that contact took, in per cent of that at the start and gravity's work."""
    case, folder, mass, gravity, end, outputs = "tumbling box", settings.out / "peers-tumbling", 50 * 0.044, 9.81, 0.1, 50

    @functools.cache
    def ready():
        make(settings, "tumbling-parts", folder, "part.msh", "rigid.yaml", "mesh.yaml", "superelement.yaml")
        scene = (folder / "rigid.yaml").read_text()
        (folder / "fine.yaml").write_text(scene.replace("step: 1.0e-4", "step: 1.0e-5"))
        if not (folder / "fine.h5").exists():
            clocked(dyn(settings, "fine"), folder, "log.txt")
        with open(folder / "bodies.txt", "w") as file:
            for of in yaml.safe_load(scene)["instances"].values():
                q = rotation(of["rotation"])
                r = 2 * np.outer(q[1:], q[1:]) + (2 * q[0] ** 2 - 1) * np.eye(3) + 2 * q[0] * np.cross(np.eye(3), -q[1:])
                print(*(r @ [0.022, 0.022, 0.01] + of["position"]), *q, *of["velocity"], *of["angular_velocity"], file=file)

    def state(name):
        """t, momentum upwards, energy of motion and strain (n), common centre of mass (n x 3)."""
        if (folder / f"{name}.rows").exists():
            t, p, E, *x = np.loadtxt(folder / f"{name}.rows").T
            return t, p, E, np.transpose(x)
        with h5py.File(folder / f"{name}.h5") as f:
            bodies = list(f["instances"].values())
            return (f["time"][:], sum(body["momentum"][:, 2] for body in bodies), f["energy/total"][:],
                    np.mean([body["center_of_mass"][:] for body in bodies], axis=0))

    def judge(name):
        (_, _, E, x), x_ref = state(name), state("fine")[3]
        whole = E[0] + mass * gravity * (x[0, 2] - x[-1, 2])
        return 100 * np.linalg.norm(x - x_ref, axis=1).max() / np.linalg.norm(np.diff(x_ref, axis=0), axis=1).sum(), 100 * (1 - E[-1] / whole)

    def curves(name):
        t, p, E, x = state(name)
        return (t[1:] + t[:-1]) / 2, np.diff(p) / np.diff(t) + mass * gravity, t, 100 * (E + mass * gravity * x[:, 2]) / (E[0] + mass * gravity * x[0, 2])

    for setting, name in (("rigid parts", "rigid"), ("full meshes", "mesh"), ("superelements", "superelement")):
        yield Job(case, "cbr", setting, folder, ready, dyn(settings, name), lambda name=name: judge(name),
                  reduce(settings, "superelement.yaml") if name == "superelement" else None, curves=lambda name=name: curves(name))
    for setting, words in (("constraints, own envelope and iterations", "nsc 1e-4 0.03 50"), ("constraints, envelope of 1 mm, 500 iterations", "nsc 1e-4 1e-3 500"),
                           ("constraints, the same in steps of 1e-5 s", "nsc 1e-5 1e-3 500"), ("springs, steps of 1e-5 s", "smc 1e-5 1e-3 50")):
        name = re.sub(r"\W+", "-", words)
        yield Job(case, "Chrono", setting, folder, ready, ["peer-chrono", "bodies.txt", f"{name}.rows", *words.split(), str(end), str(end / outputs)],
                  lambda name=name: judge(name), curves=lambda name=name: curves(name))


def joint(settings):
    """The bolted lap joint in statics: travel of the end in the second cycle of load, from that on a finer mesh; second: the bolt's force at the end, N."""
    folder, fine = settings.out / "peers-joint", settings.out / "peers-joint-fine"

    @functools.cache
    def reference():
        """The travel on the finer mesh."""
        make(settings, "lap-joint", folder, "mesh.h5", "craig-bampton.h5")
        if not (fine / "mesh.h5").exists():
            fine.mkdir(parents=True, exist_ok=True)
            for number, name in enumerate(("plate", "washer", "bolt"), 1):
                sizes = ["-setnumber", "part", str(number), "-setnumber", "n", "6", "-setnumber", "layers", "3"]
                subprocess.run(["gmsh", "-3", "-v", "1", CASES / "lap-joint" / "joint.geo", *sizes, "-o", fine / f"{name}.msh"], check=True)
            make(settings, "lap-joint", fine, "mesh.h5")
        return figures(fine / "mesh.h5")[0]

    def figures(file):
        with h5py.File(file) as f:
            cycle = f["surfaces/upper.end/mean_position"][:, 0][f["time"][:] >= 6 - 1e-9]
            return np.ptp(cycle), -f["contact/head.cut - nut.cut/force"][-1, 2]

    def ours(name):
        travel, bolt = figures(folder / f"{name}.h5")
        return 100 * abs(travel / reference() - 1), bolt

    def judge(stem):
        travel, bolt = calculix.joint_figures(stem)
        return 100 * abs(travel / reference() - 1), bolt

    yield Job("lap joint", "cbr", "full mesh", folder, reference, dyn(settings, "mesh"), lambda: ours("mesh"))
    yield Job("lap joint", "cbr", "superelement, 10 modes a part", folder, reference, dyn(settings, "craig-bampton"), lambda: ours("craig-bampton"), reduce(settings, "craig-bampton.yaml"))
    for setting, options in (("surface to surface", {}), ("surface to surface, springs of 1 N/mm, softer contact", {"springs": 1.0, "stiffness": 1e6}),
                             ("node to surface, springs of 1 N/mm", {"springs": 1.0, "contact": "NODE TO SURFACE"})):
        yield solver("CalculiX", "lap joint", setting, folder, lambda stem, options=options: reference() and calculix.write_joint(stem.with_suffix(".inp"), folder, **options), judge)


def reduction(settings, name, mesh, make_mesh, side, modes, steel):
    """Ten lowest elastic frequencies of the free reduced component, the worst from those of all dofs; second: dofs of the interface."""
    folder, case = mesh.parent, f"reduction of {name}"
    stem = re.sub(r"\W+", "-", name)
    reference, scipy = folder / f"{stem}-km.hz", [settings.python, t1.HERE / "peers.py", f"{stem}-km"]
    material = [word for pair in zip(("--youngs-modulus", "--poissons-ratio", "--density"), map(str, steel)) for word in pair]

    @functools.cache
    def ready():
        """The mesh, and CalculiX's matrices and frequencies of all its dofs."""
        make_mesh()
        of = calculix.Mesh(mesh)
        calculix.write_matrices(folder / f"{stem}-km.inp", of, steel)
        np.savetxt(folder / f"{stem}-km.kept", of.sides[side][0] + 1, fmt="%d")
        if shutil.which("ccx") and not reference.exists():
            clocked(["ccx", "-i", f"{stem}-km"], folder, "log.txt")
            clocked([*scipy, "reference"], folder, "log.txt")
        return of

    def frequencies(K, M):
        """Of the free component, the ten above its six rigid motions, Hz."""
        from scipy.linalg import eigh
        return np.sqrt(np.abs(eigh(K, M, eigvals_only=True, subset_by_index=[6, 15]))) / (2 * np.pi)

    def judge(K, M, kept):
        if not reference.exists():
            return "", kept
        return 100 * np.abs(frequencies(K, M) / np.loadtxt(reference) - 1).max(), kept

    def ours():
        with h5py.File(folder / f"{stem}.cbr.h5") as f:
            K, M, M_kc, values = (f[f"matrices/{matrix}"][:] for matrix in ("K_cc", "M_cc", "M_kc", "eigenvalues"))
        k, c = M_kc.shape
        return judge(np.block([[np.diag(values), np.zeros((k, c))], [np.zeros((c, k)), K]]), np.block([[np.eye(k), M_kc], [M_kc.T, M]]), c)

    def theirs():
        found = np.load(folder / f"{stem}-km.npz")
        return judge(found["K"], found["M"], found["K"].shape[0] - modes)

    def substructure(path):
        with h5py.File(folder / f"{stem}.cbr.h5") as f:
            order = np.lexsort((f["dofs/component"][:], f["nodes/id"][:][f["dofs/node"][:]]))
            K = f["matrices/K_cc"][:][np.ix_(order, order)]
        return 100 * np.abs(calculix.triangle(path.with_suffix(".mtx"), len(K)) - K).max() / np.abs(K).max(), len(K)

    yield Job(case, "cbr", f"Craig-Bampton, {modes} modes", folder, ready,
              reduce(settings, mesh.name, "--interface", side, "--modes", str(modes), "--element", "hex8", "--mass", "consistent", *material, "-o", f"{stem}.cbr.h5"), ours)
    for setting, words in (("splu and eigsh, by default", []), ("splu for symmetric patterns, eigsh with its factor", ["symmetric"])):
        yield Job(case, "SciPy", setting, folder, ready, [*scipy, str(modes), *words], theirs)
    yield solver("CalculiX", case, "substructure, stiffness alone", folder, lambda path: calculix.write_matrices(path.with_suffix(".inp"), ready(), steel, side), substructure)


def with_scipy(stem, modes, symmetric):
    """Craig-Bampton matrices STEM.npz of CalculiX's matrices; for modes None STEM.hz: ten elastic frequencies of all dofs."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.linalg import LinearOperator, eigsh, splu

    def matrix(kind):
        i, j, values = np.fromfile(f"{stem}.{kind}", sep=" ").reshape(-1, 3).T
        A = coo_matrix((values, (i.astype(int) - 1, j.astype(int) - 1))).tocsc()
        return (A + A.T - coo_matrix((A.diagonal(), [np.arange(A.shape[0])] * 2))).tocsc()

    K, M = matrix("sti"), matrix("mas")
    if modes is None:
        values = eigsh(K, 16, M, sigma=-(2 * np.pi * 500.0)**2, return_eigenvectors=False)
        np.savetxt(f"{stem}.hz", np.sqrt(np.abs(np.sort(values)[6:])) / (2 * np.pi))
        return
    node = np.array([int(line.split(".")[0]) for line in open(f"{stem}.dof")])
    is_kept = np.isin(node, np.loadtxt(f"{stem}.kept", dtype=int))
    i, c = np.flatnonzero(~is_kept), np.flatnonzero(is_kept)
    K_ii, K_ic, M_ii, M_ic = K[i][:, i], K[i][:, c], M[i][:, i], M[i][:, c]
    start = time.process_time()
    lu = splu(K_ii, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}) if symmetric else splu(K_ii)
    Psi = -lu.solve(K_ic.toarray())
    print(f"factor and {len(c)} solutions: {time.process_time() - start:.2f} s")
    solve = LinearOperator(K_ii.shape, matvec=lu.solve) if symmetric else None
    values, Phi = eigsh(K_ii, modes, M_ii, sigma=0, OPinv=solve)
    print(f"with {modes} modes: {time.process_time() - start:.2f} s")
    carried = M_ii @ Psi + M_ic
    K_c, M_c = K[c][:, c] + K_ic.T @ Psi, M[c][:, c] + Psi.T @ carried + M_ic.T @ Psi
    M_kc, zero = Phi.T @ carried, np.zeros((modes, len(c)))
    np.savez(f"{stem}.npz", K=np.block([[np.diag(values), zero], [zero.T, K_c]]), M=np.block([[np.eye(modes), M_kc], [M_kc.T, M_c]]))


def jobs(settings):
    """All rows, in the order of the table. Generators: a case's references are made when its turn comes."""
    steel = calculix.STEEL_M
    folder, blocks = settings.out / "peers-ordinary-part", settings.out / "peers"
    ordinary = ({"full mesh": "full", "superelement, few shapes": "shapes", "superelement, all nodes": "nodes"},
                {"explicit": {}, "implicit": {"implicit": True}, "implicit, steps of 2 us, alpha -0.3": {"implicit": True, "step": 2e-6, "alpha": -0.3}})
    bracket = {"full mesh": "full", "superelement, 80 picked modes": "k80", "superelement, 80 picked modes, 4 critical steps": "k80-s4"}
    if settings.smoke:
        return [impact(settings, 1), part(settings, "ordinary-part", "small", *ordinary)]
    return [impact(settings, 0.5), impact(settings, 1), impact(settings, 2), part(settings, "ordinary-part", "small", *ordinary),
            part(settings, "ordinary-part", "part", *ordinary), part(settings, "ordinary-part", "part", *ordinary, friction="-friction"),
            part(settings, "small-features", "tet4", bracket, {"explicit": {}}), part(settings, "small-features", "tet10", bracket, {"implicit": {"implicit": True}}),
            joint(settings), tumbling(settings),
            *(reduction(settings, title, folder / mesh, lambda mesh=mesh: make(settings, "ordinary-part", folder, mesh), "foot", modes, steel)
              for title, mesh, modes in (("the ordinary part, small", "small.msh", 60), ("the ordinary part", "part.msh", 120))),
            reduction(settings, "T1 (c)", blocks / "block-1.msh", lambda: t1.make_mesh(1, (20, 10, 15), blocks), "surface", 500, calculix.STEEL_T1)]


def versions():
    """Name and version of each peer; what is missing says so."""
    found = {"CalculiX": "not installed (Debian: calculix-ccx)", "SciPy": "not installed (Debian: python3-scipy)",
             "Chrono": "not installed (chrono.cpp, compiled as peer-chrono)", "OpenRadioss": "not installed (starter_linux64_gf and engine_linux64_gf, with RAD_CFG_PATH)"}
    if shutil.which("ccx"):
        said = re.search(r"Version\s+(\S+)", subprocess.run(["ccx", "-v"], capture_output=True, text=True).stdout)
        found["CalculiX"] = said[1] if said else "of an unknown version"
    if shutil.which("starter_linux64_gf") and shutil.which("engine_linux64_gf") and "RAD_CFG_PATH" in os.environ:
        said = subprocess.run(["starter_linux64_gf", "-version"], capture_output=True, text=True).stdout
        found["OpenRadioss"] = f"built {re.search('Date of build : (.*)', said)[1].strip()}"
    if shutil.which("peer-chrono"):
        found["Chrono"] = subprocess.run(["peer-chrono"], capture_output=True, text=True).stdout.strip()
    if importlib.util.find_spec("scipy"):
        import scipy
        found["SciPy"] = scipy.__version__ if shutil.which("ccx") else "not measured: its matrices need CalculiX"
    return found


def measure(settings, say=print):
    """Writes peers.csv, peer-curves.csv and peer-versions.csv, a row as soon as it is measured."""
    path, curves, known = settings.out / "peers.csv", settings.out / "peer-curves.csv", versions()
    try:
        only = re.compile(os.environ.get("ONLY", ""))
    except re.error as error:
        sys.exit(f"ONLY: {error}: give a regular expression of rows, as 'T1, r = 0.5; .*'")
    write_csv(settings.out / "peer-versions.csv", [{"peer": f"{name} {of}"} for name, of in known.items()], ["peer"])
    (settings.out / "peers").mkdir(parents=True, exist_ok=True)
    for case in jobs(settings):
        for job in case:
            # A smoke run is the same with peers and without
            if not only.search(f"{job.case}; {job.program}; {job.setting}") or settings.smoke and job.program != "cbr":
                continue
            missing = known.get(job.program, "").startswith("not")
            key = (job.case, job.program, job.setting)
            row = {**dict(zip(KEY, key)), "note": known[job.program]} if missing else job.run(settings.repeats)
            new = []
            if job.curves and row.get("error_percent", "") != "":
                t, force, t_energy, energy = apart(job.curves)
                new = [{**dict(zip(KEY, key)), "curve": curve, "t": x, "value": y} for curve, *points in (("force", t, force), ("energy", t_energy, energy)) for x, y in zip(*points)]
            for file, rows, columns in ((path, [row], COLUMNS), (curves, new, [*KEY, "curve", "t", "value"])):
                write_csv(file, [r for r in read_csv(file) if tuple(r[column] for column in KEY) != key] + rows, columns)
            say(f"  {'; '.join(key)}: {row.get('seconds', '')} s, {row.get('error_percent', '')} % {row['note']}")
    if not any(only.search("; ".join(row[column] for column in KEY)) for row in read_csv(path)):
        sys.exit(f"peers.py: no row matches ONLY={only.pattern}; rows are \"case; program; setting\", and make needs $$ for $")


if __name__ == "__main__":
    with_scipy(sys.argv[1], None if sys.argv[2] == "reference" else int(sys.argv[2]), "symmetric" in sys.argv[3:])
