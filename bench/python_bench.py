#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Compares the Python module with cv2 on a million points, and with the C++ batch calls behind it.

usage: PYTHONPATH=build/python bench/python_bench.py [BATCH_CALLS]

BATCH_CALLS is build/bench/libbatch_calls.so (-DALIDADE_BUILD_BENCH=ON): projectBatch(), called in turns with project() in
this process, so that what else the machine does slows both. Times are CPU times on one thread each, medians of nine runs,
unless the line says otherwise. cv2.projectPoints() always computes Jacobians, which project() does not. Exit code 1: a
ratio misses its limit, which stands beside it.
"""
from __future__ import annotations

import ctypes
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable

import alidade
import cv2
import numpy as np

NUM_POINTS = 1_000_000
NUM_RUNS = 9
PARAMETERS = {"fx": 1200, "fy": 1210, "cx": 959.5, "cy": 599.5, "k1": -0.28, "k2": 0.09, "p1": 0.0008, "p2": -0.0004, "k3": -0.01}


def seconds(call: Callable[[], object], clock: Callable[[], float] = time.process_time) -> float:
    """Returns the median CPU time of a call; of a call with threads, the elapsed time."""
    times = []
    for _ in range(NUM_RUNS):
        start = clock()
        call()
        times.append(clock() - start)
    return statistics.median(times)


# Prints by how many bytes the memory of a process grows at most in one call, beyond what it had before.
MEMORY = """
import numpy as np, alidade
def kilobytes(key):
    return int(next(line for line in open("/proc/self/status") if line.startswith(key)).split()[1])
camera = alidade.Camera("radtan", (1920, 1200), {parameters})
points = np.full(({count}, 3), 0.5) + [0, 0, 1]
camera.project(points[:1000])
open("/proc/self/clear_refs", "w").write("5")  # the peak is what there is now
before = kilobytes("VmRSS:")
pixels, status = camera.project(points)
print(1024 * (kilobytes("VmHWM:") - before) + points.nbytes, points.nbytes + pixels.nbytes + status.nbytes)
"""


def ratio_in_turns(call: Callable[[], object], other: Callable[[], object]) -> float:
    """Returns the median ratio of the CPU times of two calls that follow each other."""
    ratios = []
    for _ in range(5 * NUM_RUNS):
        times = [time.process_time()]
        for each in (call, other):
            each()
            times.append(time.process_time())
        ratios.append((times[1] - times[0]) / (times[2] - times[1]))
    return statistics.median(ratios)


class BatchCalls:
    """projectBatch() on the same points, one array a coordinate, as C++ stores them."""

    def __init__(self, library: str, points: np.ndarray) -> None:
        self._library = ctypes.CDLL(os.path.abspath(library))
        self._library.newBatchScene.restype = ctypes.c_void_p
        numbers = ctypes.POINTER(ctypes.c_double)
        params = np.array(list(PARAMETERS.values()), float)
        self._scene = ctypes.c_void_p(self._library.newBatchScene(
            params.ctypes.data_as(numbers), points.ctypes.data_as(numbers), ctypes.c_size_t(len(points))))

    def into_kept(self, with_pose: bool) -> None:
        """Into the same arrays in each call."""
        self._library.projectIntoKept(self._scene, ctypes.c_bool(with_pose))

    def into_new(self, with_pose: bool) -> None:
        """Into new vectors in each call."""
        self._library.projectIntoNew(self._scene, ctypes.c_bool(with_pose))


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
        print(f"{name:<66} {value:8.2f}   {'at least' if is_least else 'at most'} {limit:g}{'' if is_good else '   MISSED'}")

    memory = subprocess.run([sys.executable, "-c", MEMORY.format(parameters=PARAMETERS, count=NUM_POINTS)], capture_output=True,
                            text=True, check=True)
    taken, arrays = map(int, memory.stdout.split())
    report("memory: peak of project() over its arrays", taken / arrays, 2, False)
    pixels, status = camera.project(points)
    own = seconds(lambda: camera.project(points))
    other = seconds(lambda: cv2.projectPoints(points, zero, zero, matrix, distortion))
    report("project: time of cv2.projectPoints over project()", other / own, 8, True)
    print(f"{'  its largest difference in px':<66} {np.abs(cv2.projectPoints(points, zero, zero, matrix, distortion)[0][:, 0] - pixels).max():.1e}")
    if len(sys.argv) > 1:
        batch = BatchCalls(sys.argv[1], points)
        for words, pose in (("", None), (" with a pose", np.eye(4))):
            report(f"project(){words}: time over projectBatch() to new vectors",
                   ratio_in_turns(lambda: camera.project(points, pose), lambda: batch.into_new(pose is not None)), 1.3, False)
            report(f"project(out=){words}: over projectBatch() to the same vectors",
                   ratio_in_turns(lambda: camera.project(points, pose, out=(pixels, status)), lambda: batch.into_kept(pose is not None)), 1.3, False)
            print(f"{'  new arrays over the same vectors':<66} {ratio_in_turns(lambda: camera.project(points, pose), lambda: batch.into_kept(pose is not None)):8.2f}")
    threads = os.cpu_count() or 1
    alone, shared = (seconds(lambda: camera.project(points, jobs=jobs), time.perf_counter) for jobs in (1, 0))
    print(f"{f'project: {threads} threads are faster than one by a factor of':<66} {alone / shared:8.2f}")
    own = seconds(lambda: camera.project_with_jacobians(points, np.eye(4)))
    report("Jacobians: time of cv2.projectPoints over all of ours", other / own, 3, True)

    own = seconds(lambda: camera.unproject(pixels))
    exact = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 1000, 1e-9)
    iterate = lambda: cv2.undistortPointsIter(pixels, matrix, distortion, None, None, exact)
    other = seconds(iterate)
    report("unproject: time of cv2.undistortPointsIter over unproject()", other / own, 20, True)
    plane = iterate()[:, 0]
    rays = camera.unproject(pixels)[0]
    for name, given in (("cv2", np.column_stack([plane, np.ones(len(plane))])), ("alidade", rays)):
        print(f"{f'  largest error of {name} in px':<66} {np.abs(camera.project(given)[0] - pixels).max():.1e}")
    alone, shared = (seconds(lambda: camera.unproject(pixels, jobs=jobs), time.perf_counter) for jobs in (1, 0))
    print(f"{f'unproject: {threads} threads are faster than one by a factor of':<66} {alone / shared:8.2f}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
