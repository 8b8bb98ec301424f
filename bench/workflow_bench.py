#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Throughput of workflow/ on this machine (bench/README.md): workflow_bench.py PROGRAM [REPETITIONS]

Photographs a second from files to corners, and cameras a second from corners to the page of the fleet, with one processor
and with all. Needs Snakemake and Debian's python3-opencv. Exits with 1 if a second processor gains less than 0.8 times what
it gains for the program alone.
"""
import concurrent.futures
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

import cv2

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
BOARD = "checkerboard:10x7:30mm"
NUM_RENDERED = 8
PHOTOS_PER_CAMERA = 12
VIEWS_PER_CAMERA = 50
JPEG_QUALITY = 95
LEAST_SHARE = 0.8
SCENE = """\
alidade_scene: 1
camera:
  model: radtan
  image_size: {{width: 4000, height: 3000}}
  parameters: {{fx: {focal}, fy: {focal}, cx: 2010, cy: 1490, k1: -0.28, k2: 0.08, p1: 0.0008, p2: -0.0004, k3: -0.01}}
board: {board}
views: {{random: {views}}}
seed: {seed}
random: {{max_tilt_deg: 50, max_roll_deg: 30, min_fill: 0.4, max_fill: 0.8, margin_px: 4}}
render: {{blur_px: 1.0, read_noise: 1.5, full_well_electrons: 10000, dark_level: 30, bright_level: 220,
         background_level: 110, border_square: 1, falloff: 0.2, vignetting_exponent: 4}}
