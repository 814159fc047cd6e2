# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the HDF5 library can read a file: damage may crash it, or make it search without end. As in
common/files/hdf5_string_heap.cpp."""
from __future__ import annotations

import contextlib
import functools
import os
import struct
import sys

import h5py

_WHOLE, _WINDOW, _OVERLAP, _LONGEST = 1 << 26, 1 << 24, 1 << 16, 1 << 20
_HEAP = b"GCOL\x01"  # of a collection of strings, and its version


def _sizes(data: bytes, at: int) -> dict[int, int]:
    """Of the strings of a collection, by their index. Empty: it has another layout."""
    if at + 16 > len(data) or data[at + 5:at + 8] != bytes(3):
        return {}
    sizes: dict[int, int] = {}
    end, at = at + int.from_bytes(data[at + 8:at + 16], "little"), at + 16
    while at + 16 <= min(end, len(data)):
        index, size = struct.unpack_from("<H6xQ", data, at)
        if index == 0:
            return sizes if size == end - at else {}
        if size > end - at - 16 or index in sizes:
            return {}
        sizes[index] = size
        at += 16 + (size + 7) // 8 * 8
    return sizes if end <= len(data) else {}


def _heaps_are_sound(windows: list[tuple[int, bytes]]) -> bool:
    """Whether each string of one value in a window, (its place in the file, its bytes), has the length that it has in the
    collection to which it points: the library copies without a look."""
    for begin, data in windows:
        at = data.find(_HEAP)
        while at >= 0:
            sizes, address = _sizes(data, at), (begin + at).to_bytes(8, "little")
            for _, other in windows:
                found = other.find(address)
                while found >= 0:
                    is_one = found >= 8 and (other[found - 8:found - 4] == b"\2\0\0\0" or other[found - 12:found - 4] == b"\1" + bytes(7))
                    if is_one and found + 12 <= len(other):
                        length, index = struct.unpack_from("<I8xI", other, found - 4)
                        if 0 < length <= _LONGEST and sizes.get(index) != length:
                            return False
                    found = other.find(address, found + 1)
            at = data.find(_HEAP, at + 1)
    return True


def _visit(item: h5py.Group | h5py.Dataset) -> None:
    """As readers do, and on after what cannot be read: they may not come to it."""
    with contextlib.suppress(Exception):
        dict(item.attrs)
    names: list[str] = []
    with contextlib.suppress(Exception):
        names += item if isinstance(item, h5py.Group) else []
    for name in names:
        with contextlib.suppress(Exception):
            _visit(item[name])


def _survives(path: str, size: int) -> bool:
    """Whether a process of its own reads all names and attributes, in the time that the size allows."""
    if sys.platform != "linux":
        return True
    import resource

    with h5py._objects.phil:  # the library's lock: no other thread holds it in the child
        child = os.fork()
        if child == 0:
            try:
                resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
                resource.setrlimit(resource.RLIMIT_CPU, (10 + size // 1000000, 11 + size // 1000000))
                os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
                with h5py.File(path, "r") as f:
                    _visit(f)
            finally:  # the parent comes to the same exception
                os._exit(0)
    try:
        return os.WIFEXITED(os.waitpid(child, 0)[1])
    except ChildProcessError:  # the program ignores how children end
        return True


@functools.lru_cache(maxsize=1000)
def _is_sound(path: str, size: int, changed: int) -> bool:
    with open(path, "rb") as file:
        windows = [(0, file.read(size if size <= _WHOLE else _WINDOW))]
        if size > _WHOLE:
            file.seek(size - _WINDOW - _OVERLAP)
            windows.append((size - _WINDOW - _OVERLAP, file.read()))
    return _heaps_are_sound(windows) and _survives(path, size)


def is_sound(path: str) -> bool:
    """Whether a file can be read without a crash; once for each state of the file. OSError: it cannot be opened."""
    state = os.stat(path)
    return _is_sound(os.path.abspath(path), state.st_size, state.st_mtime_ns)
