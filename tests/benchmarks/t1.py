# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's block impact (T1) on 20 r x 10 r x 15 r hexes: run time against error, all rivals in turns."""
import os
import pathlib

import h5py
import numpy as np

import limits
from runs import Refused, block_mesh, in_turns, median, read_table, run, spread

SPEED, CONTACT, END = 3810.0, 4.25e-6, 1.2e-5  # m/s, s; contact lasts so long in the converged answer
CENTRE = 0.0051  # x of the plane of symmetry at the start; it moves with SPEED / 2
HERE = pathlib.Path(__file__).resolve().parent

PARTS = ("bodies", "search", "response", "contact", "output")  # of the steps
COLUMNS = ["row", "r", "model", "modes", "pick", "enforcement", "step_option", "dofs", "steps", "step_s", "contact_steps", "mean_rows", "rms_percent",
           "rms_percent_of_half_speed", "energy_kept", "read_s", "setup_s", "stepping_s", "write_s", "total_s", "user_s", "spread", *(f"{part}_s" for part in PARTS), "limit_s", "share_of_limit", "read_limit_s",
           "reduction_s", "peak_memory_bytes", "speedup", "break_even_runs", "note"]

SCENE = """materials:
  steel: {{youngs_modulus: 5.17e12, poissons_ratio: 0.3, density: 7836}}
components:
  block:
    mesh: block-{r}.msh
    material: steel
    reduction: {{interface: [{interface}], modes: {modes}, pick: {pick}{basis}{recovery}, superelement: {superelement}}}
instances:
  left:  {{component: block, as: {kind}, position: [-0.0279, 0, 0], velocity: [3810, 0, 0]}}
  right: {{component: block, as: {kind}, position: [ 0.0381, 0, 0], mirror: x}}
contact:
  - {{between: [left.contact, right.contact], enforcement: {enforcement}}}
time: {{end: {end}{time}}}
output: {{every: {every}, history: [left.contact, right.contact]{fields}}}
"""
# a, b, c: the paper's interfaces, basis craig-bampton; shapes: the face of (a), basis characteristic
INTERFACES = {"a": "contact", "b": "contact, x_min", "c": "surface", "shapes": "contact", "full": "contact"}
BASES = {"shapes": ", basis: characteristic"}


def rows_of(r, smoke):
    """(model, modes, pick, enforcement, entry of time) of the rivals on mesh r. Every mesh has the full mesh as its first."""
    rivals = [("full", 0, "frequency", "impulse", "")]
    # The same steps in seconds on every mesh, so the same modes that move
    long = [f", step: {{cfl: {cfl * r:g}}}" for cfl in ((2,) if smoke else (1, 1.5, 2, 3))]
    picked = ("a", 5 if smoke else 20, "participation", "impulse")
    rivals += [("shapes", n, "participation", "impulse", "") for n in ((5,) if smoke else (20, 40))]
    # All 7503 dofs of the face at r = 4 take an hour to reduce
    if r >= 4:
        return rivals
    rivals += [picked + (time,) for time in ("", *long)]
    if smoke:
        return rivals
    if r == 1:
        rivals += [("full", 0, "frequency", "penalty", ""), ("full", 0, "frequency", "nodal", "")]
        rivals += [("a", 20, "participation", e, "") for e in ("penalty", "nodal")]
        rivals += [("a", 20, "participation", "impulse", f", step: {step}") for step in (1e-7, 5e-8)]
        rivals += [("c", 500, "frequency", "impulse", time) for time in ("", long[2])]
    rivals += [("a", 80, "participation", "impulse", time) for time in ("", long[2])]
    rivals += [("a", modes, "frequency", "impulse", time) for modes in (80, 200, 500) for time in ("", long[2])]
    return rivals + [("b", 80, "frequency", "impulse", time) for time in ("", long[2])]


def label(r, model, modes, pick, enforcement, time):
    name = f"r{r} {model}" + ("" if model == "full" else f" {modes}" + (" picked" if pick == "participation" else ""))
    name += "" if enforcement == "impulse" else f" {enforcement}"
    option = time.replace(", step: ", " ").replace("{cfl: ", "cfl ").replace("}", "")
    return name + option


