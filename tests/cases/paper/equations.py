# SPDX-License-Identifier: GPL-3.0-or-later
"""Eqs 5-17 of the paper for Table 4's cube, counted on a real decomposition: equations.py BIN OUT N

Writes OUT/eqs.md: what `cbr-reduce --estimate` says for N^3 hexes cut no, one and three times in each direction. Exit 1 when the counts do not
bear the formulas out.
"""
import pathlib
import subprocess
import sys

sys.path.append("..")
from checks import Checks

HERE = pathlib.Path(__file__).parent


def estimate(bin_folder, mesh, domains):
    """Rows of the first table: (equation, quantity, counted, formula, as printed)."""
    command = [bin_folder / "cbr-reduce", mesh, "--interface", "surface", "--modes", "50", "--domains", str(domains), "--estimate"]
    text = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    rows = []
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if len(cells) == 5 and cells[0].isdigit():
            rows.append(cells)
    return rows


def check(checks, rows, domains):
    number = {(row[0], i): tuple(float(cell) for cell in row[2:]) for i, row in enumerate(rows) if row[0] != "5"}
    by_equation = {}
    for (equation, _), values in number.items():
        by_equation.setdefault(equation, []).append(values)
    for equation in ("6", "7", "8", "9"):
        counted, formula, _ = by_equation[equation][0]
        # METIS need not cut a cube into cubes: then the largest domain has a larger surface.
        exact = domains == 1 or equation in ("6", "7")
        checks.condition(f"{domains} domains, Eq {equation}", counted == formula if exact else 0.8 * formula < counted < 1.6 * formula)
    dofs = by_equation["7"][1]
    checks.condition(f"{domains} domains, Eq 7 as printed counts nodes: three dofs each", dofs[1] == 3 * dofs[2])
    for equation in ("13", "14"):
        counted, formula, printed = by_equation[equation][0]
        # 324, the square of Eq 11's 18, and not 36
        checks.condition(f"{domains} domains, Eq {equation}, 9 times what is printed", abs(formula / printed - 9) < 0.01)
        checks.condition(f"{domains} domains, Eq {equation} right within a factor of 2.5, as printed too few by one of 3 or more",
                         formula / 2.5 < counted < formula * 2.5 and counted > 3 * printed)
    for equation in ("15", "16", "17"):
        counted, bound, _ = by_equation[equation][0]
        checks.condition(f"{domains} domains, Eq {equation} is a bound", counted < bound)


def main():
    bin_folder, out, n = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), int(sys.argv[3])
    mesh = out / f"cube-{n}.msh"
    sides = [word for d in "xyz" for word in ("-setnumber", "n" + d, str(n), "-setnumber", "l" + d, "0.0191")]
    subprocess.run(["gmsh", "-3", "-v", "2", HERE / "../../../meshes/block.geo", *sides, "-o", mesh], check=True, stdout=subprocess.DEVNULL)
    checks, lines = Checks(), []
    for cuts in (0, 1, 3):
        domains = (cuts + 1) ** 3
        rows = estimate(bin_folder, mesh, domains)
        check(checks, rows, domains)
        lines += [f"{n} x {n} x {n} hexes, cut {cuts} times in each direction ({domains} domains), the whole surface kept:", "",
                  "| Eq | quantity | counted | formula | as printed |", "|---|---|---|---|---|"]
        lines += ["| " + " | ".join(row) + " |" for row in rows] + [""]
    (out / "eqs.md").write_text("\n".join(lines))
    return checks.exit_code()


if __name__ == "__main__":
    sys.exit(main())
