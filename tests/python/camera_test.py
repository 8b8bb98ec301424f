# SPDX-License-Identifier: MIT
"""Projection and camera files from Python."""
import os
import pickle
import threading

import numpy as np
import pytest

import alidade
from conftest import DATA, alidade_program

RNG_SEED = 7


def points(count):
    rng = np.random.default_rng(RNG_SEED)
    return np.column_stack([rng.uniform(-1.5, 1.5, (count, 2)), rng.uniform(-0.5, 3, count)])


def test_projects_and_unprojects(camera):
    given = points(5000)
    pixels, status = camera.project(given)
    assert pixels.shape == (5000, 2) and pixels.dtype == np.float64
    assert status.shape == (5000,) and status.dtype.kind == "u"
    assert set(status) == {alidade.Status.OK, alidade.Status.BEHIND, alidade.Status.OUTSIDE}
    assert np.array_equal(np.isnan(pixels).any(axis=1), status != alidade.Status.OK)
    rays, ray_status = camera.unproject(pixels[status == 0])
    assert (ray_status == 0).all() and len(rays) > 1000
    directions = given[status == 0] / np.linalg.norm(given[status == 0], axis=1, keepdims=True)
    assert np.abs(rays - directions).max() < 1e-9


def test_has_the_digits_of_the_program(camera):
    given = points(300)
    table = "x,y,z\n" + "".join(f"{float(x)!r},{float(y)!r},{float(z)!r}\n" for x, y, z in given)
    printed = alidade_program("project", DATA / "camera.yaml", text=table).splitlines()[1:]
    pixels, status = camera.project(given)
    assert len(printed) == 300
    for line, pixel, code in zip(printed, pixels, status):
        u, v, word = line.split(",")
        assert (code == 0) == (word in ("ok", "out_of_image"))
        assert code != 0 or (float(u) == pixel[0] and float(v) == pixel[1])
    seen = pixels[status == 0]
    table = "u,v\n" + "".join(f"{float(u)!r},{float(v)!r}\n" for u, v in seen)
    printed = alidade_program("unproject", DATA / "camera.yaml", text=table).splitlines()[1:]
    rays = camera.unproject(seen)[0]
    assert len(printed) == len(seen) > 50
    for line, ray in zip(printed, rays):
        assert [float(number) for number in line.split(",")[:3]] == list(ray)


def test_pose_is_applied_before_the_projection(camera):
    angle = 0.3
    pose = np.array([[np.cos(angle), -np.sin(angle), 0, 0.1], [np.sin(angle), np.cos(angle), 0, -0.2], [0, 0, 1, 2], [0, 0, 0, 1]])
    given = points(200)
    expected = camera.project(given @ pose[:3, :3].T + pose[:3, 3])[0]
    for matrix in (pose, pose[:3], pose.tolist()):
        np.testing.assert_allclose(camera.project(given, matrix)[0], expected, rtol=1e-12)
    for wrong in (2 * pose, np.diag([1, 1, -1, 1]), np.eye(3), np.full((4, 4), np.nan)):
        with pytest.raises(alidade.UsageError, match="camera_from_points"):
            camera.project(given, wrong)


