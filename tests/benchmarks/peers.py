# SPDX-License-Identifier: GPL-3.0-or-later
"""Beside the peers: CalculiX and SciPy on our meshes, next to cbr-dyn and cbr-reduce. Every process has one thread; its seconds are those of
the processor, user and system, from start to end. ONLY=REGEX of case, program and setting measures some rows, the others stay; LIMIT is the
most seconds of a process. As a program it is the reduction by SciPy that the benchmark runs: peers.py STEM MODES
[symmetric], or the frequencies of all dofs: peers.py STEM reference."""
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

import calculix
import t1
from runs import read_csv, read_table, write_csv

COLUMNS = ["case", "program", "setting", "runs", "reduction_s", "seconds", "steps_percent", "megabytes", "error_percent", "second", "note"]
CASES = t1.HERE.parent / "cases"
LIMIT = 600
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1"}


def clocked(command, folder, log):
    """(exit code or signal below 0, processor seconds, MB) of a process that is stopped after LIMIT seconds of its processor."""
    most = int(os.environ.get("LIMIT") or LIMIT)
    with open(folder / log, "w") as file:
        process = subprocess.Popen(command, cwd=folder, stdout=file, stderr=file, env={**os.environ, **ONE_THREAD},
                                   preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (most, most + 1)))
        _, status, usage = os.wait4(process.pid, 0)
    return os.waitstatus_to_exitcode(status), usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


class Job:
    """A row. command and reduction: words, run in `folder`; judge(): (error in per cent, second figure); stem: of the files of CalculiX."""

    def __init__(self, case, program, setting, folder, command, judge, reduction=None, stem=None):
        self.case, self.program, self.setting, self.folder = case, program, setting, folder
        self.command, self.judge, self.reduction, self.stem = command, judge, reduction, stem
        self.timings = folder / command[command.index("--timings") + 1] if "--timings" in command else None

    def why(self, code):
        """Of a run that did not end well: its message, and how far it came."""
        text = (self.folder / "log.txt").read_text(errors="replace")
        found = re.search(r"\*ERROR(?: in)?:?\s*([^*]{,160})", text) or re.search(r"error: (.{,160})", text)
        said = " ".join(found[1].split()) if found else signal.Signals(-code).name if code < 0 else f"exit code {code}"
        stopped = code in (-signal.SIGXCPU, -signal.SIGKILL)
        at = calculix.reached(self.folder / self.stem) if self.stem else None
        return (f"stopped after {os.environ.get('LIMIT') or LIMIT} s" if stopped else f"failed: {said}") + ("" if at is None else f", at {at:.3g} s")

    def run(self, repeats):
        row = {"case": self.case, "program": self.program, "setting": self.setting, "note": ""}
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
            phases += [read_table(self.timings)["phase"]] if self.timings else []
        row.update(runs=len(seconds), seconds=statistics.median(seconds))
        if phases and "steps" in phases[0]:
            # The program's own clock is of the wall; on a busy machine only its shares mean something
            row["steps_percent"] = statistics.median(100 * phase["steps"] / phase["total"] for phase in phases)
        row["error_percent"], row["second"] = self.judge()
        return row


def dyn(settings, scene):
    return [settings.bin / "cbr-dyn", f"{scene}.yaml", "-o", f"{scene}.h5", "--quiet", "--threads", "1", "--timings", f"{scene}.dyn.csv"]


def reduce(settings, *what):
    return [settings.bin / "cbr-reduce", *what, "--quiet", "--force", "--threads", "1"]


def make(settings, case, folder, *targets):
    """Files of a case, by its Makefile."""
    words = ["make", "--no-print-directory", "-s", "-C", CASES / case, f"OUT={folder}", f"BIN={settings.bin}", f"PYTHON={settings.python}", f"FAST={'1' if settings.smoke else ''}"]
    subprocess.run([*words, *(folder / target for target in targets)], check=True, stdout=subprocess.DEVNULL)


def ccx(case, setting, folder, stem, judge):
    return Job(case, "CalculiX", setting, folder, ["ccx", "-i", stem], judge, stem=stem)


