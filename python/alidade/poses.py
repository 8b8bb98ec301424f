# SPDX-License-Identifier: MIT
"""Rigid motions and their forms: see SE3."""
from __future__ import annotations

import warnings
from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import UsageError, _numbers_from_poses, _poses_from_numbers

_Floats = NDArray[np.float64]


def _euler_form(order: str, degrees: bool) -> str:
    is_fixed = order.islower()
    if not (is_fixed or order.isupper()):
        raise UsageError(f"order: {order!r}; expected three capitals such as 'ZYX' (each turn about the new axes), or three "
                         "small letters such as 'xyz' (about fixed axes)")
    return f"euler_{'fixed_' if is_fixed else ''}{order.lower()}_{'deg' if degrees else 'rad'}"


def _quaternion_form(order: str) -> str:
    if order not in ("xyzw", "wxyz"):
        raise UsageError(f"order: {order!r}; expected 'xyzw' (w last) or 'wxyz' (w first)")
    return f"quaternion_{order}"


class SE3:
    """Rigid motions a_from_b: p_a = a_from_b.apply(p_b), one or an array of them. Metres.

    SE3(matrix) takes matrices (..., 4, 4) or (..., 3, 4); SE3() is the identity. from_quaternion(), from_rotation_vector(),
    from_rotation() and from_euler() take rotations (...) and translations (..., 3). The shapes before the last axes are
    those of the array of motions, and NumPy's broadcasting holds. Immutable. UsageError: another shape, or no rotation.
    np.asarray(pose) is the matrix, so a motion is accepted where a 4x4 matrix is, as by Camera.project().
    """

    __slots__ = ("_matrix",)
    __array_priority__ = 1000  # so that an array leaves matrix @ pose to this class
    _matrix: _Floats

    def __init__(self, matrix: Optional[ArrayLike] = None) -> None:
        given = np.asarray(np.eye(4) if matrix is None else matrix)
        if given.ndim < 2 or given.shape[-2:] not in ((3, 4), (4, 4)):
            raise UsageError(f"matrix: an array of shape {given.shape}; expected (..., 4, 4) or (..., 3, 4)")
        form, count = ("matrix", 16) if given.shape[-2] == 4 else ("matrix_3x4", 12)
        self._keep(_poses_from_numbers(form, given.reshape((*given.shape[:-2], count))))

    def _keep(self, matrix: _Floats) -> SE3:
        self._matrix = matrix
        matrix.flags.writeable = False
        return self

    @classmethod
    def _from_form(cls, form: str, numbers: ArrayLike, translation: Optional[ArrayLike]) -> SE3:
        matrix = _poses_from_numbers(form, numbers)
        if translation is not None:
            moved = np.asarray(translation, dtype=np.float64)
            if moved.ndim == 0 or moved.shape[-1] != 3 or not np.isfinite(moved).all():
                raise UsageError(f"translation: an array of shape {moved.shape}; expected finite numbers (..., 3), metres")
            shape = np.broadcast_shapes(matrix.shape[:-2], moved.shape[:-1])
            matrix = np.broadcast_to(matrix, (*shape, 4, 4)).copy()
            matrix[..., :3, 3] = moved
        return cls.__new__(cls)._keep(matrix)

    @classmethod
    def from_quaternion(cls, quaternion: ArrayLike, translation: Optional[ArrayLike] = None, *, order: str = "xyzw") -> SE3:
        """From quaternions (..., 4) of any length, "xyzw" (w last) or "wxyz" (w first)."""
        return cls._from_form(_quaternion_form(order), quaternion, translation)

    @classmethod
    def from_rotation_vector(cls, vector: ArrayLike, translation: Optional[ArrayLike] = None, *, degrees: bool = False) -> SE3:
        """From axes times angles (..., 3), as OpenCV's rvec."""
        return cls._from_form("rotation_vector_deg" if degrees else "rotation_vector_rad", vector, translation)

    @classmethod
    def from_rotation(cls, rotation: ArrayLike, translation: Optional[ArrayLike] = None) -> SE3:
        """From rotation matrices (..., 3, 3)."""
        given = np.asarray(rotation)
        if given.shape[-2:] != (3, 3):
            raise UsageError(f"rotation: an array of shape {given.shape}; expected (..., 3, 3)")
        return cls._from_form("rotation_matrix", given.reshape((*given.shape[:-2], 9)), translation)

    @classmethod
    def from_euler(cls, order: str, angles: ArrayLike, translation: Optional[ArrayLike] = None, *, degrees: bool = False) -> SE3:
        """From angles (..., 3) in the order of the axes: "ZYX" is yaw, pitch, roll, about z, the new y, the new x.

        Small letters, "xyz", are turns about fixed axes, the first one first, as in SciPy.
        """
        return cls._from_form(_euler_form(order, degrees), angles, translation)

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the array of motions; () for a single one."""
        return self._matrix.shape[:-2]

    @property
    def matrix(self) -> _Floats:
        """Homogeneous matrices (..., 4, 4)."""
        return self._matrix

    @property
    def rotation(self) -> _Floats:
        """Rotation matrices (..., 3, 3)."""
        return self._matrix[..., :3, :3]

    @property
    def translation(self) -> _Floats:
        """Translations (..., 3): the origin of b, in a."""
        return self._matrix[..., :3, 3]

    def _numbers(self, form: str) -> _Floats:
        numbers, is_locked = _numbers_from_poses(form, self._matrix.reshape((*self.shape, 16)))
        if is_locked:
            warnings.warn("gimbal lock: only the sum or difference of the first and the last angle is determined, and one "
                          "is given as 0", RuntimeWarning, stacklevel=3)
        return numbers

    def quaternion(self, order: str = "xyzw") -> _Floats:
        """Unit quaternions (..., 4) with w >= 0, "xyzw" or "wxyz"."""
        return self._numbers(_quaternion_form(order))

    def rotation_vector(self, *, degrees: bool = False) -> _Floats:
        """Axes times angles (..., 3) of 0 to half a turn."""
        return self._numbers("rotation_vector_deg" if degrees else "rotation_vector_rad")

    def euler(self, order: str = "ZYX", *, degrees: bool = False) -> _Floats:
        """Angles (..., 3) in the order of the axes, see from_euler(). RuntimeWarning: gimbal lock."""
        return self._numbers(_euler_form(order, degrees))

    def inverse(self) -> SE3:
        """b_from_a."""
        inverse = np.broadcast_to(np.eye(4), self._matrix.shape).copy()
        inverse[..., :3, :3] = np.swapaxes(self.rotation, -1, -2)
        inverse[..., :3, 3] = -np.einsum("...ij,...j->...i", inverse[..., :3, :3], self.translation)
        return type(self).__new__(type(self))._keep(inverse)

    def apply(self, points: ArrayLike) -> _Floats:
        """The points (..., 3) of frame b in frame a. For each of N motions and M points: poses[:, None].apply(points)."""
        given = np.asarray(points, dtype=np.float64)
        if given.ndim == 0 or given.shape[-1] != 3:
            raise UsageError(f"points: an array of shape {given.shape}; expected (..., 3)")
        return np.einsum("...ij,...j->...i", self.rotation, given) + self.translation

    def __matmul__(self, other: SE3) -> SE3:
        """a_from_c = a_from_b @ b_from_c."""
        if not isinstance(other, SE3):
            return NotImplemented
        return type(self)(self._matrix @ other._matrix)

    def __getitem__(self, index: Any) -> SE3:
        if not self.shape:
            raise TypeError("a single motion has no elements")
        key = index if isinstance(index, tuple) else (index,)
        return type(self)(self._matrix[(*key, slice(None), slice(None))])

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("a single motion has no length")
        return self.shape[0]

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> NDArray[Any]:
        return np.array(self._matrix, dtype=dtype)

    def __repr__(self) -> str:
        if self.shape:
            return f"<alidade.SE3 of shape {self.shape}>"
        return f"SE3.from_quaternion({self.quaternion().tolist()}, {self.translation.tolist()})"
