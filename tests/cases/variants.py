# SPDX-License-Identifier: GPL-3.0-or-later
"""Other scenes from the scene of a case: its text with some of it replaced. A case's scene.py says by what."""
import pathlib
import re
import sys


def print_variant(usage, changes, keeps_comments=True):
    """Main function of a scene.py: `scene.py SCENE.yaml NAME` prints the scene with the changes of NAME.

    changes(NAME): pairs (text of the scene, its replacement), made in turn; None if there is no such name.
    """
    if len(sys.argv) != 3 or sys.argv[1].startswith("-"):
        sys.exit(usage)
    path, name = sys.argv[1:]
    pairs, text = changes(name), pathlib.Path(path).read_text()
    if pairs is None:
        sys.exit(f"scene.py: {name}: see --help")
    for old, new in pairs:
        if old not in text:
            sys.exit(f"scene.py: {path} has no '{old.strip()}'")
        text = text.replace(old, new)
    print(text if keeps_comments else re.sub(r"  +#.*", "", text), end="")
