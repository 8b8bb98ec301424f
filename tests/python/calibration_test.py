# SPDX-License-Identifier: MIT
"""Detection, calibration and checks from Python, and the same numbers as the program's."""
import pathlib
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import alidade
from conftest import DATA, SPEC, alidade_program, python

cv2 = pytest.importorskip("cv2")


def test_boards():
    board = alidade.Board(SPEC)
    assert (board.spec, board.columns, board.rows, board.points.shape) == (SPEC, 9, 6, (54, 3))
    np.testing.assert_allclose(board.points[10], [0.025, 0.025, 0], atol=1e-15)
    assert board == alidade.Board(repr(board)[7:-2]) and board != alidade.Board("checkerboard:9x6:20mm")
    with pytest.raises(alidade.UsageError, match="did you mean 'checkerboard'"):
        alidade.Board("chequerboard:9x6:25mm")


def test_finds_the_corners_of_the_program(photos, corners, tmp_path):
    names, views = corners
    survey = alidade.detect(DATA / "images", SPEC)
    assert len(survey) == len(survey.boards) * survey.num_images == 12 and survey.num_found == len(names)
    for detection, name, (ids, pixels, sigmas) in zip(survey, names, views):
        assert detection.image == name and detection.reason in ("found", "partial", "cut")
        assert np.array_equal(detection.ids, ids) and np.array_equal(detection.pixels, pixels)
        assert np.array_equal(detection.sigma_px, sigmas)
        assert np.array_equal(detection.all_pixels[detection.ids], detection.pixels)
    survey.save(tmp_path / "corners.csv")
    loaded = alidade.load_corners(tmp_path / "corners.csv")
    assert [d.image for d in loaded] == names and all(np.array_equal(a.pixels, b.pixels) for a, b in zip(loaded, survey))
    with pytest.raises(IndexError):
        survey[12]


def test_images_from_arrays(photos):
    gray = cv2.imread(str(photos[0]), cv2.IMREAD_GRAYSCALE)
    expected = alidade.detect([photos[0]], SPEC)[0].pixels
    padded = np.zeros((480, 700), np.uint8)
    padded[:, :640] = gray
    kinds = {"gray": gray, "row padding": padded[:, :640], "color": np.dstack([gray] * 3), "column": gray[:, :, None],
             "fortran": np.asfortranarray(gray), "alpha": np.dstack([gray] * 4), "flipped twice": gray[::-1].copy()[::-1]}
    for name, image in kinds.items():
        detection = alidade.detect(image, SPEC)
        assert detection and np.array_equal(detection.pixels, expected), name
    assert len(kinds) == 7
    deep = alidade.detect(gray.astype(np.uint16) * 16, SPEC)
    assert np.abs(deep.pixels - expected).max() < 0.05
    assert np.array_equal(alidade.detect((gray.astype(np.uint16) * 16).astype(">u2"), SPEC).pixels, deep.pixels)
    survey = alidade.detect([gray, gray[::-1].copy() * 0], SPEC, names=["one", "black"])
    assert [d.image for d in survey] == ["one", "black"] and not survey[1] and survey[1].message
    for wrong in (gray.astype(float), np.zeros((4, 5, 2), np.uint8), np.zeros((0, 5), np.uint8), gray.astype(np.int32)):
        with pytest.raises(alidade.UsageError):
            alidade.detect([wrong], SPEC)


def test_writes_the_file_of_the_program(corners_file, corners, result, tmp_path):
    alidade_program("calibrate", corners_file, "-o", tmp_path / "program.yaml", "--quiet")
    expected = (tmp_path / "program.yaml").read_bytes()
    result.save(tmp_path / "tuples.yaml")
    assert (tmp_path / "tuples.yaml").read_bytes() == expected
    names, views = corners
    dense = np.full((len(names), 54, 2), np.nan)
    sigmas = np.full((len(names), 54), np.nan)
    for i, (ids, pixels, sigma) in enumerate(views):
        dense[i, ids] = pixels
        sigmas[i, ids] = sigma
    alidade.calibrate(alidade.load_corners(corners_file)).save(tmp_path / "survey.yaml")
    assert (tmp_path / "survey.yaml").read_bytes() == expected
    alidade.calibrate(str(DATA / "images"), SPEC).save(tmp_path / "images.yaml")
    assert (tmp_path / "images.yaml").read_bytes() == expected
    without = alidade.calibrate(dense, SPEC, image_size=(640, 480), names=names, model="radtan")
    again = alidade.calibrate([(ids, pixels) for ids, pixels, _ in views], SPEC, image_size=(640, 480), names=names, model="radtan")
    assert without.camera.parameters == again.camera.parameters


