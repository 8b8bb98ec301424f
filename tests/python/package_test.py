# SPDX-License-Identifier: MIT
"""The package as users install it, its stubs, and the samples of the documentation."""
import ast
import inspect
import os
import pathlib
import re
import subprocess
import sys

import pytest

import alidade
from conftest import DATA, ROOT, python

PHOTOS = pathlib.Path("/usr/share/doc/opencv-doc/examples/data")


def stub_names():
    names = set()
    for node in ast.parse((ROOT / "python/alidade/_core.pyi").read_text()).body:
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            names.add(node.name)
        if isinstance(node, ast.ClassDef):
            names |= {f"{node.name}.{member.name}" for member in node.body if isinstance(member, ast.FunctionDef)}
    return names


def test_stubs_name_all_there_is():
    from alidade import _core
    found = set()
    for name, value in vars(_core).items():
        if name.startswith("_"):
            continue
        found.add(name)
        if inspect.isclass(value) and not issubclass(value, Exception):
            members = {m for m in vars(value) if not m.startswith("_") or m in ("__getitem__", "__len__")}
            if "__init__" in vars(value) and name in ("Board", "Camera"):
                members.add("__init__")
            found |= {f"{name}.{m}" for m in members}
    assert found == {n for n in stub_names() if not n.startswith("_")} and len(found) > 120
    assert set(alidade.__all__) == {n for n in found if "." not in n} | {"SE3", "Status", "__version__"}


def test_everything_public_has_a_docstring():
    num_checked = 0
    for name in alidade.__all__:
        value = getattr(alidade, name)
        if name != "__version__":
            assert value.__doc__, name
            num_checked += 1
    assert num_checked == len(alidade.__all__) - 1
    assert alidade.Camera.project.__doc__.startswith("project(points, camera_from_points=None, *, out=None, jobs=1)\n")


def test_statuses_are_those_of_the_library(camera):
    assert [camera.project(p)[1] for p in ([0.0, 0, 1], [0.0, 0, -1], [30.0, 0, 1])] == list(alidade.Status)


def test_installs_with_pip(tmp_path):
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    environment.update(PIP_NO_INDEX="1", PIP_DISABLE_PIP_VERSION_CHECK="1")
    venv = tmp_path / "venv"
    subprocess.run([sys.executable, "-m", "venv", "--system-site-packages", venv], check=True)
    run = subprocess.run([venv / "bin/python", "-m", "pip", "install", "--no-build-isolation", ROOT], env=environment,
                         capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    code = "import alidade, sys; print(alidade.__file__); print(alidade.load_camera(sys.argv[1]).model)"
    run = subprocess.run([venv / "bin/python", "-c", code, DATA / "camera.yaml"], env=environment, capture_output=True,
                         text=True, cwd=tmp_path)
    assert run.stdout.splitlines()[0].startswith(str(venv)) and run.stdout.splitlines()[1] == "radtan", run.stderr
    run = subprocess.run([venv / "bin/python", "-m", "pip", "check"], env=environment, capture_output=True, text=True)
    assert "alidade" not in run.stdout
    run = subprocess.run([venv / "bin/python", "-m", "pip", "uninstall", "-y", "alidade"], env=environment, capture_output=True)
    assert run.returncode == 0 and not list(venv.rglob("_core.*"))


def test_installs_as_a_component(tmp_path):
    subprocess.run(["cmake", "--install", os.environ["ALIDADE_BUILD_DIR"], "--component", "python", "--prefix", tmp_path],
                   check=True, capture_output=True)
    files = sorted(p.name for p in tmp_path.rglob("alidade/*") if p.is_file())
    assert files == sorted(p.name for p in pathlib.Path(alidade.__file__).parent.iterdir() if p.is_file())
    folder = next(tmp_path.rglob("__init__.py")).parent.parent
    assert folder.name == "dist-packages"
    run = python("import alidade; print(alidade.__file__)", env={**os.environ, "PYTHONPATH": str(folder)})
    assert run.stdout.startswith(str(folder)), run.stderr


def blocks(path):
    return re.findall(r"```python\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL)


@pytest.fixture
def samples_folder(tmp_path, monkeypatch):
    """What the samples read: photos/."""
    (tmp_path / "photos").symlink_to(DATA / "images")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name, count", [("README.md", 2), ("docs/python.md", 7)])
def test_samples_run(samples_folder, name, count):
    code = blocks(ROOT / name)
    assert len(code) == count
    run = python("\n".join(code), cwd=samples_folder)
    assert run.returncode == 0, run.stderr
    assert run.stdout


def test_example_runs(tmp_path):
    pytest.importorskip("matplotlib")
    import cv2
    video = tmp_path / "board.avi"
    writer = cv2.VideoWriter(str(video), cv2.VideoWriter_fourcc(*"MJPG"), 5, (640, 480))
    for photo in sorted((DATA / "images").glob("*.png")):
        writer.write(cv2.imread(str(photo)))
    writer.release()
    run = subprocess.run([sys.executable, ROOT / "docs/examples/notebook.py", video, "checkerboard:9x6:25mm"], cwd=tmp_path,
                         capture_output=True, text=True, env={**os.environ, "MPLBACKEND": "Agg"})
    assert run.returncode == 0, run.stderr
    assert "12 frames" in run.stdout and (tmp_path / "accuracy.png").stat().st_size > 5000 and (tmp_path / "camera.yaml").exists()
