# SPDX-License-Identifier: GPL-3.0-or-later
"""The contents page of the reproduced figures: contents.py OUT FIGURE ... Exit 1 when one is not there."""
import os
import pathlib
import sys

FIGURES = (
    ("fig3", "Fig 3: approach, contact and separation of two equal blocks"),
    ("fig5", "Fig 5: the choice of interface (Table 1)"),
    ("fig6", "Fig 6: the number of fixed-interface modes (Table 1)"),
    ("fig8", "Fig 8: sphere and brick against a dense block (Table 2)"),
    ("fig9", "Fig 9: explicit runs under a sharp load against the mesh's own solution (Table 3)"),
    ("fig10", "Fig 10: implicit runs of superelements and of the mesh (Table 3)"),
    ("fig11", "Fig 11: time steps and hex formulations (Table 3)"),
    ("fig12", "Fig 12: time over the number of domains (Table 4)"),
    ("eqs", "Eqs 5 to 17: sizes of a decomposed cube"),
    ("eq18", "Eq 18: the bar of two nodes under an accelerated interface"),
)


def main():
    out = pathlib.Path(sys.argv[1])
    small = " on small meshes (FAST=1)" if os.environ.get("FAST") else ""
    lines = [f"# The paper's figures and tables, reproduced{small}", "", "What the paper says, and why ours are as they are: docs/reproducing-the-paper.md.", ""]
    body, missing = [], 0
    figures = [figure for figure in FIGURES if figure[0] in sys.argv[2:]]
    for name, title in figures:
        files = [out / f"{name}{ending}" for ending in (".png", ".md", ".txt") if (out / f"{name}{ending}").exists()]
        missing += not files
        lines.append(f"- [{title}](#{name}): `make {name}`" + ("" if files else " - not run"))
        body += ["", f'<a id="{name}"></a>', f"## {title}", ""]
        for file in files:
            if file.suffix == ".png":
                body.append(f"![{title}]({file.name})")
            elif file.suffix == ".md":
                body += ["", file.read_text().strip()]
            else:
                body += ["", "```", file.read_text().rstrip(), "```"]
    (out / "contents.md").write_text("\n".join(lines + body) + "\n")
    print(f"{out}/contents.md: {len(figures) - missing} of {len(figures)}")
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
