# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of a case beside their bounds."""


class Checks:
    """Prints each figure, and counts those above their bounds."""

    missed = counted = 0

    def below(self, *row):
        """row: names of the run and the figure, the figure, and its bound. A figure that is not a number misses."""
        *names, value, bound = row
        words = " ".join(f"{name:{width}s}" for name, width in zip(names, (30, 60) if len(names) > 1 else (70,)))
        self.condition(f"{words} {value:12.4g}  bound {bound:9.3g}", value <= bound)

    def near(self, run, what, value, wanted, tolerance):
        self.condition(f"{run:14s} {what:22s} {value:14.6g}  wanted {wanted:10.6g} +- {tolerance:.2g}", abs(value - wanted) <= tolerance)

    def condition(self, words, held):
        """Any other condition; the words stand before `held` or `MISSED`."""
        self.counted += 1
        self.missed += not held
        print(f"{words}  {'held' if held else 'MISSED'}")

    def exit_code(self):
        """1 if a figure missed, or if there is none."""
        print(f"{self.counted - self.missed} of {self.counted} held")
        return 1 if self.missed or not self.counted else 0


def report(rows):
    """Exit code of a list of rows (name, figure, bound)."""
    checks = Checks()
    for row in rows:
        checks.below(*row)
    return checks.exit_code()
