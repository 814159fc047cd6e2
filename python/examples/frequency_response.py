#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The response of superelements to a harmonic force at a corner of the face, as a figure.

    frequency_response.py A.cbr.h5 [B.cbr.h5 ...] -o response.png
"""
import argparse
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import cbr


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("superelements", nargs="+")
    parser.add_argument("-o", "--output", required=True)
    given = parser.parse_args()
    fig, axis = plt.subplots(figsize=(7, 4), layout="constrained")
    for path in given.superelements:
        part = cbr.superelement(path)
        elastic = part.frequencies()[part.frequencies() > 0]
        hz = np.linspace(0.2 * elastic[0], 1.5 * elastic[min(9, len(elastic) - 1)], 2000)
        corner = part.dof(int(part.node_id[np.argmax(part.coordinates.sum(axis=1))]), "x")
        axis.semilogy(hz, np.abs(part.response(hz, corner, corner, ratio=0.01)), label=pathlib.Path(path).name)
    axis.set_xlabel("frequency [Hz]")
    axis.set_ylabel("displacement per force")
    axis.legend(frameon=False)
    fig.savefig(given.output, dpi=120)


if __name__ == "__main__":
    main()