def test_result(result, tmp_path):
    camera = result.camera
    assert result.verdict == camera.calibration.verdict and result.is_usable
    assert result.accuracy_px == result.accuracy.covered_px and abs(camera.calibration.accuracy_px / result.accuracy_px - 1) < 0.01
    accuracy = result.accuracy
    assert accuracy.pixels.shape == (*accuracy.error_px.shape, 2) and accuracy.is_covered.dtype == bool
    assert np.nanmax(accuracy.error_px[accuracy.is_covered]) == accuracy.covered_px
    assert 0 <= accuracy.share_within(0.1) <= accuracy.share_within(1) <= 1
    squares = corners = 0
    for view in result.views:
        pose = view.camera_from_board
        assert view.residuals.shape == view.pixels.shape == (len(view.ids), 2) and pose.shape == (4, 4)
        squares += (view.residuals ** 2).sum()
        corners += len(view.ids)
        assert abs(np.sqrt((view.residuals ** 2).sum() / len(view.ids)) - view.rms_px) < 1e-12
    assert len(result.views) == 12 and abs(np.sqrt(squares / corners) - result.rms_px) < 1e-12
    assert camera.calibration.covariance.shape == (len(camera.parameters),) * 2
    assert result.evidence["rms_px"] == result.rms_px and len(result.evidence["views"]) == 12
    for finding in result.findings:
        assert finding.id and finding.message and finding.severity in ("note", "warning", "failure")
    assert "alidade.Calibration" in repr(result) and result.verdict in repr(result)
    html = result._repr_html_()
    assert html.count("<img") == 2 and result.verdict in html and html.count("image/svg+xml") == 2
    result.report(tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert page.startswith("<!DOCTYPE html>") and 'id="evidence"' in page


def test_report_shows_the_photographs(tmp_path):
    result = alidade.calibrate(DATA / "images", SPEC, model="radtan")
    result.report(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text().count("data:image/jpeg") >= 12


def test_report_shows_frames_of_videos(tmp_path):
    video = str(tmp_path / "board.avi")
    writer = cv2.VideoWriter(video, cv2.VideoWriter_fourcc(*"MJPG"), 5, (640, 480))
    for photo in sorted((DATA / "images").glob("*.png")):
        for _ in range(2):
            writer.write(cv2.imread(str(photo)))
    writer.release()
    result = alidade.calibrate(video, SPEC, model="radtan")
    result.report(tmp_path / "page.html")
    pictures = re.findall("data:image/jpeg[^\"]+", (tmp_path / "page.html").read_text())
    assert len(result.views) == 12 and len(set(pictures)) >= 12
    pathlib.Path(video).unlink()
    result.report(tmp_path / "page.html")  # the corners in their place
    assert "data:image/jpeg" not in (tmp_path / "page.html").read_text()


def test_options(corners, camera):
    names, views = corners
    common = dict(image_size=(640, 480), names=names, model="radtan")
    fixed = alidade.calibrate(views, SPEC, initial=camera, fix=["cx", "cy"], **common).camera
    assert (fixed.parameters["cx"], fixed.parameters["cy"]) == (camera.parameters["cx"], camera.parameters["cy"])
    equal = alidade.calibrate(views, SPEC, same_focal=True, name="front", **common).camera
    assert equal.parameters["fx"] == equal.parameters["fy"] and equal.name == "front"
    wrong = [dict(model="radtam"), dict(fix=["k9"]), dict(board_shape="round"), dict(tolerance_px=0), dict(tolerance_px="1px"),
             dict(modell="radtan"), dict(image_size=None), dict(names=names[:3])]
    for options in wrong:
        with pytest.raises(alidade.UsageError):
            alidade.calibrate(views, SPEC, **{**common, **options})
    with pytest.raises(alidade.UsageError, match="tolerance_px"):
        alidade.calibrate(views, SPEC, tolerance=1, **common)
    with pytest.raises(alidade.InputError, match="only 2 of 2.*expected at least 3"):
        alidade.calibrate(views[:2], SPEC, image_size=(640, 480))
    with pytest.raises(alidade.UsageError, match="54"):
        alidade.calibrate([pixels[:50] for _, pixels, _ in views], SPEC, image_size=(640, 480))
    with pytest.raises(alidade.UsageError, match="no board"):
        alidade.calibrate(views, image_size=(640, 480))
    assert len(wrong) == 8


def test_a_rejected_camera_is_not_written(corners, tmp_path):
    names, views = corners
    spoiled = [(ids, pixels + 30 * np.sin(ids * 1.7 + i)[:, None], sigma) for i, (ids, pixels, sigma) in enumerate(views)]
    path = tmp_path / "camera.yaml"
    try:
        result = alidade.calibrate(spoiled, SPEC, image_size=(640, 480), names=names, model="radtan")
    except alidade.InputError as error:
        assert "next:" in str(error)
        return
    assert not result.is_usable and result.warnings[0].severity == "failure"
    with pytest.raises(alidade.Error, match="must not be used"):
        result.save(path)
    assert not path.exists()
    result.save(path, keep_untrustworthy=True)
    assert path.exists()


def test_progress_and_its_exceptions(photos):
    seen = []
    alidade.detect(photos[:4], SPEC, progress=lambda *report: seen.append(report))
    assert seen[-1] == ("detecting boards", 4, 4)
    class Stop(Exception):
        pass
    def stop(*_):
        raise Stop
    with pytest.raises(Stop):
        alidade.detect(photos, SPEC, progress=stop)


def test_other_threads_run_during_a_calibration(corners):
    import threading
    names, views = corners
    counted, done = [0], threading.Event()
    def count():
        while not done.is_set():
            counted[0] += 1
    thread = threading.Thread(target=count)
    thread.start()
    alidade.calibrate(views, SPEC, image_size=(640, 480), names=names)
    done.set()
    thread.join()
    assert counted[0] > 1000


INTERRUPTED = """
import os, signal, sys, threading, alidade, cv2
images = 3000 * [cv2.imread(sys.argv[1], cv2.IMREAD_GRAYSCALE)]
num_done = 0
def progress(stage, done, total):
    global num_done
    if num_done == 0:
        threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT)).start()  # while the main thread is in the library
    num_done = done
try:
    alidade.detect(images, "checkerboard:9x6:25mm", progress=progress)
except KeyboardInterrupt:
    print("interrupted", 0 < num_done < len(images))
"""


def test_interrupt_stops_a_search(photos):
    run = python(INTERRUPTED, photos[0], timeout=250)
    assert run.stdout.strip() == "interrupted True" and run.returncode == 0, run.stderr


def test_interrupt_ends_the_interpreter(photos):
    code = "import sys, alidade\nprint('ready', flush=True)\nwhile True: alidade.calibrate(sys.argv[1:], 'checkerboard:9x6:25mm')"
    process = subprocess.Popen([sys.executable, "-c", code, *map(str, photos)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    assert "KeyboardInterrupt" in process.communicate(timeout=100)[1]
    assert process.returncode == -signal.SIGINT


def test_validates(tmp_path, camera, photos):
    (good,) = alidade.validate(DATA / "camera.yaml")
    assert good and good.format == "alidade" and good.checks and good.error == ""
    assert {check.severity for check in good.checks} <= {"pass", "note", "warning"}
    (tested,) = alidade.validate(DATA / "camera.yaml", DATA / "images", SPEC)
    assert tested and {"held_out_error", "images_agree"} <= {check.id for check in tested.checks}
    alidade.save_camera(tmp_path / "wrong.yaml", alidade.Camera("radtan", (640, 480), {**camera.parameters, "fx": 700}))
    (tmp_path / "broken.yaml").write_text("camera_model: pinhole\nintrinsics: [1, 2]\n")
    judged = {file.file.rsplit("/", 1)[1]: file for file in alidade.validate(tmp_path, against=camera)}
    assert len(judged) == 2 and not judged["wrong.yaml"] and judged["broken.yaml"].error
    against = next(check for check in judged["wrong.yaml"].checks if check.id == "against")
    assert against.severity == "failure" and against.message
    html = judged["wrong.yaml"]._repr_html_()
    assert html.count("image/svg+xml") == 1 and against.message[:20] in html and "<td" not in judged["broken.yaml"]._repr_html_()
    assert tested._repr_html_().count("image/svg+xml") == 1 and "<img" not in good._repr_html_()
    with pytest.raises(alidade.InputError, match="nowhere"):
        alidade.validate(tmp_path / "nowhere")
    with pytest.raises(alidade.UsageError, match="board without images"):
        alidade.validate(DATA / "camera.yaml", board=SPEC)


def test_compares(camera, result):
    same = alidade.diff(camera, DATA / "camera.yaml")
    assert same.max_px < 1e-9 and same.is_significant is None and same.answer() == "same"
    difference = alidade.diff(camera, result.camera)
    lengths = np.linalg.norm(difference.difference_px, axis=-1)
    assert difference.is_significant is not None and np.isfinite(lengths).sum() == difference.num_compared > 1000
    assert abs(np.sqrt(np.nanmean(lengths ** 2)) - difference.rms_px) < 1e-12 and np.nanmax(lengths) == difference.max_px < 2
    assert abs(np.nanmean(lengths) - difference.mean_px) < 1e-12 and 0 < difference.p95_px < difference.max_px
    assert difference.difference_px.shape == difference.pixels.shape and difference.b_from_a.shape == (4, 4)
    assert "alidade.Difference" in repr(difference)
    assert difference.answer(0.001) == "cannot tell" and difference.answer(tolerance_px=100) == "same"
    html = difference._repr_html_()
    assert html.count("image/svg+xml") == 1 and "significant" in html and f"{difference.rms_px:.4g} px" in html
    with pytest.raises(alidade.UsageError):
        alidade.diff(camera, camera, distance_m=1, same_frame=True)
    with pytest.raises(alidade.InputError):
        alidade.diff(camera, camera.crop(0, 0, 640, 100))


def test_rig(camera, tmp_path):
    rng = np.random.default_rng(3)
    board = alidade.Board(SPEC)
    right_from_left = np.eye(4)
    right_from_left[0, 3] = -0.1
    views = {"left": [], "right": []}
    for _ in range(14):
        a, b, c = rng.uniform(-0.5, 0.5, 3)
        rx = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
        ry = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
        rz = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
        pose = np.eye(4)
        pose[:3, :3] = rx @ ry @ rz
        pose[:3, 3] = pose[:3, :3] @ [-0.1, -0.06, 0] + [rng.uniform(-0.1, 0.2), rng.uniform(-0.1, 0.1), rng.uniform(0.4, 0.6)]
        for name, placed in (("left", pose), ("right", right_from_left @ pose)):
            pixels = camera.project(board.points, placed)[0]
            pixels[((pixels < 0) | (pixels > [639, 479])).any(axis=1)] = np.nan
            views[name].append(pixels + rng.normal(0, 0.05, pixels.shape))
    rig = alidade.calibrate_rig(views, board, image_size=(640, 480), model="radtan")
    assert [c.name for c in rig.cameras] == ["left", "right"] and 0.05 < rig.rms_px < 0.1
    np.testing.assert_allclose(rig.cameras[1].camera_from_rig, right_from_left, atol=3e-3)
    rig.save(tmp_path / "rig.yaml", keep_untrustworthy=True)
    saved = alidade.load_cameras(tmp_path / "rig.yaml")
    assert [c.parameters for c in saved] == [c.parameters for c in rig.cameras]
    assert np.array_equal(saved[1].camera_from_rig, rig.cameras[1].camera_from_rig)
    rig.report(tmp_path / "rig.html")
    assert 'id="evidence"' in (tmp_path / "rig.html").read_text() and rig._repr_html_().count("<img") == 1
    with pytest.raises(alidade.UsageError, match="two or more"):
        alidade.calibrate_rig({"left": views["left"]}, board, image_size=(640, 480))
    renamed, count = re.subn('name: "?left"?', "name: middle", (tmp_path / "rig.yaml").read_text())
    assert count == 2  # where it is, and the camera itself
    (tmp_path / "other.yaml").write_text(renamed)
    with pytest.raises(alidade.InputError, match="middle.*expected those of a: left"):
        alidade.diff_rigs(rig, tmp_path / "other.yaml")
    same = alidade.diff_rigs(rig, tmp_path / "rig.yaml")
    assert list(same.lenses) == ["left", "right"] and same.places["right"][0] < 1e-9 and same.distance_m == pytest.approx(1, rel=0.05)
    assert all(lens.max_px < 1e-9 for lens in same.lenses.values())
    assert same.transfers["right"]["from_camera"] == "left" and same.transfers["right"]["max_px"] < 1e-6
    again = alidade.calibrate_rig({name: [view + rng.normal(0, 0.3, view.shape) for view in of_camera] for name, of_camera in
                                   views.items()}, board, image_size=(640, 480), model="radtan")
    difference = alidade.diff_rigs(rig, again, distance_m=0.5)
    assert difference.distance_m == 0.5 and 0 < difference.places["right"][0] < 0.01 and difference.places["left"] == (0, 0)
    assert 0.01 < difference.transfers["left"]["p95_px"] < 5 and "0.5 m" in repr(difference)
    with pytest.raises(alidade.UsageError, match="distance_m"):
        alidade.diff_rigs(rig, again, distance_m=0)