def impact(settings, r):
    """T1: rms of the mean positions of the faces, of 8.1 mm; second: the rebound."""
    case, folder, hexes = f"T1, r = {r:g}", settings.out / "peers", (6, 4, 5) if settings.smoke else tuple(int(n * r) for n in (20, 10, 15))
    t1.make_mesh(r, hexes, folder)
    mesh = calculix.Mesh(folder / f"block-{r}.msh")

    def judge(stem):
        t_ref, s_ref = t1.reference()
        off, speeds = [], []
        for name, sign in (("LEFT", 1), ("RIGHT", -1)):
            t, x = calculix.path(folder / stem, f"{name}_contact")
            # The left face is at -2.5 mm, the right one at 12.7 mm; the plane of symmetry is t1.CENTRE at the start
            off.append(x[:, 0] - t1.SPEED / 2 * t - sign * (np.interp(t, t_ref, s_ref) - s_ref[0]))
            speeds.append(calculix.speed(folder / stem, name, mesh.weights())[0])
        return 200 * np.sqrt(np.mean(np.square(off))) / (t1.SPEED * t1.CONTACT), (speeds[1] - speeds[0]) / t1.SPEED

    def ours(model):
        def figures():
            with h5py.File(folder / f"{model.stem}.h5") as f:
                p = [f[f"instances/{name}/momentum"][:, 0] for name in ("left", "right")]
            return 2 * t1.errors(folder / f"{model.stem}.h5")[0], (p[1][-1] - p[0][-1]) / p[0][0]
        return figures

    n = 5 if settings.smoke else 40
    for setting, rival in (("full mesh", ("full", 0, "frequency")), ("superelement, by default", ("shapes", 2 * n, "frequency")),
                           (f"superelement, {n} picked modes", ("shapes", n, "participation"))):
        model = t1.Case(r, (*rival, "impulse", ""), hexes, folder, settings.bin)
        model.prepare()
        yield Job(case, "cbr", setting, folder, dyn(settings, model.stem), ours(model), None if model.is_mesh else reduce(settings, f"{model.stem}.yaml"))
    step = 1e-7 / r
    for setting, options in (("explicit", {}), ("explicit, massless contact", {"contact": "MASSLESS"}), ("implicit", {"implicit": True}),
                             (f"implicit, steps of {step:.2g} s", {"implicit": True, "step": step})):
        stem = re.sub(r"\W+", "-", f"{case} {setting}")
        calculix.write_impact(folder / f"{stem}.inp", mesh, **options)
        yield ccx(case, setting, folder, stem, lambda stem=stem: judge(stem))


def part(settings, mesh_name, friction=""):
    """The pedestal: path of its centre of mass from that of the mesh `fine`, of its length; second: momentum upwards at the end, of that downwards before."""
    folder = settings.out / "peers-part"
    names = {"full mesh": "full", "superelement, few shapes": "shapes", "superelement, all nodes": "nodes"}
    scenes = {setting: f"{mesh_name}-{model}{friction}" for setting, model in names.items()}
    fine = f"fine-full{friction}" if not settings.smoke else scenes["full mesh"]
    make(settings, "ordinary-part", folder, f"{mesh_name}.msh", f"{fine}.h5", *(f"{scene}.yaml" for scene in scenes.values()))
    case = f"ordinary part, {mesh_name}" + (", friction" if friction else "")

    def off(t, x):
        with h5py.File(folder / f"{fine}.h5") as f:
            t_ref, x_ref = f["time"][:], f["instances/pedestal/center_of_mass"][:]
        moved = x_ref - x_ref[0]
        ours = np.array([np.interp(t, t_ref, moved[:, k]) for k in range(3)]).T
        return 100 * np.linalg.norm(x - x[0] - ours + ours[0], axis=1).max() / np.linalg.norm(np.diff(x_ref, axis=0), axis=1).sum()

    def figures(scene):
        with h5py.File(folder / f"{scene}.h5") as f:
            t, x, p = f["time"][:], f["instances/pedestal/center_of_mass"][:], f["instances/pedestal/momentum"][:]
        return off(t, x), -p[-1, 2] / p[0, 2]

    def judge(stem):
        t, x = calculix.path(folder / stem, "PART", mesh.weights())
        return off(t, x), calculix.speed(folder / stem, "PART", mesh.weights())[2]

    for setting, scene in scenes.items():
        # Superelements of all nodes are the same with friction and without
        yield Job(case, "cbr", setting, folder, dyn(settings, scene), lambda scene=scene: figures(scene),
                  None if setting == "full mesh" else reduce(settings, f"{scene}.yaml"))
    mesh = calculix.Mesh(folder / f"{mesh_name}.msh")
    for setting, options in (("explicit", {}), ("implicit", {"implicit": True}), ("implicit, steps of 2 us, alpha -0.3", {"implicit": True, "step": 2e-6, "alpha": -0.3})):
        stem = re.sub(r"\W+", "-", f"{case} {setting}")
        calculix.write_fall(folder / f"{stem}.inp", mesh, friction=0.3 if friction else 0, **options)
        yield ccx(case, setting, folder, stem, lambda stem=stem: judge(stem))


