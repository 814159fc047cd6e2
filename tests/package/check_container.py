#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks the Containerfile against the Makefile, packages.txt and the files of this tree, without a container engine.

Both stages start from the Debian that README names. Packages come from scripts/install-packages or are listed in packages.txt.
Targets of make exist. Copied files exist and are not ignored, and the package is copied from where `make deb` puts it. A line per breach,
exit 1.
"""
import fnmatch
import pathlib
import re
import shlex
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
INSTRUCTIONS = {"FROM", "WORKDIR", "COPY", "RUN"}  # no ENTRYPOINT: the programs are called by name


def instructions(text):
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    for line in "\n".join(lines).replace("\\\n", " ").splitlines():
        name, _, rest = line.strip().partition(" ")
        yield name.upper(), rest


def commands(line):
    return [shlex.split(part) for part in re.split(r"&&|;", line)]


def run_breaches(words, packages, makefile):
    if words[0] == "make":
        for target in words[1:]:
            if not re.search(rf"^{re.escape(target)}:", makefile, re.M):
                yield f"make {target}: the Makefile has no such target"
    elif words[0] == "apt-get" and "install" in words:
        for package in words[words.index("install") + 1:]:
            if not package.startswith(("-", "./")) and package not in packages:
                yield f"apt-get install {package}: packages.txt does not list it"
    elif words[0] == "scripts/install-packages":
        if words[1:] != ["packages.txt"]:
            yield f"{' '.join(words)}: expected packages.txt"
    elif words[0] not in {"apt-get", "rm"}:
        yield f"{words[0]}: expected scripts/install-packages, make, apt-get or rm"


def copy_breaches(words, deb, ignored):
    for source in [word for word in words[:-1] if not word.startswith("--")]:
        if words[0].startswith("--from="):
            if source != deb:
                yield f"COPY {source}: `make deb` writes {deb}"
        elif not (ROOT / source).exists():
            yield f"COPY {source}: does not exist"
        elif any(fnmatch.fnmatch(source, pattern) for pattern in ignored):
            yield f"COPY {source}: .dockerignore leaves it out"


def breaches(text, packages, makefile, readme, ignored):
    version = re.search(r"On Debian (\d+)", readme).group(1)
    build = re.search(r"^BUILD\s*\?=\s*(\S+)", makefile, re.M).group(1)
    folder, ran = "", []
    for name, rest in instructions(text):
        if name not in INSTRUCTIONS:
            yield f"{name}: expected {', '.join(sorted(INSTRUCTIONS))}"
        elif name == "FROM" and rest.split()[0] != f"debian:{version}":
            yield f"FROM {rest}: README names Debian {version}"
        elif name == "WORKDIR":
            folder = folder or rest
        elif name == "COPY":
            yield from copy_breaches(rest.split(), f"{folder}/{build}/cbr_*.deb", ignored)
        elif name == "RUN":
            for words in commands(rest):
                ran.append(" ".join(words))
                yield from run_breaches(words, packages, makefile)
    for wanted in ["scripts/install-packages packages.txt", "make deb"]:
        if wanted not in ran:
            yield f"does not run {wanted}"
    if not any(fnmatch.fnmatch(build, pattern) for pattern in ignored):
        yield f".dockerignore: does not leave out {build}, whose CMake cache holds another path"


def self_test(text, *others):
    for old, new in [("debian:12 AS", "debian:11 AS"), ("make deb", "make debs"), (" gmsh ", " gmesh "), ("/cbr/build/", "/cbr/"),
                     ("COPY packages.txt", "COPY package.txt"), ("RUN scripts/install-packages packages.txt", "RUN true"),
                     ("WORKDIR /work", 'ENTRYPOINT ["cbr-dyn"]')]:
        assert old in text and list(breaches(text.replace(old, new), *others)), (old, new)


def main():
    def read(name):
        return (ROOT / name).read_text()

    packages = set(re.sub("#.*", "", read("packages.txt")).split())
    others = packages, read("Makefile"), read("README.md"), read(".dockerignore").split()
    found = list(breaches(read("Containerfile"), *others))
    if not found:
        self_test(read("Containerfile"), *others)
    for breach in found:
        print(f"Containerfile: {breach}", file=sys.stderr)
    print(f"container check: {len(found)} breaches", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
