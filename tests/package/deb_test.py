#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Debian package that cpack makes of a build, unpacked: deb_test.py BUILD SOURCE VERSION CMAKE CPACK."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

BUILD, SOURCE, VERSION, CMAKE, CPACK = sys.argv[1:6]
PROGRAMS = ["cbr-reduce", "cbr-skin", "cbr-dyn"]


def output(*command: object, **options) -> str:
    done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)
    if done.returncode != 0:
        raise AssertionError(f"{command} exited with {done.returncode}:\n{done.stdout}")
    return done.stdout


def names(relations: str) -> set[str]:
    """Packages of a field such as 'a (>= 1), b | c'."""
    return set(re.findall(r"(?:^|[,|])\s*([a-z0-9.+-]+)", relations))


def files(folder: pathlib.Path) -> set[str]:
    return {p.relative_to(folder).as_posix() for p in folder.rglob("*") if not p.is_dir()}


def shared_libraries(program: pathlib.Path) -> dict[str, str]:
    """Shared libraries that a program names -> the file of each."""
    needed = re.findall(r"\(NEEDED\).*\[(.*)\]", output("readelf", "-d", program))
    loaded = dict(re.findall(r"(\S+) => (\S+)", output("ldd", program)))
    return {library: os.path.realpath(loaded[library]) for library in needed if library in loaded}  # all but the loader itself


def providers(files: set[str]) -> dict[str, str]:
    """Files -> the installed package of each. One search, as each reads the lists of all packages."""
    # Files of packages older than the merge of /lib and /usr/lib are listed in /lib
    names = {known: file for file in files for known in (file, file.removeprefix("/usr"))}
    # Its exit code tells of names that are not found
    search = subprocess.run(["dpkg", "-S", *names], capture_output=True, text=True)
    found = (line.split(": ") for line in search.stdout.splitlines() if ": " in line and not line.startswith("diversion by"))
    return {names[path]: package.split(":")[0] for package, path in found if path in names}


class Deb(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        output(CPACK, "--config", f"{BUILD}/CPackConfig.cmake", "-B", cls.folder / "out")
        cls.deb, = (cls.folder / "out").glob("*.deb")
        cls.root = cls.folder / "root"
        output("dpkg-deb", "-x", cls.deb, cls.root)
        cls.bin = cls.root / "usr/bin"
        cls.environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"} | {"PYTHONDONTWRITEBYTECODE": "1"}

    def field(self, name: str) -> str:
        return output("dpkg-deb", "-f", self.deb, name).strip()

    def test_programs_run(self) -> None:
        for name in PROGRAMS:
            self.assertEqual(output(self.bin / name, "--version").split(), [name, VERSION])
            self.assertIn(f"Usage: {name}", output(self.bin / name, "--help"))

    def test_programs_are_stripped_and_have_no_path_of_libraries(self) -> None:
        for name in PROGRAMS:
            self.assertNotRegex(output("readelf", "-d", self.bin / name), "RPATH|RUNPATH")
            self.assertNotIn(".symtab", output("readelf", "-SW", self.bin / name))

    def test_python_package(self) -> None:
        self.assertIn("usage: cbr-report", output(self.bin / "cbr-report", "--help", env=self.environment, cwd=self.folder))
        module, = self.root.glob("usr/lib/python3*/dist-packages/cbr")
        folder = module.parent
        # Debian's Python finds the folder once the package is installed
        self.assertIn("/" + folder.relative_to(self.root).as_posix(), output("/usr/bin/python3", "-c", "import site; print(site.getsitepackages())"))
        where = output("/usr/bin/python3", "-c", "import cbr; print(cbr.__file__)", env=self.environment | {"PYTHONPATH": str(folder)}, cwd=self.folder)
        self.assertEqual(where.strip(), str(module / "__init__.py"))

    def test_holds_what_make_install_installs(self) -> None:
        output(CMAKE, "--install", BUILD, "--prefix", self.folder / "install")
        self.assertEqual(files(self.root / "usr"), files(self.folder / "install"))
        self.assertEqual([p.name for p in self.root.iterdir()], ["usr"])
        for name in ["share/man/man1/cbr-dyn.1", "share/bash-completion/completions/cbr-dyn", "share/zsh/vendor-completions/_cbr", "share/doc/cbr/copyright",
                     "include/cbr/common/superelement/superelement.hpp"]:
            self.assertTrue((self.root / "usr" / name).exists(), name)
        self.assertEqual(len(list(self.root.glob("usr/lib/**/cmake/cbr/cbrConfig.cmake"))), 1)

    def test_depends(self) -> None:
        self.assertEqual([self.field("Package"), self.field("Version")], ["cbr", VERSION])
        depends = self.field("Depends")
        libraries = {name: shared_libraries(self.bin / name) for name in PROGRAMS}
        packages = providers({file for of in libraries.values() for file in of.values()})
        for name in PROGRAMS:
            self.assertIn("libc.so.6", libraries[name])
            for library, file in libraries[name].items():
                if file not in packages:
                    continue
                package = packages[file]
                # libopenblas0 stands for libopenblas0-pthread and its like
                self.assertTrue(any(package == d or package.startswith(d + "-") for d in names(depends)), f"{name} needs {library} of {package}: {depends}")
        for package in ["python3", "python3-numpy", "python3-h5py", "python3-matplotlib"]:
            self.assertIn(package, names(depends))
        self.assertEqual([d for d in names(depends) if d.endswith("-dev")], [])
        # The packages are installed here, as the build needs them: each relation is one that dpkg understands and finds fulfilled
        output("dpkg-checkbuilddeps", "-d", depends, "/dev/null")
        self.assertIn("libeigen3-dev", names(self.field("Suggests")))

    def test_owner_and_modes(self) -> None:
        for line in output("dpkg-deb", "-c", self.deb).splitlines():
            mode, owner = line.split()[:2]
            self.assertEqual(owner, "root/root", line)
            self.assertIn(mode, ["drwxr-xr-x", "-rw-r--r--", "-rwxr-xr-x"], line)

    def test_no_path_of_this_machine(self) -> None:
        output("dpkg-deb", "-e", self.deb, self.root / "DEBIAN")
        self.addCleanup(shutil.rmtree, self.root / "DEBIAN")
        folders = "|".join(re.escape(os.path.realpath(f)) for f in (BUILD, SOURCE, self.folder))
        # Not a part of a longer path: /cbr of include/cbr
        path = re.compile(rf"(?<![\w./}}-])(?:{folders})(?![\w.-])".encode())
        self.assertTrue(path.search(f"-I{BUILD}/x".replace("-I", "-I ").encode()))
        for file in self.root.rglob("*"):
            if file.is_file():
                found = path.search(file.read_bytes())
                self.assertIsNone(found, f"{file.relative_to(self.root)} holds {found and found.group().decode()}")


if __name__ == "__main__":
    if not all(map(shutil.which, ["dpkg-deb", "dpkg-shlibdeps", "file"])):
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
