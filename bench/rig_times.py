#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Rigs of webcams that are not triggered together, simulated: errors of the cameras' places by `alidade rig calibrate` and by
OpenCV (cameras one by one, then pairs along a tree), and what is said of faults.

usage: rig_times.py PROGRAM [SETS [FIRST_SEED [FAULT]]]

Each set draws the number of cameras (3 to 8), an arc or a ring of 1 m radius, the image size, the board (12 to 35 corners), its mean
speed (0.1 to 1 m/s), the frame rate (6 to 60 a second, of which 6 to 8 a second are used), the jitter of the exposures (0 to 10 ms)
and the largest delay of a camera (0 to 100 ms). FAULT: moved (a camera, by 2 mm, from the middle on), instant (one view is of
another time), swapped (two cameras, from the middle on) or zoom (by 3 %, from the middle on); jitter is then 3 ms.
"""
import json
import os
import subprocess
import sys
import tempfile

import cv2
import numpy as np

NOISE_PX = 0.06
FACTORS = {"cameras": range(3, 9), "ring": (False, True), "size": ((640, 480), (1280, 720), (1920, 1080)),
           "board": ((4, 5), (5, 6), (6, 8)), "speed": (0.1, 0.3, 1.0), "rate": (6.0, 30.0, 60.0),
           "jitter": (0, 0.001, 0.003, 0.01), "delay": (0, 0.02, 0.1)}


def rotation(vector):
    return cv2.Rodrigues(np.asarray(vector, float))[0]


def waved(random, speed, seconds, swing):
    """The pose of the board by time: sums of sines, at `speed` on average, and turned towards the cameras within +- `swing`."""
    def wave(size):
        rate, phase = 2 * np.pi * random.uniform(0.1, 0.5, 4), random.uniform(0, 2 * np.pi, 4)
        height = random.normal(size=4) / 2 * size * 1.4
        return lambda t: (height * np.sin(rate * t + phase)).sum()
    shifts, turns = [wave(s) for s in (0.20, 0.12, 0.15)], [wave(s) for s in (0.5, 0.5, 0.4)]
    velocity = [[(shift(t + 1e-3) - shift(t - 1e-3)) / 2e-3 for shift in shifts] for t in np.linspace(0, 10, 200)]
    scale = speed / np.linalg.norm(velocity, axis=1).mean()
    times = np.clip(seconds * scale / 10, 1, 3)
    return lambda t: (rotation([0, -swing * np.sin(2 * np.pi * times * t / seconds), 0]) @
                      rotation([turn(t * scale) for turn in turns]), np.array([shift(t * scale) for shift in shifts]))


class Set:
    """The true cameras of a set, and the corners in their views by frame."""

    def __init__(self, seed, fault=None):
        random = np.random.default_rng(seed)
        self.drawn = {name: values[random.integers(len(values))] for name, values in FACTORS.items()}
        if fault:
            self.drawn["jitter"] = 0.003
        d = self.drawn
        self.step = max(1, round(d["rate"] / 8))
        rate = d["rate"] / self.step
        frames = 90 if rate < 7 else 120
        columns, rows = d["board"]
        square = 0.27 / rows
        self.size, self.columns = d["size"], columns - 1
        self.board = f"charuco:{columns}x{rows}:{1e3 * square:g}mm:{750 * square:g}mm:DICT_4X4_1000"
        self.points = np.array([[(i + 1) * square, (j + 1) * square, 0] for j in range(rows - 1) for i in range(columns - 1)])
        n = d["cameras"]
        swing = np.pi if d["ring"] else np.deg2rad(25) * (n - 1) / 2 if n > 4 else 0
        pose = waved(random, d["speed"], frames / rate, swing)
        self.cameras, self.delays, self.views = [], [], []
        self.faulty, half = int(random.integers(1, n)), frames // 2
        moved = random.normal(size=3)
        for c in range(n):
            angle = (2 * np.pi * c / n if d["ring"] else (c - (n - 1) / 2) * np.deg2rad(25)) + 0.03 * random.normal()
            turn, shift = rotation(0.05 * random.normal(size=3)) @ rotation([0, -angle, 0]), np.array([0, 0, 1 + 0.05 * random.normal()])
            focal, centre = 0.75 * self.size[0] * (1 + 0.02 * random.normal()), np.array(self.size) / 2 + 10 * random.normal(size=2)
            k1, k2 = -0.3 + 0.05 * random.normal(), 0.1 + 0.03 * random.normal()
            self.cameras.append((turn, shift))
            self.delays.append(d["delay"] * random.uniform(-1, 1) if c > 0 else 0)
            views = {}
            for frame in range(frames):
                board_turn, board_shift = pose(frame / rate + self.delays[c] + d["jitter"] * random.normal())
                middle = turn @ board_shift + shift
                if fault == "moved" and c == self.faulty and frame >= half:
                    middle = middle + 0.002 * moved / np.linalg.norm(moved)
                x = (self.points - self.points.mean(0)) @ (turn @ board_turn).T + middle
                if x[:, 2].min() < 0.1 or (turn @ board_turn)[:, 2] @ middle < 0.35 * np.linalg.norm(middle):
                    continue
                x = x[:, :2] / x[:, 2:]
                r2 = (x**2).sum(1)
                pixels = focal * x * (1 + k1 * r2 + k2 * r2**2)[:, None] + centre
                seen = ((pixels > 2) & (pixels < np.array(self.size) - 3)).all(1) & (r2 < 1.2)
                pixels += NOISE_PX * random.normal(size=pixels.shape)
                if fault == "zoom" and c == self.faulty and frame >= half:
                    pixels = 1.03 * (pixels - np.array(self.size) / 2) + np.array(self.size) / 2
                if seen.sum() >= 8:
                    views[frame * self.step] = (np.nonzero(seen)[0], pixels[seen])
            self.views.append(views)
        own = sorted(self.views[self.faulty])
        if fault == "instant" and own:
            at = int(random.integers(len(own)))
            self.views[self.faulty][own[at]] = self.views[self.faulty][own[(at + len(own) // 2) % len(own)]]
        if fault == "swapped":
            a, b = ({f: v for f, v in self.views[c].items() if f >= half * self.step} for c in (0, self.faulty))
            for camera, old, new in ((0, a, b), (self.faulty, b, a)):
                self.views[camera] = {**{f: v for f, v in self.views[camera].items() if f not in old}, **new}

    def is_linked(self):
        """True if each camera has 15 views, and pairs with 8 common ones connect all."""
        linked = {0}
        for _ in self.views:
            linked |= {b for a in linked for b, views in enumerate(self.views) if len(views.keys() & self.views[a].keys()) >= 8}
        return min(map(len, self.views)) >= 15 and len(linked) == len(self.views)

    def write(self, folder):
        paths = [os.path.join(folder, f"cam{c}.csv") for c in range(len(self.views))]
        for path, views in zip(paths, self.views):
            with open(path, "w", encoding="utf-8") as file:
                file.write("camera,image,width,height,board,corner_id,col,row,u,v,sigma_px\n")
                for frame, (ids, pixels) in sorted(views.items()):
                    for i, (u, v) in zip(ids, pixels):
                        file.write(f"camera,f{frame:05}.png,{self.size[0]},{self.size[1]},{self.board},{i},{i % self.columns},"
                                   f"{i // self.columns},{u:.6f},{v:.6f},\n")
        return paths

    def errors_mm(self, places):
        turn, shift = self.cameras[0]
        truth = np.array([turn @ (-own_turn.T @ own_shift) + shift for own_turn, own_shift in self.cameras])
        return 1e3 * (np.array(places) - truth)[1:]

    def by_opencv(self):
        lenses = []
        for views in self.views:
            points = [self.points[ids].astype(np.float32) for ids, _ in views.values()]
            lenses.append(cv2.calibrateCamera(points, [p.astype(np.float32) for _, p in views.values()], self.size, None, None)[1:3])
        poses = {0: (np.eye(3), np.zeros(3))}
        while len(poses) < len(self.views):
            _, a, b = max((len(self.views[a].keys() & self.views[b].keys()), a, b)
                          for a in poses for b in range(len(self.views)) if b not in poses)
            points, ours, theirs = [], [], []
            for frame in sorted(self.views[a].keys() & self.views[b].keys()):
                (ids_a, pixels_a), (ids_b, pixels_b) = self.views[a][frame], self.views[b][frame]
                common = np.intersect1d(ids_a, ids_b)
                if len(common) >= 6:
                    points.append(self.points[common].astype(np.float32))
                    ours.append(pixels_a[np.isin(ids_a, common)].astype(np.float32))
                    theirs.append(pixels_b[np.isin(ids_b, common)].astype(np.float32))
            result = cv2.stereoCalibrate(points, ours, theirs, *lenses[a], *lenses[b], self.size, flags=cv2.CALIB_FIX_INTRINSIC)
            poses[b] = (result[5] @ poses[a][0], result[5] @ poses[a][1] + result[6].ravel())
        return self.errors_mm([-poses[c][0].T @ poses[c][1] for c in range(len(self.views))])


def by_alidade(program, rig):
    """The errors in mm and in standard deviations, and the JSON document; no errors if there is no rig."""
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run([program, "rig", "calibrate", *rig.write(folder), "--board", rig.board, "--json"], check=False,
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8")
    document = json.loads(run.stdout) if run.stdout else {}
    if "cameras" not in document:
        return None, None, {"verdict": "none"}
    places = []
    for camera in document["cameras"]:
        x, y, z, w = camera["camera_from_rig"]["quaternion_xyzw"]
        sine = np.linalg.norm([x, y, z])
        turn = rotation(np.array([x, y, z]) * 2 * np.arctan2(sine, w) / max(sine, 1e-12))
        places.append(-turn.T @ np.array(camera["camera_from_rig"]["translation_m"]))
    errors = rig.errors_mm(places)
    stds = 1e3 * np.array([camera["position_std_m"] or [np.nan] * 3 for camera in document["cameras"][1:]], float)
    return errors, errors / stds, document


def rms(errors):
    return np.sqrt((np.square(errors)).sum(1).mean())


def tell(title, results):
    ours, theirs, usable = (np.array([result[i] for result in results]) for i in (0, 1, 3))
    sigmas = np.concatenate([result[2].ravel() for result in results])
    print(f"{title:22} {len(results):4} {np.median(ours):9.2f} {np.median(theirs):9.2f} {np.median(ours / theirs):9.2f} "
          f"{np.mean(ours < 0.6 * theirs):9.0%} {usable.mean():8.0%} {np.mean(np.abs(sigmas[np.isfinite(sigmas)]) < 1.96):8.1%}", flush=True)


def main():
    program, num_sets = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 20
    seed, fault = int(sys.argv[3]) if len(sys.argv) > 3 else 0, sys.argv[4] if len(sys.argv) > 4 else None
    results = []
    while len(results) < num_sets:
        seed += 1
        rig = Set(seed, fault)
        if not rig.is_linked():
            continue
        errors, sigmas, document = by_alidade(program, rig)
        named = sorted({d["id"] for d in document.get("diagnoses", []) if d["severity"] != "note"} - {"poor_coverage", "weak_link"})
        if fault:
            motions = [motion["camera"] for motion in document.get("motions", [])]
            print(f"{seed} {document['verdict']}: cam{rig.faulty}; said: {', '.join(named)}; moved: {motions}", flush=True)
            results.append(None)
            continue
        if errors is None:
            print(f"{seed}: no rig", flush=True)
            continue
        results.append((rms(errors), rms(rig.by_opencv()), sigmas, document["verdict"] != "rejected", rig.drawn))
        print(f"{seed} {document['verdict']}: {results[-1][0]:.2f} mm, OpenCV {results[-1][1]:.2f} mm; {', '.join(named)}; {rig.drawn}", flush=True)
    if fault:
        return
    print("                       sets   Alidade    OpenCV   medians' ratio  below 0.6  usable  within 1.96 (mm, medians)")
    for name, values in FACTORS.items():
        for value in values:
            if chosen := [result for result in results if result[4][name] == value]:
                tell(f"{name} {value}", chosen)
    tell("all", results)


if __name__ == "__main__":
    main()
