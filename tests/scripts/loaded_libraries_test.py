#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""OpenCV's library for image files, which depends on a hundred others, is loaded for PNG files and not for grey JPEG files:
loaded_libraries_test.py ALIDADE
"""
import glob
import os
import shutil
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
LIBRARY = "opencv_imgcodecs"


def loads_codecs(folder: str, program: str, pattern: str) -> bool:
    """Calibrates from the images, with a page, and says whether the library was loaded."""
    trace = os.path.join(folder, "trace")
    command = [program, "calibrate", pattern, "--board", "checkerboard:9x6:25mm", "--report", os.path.join(folder, "page.html"), "--quiet"]
    done = subprocess.run(command, env=os.environ | {"LD_DEBUG": "files", "LD_DEBUG_OUTPUT": trace}, capture_output=True, text=True)
    assert done.returncode in (0, 3), done.stderr
    assert os.path.exists(os.path.join(folder, "page.html"))
    text = "".join(open(name, encoding="utf-8", errors="replace").read() for name in glob.glob(trace + ".*"))
    assert "libc.so" in text, "the loader wrote no trace"
    return LIBRARY in text


def main() -> int:
    program = os.path.abspath(sys.argv[1])
    if shutil.which("ffmpeg") is None:
        print("SKIPPED: ffmpeg, which makes the JPEG files, is not installed")
        return 77
    with tempfile.TemporaryDirectory() as png, tempfile.TemporaryDirectory() as jpeg:
        images = sorted(glob.glob(os.path.join(ROOT, "testdata", "checkerboard", "images", "*.png")))
        assert len(images) >= 6
        for name in images:
            shutil.copy(name, png)
            written = os.path.join(jpeg, os.path.splitext(os.path.basename(name))[0] + ".jpg")
            subprocess.run(["ffmpeg", "-loglevel", "error", "-i", name, "-q:v", "2", written], check=True, stdin=subprocess.DEVNULL)
        if not loads_codecs(png, program, os.path.join(png, "*.png")):
            print("SKIPPED: this program contains OpenCV's library")
            return 77
        assert not loads_codecs(jpeg, program, os.path.join(jpeg, "*.jpg")), f"{LIBRARY} is loaded for grey JPEG files"
    return 0


if __name__ == "__main__":
    sys.exit(main())
