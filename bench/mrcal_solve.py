# SPDX-License-Identifier: MIT
"""Solves what mrcal_input.cc writes to standard input with mrcal and prints CPU ms, peak MB, RMS and fx.

Input: a line "columns rows spacing width height cameras frames views repetitions"; for each camera a line with
fx fy cx cy k1 k2 p1 p2 k3 and its pose camera_from_rig (rotation vector, translation); for each frame a line with
rig_from_board; for each view a line with its frame, its camera, and u v weight of all corners, row by row (weight
-1: not seen).
"""
import resource
import sys
import time

import mrcal
import numpy as np


def main():
    lines = sys.stdin.read().splitlines()
    head = [float(word) for word in lines[0].split()]
    columns, rows, spacing, width, height = int(head[0]), int(head[1]), head[2], int(head[3]), int(head[4])
    num_cameras, num_frames, num_views, repetitions = map(int, head[5:])
    numbers = [np.array(line.split(), dtype=float) for line in lines[1:]]
    cameras = np.array(numbers[:num_cameras])
    frames = np.array(numbers[num_cameras : num_cameras + num_frames])
    views = np.array(numbers[num_cameras + num_frames :])
    observations = views[:, 2:].reshape(num_views, rows, columns, 3)
    indices = np.zeros((num_views, 3), dtype=np.int32)
    indices[:, 0] = views[:, 0]
    indices[:, 1] = views[:, 1]
    indices[:, 2] = views[:, 1] - 1
    order = np.lexsort((indices[:, 1], indices[:, 0]))  # mrcal wants frames in order
    indices, observations = indices[order], observations[order]
    times = []
    for _ in range(repetitions):
        solved = cameras[:, :9].copy()
        arguments = dict(
            intrinsics=solved,
            extrinsics_rt_fromref=cameras[1:, 9:].copy(),
            frames_rt_toref=frames.copy(),
            points=None,
            observations_board=observations.copy(),
            indices_frame_camintrinsics_camextrinsics=indices.copy(),
            observations_point=None,
            indices_point_camintrinsics_camextrinsics=None,
            lensmodel="LENSMODEL_OPENCV5",
            imagersizes=np.array([[width, height]] * num_cameras, dtype=np.int32),
            calibration_object_spacing=spacing,
            do_optimize_calobject_warp=False,
            do_apply_regularization=False,
            do_apply_outlier_rejection=False,
        )
        start = time.process_time()
        stats = mrcal.optimize(**arguments)
        times.append(time.process_time() - start)
        residuals = stats["x"][: num_views * rows * columns * 2].reshape(-1, 2)
    seen = observations[..., 2].ravel() > 0
    rms = np.sqrt(np.mean(np.sum(residuals[seen] ** 2, axis=1)))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(1000 * min(times), peak, rms, solved[0, 0])


main()
