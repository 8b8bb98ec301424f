# SPDX-License-Identifier: MIT
"""Rotations and poses from Python."""
import warnings

import numpy as np
import pytest

import alidade
from alidade import SE3

RNG = np.random.default_rng(5)


def drawn(*shape):
    return SE3.from_quaternion(RNG.normal(size=(*shape, 4)), RNG.normal(size=(*shape, 3)))


@pytest.mark.parametrize("shape", [(), (7,), (2, 3), (0,)])
def test_each_form_gives_the_pose_back(shape):
    pose = drawn(*shape)
    t = pose.translation
    assert pose.shape == shape and pose.matrix.shape == (*shape, 4, 4) and t.shape == (*shape, 3)
    backs = [SE3(pose.matrix), SE3(pose.matrix[..., :3, :]), SE3.from_rotation(pose.rotation, t),
             SE3.from_rotation_vector(pose.rotation_vector(), t),
             SE3.from_rotation_vector(pose.rotation_vector(degrees=True), t, degrees=True)]
    backs += [SE3.from_quaternion(pose.quaternion(order), t, order=order) for order in ("xyzw", "wxyz")]
    backs += [SE3.from_euler(order, pose.euler(order, degrees=degrees), t, degrees=degrees)
              for order in ("ZYX", "XYZ", "ZXZ", "xyz", "yxy") for degrees in (False, True)]
    assert len(backs) == 17
    for back in backs:
        np.testing.assert_allclose(back.matrix, pose.matrix, atol=1e-12)


def test_angles_have_the_order_that_the_letters_say():
    turn = {axis: SE3.from_rotation_vector(angle * np.eye(3)["xyz".index(axis)]) for axis, angle in zip("xyz", (0.1, 0.2, 0.3))}
    moving = turn["z"] @ turn["y"] @ turn["x"]
    np.testing.assert_allclose(moving.euler("ZYX"), [0.3, 0.2, 0.1], atol=1e-14)
    np.testing.assert_allclose(moving.euler("xyz"), [0.1, 0.2, 0.3], atol=1e-14)
    np.testing.assert_allclose(SE3.from_euler("ZYX", [90, 0, 0], degrees=True).apply([1, 0, 0]), [0, 1, 0], atol=1e-15)


def test_gimbal_lock_warns():
    with pytest.warns(RuntimeWarning, match="gimbal lock"):
        SE3.from_euler("ZYX", [10, 90, 20], degrees=True).euler()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        SE3.from_euler("ZYX", [10, 89, 20], degrees=True).euler()


def test_composes_inverts_and_applies():
    a, b, points = drawn(), drawn(4), RNG.normal(size=(9, 3))
    np.testing.assert_allclose((a @ b).matrix, a.matrix @ b.matrix, atol=1e-12)
    np.testing.assert_allclose((b @ b.inverse()).matrix, np.broadcast_to(np.eye(4), (4, 4, 4)), atol=1e-12)
    np.testing.assert_allclose(a.apply(points), points @ a.rotation.T + a.translation, atol=1e-12)
    every = b[:, None].apply(points)
    assert every.shape == (4, 9, 3) and len(b) == 4
    for i in range(4):
        np.testing.assert_allclose(every[i], b[i].apply(points), atol=1e-12)
    np.testing.assert_array_equal(SE3().matrix, np.eye(4))
    with pytest.raises(ValueError):
        a.matrix[0, 0] = 2


def test_is_a_pose_for_the_camera(camera):
    pose = SE3.from_rotation_vector([0, 0.1, 0], [0, 0, 2])
    points = RNG.uniform(-0.2, 0.2, (20, 3))
    np.testing.assert_array_equal(camera.project(points, pose)[0], camera.project(points, pose.matrix)[0])


def test_what_is_no_rotation_is_refused():
    refused = [(lambda: SE3(np.diag([1, 1, -1, 1])), "reflection"), (lambda: SE3(2 * np.eye(4)), "last row"),
               (lambda: SE3.from_rotation(1.1 * np.eye(3)), "column 0 has length 1.1"), (lambda: SE3(np.eye(3)), "shape"),
               (lambda: SE3.from_quaternion([0, 0, 0, 0]), "not all zero"), (lambda: SE3.from_quaternion([0, 0, 1]), "shape"),
               (lambda: SE3.from_quaternion([0, 0, 0, 1], order="wzyx"), "'wxyz'"), (lambda: SE3.from_euler("zYx", [0, 0, 0]), "capitals"),
               (lambda: SE3.from_euler("ZZX", [0, 0, 0]), "euler_zzx_rad"), (lambda: SE3.from_rotation(np.eye(3), [1, 2]), "translation"),
               (lambda: SE3.from_rotation_vector([[0, 0, 0], [0, 0, np.nan]]), "finite"), (lambda: SE3().apply([1, 2]), "points")]
    for call, message in refused:
        with pytest.raises(alidade.UsageError, match=message):
            call()
    assert len(refused) == 12
