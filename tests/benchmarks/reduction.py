# SPDX-License-Identifier: GPL-3.0-or-later
"""cbr-reduce by phase: seconds, flops, rate, share of the limit; the cost of a second run on unchanged inputs, and of a larger interior."""
import subprocess

import limits
import t1
from runs import in_turns, median, run

COLUMNS = ["row", "phase", "seconds", "flops", "flop_rate", "limit_s", "share_of_limit", "share_of_total", "dofs", "interface_dofs", "modes", "factor_nonzeros",
           "factor_flops", "peak_memory_bytes", "note"]
AGAIN = ["row", "first_s", "again_s", "ratio", "target", "reached", "note"]
# Phase -> column of interior.csv
OF_INTERIOR = {"assembly": "assembly_s", "factorisation": "factorisation_s", "factorisation and condensation": "both_s",
               "fixed-interface modes": "modes_s", "condensation": "condensation_s", "diagonal form": "diagonal_s", "total": "total_s"}
INTERIOR = ["row", "hexes", "dofs", "interface_dofs", "factor_flops", *OF_INTERIOR.values(), "grows_flops", "grows_factorisation", "grows_total", "reached",
            "peak_memory_bytes", "note"]

# Phase -> counts that are its flops, by the names of the program; limits.reduction has those of the diagonal form
FLOPS = {"factorisation": ("factor_flops",), "condensation": ("solve_flops", "product_flops"),
         "factorisation and condensation": ("factor_flops", "front_flops")}


def make_case(settings, case, folder, *targets):
    """make in a folder of tests/cases, its results in `folder`; the process when it has ended."""
    command = ["make", "--no-print-directory", "-s", "-C", t1.HERE.parent / "cases" / case, f"OUT={folder}", f"BIN={settings.bin}",
               f"PYTHON={settings.python}", f"FAST={'1' if settings.smoke else ''}", *targets]
    return subprocess.run(command, stdout=subprocess.PIPE, text=True)


def cases(folder, settings):
    """name -> function that writes the scene and returns its file."""
    def block(model, modes, r, hexes):
        def make():
            t1.make_mesh(r, hexes, folder)
            case = t1.Case(r, (model, modes, "frequency", "impulse", ""), hexes, folder, settings.bin)
            case.write_scene(1e-7)
            return f"{case.stem}.yaml"
        return make

    def of_case(case, mesh, model):
        def make():
            make_case(settings, case, folder, folder / f"{mesh}.msh", folder / f"{mesh}-{model}.yaml").check_returncode()
            return f"{mesh}-{model}.yaml"
        return make

    if settings.smoke:
        return {"T1 (a), 5 modes": block("a", 5, 1, (6, 4, 5)), "small features": of_case("small-features", "small", "k20"),
                "ordinary part, shapes": of_case("ordinary-part", "small", "shapes")}
    return {"T1 (a), 80 modes": block("a", 80, 1, (20, 10, 15)), "T1 (c), 500 modes": block("c", 500, 1, (20, 10, 15)),
            "T1 (a), 80 modes, r = 2": block("a", 80, 2, (40, 20, 30)),
            "T1, shapes, 20 modes, r = 2": block("shapes", 20, 2, (40, 20, 30)),
            "small features, 80 modes": of_case("small-features", "tet4", "k80"),
            "ordinary part, 120 modes": of_case("ordinary-part", "part", "nodes"),
            "ordinary part, shapes, 120 modes": of_case("ordinary-part", "part", "shapes")}


def phases(name, tables, rates):
    counts = {key: median(tables, "count", key) for key in tables[0]["count"]}
    least = limits.reduction(rates, counts)
    n = counts["interface_dofs"] + counts["modes"]
    common = {"row": name, "dofs": counts["dofs"], "interface_dofs": counts["interface_dofs"], "modes": counts["modes"], "note": "",
              "factor_nonzeros": counts["factor_nonzeros"], "factor_flops": counts["factor_flops"], "peak_memory_bytes": counts["peak_memory_bytes"]}
    total = median(tables, "phase", "total")
    rows = []
    for phase in tables[0]["phase"]:
        seconds = median(tables, "phase", phase)
        flops = sum(counts[count] for count in FLOPS.get(phase, ())) or (limits.diagonal_flops(n) if phase == "diagonal form" else 0)
        row = {**common, "phase": phase, "seconds": seconds, "share_of_total": seconds / total}
        if flops:
            row.update(flops=flops, flop_rate=flops / seconds)
        if least.get(phase) and seconds > 0:
            row.update(limit_s=least[phase], share_of_limit=least[phase] / seconds)
        rows.append(row)
    return rows


