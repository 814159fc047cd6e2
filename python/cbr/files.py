# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that this package writes: whole or not at all, and over nothing but its own."""
from __future__ import annotations

import os
import pathlib
import tempfile
from collections.abc import Callable


class Refused(OSError):
    """A file that is there is not of the kind that would replace it."""


def require_replaceable(path: pathlib.Path, noun: str, is_ours: Callable[[bytes], bool]) -> pathlib.Path:
    """The file to replace. Refused: it exists, is not empty and `is_ours` says of its bytes that it is no
    `noun` of this package; or `path` is a link into another folder."""
    target = path.resolve()
    if path.is_symlink() and target.parent != path.absolute().parent.resolve():
        raise Refused(f"{path}: is a link to {target}, a file of another folder: give that name, or remove the link")
    if target.exists() and not target.is_file():
        raise Refused(f"{path}: is not a regular file: give the name of a file to write")
    if target.exists() and target.stat().st_size > 0 and not is_ours(target.read_bytes()):
        raise Refused(f"{path}: exists and is not {noun} that cbr wrote, and would be overwritten: give another name")
    if target.exists() and not os.access(target, os.W_OK):
        raise Refused(f"{path}: is write-protected: make it writable (chmod u+w) or give another name")
    return target


def replace_text(path: str | os.PathLike[str], text: str, noun: str, is_ours: Callable[[bytes], bool]) -> None:
    """Writes under a temporary name, then renames. Refused: as require_replaceable."""
    target = require_replaceable(pathlib.Path(path), noun, is_ours)
    if target.exists():
        mode = target.stat().st_mode & 0o777
    else:
        mask = os.umask(0)
        os.umask(mask)
        mode = 0o666 & ~mask
    with tempfile.NamedTemporaryFile("w", encoding="utf-8", dir=target.parent, prefix=".cbr-", suffix=".tmp", delete=False) as file:
        try:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
            os.chmod(file.name, mode)
            os.replace(file.name, target)
        except BaseException:
            os.unlink(file.name)
            raise