def test_jacobians_are_derivatives(camera):
    given = np.array([[0.1, -0.2, 1.0], [0.4, 0.3, 1.5], [0, 0, -1]])
    pixels, status, by_point, by_pose, by_params = camera.project_with_jacobians(given, np.eye(4))
    assert by_point.shape == (3, 2, 3) and by_pose.shape == (3, 2, 6) and by_params.shape == (3, 2, 9)
    assert list(status) == [0, 0, 1] and np.isnan(by_point[2]).all() and np.isnan(by_params[2]).all()
    step = 1e-6
    for axis in range(3):
        moved = given.copy()
        moved[:, axis] += step
        numeric = (camera.project(moved)[0] - pixels)[:2] / step
        np.testing.assert_allclose(by_point[:2, :, axis], numeric, atol=2e-2)
        np.testing.assert_allclose(by_pose[:2, :, axis], numeric, atol=2e-2)
    names = list(camera.parameters)
    for i, name in enumerate(names):
        changed = dict(camera.parameters)
        changed[name] += step
        numeric = (alidade.Camera(camera.model, camera.size, changed).project(given)[0] - pixels)[:2] / step
        np.testing.assert_allclose(by_params[:2, :, i], numeric, atol=2e-2)
    rays, ok, by_pixel = camera.unproject_with_jacobians(pixels[:2])
    numeric = (camera.unproject(pixels[:2] + [1e-3, 0])[0] - rays) / 1e-3
    np.testing.assert_allclose(by_pixel[:, :, 0], numeric, atol=1e-6)
    assert list(ok) == [0, 0]


def test_entrance_pupil_is_seen_by_near_points():
    parameters = [260, 260, 320, 240, 0.01, 0, 0, 0]
    fixed = alidade.Camera("kannala_brandt", (640, 480), parameters)
    moving = alidade.Camera("kannala_brandt", (640, 480), parameters, pupil=(0.002, 0))
    assert fixed.pupil == (0, 0)
    assert moving.pupil == (0.002, 0)
    far = [[1e8, 2e7, 1e8]]
    np.testing.assert_allclose(moving.project(far)[0], fixed.project(far)[0], atol=1e-6)
    ray = np.array([1, 0, 1]) / np.sqrt(2)
    start = np.array([0, 0, 0.002 * (np.pi / 4) ** 2])
    np.testing.assert_allclose(moving.project([start + 0.2 * ray])[0], fixed.project([ray])[0], atol=1e-9)
    with pytest.raises(alidade.InputError, match="-0.1 to 0.1"):
        alidade.Camera("kannala_brandt", (640, 480), parameters, pupil=(1, 0))


@pytest.mark.parametrize("jobs", [0, 1, 3])
def test_threads_do_not_change_a_digit(camera, jobs):
    given = points(100_000)
    assert np.array_equal(camera.project(given)[0], camera.project(given, jobs=jobs)[0], equal_nan=True)


def test_other_arrays_are_converted(camera):
    given = points(64)
    expected = camera.project(given)[0]
    others = {"fortran": np.asfortranarray(given), "strided": np.repeat(given, 2, axis=0)[::2], "big-endian": given.astype(">f8"),
              "list": given.tolist(), "reversed": given[::-1].copy()[::-1], "unaligned": np.frombuffer(b"x" + given.tobytes(), offset=1).reshape(-1, 3)}
    for name, other in others.items():
        assert np.array_equal(camera.project(other)[0], expected, equal_nan=True), name
    assert len(others) == 6
    single = given.astype(np.float32)
    assert np.array_equal(camera.project(single)[0], camera.project(single.astype(np.float64))[0], equal_nan=True)
    assert np.array_equal(camera.project(np.array([[1, 2, 30]]))[0], camera.project(np.array([[1.0, 2.0, 30.0]]))[0])


def test_arrays_of_any_shape(camera):
    given = points(24)
    expected, status = camera.project(given)
    pixels, grid_status = camera.project(given.reshape(2, 3, 4, 3))
    assert pixels.shape == (2, 3, 4, 2) and grid_status.shape == (2, 3, 4)
    assert np.array_equal(pixels.reshape(-1, 2), expected, equal_nan=True) and np.array_equal(grid_status.ravel(), status)
    pixel, code = camera.project([0.1, 0.1, 1])
    assert pixel.shape == (2,) and code.shape == () and code == 0
    for empty in (np.empty((0, 3)), np.empty((4, 0, 3))):
        pixels, status = camera.project(empty)
        assert pixels.shape == (*empty.shape[:-1], 2) and status.shape == empty.shape[:-1]
    assert camera.unproject(np.empty((0, 2)))[0].shape == (0, 3)


