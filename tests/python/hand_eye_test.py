# SPDX-License-Identifier: MIT
"""Hand-eye calibration from Python, and the same file as the program's."""
import numpy as np
import pytest

import alidade
from alidade import SE3
from conftest import DATA, SPEC, alidade_program

SIZE = (640, 480)
BOARD = alidade.Board(SPEC)
MOUNT = SE3.from_euler("ZYX", [88, 3, -2], [0.05, -0.03, 0.06], degrees=True)
WORLD = SE3.from_euler("ZYX", [20, 1, 179], [0.6, 0.05, 0.02], degrees=True)


def recorded(on, count=12):
    """Corners, and what the robot states: base_from_gripper, within 0.1 mm and 0.0002 rad."""
    rng = np.random.default_rng(8)
    camera = alidade.load_camera(DATA / "camera.yaml")
    corners, poses = [], []
    while len(corners) < count:
        turn = SE3.from_rotation_vector([*rng.uniform(-0.6, 0.6, 2), rng.uniform(-1, 1)])
        middle = [rng.uniform(-0.05, 0.05), rng.uniform(-0.04, 0.04), rng.uniform(0.3, 0.45)]
        camera_from_board = SE3.from_rotation(turn.rotation, middle - turn.rotation @ BOARD.points.mean(axis=0))
        pixels, status = camera.project(BOARD.points, camera_from_board)
        if status.any() or (pixels < 0).any() or (pixels > np.array(SIZE) - 1).any():
            continue
        corners.append(pixels + rng.normal(0, 0.05, pixels.shape))
        error = SE3.from_rotation_vector(rng.normal(0, 2e-4, 3), rng.normal(0, 1e-4, 3))
        at = MOUNT @ camera_from_board @ WORLD.inverse()
        poses.append(((at.inverse() if on == "hand" else at) @ error).matrix)
    return corners, poses


def calibrated(on, poses=None, **options):
    corners, stated = recorded(on)
    return alidade.calibrate_hand_eye(corners, stated if poses is None else poses, BOARD,
                                      **{"image_size": SIZE, "model": "radtan", **options})


@pytest.mark.parametrize("on", ["hand", "base"])
def test_finds_the_transform(on):
    corners, poses = recorded(on)
    result = calibrated(on, list(enumerate(poses)))
    assert result.camera_on == on and result.is_usable and result.verdict == "trustworthy" and not result.warnings
    off = SE3(result.mount_from_camera) @ MOUNT.inverse()
    seen = MOUNT.apply([0, 0, 0.37])
    assert np.linalg.norm(off.apply(seen) - seen) < 1.5 * result.error_m < 1.5e-3
    np.testing.assert_allclose(result.world_from_boards, [WORLD.matrix], atol=2e-3)
    assert result.covariance.shape == (6, 6) and (np.linalg.eigvalsh(result.covariance) > 0).all()
    assert 5e-5 < result.robot_noise["translation_m"] < 2e-4 and 5e-5 < result.robot_noise["rotation_rad"] < 4e-4
    assert result.boards == [SPEC] and result.num_poses == len(result.frames) == 12 and result.finding_ids == []
    for frame, pose in zip(result.frames, poses):
        np.testing.assert_allclose(frame.base_from_gripper, pose, atol=1e-12)
        assert frame.reason == "" and 0 < frame.sigmas < 3 and frame.deviation.shape == (6,) and 0.03 < frame.rms_px < 0.12
    again = calibrated(on, {f"view{i:04d}": pose for i, pose in enumerate(poses)}, camera_on=on)
    np.testing.assert_array_equal(again.mount_from_camera, result.mount_from_camera)
    assert f"camera on the {on}" in repr(result) and "view0000" in repr(result.frames[0])


def test_keeps_a_camera(camera):
    result = calibrated("hand", list(enumerate(recorded("hand")[1])), camera=camera, model=None)
    np.testing.assert_allclose(result.mount_from_camera, MOUNT.matrix, atol=1e-3)
    refused = [({"camera": camera}, "one of them"), ({"camera": "camera.yaml", "model": None}, "load_camera"),
               ({"camera_on": "head"}, "'hand', 'base'"), ({"tolerance": "0mm"}, "above 0"), ({"tolerance": "1 parsec"}, "tolerance"),
               ({"pose_form": "kuka"}, "beside matrices"), ({"colour": "bgr"}, "color"),
               ({"poses": [np.eye(4)]}, "list of \\(name, matrix\\)"), ({"poses": {"a": 2 * np.eye(4)}}, "pose of a"),
               ({"poses": [("a", None)]}, "4x4"), ({"poses": 5}, "list of")]
    for options, message in refused:
        with pytest.raises(alidade.UsageError, match=message):
            calibrated("hand", **{"poses": list(enumerate(recorded("hand")[1])), **options})
    assert len(refused) == 11
    with pytest.raises(alidade.InputError, match="2 poses"):
        calibrated("hand", {0: np.eye(4), 1: np.eye(4)})


