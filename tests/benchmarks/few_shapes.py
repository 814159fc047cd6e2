# SPDX-License-Identifier: GPL-3.0-or-later
"""T1 with interfaces of few shapes (basis: characteristic) beside all dofs: what impact, friction and a whole surface in the interface cost.

`stepping_s` of a row with friction stands beside that of the same superelements and motion without: `against_frictionless`.
"""
import h5py
import numpy as np

import t1
from runs import in_turns, median, run

COLUMNS = ["row", "interface", "friction", "n", "steps", "rms_percent_of_half_speed", "separation", "energy", "residual", "friction_J", "stepping_s",
           "against_frictionless", "reduction_s", "file_bytes", "note"]
FACE, SURFACE = "contact", "surface, contact"
PICKED = "modes: 20, pick: participation"
# Superelement: interface, entries of `reduction`
REDUCTIONS = {
    "all": (FACE, PICKED),
    "c10": (FACE, PICKED + ", basis: characteristic, characteristic: {modes: 10}"),
    "s20": (FACE, "modes: 20, basis: characteristic, characteristic: {modes: 10, shear: true}"),
    "surface-all": (SURFACE, PICKED),
    "surface-all-500": (SURFACE, "modes: 500"),
    "surface-keep": (SURFACE, PICKED + ", basis: characteristic, characteristic: {modes: 40, keep: [contact]}"),
    "surface-pattern": (SURFACE, PICKED + ", basis: characteristic, characteristic: {modes: 40}"),
}
# Row: superelement, friction, speed of the left block along the face, the same without friction
ROWS = {
    "all": ("all", 0, 0, ""),
    "c10": ("c10", 0, 0, ""),
    "c10 slides": ("c10", 0, 500, ""),
    "c10 rubs": ("c10", 0.3, 500, "c10 slides"),
    "s20": ("s20", 0, 0, ""),
    "s20 slides": ("s20", 0, 500, ""),
    "s20 rubs": ("s20", 0.3, 500, "s20 slides"),
    "s20z rubs": ("s20", 0.3, 0, "s20"),
    "surface-all": ("surface-all", 0, 0, ""),
    "surface-all-500": ("surface-all-500", 0, 0, ""),
    "surface-keep": ("surface-keep", 0, 0, ""),
    "surface-keep rubs": ("surface-keep", 0.3, 0, "surface-keep"),
    "surface-pattern": ("surface-pattern", 0, 0, ""),
}
SMOKE = ("all", "c10", "c10 slides", "c10 rubs", "surface-keep")

SCENE = """materials:
  steel: {{youngs_modulus: 5.17e12, poissons_ratio: 0.3, density: 7836}}
components:
  block: {{mesh: block-1.msh, material: steel, reduction: {{interface: [{interface}], {reduction}, superelement: {superelement}}}}}
instances:
  left:  {{component: block, as: superelement, position: [-0.0279, 0, 0], velocity: [{speed}, {along}, 0]}}
  right: {{component: block, as: superelement, position: [ 0.0381, 0, 0], mirror: x}}
contact:
  - {{between: [left.contact, right.contact], enforcement: impulse, friction: {friction}}}
time: {{end: {end}}}
output: {{every: 1.0e-7, history: [left.contact, right.contact]}}
"""


def file_of(row):
    return "run-" + row.replace(" ", "-")


def superelement_of(row):
    """Friction asks for other statics."""
    return ROWS[row][0] + ("-rubs" if ROWS[row][1] else "")


def results_of(file, slides):
    with h5py.File(file) as f:
        momentum = [f[f"instances/{name}/momentum"][:, 0] for name in ("left", "right")]
        energy, taken = f["energy/total"][:], f["energy/work_friction"][:]
        residual = f["contact/left.contact - right.contact/residual"][:]
    row = {"separation": (momentum[1][-1] - momentum[0][-1]) / momentum[0][0], "energy": energy[-1] / energy[0], "residual": float(np.max(residual)),
           "friction_J": float(0 - taken[-1])}
    return row | ({} if slides else {"rms_percent_of_half_speed": 2 * t1.errors(file)[0]})


def reduce_all(settings, wanted, folder, say):
    """{superelement: its columns}; the scenes of the rows that are wanted stand in `folder` then."""
    columns = {}
    for row in wanted:
        name, friction, along, _ = ROWS[row]
        interface, reduction = REDUCTIONS[name]
        reduced = superelement_of(row)
        if settings.smoke:
            reduction = reduction.replace("modes: 20", "modes: 5").replace("modes: 40", "modes: 8")
        scene = SCENE.format(interface=interface, reduction=reduction, superelement=f"{reduced}.cbr.h5", speed=t1.SPEED, along=along, friction=friction, end=t1.END)
        (folder / f"{file_of(row)}.yaml").write_text(scene)
        if reduced not in columns:
            say(f"  {reduced}: reduction")
            table = run(settings.bin, "cbr-reduce", f"{file_of(row)}.yaml", "--force", folder=folder)
            columns[reduced] = {"interface": interface.replace(",", " and"), "reduction_s": table["phase"]["total"],
                             "file_bytes": (folder / f"{reduced}.cbr.h5").stat().st_size}
    return columns


def measure(settings, say=print):
    """Rows of few_shapes.csv."""
    folder, hexes = settings.out / "few_shapes", (6, 4, 5) if settings.smoke else (20, 10, 15)
    folder.mkdir(parents=True, exist_ok=True)
    t1.make_mesh(1, hexes, folder)
    wanted = [row for row in ROWS if row in SMOKE or not settings.smoke]
    reduced = reduce_all(settings, wanted, folder, say)
    jobs = {row: lambda name=file_of(row): run(settings.bin, "cbr-dyn", f"{name}.yaml", "-o", f"{name}.h5", folder=folder) for row in wanted}
    results, refused = in_turns(jobs, settings.repeats, say)
    rows = []
    for row, tables in results.items():
        name, friction, along, rival = ROWS[row]
        count, seconds = tables[0]["count"], median(tables, "phase", "steps")
        rows.append({"row": row, "friction": friction, **reduced[superelement_of(row)], "n": count["dofs"] / 2, "steps": count["steps"], "stepping_s": seconds,
                     **results_of(folder / f"{file_of(row)}.h5", along != 0)})
        if rival in results:
            rows[-1]["against_frictionless"] = seconds / median(results[rival], "phase", "steps")
    return rows + [{"row": row, "note": f"left out: {text}"} for row, text in refused.items()]