def test_not_a_number_has_no_pixel(camera):
    given = np.array([[np.nan, 0, 1], [0, np.inf, 1], [0, 0, 0], [0.1, 0.1, 1]])
    pixels, status = camera.project(given)
    assert list(status[:2]) == [2, 2] and status[2] != 0 and status[3] == 0
    assert np.isnan(pixels[:3]).all()
    assert list(camera.unproject([[np.nan, 1], [1e9, 0]])[1]) == [2, 2]


def test_read_only_and_uncopied(camera):
    given = points(1000)
    before = given.copy()
    given.flags.writeable = False
    camera.project(given)
    assert np.array_equal(given, before)


def test_results_may_be_overwritten(camera):
    given = points(1000)
    expected = camera.project(given)
    out = np.empty((1000, 2)), np.empty(1000, np.uint8)
    pixels, status = camera.project(given, out=out)
    assert pixels is out[0] and status is out[1]
    assert np.array_equal(pixels, expected[0], equal_nan=True) and np.array_equal(status, expected[1])
    rays = camera.unproject(pixels, out=(np.empty((1000, 3)), status))
    assert np.array_equal(rays[0], camera.unproject(pixels)[0], equal_nan=True) and rays[1] is status
    fixed = np.empty((1000, 2))
    fixed.flags.writeable = False
    wrong = [(out[0][:999], out[1]), (out[0].astype(np.float32), out[1]), (out[0], out[1].astype(int)), out[0], (fixed, out[1]),
             (np.empty((1000, 4))[:, ::2], out[1]), (None, None)]
    for arrays in wrong:
        with pytest.raises(alidade.UsageError, match=r"out: .*\(1000, 2\)"):
            camera.project(given, out=arrays)
    assert len(wrong) == 7


@pytest.mark.parametrize("wrong", [np.zeros((3, 2)), np.zeros(4), np.float64(1), np.zeros((0,)), np.zeros((2, 3), complex),
                                   np.array([["1", "2", "3"]]), [["a", "b", "c"]], None, object(), np.zeros((1, 3), bool)])
def test_wrong_arrays_are_refused(camera, wrong):
    with pytest.raises(alidade.UsageError, match="points: ") as caught:
        camera.project(wrong)
    assert isinstance(caught.value, ValueError) and isinstance(caught.value, alidade.Error) and "expected" in str(caught.value)


