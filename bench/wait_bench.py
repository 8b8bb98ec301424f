#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What people wait for: commands and calls beside those of others, against goals (bench/README.md).

usage: PYTHONPATH=build/python bench/wait_bench.py BUILD_FOLDER [GROUP]...

BUILD_FOLDER holds alidade and bench/ (-DALIDADE_BUILD_BENCH=ON). GROUP is one of start, photographs, whole, uneven, jobs,
rig, maps, memory and detection; without it all are measured. Times are CPU times on one thread unless the line says
otherwise, the least of some runs; those that take long run once. Goals in seconds are for the machine on which mrcal's
solve of 100 views takes 31 ms and findChessboardCornersSB 47 ms for 640x480; they are scaled by what these two take here.
What needs photographs is left out where these are missing. ALIDADE_REAL_DATA: see docs/real_data.md. Exit code 1: the
number of threads changes a result; missed goals are only printed.
"""
from __future__ import annotations

import math
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable

import alidade
import cv2
import numpy as np
import yaml

RADTAN = {"fx": 1003, "fy": 1001, "cx": 955, "cy": 604, "k1": -0.2, "k2": 0.08, "p1": 5e-4, "p2": -4e-4, "k3": -0.01}
SCENE = {
    "alidade_scene": 1,
    "camera": {"model": "radtan", "image_size": {"width": 1920, "height": 1200}, "parameters": RADTAN},
    "random": {"max_tilt_deg": 50, "max_roll_deg": 30, "min_fill": 0.4, "max_fill": 0.8, "margin_px": 4},
    "render": {"blur_px": 1.0},
    "corner_noise_px": 0.1,
}
PHOTOGRAPHS = "/usr/share/doc/opencv-doc/examples/data/left%02d.jpg"
NOISE_PX = 0.1
PEAK_FILE = os.path.join(tempfile.gettempdir(), f"alidade_wait_bench_{os.getpid()}.peak")

# Calibrates from photographs as OpenCV's documentation shows, and writes a file.
OPENCV_SCRIPT = """
import cv2, glob, numpy as np
cv2.setNumThreads(1)
points, pixels = [], []
board = np.zeros((54, 3), np.float32); board[:, :2] = 0.025 * np.mgrid[0:9, 0:6].T.reshape(-1, 2)
for name in sorted(glob.glob({pattern!r})):
    image = cv2.imread(name, cv2.IMREAD_GRAYSCALE)
    found, corners = cv2.findChessboardCorners(image, (9, 6))
    if not found: continue
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.001)
    points.append(board); pixels.append(cv2.cornerSubPix(image, corners, (5, 5), (-1, -1), criteria))
