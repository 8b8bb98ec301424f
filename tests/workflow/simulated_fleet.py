# SPDX-License-Identifier: MIT
"""A dozen simulated cameras for the tests of the workflow, and runs of it in scratch folders.

Ten cameras are rendered. Two of them have a previous file: that of "steady" is right, and that of "drifted" has another
focal length. "mixed" has the photographs of two cameras, and those of "broken" cannot be read.
"""
import concurrent.futures
import csv
import ctypes
import os
import re
import shutil
import signal
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
WORKFLOW = os.path.join(ROOT, "workflow")
BOARD = "checkerboard:6x5:30mm"
RENDERED = [f"cam{i:02}" for i in range(1, 9)] + ["steady", "drifted"]
ALL = RENDERED + ["mixed", "broken"]
NUM_VIEWS = 8
# What the command line names of each step, from which a logged command is assigned to a camera.
NAMED_FILE = {"detect": "corners", "calibrate": "corners", "diff": "calibrations", "validate": "calibrations",
              "report": "evidence"}
SKIP = 77

SCENE = """\
alidade_scene: 1
camera:
  model: radtan
  image_size: {{width: 320, height: 240}}
  parameters: {{fx: {focal}, fy: {focal}, cx: {cx}, cy: 119.1, k1: -0.28, k2: 0.08, p1: 0.0008, p2: -0.0004, k3: -0.01}}
board: checkerboard:6x5:30mm
views: {{random: {views}}}
seed: {seed}
random: {{max_tilt_deg: 50, max_roll_deg: 30, min_fill: 0.4, max_fill: 0.8, margin_px: 4}}
render: {{blur_px: 0.8, read_noise: 1.5, full_well_electrons: 10000, dark_level: 30, bright_level: 220,
         background_level: 110, border_square: 1, falloff: 0.2, vignetting_exponent: 4}}
corner_noise_px: 0
"""

# Logs each command. "trap" holds a part of a command that does not simply run: it is killed, has no memory, or waits until
# the file "hold" is removed.
WRAPPER = """\
#!/bin/sh
echo "$*" >>{folder}/log
if [ -s {folder}/trap ]; then
  read -r kind text <{folder}/trap
  case "$*" in
    *"$text"*)
      case $kind in
        kill) kill -KILL $$ ;;
        memory) echo 'error: out of memory' >&2; exit 1 ;;
        hold) while [ -e {folder}/hold ]; do sleep 0.05; done ;;
      esac
      ;;
  esac
fi
exec {program} "$@"
"""


def require(*programs):
    """Ends the test as skipped where a program is missing."""
    missing = [name for name in programs if not shutil.which(name)]
    if missing:
        skip(missing, "full")


def skip(missing, group):
    """Ends the test: as skipped, or as failed where the packages were installed for it."""
    is_required = os.environ.get("ALIDADE_REQUIRE_PEERS") == "1"
    print(f"{'FAILED' if is_required else 'SKIPPED'}: {', '.join(missing)} not found; run scripts/setup {group}")
    raise SystemExit(1 if is_required else SKIP)


def end_with_parent():
    """In a child: ask the kernel to end it where the test is killed and ends nothing itself."""
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


def content(path):
    with open(path, "rb") as file:
        return file.read()


