#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether two result files have the same datasets, byte for byte. Attributes hold wall times and are left out."""
import sys

import h5py


def datasets(path):
    found = {}
    with h5py.File(path) as f:
        f.visititems(lambda name, item: found.update({name: (item.dtype, item.shape, item[()].tobytes())}) if isinstance(item, h5py.Dataset) else None)
    return found


def main():
    a, b = datasets(sys.argv[1]), datasets(sys.argv[2])
    differing = sorted(name for name in a.keys() | b.keys() if a.get(name) != b.get(name))
    print(f"{len(a)} datasets, {len(differing)} differ: {' '.join(differing)}")
    return 1 if differing or not a else 0


if __name__ == "__main__":
    sys.exit(main())
