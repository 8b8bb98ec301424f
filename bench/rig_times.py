#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Rigs of webcams that are not triggered together, simulated: errors of the cameras' places by `alidade rig calibrate` and by
OpenCV (cameras one by one, then pairs with the first one).

usage: rig_times.py PROGRAM [SETS]

Four cameras of about 900 px (radtan) stand on an arc, 1 m from a ChArUco board of 12 corners that moves by 0.3 m/s; 45 frames,
6 a second; corner noise 0.06 px. One row for each jitter of the exposures and largest delay of a camera.
"""
import os
import subprocess
import sys
import tempfile

import cv2
import numpy as np
import yaml

COLUMNS, ROWS, SQUARE = 4, 5, 0.054
BOARD = f"charuco:{COLUMNS}x{ROWS}:54mm:40.5mm:DICT_4X4_1000"
SIZE = (1280, 720)
NUM_CAMERAS, NUM_FRAMES, FRAME_RATE, SPEED, NOISE = 4, 45, 6.0, 0.3, 0.06
POINTS = np.array([[(i + 1) * SQUARE, (j + 1) * SQUARE, 0] for j in range(ROWS - 1) for i in range(COLUMNS - 1)])


def rotation(vector):
    return cv2.Rodrigues(np.asarray(vector, float))[0]


def waved(random):
    """The pose of the board by time: sums of sines, at SPEED on average."""
    def wave(size):
        rate, phase = 2 * np.pi * random.uniform(0.1, 0.5, 4), random.uniform(0, 2 * np.pi, 4)
        height = random.normal(size=4) / 2 * size * 1.4
        return lambda t: (height * np.sin(rate * t + phase)).sum()
    shifts, turns = [wave(s) for s in (0.20, 0.12, 0.15)], [wave(s) for s in (0.5, 0.5, 0.4)]
    def place(t):
        return np.array([shift(t) for shift in shifts])
    times = np.linspace(0, NUM_FRAMES / FRAME_RATE, 200)
    speed = np.mean([np.linalg.norm(place(t + 1e-3) - place(t - 1e-3)) / 2e-3 for t in times])
    scale = SPEED / speed
    return lambda t: (rotation([turn(t * scale) for turn in turns]), place(t * scale))


def simulated(seed, jitter, most_delay):
    """The true cameras (rotation, translation) and the views of each: corners by frame."""
    random = np.random.default_rng(seed)
    pose = waved(random)
    cameras, all_views = [], []
    for camera in range(NUM_CAMERAS):
        angle = (camera - (NUM_CAMERAS - 1) / 2) * np.deg2rad(25) + 0.03 * random.normal()
        turn = rotation([0, -angle, 0]) @ rotation(0.05 * random.normal(size=3))
        shift = np.array([0, 0, 1 + 0.05 * random.normal()])
        focal = 900 * (1 + 0.02 * random.normal())
        centre = np.array(SIZE) / 2 + 10 * random.normal(size=2)
        k1, k2 = -0.3 + 0.05 * random.normal(), 0.1 + 0.03 * random.normal()
        delay = most_delay * random.uniform(-1, 1) if camera > 0 else 0
        views = {}
        for frame in range(NUM_FRAMES):
            board_turn, board_shift = pose(frame / FRAME_RATE + delay + jitter * random.normal())
            x = (POINTS - POINTS.mean(0)) @ (turn @ board_turn).T + turn @ board_shift + shift
            middle, normal = turn @ board_shift + shift, (turn @ board_turn)[:, 2]
            if x[:, 2].min() < 0.1 or normal @ middle < 0.35 * np.linalg.norm(middle):
                continue
            x = x[:, :2] / x[:, 2:]
            square = (x**2).sum(1)
            pixels = focal * x * (1 + k1 * square + k2 * square**2)[:, None] + centre
            seen = ((pixels > 2) & (pixels < np.array(SIZE) - 3)).all(1)
            pixels += NOISE * random.normal(size=pixels.shape)
            if seen.sum() >= 8:
                views[frame] = (np.nonzero(seen)[0], pixels[seen])
        cameras.append((turn, shift))
        all_views.append(views)
    return cameras, all_views


def write_corners(path, views):
    with open(path, "w", encoding="utf-8") as file:
        file.write("camera,image,width,height,board,corner_id,col,row,u,v,sigma_px\n")
        for frame, (ids, pixels) in views.items():
            for i, (u, v) in zip(ids, pixels):
                column, row = i % (COLUMNS - 1), i // (COLUMNS - 1)
                file.write(f"camera,f{frame:03}.png,{SIZE[0]},{SIZE[1]},{BOARD},{i},{column},{row},{u:.6f},{v:.6f},\n")


def by_alidade(program, all_views):
    with tempfile.TemporaryDirectory() as folder:
        paths = [os.path.join(folder, f"cam{c}.csv") for c in range(NUM_CAMERAS)]
        for path, views in zip(paths, all_views):
            write_corners(path, views)
        output = os.path.join(folder, "rig.yaml")
        subprocess.run([program, "rig", "calibrate", *paths, "--board", BOARD, "--keep-untrustworthy", "--quiet", "-o", output],
                       check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        if not os.path.exists(output):
            return None, "none"
        with open(output, encoding="utf-8") as file:
            rig = yaml.safe_load(file)
    places = []
    for camera in rig["cameras"]:
        x, y, z, w = camera["camera_from_rig"]["quaternion_xyzw"]
        turn = rotation(np.array([x, y, z]) * 2 * np.arctan2(np.linalg.norm([x, y, z]), w) / max(np.linalg.norm([x, y, z]), 1e-12))
        places.append(-turn.T @ np.array(camera["camera_from_rig"]["translation_m"]))
    return np.array(places), rig["calibration"]["verdict"] if "calibration" in rig else str(rig.get("verdict"))


def by_opencv(all_views):
    lenses = []
    for views in all_views:
        points = [POINTS[ids].astype(np.float32) for ids, _ in views.values()]
        pixels = [pixels.astype(np.float32) for _, pixels in views.values()]
        _, matrix, distortion, _, _ = cv2.calibrateCamera(points, pixels, SIZE, None, None)
        lenses.append((matrix, distortion))
    places = [np.zeros(3)]
    for other in range(1, NUM_CAMERAS):
        points, ours, theirs = [], [], []
        for frame in sorted(set(all_views[0]) & set(all_views[other])):
            (ids_a, a), (ids_b, b) = all_views[0][frame], all_views[other][frame]
            common = np.intersect1d(ids_a, ids_b)
            if len(common) >= 6:
                points.append(POINTS[common].astype(np.float32))
                ours.append(a[np.isin(ids_a, common)].astype(np.float32))
                theirs.append(b[np.isin(ids_b, common)].astype(np.float32))
        result = cv2.stereoCalibrate(points, ours, theirs, *lenses[0], *lenses[other], SIZE, flags=cv2.CALIB_FIX_INTRINSIC)
        places.append(-result[5].T @ result[6].ravel())
    return np.array(places)


def rms_mm(places, cameras):
    """RMS distance of the other cameras from their true places, in the frame of the first one."""
    turn, shift = cameras[0]
    truth = np.array([turn @ (-own_turn.T @ own_shift) + shift for own_turn, own_shift in cameras])
    return 1e3 * np.sqrt(((places - truth)[1:] ** 2).sum(1).mean())


def main():
    program, num_sets = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 5
    print("jitter  delay    alidade, RMS (median)    OpenCV, RMS (median)   ratio of RMS   verdicts")
    for jitter, delay in ((0, 0), (0.001, 0), (0.003, 0), (0.01, 0), (0.001, 0.02), (0.003, 0.1)):
        ours, theirs, verdicts = [], [], []
        for seed in range(1, num_sets + 1):
            cameras, views = simulated(seed, jitter, delay)
            places, verdict = by_alidade(program, views)
            verdicts.append(verdict)
            if places is not None:
                ours.append(rms_mm(places, cameras))
                theirs.append(rms_mm(by_opencv(views), cameras))
        a, b = (np.sqrt(np.mean(np.square(errors))) for errors in (ours, theirs))
        print(f"{1e3 * jitter:4.0f} ms {1e3 * delay:4.0f} ms {a:9.2f} ({np.median(ours):.2f}) mm {b:16.2f} ({np.median(theirs):.2f}) mm "
              f"{a / b:12.2f}   {({v: verdicts.count(v) for v in sorted(set(verdicts))})}", flush=True)


if __name__ == "__main__":
    main()