def test_writes_the_file_of_the_program(tmp_path):
    corners, poses = recorded("hand")
    with open(tmp_path / "poses.csv", "w", encoding="utf-8") as file:
        for i, pose in enumerate(poses):
            file.write(f"view{i:04d}," + ",".join(map(repr, map(float, pose.ravel()))) + "\n")
    with open(tmp_path / "corners.csv", "w", encoding="utf-8") as file:
        file.write("camera,image,width,height,board,corner_id,col,row,u,v,sigma_px\n")
        for i, view in enumerate(corners):
            for k, (u, v) in enumerate(view):
                file.write(f"camera,view{i:04d},640,480,{SPEC},{k},{k % 9},{k // 9},{float(u)!r},{float(v)!r},\n")
    alidade_program("handeye", "calibrate", tmp_path / "corners.csv", "--poses", tmp_path / "poses.csv", "--model", "radtan",
                    "-o", tmp_path / "program.yaml", "--quiet")
    result = calibrated("hand", tmp_path / "poses.csv", pose_form="matrix")
    result.save(tmp_path / "module.yaml")
    assert (tmp_path / "module.yaml").read_bytes() == (tmp_path / "program.yaml").read_bytes()
    loaded = alidade.load_hand_eye(tmp_path / "module.yaml")
    for name in ("mount_from_camera", "covariance", "world_from_boards"):
        np.testing.assert_allclose(getattr(loaded, name), getattr(result, name), rtol=1e-9, atol=1e-15)
    names = ["camera_on", "boards", "robot_noise", "num_poses", "error_m", "rms_px", "verdict", "finding_ids"]
    for name in names:
        assert getattr(loaded, name) == getattr(result, name), name
    loaded.save(tmp_path / "again.yaml")
    assert alidade.load_hand_eye(tmp_path / "again.yaml").error_m == result.error_m
    for form, text in (("ros", "static_transform"), ("urdf", "<joint"), ("opencv", "R_cam2gripper")):
        result.save(tmp_path / form, form)
        assert text in (tmp_path / form).read_text()
    with pytest.raises(alidade.UsageError, match="urdf"):
        result.save(tmp_path / "x", "urd")
    with pytest.raises(alidade.InputError, match="nowhere.yaml"):
        alidade.load_hand_eye(tmp_path / "nowhere.yaml")


def test_says_what_is_wrong(tmp_path):
    poses = recorded("hand")[1]
    poses[3] = poses[3] @ SE3.from_rotation_vector([0.05, 0, 0], [0.03, 0, 0]).matrix
    result = calibrated("hand", list(enumerate(poses)))
    assert [finding.id for finding in result.warnings] == result.finding_ids == ["robot_poses_left_out"]
    assert [frame.image for frame in result.frames if frame.reason] == ["view0003"] and result.num_poses == 11
    rejected = calibrated("hand", list(enumerate(recorded("hand")[1])), tolerance="0.01mm")
    assert not rejected.is_usable and rejected.verdict == "rejected"
    with pytest.raises(alidade.Error, match="must not be used"):
        rejected.save(tmp_path / "rejected.yaml")
    rejected.save(tmp_path / "rejected.yaml", keep_untrustworthy=True)
    assert alidade.load_hand_eye(tmp_path / "rejected.yaml").verdict == "rejected"


def test_has_no_transform_where_poses_contradict_the_images(tmp_path):
    _, poses = recorded("hand")
    rng = np.random.default_rng(9)
    others = [(SE3.from_rotation_vector(rng.uniform(-1, 1, 3), rng.uniform(-0.3, 0.3, 3))).matrix for _ in poses]
    result = calibrated("hand", list(enumerate(others)), camera_on="hand")
    assert result.verdict == "rejected" and not result.is_usable and result.finding_ids[0] == "robot_contradicts"
    assert np.isnan(result.mount_from_camera[:3, 3]).all() and np.isnan(result.error_m) and result.covariance is None
    assert len(result.world_from_boards) == 0 and result.num_poses == 0
    with pytest.raises(alidade.Error, match="must not be used"):
        result.save(tmp_path / "handeye.yaml")
    assert not list(tmp_path.iterdir())
