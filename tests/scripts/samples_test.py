#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs the commands of README.md and docs/*.md that are shown with their output, and compares the output.

usage: samples_test.py PROGRAM

A command is a line "$ ..." in a code block, and the lines behind it are what it prints; a line "..." stands for any
lines. The photographs are those of Debian's package opencv-doc: without them the test is skipped (exit code 77).
"""
import glob
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PHOTOS = "/usr/share/doc/opencv-doc/examples/data"
NUM_SAMPLES = 13


def samples(path):
    """Yields (line number, command, printed lines)."""
    command, start, lines = None, 0, []
    for number, line in enumerate(open(path, encoding="utf-8").read().split("\n"), 1):
        if line.startswith("$ "):
            command, start, lines = line[2:], number, []
        elif line.startswith("```"):
            if command:
                yield start, command, lines
            command = None
        elif command:
            lines.append(line)


def matches(shown, printed):
    """Whether the printed lines are those shown; "..." is any number of lines."""
    if not shown:
        return not printed
    if shown[0].strip() == "...":
        return any(matches(shown[1:], printed[i:]) for i in range(len(printed) + 1))
    return bool(printed) and shown[0].rstrip() == printed[0].rstrip() and matches(shown[1:], printed[1:])


def main():
    program = os.path.abspath(sys.argv[1])
    if not os.path.isdir(PHOTOS):
        print("the photographs of opencv-doc are not installed")
        return 77
    num_checked = num_wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        os.symlink(os.path.join(ROOT, "testdata"), os.path.join(folder, "testdata"))
        os.mkdir(os.path.join(folder, "photos"))
        for photo in glob.glob(PHOTOS + "/left[0-9][0-9].jpg"):
            os.symlink(photo, os.path.join(folder, "photos", os.path.basename(photo)))
        os.mkdir(os.path.join(folder, "bin"))
        os.symlink(program, os.path.join(folder, "bin", "alidade"))
        environment = dict(os.environ, PATH=os.path.join(folder, "bin") + ":" + os.environ["PATH"])
        for side in ("left", "right"):
            subprocess.run(f"alidade calibrate {PHOTOS}/{side}[0-9][0-9].jpg --board checkerboard:9x6:25mm "
                           f"-o {side}.yaml", shell=True, cwd=folder, env=environment, check=True, capture_output=True)
        os.symlink("left.yaml", os.path.join(folder, "camera.yaml"))
        for path in [os.path.join(ROOT, "README.md"), *sorted(glob.glob(os.path.join(ROOT, "docs", "*.md")))]:
            for number, command, shown in samples(path):
                run = subprocess.run(command, shell=True, cwd=folder, env=environment, capture_output=True, text=True)
                num_checked += 1
                if matches(shown, run.stdout.rstrip("\n").split("\n")):
                    continue
                num_wrong += 1
                print(f"{os.path.relpath(path, ROOT)}:{number}: $ {command}\nshown:")
                print("\n".join(shown) + "\nprinted:\n" + run.stdout + run.stderr)
    print(f"{num_checked} samples, {num_wrong} differ")
    return 0 if num_checked == NUM_SAMPLES and num_wrong == 0 else 1


sys.exit(main())
