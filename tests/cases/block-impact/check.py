#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the paper's block impact must show, checked on the results in a folder. Exit 1 and a line per figure that is missed."""
import pathlib
import sys

from plot import CONVERGED, SPEED, load

COMMON = SPEED / 2  # both blocks after a perfectly plastic impact


def main():
    folder = pathlib.Path(sys.argv[1])
    missed = []

    def expect(run, what, value, wanted, tolerance):
        held = abs(value - wanted) <= tolerance
        print(f"{run:14s} {what:22s} {value:14.6g}  wanted {wanted:10.6g} +- {tolerance:.2g}  {'held' if held else 'MISSED'}")
        if not held:
            missed.append((run, what))

    # The impulse on superelements of any interface, and on the full mesh: the converged answer within 0.5 % of the speed.
    for name in ("a-impulse", "b-impulse", "c-impulse", "shapes-impulse", "full-impulse", "a100-impulse", "a500-impulse"):
        run = load(folder / f"{name}.h5")
        expect(name, "left, m/s", run["v"]["left"][-1], CONVERGED[0], 0.005 * SPEED)
        expect(name, "right, m/s", run["v"]["right"][-1], CONVERGED[1], 0.005 * SPEED)
    # The paper's finding: with node-lumped contact the contact face alone sticks, whatever the number of modes.
    for name in ("a5-nodal", "a-nodal", "a100-nodal", "a500-nodal"):
        run = load(folder / f"{name}.h5")
        expect(name, "left, m/s", run["v"]["left"][-1], COMMON, 1e-3 * SPEED)
        expect(name, "right, m/s", run["v"]["right"][-1], COMMON, 1e-3 * SPEED)
    # ... and with more interface elsewhere the rebound returns in part, more of it for (c) than for (b).
    lefts = [load(folder / f"{name}.h5")["v"]["left"][-1] for name in ("a-nodal", "b-nodal", "c-nodal", "full-nodal")]
    ordered = all(more > less + 0.05 * SPEED for more, less in zip(lefts, lefts[1:]))
    expect("nodal", "a > b > c > full", float(ordered), 1, 0)
    # Half and quarter models
    whole = load(folder / "symmetry/full-mesh.h5")["v"]
    for part in ("full", "half", "quarter"):
        for kind, tolerance in (("mesh", 1e-11), ("superelement", 0.005)):
            run = load(folder / f"symmetry/{part}-{kind}.h5")["v"]
            for block in ("left", "right"):
                expect(f"{part}-{kind}", f"{block}, m/s", run[block][-1], whole[block][-1], tolerance * SPEED)
    for path in sorted(folder.glob("*.h5")):
        if not path.name.endswith(".cbr.h5"):
            run = load(path)
            expect(path.stem, "momentum drift", run["drift"], 0, 1e-10)
            expect(path.stem, "energy, end / start", run["energy"], 0.75, 0.26)  # nothing below a plastic impact, nothing gained
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