class SimulatedFleet:
    """Renders the photographs in a folder, and makes working folders that share them."""

    def __init__(self, folder, program):
        self.folder = folder
        self.program = os.path.abspath(program)
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            list(pool.map(self._render, range(len(RENDERED))))
        for name in ("mixed", "broken"):
            os.makedirs(self.photos(name))
        for name in ("cam01", "cam08"):
            for photo in sorted(os.listdir(self.photos(name))):
                shutil.copy(os.path.join(self.photos(name), photo), os.path.join(self.photos("mixed"), f"{name}_{photo}"))
        with open(os.path.join(self.photos("broken"), "a.png"), "wb") as file:
            file.write(content(os.path.join(self.photos("cam01"), "view_001.png"))[:500])
        with open(os.path.join(self.photos("broken"), "b.jpg"), "wb") as file:
            file.write(b"no image")
        os.mkdir(os.path.join(folder, "last"))
        for name, factor in (("steady", 1.0), ("drifted", 1.03)):
            text = content(os.path.join(folder, "scenes", name, "camera.yaml")).decode()
            if factor != 1.0:
                text = re.sub(r"(fx|fy): ([0-9.]+)", lambda m: f"{m[1]}: {float(m[2]) * factor}", text)
                text = re.sub(r"self_check:\n(  - .*\n)+", "", text)
            with open(os.path.join(folder, "last", name + ".yaml"), "w", encoding="utf-8") as file:
                file.write(text)

    def photos(self, name):
        return os.path.join(self.folder, "photos", name)

    def _render(self, i):
        os.makedirs(os.path.join(self.folder, "scenes"), exist_ok=True)
        os.makedirs(os.path.join(self.folder, "photos"), exist_ok=True)
        scene = os.path.join(self.folder, "scenes", RENDERED[i])
        with open(scene + ".yaml", "w", encoding="utf-8") as file:
            # One photograph more, for a later day.
            file.write(SCENE.format(focal=260 + 3 * i, cx=158 + 0.7 * i, seed=11 + i, views=NUM_VIEWS + (i == 1)))
        subprocess.run([self.program, "simulate", scene + ".yaml", "-o", scene, "--jobs", "1", "--quiet"], check=True)
        shutil.move(os.path.join(scene, "images"), self.photos(RENDERED[i]))
        if i == 1:
            shutil.move(os.path.join(self.photos("cam02"), f"view_{NUM_VIEWS + 1:03}.png"),
                        os.path.join(self.folder, "new.png"))

    def work(self, name, cameras=tuple(ALL)):
        """A new working folder with a table of these cameras."""
        return Work(self, os.path.join(self.folder, name), cameras)


