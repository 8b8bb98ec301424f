# SPDX-License-Identifier: MIT
"""What the tests of the Python module share. The module is found by PYTHONPATH, the program by ALIDADE."""
import csv
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT / "testdata" / "checkerboard"
SPEC = "checkerboard:9x6:25mm"
sys.dont_write_bytecode = True


def alidade_program(*arguments, text=None):
    """Runs the program and returns what it prints; it must succeed."""
    run = subprocess.run([os.environ["ALIDADE"], *map(str, arguments)], input=text, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return run.stdout


def python(code, *arguments, **options):
    """Runs code in an interpreter of its own."""
    return subprocess.run([sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True, **options)


@pytest.fixture(scope="session")
def camera():
    import alidade
    return alidade.load_camera(DATA / "camera.yaml")


@pytest.fixture(scope="session")
def photos():
    return sorted((DATA / "images").glob("*.png"))


@pytest.fixture(scope="session")
def corners_file(tmp_path_factory):
    """The corners that the program finds in the images."""
    path = tmp_path_factory.mktemp("corners") / "corners.csv"
    alidade_program("detect", DATA / "images", "--board", SPEC, "-o", path, "--quiet")
    return path


@pytest.fixture(scope="session")
def corners(corners_file):
    """The same as arrays: names, (ids, pixels, sigmas) of each view."""
    rows = {}
    with open(corners_file, encoding="utf-8") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            rows.setdefault(row["image"], []).append([float(row[key]) for key in ("corner_id", "u", "v", "sigma_px")])
    tables = [np.array(table) for table in rows.values()]
    return list(rows), [(t[:, 0].astype(int), t[:, 1:3], t[:, 3]) for t in tables]


@pytest.fixture(scope="session")
def result(corners):
    import alidade
    names, views = corners
    return alidade.calibrate(views, SPEC, image_size=(640, 480), names=names)