corner_noise_px: 0.1
"""


class Bench:
    """Scratch folders, and timed runs of the workflow in them."""

    def __init__(self, folder, program):
        self.folder = folder
        self.program = os.path.abspath(program)
        self.num_cameras = 4 * max(2, os.cpu_count())

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def simulate(self, name, *flags, **scene):
        with open(self.path(name + ".yaml"), "w", encoding="utf-8") as file:
            file.write(SCENE.format(board=BOARD, **scene))
        subprocess.run([self.program, "simulate", self.path(name + ".yaml"), "-o", self.path(name), "--quiet", *flags], check=True)

    def take_photos(self):
        """JPEG files of a few renderings. A comment makes each file unique, so that no search is saved by the cache."""
        self.simulate("rendered", focal=3340, seed=3, views=NUM_RENDERED)
        rendered = []
        for i in range(NUM_RENDERED):
            image = cv2.imread(self.path("rendered", "images", f"view_{i + 1:03}.png"), cv2.IMREAD_GRAYSCALE)
            rendered.append(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes())
        for camera in range(self.num_cameras):
            os.makedirs(self.path("photos", f"cam{camera}"))
            for photo in range(PHOTOS_PER_CAMERA):
                text = f"{camera} {photo}".encode()
                comment = b"\xff\xfe" + (len(text) + 2).to_bytes(2, "big") + text
                jpeg = rendered[(camera + photo) % NUM_RENDERED]
                with open(self.path("photos", f"cam{camera}", f"{photo}.jpg"), "wb") as file:
                    file.write(jpeg[:2] + comment + jpeg[2:])
        self.write_table("photos")

    def take_corners(self):
        """True corners with noise, without photographs."""
        for camera in range(self.num_cameras):
            os.makedirs(self.path("none", f"cam{camera}"))
            self.simulate(f"cam{camera}", "--corners-only", focal=3300 + 10 * camera, seed=camera, views=VIEWS_PER_CAMERA)
        self.write_table("none")

    def write_table(self, folder):
        with open(self.path(folder + ".csv"), "w", encoding="utf-8") as file:
            file.write("id,images,board\n")
            file.writelines(f"cam{i},{folder}/cam{i},{BOARD}\n" for i in range(self.num_cameras))

    def snakemake(self, table, *args, config=()):
        subprocess.run(["snakemake", "-s", os.path.join(ROOT, "workflow", "Snakefile"), "--profile",
                        os.path.join(ROOT, "workflow", "profiles", "local"), *args, "--config", f"table={table}.csv",
                        f"alidade={self.program}", *config], cwd=self.folder, check=True, capture_output=True)

    def timed(self, cores, table, *args, config=()):
        """Seconds of elapsed time and of processor time."""
        before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
        self.snakemake(table, "--cores", str(cores), *args, config=config)
        elapsed, after = time.monotonic() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
        return elapsed, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime

    def plain(self, cores):
        """The same searches by the program alone, one process for each processor: what the machine itself can gain."""
        before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
        with concurrent.futures.ThreadPoolExecutor(cores) as pool:
            list(pool.map(lambda i: subprocess.run(
                [self.program, "detect", f"photos/cam{i}", "--board", BOARD, "--jobs", "1", "--quiet", "-o", "/dev/null"],
                cwd=self.folder, check=True), range(self.num_cameras)))
        elapsed, after = time.monotonic() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
        return elapsed, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime

    def detect(self, cores):
        """All steps up to the corners; nothing is known from the run before."""
        shutil.rmtree(self.path("fleet"), ignore_errors=True)
        return self.timed(cores, "photos", "--until", "detect", config=["threads=1"])

    def calibrate(self, cores):
        """All steps from the corners on."""
        shutil.rmtree(self.path("fleet"), ignore_errors=True)
        self.snakemake("none", "--until", "detect")  # finds no photographs
        for camera in range(self.num_cameras):
            record = self.path("fleet", "steps", f"cam{camera}", "detect")
            with open(record, encoding="utf-8") as file:
                inputs = file.read().splitlines()[1]
            shutil.copy(self.path(f"cam{camera}", "corners.csv"), self.path("fleet", "corners", f"cam{camera}.csv"))
            with open(record, "w", encoding="utf-8") as file:
                file.write(f"0\n{inputs}\n")
        taken = self.timed(cores, "none")
        with open(self.path("fleet", "cameras.csv"), encoding="utf-8") as file:
            num_calibrated = file.read().count(",calibrated,")
        if num_calibrated != self.num_cameras:
            sys.exit(f"{num_calibrated} of {self.num_cameras} cameras were calibrated")
        return taken


def main():
    repetitions = int(sys.argv[2]) if len(sys.argv) > 2 else 3
    counts = sorted({1, 2, os.cpu_count()} & set(range(1, os.cpu_count() + 1)))
    gains = []
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(folder, sys.argv[1])
        bench.take_photos()
        bench.take_corners()
        print(f"medians of {repetitions} runs on {os.cpu_count()} processors; {bench.num_cameras} cameras")
        photos = bench.num_cameras * PHOTOS_PER_CAMERA
        cases = [("files to corners, program alone", bench.plain, photos, "photograph"),
                 ("files to corners, workflow", bench.detect, photos, "photograph"),
                 (f"corners of {VIEWS_PER_CAMERA} views to pages", bench.calibrate, bench.num_cameras, "camera")]
        taken = {(case[0], cores): [] for case in cases for cores in counts}
        for _ in range(repetitions):  # in turns, because other work on the machine comes and goes
            for name, run, _, _ in cases:
                for cores in counts:
                    taken[name, cores].append(run(cores))
    for name, _, number, unit in cases:
        for cores in counts:
            elapsed, processor = (statistics.median(times) for times in zip(*taken[name, cores]))
            gain = statistics.median(one[0] / run[0] for one, run in zip(taken[name, 1], taken[name, cores]))
            print(f"{name:<32} {cores} processors: {number / elapsed:6.2f} {unit}s/s, {number / elapsed / cores:6.2f} per "
                  f"processor; {processor / number:.3f} s of processor time per {unit}; {gain:.2f} times as fast as one")
            if cores == 2:
                gains.append(gain)
    # Of what the program alone gains in the same run: the machine may have other work.
    return 0 if all(gain >= LEAST_SHARE * gains[0] for gain in gains[1:]) else 1


if __name__ == "__main__":
    sys.exit(main())