rms, K, distortion, *_ = cv2.calibrateCamera(points, pixels, image.shape[::-1], None, None)
cv2.FileStorage({output!r}, cv2.FILE_STORAGE_WRITE).write("K", K)
"""


def spent(command: list[str], runs: int = 3, allowed: tuple[int, ...] = (0, 3)) -> tuple[float, float, float]:
    """Returns the least CPU time and elapsed time of a command, s, and its peak memory, MB."""
    cpu = elapsed = math.inf
    peak = 0.0
    # A child's own peak, as the kernel reports it, begins with that of this process.
    timed = ["/usr/bin/time", "--format=%M", f"--output={PEAK_FILE}", *command]
    for _ in range(runs):
        start = time.perf_counter()
        process = subprocess.Popen(timed, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        message = process.stderr.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode not in allowed:
            sys.exit(f"{' '.join(command)}: exit {process.returncode}\n{message.decode()}")
        elapsed = min(elapsed, time.perf_counter() - start)
        cpu = min(cpu, usage.ru_utime + usage.ru_stime)
        with open(PEAK_FILE, encoding="utf-8") as file:
            peak = max(peak, float(file.read().split()[-1]) / 1024)
    return cpu, elapsed, peak


def growth(first: float, last: float, factor: float) -> float:
    return math.log(last / first) / math.log(factor)


class Bench:
    """Inputs in a scratch folder, the rows, and how fast this machine is."""

    def __init__(self, build: str, folder: str):
        self.build, self.folder = build, folder
        self.program = os.path.join(build, "alidade")
        self.real = os.environ.get("ALIDADE_REAL_DATA", "")
        self.slowness = 1.0
        self.is_broken = False

    def path(self, *names: str) -> str:
        return os.path.join(self.folder, *names)

    def row(self, name: str, ours: float, goal: float, unit: str = "s", beside: str = "", is_scaled: bool = False) -> None:
        """Prints a row. A goal in seconds (is_scaled) is for the machine that the goals were set on."""
        limit = goal * (self.slowness if is_scaled else 1)
        state = "met" if ours <= limit else f"{ours / limit:.2f} times the goal"
        print(f"{name:<46} {ours:9.4g} {unit:<3} goal {limit:8.3g}   {state:<22} {beside}", flush=True)

    def calibrate(self, corners: str, *flags: str) -> list[str]:
        return [self.program, "calibrate", corners, "--jobs", "1", "--quiet", *flags]

    # ---- inputs ----

    def corners_of(self, name: str, board: str, num_views: int, is_uneven: bool) -> str:
        """Returns the corners file of simulated views; uneven: the paper is stretched, wavy, and each point is off."""
        scene = SCENE | {"board": board, "views": {"random": num_views}, "seed": 5}
        with open(self.path(name + ".yaml"), "w", encoding="utf-8") as file:
            yaml.safe_dump(scene, file)
        subprocess.run([self.program, "simulate", self.path(name + ".yaml"), "-o", self.path(name), "--corners-only", "--quiet"],
                       check=True)
        file = self.path(name, "corners.csv")
        if is_uneven:
            self.make_uneven(name, file)
        return file

    def make_uneven(self, name: str, corners: str) -> None:
        camera = alidade.load_camera(self.path(name, "camera.yaml"))
        with open(self.path(name, "poses.yaml"), encoding="utf-8") as file:
            poses = {view["image"]: view["camera_from_board"] for view in yaml.safe_load(file)}
        random = np.random.default_rng(7)
        offsets: dict[int, np.ndarray] = {}
        with open(corners, encoding="utf-8") as file:
            lines = file.read().splitlines()
        for i, line in enumerate(lines[2:], 2):
            cells = line.split(",")
            square = float(re.search(r":([\d.]+)mm", cells[4]).group(1)) / 1e3
            place = square * np.array([float(cells[6]), float(cells[7]), 0])
            if int(cells[5]) not in offsets:
                wave = 2e-4 * math.sin(25 * place[0]) * math.sin(20 * place[1])
                offsets[int(cells[5])] = np.array([*random.normal(0, 3e-5, 2) + [1e-3 * place[0], 0], wave])
            pose = poses[cells[1]]
            x, y, z, w = pose["quaternion_xyzw"]
            turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                             [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                             [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
            point = turn @ (place + offsets[int(cells[5])]) + pose["translation_m"]
            pixel = camera.project(point[None])[0][0] + random.normal(0, NOISE_PX, 2)
            cells[8], cells[9] = map(repr, map(float, pixel))
            lines[i] = ",".join(cells)
        with open(corners, "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")

    # ---- rows ----

    def measure_machine(self) -> None:
        mrcal = self.solver("mrcal", 100)
        folder = self.path("yardstick")
        scene = SCENE | {"board": "checkerboard:9x6:25mm", "views": {"random": 1}, "seed": 7,
                         "camera": SCENE["camera"] | {"image_size": {"width": 640, "height": 480},
                                                      "parameters": RADTAN | {"fx": 544, "fy": 544, "cx": 320, "cy": 240}}}
        with open(folder + ".yaml", "w", encoding="utf-8") as file:
            yaml.safe_dump(scene, file)
        subprocess.run([self.program, "simulate", folder + ".yaml", "-o", folder, "--quiet"], check=True)
        image = cv2.imread(os.path.join(folder, "images", "view_001.png"), cv2.IMREAD_GRAYSCALE)
        times = []
        for _ in range(9):
            start = time.process_time()
            cv2.findChessboardCornersSB(image, (9, 6))
            times.append(time.process_time() - start)
        factors = [min(times) / 0.047] + ([mrcal[0] / 0.031] if mrcal else [])
        self.slowness = math.exp(sum(map(math.log, factors)) / len(factors))
        print(f"this machine takes {self.slowness:.2f} times as long as the one that the goals are for "
              f"({', '.join(f'{factor:.2f}' for factor in factors)})")

    def solver(self, case: str, num_views: int) -> tuple[float, float] | None:
        """Returns CPU s and peak MB of a case of solver_bench; nothing if a peer is not installed."""
        result = subprocess.run([os.path.join(self.build, "bench", "solver_bench"), "--case", case, str(num_views)],
                                capture_output=True, text=True)
        if result.returncode != 0 and case == "mrcal":
            return None
        if result.returncode != 0:
            sys.exit(f"solver_bench --case {case} {num_views}: {result.stderr}")
        ms, peak = result.stdout.split()[:2]
        return float(ms) / 1e3, float(peak)

    def uneven_boards(self) -> None:
        for num_views, board, goal in ((27, "checkerboard:13x9:20mm", None), (186, "checkerboard:10x10:20mm", 8.0)):
            corners = self.corners_of(f"uneven{num_views}", board, num_views, True)
            flat = spent(self.calibrate(corners, "--model", "radtan", "--board-shape", "flat"))
            auto = spent(self.calibrate(corners, "--model", "radtan"))
            name = f"uneven board, {num_views} views"
            self.row(name + ", auto", auto[0], goal or 4 * flat[0], beside=f"flat {flat[0]:.3g} s", is_scaled=goal is not None)
            self.row(name + ", peak memory", auto[2], 150, "MB")

    def real_rig(self) -> None:
        files = [os.path.join(self.real, "large_charuco_corners", f"cam{i}.csv") for i in (1, 2, 3)]
        if not self.real or not all(map(os.path.exists, files)):
            return
        rig = [self.program, "rig", "calibrate", *files, "--jobs", "1", "--quiet"]
        self.row("ChArUco 20x20, one camera, auto", spent(self.calibrate(files[0]), 1)[0], 6, is_scaled=True)
        self.row("ChArUco 20x20, rig of three", spent(rig, 1)[0], 20, is_scaled=True)

    def whole_calibration(self) -> None:
        for num_views, factor in ((100, 1.5), (1000, 0.7)):
            mrcal = self.solver("mrcal", num_views)
            if not mrcal:
                continue
            ours, solve = self.solver("calibrate", num_views), self.solver("solve", num_views)
            self.row(f"calibrate() of a flat board, {num_views} views", ours[0], factor * mrcal[0], beside=f"mrcal's solve {mrcal[0]:.3g} s, our solve {solve[0]:.3g} s")
        corners = self.corners_of("flat100", "checkerboard:10x7:30mm", 100, False)
        fixed, auto = spent(self.calibrate(corners, "--model", "radtan")), spent(self.calibrate(corners))
        self.row("model choice, 100 views", auto[0], 4 * fixed[0], beside=f"radtan {fixed[0]:.3g} s")

    def detection(self) -> None:
        goals = {("circles", "board"): 1, ("acircles", "board"): 1, ("aprilgrid", "texture"): 2, ("charuco", "texture"): 2,
                 ("aprilgrid", "board"): 2}
        output = subprocess.run([os.path.join(self.build, "bench", "detect_bench")], capture_output=True, text=True, check=True).stdout
        for line in output.splitlines():
            found = re.match(r" *(\d+)x\d+ *(\w+) +(board|texture) +([\d.]+) +([\d.]+) \d+/\d+ +(\S+) ([\d.]+)", line)
            if not found:
                continue
            width, target, shows = found.group(1), found.group(2), found.group(3)
            decoding, ours, peer = (float(found.group(i)) / 1e3 for i in (4, 5, 7))
            beside = f"decoding {1e3 * decoding:.3g}, {found.group(6)} {1e3 * peer:.3g} ms"
            name = f"detect {target} {width} {'found' if shows == 'board' else 'none'}"
            if (target, shows) in goals:
                self.row(name, 1e3 * ours, 1e3 * goals[target, shows] * peer, "ms", beside)
            elif target == "checkerboard" and width == "640":
                self.row(name, 1e3 * ours, 5, "ms", beside, is_scaled=True)

    def maps(self) -> None:
        output = subprocess.run([os.path.join(self.build, "bench", "undistort_bench"), "--benchmark_filter=^map/"],
                                capture_output=True, text=True, check=True).stdout
        output = re.sub(r"\x1b\[[0-9;]*m", "", output)  # colours
        for model in ("radtan", "kannala_brandt"):
            ours, *peers = (float(ms) for ms in re.findall(rf"map/{model}/\S+_median +[\d.]+ ms +([\d.]+) ms", output))
            self.row(f"map 1920x1200 {model}", ours, min(peers), "ms", f"OpenCV {min(peers):.3g} ms")

    def start(self) -> None:
        self.row("start (--version)", 1e3 * spent([self.program, "--version"], 20)[0], 10, "ms", is_scaled=True)

    def photographs(self) -> None:
        if not os.path.exists(PHOTOGRAPHS % 1):
            return
        pattern = PHOTOGRAPHS.replace("%02d", "[0-9][0-9]")
        runs = []
        for run in range(3):
            outputs = ["--jobs", "1", "-o", self.path(f"camera{run}.yaml"), "--report", self.path(f"page{run}.html")]
            runs.append(spent([self.program, "calibrate", pattern, "--board", "checkerboard:9x6:25mm", "--quiet", *outputs], 1)[0])
        script = OPENCV_SCRIPT.format(pattern=pattern, output=self.path("opencv.yaml"))
        peer = spent([sys.executable, "-c", script])
        self.row("13 photographs to file and page", min(runs), 0.4, beside=f"OpenCV's script {peer[0]:.3g} s", is_scaled=True)

    def memory(self) -> None:
        counts = (100, 300, 1000, 3000)
        bench = os.path.join(self.build, "bench", "solver_bench")
        taken = [spent([bench, "--case", "calibrate", str(n)], 1)[2] for n in counts]
        power = growth(taken[1] - taken[0], taken[3] - taken[2], 10)
        print(f"memory of calibrate(), {counts} views of 70: {', '.join(f'{mb:.0f}' for mb in taken)} MB, grows to the power of {power:.2f}")
        corners = self.corners_of("flat1000", "checkerboard:13x9:20mm", 1000, False)
        self.row("memory, 1000 views of 117, flat", spent(self.calibrate(corners, "--model", "radtan"), 1)[2], 400, "MB")

    def jobs(self) -> None:
        if (os.cpu_count() or 1) < 2:
            return
        corners = self.corners_of("jobs", "checkerboard:13x9:20mm", 60, True)
        elapsed, files = [], []
        for jobs in (1, 2):
            camera = self.path(f"jobs{jobs}.yaml")
            command = [self.program, "calibrate", corners, "--quiet", "--jobs", str(jobs), "--keep-untrustworthy"]
            subprocess.run([*command, "-o", camera], check=False)  # exits with 3 if the camera must not be used
            elapsed.append(spent(command)[1])
            with open(camera, "rb") as file:
                files.append(file.read())
        self.is_broken = self.is_broken or files[0] != files[1]
        self.row("60 views, time by the clock of two threads over one", elapsed[1] / elapsed[0], 1 / 1.7, "",
                 "same bytes" if files[0] == files[1] else "OTHER BYTES")

    def groups(self) -> dict[str, Callable[[], None]]:
        return {"start": self.start, "photographs": self.photographs, "whole": self.whole_calibration, "uneven": self.uneven_boards,
                "jobs": self.jobs, "rig": self.real_rig, "maps": self.maps, "memory": self.memory, "detection": self.detection}


def main() -> int:
    if len(sys.argv) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")  # of the commands
    cv2.setNumThreads(1)
    with tempfile.TemporaryDirectory(prefix="alidade_wait_bench") as folder:
        bench = Bench(os.path.abspath(sys.argv[1]), folder)
        groups = bench.groups()
        wanted = sys.argv[2:] or list(groups)
        if unknown := [name for name in wanted if name not in groups]:
            print(f"wait_bench: unknown group '{unknown[0]}'; expected {', '.join(groups)}", file=sys.stderr)
            return 2
        bench.measure_machine()
        for name in wanted:
            groups[name]()
        if os.path.exists(PEAK_FILE):
            os.remove(PEAK_FILE)
        return 1 if bench.is_broken else 0


if __name__ == "__main__":
    sys.exit(main())