def joint(settings):
    """The bolted lap joint in statics: travel of the end in the second cycle of load, from that on a finer mesh; second: the bolt's force at the end, N."""
    folder, fine = settings.out / "peers-joint", settings.out / "peers-joint-fine"
    make(settings, "lap-joint", folder, "mesh.h5", "craig-bampton.h5")
    if not (fine / "mesh.h5").exists():
        fine.mkdir(parents=True, exist_ok=True)
        for number, name in enumerate(("plate", "washer", "bolt"), 1):
            sizes = ["-setnumber", "part", str(number), "-setnumber", "n", "6", "-setnumber", "layers", "3"]
            subprocess.run(["gmsh", "-3", "-v", "1", CASES / "lap-joint" / "joint.geo", *sizes, "-o", fine / f"{name}.msh"], check=True)
        make(settings, "lap-joint", fine, "mesh.h5")

    def figures(file):
        with h5py.File(file) as f:
            cycle = f["surfaces/upper.end/mean_position"][:, 0][f["time"][:] >= 6 - 1e-9]
            return np.ptp(cycle), -f["contact/head.cut - nut.cut/force"][-1, 2]

    reference = figures(fine / "mesh.h5")[0]

    def ours(name):
        travel, bolt = figures(folder / f"{name}.h5")
        return 100 * abs(travel / reference - 1), bolt

    def judge(stem):
        travel, bolt = calculix.joint_figures(folder / stem)
        return 100 * abs(travel / reference - 1), bolt

    yield Job("lap joint", "cbr", "full mesh", folder, dyn(settings, "mesh"), lambda: ours("mesh"))
    yield Job("lap joint", "cbr", "superelement, 10 modes a part", folder, dyn(settings, "craig-bampton"), lambda: ours("craig-bampton"), reduce(settings, "craig-bampton.yaml"))
    for setting, options in (("surface to surface", {}), ("surface to surface, springs of 1 N/mm, softer contact", {"springs": 1.0, "stiffness": 1e6}),
                             ("node to surface, springs of 1 N/mm", {"springs": 1.0, "contact": "NODE TO SURFACE"})):
        stem = re.sub(r"\W+", "-", f"joint {setting}")
        calculix.write_joint(folder / f"{stem}.inp", folder, **options)
        yield ccx("lap joint", setting, folder, stem, lambda stem=stem: judge(stem))


