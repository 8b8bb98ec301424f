#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Tests what one more camera model takes: a header with all traits, and its name in the list.

usage: new_model_test.py commands PROGRAM DOC_TEST SOURCE_FOLDER
       new_model_test.py traits COMPILER OVERLAY SOURCE_FOLDER
"""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

# A fisheye lens of 220 px a radian on the axis, which sees 120 degrees across the shorter side.
SCENE = """alidade_scene: 1
camera:
  model: scaled_ucm
  image_size: {width: 640, height: 480}
  parameters: {fx: 110, fy: 110.5, cx: 322.5, cy: 238.1, alpha: 0.62}
board: checkerboard:9x6:25mm
views: {random: 24}
seed: 7
random: {max_tilt_deg: 50, max_roll_deg: 30, min_fill: 0.3, max_fill: 0.9, margin_px: 4}
corner_noise_px: 0.1
"""


def run(*command, codes=(0,), **options):
    """Returns what a command writes; one that ends with an unexpected exit code ends the test."""
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    if done.returncode not in codes:
        sys.exit(f"{' '.join(command)}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout or done.stderr


def check(condition, what, output):
    """Ends the test where a condition does not hold."""
    if not condition:
        sys.exit(f"expected {what}:\n{output}")


def test_commands(program, doc_test, source):
    """Every command knows the model."""
    with open("scene.yaml", "w", encoding="utf-8") as scene:
        scene.write(SCENE)
    run(program, "simulate", "scene.yaml", "-o", "set", "--corners-only")
    calibrate = (program, "calibrate", "set/corners.csv", "--quiet")
    run(*calibrate, "--model", "scaled_ucm", "-o", "new.yaml")
    with open("new.yaml", encoding="utf-8") as camera:
        check("model: scaled_ucm\n" in camera.read(), "a camera of the model", "new.yaml")
    chosen = json.loads(run(*calibrate, "--model", "auto", "-o", "auto.yaml", "--json"))
    candidates = [candidate["model"] for candidate in chosen["model_choice"]["candidates"]]
    check("scaled_ucm" in candidates, "the model among the candidates", candidates)
    run(program, "validate", "new.yaml")
    output = run(program, "convert", "new.yaml", "-o", "ucm.yaml", "--model", "ucm")
    with open("ucm.yaml", encoding="utf-8") as camera:
        check("model: ucm\n" in camera.read(), "the same lens as ucm", output)
    difference = json.loads(run(program, "diff", "new.yaml", "ucm.yaml", "--json"))
    check(difference["max_px"] < 1e-6, "no difference between the two", difference)
    run(program, "convert", "ucm.yaml", "-o", "back.yaml", "--model", "scaled_ucm", "--rotate", "90")
    # A file format that cannot hold the model holds the lens.
    run(program, "convert", "new.yaml", "-o", "basalt.json", "--to", "basalt")

    shutil.copy(f"{source}/docs/models.md", "models.md")
    places = dict(os.environ, ALIDADE_MODELS_DOC="models.md")
    check("FAILED" in run(doc_test, codes=(1,), env=places), "a row that is missing in docs/models.md", doc_test)
    run(doc_test, env=dict(places, ALIDADE_WRITE_MODELS_DOC="1"))
    run(doc_test, env=places)
    with open("models.md", encoding="utf-8") as doc:
        check("| `scaled_ucm` | alpha |" in doc.read(), "a row for the model", "models.md")


def test_traits(compiler, overlay, source):
    """A header without a trait does not compile, and the message names the trait."""
    with open(f"{overlay}/alidade/camera/scaled_ucm.h", encoding="utf-8") as header:
        whole = header.read()
    os.makedirs("alidade/camera")
    command = (compiler, "-std=c++20", "-fsyntax-only", "-I.", f"-I{overlay}", f"-I{source}/src", "-xc++", "-")
    program = '#include "alidade/camera/model_list.h"\nalidade::AllModels all;\n'
    traits = ["kId", "kMaxAngle", "kFamily", "kIsStiff", "kIsPolynomial", "kFlexibleId", "kVectors", "kSharedLenses"]
    for trait in ["none", *traits]:
        without, count = re.subn(rf"\n  static constexpr [^;]*\b{trait} = [^;]*;", "", whole)
        check(count == (trait != "none"), "the trait once in the header", trait)
        with open("alidade/camera/scaled_ucm.h", "w", encoding="utf-8") as header:
            header.write(without)
        output = run(*command, codes=(0,) if trait == "none" else (1,), input=program)
        check(trait == "none" or re.search(rf"M::{trait}\b.* (is|would be) invalid", output), f"{trait} in", output)


if __name__ == "__main__":
    arguments = [os.path.abspath(argument) for argument in sys.argv[2:]]
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        {"commands": test_commands, "traits": test_traits}[sys.argv[1]](*arguments)
