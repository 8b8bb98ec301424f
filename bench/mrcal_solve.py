# SPDX-License-Identifier: MIT
"""Solves what solver_bench writes to standard input with mrcal and prints CPU ms, peak MB, RMS and fx.

Input: a line "columns rows spacing width height views repetitions", a line with fx fy cx cy k1 k2 p1 p2 k3, and
for each view a line with the board's pose in the camera frame (rotation vector, translation) and one with u v of
all corners, row by row.
"""
import resource
import sys
import time

import mrcal
import numpy as np


def main():
    lines = sys.stdin.read().splitlines()
    columns, rows, spacing, width, height, num_views, repetitions = map(float, lines[0].split())
    columns, rows, num_views = int(columns), int(rows), int(num_views)
    intrinsics = np.array([lines[1].split()], dtype=float)
    poses = np.array([line.split() for line in lines[2::2]], dtype=float)
    pixels = np.array([line.split() for line in lines[3::2]], dtype=float).reshape(num_views, rows, columns, 2)
    observations = np.concatenate([pixels, np.ones((num_views, rows, columns, 1))], axis=-1)
    indices = np.zeros((num_views, 3), dtype=np.int32)
    indices[:, 0] = np.arange(num_views)
    indices[:, 2] = -1
    times = []
    for _ in range(int(repetitions)):
        solved = intrinsics.copy()
        arguments = dict(
            intrinsics=solved,
            extrinsics_rt_fromref=np.zeros((0, 6)),
            frames_rt_toref=poses.copy(),
            points=None,
            observations_board=observations.copy(),
            indices_frame_camintrinsics_camextrinsics=indices,
            observations_point=None,
            indices_point_camintrinsics_camextrinsics=None,
            lensmodel="LENSMODEL_OPENCV5",
            imagersizes=np.array([[width, height]], dtype=np.int32),
            calibration_object_spacing=spacing,
            do_optimize_calobject_warp=False,
            do_apply_regularization=False,
            do_apply_outlier_rejection=False,
        )
        start = time.process_time()
        stats = mrcal.optimize(**arguments)
        times.append(time.process_time() - start)
        residuals = stats["x"][: num_views * rows * columns * 2]
    rms = np.sqrt(2 * np.mean(residuals**2))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(1000 * min(times), peak, rms, solved[0, 0])


main()