def reduction(settings, name, mesh, side, modes, steel, element):
    """Ten lowest elastic frequencies of the free reduced component, the worst from those of all dofs; second: dofs of the interface."""
    folder, case = mesh.parent, f"reduction of {name}"
    stem = re.sub(r"\W+", "-", name)
    reference, scipy = folder / f"{stem}-km.hz", [settings.python, t1.HERE / "peers.py", f"{stem}-km"]
    of = calculix.Mesh(mesh)
    calculix.write_matrices(folder / f"{stem}-km.inp", of, steel, element)
    calculix.write_matrices(folder / f"{stem}-sub.inp", of, steel, element, side)
    np.savetxt(folder / f"{stem}-km.kept", of.sides[side][0] + 1, fmt="%d")
    material = [word for pair in zip(("--youngs-modulus", "--poissons-ratio", "--density"), map(str, steel)) for word in pair]

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

    def substructure():
        with h5py.File(folder / f"{stem}.cbr.h5") as f:
            order = np.lexsort((f["dofs/component"][:], f["nodes/id"][:][f["dofs/node"][:]]))
            K = f["matrices/K_cc"][:][np.ix_(order, order)]
        return 100 * np.abs(calculix.triangle(folder / f"{stem}-sub.mtx", len(K)) - K).max() / np.abs(K).max(), len(K)

    yield Job(case, "cbr", f"Craig-Bampton, {modes} modes", folder,
              reduce(settings, mesh.name, "--interface", side, "--modes", str(modes), "--element", "hex8", "--mass", "consistent", *material, "-o", f"{stem}.cbr.h5"), ours)
    if shutil.which("ccx") and not reference.exists():
        clocked(["ccx", "-i", f"{stem}-km"], folder, "log.txt")
        clocked([*scipy, "reference"], folder, "log.txt")
    for setting, words in (("splu and eigsh, by default", []), ("splu for symmetric patterns, eigsh with its factor", ["symmetric"])):
        yield Job(case, "SciPy", setting, folder, [*scipy, str(modes), *words], theirs)
    yield ccx(case, "substructure, stiffness alone", folder, f"{stem}-sub", substructure)


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
    if settings.smoke:
        return [impact(settings, 1), part(settings, "small")]
    steel = calculix.STEEL_M
    folder = settings.out / "peers-part"
    return [impact(settings, 0.5), impact(settings, 1), impact(settings, 2), part(settings, "small"), part(settings, "part"), part(settings, "part", "-friction"),
            joint(settings), reduction(settings, "the ordinary part, small", folder / "small.msh", "foot", 60, steel, "C3D10"),
            reduction(settings, "the ordinary part", folder / "part.msh", "foot", 120, steel, "C3D10"),
            reduction(settings, "T1 (c)", settings.out / "peers" / "block-1.msh", "surface", 500, calculix.STEEL_T1, "C3D8")]


def versions():
    """Name and version of each peer; what is missing says so."""
    found = {"CalculiX": "not installed (Debian: calculix-ccx)", "SciPy": "not installed (Debian: python3-scipy)"}
    if shutil.which("ccx"):
        said = re.search(r"Version\s+(\S+)", subprocess.run(["ccx", "-v"], capture_output=True, text=True).stdout)
        found["CalculiX"] = said[1] if said else "of an unknown version"
    try:
        import scipy
        found["SciPy"] = scipy.__version__
    except ImportError:
        pass
    return found


def measure(settings, say=print):
    """Writes peers.csv and peer-versions.csv, a row as soon as it is measured."""
    path, known = settings.out / "peers.csv", versions()
    only = re.compile(os.environ.get("ONLY", ""))
    write_csv(settings.out / "peer-versions.csv", [{"peer": f"{name} {of}"} for name, of in known.items()], ["peer"])
    (settings.out / "peers").mkdir(parents=True, exist_ok=True)
    for case in jobs(settings):
        for job in case:
            # A smoke run is the same with peers and without
            if not only.search(f"{job.case}; {job.program}; {job.setting}") or settings.smoke and job.program != "cbr":
                continue
            missing = known.get(job.program, "").startswith("not")
            row = {"case": job.case, "program": job.program, "setting": job.setting, "note": known[job.program]} if missing else job.run(settings.repeats)
            key = (job.case, job.program, job.setting)
            write_csv(path, [r for r in read_csv(path) if (r["case"], r["program"], r["setting"]) != key] + [row], COLUMNS)
            say(f"  {'; '.join(key)}: {row.get('seconds', '')} s, {row.get('error_percent', '')} % {row['note']}")


if __name__ == "__main__":
    with_scipy(sys.argv[1], None if sys.argv[2] == "reference" else int(sys.argv[2]), "symmetric" in sys.argv[3:])
