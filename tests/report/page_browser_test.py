#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Loads report pages in a headless Chromium as their readers do: page_browser_test.py ALIDADE

Exit code 77 (skipped) without Chromium, unless ALIDADE_REQUIRE_PEERS is set.
"""
from __future__ import annotations

import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import chromium  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
FIGURES = ["accuracy", "coverage", "next-view", "tilts", "distances", "scene", "image-residuals", "board-residuals", "histogram",
           "normal-plot", "view-errors", "view-sheet", "distortion-grid", "radial", "undistorted", "correlations", "parameters", "models"]
VALIDATION_FIGURES = ["image-residuals", "board-residuals", "histogram", "freed-difference", "view-errors", "fixed-freed", "view-sheet",
                      "difference", "distortion-grid", "radial", "undistorted", "parameters"]
NAMES = ["</script><script>alert(1)</script>", "\"><img src=x onerror=alert(1)>", "'a' & 📷", "${alert(1)}", "&lt;b&gt;"]
ALIDADE = ""


class PageTest(unittest.TestCase):
    """One page with hostile image names, and one browser for all tests."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = tempfile.TemporaryDirectory()
        images = pathlib.Path(cls.folder.name) / "images"
        images.mkdir()
        for i, image in enumerate(sorted((ROOT / "testdata/checkerboard/images").glob("*.png"))):
            name = NAMES[i].replace("/", "|") if i < len(NAMES) else ""
            if i == len(NAMES):  # bytes that are not UTF-8
                os.symlink(image, os.fsencode(images) + b"/\xff\xfe<i>" + os.fsencode(image.name))
            else:
                (images / f"{name}{image.name}").symlink_to(image)
        cls.page = images.parent / "page.html"
        subprocess.run([ALIDADE, "calibrate", images, "--board", "checkerboard:9x6:25mm", "--report", cls.page, "--quiet"],
                       check=True)
        camera = ROOT / "testdata/checkerboard/camera.yaml"
        cls.validation = images.parent / "validation.html"
        subprocess.run([ALIDADE, "validate", camera, "--images", images, "--board", "checkerboard:9x6:25mm", "--against", camera,
                        "--report", cls.validation, "--quiet"], check=True)
        files = images.parent / "files"
        files.mkdir()
        for name in NAMES:
            (files / (name.replace("/", "|") + ".yaml")).write_bytes(camera.read_bytes())
        cls.folder_page = images.parent / "files.html"
        subprocess.run([ALIDADE, "validate", files, "--images", images, "--board", "checkerboard:9x6:25mm",
                        "--report", cls.folder_page, "--quiet"], check=True)
        cls.browser = chromium.Chromium()

    @classmethod
    def tearDownClass(cls) -> None:
        cls.browser.close()
        cls.folder.cleanup()

    def setUp(self) -> None:
        self.browser.open(self.page)

    def run_js(self, script: str) -> object:
        return self.browser.run(script)

    def test_loads_without_network_and_errors(self) -> None:
        self.assertEqual(self.browser.console, [])
        self.assertEqual([r for r in self.browser.requests if not r.startswith(("data:", self.page.as_uri()))], [])
        self.assertNotIn("Page.javascriptDialogOpening", self.browser.events)

    def test_every_figure_shows_something(self) -> None:
        self.check_figures(FIGURES)

    def check_figures(self, figures: list[str]) -> None:
        for figure in figures:
            with self.subTest(figure):
                self.assertTrue(self.run_js(f"!!document.getElementById('{figure}')"), "is missing")
                size = self.run_js(f"(() => {{ const b = document.getElementById('{figure}').getBoundingClientRect();"
                                   " return [b.width, b.height]; })()")
                self.assertGreater(min(size), 100)
                marks = self.run_js(f"document.querySelectorAll('#{figure} svg *, #{figure} td, #{figure} img').length")
                self.assertGreaterEqual(marks, 6)
                self.assertTrue(self.run_js(f"document.querySelector('#{figure} h3').textContent.length > 5"))
                self.assertTrue(self.run_js(f"document.querySelector('#{figure} .reading').textContent.length > 40"))

    def test_drawings_have_words_for_readers_who_cannot_see_them(self) -> None:
        self.assertEqual(self.run_js("[...document.querySelectorAll('figure svg.drawing')].filter(s => !s.closest('.thumb') && ("
                                     "s.getAttribute('role') !== 'img' || s.getAttribute('aria-label').length < 20)).length"), 0)
        self.assertEqual(self.run_js("[...document.querySelectorAll('button')].filter(b => "
                                     "!(b.getAttribute('aria-label') || b.textContent).trim()).length"), 0)

    def test_drawings_stay_within_their_frames(self) -> None:
        self.check_frames(self.page)

    def check_frames(self, page: pathlib.Path) -> None:
        for width in (1280, 400):
            self.browser.open(page, width)
            self.run_js("document.querySelectorAll('details').forEach(d => { d.open = true; })")
            self.assertEqual(self.run_js("document.documentElement.scrollWidth"), width)
            outside = self.run_js("""[...document.querySelectorAll('figure svg text')].filter(t => {
                const a = t.getBoundingClientRect(), b = t.ownerSVGElement.getBoundingClientRect();
                return a.left < b.left - 2 || a.right > b.right + 2 || a.top < b.top - 2 || a.bottom > b.bottom + 2;
              }).map(t => t.closest('figure').id + ': ' + t.textContent)""")
            self.assertEqual(outside, [], f"at {width} px")
            smallest = self.run_js("""Math.min(...[...document.querySelectorAll('figure svg text')].map(t =>
                t.ownerSVGElement.getScreenCTM().a * parseFloat(getComputedStyle(t).fontSize)))""")
            self.assertGreaterEqual(smallest, 11)
            hidden = self.run_js("""[...document.querySelectorAll('*')].filter(e => e.scrollWidth > e.clientWidth + 2 &&
                ['auto', 'scroll'].includes(getComputedStyle(e).overflowX)).map(e => e.parentElement.id)""")
            self.assertEqual(hidden, [], f"scrolls at {width} px")

    def test_the_keyboard_shows_where_it_is(self) -> None:
        self.run_js("document.querySelector('nav a:last-child').focus()")
        self.run_js("document.getElementById('scene-drawing').focus()")
        self.browser.press("ArrowLeft", 37)
        self.assertEqual(self.run_js("getComputedStyle(document.getElementById('scene-drawing')).outlineStyle"), "solid")

    def test_views_open_and_close_by_mouse(self) -> None:
        self.run_js("document.querySelector('.thumb').click()")
        self.assertTrue(self.run_js("document.getElementById('viewer').open"))
        self.assertEqual(self.run_js("document.querySelectorAll('#viewer-drawing image').length"), 1)
        self.assertGreater(self.run_js("document.querySelector('#viewer-drawing .detected').getBBox().width"), 50)
        self.assertGreater(self.run_js("document.querySelector('#viewer-drawing .projected').getBBox().width"), 50)
        self.assertEqual(self.run_js("document.getElementById('viewer-times').value"), "200")
        self.run_js("document.getElementById('viewer-close').click()")
        self.assertFalse(self.run_js("document.getElementById('viewer').open"))
        self.run_js("document.querySelector('rect[data-view]').dispatchEvent(new MouseEvent('click', {bubbles: true}))")
        self.assertTrue(self.run_js("document.getElementById('viewer').open"))

    def test_views_open_and_close_by_keyboard(self) -> None:
        self.run_js("document.querySelector('.thumb[data-view=\"3\"]').focus()")
        self.browser.press("Enter", 13)
        name = lambda: self.run_js("document.getElementById('viewer-words').textContent")
        self.assertTrue(self.run_js("document.getElementById('viewer').open"))
        self.assertIn("view 4 of 12", name())
        self.browser.press("ArrowRight", 39)
        self.assertIn("view 5 of 12", name())
        self.browser.press("ArrowLeft", 37)
        self.browser.press("ArrowLeft", 37)
        self.assertIn("view 3 of 12", name())
        self.browser.press("Escape", 27)
        self.assertFalse(self.run_js("document.getElementById('viewer').open"))

    def test_the_scene_turns(self) -> None:
        shape = "document.querySelector('#scene-drawing .board').parentElement.lastElementChild.getAttribute('d')"
        texts = "[...document.querySelectorAll('#scene-drawing text[data-points]')].map(t => t.getAttribute('x')).join()"
        before, words = self.run_js(shape), self.run_js(texts)
        self.run_js("document.getElementById('scene-drawing').focus()")
        self.browser.press("ArrowLeft", 37)
        self.assertNotEqual(self.run_js(shape), before)
        self.browser.press("ArrowRight", 39)
        numbers = lambda d: [float(n) for n in re.findall(r"-?[\d.]+", d)]
        for a, b in zip(numbers(self.run_js(shape)), numbers(before), strict=True):
            self.assertAlmostEqual(a, b, delta=0.3)  # the script and the program draw the same
        box = self.run_js("(() => { const s = document.getElementById('scene-drawing'); s.scrollIntoView({block: 'center'});"
                          " const b = s.getBoundingClientRect(); return [b.left, b.top]; })()")
        self.browser.drag((box[0] + 40, box[1] + 40), (box[0] + 140, box[1] + 90))
        self.assertNotEqual(self.run_js(texts), words)
        self.assertFalse(self.run_js("document.getElementById('viewer').open"), "a drag opens no view")
        self.run_js("document.querySelector('.thumb').click()")
        self.assertTrue(self.run_js("document.getElementById('viewer').open"))

    def test_a_rig_shows_and_turns(self) -> None:
        lines = (ROOT / "testdata/checkerboard/corners.csv").read_text().splitlines()
        page = self.page.parent / "rig.html"
        x = lines[1].split(",").index("u")
        # Corners that agree to the last digit would be those of the same images.
        for name, wave in (("left", math.sin), ("right", math.cos)):
            noisy = [line.split(",") for line in lines]
            for i, fields in enumerate(noisy[2:]):
                fields[x] = str(float(fields[x]) + 0.05 * wave(7 * i))
            (page.parent / f"{name}.csv").write_text("".join(",".join(fields) + "\n" for fields in noisy))
        subprocess.run([ALIDADE, "rig", "calibrate", page.parent / "left.csv", page.parent / "right.csv", "--model", "radtan",
                        "--report", page, "--quiet"], check=True)
        for width in (1280, 400):
            self.browser.open(page, width)
            self.assertEqual(self.browser.console, [])
            self.assertEqual(self.run_js("document.documentElement.scrollWidth"), width)
        shape = "document.querySelector('#scene-drawing .pyramid').getAttribute('d')"
        before = self.run_js(shape)
        self.run_js("document.getElementById('scene-drawing').focus()")
        self.browser.press("ArrowUp", 38)
        self.assertNotEqual(self.run_js(shape), before)
        # The views of each camera stand in its fold, and open.
        self.run_js("location.hash = '#camera1'")
        time.sleep(0.2)
        self.assertEqual(self.run_js("[...document.querySelectorAll('details.file[open]')].map(d => d.id)"), ["camera1"])
        self.run_js("document.querySelector('#camera1 .thumb[data-view=\"12\"]').click()")
        self.assertIn("view 13 of 24", self.run_js("document.getElementById('viewer-words').textContent"))
        self.assertGreater(self.run_js("document.querySelector('#viewer-drawing .detected').getBBox().width"), 50)
        self.run_js("document.getElementById('viewer').close()")
        self.check_frames(page)

    def test_a_validation_shows_its_figures_and_views(self) -> None:
        self.browser.open(self.validation)
        self.assertEqual(self.browser.console, [])
        self.assertEqual([r for r in self.browser.requests if not r.startswith(("data:", self.validation.as_uri()))], [])
        self.check_figures(VALIDATION_FIGURES)
        self.run_js("document.querySelector('.thumb[data-view=\"3\"]').click()")
        self.assertTrue(self.run_js("document.getElementById('viewer').open"))
        self.assertEqual(self.run_js("document.querySelectorAll('#viewer-drawing image').length"), 1)
        self.assertGreater(self.run_js("document.querySelector('#viewer-drawing .detected').getBBox().width"), 50)
        self.assertIn("view 4 of 12", self.run_js("document.getElementById('viewer-words').textContent"))
        self.check_frames(self.validation)

    def test_a_validated_folder_opens_its_files(self) -> None:
        self.browser.open(self.folder_page)
        self.assertEqual(self.browser.console, [])
        names = self.run_js("[...document.querySelectorAll('td.name')].map(n => n.textContent)")
        self.assertEqual(sorted(n.split("/", 3)[-1].split("files/")[-1] for n in names),
                         sorted(n.replace("/", "|") + ".yaml" for n in NAMES))
        self.assertEqual(self.run_js("document.querySelectorAll('img[onerror], script').length"), 2)
        self.assertEqual(self.run_js("document.querySelectorAll('details.file[open]').length"), 0)
        self.run_js("document.querySelectorAll('td.name a')[2].click()")
        time.sleep(0.2)
        self.assertEqual(self.run_js("document.querySelectorAll('details.file[open]').length"), 1)
        # Each fold has views of its own, which open.
        self.run_js("document.querySelectorAll('details.file')[2].querySelector('rect[data-view]')"
                    ".dispatchEvent(new MouseEvent('click', {bubbles: true}))")
        self.assertIn("of 60", self.run_js("document.getElementById('viewer-words').textContent"))
        self.run_js("document.getElementById('viewer').close()")
        self.check_frames(self.folder_page)

    def test_outliers_have_a_mark(self) -> None:
        lines = (ROOT / "testdata/checkerboard/corners.csv").read_text().splitlines()
        rows = [i for i, line in enumerate(lines) if ",view_003.png," in line]
        self.assertGreater(len(rows), 40)
        spoiled = lines[rows[20]].split(",")
        x = lines[1].split(",").index("u")
        spoiled[x] = str(float(spoiled[x]) + 9)
        lines[rows[20]] = ",".join(spoiled)
        corners, page = self.page.parent / "spoiled.csv", self.page.parent / "spoiled.html"
        corners.write_text("\n".join(lines) + "\n")
        subprocess.run([ALIDADE, "calibrate", corners, "--report", page, "--quiet"], check=True)
        self.browser.open(page)
        self.run_js("document.querySelector('.thumb[data-view=\"2\"]').click()")
        box = self.run_js("(() => { const b = document.querySelector('#viewer-drawing .rejected').getBBox(); return [b.x, b.width]; })()")
        self.assertLess(abs(box[0] + box[1] / 2 - float(spoiled[x])), 12)
        self.assertGreater(box[1], 2)
        self.assertIn("1 left out", self.run_js("document.getElementById('viewer-words').textContent"))
        self.assertIn("diamond", self.run_js("document.getElementById('viewer-key').textContent"))
        self.run_js("document.getElementById('viewer-after').click()")
        self.assertNotIn("left out", self.run_js("document.getElementById('viewer-words').textContent"))

    def test_names_are_text(self) -> None:
        names = self.run_js("[...document.querySelectorAll('.thumb .name')].map(n => n.textContent)")
        for name in NAMES:
            self.assertTrue(any(n.startswith(name.replace("/", "|")) for n in names), name)
        self.assertTrue(any(n.startswith("\ufffd\ufffd<i>") for n in names))
        self.assertEqual(self.run_js("document.querySelectorAll('img[onerror], script').length"), 2)

    def test_colours_follow_the_reader(self) -> None:
        ground = "getComputedStyle(document.body).backgroundColor"
        bright = self.run_js(ground)
        self.browser.open(self.page, dark=True)
        self.assertNotEqual(self.run_js(ground), bright)
        self.assertEqual(self.browser.console, [])

    def test_scripts_can_extract_the_evidence(self) -> None:
        views = self.run_js("JSON.parse(document.getElementById('evidence').textContent).views.length")
        self.assertEqual(views, 12)

    def test_prints(self) -> None:
        pdf = self.browser.call("Page.printToPDF")["data"]
        self.assertGreater(len(pdf), 20_000)


if __name__ == "__main__":
    if chromium.find() is None:
        print("page_browser_test: Chromium was not found (Debian: chromium)")
        sys.exit(1 if os.environ.get("ALIDADE_REQUIRE_PEERS") else 77)
    ALIDADE = os.path.realpath(sys.argv.pop(1))
    unittest.main()