def outputs_for(n_steps, least=24, most=40):
    """A number of outputs, whose whole multiple of steps is the least that is not below n_steps: outputs cost a step or two in a hundred."""
    return min(range(least, most + 1), key=lambda n: (n * -(-n_steps // n), -n))


def reference():
    """t, distance of the face from the plane of symmetry."""
    t, s, _ = np.loadtxt(HERE / "reference" / "t1.txt").T
    return t, s


def errors(results):
    """rms of the two faces' positions at the outputs against the converged answer, per cent of SPEED x CONTACT; energy kept, of that in
    the frame of the common centre of mass: what an impact can take."""
    t_ref, s_ref = reference()
    with h5py.File(results) as f:
        t = f["time"][:]
        s = np.interp(t, t_ref, s_ref)
        plane = CENTRE + SPEED / 2 * t
        d = [f[f"surfaces/{name}.contact/mean_position"][:, 0] - plane for name in ("left", "right")]
        momentum = sum(f[f"instances/{name}/momentum"][0] for name in ("left", "right"))
        energy = f["energy/total"][:]
    rms = np.sqrt(np.mean(np.concatenate([d[0] - s, d[1] + s])[:] ** 2))
    common = np.linalg.norm(momentum) * SPEED / 4  # P^2 / 2 M with P = M SPEED / 2
    return 100 * rms / (SPEED * CONTACT), (energy[-1] - common) / (energy[0] - common)


class Case:
    """One rival on one mesh."""
    reduced = {}  # superelement -> how its reduction by this process ended

    def __init__(self, r, rival, hexes, folder, bin_dir):
        self.r, self.rival, self.hexes, self.folder, self.bin_dir = r, rival, hexes, folder, bin_dir
        self.model, self.modes, self.pick, self.enforcement, self.time = rival
        self.name = label(r, *rival)
        self.stem = self.name.replace(" ", "-").replace(":", "")
        self.superelement = f"{self.model}-{self.r}-{self.modes}-{self.pick}.cbr.h5"
        self.is_mesh = self.model == "full"

    def write_scene(self, every, fields="", recovery=""):
        """fields, recovery: what follows in the entries of output and reduction."""
        text = SCENE.format(r=self.r, interface=INTERFACES[self.model], modes=max(self.modes, 1), pick=self.pick,
                            basis=BASES.get(self.model, ""), superelement=self.superelement,
                            kind="mesh" if self.is_mesh else "superelement", enforcement=self.enforcement, end=END, time=self.time, every=every,
                            fields=fields, recovery=recovery)
        (self.folder / f"{self.stem}.yaml").write_text(text)

    def reduce(self):
        """Seconds and counts of cbr-reduce, run once for each superelement, with REUSE=1 only when there is none; None for the mesh."""
        if self.is_mesh:
            return None
        target, table = self.folder / self.superelement, self.folder / f"{self.superelement}.csv"
        reuse = os.environ.get("REUSE", "") not in ("", "0") and target.exists() and table.exists()
        if target not in Case.reduced and not reuse:
            try:
                Case.reduced[target] = run(self.bin_dir, "cbr-reduce", f"{self.stem}.yaml", "--force", folder=self.folder, timings=table.name)
            except Refused as error:
                Case.reduced[target] = error
        if isinstance(Case.reduced.get(target), Refused):
            raise Case.reduced[target]
        return read_table(table)

    def dyn(self):
        return run(self.bin_dir, "cbr-dyn", f"{self.stem}.yaml", "-o", f"{self.stem}.h5", folder=self.folder, timings=f"{self.stem}.csv")

    def prepare(self, known_steps=None):
        """Reduces, finds how many steps the run needs when outputs do not limit them, and chooses the outputs to fit."""
        self.write_scene(0)
        self.reduction = self.reduce()
        self.n_steps = known_steps or int(self.dyn()["count"]["steps_planned"])
        self.write_scene(END / outputs_for(self.n_steps))

    def n_nodes(self):
        return int(np.prod([n + 1 for n in self.hexes]))

    def limit(self, rates, tables):
        """Seconds of stepping at the least."""
        steps, touching = (median(tables, "count", name) for name in ("steps", "contact_steps"))
        rows = median(tables, "count", "contact_rows") / max(touching, 1)
        m = (self.hexes[1] + 1) * (self.hexes[2] + 1)
        if self.is_mesh:
            return 2 * steps * limits.mesh_step(rates, int(np.prod(self.hexes)), self.n_nodes())
        if self.model == "shapes":
            n = median(tables, "count", "dofs") / 2
            in_contact = touching * limits.shapes_step(rates, n, m, rows)
            return 2 * (steps - touching) * limits.flight_step(rates, n) + in_contact
        n = median(tables, "count", "dofs") / 2
        return 2 * (steps - touching) * limits.flight_step(rates, n) + touching * limits.contact_step(rates, n, m, rows)

    def bytes_to_read(self):
        """What a run cannot do without: the mesh; of a superelement V, or where there is none its matrices."""
        if self.is_mesh:
            return (self.folder / f"block-{self.r}.msh").stat().st_size
        with h5py.File(self.folder / self.superelement) as f:
            if "characteristic" in f:
                names = ["characteristic/V", "characteristic/statics/F"]
                return sum(f[name].size * 8 for name in names if name in f)
            return sum(f[name].size * 8 for name in (["diagonal/V"] if "diagonal" in f else ["matrices/K_cc", "matrices/M_cc", "matrices/M_kc"]))

    def row(self, tables, rates):
        rms, energy = errors(self.folder / f"{self.stem}.h5")
        steps, touching = median(tables, "count", "steps_planned"), median(tables, "count", "contact_steps")
        stepping, limit = median(tables, "phase", "steps"), self.limit(rates, tables)
        option = self.time.strip(", ") or "auto"
        return {
            "row": self.name, "r": self.r, "model": self.model, "modes": self.modes, "pick": self.pick if not self.is_mesh else "",
            "enforcement": self.enforcement, "step_option": option, "dofs": median(tables, "count", "dofs") / 2, "steps": steps,
            "step_s": END / steps, "contact_steps": touching, "mean_rows": median(tables, "count", "contact_rows") / max(touching, 1),
            "rms_percent": rms, "rms_percent_of_half_speed": 2 * rms, "energy_kept": energy, "read_s": median(tables, "phase", "read"),
            "setup_s": median(tables, "phase", "setup"), "stepping_s": stepping, "write_s": median(tables, "phase", "write"),
            "total_s": median(tables, "phase", "total"), "user_s": median(tables, "user", None), "spread": spread(tables, "phase", "steps"),
            **{f"{part}_s": median(tables, "part", f"steps: {part}") for part in PARTS},
            "limit_s": limit, "share_of_limit": limit / stepping, "read_limit_s": limits.reading(rates, self.bytes_to_read()),
            "peak_memory_bytes": median(tables, "count", "peak_memory_bytes"),
            "reduction_s": self.reduction["phase"]["total"] if self.reduction else 0.0, "note": "",
        }


def make_mesh(r, hexes, folder):
    block_mesh(folder / f"block-{r}.msh", hexes)


def measure(r, folder, bin_dir, rates, repeats, smoke=False, say=print, steps_per_r=None):
    """Rows of mesh r, and the steps that the full mesh takes. steps_per_r: those of r = 1, so that no run is spent on finding them."""
    hexes = (6, 4, 5) if smoke else tuple(int(n * r) for n in (20, 10, 15))
    folder.mkdir(parents=True, exist_ok=True)
    make_mesh(r, hexes, folder)
    cases, notes = {}, []
    full_steps = None
    for rival in rows_of(r, smoke):
        case = Case(r, rival, hexes, folder, bin_dir)
        # The critical step of the same elements falls with their size; a little less on a larger mesh
        known = int(np.ceil(1.005 * steps_per_r * r)) if steps_per_r and case.is_mesh and case.enforcement == "impulse" else None
        try:
            case.prepare(known)
            cases[case.name] = case
        except Refused as error:
            say(f"  {case.name}: left out: {error}")
            notes.append({"row": case.name, "r": r, "note": f"left out: {error}"})
        if case.is_mesh and case.enforcement == "impulse" and case.name in cases:
            full_steps = case.n_steps
    results, refused = in_turns({name: case.dyn for name, case in cases.items()}, repeats, say)
    rows = [cases[name].row(tables, rates) for name, tables in results.items()]
    full = next((row for row in rows if row["model"] == "full"), None)
    for row in rows:
        row["speedup"] = full["stepping_s"] / row["stepping_s"] if full else ""
        gain = full["total_s"] - row["total_s"] if full else 0
        row["break_even_runs"] = row["reduction_s"] / gain if gain > 0 else ""
    return rows + notes + [{"row": name, "r": r, "note": f"left out: {text}"} for name, text in refused.items()], full_steps
