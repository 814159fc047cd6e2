#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""check.py BIN OUT PAGE: each scene prints the lines of its comments `# symptom:`, and PAGE quotes them. With each line replaced
by its comment `# cure:` it prints none of them, and runs to its end."""
import pathlib
import re
import subprocess
import sys


def printed(bin, scene, text):
    """All that the programs print on a scene, and whether both succeed."""
    if "reduction:" in text:  # one superelement for the symptom, one for the cure
        text = text.replace("reduction: {", f"reduction: {{superelement: {scene.stem}.cbr.h5, ")
    scene.write_text(text)
    said, done = "", True
    for call in ("cbr-reduce", scene, "--force"), ("cbr-dyn", scene, "-o", scene.with_suffix(".h5")):
        if call[0] == "cbr-dyn" or "reduction:" in text:
            run = subprocess.run([bin / call[0], "--threads", "1", *call[1:]], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            said, done = said + run.stderr, done and run.returncode == 0
    return said, done


def main():
    bin, out, page = (pathlib.Path(arg).resolve() for arg in sys.argv[1:])
    page, missed = " ".join(page.read_text().split()), []
    for path in sorted(pathlib.Path(__file__).parent.glob("*.yaml")):
        text = path.read_text()
        said, _ = printed(bin, out / path.name, text)
        cured, done = printed(bin, out / f"{path.stem}-cured.yaml", re.sub(r"^( *).*# cure: ", r"\1", text, flags=re.M))
        symptoms = re.findall(r"^# symptom: (.*)", text, re.M)
        missed += [f"{path.name} does not print: {s}\n{said}" for s in symptoms if s not in said]
        missed += [f"{path.name}: docs/trouble.md does not quote: {s}" for s in symptoms if s not in page]
        if not done or not symptoms or any(s in cured for s in symptoms):
            missed.append(f"{path.name} is not cured:\n{cured}")
        print(path.stem)
    print("\n".join(missed) or "each symptom is printed, and gone with its cure")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