def test_eight_threads_share_a_camera(camera):
    given = points(20_000)
    expected = camera.project(given)[0]
    same = []
    threads = [threading.Thread(target=lambda: same.extend(np.array_equal(camera.project(given)[0], expected, equal_nan=True)
                                                           for _ in range(10))) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert same == [True] * 80


def test_works_after_fork(camera):
    given = points(200_000)
    expected = camera.project(given, jobs=2)[0]
    child = os.fork()
    if child == 0:
        os._exit(0 if np.array_equal(camera.project(given, jobs=2)[0], expected, equal_nan=True) else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def test_every_model_projects():
    assert len(alidade.models()) == 20
    for model in alidade.models():
        names = alidade.parameter_names(model)
        values = {"fx": 500, "fy": 500, "cx": 320, "cy": 240}
        camera = alidade.Camera(model, (640, 480), {n: values.get(n, 0.9 if n == "w" else 1.0 if n == "beta" else 0.0) for n in names})
        pixel, status = camera.project([0.0, 0.0, 1.0])
        assert status == 0 and np.allclose(pixel, [320, 240])
        assert list(camera.parameters) == names and camera.parameter_values.shape == (len(names),)


def test_camera_from_names_or_numbers(camera):
    again = alidade.Camera("radtan", (640, 480), camera.parameter_values, name="front")
    assert again.parameters == camera.parameters and again.name == "front" and again.calibration is None
    assert eval(repr(again), {"Camera": alidade.Camera}).parameters == camera.parameters
    assert "535" in again._repr_html_() and "front" in again._repr_html_()
    with pytest.raises(alidade.InputError, match="fx"):
        alidade.Camera("radtan", (640, 480), {**camera.parameters, "fx": -1})
    with pytest.raises(alidade.Error, match="k3"):
        alidade.Camera("radtan", (640, 480), {k: v for k, v in camera.parameters.items() if k != "k3"})
    with pytest.raises(alidade.UsageError, match="radtan"):
        alidade.Camera("radtam", (640, 480), camera.parameters)
    for size in ((640, 0), (640,), "640x480", None):
        with pytest.raises(alidade.UsageError, match="width, height"):
            alidade.Camera("radtan", size, camera.parameters)


def test_pickles(camera):
    again = pickle.loads(pickle.dumps(camera))
    assert again.parameters == camera.parameters and again.size == camera.size


def test_edits(camera):
    half = camera.resize((320, 240))
    pixels = camera.project(points(100))[0]
    np.testing.assert_allclose(half.project(points(100))[0], (pixels + 0.5) / 2 - 0.5)
    part = camera.crop(10, 20, 300, 200)
    assert part.size == (300, 200)
    np.testing.assert_allclose(part.project(points(100))[0], pixels - [10, 20])
    other, error = camera.to_model("rational")
    assert other.model == "rational" and 0 <= error < 1e-6


def test_undistort_map(camera):
    table, pinhole = camera.undistort_map(keep="valid")
    assert table.shape == (480, 640, 2) and table.dtype == np.float32 and not np.isnan(table).any()
    assert pinhole.model == "pinhole" and pinhole.size == (640, 480)
    rays = pinhole.unproject([[100.0, 50.0]])[0]
    np.testing.assert_allclose(table[50, 100], camera.project(rays)[0][0], atol=1e-3)
    wide, none = camera.undistort_map("cylindrical", fov_deg=100, size=(300, 200))
    assert wide.shape == (200, 300, 2) and none is None
    for wrong in ({"keep": "most"}, {"projection": "flat"}, {"keep": "all", "fov_deg": 50}):
        with pytest.raises(alidade.UsageError):
            camera.undistort_map(**wrong)


def test_files(camera, tmp_path):
    path = tmp_path / "camera.yaml"
    alidade.save_camera(path, camera)
    assert alidade.load_camera(str(path)).parameters == camera.parameters
    for format in ("opencv", "ros", "kalibr"):
        other = tmp_path / f"{format}.yaml"
        alidade.save_camera(other, camera.to_model("pinhole")[0] if format == "kalibr" else camera, format)
        assert [c.size for c in alidade.load_cameras(os.fsencode(other))] == [(640, 480)]
    with pytest.raises(alidade.UsageError, match="opencv"):
        alidade.save_camera(tmp_path / "x.yaml", camera, "opencw")
    with pytest.raises(alidade.InputError, match="nowhere"):
        alidade.load_camera(tmp_path / "nowhere.yaml")
    damaged = path.read_text().replace("fx: 535", "fx: 5x35")
    path.write_text(damaged)
    with pytest.raises(alidade.InputError, match=r"camera.yaml:\d+: .*fx"):
        alidade.load_camera(path)
    with pytest.raises(TypeError):
        alidade.load_camera(3)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["camera.yaml", "kalibr.yaml", "opencv.yaml", "ros.yaml"]


def test_gives_a_covariance_without_standard_deviations(tmp_path):
    lines = (DATA.parent / "camera_files/version_1.yaml").read_text(encoding="utf-8").splitlines(keepends=True)
    file = tmp_path / "camera.yaml"
    file.write_text("".join(line for line in lines if "parameter_std:" not in line), encoding="utf-8")
    covariance = alidade.load_camera(file).calibration.covariance
    assert covariance.shape == (9, 9) and np.array_equal(covariance, covariance.T)
