# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene does not need must cost nothing: bodies that never meet, flight without contact."""
import t1
from runs import in_turns, median, run

COLUMNS = ["row", "against", "bodies", "steps_planned", "steps", "total_s", "stepping_s", "setup_s", "read_s", "write_s", "peak_memory_bytes", "ratio", "stepping_ratio",
           "target", "reached", "note"]
SPACING = 0.1  # m between the blocks that take no part; no two of them can meet

SCENE = """materials:
  steel: {{youngs_modulus: 5.17e12, poissons_ratio: 0.3, density: 7836}}
components:
  block:
    mesh: block-{r}.msh
    material: steel
    reduction: {{interface: [contact], modes: {modes}, pick: participation, superelement: skipping.cbr.h5}}
instances:
  left:  {{component: block, as: superelement, position: [-0.0279, 0, 0], velocity: [3810, 0, 0]}}
  right: {{component: block, as: superelement, position: [{right}, 0, 0], mirror: x}}
{others}contact: all
time: {{end: {end}}}
output: {{every: {every}, history: [left.contact, right.contact]}}
"""


def scene(modes, others=0, velocity="[0, 0, 0]", gap=0.0152, end=1.2e-5, outputs=40):
    lines = "".join(f"  other{i}: {{component: block, as: superelement, position: [{SPACING * (i % 8 - 4):.3g}, {SPACING * (1 + i // 8):.3g}, 0], "
                    f"velocity: {velocity}}}\n" for i in range(others))
    return SCENE.format(r=1, modes=modes, right=0.0229 + gap, others=lines, end=end, every=end / outputs)


def scenes(smoke):
    """name -> (text, bodies); and (row, its base, target of the ratio of total times)."""
    modes, n = (5, 8) if smoke else (80, 48)
    flight = 1.3e-5 if not smoke else 4e-5  # about 100 steps of contact
    longer = 0.0152 + 9 * 3810 * flight
    of = {
        "two blocks": (scene(modes), 2),
        f"{n + 2} blocks, two meet": (scene(modes, n), n + 2),
        f"{n + 2} blocks, two meet, the others fly": (scene(modes, n, "[0, 100, 0]"), n + 2),
        "flight": (scene(modes, gap=100, end=flight, outputs=4), 2),
        "flight ten times as long": (scene(modes, gap=100, end=10 * flight, outputs=4), 2),
        "impact": (scene(modes, end=flight, outputs=4), 2),
        "impact after a flight ten times as long": (scene(modes, gap=longer, end=10 * flight, outputs=4), 2),
    }
    names = list(of)
    return of, [(names[1], names[0], 3.0), (names[2], names[0], 3.0), (names[4], names[3], 1.5), (names[6], names[5], 1.5)]


def measure(settings, say=print):
    folder = settings.out / "skipping"
    folder.mkdir(parents=True, exist_ok=True)
    t1.make_mesh(1, (6, 4, 5) if settings.smoke else (20, 10, 15), folder)
    of, ratios = scenes(settings.smoke)
    files = {}
    for i, (name, (text, _)) in enumerate(of.items()):
        files[name] = f"skipping-{i}.yaml"
        (folder / files[name]).write_text(text)
    run(settings.bin, "cbr-reduce", files["two blocks"], folder=folder)
    jobs = {name: (lambda file=file: run(settings.bin, "cbr-dyn", file, "-o", file.replace(".yaml", ".h5"), folder=folder)) for name, file in files.items()}
    results, refused = in_turns(jobs, settings.repeats, say)
    rows = {}
    for name, tables in results.items():
        rows[name] = {"row": name, "bodies": of[name][1], "steps_planned": median(tables, "count", "steps_planned"), "steps": median(tables, "count", "steps"),
                      "peak_memory_bytes": median(tables, "count", "peak_memory_bytes"), "note": ""}
        rows[name].update({f"{column}_s": median(tables, "phase", phase) for column, phase in
                           (("total", "total"), ("stepping", "steps"), ("setup", "setup"), ("read", "read"), ("write", "write"))})
    for name, base, target in ratios:
        if name in rows and base in rows:
            ratio = rows[name]["total_s"] / rows[base]["total_s"]
            rows[name].update(against=base, ratio=ratio, stepping_ratio=rows[name]["stepping_s"] / rows[base]["stepping_s"], target=target,
                              reached="yes" if ratio <= target else "no")
    return list(rows.values()) + [{"row": name, "note": f"left out: {text}"} for name, text in refused.items()]