class Work:
    """A working folder with cameras.csv, links to the photographs, and a program that logs its calls."""

    def __init__(self, fleet, folder, cameras):
        self.folder = folder
        self.cameras = list(cameras)
        os.mkdir(folder)
        os.mkdir(self.path("home"))
        os.symlink(os.path.join(fleet.folder, "photos"), self.path("photos"))
        os.symlink(os.path.join(fleet.folder, "last"), self.path("last"))
        with open(self.path("alidade"), "w", encoding="utf-8") as file:
            file.write(WRAPPER.format(folder=folder, program=fleet.program))
        os.chmod(self.path("alidade"), 0o755)
        with open(self.path("cameras.csv"), "w", encoding="utf-8") as file:
            file.write("id,images,board,model,tolerance,previous\n")
            for name in self.cameras:
                file.write(",".join(self.row(name)) + "\n")
        # Snakemake writes to the home folder, and asks less often for the state of jobs where CI is not set.
        self.environment = dict(os.environ, HOME=self.path("home"), XDG_CACHE_HOME=self.path("home"), CI="true",
                                PATH=folder + ":" + os.environ["PATH"])
        self.environment.pop("SNAKEMAKE_PROFILE", None)

    @staticmethod
    def row(name):
        model = "radtan" if name == "cam01" else ""
        tolerance = "0.5px" if name in ("cam03", "drifted") else ""
        previous = f"last/{name}.yaml" if name in ("steady", "drifted") else ""
        return name, f"photos/{name}", BOARD, model, tolerance, previous

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def command(self, *args, profile="local", config=()):
        return ["snakemake", "-s", os.path.join(WORKFLOW, "Snakefile"),
                *(["--profile", os.path.join(WORKFLOW, "profiles", profile)] if profile else []), *args,
                "--config", "table=cameras.csv", *config]

    def start(self, *args, environment=None, **options):
        """Starts the workflow in a process group of its own."""
        with open(self.path("printed"), "wb") as printed:
            return subprocess.Popen(self.command(*args, **options), cwd=self.folder, stdin=subprocess.DEVNULL,
                                    env=environment or self.environment, stdout=printed, stderr=subprocess.STDOUT,
                                    start_new_session=True, preexec_fn=end_with_parent)

    def run(self, *args, **options):
        """Runs the workflow; returns its exit code and what it printed."""
        run = self.start(*args, **options)
        code = run.wait(300)
        return code, self.printed()

    def printed(self):
        return content(self.path("printed")).decode(errors="replace")

    def calls(self):
        """The (step, camera) of each command since the last take_log(), in order. A search of a chunk has no camera."""
        calls = []
        if os.path.exists(self.path("log")):
            for line in content(self.path("log")).decode().splitlines():
                word = line.split(" ", 1)[0]
                if word in NAMED_FILE:
                    camera = re.search(rf"fleet/{NAMED_FILE[word]}/([\w-]+)\.", line)
                    calls.append((word, camera[1] if camera else "?"))
                elif word == "fleet":
                    calls.append((word, ""))
        return calls

    def take_log(self):
        """The same, and forgets them."""
        calls = self.calls()
        if os.path.exists(self.path("log")):
            os.remove(self.path("log"))
        return calls

    def set_trap(self, kind="", text=""):
        """Of all commands with this text from now on; without arguments: of none."""
        with open(self.path("trap"), "w", encoding="utf-8") as file:
            file.write(f"{kind} {text}\n" if kind else "")

    def set_row(self, name, **fields):
        """Replaces fields of the row of a camera in the table."""
        with open(self.path("cameras.csv"), encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        for row in rows:
            if row["id"] == name:
                row.update(fields)
        with open(self.path("cameras.csv"), "w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)

    def records(self):
        """The (step, camera) of each step that has ended."""
        steps = self.path("fleet", "steps")
        return {(step, camera) for camera in self.cameras if os.path.isdir(os.path.join(steps, camera))
                for step in os.listdir(os.path.join(steps, camera)) if step in NAMED_FILE}

    def outputs(self):
        """All files of the output by their path in it, but the cache, the lock and temporary ones."""
        found = {}
        for folder, folders, names in os.walk(self.path("fleet")):
            if folder == self.path("fleet") and "cache" in folders:
                folders.remove("cache")
            for name in names:
                if name.startswith(".") or name.endswith(".new"):
                    continue
                path = os.path.join(folder, name)
                found[os.path.relpath(path, self.path("fleet"))] = content(path)
        return found

    def leftovers(self):
        """Temporary files below the output, but in the cache: other runs may be writing there."""
        return [os.path.join(folder, name) for folder, _, names in os.walk(self.path("fleet")) for name in names
                if name.endswith((".new", ".tmp")) and not folder.startswith(self.path("fleet", "cache"))]

    def run_by_hand(self, program):
        """The single commands of docs/workflow.md, in this folder."""
        for name in ("corners", "calibrations", "evidence", "summaries", "differences", "reports", "previous"):
            os.makedirs(self.path("fleet", name))
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            usable = [name for name in pool.map(lambda name: self._by_hand(program, name), self.cameras) if name]
        previous = [name for name in usable if self.row(name)[5]]
        for name in previous:
            shutil.copy(self.path(self.row(name)[5]), self.path("fleet", "previous"))
        for page in ("fleet.csv", "fleet.html"):
            subprocess.run([program, "fleet", *(name + ".yaml" for name in usable),
                            "--previous", *(f"../previous/{name}.yaml" for name in previous), "-o", "../" + page],
                           cwd=self.path("fleet", "calibrations"), check=True, capture_output=True)

    def _by_hand(self, program, name):
        _, images, board, model, tolerance, previous = self.row(name)
        corners, camera, evidence = f"fleet/corners/{name}.csv", f"fleet/calibrations/{name}.yaml", f"fleet/evidence/{name}.json"
        accepted = ["--tolerance", tolerance or "1px"]

        def alidade(*args, printed=os.devnull):
            with open(self.path(printed), "wb") as file:
                return subprocess.run([program, *args], cwd=self.folder, stdout=file, stderr=subprocess.DEVNULL,
                                      check=False).returncode

        if alidade("detect", images, "--board", board, "--camera", name, "-o", corners) != 0:
            return None
        code = alidade("calibrate", corners, *(["--model", model] if model else []), *accepted, "--name", name, "-o", camera,
                       "--evidence", evidence, printed=f"fleet/summaries/{name}.txt")
        alidade("report", evidence, "-o", f"fleet/reports/{name}.html")
        if code == 0 and previous:
            alidade("diff", previous, camera, *accepted, "-o", f"fleet/differences/{name}.svg",
                    printed=f"fleet/differences/{name}.txt")
        return name if code == 0 else None
