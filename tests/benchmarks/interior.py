# SPDX-License-Identifier: GPL-3.0-or-later
"""What a reduction costs when its interior grows and its interface stays: bars of one cross-section, one end kept."""
import t1
from runs import in_turns, median, run

PHASES = {"assembly": "assembly_s", "factorisation": "factorisation_s",
          "factorisation and condensation": "both_s", "fixed-interface modes": "modes_s", "condensation": "condensation_s",
          "diagonal form": "diagonal_s", "total": "total_s"}
COLUMNS = ["row", "hexes", "dofs", "interface_dofs", "factor_flops", *PHASES.values(), "grows_flops", "grows_factorisation", "grows_total", "reached",
           "peak_memory_bytes", "note"]
MODES = 20


def factor_s(row):
    return row["factorisation_s"] + row["both_s"]


def measure(settings, say=print):
    """Rows of interior.csv: ever longer bars, and how much more each takes than the first."""
    folder = settings.out / "interior"
    folder.mkdir(parents=True, exist_ok=True)
    side, lengths = (4, (4, 12)) if settings.smoke else (20, (20, 60, 200))
    jobs = {}
    for length in lengths:
        hexes = (length, side, side)
        t1.make_mesh(f"{length}-long", hexes, folder)
        case = t1.Case(f"{length}-long", ("a", MODES, "frequency", "impulse", ""), hexes, folder, settings.bin)
        case.write_scene(1e-7)
        jobs[length] = lambda scene=f"{case.stem}.yaml": run(settings.bin, "cbr-reduce", scene, "--force", folder=folder)
    results, refused = in_turns(jobs, settings.repeats, say)
    rows, first = [], None
    for length, tables in results.items():
        row = {"row": f"{side} x {side} hexes, {length} long", "hexes": length * side * side, "note": "",
               **{key: median(tables, "count", key) for key in ("dofs", "interface_dofs", "factor_flops", "peak_memory_bytes")},
               **{column: median(tables, "phase", phase) for phase, column in PHASES.items()}}
        first = first or row
        row.update(grows_flops=row["factor_flops"] / first["factor_flops"], grows_factorisation=factor_s(row) / factor_s(first),
                   grows_total=row["total_s"] / first["total_s"])
        if row is not first:
            row["reached"] = "yes" if row["grows_total"] <= row["grows_flops"] else "no"
        rows.append(row)
    return rows + [{"row": f"{length} long", "note": f"left out: {text}"} for length, text in refused.items()]
