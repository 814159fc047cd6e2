#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The package `cbr` on superelements and results that the programs write: package_test.py BIN SOURCE [TEST...]."""
import base64
import contextlib
import doctest
import html
import html.parser
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
import warnings

import numpy as np

BIN, SOURCE = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
sys.path.insert(0, str(SOURCE / "python"))
sys.dont_write_bytecode = True

import cbr  # noqa: E402
import cbr.report  # noqa: E402

BASES = {"craig-bampton": {"modes": 200}, "characteristic": {"modes": 30}, "massless": {"modes": 30}}


def block(basis: str, end: float = 4e-5) -> cbr.Scene:
    reduction = {"basis": basis, "interface": ["contact"], "superelement": f"{basis}.cbr.h5", **BASES[basis]}
    return cbr.scene(
        materials={"steel": {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3, "density": 7850}},
        components={"block": {"mesh": "block.msh", "material": "steel", "reduction": reduction}},
        instances={"left": {"component": "block", "position": [-0.0254005, 0, 0], "velocity": [1, 0, 0]},
                   "right": {"component": "block", "position": [0.0254005, 0, 0], "mirror": "x"}},
        contact=[{"between": ["left.contact", "right.contact"]}],
        time={"end": end}, output={"every": 1e-6, "history": ["left.contact", "right.contact"]})


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.held = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.held.name)
        numbers = [x for name, n in (("nx", 6), ("ny", 3), ("nz", 4)) for x in ("-setnumber", name, str(n))]
        subprocess.run(["gmsh", "-3", "-v", "1", str(SOURCE / "meshes/block.geo"), *numbers, "-o",
                        str(cls.folder / "block.msh")], check=True)
        cls.runs = {basis: block(basis).run(cls.folder / f"{basis}.yaml", bin=BIN) for basis in BASES}
        cls.parts = {basis: cbr.superelement(cls.folder / f"{basis}.cbr.h5") for basis in BASES}

    @classmethod
    def tearDownClass(cls) -> None:
        cls.held.cleanup()

    def test_matrices_have_rigid_motions_and_mass(self) -> None:
        part = self.parts["craig-bampton"]
        n, k = len(part.K), part.n_modes
        self.assertEqual(n, k + len(part.node))
        along_x = np.zeros(n)
        along_x[k:] = part.component == 0
        self.assertLess(np.abs(part.K @ along_x).max(), 1e-9 * np.abs(part.K).max())
        self.assertAlmostEqual(along_x @ part.M @ along_x / part.mass, 1, places=9)

    def test_frequencies_are_those_that_the_reduction_tells(self) -> None:
        for basis, part in self.parts.items():
            elastic = part.frequencies()[6:]
            self.assertTrue((part.frequencies()[:6] == 0).all(), basis)
            told = part.accuracy["frequency_hz"]
            m = min(len(told), 3)
            np.testing.assert_allclose(elastic[:m], told[:m], rtol=1e-6, err_msg=basis)

    def test_response_is_that_of_the_matrices(self) -> None:
        part = self.parts["craig-bampton"]
        out, at = part.dof(int(part.node_id[0]), "x"), part.dof(int(part.node_id[-1]), 2)
        hz = np.array([700.0, 31000.0])
        for f, found in zip(hz, part.response(hz, out, at)):
            force = np.zeros(len(part.K))
            force[part.n_modes + at] = 1
            dense = np.linalg.solve(part.K - (2 * np.pi * f)**2 * part.M, force)[part.n_modes + out]
            self.assertLess(abs(found - dense), 1e-7 * abs(dense))

    def test_bases_respond_alike(self) -> None:
        """Far below the modes that are left out; normal to the face, of which all bases keep the statics."""
        part = self.parts["craig-bampton"]
        dof = part.dof(int(part.node_id[0]), "x")
        of_all = part.response([10e3], dof, dof)[0]
        for basis in ("characteristic", "massless"):
            other = self.parts[basis]
            same = other.dof(int(part.node_id[0]), "x")
            self.assertLess(abs(other.response([10e3], same, same)[0] / of_all - 1), 0.02, basis)

    def test_shapes_and_dofs(self) -> None:
        part = self.parts["craig-bampton"]
        u = np.arange(len(part.node), dtype=float)
        self.assertTrue((part.shape(u)[part.node, part.component] == u).all())
        with self.assertRaisesRegex(KeyError, "node 999999 has no dof x"):
            part.dof(999999, "x")
        for wrong in ("q", 6, -1):
            with self.assertRaisesRegex(ValueError, "x, y, z, rx, ry, rz"):
                part.dof(int(part.node_id[0]), wrong)
        self.assertEqual(part.faces["contact"].kind, "quad4")
        self.assertEqual(part.faces["contact"].nodes.shape, (12, 4))

    def test_results_by_name(self) -> None:
        run = self.runs["characteristic"]
        self.assertEqual(run.instances, ["left", "right"])
        self.assertEqual(run.pairs, ["left.contact - right.contact"])
        self.assertEqual(run.surfaces, ["left.contact", "right.contact"])
        momentum = run["instances/left/momentum"] + run["instances/right/momentum"]
        self.assertEqual(momentum.shape, (len(run.time), 3))
        self.assertLess(np.abs(momentum - momentum[0]).max(), 1e-12 * np.abs(momentum).max())
        self.assertGreater(run["instances/right/momentum"][-1, 0], 0.5 * momentum[0, 0])
        self.assertIn("steps", run.seconds)
        covered = self.parts["characteristic"].accuracy["covered_hz"]
        self.assertGreater(covered, 1e4)
        self.assertEqual(run.covered_hz, {"left": covered, "right": covered})
        self.assertIn(f"Frequencies of left are right to 1 % up to {covered:.4g} Hz", cbr.report.histories(cbr.report.Runs(run, None)))
        with self.assertRaisesRegex(KeyError, "no dataset 'momentum'; there are: "):
            run["momentum"]

    def test_refusals(self) -> None:
        wrong = block("characteristic")
        wrong["time"] = {"end": 1e-3, "stepp": 1}
        with self.assertRaisesRegex(cbr.Failed, "unknown key 'stepp', did you mean 'step'") as caught:
            wrong.run(self.folder / "wrong.yaml", bin=BIN)
        self.assertEqual(caught.exception.returncode, 2)
        with self.assertRaisesRegex(FileNotFoundError, "set CBR_BIN"):
            block("characteristic").run(self.folder / "x.yaml", bin=self.folder)
        with self.assertRaisesRegex(cbr.FileError, "is cbr-superelement, expected cbr-results"):
            cbr.results(self.folder / "massless.cbr.h5")
        with self.assertRaisesRegex(cbr.FileError, "block.msh: is not an HDF5 file"):
            cbr.superelement(self.folder / "block.msh")
        with self.assertRaisesRegex(cbr.FileError, "none.h5: no such file"):
            cbr.superelement(self.folder / "none.h5")

    def test_numbers_and_paths_of_any_kind(self) -> None:
        """Arrays, numpy's numbers and paths in a scene; names and folders in other alphabets."""
        folder = self.folder / "Prüfung 部品"
        folder.mkdir()
        shutil.copy(self.folder / "block.msh", folder / "Körper.msh")
        made, plain = block("massless"), self.runs["massless"]
        made["components"]["block"]["mesh"] = pathlib.Path("Körper.msh")
        made["instances"]["left"] |= {"position": np.array([-0.0254005, 0, 0]), "velocity": np.array([1, 0, 0])}
        made["time"] = {"end": np.float64(4e-5)}
        made["components"]["block"]["reduction"]["modes"] = np.int64(30)
        run = made.run(folder / "Stoß 🜨.yaml", bin=BIN)
        np.testing.assert_array_equal(run["energy/total"], plain["energy/total"])
        made["instances"] = {"左": made["instances"]["left"], "жук": made["instances"]["right"]}
        made["contact"] = [{"between": ["左.contact", "жук.contact"]}]
        made["output"] = {"every": 1e-6}
        run = made.run(folder / "Stoß 🜨.yaml", bin=BIN)
        self.assertEqual(set(run.instances), {"左", "жук"})
        made.write(folder / "Stoß.yaml")
        self.assertIn("Körper.msh", (folder / "Stoß.yaml").read_text(encoding="utf-8"))
        made["time"]["end"] = {1e-5}
        with self.assertRaisesRegex(TypeError, "a scene has dictionaries, lists, numbers.*, not a set"):
            made.write(folder / "Stoß.yaml")

    def test_errors_have_the_lines_of_program_and_scene_and_the_signal(self) -> None:
        wrong = block("characteristic")
        wrong["time"]["end"] = -1
        with self.assertRaisesRegex(cbr.Failed, r"cbr-reduce: error: <stdin>:\d+: time.end: .*; line \d+: \"end\": -1$") as caught:
            wrong.run(self.folder / "wrong.yaml", bin=BIN)
        self.assertTrue(str(caught.exception).startswith(caught.exception.line))
        dying = self.folder / "dying"
        dying.mkdir()
        (dying / "cbr-reduce").symlink_to(BIN / "cbr-reduce")
        for name in ("SEGV", "KILL"):
            (dying / "cbr-dyn").write_text(f"#!/bin/sh\ncase $* in *-2.h5*) kill -{name} $$;; esac\nexec '{BIN}/cbr-dyn' \"$@\"\n")
            (dying / "cbr-dyn").chmod(0o755)
            with self.assertRaisesRegex(cbr.Failed, f"^cbr-dyn: ended by SIG{name}") as died:
                block("characteristic").run(self.folder / "died-2.yaml", bin=dying)
            self.assertLess(died.exception.returncode, 0)
        made = cbr.study(block("characteristic"), "time.end", [1e-5, 2e-5, 3e-5], self.folder / "died.h5", bin=dying, progress=False)
        self.assertEqual(made.failures, {1: "cbr-dyn: ended by SIGKILL"})
        self.assertIsNone(made.runs[1])
        self.assertEqual(list(np.isnan(made.columns["energy"])), [False, True, False])
        self.assertRegex(str(made), r"2e-05 +nan +nan +cbr-dyn: ended by SIGKILL\n3e-05 +0\.")

    def test_study(self) -> None:
        """Ten angles on one reduction: each row is that of a run of its own."""
        made, angles = block("characteristic", 1e-5), np.zeros((10, 3))
        angles[:, 2] = np.linspace(0, 2, 10)
        before = (self.folder / "characteristic.cbr.h5").read_bytes()
        with contextlib.redirect_stderr(io.StringIO()) as bar:
            table = cbr.study(made, "instances.left.rotation", angles, self.folder / "angle.h5", bin=BIN)
        self.assertEqual((self.folder / "characteristic.cbr.h5").read_bytes(), before)
        self.assertIn("[###                           ] 1 of 10 runs, ", bar.getvalue())
        self.assertIn(f"[{'#' * 30}] 10 of 10 runs\n", bar.getvalue())
        made["instances"]["left"]["rotation"] = angles[7]
        run = made.run(self.folder / "one.yaml", bin=BIN)
        np.testing.assert_array_equal(table.runs[7]["energy/total"], run["energy/total"])  # type: ignore[index]
        force = table.columns["force of left.contact - right.contact"]
        self.assertEqual(force[7], np.linalg.norm(run["contact/left.contact - right.contact/force"], axis=1).max())
        self.assertEqual(len(str(table).splitlines()), 11)
        self.assertNotIn("rotation", block("characteristic")["instances"]["left"])
        speed = cbr.study(made, "output.history.1", ["right.contact"], self.folder / "n.h5", {"n": lambda run: len(run.time)}, BIN,
                          progress=False)
        self.assertEqual(list(speed.columns["n"]), [11])
        for parameter, words in (("instances.middle.rotation", "instances has no 'middle'; it has: left, right"),
                                 ("output.history.2", "output.history has entries 0 to 1, not '2'")):
            with self.assertRaisesRegex(KeyError, words):
                cbr.study(made, parameter, [1], self.folder / "n.h5", bin=BIN)
        with self.assertRaisesRegex(cbr.Failed, "did you mean 'step'"):
            cbr.study(made, "time.stepp", [1], self.folder / "n.h5", bin=BIN, progress=False)
        ends = cbr.study(made, "time.end", [1e-5, -1.0, 2e-5], self.folder / "e.h5", bin=BIN, progress=False)
        self.assertEqual([run is None for run in ends.runs], [False, True, False])
        self.assertIn("time.end", ends.failures[1])
        with self.assertRaisesRegex(ValueError, "there are none"):
            cbr.study(made, "time.end", [], self.folder / "n.h5", bin=BIN)
        first = {"n": lambda run: {1e-5: 1.0}[round(float(run.time[-1]), 6)]}
        of_first = cbr.study(made, "time.end", [1e-5, 2e-5], self.folder / "f.h5", first, BIN, progress=False)
        self.assertEqual((of_first.columns["n"][0], of_first.failures), (1, {1: "measures: KeyError(2e-05)"}))
        made["instances"]["left"]["velocity"] = np.array([10, 0, 0])
        fast = cbr.study(made, "instances.left.velocity.0", [9.5, 9.9], self.folder / "v.h5",
                         {"p": lambda run: run["instances/left/momentum"][0, 0]}, BIN, progress=False)
        self.assertAlmostEqual(fast.columns["p"][1] / fast.columns["p"][0], 9.9 / 9.5)

    def test_replaces_no_file_but_its_own(self) -> None:
        """A path that names a mesh, notes, or a scene that somebody wrote by hand costs nobody a file."""
        scene, mesh = block("characteristic"), (self.folder / "block.msh").read_bytes()
        with self.assertRaisesRegex(OSError, "block.msh: exists and is not a scene that cbr wrote"):
            scene.write(self.folder / "block.msh")
        scene.run(self.folder / "block.msh", bin=BIN)  # into block.h5
        self.assertEqual((self.folder / "block.msh").read_bytes(), mesh)
        for name in ("notes.h5", "notes.yaml"):
            (self.folder / name).write_text("materials: {}  # mine\n")
        with self.assertRaisesRegex(cbr.Failed, "notes.h5: exists and is not"):
            scene.run(self.folder / "notes.h5", bin=BIN)
        with self.assertRaisesRegex(OSError, "exists and is not a scene"):
            scene.write(self.folder / "notes.yaml")
        for name in ("notes.h5", "notes.yaml"):
            self.assertEqual((self.folder / name).read_text(), "materials: {}  # mine\n")
        for _ in range(2):
            scene.write(self.folder / "own.yaml")
        (self.folder / "below").mkdir()
        (self.folder / "below/link.yaml").symlink_to("../own.yaml")
        with self.assertRaisesRegex(OSError, "is a link to"):
            scene.write(self.folder / "below/link.yaml")
        page = self.folder / "mine.html"
        page.write_text("<!DOCTYPE html>\n<title>mine</title>\n")
        with contextlib.redirect_stderr(io.StringIO()) as refused:
            self.assertEqual(cbr.report.main([self.runs["massless"].path, "-o", str(page)]), 2)
        self.assertIn("mine.html: exists and is not a page that cbr wrote", refused.getvalue())
        self.assertEqual(page.read_text(), "<!DOCTYPE html>\n<title>mine</title>\n")
        self.assertEqual(list(self.folder.glob(".cbr-*")), [])

    def test_progress(self) -> None:
        told: list[str] = []
        scene = block("characteristic")
        run = scene.run(self.folder / "told.yaml", bin=BIN, progress=told.append)
        text = "\n".join(told)
        for words in ("instances left, right: ", "energy: ", "results: told.h5"):
            self.assertIn(words, text)
        self.assertGreater(len(run.time), 1)
        scene["time"] = {"end": -1}
        with self.assertRaisesRegex(cbr.Failed, "end"):
            scene.run(self.folder / "told.yaml", bin=BIN, progress=told.append)

    @unittest.skipUnless(shutil.which("chromium"), "needs chromium")
    def test_report_in_a_browser(self) -> None:
        """Chromium shows the page without a network: every picture has a size, nothing is wider than the window."""
        out = self.folder / "browser.html"
        cbr.report.main([self.runs["characteristic"].path, "-o", str(out), "--compare", self.runs["craig-bampton"].path])
        probe = ("<script>document.title = JSON.stringify({figures: [...document.querySelectorAll('figure')].map(f => "
                 "[f.getBoundingClientRect().width, f.getBoundingClientRect().height]), width: document.body.scrollWidth, "
                 "window: innerWidth})</script>")
        (self.folder / "probe.html").write_text(out.read_text().replace("</body>", probe + "</body>"))
        browser = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--host-resolver-rules=MAP * ~NOTFOUND",
                   f"--user-data-dir={self.folder / 'chromium'}", "--window-size=1100,900"]
        done = subprocess.run([*browser, "--dump-dom", f"file://{self.folder / 'probe.html'}"], capture_output=True, text=True,
                              check=True, timeout=120)
        seen = json.loads(html.unescape(re.search("<title>(.*?)</title>", done.stdout, re.S).group(1)))  # type: ignore[union-attr]
        self.assertEqual(len(seen["figures"]), 7)
        for width, height in seen["figures"]:
            self.assertGreater(min(width, height), 100)
        self.assertLessEqual(seen["width"], seen["window"])
        picture = self.folder / "browser.png"
        subprocess.run([*browser, f"--screenshot={picture}", f"file://{out}"], capture_output=True, check=True, timeout=120)
        self.assertGreater(picture.stat().st_size, 20000)

    def test_report(self) -> None:
        out = self.folder / "run.html"
        self.assertEqual(cbr.report.main([self.runs["characteristic"].path, "-o", str(out), "--compare",
                                          self.runs["craig-bampton"].path, "--superelement",
                                          self.parts["characteristic"].path]), 0)
        text = out.read_text()
        page = Page()
        page.feed(text)
        page.close()
        self.assertEqual(page.open, [])
        self.assertEqual(len(page.ids), len(set(page.ids)))
        self.assertEqual([a for a in page.addresses if not a.startswith(("#", "data:"))], [])
        self.assertNotIn("@import", text)
        # The start, energy, momentum along x, two histories, force, area, times
        self.assertEqual(page.figures, 8)
        for words in ("Can it be trusted", "energy that work does not account for", "Differences",
                      "instances/right/momentum", "left.contact - right.contact", "basis characteristic",
                      "Warnings of craig-bampton.h5"):
            self.assertIn(words, text)
        # The same bytes again
        self.assertEqual(cbr.report.page(self.runs["massless"]), cbr.report.page(self.runs["massless"]))
        with contextlib.redirect_stderr(io.StringIO()) as told:
            self.assertEqual(cbr.report.main([str(self.folder / "none.h5"), "-o", str(out)]), 2)
        before = pathlib.Path(self.runs["massless"].path).read_bytes()
        with contextlib.redirect_stderr(io.StringIO()) as refused:
            self.assertEqual(cbr.report.main([self.runs["massless"].path, "-o", self.runs["massless"].path]), 2)
        self.assertIn("exists and is not a page that cbr wrote", refused.getvalue())
        self.assertEqual(pathlib.Path(self.runs["massless"].path).read_bytes(), before)
        self.assertRegex(told.getvalue(), "^cbr-report: error: .*none.h5: no such file\n$")

    def test_report_tells_what_can_be_trusted(self) -> None:
        """Two free blocks keep their momentum; a wall, a load or a support says nothing of it. Warnings are counted."""
        import h5py
        text = cbr.report.checks(self.runs["massless"])
        drift = re.search('drift of momentum, share</td><td class="number">([^<]+)<', text)
        assert drift is not None
        self.assertLess(float(drift.group(1)), 1e-10)
        self.assertNotIn("warnings", text)
        self.assertIn("below 1e-10</td><td></td>", text)  # not marked
        copy = self.folder / "checked.h5"
        shutil.copy(self.runs["massless"].path, copy)
        with h5py.File(copy, "r+") as file:
            file["energy"].attrs["outside_basis"] = 0.125
            file.attrs["warnings"] = "one\ntwo"
            del file.attrs["checksums_of_texts"]
            file.move("contact/left.contact - right.contact", "contact/left.contact - floor")
        text = cbr.report.checks(cbr.results(copy))
        self.assertIn('energy outside the basis, share</td><td class="number">0.125</td><td>below 0.05, a few per cent</td>'
                      "<td>above: contact took it from short waves", text)
        self.assertIn('warnings, told above</td><td class="number">2</td><td>0</td><td>above: read them', text)
        self.assertNotIn("drift", text)
        with h5py.File(copy, "r+") as file:
            del file["energy"].attrs["outside_basis"]
        self.assertNotIn("outside the basis", cbr.report.checks(cbr.results(copy)))
        for name in ("energy/work_external", "instances/left/reaction"):
            shutil.copy(self.runs["massless"].path, copy)
            with h5py.File(copy, "r+") as file:
                if name in file:
                    file[name][-1] = 1.0
                    del file[name].attrs["checksum"]
                else:
                    file[name] = np.zeros((3, 3))
            self.assertNotIn("drift", cbr.report.checks(cbr.results(copy)), name)

    def test_report_draws_what_the_scene_asks_for(self) -> None:
        """A superelement hits a mesh that is held: histories, reactions, stress, the start, modes and animations."""
        from PIL import Image
        scene = block("craig-bampton", 2e-5)
        scene["components"]["block"]["reduction"] |= {"recovery": True, "superelement": "recovered.cbr.h5", "modes": 40}
        scene["instances"]["right"]["as"] = "mesh"
        scene["boundary"] = [{"instance": "right", "nodes": "x_min", "fix": ["x", "y", "z"]}]
        scene["output"] |= {"fields": ["displacement", "stress"], "reactions": ["right.x_min"],
                            "stress": ["left.contact", {"instance": "right", "worst": 3, "envelope": True}]}
        run = scene.run(self.folder / "asked.yaml", bin=BIN)
        text = cbr.report.page(run, animate=True)
        for words in ("<h2>Histories</h2>\n<h3>left.contact</h3>", "All supports of right", "right.x_min: force", ">moment<", ">acceleration<",
                      "Largest von Mises stress", "<p>Contact pairs:</p><ol><li>left.contact - right.contact</li></ol>"):
            self.assertIn(words, text)
        compared = cbr.report.differences(run, run)  # numbers of nodes are no series, and envelopes are one output
        for name in ("instances/right/reactions/x_min/force", "stress/left.contact/von_mises", "stress/right/envelope/nodes/von_mises"):
            self.assertIn(name, compared)
        self.assertNotIn("node_id", compared)
        worst, ids = run["stress/right/worst/von_mises"], run["stress/right/worst/element_id"]
        at = np.unravel_index(worst.argmax(), worst.shape)
        self.assertIn(f"<td>right/worst</td><td class=\"number\">{worst.max():.4g}</td><td>element {ids[at]}</td>"
                      f"<td class=\"number\">{run.time[at[0]]:.4g}</td>", text)
        caption = re.search(r"<figcaption>Displacements (\d+) times as large; colours: von Mises stress from 0 to ", text)
        moves = [cbr.pictures.Fields(run.path).displacements(step) or [] for step in range(len(run.time))]
        self.assertGreater(int(caption[1]) * max(np.abs(u).max() for of in moves for u in of), 0.02 * 0.102)  # type: ignore[index]
        start, moving = (Image.open(io.BytesIO(data)) for data in pictures_in(text))
        self.assertEqual((start.format, moving.format, moving.n_frames), ("PNG", "GIF", len(run.time)))
        first = np.asarray(moving.convert("RGB"))
        moving.seek(len(run.time) - 1)
        self.assertGreater(np.mean(np.any(first != np.asarray(moving.convert("RGB")), axis=2)), 0.1)
        # The outside alone: 2 (6 x 3 + 6 x 4 + 3 x 4) sides
        parts = cbr.pictures.at_start(run)
        self.assertEqual([(part.instance, len(part.faces)) for part in parts], [("left", 108), ("right", 108)])
        np.testing.assert_allclose(cbr.pictures.extent([[part.points for part in parts]])[1] - cbr.pictures.extent([[parts[0].points]])[1],
                                   (np.array([0.050801, 0, 0]) @ cbr.pictures.PLANE).clip(0), atol=1e-12)
        scene.write(self.folder / "asked.yaml")
        listed = subprocess.run([BIN / "cbr-dyn", "asked.yaml", "--modes", "8", "-o", "shapes.h5"], cwd=self.folder, check=True,
                                capture_output=True, text=True).stdout.splitlines()
        self.assertEqual(cbr.report.main([str(self.folder / "shapes.h5"), "-o", str(self.folder / "shapes.html")]), 0)
        text = (self.folder / "shapes.html").read_text()
        self.assertEqual(len(pictures_in(text)), 10)
        self.assertIn("<p>left: rigid motions (0 Hz), not drawn: 6.</p>", text)
        self.assertIn(f"right, mode 1: {float(listed[9].split(',')[2]):.4g} Hz", text)
        with contextlib.redirect_stderr(io.StringIO()) as refused:
            self.assertEqual(cbr.report.main([self.runs["massless"].path, "-o", str(self.folder / "no.html"), "--animate"]), 2)
        self.assertIn("massless.fields.h5: no such file", refused.getvalue())
        with unittest.mock.patch.dict(sys.modules, {"yaml": None}):
            self.assertIn("No picture: ", cbr.report.page(cbr.results(self.runs["massless"].path)))

    def test_names_in_figures_are_text(self) -> None:
        """Not mathematics of matplotlib, and not hidden as names that begin with _."""
        name, report = "_$right$ \\, a: [é]", cbr.report
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            curve = report.Runs(self.runs["massless"], None).curves(report.Panel("$", "", [(name, "energy/total", np.asarray)]))
        self.assertIn(f">\u200a{name}</text>", html.unescape(curve))

    def test_full_disk_leaves_the_old_page(self) -> None:
        out = self.folder / "kept.html"
        self.assertEqual(cbr.report.main([self.runs["massless"].path, "-o", str(out)]), 0)
        before = out.read_bytes()
        code = ("import resource, sys; sys.path.insert(0, sys.argv[1]); resource.setrlimit(resource.RLIMIT_FSIZE, (9999, 9999)); "
                "import cbr.report; sys.exit(cbr.report.main(sys.argv[2:]))")
        done = subprocess.run([sys.executable, "-c", code, str(SOURCE / "python"), self.runs["massless"].path, "-o", str(out)],
                              capture_output=True, text=True, env={**os.environ, "MPLCONFIGDIR": str(self.folder)})
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, "cbr-report: error: .*kept.html: cannot be written: File too large\n$")
        self.assertEqual(out.read_bytes(), before)
        self.assertEqual(list(self.folder.glob(".cbr-*")), [])

    def test_report_tells_how_scenes_differ(self) -> None:
        scene = block("massless", end=2e-5)
        del scene["contact"], scene["output"]["history"]
        scene["instances"] = {"left": {**scene["instances"]["left"], "as": "mesh"}, "third": {"component": "block"}}
        other = scene.run(self.folder / "unlike.yaml", bin=BIN)
        run = self.runs["massless"]
        text = html.unescape(cbr.report.page(run, other))
        for words in ("<th>what ran</th><th>massless.h5</th><th>unlike.h5</th>",
                      "The runs differ in time.end: 4e-05 in massless.h5, 2e-05 in unlike.h5.",
                      "Only massless.h5 has the key instances.right.component: block.",
                      "Only unlike.h5 has the key instances.third.component: block.",
                      "The runs differ in instances.left.as: superelement in massless.h5, mesh in unlike.h5."):
            self.assertIn(words, text)
        self.assertNotIn("The runs differ", cbr.report.page(run, run))
        with unittest.mock.patch.dict(sys.modules, {"yaml": None}):
            page = cbr.report.page(cbr.results(run.path), cbr.results(other.path))
            self.assertIn("The scenes are not compared: ", page)
        self.assertIn("its scene needs Debian&#x27;s python3-yaml (PyYAML), which is not installed", page)

    def test_report_of_damaged_files_and_folders(self) -> None:
        whole = pathlib.Path(self.runs["massless"].path)
        part = pathlib.Path(self.parts["massless"].path)
        cut, cut_part = self.folder / "cut.h5", self.folder / "cut.cbr.h5"
        cut.write_bytes(whole.read_bytes()[:whole.stat().st_size // 2])
        cut_part.write_bytes(part.read_bytes()[:part.stat().st_size // 2])
        out = str(self.folder / "damaged.html")
        for arguments, words in (
                ([str(cut), "-o", out], "cut.h5: cannot be read: the HDF5 file is truncated or damaged"),
                ([str(whole), "-o", out, "--superelement", str(cut_part)], "cut.cbr.h5: cannot be read: the HDF5 file"),
                ([str(whole), "-o", str(self.folder / "nowhere/run.html")], "nowhere/run.html: cannot be written, there is no"),
                ([str(whole), "-o", str(self.folder)], "cannot be written, it is a folder")):
            with contextlib.redirect_stderr(io.StringIO()) as told:
                self.assertEqual(cbr.report.main(arguments), 2)
            self.assertRegex(told.getvalue(), f"^cbr-report: error: .*{words}.*\n$")

    def test_flipped_bits_change_no_number(self) -> None:
        """A bit anywhere, and in the strings, where the HDF5 library crashes or searches without end."""
        whole = pathlib.Path(self.runs["massless"].path)

        def of_results(path: pathlib.Path) -> list[bytes]:
            run = cbr.results(path)
            return [*(values.tobytes() for values in run.values()), repr((run.attributes, run.superelements)).encode()]

        def of_part(path: pathlib.Path) -> list[bytes]:
            part = cbr.superelement(path)
            return [*(x.tobytes() for x in (part.K, part.M, part.V, part.F, part.node, part.coordinates, part.faces["contact"].nodes)),
                    repr((part.content_hash, part.provenance)).encode()]

        flipped, random, refused = self.folder / "flipped.h5", np.random.default_rng(4), 0
        for path, read in ((whole, of_results), (pathlib.Path(self.parts["characteristic"].path), of_part)):
            good, expected = path.read_bytes(), read(path)
            strings = good.index(b"GCOL")
            for at in [*random.integers(0, len(good), 80), *(strings + random.integers(0, 600, 20)), strings + 26, good.rindex(b"\7contact")]:
                bad = bytearray(good)
                bad[at] ^= 1 << int(random.integers(8))
                flipped.write_bytes(bad)
                try:
                    self.assertEqual(read(flipped), expected, at)
                except cbr.FileError as error:
                    refused += 1
                    self.assertIn("flipped.h5: ", str(error))
        self.assertGreater(refused, 80)

    def test_flipped_bits_are_told_by_info_and_a_restart(self) -> None:
        """Of every kind of file: a bit of a number that is stored in any dataset, or of a text."""
        import h5py
        scene = block("massless", 2e-5)
        scene["instances"]["right"]["as"] = "mesh"
        scene["output"] |= {"fields": ["displacement", "stress"], "checkpoint": {"every": 1e-5}}
        scene.run(self.folder / "flip.yaml", bin=BIN)
        scene.write(self.folder / "flip.yaml")
        going_on = [BIN / "cbr-dyn", "flip.yaml", "-o", "on.h5", "--restart", "flip.checkpoint.h5"]
        random = np.random.default_rng(11)
        for name in ("flip.h5", "flip.fields.h5", "flip.checkpoint.h5", "flip.checkpoint.fields.h5", "massless.cbr.h5"):
            file, numbers = self.folder / name, []
            with h5py.File(file) as f:
                f.visititems(lambda _, item: numbers.append((item.id.get_offset(), item.nbytes)) if isinstance(item, h5py.Dataset) and item.size else None)
            info = [BIN / "cbr-reduce", "--info", file]
            self.assertIn(f"checksums    match in {len(numbers)} datasets\n", subprocess.run(info, capture_output=True, text=True).stdout)
            good = file.read_bytes()
            if name == "flip.h5":
                numbers += [(good.index(b"youngs_modulus"), 14)] * 5
            for trial in range(20):
                start, size = numbers[random.integers(len(numbers))]
                bad = bytearray(good)
                bad[start + random.integers(size)] ^= 1 << int(random.integers(8))
                file.write_bytes(bad)
                for command in (info, *([going_on] if "checkpoint" in name and trial % 10 == 0 else [])):
                    done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True)
                    self.assertEqual((done.returncode, done.stdout, len(re.findall(": error: ", done.stderr))), (2, "", 1), (name, done.stderr))
                    self.assertRegex(done.stderr.splitlines()[-1], f"{name}: .*(its (numbers|texts) are not those that were written|is damaged)")
            file.write_bytes(good)

    def test_fields_of_another_run_are_refused(self) -> None:
        scene = block("massless", 2e-5)
        scene["output"] |= {"fields": ["displacement"]}
        scene.run(self.folder / "mine.yaml", bin=BIN)
        scene["time"]["end"] = 1e-5
        scene.run(self.folder / "theirs.yaml", bin=BIN)
        shutil.copy(self.folder / "theirs.fields.h5", self.folder / "mine.fields.h5")
        with self.assertRaisesRegex(cbr.FileError, "mine.fields.h5: is not of the run of .*mine.h5"):
            cbr.report.Fields(self.folder / "mine.h5")
        self.assertEqual(len(cbr.report.Fields(self.folder / "theirs.h5").times), len(cbr.results(self.folder / "theirs.h5").time))

    def test_superelements_are_drawn_without_fields(self) -> None:
        run = self.runs["massless"]
        parts = cbr.pictures.at_start(run)
        self.assertEqual([part.instance for part in parts], ["left", "right"])
        for part in parts:
            mean = run[f"surfaces/{part.instance}.contact/mean_position"][0]
            np.testing.assert_allclose(part.points[np.unique(part.faces)].mean(axis=0), mean, atol=1e-12)
        self.assertIn("The instances before the run", cbr.report.page(run))

    def test_report_shows_warnings_and_superelements_of_the_run(self) -> None:
        """A block that turns by more than its linear model holds, and a superelement that is reduced again."""
        scene = block("massless")
        scene["components"]["block"]["reduction"]["superelement"] = "turned.cbr.h5"
        scene["instances"] = {"<left>": {"component": "block"}}
        scene["loads"] = [{"instance": "<left>", "surface": "contact", "force": [0, 1e5, 0]}]
        del scene["contact"], scene["output"]["history"]
        scene["time"] = {"end": 1e-3, "rotations": "small"}
        run = scene.run(self.folder / "turned.yaml", bin=BIN)
        rotates = [text for text in run.warnings or [] if "'<left>' rotates by" in text]
        self.assertEqual(len(rotates), 1)
        info = subprocess.run([BIN / "cbr-reduce", "--info", run.path], check=True, capture_output=True, text=True).stdout
        self.assertIn(f"  warning      {rotates[0]}\n", info)
        text = cbr.report.page(run)
        self.assertIn(f"<li>{html.escape(rotates[0])}</li>", text)
        self.assertIn("turned.cbr.h5: basis massless", text)
        self.assertNotIn("reduced again", text)
        scene["components"]["block"]["reduction"]["modes"] = 20
        scene.run(self.folder / "again.yaml", bin=BIN)
        self.assertIn("turned.cbr.h5 has been reduced again since this run", cbr.report.page(run))
        (self.folder / "turned.cbr.h5").unlink()
        self.assertIn("turned.cbr.h5: no such file", cbr.report.page(run))
        # Files of before
        self.assertEqual(self.runs["massless"].warnings, [])
        self.assertIn("warned of nothing", cbr.report.page(self.runs["massless"]))
        import h5py
        shutil.copy(run.path, self.folder / "older.h5")
        with h5py.File(self.folder / "older.h5", "r+") as file:
            for item, name in ((file, "warnings"), (file["instances/<left>"], "superelement")):
                del item.attrs[name], item.attrs["checksums_of_texts"]
        self.assertIn("before version 1.8", cbr.report.page(cbr.results(self.folder / "older.h5")))

    def test_warnings_survive_a_restart(self) -> None:
        """What was told at the first step is told of the run that goes on from a checkpoint, once, and not printed again."""
        scene = block("characteristic")
        scene["instances"]["right"]["position"] = [0.0244, 0, 0]
        scene["output"]["checkpoint"] = {"every": 1e-5}
        whole = scene.run(self.folder / "overlap.yaml", bin=BIN)
        overlaps = [text for text in whole.warnings or [] if "overlap by" in text]
        self.assertEqual(len(overlaps), 1)
        scene.write(self.folder / "overlap.yaml")
        going_on = ["overlap.yaml", "-o", "on.h5", "--restart", "overlap.checkpoint.h5"]
        done = subprocess.run([BIN / "cbr-dyn", *going_on], cwd=self.folder, check=True, capture_output=True, text=True)
        self.assertNotIn("overlap by", done.stderr)
        self.assertEqual(sorted(cbr.results(self.folder / "on.h5").warnings or []), sorted(whole.warnings or []))

    def test_differences_are_of_what_differs(self) -> None:
        """Of a run with itself nothing differs."""
        run = self.runs["characteristic"]
        rows = cbr.report.differences(run, run).count("<tr>")
        self.assertGreater(rows, 10)
        self.assertEqual(cbr.report.differences(run, run).count(
            '<td class="number">0</td><td class="number">0</td>'), rows - 1)

    def test_error_is_told_in_full(self) -> None:
        """Random impacts, every basis: no less than the error against full meshes at half their step, to a tenth of it."""
        random = np.random.default_rng(7)
        for i in range(4):
            for basis in BASES:
                made = block(basis, 2e-5)
                made["components"]["block"]["reduction"] |= {"modes": int(random.integers(6, 20)), "superelement": f"random-{i}-{basis}.cbr.h5"}
                made["instances"]["left"] |= {"position": [-0.02541, *random.uniform(-5e-3, 5e-3, 2)], "velocity": [1, *random.uniform(-0.3, 0.3, 2)],
                                              "rotation": [float(random.uniform(-2, 2)), 0, 0]}
                made["instances"]["left"] = {key: [float(v) for v in value] if isinstance(value, list) else value
                                             for key, value in made["instances"]["left"].items()}
                told = cbr.check_error(made, self.folder / f"random-{i}-{basis}.yaml", bin=BIN)
                fine = cbr.scene(**made)
                fine["time"] = {"end": 2e-5, "step": {"cfl": 0.1}}
                fine["instances"] = {name: of | {"as": "mesh"} for name, of in made["instances"].items()}
                exact = cbr.check.compare(told.run, fine.run(self.folder / "fine.yaml", bin=BIN))
                steps = cbr.check.compare(told.reference, cbr.results(self.folder / "fine.h5"))
                self.assertGreater(told.largest, 1e-4)
                for kind in ("surfaces", "instances"):
                    for name, shares in getattr(told, kind).items():
                        for what, share in shares.items():
                            true, left = getattr(exact, kind)[name][what], getattr(steps, kind)[name][what]
                            if what != "velocity":  # which the steps of the meshes decide, too
                                self.assertGreater(share, 0.9 * true, (i, basis, name, what))
                                self.assertLess(left, 0.3 * told.largest, (i, basis, name, what))
        self.assertIn("left.contact: position", str(told))

    def test_error_of_a_superelement_alone_is_not_known(self) -> None:
        made = block("massless", 1e-5)
        del made["output"]  # outputs of both runs at the same times all the same
        told = cbr.check_error(made, self.folder / "alone.yaml", bin=BIN)
        self.assertEqual((set(told.instances), told.surfaces, len(told.run["time"])), ({"left", "right"}, {}, 201))  # type: ignore[index]
        made["components"]["block"] = {"superelement": "massless.cbr.h5"}
        with self.assertRaisesRegex(ValueError, "needs its mesh"):
            cbr.check_error(made, self.folder / "alone.yaml", bin=BIN)
        made["instances"] = {name: of | {"as": "mesh"} for name, of in made["instances"].items()}
        with self.assertRaisesRegex(ValueError, "no superelement"):
            cbr.check_error(made, self.folder / "alone.yaml", bin=BIN)

    def test_examples(self) -> None:
        examples = SOURCE / "python/examples"
        environment = {**os.environ, "PYTHONPATH": str(SOURCE / "python"), "CBR_BIN": str(BIN), "PYTHONDONTWRITEBYTECODE": "1"}
        response = self.folder / "response.png"
        subprocess.run([sys.executable, examples / "frequency_response.py", *(p.path for p in self.parts.values()), "-o",
                        response], check=True, env=environment)
        self.assertGreater(response.stat().st_size, 10000)
        told = subprocess.run([sys.executable, examples / "step_study.py", self.folder / "block.msh", self.folder / "study"],
                              check=True, env=environment, capture_output=True, text=True).stdout.splitlines()
        self.assertEqual(len(told), 5)
        self.assertLess(float(told[3].split(", ")[1].split()[0]), 0.01)

    def test_docstrings(self) -> None:
        for module in ("cbr.check", "cbr.results", "cbr.scene", "cbr.signals", "cbr.study", "cbr.superelement",
                       "cbr.page", "cbr.pictures", "cbr.report", "cbr.trust"):
            found = doctest.testmod(sys.modules[module])
            self.assertGreater(found.attempted, 0)
            self.assertEqual(found.failed, 0)


class Signals(unittest.TestCase):
    """Filters and spectra against closed forms."""

    def test_classes_are_those_of_j211(self) -> None:
        """The recursion of SAE J211-1, Appendix C, there and back over noise between two rests; its gain; 5/3 of the class."""
        step, n = 1e-4, 20000
        x, t = np.zeros(n), step * np.arange(n)
        x[8000:12000] = np.random.default_rng(1).standard_normal(4000)
        for channel in cbr.signals.CFC:
            wa = np.tan(np.pi * channel * 2.0775 * step)
            a0, b1, b2 = (number / (1 + np.sqrt(2) * wa + wa**2) for number in (wa**2, -2 * (wa**2 - 1), -1 + np.sqrt(2) * wa - wa**2))
            expected = x
            for _ in range(2):
                y = np.zeros(n)
                for i in range(2, n):
                    y[i] = a0 * (expected[i] + 2 * expected[i - 1] + expected[i - 2]) + b1 * y[i - 1] + b2 * y[i - 2]
                expected = y[::-1]
            np.testing.assert_allclose(cbr.cfc(t, x, channel), expected, atol=1e-12 * np.abs(expected).max())
            for hz in (0.3 * channel, 5 / 3 * channel, 3 * channel):
                gain = 1 / (1 + (np.tan(np.pi * hz * step) / wa)**4)
                sine, inside = np.sin(2 * np.pi * hz * t), slice(3000, 17000)
                np.testing.assert_allclose(cbr.cfc(t, sine, channel)[inside], gain * sine[inside], atol=1e-11)
        fine = 1e-6 * np.arange(300000)
        sine = np.sin(2 * np.pi * 1000 * fine)
        self.assertAlmostEqual(20 * np.log10(np.abs(cbr.cfc(fine, sine, 600)[100000:200000]).max()), 10 * np.log10(0.5), places=3)

    def test_butterworth_has_its_gain(self) -> None:
        t, inside = 1e-4 * np.arange(20000), slice(5000, 15000)
        for order in (1, 2, 3, 8):
            for hz in (100, 200, 350):
                r = np.tan(np.pi * hz * 1e-4) / np.tan(np.pi * 200 * 1e-4)
                both = np.column_stack([np.sin(2 * np.pi * hz * t), np.cos(2 * np.pi * hz * t)])
                for above in (False, True):
                    gain = 1 / (1 + (np.sqrt(2) - 1) * (1 / r if above else r)**(2 * order))
                    found = cbr.butterworth(t, both, 200, order, above)
                    np.testing.assert_allclose(found[inside], gain * both[inside], atol=1e-11)
                    if hz == 200:
                        self.assertAlmostEqual(gain, np.sqrt(0.5), places=14)
            np.testing.assert_allclose(cbr.butterworth(t, 3 + 2 * t, 200, order), 3 + 2 * t, atol=1e-11)
            np.testing.assert_allclose(cbr.butterworth(t, 3 + 2 * t, 200, order, True), 0, atol=1e-11)

    def test_spectrum_has_the_mean_square(self) -> None:
        """Of a sine on a frequency of the spectrum to round-off; of noise, whose density is 2 sigma^2 / samples a second, to
        its scatter."""
        t = np.arange(2**18) / 5000
        noise = 0.3 * np.random.default_rng(5).standard_normal(len(t))
        hz, density = cbr.psd(t, np.column_stack([4 * np.sin(2 * np.pi * 625 * t), noise]), 1024)
        self.assertEqual(density.shape, (513, 2))
        self.assertAlmostEqual(hz[density[:, 0].argmax()], 625, places=9)
        np.testing.assert_allclose(density[:, 0].sum() * hz[1], 4**2 / 2, rtol=1e-12)
        # 511 segments, which overlap by half: 1 / sqrt(270) a frequency, a sixteenth of it for a mean of 256
        for band in (slice(1, 257), slice(257, 512)):
            self.assertLess(abs(density[band, 1].mean() / (2 * 0.3**2 / 5000) - 1), 3 / np.sqrt(256 * 270))
        self.assertLess(np.abs(density[2:511, 1] / (2 * 0.3**2 / 5000) - 1).max(), 5 / np.sqrt(270))
        for odd in (999, 1000):  # with and without a highest frequency of its own
            hz, density = cbr.psd(t, noise, odd)
            self.assertLess(abs(density.sum() * hz[1] / np.mean(noise**2) - 1), 0.01)

    def test_refusals(self) -> None:
        t = np.arange(100) / 1000
        for words, call in (("no class 70", lambda: cbr.cfc(t, t, 70)), ("class 180 needs 10 times", lambda: cbr.cfc(t, t, 180)),
                            ("between 0 and 500 Hz", lambda: cbr.butterworth(t, t, 500)), ("order 0", lambda: cbr.butterworth(t, t, 5, 0)),
                            ("not evenly spaced", lambda: cbr.psd(t**2, t)), ("not finite", lambda: cbr.psd(t, t / 0 * np.nan)),
                            ("give n times", lambda: cbr.psd(t, t[1:])), ("from 4 to 100", lambda: cbr.psd(t, t, 101))):
            with self.assertRaisesRegex(ValueError, words), np.errstate(all="ignore"):
                call()


def pictures_in(text: str) -> list[bytes]:
    return [base64.b64decode(data) for data in re.findall(r'src="data:image/\w+;base64,([^"]+)"', text)]


VOID = {"meta", "br", "img", "path", "use", "rect", "line"}


class Page(html.parser.HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.addresses: list[str] = []
        self.figures = 0

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.figures += tag == "figure"
        if tag not in VOID:
            self.open.append(tag)
        self.handle_attributes(attributes)

    def handle_startendtag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.handle_attributes(attributes)

    def handle_attributes(self, attributes: list[tuple[str, str | None]]) -> None:
        for name, value in attributes:
            if name == "id":
                self.ids.append(str(value))
            if name in ("href", "src", "xlink:href"):
                self.addresses.append(str(value))

    def handle_endtag(self, tag: str) -> None:
        if tag in VOID:
            return
        if not self.open or self.open[-1] != tag:
            raise AssertionError(f"</{tag}> closes {self.open[-1:]}")
        self.open.pop()


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
