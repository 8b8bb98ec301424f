#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes deliberate mistakes with each command, and checks that the answer says what to type instead.

usage: mistakes_test.py PROGRAM

A row is a command line, its exit code, and words of the answer that are separated by " | ". Rows that write to the closed
folder run without the right of the superuser to write everywhere.
"""
import os
import shlex
import shutil
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DATA = os.path.join(ROOT, "testdata", "checkerboard")
SPEC = "checkerboard:9x6:25mm"
SCENE = os.path.join(ROOT, "testdata", "checkerboard.yaml")
BARE_NUMBER = "did you mean 25mm?"
HAS_NO_IMAGE = "give the folder that contains the images"
EXISTS = "check the path"
FILE_NAME = "add a file name to the path"
CLOSED = "Permission denied"

TABLE = {
    "calibrate": [
        ("photos", 2, "no --board | --board checkerboard:9x6:SQUARE"),
        ("photos --board checkerboard:9x6:25", 2, BARE_NUMBER),
        ("photos --board 9x6:25mm", 2, "for example checkerboard:9x6:25mm"),
        ("photos --board checkerboard:9x6", 2, "expected checkerboard:COLUMNSxROWS:SQUARE"),
        ("photos --board checkerboard:10x7:25mm", 1, "did you count squares? Use checkerboard:9x6:25mm"),
        ("photos --board chesboard:9x6:25mm", 2, "did you mean 'checkerboard'?"),
        ("photos --board aprilgrid:6x6:88mm:26.4mm", 2, "'26.4mm' as the gap; expected a plain number | as a share of it"),
        ("photos --board camera.yaml", 1, "no key 'kind' | give a SPEC, for example checkerboard:9x6:25mm"),
        ("photos --bord " + SPEC, 2, "did you mean '--board'?"),
        ("photos --square-size 0.025 --pattern 9x6", 2, "next: --board checkerboard:9x6:25mm | alidade help boards"),
        (f"photos --board {SPEC} --model photogrammetric", 2, "expected one of pinhole, radtan"),
        (f"photos --board {SPEC} --model radtn", 2, "did you mean 'radtan'?"),
        (f"photos --board {SPEC} --to ross", 2, "did you mean 'ros'?"),
        (f"photos --board {SPEC} --format kalibr", 2, "next: --to with one of alidade, opencv"),
        (f"photos --board {SPEC} --tolerance 1mm", 2, "give a value such as 0.1px"),
        (f"empty --board {SPEC}", 1, HAS_NO_IMAGE),
        (f"none --board {SPEC}", 1, EXISTS),
        (f"camera.yaml --board {SPEC}", 1, "not an image | remove it from the inputs"),
        (f"photos --board {SPEC} -o empty", 1, FILE_NAME),
        (f"photos --board {SPEC} -o closed/camera.yaml", 1, CLOSED),
    ],
    "detect": [
        ("photos", 2, "no --board | --board checkerboard:9x6:SQUARE"),
        ("photos --board checkerboard:9x6:25", 2, BARE_NUMBER),
        ("photos --borad " + SPEC, 2, "did you mean '--board'?"),
        ("photos --target aprilgrid.yaml", 2, "next: --board checkerboard:9x6:25mm"),
        ("photos --board charuco:5x7:30mm:20mm:4X4_5", 2, "did you mean 'DICT_4X4_50'?"),
        ("photos --board checkerboard:10x7:25mm", 1, "did you count squares? Use checkerboard:9x6:25mm"),
        (f"empty --board {SPEC}", 1, HAS_NO_IMAGE),
        (f"none --board {SPEC}", 1, EXISTS),
        (f"points.csv --board {SPEC}", 1, "not an image | remove it from the inputs"),
        (f"photos --board {SPEC} --out corners.csv", 2, "did you mean '--output'?"),
        (f"photos --board {SPEC} -o empty", 1, FILE_NAME),
        (f"photos --board {SPEC} -o closed/corners.csv", 1, CLOSED),
    ],
    "board": [
        ("", 2, "for example checkerboard:9x6:25mm"),
        (SPEC, 2, "-o FILE, for example -o board.pdf"),
        (SPEC + " board.pdf", 2, "did you mean '-o board.pdf'?"),
        ("--board " + SPEC, 2, "alidade board checkerboard:9x6:25mm -o board.pdf"),
        (SPEC + " -o board.jpg", 2, "ends with .pdf, .svg or .png"),
        ("checkerboard:9x6:25 -o board.pdf", 2, BARE_NUMBER),
        ("checkerbord:9x6:25mm -o board.pdf", 2, "did you mean 'checkerboard'?"),
        ("charuco:5x7:30mm:20mm -o board.pdf", 2, "expected charuco:COLUMNSxROWS:SQUARE:MARKER:DICTIONARY[:FIRST_ID]"),
        ("charuco:5x7:30mm:40mm:DICT_4X4_50 -o board.pdf", 2, "markers of 0.3 to 0.95 of the square"),
        (SPEC + " -o board.pdf --paper A6", 2, "did you mean 'A4'?"),
        (SPEC + " -o board.pdf --paper 300x400", 2, "--paper 300x400mm"),
        ("camera.yaml -o board.pdf", 1, "give a SPEC, for example checkerboard:9x6:25mm"),
        ("photos -o board.pdf", 1, "this is a folder | give the path of a file in it"),
        (SPEC + " -o none/board.pdf", 1, "create the folder first"),
        (SPEC + " -o closed/board.pdf", 1, CLOSED),
    ],
    "project": [
        ("", 2, "no camera file"),
        ("none.yaml points.csv", 1, EXISTS),
        ("points.csv camera.yaml", 1, "the camera file comes first"),
        ("photos points.csv", 1, "this is a folder | give the path of a file in it"),
        ("empty.yaml points.csv", 1, "an empty file | check the path"),
        ("rig.yaml points.csv", 1, "select one: rig.yaml#left"),
        ("rig.yaml#middle points.csv", 1, "one of left, right"),
        ("camera.yaml pixels.csv", 1, "pixels u,v are for alidade unproject"),
        ("camera.yaml photos", 1, "expected a file of points"),
        ("camera.yaml points.csv -o pixels.csv", 2, "next: results go to standard output: add > FILE"),
        ("camera.yaml points.csv --camera left", 2, "FILE#NAME selects one camera"),
        ("camera.yaml points.csv --jacobians", 2, "did you mean '--jacobian'?"),
        ("camera.yaml points.csv --poses points.csv", 1, "add a header"),
        ("camera.yaml points.csv --poses-are world_from_cam", 2, "did you mean 'world_from_camera'?"),
    ],
    "unproject": [
        ("", 2, "no camera file"),
        ("none.yaml pixels.csv", 1, EXISTS),
        ("pixels.csv camera.yaml", 1, "the camera file comes first"),
        ("photos pixels.csv", 1, "this is a folder | give the path of a file in it"),
        ("empty.yaml pixels.csv", 1, "an empty file | check the path"),
        ("rig.yaml pixels.csv", 1, "select one: rig.yaml#left"),
        ("camera.yaml points.csv", 1, "points x,y,z are for alidade project"),
        ("camera.yaml none.csv", 1, EXISTS),
        ("camera.yaml photos", 1, "expected a file of points"),
        ("camera.yaml pixels.csv -o rays.csv", 2, "next: results go to standard output: add > FILE"),
        ("camera.yaml pixels.csv --jacobain", 2, "did you mean '--jacobian'?"),
    ],
    "undistort": [
        ("", 2, "no camera file"),
        ("camera.yaml", 2, "no images"),
        ("camera.yaml photos", 2, "expected -o FOLDER"),
        ("photos camera.yaml -o out", 1, "this is a folder | expected a file"),
        ("none.yaml photos -o out", 1, EXISTS),
        ("camera.yaml empty -o out", 1, HAS_NO_IMAGE),
        ("rig.yaml photos -o out", 1, "select one: rig.yaml#left"),
        ("camera.yaml photos -o photos", 2, "choose another folder"),
        ("camera.yaml photos -o camera.yaml", 1, "a file; expected the path of a folder"),
        ("camera.yaml photos -o out --alpha 1", 2, "next: --keep all (alpha or balance 1), or --keep valid (0)"),
        ("camera.yaml photos -o out --keep everything", 2, "expected one of all, valid"),
        ("camera.yaml photos -o out --interpolation bilinear", 2, "did you mean 'linear'?"),
        ("camera.yaml photos -o out --size 640", 2, "WIDTHxHEIGHT in pixels, such as 640x480"),
        ("camera.yaml photos -o closed/out", 1, CLOSED),
    ],
    "validate": [
        ("", 2, "no file"),
        ("none.yaml", 1, EXISTS),
        ("empty", 1, "give camera files, or the folder that contains them"),
        ("photos", 1, "give camera files, or the folder that contains them"),
        ("empty.yaml", 3, "an empty file"),
        ("points.csv", 3, "not a camera file"),
        ("lens.xml", 3, "calibrate the lens with alidade calibrate"),
        ("camera.yaml --images photos", 2, "no --board | --board checkerboard:9x6:SQUARE"),
        ("camera.yaml --images photos --board checkerboard:9x6:25", 2, BARE_NUMBER),
        ("camera.yaml --board " + SPEC, 2, "expected --images FOLDER"),
        ("camera.yaml --strct", 2, "did you mean '--strict'?"),
        ("camera.yaml --model fisheye", 2, "next: --read-as MODEL"),
        ("camera.yaml --format ross", 2, "did you mean 'ros'?"),
        ("camera.yaml --format ros", 3, "no key 'camera_matrix'"),
        ("camera.yaml --from ros2", 3, "no key 'camera_matrix'"),
        ("camera.yaml --tolerance 1mm", 2, "give a value such as 0.1px"),
        ("camera.yaml --junit camera.yaml", 2, "choose another name"),
        ("camera.yaml --against points.csv", 1, "the camera file comes first"),
        ("camera.yaml --junit closed/r.xml", 1, CLOSED),
    ],
    "diff": [
        ("", 2, "alidade diff --help"),
        ("camera.yaml", 2, "1 file"),
        ("camera.yaml none.yaml", 1, EXISTS),
        ("camera.yaml photos", 2, "photos is a folder and camera.yaml is not | name the file in the folder"),
        ("camera.yaml points.csv", 1, "not a camera file"),
        ("camera.yaml empty.yaml", 1, "an empty file"),
        ("camera.yaml camera.yaml --tolerence 1", 2, "did you mean '--tolerance'?"),
        ("camera.yaml camera.yaml --distance 2km", 2, "found '2km'"),
        ("camera.yaml camera.yaml --grid 20", 2, "'20'"),
        ("camera.yaml camera.yaml -o page.html", 2, "ends in .svg"),
        ("camera.yaml camera.yaml -o closed/a.svg", 1, CLOSED),
    ],
    "fleet": [
        ("", 2, "no file"),
        ("none", 1, EXISTS),
        ("empty", 1, "give camera files, or the folder that contains them"),
        ("photos", 1, "give camera files, or the folder that contains them"),
        ("cameras -o fleet.pdf", 2, "ends in .html or .csv"),
        ("cameras --tolerance 1mm", 2, "give a value such as 0.1px"),
        ("cameras --stric", 2, "did you mean '--strict'?"),
        ("cameras --previous none", 1, EXISTS),
        ("cameras -o closed/fleet.html", 1, CLOSED),
        ("cameras fleet.html", 1, EXISTS),
    ],
    "convert": [
        ("", 2, "no camera file"),
        ("camera.yaml", 2, "-o FILE"),
        ("camera.yaml out.yaml", 2, "-o FILE"),
        ("none.yaml -o out.yaml", 1, EXISTS),
        ("photos -o out.yaml", 1, "this is a folder | give the path of a file in it"),
        ("lens.xml -o out.yaml", 1, "calibrate the lens with alidade calibrate"),
        ("camera.yaml -o camera.yaml", 2, "choose another name"),
        ("camera.yaml -o empty", 1, FILE_NAME),
        ("camera.yaml -o out.yaml --to ross", 2, "did you mean 'ros'?"),
        ("camera.yaml -o out.yaml --format kalibr", 2, "next: --to with one of | --from for the file that is read"),
        ("camera.yaml -o out.yaml --from kaliber", 2, "did you mean 'kalibr'?"),
        ("camera.yaml -o out.yaml --from kalibr", 1, "no camera in a file of the format Kalibr"),
        ("camera.yaml -o out.yaml --scale 0.5", 2, "--resize WIDTHxHEIGHT"),
        ("camera.yaml -o out.yaml --resize 320", 2, "such as 320x180"),
        ("camera.yaml -o out.yaml --crop 0,0", 2, "such as 0,60,640,360"),
        ("camera.yaml -o out.yaml --rotate 45", 2, "expected one of 0, 90, 180, 270"),
        ("camera.yaml -o out.yaml --bin 0", 2, "expected 1 to 480"),
        ("camera.yaml -o out.yaml --model plum_bob", 2, "did you mean 'radtan'?"),
        ("camera.yaml -o closed/out.yaml", 1, CLOSED),
    ],
    "report": [
        ("", 2, "an evidence file"),
        ("evidence.json", 2, "-o FILE, for example -o page.html"),
        ("evidence.json page.html", 2, "did you mean '-o page.html'?"),
        ("evidence.json --ouput page.html", 2, "did you mean '--output'?"),
        ("camera.yaml -o page.html", 1, "give it with --evidence"),
        ("none.json -o page.html", 1, EXISTS),
        ("photos -o page.html", 1, "this is a folder | give the path of a file in it"),
        ("empty.yaml -o page.html", 1, "alidade calibrate --evidence writes"),
        ("evidence.json -o evidence.json", 2, "choose another name"),
        ("evidence.json -o empty", 1, FILE_NAME),
        ("evidence.json -o page.html --images none", 1, EXISTS),
        ("evidence.json -o closed/page.html", 1, CLOSED),
    ],
    "track": [
        ("", 2, "a video or a folder of images"),
        ("photos", 2, "expected --camera FILE"),
        ("photos --camera camera.yaml", 2, "expected -o FILE"),
        ("none.mp4 --camera camera.yaml -o path.txt", 1, EXISTS),
        ("empty --camera camera.yaml -o path.txt", 1, HAS_NO_IMAGE),
        ("photos/view_001.png --camera camera.yaml -o path.txt", 1, "give a video, or a folder with several images"),
        ("photos --camera points.csv -o path.txt", 1, "not a camera file"),
        ("photos --camera rig.yaml -o path.txt", 1, "select one: rig.yaml#left"),
        ("camera.yaml photos -o path.txt", 2, "expected --camera FILE"),
        ("photos --camra camera.yaml", 2, "did you mean '--camera'?"),
        ("photos --camera camera.yaml -o path.txt --front-end orb", 2, "expected one of flow, keypoints"),
        ("photos --camera camera.yaml -o empty", 1, FILE_NAME),
        ("photos --camera camera.yaml -o closed/path.txt", 1, CLOSED),
    ],
    "simulate": [
        ("", 2, "a scene file"),
        (SCENE, 2, "expected -o FOLDER"),
        ("none.yaml -o out", 1, EXISTS),
        ("camera.yaml -o out", 1, "expected one of alidade_scene, camera, board"),
        ("photos -o out", 1, "this is a folder | give the path of a file in it"),
        ("empty.yaml -o out", 1, "an empty file | check the path"),
        (SCENE + " -o camera.yaml", 1, "expected the path of a folder"),
        (SCENE + " -o photos", 1, "choose another name"),
        (SCENE + " -o out --corner-only", 2, "did you mean '--corners-only'?"),
        (SCENE + " -o out --seed 7", 2, "write it in the scene file"),
        (SCENE + f" -o out --board {SPEC}", 2, "write it in the scene file"),
        (SCENE + " -o closed/out", 1, CLOSED),
    ],
    "rig calibrate": [
        ("", 2, "for example left/ right/"),
        ("left", 2, "1 input; expected two or more | for example left/ right/"),
        ("left right", 2, "no --board | --board checkerboard:9x6:SQUARE"),
        (f"left left --board {SPEC}", 2, "for example left/ right/"),
        ("left right --board checkerboard:9x6:25", 2, BARE_NUMBER),
        ("left right --target target.yaml", 2, "next: --board checkerboard:9x6:25mm"),
        (f"left none --board {SPEC}", 1, EXISTS),
        (f"left empty --board {SPEC}", 1, HAS_NO_IMAGE),
        (f"left right --board {SPEC} --to kalibr", 2, "alidade convert rig.yaml -o camchain.yaml --to kalibr"),
        (f"left right --board {SPEC} --models pinhole-radtan", 2, "did you mean '--model'?"),
        (f"left right --board {SPEC} --model radtan,fishey", 2, "did you mean 'kannala_brandt'?"),
        (f"left right --board {SPEC} --names left", 2, "--names left,right"),
        (f"left right --board {SPEC} --fixed camera.yaml", 2, "one for each camera"),
        (f"left right --board {SPEC} -o closed/rig.yaml", 1, CLOSED),
    ],
    "rig validate": [
        ("", 2, "no rig file"),
        ("rig.yaml left", 2, "expected 2, one for each camera: left, right"),
        ("rig.yaml left right", 2, "no --board | --board checkerboard:9x6:SQUARE"),
        ("rig.yaml left right --board checkerboard:9x6:25", 2, BARE_NUMBER),
        ("rig.yaml left right --bord " + SPEC, 2, "did you mean '--board'?"),
        ("rig.yaml left right --square 25mm", 2, "next: --board checkerboard:9x6:25mm"),
        (f"camera.yaml left right --board {SPEC}", 1, "make one with alidade rig calibrate"),
        (f"left right rig.yaml --board {SPEC}", 1, "this is a folder; expected a file"),
        (f"none.yaml left right --board {SPEC}", 1, EXISTS),
        (f"rig.yaml left empty --board {SPEC}", 1, HAS_NO_IMAGE),
        (f"rig.yaml left left --board {SPEC}", 2, "for example left/ right/"),
    ],
    "rig rectify": [
        ("", 2, "no rig file"),
        ("rig.yaml", 2, "expected two, for the first and the second camera"),
        ("rig.yaml left right", 2, "expected -o FOLDER"),
        ("rig.yaml left -o out", 2, "expected two"),
        ("camera.yaml left right -o out", 1, "make one with alidade rig calibrate"),
        ("left right rig.yaml -o out", 1, "this is a folder; expected a file"),
        ("rig.yaml left none -o out", 1, EXISTS),
        ("rig.yaml left empty -o out", 1, HAS_NO_IMAGE),
        ("rig.yaml left right -o left", 2, "choose another folder"),
        ("rig.yaml left right -o out --alpha 0", 2, "next: --keep all (alpha or balance 1), or --keep valid (0)"),
        ("rig.yaml left right -o out --interpolate cubic", 2, "did you mean '--interpolation'?"),
        ("rig.yaml left right -o closed/out", 1, CLOSED),
    ],
    "rig triangulate": [
        ("", 2, "no rig file"),
        ("none.yaml points.csv", 1, EXISTS),
        ("rig.yaml none.csv", 1, EXISTS),
        ("rig.yaml photos", 1, "this is a folder | give the path of a file in it"),
        ("points.csv rig.yaml", 1, "the camera file comes first"),
        ("camera.yaml points.csv", 1, "make one with alidade rig calibrate"),
        ("rig.yaml points.csv", 1, "expected the header id,camera,u,v"),
        ("rig.yaml seen.csv --sigma 1mm", 2, "give a value such as 0.1px"),
        ("rig.yaml seen.csv --sigm 1", 2, "did you mean '--sigma'?"),
        ("rig.yaml seen.csv found.csv", 2, "did you mean '-o found.csv'?"),
        ("rig.yaml seen.csv -o seen.csv", 2, "choose another name"),
        ("rig.yaml seen.csv -o closed/found.csv", 1, CLOSED),
    ],
    "handeye calibrate": [
        ("", 2, "no input | folders, images or a corners file"),
        ("photos", 2, "no --poses | --poses poses.csv"),
        ("photos --poses poses.csv", 2, "no --board | --board checkerboard:9x6:SQUARE"),
        ("photos --poses poses.csv --board checkerboard:9x6:25", 2, BARE_NUMBER),
        (f"photos --poses none.csv --board {SPEC}", 1, EXISTS),
        (f"photos --poses photos --board {SPEC}", 1, "this is a folder | give the path of a file in it"),
        (f"photos --poses empty.yaml --board {SPEC}", 1, "empty.yaml"),
        (f"photos --poses poses.csv --board {SPEC} --pose-form kuca", 2, "expected abb, fanuc, franka, kuka"),
        (f"photos --poses poses.csv --board {SPEC} --camera-on arm", 2, "expected one of hand, base"),
        (f"photos --poses poses.csv --board {SPEC} --to kalibr", 2, "expected one of alidade, ros, urdf, opencv"),
        (f"photos --poses poses.csv --board {SPEC} --tolerance 1px", 2, "--tolerance"),
        (f"photos --poses poses.csv --board {SPEC} --camera none.yaml", 1, EXISTS),
        (f"photos --pose poses.csv --board {SPEC}", 2, "did you mean '--poses'?"),
        (f"empty --poses poses.csv --board {SPEC}", 1, HAS_NO_IMAGE),
        (f"photos --poses poses.csv --board {SPEC} -o poses.csv", 2, "choose another name"),
        (f"photos --poses poses.csv --board {SPEC} -o closed/handeye.yaml", 1, CLOSED),
    ],
    "handeye validate": [
        ("", 2, "no input | a hand-eye file, then new images"),
        ("none.yaml photos", 1, EXISTS),
        (f"camera.yaml photos --poses poses.csv --board {SPEC}", 1, "camera.yaml"),
        (f"none.yaml photos --pose poses.csv --board {SPEC}", 2, "did you mean '--poses'?"),
        (f"camera.yaml photos --board {SPEC}", 1, "camera.yaml"),
        ("camera.yaml", 2, "no input | a hand-eye file, then new images"),
        (f"empty.yaml photos --poses poses.csv --board {SPEC}", 1, "empty.yaml"),
        (f"photos photos --poses poses.csv --board {SPEC}", 1, "this is a folder | give the path of a file in it"),
        (f"none.yaml photos --poses poses.csv --board {SPEC} --camera-on arm", 2, "expected one of hand, base"),
        ("none.yaml other.yaml", 1, EXISTS),
    ],
}

CAMERA = "{alidade_camera: 1, model: pinhole, image_size: {width: 640, height: 480}, parameters: {fx: 500, fy: 500, cx: 320, cy: 240}}"
POSE = "{quaternion_xyzw: [0, 0, 0, 1], translation_m: [%s, 0, 0]}"


def write(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def lay_out():
    """What the command lines name, in the working folder."""
    images = sorted(os.listdir(os.path.join(DATA, "images")))[:4]
    for folder in ("photos", "left", "right", "empty", "cameras", "closed"):
        os.mkdir(folder)
    for folder in ("photos", "left", "right"):
        for image in images:
            os.symlink(os.path.join(DATA, "images", image), os.path.join(folder, image))
    for name in ("camera.yaml", "cameras/1.yaml", "cameras/2.yaml"):
        shutil.copy(os.path.join(DATA, "camera.yaml"), name)
    cameras = [f"  - name: {name}\n    camera_from_rig: {POSE % x}\n    camera: {CAMERA}\n" for name, x in (("left", 0), ("right", -0.1))]
    write("rig.yaml", "alidade_rig: 1\ncameras:\n" + "".join(cameras))
    write("points.csv", "0.1,-0.05,1\n")
    write("pixels.csv", "320,240\n")
    write("poses.csv", "".join(f"{image},{0.1 * i},0,0,0,0,0,1\n" for i, image in enumerate(images)))
    write("seen.csv", "id,camera,u,v\n1,left,320,240\n1,right,270,240\n")
    write("lens.xml", "<lensdatabase version=\"2\"><lens><model>a lens</model></lens></lensdatabase>\n")
    write("empty.yaml", "")
    write("evidence.json", "{}\n")
    os.chmod("closed", 0o555)


def ordinary():
    """What runs a program without the superuser's right to write everywhere; None if that cannot be had."""
    if os.geteuid() != 0:
        return []
    drop = ["setpriv", "--bounding-set=-dac_override"]
    return drop if shutil.which("setpriv") and subprocess.run([*drop, "true"], check=False).returncode == 0 else None


