#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Compares the Python module with cv2 on a million points, and with the C++ batch calls behind it.

usage: PYTHONPATH=build/python bench/python_bench.py [PROJECT_BENCH]

PROJECT_BENCH is build/bench/project_bench (-DALIDADE_BUILD_BENCH=ON). Times are the shortest of five runs on one thread
each, unless the line says otherwise. Exit code 1: a ratio misses its limit, which stands beside it.
"""
from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable

import alidade
import cv2
import numpy as np

NUM_POINTS = 1_000_000
NUM_RUNS = 5
PARAMETERS = {"fx": 1200, "fy": 1210, "cx": 959.5, "cy": 599.5, "k1": -0.28, "k2": 0.09, "p1": 0.0008, "p2": -0.0004, "k3": -0.01}


def seconds(call: Callable[[], object]) -> float:
    """Returns the shortest time of a call."""
    times = []
    for _ in range(NUM_RUNS):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return min(times)


def peak_mb() -> float:
    """Returns the largest memory that the process has had so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def batch_seconds(program: str, case: str) -> float:
    """Returns the time of a case of project_bench, which has as many points."""
    run = subprocess.run([program, f"--benchmark_filter=^{case}$", "--benchmark_format=json"], capture_output=True, text=True, check=True)
    for measured in json.loads(run.stdout[run.stdout.index("{"):])["benchmarks"]:
        if measured.get("aggregate_name", "median") == "median":
            return measured["real_time"] * {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1}[measured["time_unit"]]
    raise ValueError(f"{program} has no case {case}")


def main() -> int:
    cv2.setNumThreads(1)
    camera = alidade.Camera("radtan", (1920, 1200), PARAMETERS)
    matrix = np.array([[PARAMETERS["fx"], 0, PARAMETERS["cx"]], [0, PARAMETERS["fy"], PARAMETERS["cy"]], [0, 0, 1]], float)
    distortion = np.array([PARAMETERS[name] for name in ("k1", "k2", "p1", "p2", "k3")])
    rng = np.random.default_rng(1)
    points = camera.unproject(rng.uniform([0, 0], [1919, 1199], (NUM_POINTS, 2)))[0] * rng.uniform(0.5, 5, (NUM_POINTS, 1))
    zero = np.zeros(3)
    failed = 0

    def report(name: str, value: float, limit: float, is_least: bool) -> None:
        nonlocal failed
        is_good = value >= limit if is_least else value <= limit
        failed += not is_good
        print(f"{name:<58} {value:8.2f}   {'at least' if is_least else 'at most'} {limit:g}{'' if is_good else '   MISSED'}")

    before = peak_mb()
    pixels, status = camera.project(points)
    arrays = (points.nbytes + pixels.nbytes + status.nbytes) / 2**20
    after = peak_mb()
    # The points were there before; anything the call takes beyond its results is a copy.
    report("memory: peak of project() over its arrays", ((after - before) + points.nbytes / 2**20) / arrays, 2, False)
    own = seconds(lambda: camera.project(points))
    other = seconds(lambda: cv2.projectPoints(points, zero, zero, matrix, distortion))
    report("project: time of cv2.projectPoints over project()", other / own, 8, True)
    print(f"{'  its largest difference in px':<58} {np.abs(cv2.projectPoints(points, zero, zero, matrix, distortion)[0][:, 0] - pixels).max():.1e}")
    posed = seconds(lambda: camera.project(points, np.eye(4)))
    if len(sys.argv) > 1:
        batch = batch_seconds(sys.argv[1], "radtan/project/alidade")
        report("project with a pose: time of project() over projectBatch()", posed / batch, 1.3, False)
    threads = os.cpu_count() or 1
    shared = seconds(lambda: camera.project(points, jobs=0))
    print(f"{f'project: {threads} threads are faster than one by a factor of':<58} {own / shared:8.2f}")

    own = seconds(lambda: camera.unproject(pixels))
    exact = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 1000, 1e-9)
    iterate = lambda: cv2.undistortPointsIter(pixels, matrix, distortion, None, None, exact)
    other = seconds(iterate)
    report("unproject: time of cv2.undistortPointsIter over unproject()", other / own, 20, True)
    plane = iterate()[:, 0]
    rays = camera.unproject(pixels)[0]
    for name, given in (("cv2", np.column_stack([plane, np.ones(len(plane))])), ("alidade", rays)):
        print(f"{f'  largest error of {name} in px':<58} {np.abs(camera.project(given)[0] - pixels).max():.1e}")
    shared = seconds(lambda: camera.unproject(pixels, jobs=0))
    print(f"{f'unproject: {threads} threads are faster than one by a factor of':<58} {own / shared:8.2f}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
