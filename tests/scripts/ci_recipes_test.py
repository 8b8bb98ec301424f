#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs the recipes of docs/ci.md on simulated photographs: once where all is well, and where the answer is no.

usage: ci_recipes_test.py PROGRAM

The recipes are the code blocks of the page as they are printed there. The run parts of its YAML blocks have to be the
command of its first recipe. Without Python's yaml module the test is skipped (exit code 77).
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DATA = os.path.join(ROOT, "testdata", "checkerboard")
BOARD = "checkerboard:9x6:25mm"
NUM_RUNS = 3 * 4 + 3 + 2 + 1 + 4
NUM_OLD_PHOTOS, NUM_PHOTOS, NUM_NEW_PHOTOS = 8, 12, 8


def blocks(language):
    """The code blocks of the page in a language."""
    page = open(os.path.join(ROOT, "docs", "ci.md"), encoding="utf-8").read()
    return re.findall(rf"^```{language}\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)


def commands_in(value):
    """The shell in a parsed CI file: what "run" and "script" hold, at any depth."""
    if isinstance(value, list):
        return [command for item in value for command in commands_in(item)]
    if not isinstance(value, dict):
        return []
    found = []
    for key, item in value.items():
        if key in ("run", "script"):
            found += item if isinstance(item, list) else [item]
        else:
            found += commands_in(item)
    return found


def content(path):
    with open(path, "rb") as file:
        return file.read()


class Recipes:
    """A scratch folder, the program in front of PATH, and counts of what was checked."""

    def __init__(self, folder, program):
        self.folder = folder
        self.num_runs = self.num_wrong = 0
        os.mkdir(self.path("bin"))
        os.symlink(program, self.path("bin/alidade"))
        self.environment = dict(os.environ, PATH=self.path("bin") + ":" + os.environ["PATH"])

    def path(self, name):
        return os.path.join(self.folder, name)

    def alidade(self, *args):
        subprocess.run(["alidade", *args], cwd=self.folder, env=self.environment, check=True, capture_output=True)

    def check(self, is_right, what):
        if not is_right:
            self.num_wrong += 1
            print("wrong: " + what)

    def run(self, what, script, args, work, expected_code):
        """Runs a recipe in a folder as CI does; sh is a plain POSIX shell on Debian."""
        run = subprocess.run(["sh", "-eu", "-c", script, "recipe.sh", *args], cwd=self.path(work), env=self.environment,
                             capture_output=True, text=True)
        self.num_runs += 1
        self.check(run.returncode == expected_code,
                   f"{what}: exit code {run.returncode}; expected {expected_code}\n{run.stdout}{run.stderr}")
        return run.stdout + run.stderr

    def take_photos(self):
        """Photographs of one camera in old/ and all/, of the same after a knock in knocked/, and both in mixed/."""
        for name in ("old", "all", "mixed", "none"):
            os.mkdir(self.path(name))
        for i in range(1, NUM_PHOTOS + 1):
            for name, count in (("old", NUM_OLD_PHOTOS), ("all", NUM_PHOTOS), ("mixed", NUM_PHOTOS)):
                if i <= count:
                    shutil.copy(f"{DATA}/images/view_{i:03}.png", self.path(name))
        scene = open(DATA + ".yaml", encoding="utf-8").read()
        for before, after in (("fx: 535, fy: 534, cx: 322.5", "fx: 545, fy: 544, cx: 330.5"), ("seed: 7", "seed: 11"),
                              ("random: 12", f"random: {NUM_NEW_PHOTOS}")):
            self.check(before in scene, f"the scene has no '{before}'")
            scene = scene.replace(before, after)
        open(self.path("knocked.yaml"), "w", encoding="utf-8").write(scene)
        self.alidade("simulate", "knocked.yaml", "-o", "simulated")
        os.rename(self.path("simulated/images"), self.path("knocked"))
        for name in os.listdir(self.path("knocked")):
            shutil.copy(self.path("knocked/" + name), self.path("mixed/knocked_" + name))
        for name in ("old", "all", "knocked"):
            self.alidade("calibrate", name, "--board", BOARD, "-o", f"{name}_camera.yaml")

    def check_folder(self, script):
        """The first recipe: folders of camera files."""
        good = open(self.path("old_camera.yaml"), encoding="utf-8").read()
        fx_in_mm = re.sub(r"\bfx: \S+", "fx: 4.2", good, count=1)
        uneven_pixels = ("{alidade_camera: 1, model: pinhole, image_size: {width: 640, height: 480}, "
                         "parameters: {fx: 500, fy: 575, cx: 320, cy: 240}}")  # a warning, which --strict refuses
        for work, right, code, num_failed in (("good", good, 0, "0"), ("wrong", fx_in_mm, 3, "1"),
                                              ("doubtful", uneven_pixels, 3, "1"), ("empty", None, 1, None)):
            shutil.rmtree(self.path(work), ignore_errors=True)
            os.makedirs(self.path(work + "/calibrations/spare"))
            if right:
                shutil.copy(self.path("all_camera.yaml"), self.path(work + "/calibrations/left.yaml"))
                open(self.path(work + "/calibrations/spare/right.yaml"), "w", encoding="utf-8").write(right)
            self.run(f"the folder '{work}'", script, [], work, code)
            report = self.path(work + "/report.xml")
            root = xml.etree.ElementTree.parse(report).getroot()
            found = root.get("tests"), root.get("failures"), root.get("errors")
            self.check(found == (("2", num_failed, "0") if right else ("1", "0", "1")),
                       f"the folder '{work}': report.xml has {root.attrib}")

    def compare(self, script):
        """The second recipe: the last camera and a new one."""
        for new, code, text in (("all", 0, "same: "), ("knocked", 3, "if it has changed"), ("no", 1, "not be compared")):
            work = "compare_" + new
            os.mkdir(self.path(work))
            printed = self.run(f"the {new} camera", script, ["../old_camera.yaml", f"../{new}_camera.yaml"], work, code)
            self.check(text in printed, f"the {new} camera: it prints {printed}")
            self.check(os.path.exists(self.path(work + "/difference.svg")) == (code != 1),
                       f"the {new} camera: difference.svg")

    def compare_folders(self, script):
        """The third recipe: the cameras of two months."""
        for new, code in (("all", 0), ("knocked", 3)):
            work = "months_" + new
            for month, camera in (("2026-10", "old"), ("2026-11", new)):
                os.makedirs(self.path(f"{work}/{month}"))
                shutil.copy(self.path(camera + "_camera.yaml"), self.path(f"{work}/{month}/front.yaml"))
            self.run(f"the months with the {new} camera", script, [], work, code)
            root = xml.etree.ElementTree.parse(self.path(work + "/changes.xml")).getroot()
            self.check(root.get("failures") == str(code // 3), f"{new}: changes.xml has {root.attrib}")
            self.check(os.path.exists(self.path(work + "/changes.html")), f"{new}: changes.html")

    def calibrate_again(self, script):
        """The last recipe, in one folder, night by night."""
        os.mkdir(self.path("nights"))
        in_use = self.path("nights/camera.yaml")
        shutil.copy(self.path("old_camera.yaml"), in_use)
        nights = [("all", 0, True), ("knocked", 3, True), ("mixed", 3, True), ("none", 1, False)]
        for photos, code, has_report in nights:
            shutil.rmtree(self.path("nights/photos"), ignore_errors=True)
            shutil.copytree(self.path(photos), self.path("nights/photos"))
            before = content(in_use)
            self.run(f"the night with the photographs '{photos}'", script, [], "nights", code)
            is_replaced = content(in_use) != before
            self.check(is_replaced == (code == 0), f"'{photos}': camera.yaml {'was' if is_replaced else 'was not'} replaced")
            if code == 0:
                self.check(content(self.path("nights/nightly/previous.yaml")) == before, f"'{photos}': previous.yaml")
                self.alidade("diff", "nights/camera.yaml", "all_camera.yaml", "--tolerance", "0.01px")
            self.check(os.path.exists(self.path("nights/nightly/report.html")) == has_report, f"'{photos}': report.html")
            self.check(os.path.exists(self.path("nights/nightly/difference.svg")) == (photos in ("all", "knocked")),
                       f"'{photos}': difference.svg")
        entries = [name for _, _, names in os.walk(self.path("nights/nightly/cache")) for name in names]
        known = len(set(entries) - {"CACHEDIR.TAG"})
        self.check(known == NUM_PHOTOS + NUM_NEW_PHOTOS, f"the cache knows {known} photographs")


def main():
    try:
        import yaml
    except ImportError:
        print("Python's yaml module is not installed (Debian: python3-yaml)")
        return 77
    scripts = blocks("sh")
    in_yaml = [commands_in(yaml.safe_load(text)) for text in blocks("yaml")]
    if len(scripts) != 5 or [len(commands) for commands in in_yaml] != [1, 1]:
        print(f"docs/ci.md has {len(scripts)} recipes, and its YAML the commands {in_yaml}; expected 5, and one each")
        return 1
    with tempfile.TemporaryDirectory() as folder:
        recipes = Recipes(folder, os.path.abspath(sys.argv[1]))
        for (command,) in in_yaml:
            recipes.check(command.strip() == scripts[0].strip(), f"the YAML runs '{command}' instead of the recipe")
        recipes.take_photos()
        for script in [scripts[0], *(command for (command,) in in_yaml)]:
            recipes.check_folder(script)
        recipes.compare(scripts[1])
        recipes.compare_folders(scripts[2])
        recipes.run("the rig without a file", scripts[3], [], "good", 1)
        recipes.calibrate_again(scripts[4])
    print(f"{recipes.num_runs} runs of recipes, {recipes.num_wrong} wrong")
    return 0 if recipes.num_runs == NUM_RUNS and recipes.num_wrong == 0 else 1


sys.exit(main())