def complaint(run, code, words):
    """What is wrong with the answer; empty if nothing is."""
    answer = run.stderr + run.stdout
    missing = [word for word in words.split(" | ") if word not in answer]
    if run.returncode != code:
        return f"exit code {run.returncode} instead of {code}"
    if missing:
        return f"no {missing}"
    return "a bug" if "error: internal" in answer else ""


def main():
    program = os.path.abspath(sys.argv[1])
    prefix = ordinary()
    num_checked = num_skipped = num_wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        lay_out()
        for command, rows in TABLE.items():
            assert len(rows) >= 10, command
            for line, code, words in rows:
                if prefix is None and "closed" in line:
                    num_skipped += 1
                    continue
                run = subprocess.run([*(prefix or []), program, *command.split(), *shlex.split(line)], text=True,
                                     stdin=subprocess.DEVNULL, capture_output=True, timeout=60, check=False)
                num_checked += 1
                if wrong := complaint(run, code, words):
                    num_wrong += 1
                    print(f"$ alidade {command} {line}\n{wrong}:\n{run.stderr}{run.stdout}")
        os.chdir("/")
        os.chmod(os.path.join(folder, "closed"), 0o755)
    print(f"{num_checked} mistakes, {num_wrong} answered badly, {num_skipped} not made")
    return 0 if num_checked + num_skipped == sum(map(len, TABLE.values())) and num_wrong == 0 else 1


sys.exit(main())
