# SPDX-License-Identifier: MIT
"""Builds the wheel of "pip install ." with CMake (PEP 517), with Python's standard library alone.

environment:
  ALIDADE_BUILD_DIR  build in this folder instead of build/
"""
from __future__ import annotations

import base64
import hashlib
import io
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from collections.abc import Iterable

ROOT = pathlib.Path(__file__).resolve().parent.parent


def version() -> str:
    """Returns the version of the project in CMakeLists.txt."""
    return re.search(r"project\(alidade VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))[1]


def tag() -> str:
    """Returns what the compiled module runs on: "cp311-cp311-linux_x86_64"."""
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


def info_files(wheel_tag: str, licence: str = "MIT") -> dict[str, bytes]:
    """Returns the files about the package, by name."""
    metadata = (f"Metadata-Version: 2.1\nName: alidade\nVersion: {version()}\nSummary: Camera calibration and projection\n"
                f"License: {licence}\nRequires-Python: >=3.9\nRequires-Dist: numpy\n")
    wheel = f"Wheel-Version: 1.0\nGenerator: alidade\nRoot-Is-Purelib: false\nTag: {wheel_tag}\n"
    return {"METADATA": metadata.encode(), "WHEEL": wheel.encode(), "LICENSE": (ROOT / "LICENSE").read_bytes()}


def build() -> pathlib.Path:
    """Builds the module and returns the folder of the package."""
    folder = pathlib.Path(os.environ.get("ALIDADE_BUILD_DIR") or ROOT / "build")
    # Not that of a virtual environment, which may be gone at the next build in the same folder.
    python = os.path.realpath(sys.executable)
    subprocess.run(["cmake", "-S", ROOT, "-B", folder, "-DALIDADE_BUILD_PYTHON=ON", f"-DPython3_EXECUTABLE={python}"], check=True)
    subprocess.run(["cmake", "--build", folder, "--target", "alidade_python", "--parallel", str(os.cpu_count() or 1)], check=True)
    return folder / "python" / "alidade"


def write_wheel(folder: str | pathlib.Path, package: Iterable[pathlib.Path], wheel_tag: str, licences: pathlib.Path | None = None) -> str:
    """Writes the files of the package, and the licences of the libraries inside (see scripts/portable), as a wheel and returns its name."""
    files = {f"alidade/{path.name}": path.read_bytes() for path in sorted(package)}
    info = f"alidade-{version()}.dist-info"
    files |= {f"{info}/{name}": content for name, content in info_files(wheel_tag, "GPL-3.0-or-later" if licences else "MIT").items()}
    if licences:
        files |= {f"{info}/licences/{path.relative_to(licences)}": path.read_bytes() for path in sorted(licences.rglob("*")) if path.is_file()}
    record = ""
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record += f"{name},sha256={digest},{len(content)}\n"
    files[f"{info}/RECORD"] = f"{record}{info}/RECORD,,\n".encode()
    name = f"alidade-{version()}-{wheel_tag}.whl"
    with zipfile.ZipFile(pathlib.Path(folder) / name, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in files.items():
            archive.writestr(zipfile.ZipInfo(path), content, zipfile.ZIP_DEFLATED)  # without the time: the same bytes each time
    return name


def build_wheel(wheel_directory: str, config_settings: object = None, metadata_directory: object = None) -> str:
    """PEP 517: builds the wheel and returns its name."""
    return write_wheel(wheel_directory, (path for path in build().iterdir() if path.is_file()), tag())


def prepare_metadata_for_build_wheel(metadata_directory: str, config_settings: object = None) -> str:
    """PEP 517: writes the files about the package, without a build, and returns their folder."""
    folder = pathlib.Path(metadata_directory) / f"alidade-{version()}.dist-info"
    folder.mkdir()
    for name, content in info_files(tag()).items():
        (folder / name).write_bytes(content)
    return folder.name


def build_sdist(sdist_directory: str, config_settings: object = None) -> str:
    """PEP 517: archives the source, without build folders, and returns the archive's name."""
    base = f"alidade-{version()}"
    info = f"Metadata-Version: 2.1\nName: alidade\nVersion: {version()}\n".encode()
    with tarfile.open(os.path.join(sdist_directory, f"{base}.tar.gz"), "w:gz", format=tarfile.PAX_FORMAT) as archive:
        for path in sorted(ROOT.iterdir()):
            if path.name != ".git" and not path.name.startswith("build"):
                archive.add(path, f"{base}/{path.name}", filter=lambda entry: None if "__pycache__" in entry.name else entry)
        entry = tarfile.TarInfo(f"{base}/PKG-INFO")
        entry.size = len(info)
        archive.addfile(entry, io.BytesIO(info))
    return f"{base}.tar.gz"
