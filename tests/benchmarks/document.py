#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of docs/benchmarks.md, anew from the CSV files, and its plots: document.py OUT DOCS.

A table stands between <!-- table NAME --> and <!-- end -->; what is around them is written by hand and stays. A table without measurements stays too.
"""
import pathlib
import re
import shutil
import sys

from runs import read_csv


def number(value, digits=3):
    if not isinstance(value, float):
        return str(value)
    if value == int(value) and abs(value) < 1e6:
        return str(int(value))
    return f"{value:.{digits}g}" if 1e-3 <= abs(value) < 1e5 else f"{value:.{digits}g}".replace("e-0", "e-").replace("e+0", "e")


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(number(cell) for cell in row) + " |" for row in rows])


def yes_no(reached):
    return "**yes**" if reached else "**no**"


def machine_table(out):
    versions = read_csv(out / "versions.csv")
    rates = {}
    for row in read_csv(out / "machine.csv"):
        rates.setdefault(row["name"], {})[int(row["threads"])] = (row["value"] / 1e9, "G" + row["unit"])
    first = table(["", ""], [[row["what"], row["value"]] for row in versions])
    most = max((max(of) for of in rates.values()), default=1)
    second = table(["rate", "1 thread", f"{most} threads"],
                   [[f"{name}, {of[1][1]}", of[1][0], of.get(most, ("",))[0]] for name, of in rates.items()])
    return first + "\n\n" + second if rates else ""


def t1_table(out):
    rows = sorted((row for row in read_csv(out / "t1.csv") if not row["note"]), key=lambda row: row["r"])
    cells = [[row["row"], row["dofs"], row["steps"], row["contact_steps"], row["rms_percent_of_half_speed"], row["energy_kept"], row["reduction_s"] or "", row["setup_s"],
              row["stepping_s"], row["spread"], row["speedup"],
              row.get("break_even_runs", ""), 100 * row["share_of_limit"], row["peak_memory_bytes"] / 1e6] for row in rows]
    text = table(["row", "dofs a block", "steps", "near contact", "rms %", "energy kept", "reduction s", "setup s", "stepping s", "slowest / fastest run", "x full mesh",
                  "break-even, runs", "% of the limit", "MB"], cells)
    left_out = [f"- {row['row']}: {row['note']}" for row in read_csv(out / "t1.csv") if row["note"]]
    return text + ("\n\n" + "\n".join(left_out) if left_out else "")


def parts_table(out):
    rows = [row for row in read_csv(out / "t1.csv") if not row["note"] and row["enforcement"] == "impulse" and isinstance(row.get("search_s"), float)]
    return table(["row", "stepping, ms", "bodies", "search", "response", "contact", "output", "a step near contact, ms", "of it search", "contact"],
                 [[row["row"], 1e3 * row["stepping_s"], *(1e3 * row[f"{part}_s"] for part in ("bodies", "search", "response", "contact", "output")),
                   *(1e3 * sum(row[f"{part}_s"] for part in parts) / row["contact_steps"] for parts in (("search", "contact"), ("search",), ("contact",)))] for row in rows])


def reduction_table(out):
    rows = [row for row in read_csv(out / "reduction.csv") + read_csv(out / "largest.csv") if not row["note"] and row["seconds"] > 1e-3 * (row["seconds"] / (row["share_of_total"] or 1))]
    return table(["component", "phase", "s", "Gflop/s", "% of the limit"],
                 [[row["row"], row["phase"], row["seconds"], row["flop_rate"] / 1e9 if row["flop_rate"] else "",
                   100 * row["share_of_limit"] if row["share_of_limit"] else ""] for row in rows])


def bases_table(out):
    rows = read_csv(out / "bases.csv")
    cells = [[row["scene"], row["basis"], row["dofs"], row["steps"], row["step_s"], number(row["error_percent"], 2), number(row["error_all_percent"], 2), row["energy"], row["reduction_s"] or "", row["stepping_s"]]
             for row in rows if not row["note"]]
    text = table(["scene", "basis", "dofs", "steps", "step s", "error %", "to the end %", "energy", "reduction s", "stepping s"], cells)
    left_out = [f"- {row['row']}: {row['note']}" for row in rows if row["note"]]
    return text + ("\n\n" + "\n".join(left_out) if left_out else "")


def interior_table(out):
    return table(["bar", "dofs", "of interface", "factorisation, Gflop", "factorisation, s", "with condensation, s", "modes, s", "condensation, s", "total, s", "flops grow", "total grows", "MB"],
                 [[row["row"], row["dofs"], row["interface_dofs"], row["factor_flops"] / 1e9, row["factorisation_s"], row["both_s"], row["modes_s"], row["condensation_s"], row["total_s"],
                   row["grows_flops"], row["grows_total"], row["peak_memory_bytes"] / 1e6] for row in read_csv(out / "interior.csv") if not row["note"]])


def runs_table(out):
    return table(["part", "measured (UTC)", "commit", "runs of each", "processes before"],
                 [[row["part"], row["date"], row["commit"], row["repeats"], row["load"]] for row in read_csv(out / "runs.csv")])


def skipping_table(out):
    rows = [row for row in read_csv(out / "skipping.csv") if not row["note"]]
    return table(["scene", "bodies", "steps computed", "of", "stepping s", "total s", "against", "ratio of totals", "at most", "reached"],
                 [[row["row"], row["bodies"], row["steps"], row["steps_planned"], row["stepping_s"], row["total_s"], row["against"], row["ratio"], row["target"], row["reached"]]
                  for row in rows])


def again_table(out):
    return table(["reduction", "first s", "again s", "ratio", "at most", "reached"],
                 [[row["row"], row["first_s"], row["again_s"], row["ratio"], row["target"], row["reached"]] for row in read_csv(out / "again.csv")])


def features_table(out):
    rows = [row for row in read_csv(out / "features.csv") if row.get("steps_s") not in (None, "")]
    header = ["run", "dofs", "steps", "stepping s", "setup s", "reduction s", "rms %", "rebound",
              "x full mesh", "break-even, runs"]
    return table(header, [[*(row[c] for c in ("run", "dofs", "steps", "steps_s", "setup_s", "reduction_s")),
                           100 * row["rms"] if row["rms"] != "" else "", row["rebound"],
                           row["seconds_ratio"], row["break_even_runs"]] for row in rows])


def ordinary_table(out):
    rows = [row for row in read_csv(out / "ordinary.csv") if row.get("steps_s") not in (None, "")]
    columns = ("dofs", "steps", "steps_s", "setup_s", "reduction_s", "way_percent", "momentum_along",
               "momentum_off_percent", "energy_kept", "seconds_ratio", "break_even_runs")
    header = ["run", "dofs", "steps", "stepping s", "setup s", "reduction s", "way off %",
              "momentum along", "off %", "energy kept", "x full mesh", "break-even, runs"]
    return table(header, [[row["run"], *(row[c] for c in columns)] for row in rows])


def ordinary_targets(out):
    """Rows of the target table: the superelement of few shapes against its full mesh."""
    lines = []
    rows = {row["run"]: row for row in read_csv(out / "ordinary.csv")}
    for name, wanted in (("part-shapes", 40), ("part-shapes-friction", 20)):
        row = rows.get(name)
        if not row or not isinstance(row.get("seconds_ratio"), float):
            continue
        off = row["momentum_off_percent"] if name.endswith("friction") else 0.0
        good = row["seconds_ratio"] >= wanted and row["way_percent"] <= 1 and abs(off) <= 3
        friction = ", friction 0.3" if name.endswith("friction") else ""
        target = (f"ordinary part{friction}: stepping {wanted} times faster, centre of mass within "
                  "1 % of its way, momentum along the floor within 3 %")
        reached = (f"{number(row['seconds_ratio'])} times, {number(row['way_percent'], 2)} %, "
                   f"{number(off, 2)} %")
        lines.append([target, reached, yes_no(good)])
    return lines


def projected_table(out):
    return table(["row", "dofs a block", "rms %", "energy kept", "of the projected full mesh", "difference %"],
                 [[row["row"], row["dofs"], row["rms_percent_of_half_speed"], row["energy_kept"], row["energy_of_projection"], row["difference_percent"]]
                  for row in read_csv(out / "projected.csv")])


def peers_table(out):
    columns = ("case", "program", "setting", "runs", "reduction_s", "seconds", "steps_percent", "megabytes", "error_percent", "second", "note")
    header = ["case", "program", "setting", "runs", "reduction s", "s", "of it steps %", "MB", "error %", "second figure", "remark"]
    rows = [[number(row[column], 4 if column == "second" else 3) for column in columns] for row in read_csv(out / "peers.csv")]
    of = ", ".join(row["peer"] for row in read_csv(out / "peer-versions.csv"))
    return f"Peers: {of}.\n\n{table(header, rows)}" if rows else ""


def best(rows, r):
    """The fastest superelement of the contact face on mesh r with an error below 0.5 %."""
    good = [row for row in rows if row["r"] == r and row["model"] in ("a", "shapes") and not row["note"] and row["enforcement"] == "impulse"
            and row["rms_percent_of_half_speed"] < 0.5]
    return max(good, key=lambda row: row["speedup"], default=None)


def nearest(rows, r):
    """What to say of mesh r when no row is below 0.5 %."""
    run = [row for row in rows if row["r"] == r and row["model"] in ("a", "shapes") and not row["note"] and row["enforcement"] == "impulse"]
    least = min(run, key=lambda row: row["rms_percent_of_half_speed"], default=None)
    return f"none below 0.5 %; least {number(least['rms_percent_of_half_speed'])} % at {number(least['speedup'])} times ({least['row']})" if least else "not measured"


def target_table(out):
    rows, lines = read_csv(out / "t1.csv"), []
    if not rows:
        return ""  # what the page has stays
    for r, wanted in ((1, 30), (2, 100), (4, 300)):
        row = best(rows, r)
        reached = f"{number(row['speedup'])} times, rms {number(row['rms_percent_of_half_speed'])} % ({row['row']})" if row else nearest(rows, r)
        lines.append([f"T1 stepping, r = {r}: {wanted} times faster than the full mesh, rms below 0.5 %", reached, yes_no(row and row["speedup"] >= wanted)])
    row = next((row for row in read_csv(out / "projected.csv") if row["modes"] == 20), None)
    if row:
        good = row["rms_percent"] <= 0.2 and abs(row["difference_percent"]) <= 0.5
        lines.append(["rms 0.2 % on 170 dofs (of the quarter block: 548 of the block), energy that of the projected full mesh to 0.5 %",
                      f"rms {number(row['rms_percent'])} % of 3810 m/s x 4.25 us, energy off by {number(row['difference_percent'], 2)} %", yes_no(good)])
    features = [row for row in read_csv(out / "features.csv") if isinstance(row.get("seconds_ratio"), float) and row["rms"] < 0.01]
    fastest = max(features, key=lambda row: row["seconds_ratio"], default=None)
    lines.append(["part with small features: 100 times faster, rms below 1 % of the full mesh on the same elements", f"{number(fastest['seconds_ratio'])} times, rms {number(100 * fastest['rms'])} % ({fastest['run']})" if fastest
                  else "not measured", yes_no(fastest and fastest["seconds_ratio"] >= 100)])
    lines += ordinary_targets(out)
    for row in read_csv(out / "skipping.csv"):
        if isinstance(row.get("ratio"), float):
            lines.append([f"{row['row']}: at most {number(row['target'])} times {row['against']}", f"{number(row['ratio'])} times", yes_no(row["reached"] == "yes")])
    for row in read_csv(out / "interior.csv"):
        if row["reached"]:
            lines.append([f"interior {number(row['grows_flops'])} times the factorisation's flops, same interface ({row['row']}): no more than that", f"{number(row['grows_total'])} times",
                          yes_no(row["reached"] == "yes")])
    for row in read_csv(out / "again.csv"):
        lines.append([f"cbr-reduce again, {row['row']}: at most a fifth", number(row["ratio"]), yes_no(row["reached"] == "yes")])
    for row in read_csv(out / "reduction.csv"):
        if row["phase"] in ("condensation", "factorisation and condensation") and isinstance(row.get("share_of_limit"), float):
            lines.append([f"{row['phase']}, {row['row']}: over 60 % of dgemm's rate", f"{number(100 * row['share_of_limit'])} %", yes_no(row["share_of_limit"] > 0.6)])
    return table(["target", "reached", ""], lines)


TABLES = {"machine": machine_table, "t1": t1_table, "parts": parts_table, "reduction": reduction_table, "interior": interior_table, "bases": bases_table, "runs": runs_table, "again": again_table, "skipping": skipping_table, "features": features_table,
          "ordinary": ordinary_table, "targets": target_table, "projected": projected_table, "peers": peers_table}


def main():
    out, docs = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    page = docs / "benchmarks.md"
    text = page.read_text()
    for name, make in TABLES.items():
        pattern = re.compile(rf"(<!-- table {name} -->\n).*?(<!-- end -->)", re.S)
        if not pattern.search(text):
            sys.exit(f"document.py: {page.name} has no table {name}")
        new = make(out)
        if new.count("\n") > 1:
            text = pattern.sub(lambda found: found.group(1) + new + "\n" + found.group(2), text)
    page.write_text(text)
    for plot in sorted(out.glob("bench-*.png")):
        shutil.copy(plot, docs / "images" / plot.name)


if __name__ == "__main__":
    main()