def largest(settings, rates, hexes, say=print):
    """Rows of largest.csv: one run of a block of that many hexes whose contact face is kept, with 20 modes."""
    folder = settings.out / "largest"
    folder.mkdir(parents=True, exist_ok=True)
    t1.make_mesh("large", hexes, folder)
    case = t1.Case("large", ("a", 20, "frequency", "impulse", ""), hexes, folder, settings.bin)
    case.write_scene(1e-7)
    # 2 GB of panels beside a factor of 14 GB
    table = run(settings.bin, "cbr-reduce", f"{case.stem}.yaml", "--force", "--memory", "2GB", folder=folder)
    say(f"  {table['wall']:.0f} s, {table['count']['peak_memory_bytes'] / 1e9:.1f} GB")
    return phases(f"block of {hexes[0]} x {hexes[1]} x {hexes[2]} hexes, 20 modes", [table], rates)


def measure(settings, rates, say=print):
    """Rows of reduction.csv and of again.csv."""
    folder = settings.out / "reduction"
    folder.mkdir(parents=True, exist_ok=True)
    scenes, rows, again = {}, [], []
    for name, make in cases(folder, settings).items():
        scenes[name] = make()
    jobs = {name: (lambda scene=scene: run(settings.bin, "cbr-reduce", scene, "--force", folder=folder)) for name, scene in scenes.items()}
    results, refused = in_turns(jobs, settings.repeats, say)
    second, _ = in_turns({name: (lambda scene=scenes[name]: run(settings.bin, "cbr-reduce", scene, folder=folder)) for name in results}, settings.repeats, say)
    for name, tables in results.items():
        rows += phases(name, tables, rates)
        first_s, again_s = median(tables, "phase", "total"), median(second[name], "phase", "total")
        again.append({"row": name, "first_s": first_s, "again_s": again_s, "ratio": again_s / first_s, "target": 0.2,
                      "reached": "yes" if again_s <= 0.2 * first_s else "no"})
    notes = [{"row": name, "note": f"left out: {text}"} for name, text in refused.items()]
    return rows + notes, again


def factor_s(row):
    return row["factorisation_s"] + row["both_s"]


def interior(settings, say=print):
    """Rows of interior.csv: ever longer bars, and how much more each takes than the first."""
    folder = settings.out / "interior"
    folder.mkdir(parents=True, exist_ok=True)
    side, lengths = (4, (4, 12)) if settings.smoke else (20, (20, 60, 200))
    jobs = {}
    for length in lengths:
        hexes = (length, side, side)
        t1.make_mesh(f"{length}-long", hexes, folder)
        case = t1.Case(f"{length}-long", ("a", 20, "frequency", "impulse", ""), hexes, folder, settings.bin)
        case.write_scene(1e-7)
        jobs[length] = lambda scene=f"{case.stem}.yaml": run(settings.bin, "cbr-reduce", scene, "--force", folder=folder)
    results, refused = in_turns(jobs, settings.repeats, say)
    rows, first = [], None
    for length, tables in results.items():
        row = {"row": f"{side} x {side} hexes, {length} long", "hexes": length * side * side, "note": "",
               **{key: median(tables, "count", key) for key in ("dofs", "interface_dofs", "factor_flops", "peak_memory_bytes")},
               **{column: median(tables, "phase", phase) for phase, column in OF_INTERIOR.items()}}
        first = first or row
        row.update(grows_flops=row["factor_flops"] / first["factor_flops"], grows_factorisation=factor_s(row) / factor_s(first),
                   grows_total=row["total_s"] / first["total_s"])
        if row is not first:
            row["reached"] = "yes" if row["grows_total"] <= row["grows_flops"] else "no"
        rows.append(row)
    return rows + [{"row": f"{length} long", "note": f"left out: {text}"} for length, text in refused.items()]
