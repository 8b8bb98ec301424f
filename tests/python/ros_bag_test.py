# SPDX-License-Identifier: MIT
"""The example for ROS 2 bags, with messages and a reader that stand for those of ROS."""
import os
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import alidade
from conftest import DATA, ROOT, SPEC

cv2 = pytest.importorskip("cv2")
EXAMPLE = ROOT / "docs/examples/ros2_bag.py"
sys.path.insert(0, str(EXAMPLE.parent))
import ros2_bag  # noqa: E402


def message(encoding, pixels, padding=0, is_bigendian=False):
    """A sensor_msgs/Image of an array (height, width[, channels])."""
    height, width = pixels.shape[:2]
    if pixels.dtype.itemsize == 2:
        pixels = pixels.astype(">u2" if is_bigendian else "<u2")
    rows = np.frombuffer(pixels.tobytes(), np.uint8).reshape(height, -1)
    rows = np.pad(rows, ((0, 0), (0, padding)), constant_values=77)
    return SimpleNamespace(height=height, width=width, encoding=encoding, is_bigendian=int(is_bigendian), step=rows.shape[1],
                           data=rows.ravel())


GREY = np.arange(24, dtype=np.uint8).reshape(4, 6)
COLOUR = np.arange(72, dtype=np.uint8).reshape(4, 6, 3)


def test_plain_encodings():
    deep = GREY.astype(np.uint16) * 1000
    alpha = np.dstack([COLOUR, np.full_like(GREY, 255)])
    cases = [("mono8", GREY, GREY), ("8UC1", GREY, GREY), ("mono16", deep, deep), ("16UC1", deep, deep),
             ("bgr8", COLOUR, COLOUR), ("rgb8", COLOUR[..., ::-1], COLOUR), ("bgra8", alpha, COLOUR),
             ("rgba8", alpha[..., [2, 1, 0, 3]], COLOUR), ("bgr16", COLOUR.astype(np.uint16) * 9, COLOUR.astype(np.uint16) * 9)]
    num_checked = 0
    for encoding, given, expected in cases:
        for padding in (0, 4):
            for is_bigendian in (False, True):
                image = ros2_bag.image_array(message(encoding, given, padding, is_bigendian))
                assert image.dtype == expected.dtype and image.dtype.isnative and np.array_equal(image, expected), encoding
                num_checked += 1
    assert num_checked == 36


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
def test_mosaics(pattern, bits):
    colours = {"r": 200, "g": 120, "b": 40}
    scale = 1 if bits == 8 else 256
    tile = np.array([colours[c] * scale for c in pattern], f"u{bits // 8}").reshape(2, 2)
    image = ros2_bag.image_array(message(f"bayer_{pattern}{bits}", np.tile(tile, (6, 8)), padding=6))
    assert image.shape == (12, 16, 3) and image.dtype == tile.dtype
    inner = image[2:-2, 2:-2].reshape(-1, 3)
    assert (inner == np.array([40, 120, 200]) * scale).all() and len(inner) == 96


def test_compressed_images():
    data = cv2.imencode(".png", COLOUR)[1]
    assert np.array_equal(ros2_bag.image_array(SimpleNamespace(format="png", data=data)), COLOUR)
    for wrong in (b"", b"no image"):
        with pytest.raises(ValueError, match="png"):
            ros2_bag.image_array(SimpleNamespace(format="png", data=wrong))


def test_refuses_what_it_does_not_know():
    with pytest.raises(ValueError, match="'yuv422'.*mono8"):
        ros2_bag.image_array(message("yuv422", GREY))
    short = message("mono8", GREY)
    short.data = short.data[:-1]
    narrow = message("mono8", GREY)
    narrow.step = 5
    for wrong in (short, narrow):
        with pytest.raises(ValueError, match="expected 4 rows of 6"):
            ros2_bag.image_array(wrong)


def run_example(folder, *arguments):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(folder), os.environ["PYTHONPATH"]])}
    return subprocess.run([sys.executable, EXAMPLE, *map(str, arguments)], cwd=folder, capture_output=True, text=True,
                          env=environment)


def test_says_what_to_install(tmp_path):
    for package in ("rosbags", "rosbag2_py"):
        (tmp_path / f"{package}.py").write_text("raise ImportError('as if it were not installed')")
    run = run_example(tmp_path, "bag", "/image", SPEC, "camera.yaml")
    assert run.returncode == 1 and "pip install rosbags" in run.stderr and "Traceback" not in run.stderr
    assert run_example(tmp_path).returncode == 2


READER = '''
import glob, types, cv2
class AnyReader:
    def __init__(self, paths, default_typestore):
        self.folder = paths[0]
        self.connections = [types.SimpleNamespace(topic=t, msgtype="sensor_msgs/msg/Image") for t in ("/left", "/right")]
    def __enter__(self):
        return self
    def __exit__(self, *_):
        pass
    def messages(self, connections):
        assert [c.topic for c in connections] == ["/left"]
        for i, photo in enumerate(sorted(glob.glob(f"{self.folder}/*.png"))):
            yield connections[0], i, cv2.imread(photo)
    def deserialize(self, data, msgtype):
        return types.SimpleNamespace(height=480, width=640, encoding="bgr8", is_bigendian=0, step=1920, data=data.ravel())
'''


def test_calibrates_from_a_bag(tmp_path):
    package = tmp_path / "rosbags"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "highlevel.py").write_text(READER)
    (package / "typesys.py").write_text("class Stores: ROS2_HUMBLE = 1\ndef get_typestore(store): return store\n")
    run = run_example(tmp_path, DATA / "images", "/left", SPEC, "camera.yaml", 1)
    assert run.returncode == 0, run.stderr
    written = alidade.load_camera(tmp_path / "camera.yaml")
    assert written.calibration.num_views == 12 and alidade.load_camera(tmp_path / "camera.ros.yaml").model == written.model
    run = run_example(tmp_path, DATA / "images", "/front", SPEC, "none.yaml", 1)
    assert run.returncode == 1 and "/front" in run.stderr and not (tmp_path / "none.yaml").exists()
