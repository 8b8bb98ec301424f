# SPDX-License-Identifier: MIT
# Types and docstrings of the compiled module; the docstrings of the module itself are made from this file.
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Optional, Union, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

_Path = Union[str, bytes, "os.PathLike[str]"]
_Floats = NDArray[np.float64]
_Size = tuple[int, int]
_Progress = Optional[Callable[[str, int, int], object]]

class Error(RuntimeError):
    """What cannot be done, with the place, what was found and expected there, and the next step."""

class InputError(Error):
    """A file, an image or a value that cannot be used, or an output that cannot be written."""

class UsageError(Error, ValueError):
    """A call that asks for something that does not exist, such as an array of a wrong shape or an unknown model."""

def models() -> list[str]:
    """The ids of all camera models."""

def parameter_names(model: str) -> list[str]:
    """The names of a model's parameters in storage order: fx, fy, cx, cy, then the lens. UsageError: unknown model."""

class CalibrationInfo:
    """What a camera file says about its calibration. Lengths in the image are in pixels; NaN is unknown."""
    @property
    def verdict(self) -> str:
        """"trustworthy", "usable_with_reservations" or "rejected"."""
    @property
    def accuracy_px(self) -> float:
        """The error of a projected point, where boards were seen, that is not exceeded in 95 % of cases."""
    @property
    def accuracy_distance_m(self) -> float:
        """Distance of the points that accuracy_px is for, metres; inf: distant points."""
    @property
    def covered_share(self) -> float:
        """The share of the image where boards were seen, 0 to 1."""
    @property
    def rms_px(self) -> float:
        """The reprojection error: sqrt(mean of dx^2 + dy^2) over the corners."""
    @property
    def holdout_rms_px(self) -> float:
        """The cross-validation error, of corners that were not used for the estimate."""
    @property
    def num_views(self) -> int:
        """Views in the fit."""
    @property
    def num_corners(self) -> int:
        """Corners in the fit."""
    @property
    def boards(self) -> list[str]:
        """The SPECs of the boards."""
    @property
    def findings(self) -> list[str]:
        """The ids of the findings behind the verdict."""
    @property
    def parameter_std(self) -> _Floats:
        """The standard deviations of the parameters, (P,) in storage order; empty if unknown."""
    @property
    def covariance(self) -> Optional[_Floats]:
        """The covariance of the parameters, (P, P) in storage order; None if unknown."""

class Camera:
    """A camera of one of the models() and the size of its images. Immutable, and safe to use from several threads.

    Points are in metres (any unit of length for project() without a pose), in the camera frame: x right, y down,
    z forward. Pixel (0, 0) is the centre of the top-left pixel.

    Arrays that are C-contiguous and float64 are used where they are. Others, such as float32 or strided ones, are
    converted, which takes a copy. Results are new arrays.
    """
    def __init__(self, model: str, size: _Size, parameters: Union[Mapping[str, float], ArrayLike], *, name: str = "", pupil: tuple[float, float] = (0.0, 0.0)) -> None:
        """A camera from all of its parameters, by name or in storage order.

        size: (width, height) in pixels. pupil: s1 and s2 of the entrance pupil, in metres.
        UsageError: unknown model or parameter name. InputError: a missing parameter or a value out of its range.
        """
    @property
    def model(self) -> str:
        """The id of the model, such as "radtan"."""
    @property
    def size(self) -> _Size:
        """(width, height) of the images in pixels."""
    @property
    def name(self) -> str:
        """What the camera is called in its file; may be empty."""
    @property
    def serial(self) -> str:
        """The serial number in the camera file; may be empty."""
    @property
    def parameters(self) -> dict[str, float]:
        """The parameters by name, in storage order; a copy."""
    @property
    def parameter_values(self) -> _Floats:
        """The parameters in storage order, (P,); a copy."""
    @property
    def pupil(self) -> tuple[float, float]:
        """s1 and s2 of the entrance pupil: the ray at the angle t (rad) starts s1 t^2 + s2 t^4 metres along the axis."""
    @property
    def correction(self) -> Optional[tuple[tuple[float, float], tuple[float, float], _Floats]]:
        """The correction field: the corner (x, y) of its grid and the size of a cell, pixels, and its control points (rows + 3, columns + 3, 2); None without one."""
    @property
    def calibration(self) -> Optional[CalibrationInfo]:
        """What the camera file says about the calibration; None if it says nothing."""
    @property
    def max_angle_deg(self) -> float:
        """The largest angle to the optical axis at which the camera is one-to-one, degrees."""
    @property
    def camera_from_rig(self) -> Optional[_Floats]:
        """Of a camera of a rig file: the 4x4 matrix that takes points of the rig frame to the camera frame."""
    @property
    def remarks(self) -> list[str]:
        """What was assumed or left out when the camera was read from a file, a sentence each."""
    def project(self, points: ArrayLike, camera_from_points: Optional[ArrayLike] = None, *, out: Optional[tuple[_Floats, NDArray[np.uint8]]] = None, jobs: int = 1) -> tuple[_Floats, NDArray[np.uint8]]:
        """Projects points to pixels.

        points: (..., 3). camera_from_points: the pose as a 4x4 or 3x4 matrix [R t], if the points are in another frame.
        out: (pixels, status) of an earlier call with as many points, to be overwritten and returned.
        jobs: threads; 0 is one per processor.
        Returns pixels (..., 2), NaN for points without a pixel, and status (...), 0 = ok, see Status. The pixel may
        lie outside the image.
        UsageError: another shape, or a matrix that is not a pose.
        """
    def project_with_jacobians(self, points: ArrayLike, camera_from_points: Optional[ArrayLike] = None, *, jobs: int = 1) -> tuple[_Floats, NDArray[np.uint8], _Floats, _Floats, _Floats]:
        """Projects points as project() does, with the derivatives of the pixels.

        Returns pixels, status, and the Jacobians by the point as given (..., 2, 3), by the pose (..., 2, 6) and by the
        parameters (..., 2, P). The pose is T Exp(xi) with xi = [translation, rotation], in metres and radians. NaN
        unless the status is 0.
        """
    def unproject(self, pixels: ArrayLike, *, out: Optional[tuple[_Floats, NDArray[np.uint8]]] = None, jobs: int = 1) -> tuple[_Floats, NDArray[np.uint8]]:
        """The rays of pixels, exact to rounding.

        pixels: (..., 2). out: (rays, status) of an earlier call, to be overwritten. Returns unit vectors (..., 3) in the camera frame, NaN for pixels without a ray, and status
        (...), 0 = ok. UsageError: another shape.
        """
    def unproject_with_jacobians(self, pixels: ArrayLike, *, jobs: int = 1) -> tuple[_Floats, NDArray[np.uint8], _Floats]:
        """The rays of pixels as unproject() gives them, with their derivatives by the pixel, (..., 3, 2)."""
    def undistort_map(self, projection: str = "rectilinear", *, keep: Optional[str] = None, fov_deg: Optional[float] = None, size: Optional[_Size] = None, jobs: int = 0) -> tuple[NDArray[np.float32], Optional[Camera]]:
        """Where the pixels of an undistorted image lie in the camera's image: the map of cv2.remap().

        projection: "rectilinear", "cylindrical" or "equirectangular". keep: "valid" (no pixel without a source), "all"
        (every pixel of the source), or None (the focal length of the camera). fov_deg: a horizontal field of view
        instead. size: (width, height) of the undistorted image; default: that of the camera.
        Returns map (height, width, 2), NaN where there is no source, and the camera of the undistorted image, which is
        a pinhole camera; None for the other projections.
        cv2.remap(image, map, None, cv2.INTER_LINEAR)
        """
    def crop(self, x: int, y: int, width: int, height: int) -> Camera:
        """The camera of a part of the image. UsageError: the part is not inside the image."""
    def resize(self, size: _Size) -> Camera:
        """The camera of the resized image."""
    def to_model(self, model: str) -> tuple[Camera, float]:
        """The nearest camera of another model, and the largest error over the image in pixels."""

def load_camera(path: _Path, *, size: Optional[_Size] = None, model: str = "") -> Camera:
    """Reads the only camera of a file of any supported format, or the one that "FILE#NAME" selects.

    size and model: for files that do not state them. What was assumed is in Camera.remarks.
    InputError: a file that cannot be read or is no camera file, several cameras, an unsupported camera.
    """

def load_cameras(path: _Path, *, size: Optional[_Size] = None, model: str = "") -> list[Camera]:
    """Reads all cameras of a file. Those of a rig have camera_from_rig. Errors as load_camera()."""

def save_camera(path: _Path, camera: Camera, format: str = "alidade") -> None:
    """Writes a camera file: "alidade", "opencv", "ros", "kalibr", "colmap", ... The file appears whole or not at all.

    UsageError: an unknown format. InputError: a camera that the format cannot represent exactly, or a file that cannot
    be written.
    """

class Board:
    """A calibration board: points in columns and rows on a plane."""
    def __init__(self, spec: _Path) -> None:
        """A board from its SPEC, such as "checkerboard:9x6:25mm" (see docs/boards.md), or from a board file.

        UsageError: a SPEC that is wrong; the message says where and shows one that works.
        """
    @property
    def spec(self) -> str:
        """The SPEC, as on the command line."""
    @property
    def columns(self) -> int:
        """Columns of points."""
    @property
    def rows(self) -> int:
        """Rows of points."""
    @property
    def points(self) -> _Floats:
        """The points in the board frame, metres, (N, 3), by id: id = row * columns + column."""

class Detection:
    """A board in one image, or why it was not found. True if there are corners."""
    @property
    def image(self) -> str:
        """The name of the image; empty for a single array."""
    @property
    def size(self) -> _Size:
        """(width, height) of the image."""
    @property
    def board(self) -> Board:
        """The board that was looked for."""
    @property
    def found(self) -> bool:
        """Whether there are corners, of all of the board or of a part of it."""
    @property
    def reason(self) -> str:
        """"found", "partial", "cut", or why there are no corners: "no_board", "blurred", "duplicate", ..."""
    @property
    def message(self) -> str:
        """The reason in a sentence; empty if all corners were found."""
    @property
    def ids(self) -> NDArray[np.int32]:
        """The ids of the corners that were found, rising, (N,)."""
    @property
    def pixels(self) -> _Floats:
        """Where they are, (N, 2)."""
    @property
    def sigma_px(self) -> _Floats:
        """The standard deviation of each coordinate, pixels, (N,); NaN if unknown."""
    @property
    def all_pixels(self) -> _Floats:
        """One row for each point of the board, (board points, 2); NaN where it was not found."""
    @property
    def blur_px(self) -> float:
        """The blur of the edges (sigma), pixels; NaN if it was not measured."""
    @property
    def tilt_deg(self) -> float:
        """The apparent tilt of the board, degrees; NaN if it was not measured."""

class Survey:
    """Boards in many images: a sequence of Detection, board by board in the order of the images."""
    @property
    def boards(self) -> list[Board]:
        """The boards that were looked for."""
    @property
    def num_images(self) -> int:
        """Images that were searched."""
    @property
    def num_found(self) -> int:
        """Images with a board."""
    @property
    def reasons(self) -> list[str]:
        """Why images have no board or not all of it, a line each."""
    @property
    def notes(self) -> list[str]:
        """What is remarkable about the set of images, a sentence each."""
    def save(self, path: _Path, camera: str = "camera") -> None:
        """Writes a corners file (CSV) as `alidade detect -o` does. InputError: it cannot be written."""
    def __len__(self) -> int: ...
    def __getitem__(self, index: int) -> Detection: ...

@overload
def detect(images: NDArray[np.unsignedinteger[Any]], board: Union[Board, str], *, color: str = "bgr") -> Detection:
    """Finds a board in one image.

    images: uint8 or uint16, (height, width), or (height, width, 3) in the order of color, "bgr" or "rgb". It is read where
    it is; the search works on a grey copy of 8 bits.
    """
@overload
def detect(images: Union[_Path, Sequence[_Path], Sequence[NDArray[np.unsignedinteger[Any]]]], board: Union[Board, str, Sequence[Union[Board, str]]], *, names: Optional[Sequence[str]] = None, color: str = "bgr", num_frames: int = 100, cache: Optional[_Path] = None, jobs: int = 0, progress: _Progress = None) -> Survey:
    """Finds boards in many images, in parallel, and leaves out images that must not be used together.

    images: folders, image files, patterns or videos; or a list of arrays. names: of the arrays (default: image0000, ...).
    num_frames: of each video, at most. cache: a folder that keeps what was found. jobs: threads; 0 is one per processor.
    progress: is called with (stage, done, total). Ctrl-C and an exception of progress stop the search.
    InputError: inputs that do not exist. UsageError: boards that look alike, or arrays of another type.
    """

def load_corners(path: _Path) -> Survey:
    """Reads a corners file (CSV), as `alidade detect -o` and Survey.save() write it. InputError names the line."""

class Finding:
    """What a calibration or a check found, and what to do about it."""
    @property
    def severity(self) -> str:
        """"pass", "note", "warning" or "failure"."""
    @property
    def id(self) -> str:
        """Stable in all versions, for programs: "fronto_parallel"."""
    @property
    def message(self) -> str:
        """Cause and evidence in a sentence."""
    @property
    def next_step(self) -> str:
        """What to do about it; may be empty."""
    @property
    def effect_px(self) -> float:
        """By how many pixels (95 %) it may displace projected points where boards were seen; NaN: not the question."""

class AccuracyMap:
    """The 95 % error of projected points over the image, on a grid of rows and columns."""
    @property
    def pixels(self) -> _Floats:
        """The pixels of the grid, (rows, columns, 2)."""
    @property
    def error_px(self) -> _Floats:
        """The error at each of them, pixels, (rows, columns); NaN where a pixel has no ray."""
    @property
    def is_covered(self) -> NDArray[np.bool_]:
        """Where boards were seen, (rows, columns)."""
    @property
    def distance_m(self) -> float:
        """Distance of the points, metres; inf: distant points."""
    @property
    def covered_share(self) -> float:
        """The share of the image where boards were seen, 0 to 1."""
    @property
    def covered_px(self) -> float:
        """The largest error where boards were seen, pixels."""
    @property
    def worst_px(self) -> float:
        """The largest error of all, pixels."""
    def share_within(self, tolerance_px: float) -> float:
        """The share of the image, 0 to 1, whose error is at most so many pixels."""

class CalibrationView:
    """A view of a board in a calibration."""
    @property
    def image(self) -> str:
        """The name of the image."""
    @property
    def board(self) -> Board:
        """The board that it shows."""
    @property
    def ids(self) -> NDArray[np.int32]:
        """The ids of the corners in use, (N,)."""
    @property
    def pixels(self) -> _Floats:
        """Where they were seen, (N, 2)."""
    @property
    def residuals(self) -> _Floats:
        """Projected minus observed, pixels, (N, 2)."""
    @property
    def camera_from_board(self) -> _Floats:
        """The pose of the board as a 4x4 matrix, metres."""
    @property
    def rms_px(self) -> float:
        """sqrt(mean of dx^2 + dy^2) of the corners in use."""
    @property
    def max_error_px(self) -> float:
        """The largest error."""
    @property
    def num_outliers(self) -> int:
        """Corners that are not in use because they are outliers."""

class Calibration:
    """A calibrated camera and what is known about it; shows the accuracy and the residuals in a notebook."""
    @property
    def camera(self) -> Camera:
        """The camera, with what a camera file states about the calibration."""
    @property
    def verdict(self) -> str:
        """"trustworthy", "usable_with_reservations" or "rejected"."""
    @property
    def is_usable(self) -> bool:
        """False for a rejected camera, which must not be used."""
    @property
    def accuracy_px(self) -> float:
        """The 95 % error of projected points where boards were seen, pixels; NaN if unknown."""
    @property
    def accuracy(self) -> Optional[AccuracyMap]:
        """The error over the whole image; None if the views do not determine the camera."""
    @property
    def rms_px(self) -> float:
        """The reprojection error: sqrt(mean of dx^2 + dy^2) over the corners."""
    @property
    def holdout_rms_px(self) -> float:
        """The cross-validation error, of corners that were not used for the estimate; NaN if unknown."""
    @property
    def findings(self) -> list[Finding]:
        """What was found, failures first."""
    @property
    def warnings(self) -> list[Finding]:
        """The findings that are warnings or failures."""
    @property
    def views(self) -> list[CalibrationView]:
        """The views in use, by name of the image."""
    @property
    def reasons(self) -> list[str]:
        """Why images have no board or not all of it, a line each."""
    @property
    def next_view(self) -> str:
        """The photograph that would improve the camera most, in a sentence."""
    @property
    def evidence(self) -> dict[str, Any]:
        """Everything that was found out, as `alidade calibrate --evidence` writes it."""
    def save(self, path: _Path, format: str = "alidade", *, keep_untrustworthy: bool = False) -> None:
        """Writes the camera file, as save_camera(). Error: the camera is rejected, unless keep_untrustworthy."""
    def report(self, path: _Path) -> None:
        """Writes the report: one HTML file with all figures. InputError: it cannot be written."""

def calibrate(views: Any, board: Union[Board, str, Sequence[Union[Board, str]], None] = None, *, image_size: Optional[_Size] = None, names: Optional[Sequence[str]] = None, sigma_px: Optional[ArrayLike] = None, model: str = "auto", initial: Optional[Camera] = None, fix: Sequence[str] = (), same_focal: bool = False, board_shape: str = "auto", pupil: Optional[int] = None, correction: Optional[tuple[int, int]] = None, tolerance_px: float = 1, distance_m: float = float("inf"), name: str = "", serial: str = "", color: str = "bgr", num_frames: int = 100, cache: Optional[_Path] = None, jobs: int = 0, progress: _Progress = None) -> Calibration:
    """Calibrates a camera. An initial guess is not needed.

    views: one of
    - images as detect() takes them: paths, or a list of uint8 or uint16 arrays;
    - a Survey, or a list of Detection; they know their board;
    - corners: for each view an array (board points, 2), NaN for points that are not seen, as Detection.all_pixels; or a
      tuple (ids, pixels) or (ids, pixels, sigma_px). They need image_size=(width, height).
    board: a Board or its SPEC; several boards as a list. names: of the images or views.
    sigma_px: standard deviation of the corners, one number or one per corner; default: unknown.
    model: one of models(), or "auto": chosen by cross-validation. initial: a camera to start from.
    fix: names of parameters that keep the values of initial (without it, the image centre and 0).
    same_focal: fx = fy. board_shape: "auto", "flat", "warp", "uneven" or "flexible".
    pupil: how many numbers of the entrance pupil are estimated, 0 to 2; None: those that a wide lens needs.
    correction: columns and rows of the correction field, (0, 0) for none; None: the field that the lens needs, with model "auto".
    tolerance_px: the error of a projected point (95 %) that you accept. distance_m: of these points.
    jobs: threads; the result does not depend on it. progress: is called with (stage, done, total).

    A poor result does not raise: see Calibration.verdict and findings. Ctrl-C stops with KeyboardInterrupt.
    InputError: fewer than 3 usable views, or corners that no camera explains. UsageError: arguments that do not exist.
    """

class RigCalibration:
    """Cameras that are fixed to each other, calibrated together."""
    @property
    def cameras(self) -> list[Camera]:
        """The cameras with their names and camera_from_rig; the first one is at the rig's origin."""
    @property
    def verdict(self) -> str:
        """"trustworthy", "usable_with_reservations" or "rejected"."""
    @property
    def is_usable(self) -> bool:
        """False for a rejected rig, which must not be used."""
    @property
    def rms_px(self) -> float:
        """The reprojection error of all corners."""
    @property
    def holdout_rms_px(self) -> float:
        """The cross-validation error; NaN if unknown."""
    @property
    def findings(self) -> list[Finding]:
        """What was found of the rig and its cameras, failures first."""
    @property
    def warnings(self) -> list[Finding]:
        """The findings that are warnings or failures."""
    @property
    def evidence(self) -> dict[str, Any]:
        """Everything that was found out, as `alidade rig calibrate --evidence` writes it."""
    def save(self, path: _Path, *, keep_untrustworthy: bool = False) -> None:
        """Writes the rig file. Error: the rig is rejected, unless keep_untrustworthy."""
    def report(self, path: _Path) -> None:
        """Writes the report: one HTML file with all figures. InputError: it cannot be written."""

def calibrate_rig(views: Mapping[str, Any], board: Union[Board, str, Sequence[Union[Board, str]], None] = None, *, image_size: Optional[_Size] = None, names: Optional[Sequence[str]] = None, sigma_px: Optional[ArrayLike] = None, model: str = "auto", fix: Sequence[str] = (), same_focal: bool = False, board_shape: str = "auto", pupil: Optional[int] = None, tolerance_px: float = 1, distance_m: float = float("inf"), color: str = "bgr", num_frames: int = 100, cache: Optional[_Path] = None, jobs: int = 0, progress: _Progress = None) -> RigCalibration:
    """Calibrates cameras that are fixed to each other.

    views: {name of the camera: its views as calibrate() takes them}. Images of different cameras with the same name, or
    else with the same last number in it, were taken at the same time; so were arrays with the same index.
    The other arguments and the errors are those of calibrate(). InputError: cameras that nothing links.
    """

class HandEye:
    """Where a camera is on a robot's hand or beside the robot: the content of a hand-eye file. Metres, radians."""
    @property
    def camera_on(self) -> str:
        """"hand", or "base" if the camera stands beside the robot and the gripper carries the boards."""
    @property
    def mount_from_camera(self) -> _Floats:
        """gripper_from_camera, or base_from_camera, as a 4x4 matrix."""
    @property
    def covariance(self) -> Optional[_Floats]:
        """Of the tangent [translation, rotation] of mount_from_camera, (6, 6), a right perturbation; None if unknown."""
    @property
    def world_from_boards(self) -> list[_Floats]:
        """base_from_board, or gripper_from_board, of each board as a 4x4 matrix."""
    @property
    def boards(self) -> list[str]:
        """The SPECs of the boards."""
    @property
    def robot_noise(self) -> dict[str, float]:
        """Standard deviations of the robot's errors about and along each axis: rotation_rad, translation_m."""
    @property
    def num_poses(self) -> int:
        """Robot poses in use."""
    @property
    def error_m(self) -> float:
        """The 95 % error of a point at the boards' distance, in the frame of the gripper or base."""
    @property
    def rms_px(self) -> float:
        """The reprojection error: sqrt(mean of dx^2 + dy^2) over the corners."""
    @property
    def verdict(self) -> str:
        """"trustworthy", "usable_with_reservations" or "rejected"."""
    @property
    def finding_ids(self) -> list[str]:
        """The ids of the findings behind the verdict."""
    def save(self, path: _Path, format: str = "alidade") -> None:
        """Writes the file: "alidade", or only the transform as "ros", "urdf" or "opencv". UsageError: an unknown format."""

class HandEyeFrame:
    """An image and the robot pose that belongs to it."""
    @property
    def image(self) -> str:
        """The name of the image."""
    @property
    def base_from_gripper(self) -> _Floats:
        """The pose that the robot stated, after mending, as a 4x4 matrix."""
    @property
    def deviation(self) -> _Floats:
        """The gripper was at base_from_gripper @ exp(deviation): [translation, rotation], metres and radians, (6,)."""
    @property
    def sigmas(self) -> float:
        """The size of the deviation in its standard deviations; about 1."""
    @property
    def rms_px(self) -> float:
        """The reprojection error of the corners."""
    @property
    def reason(self) -> str:
        """Why it is left out; empty if it is in use."""

class HandEyeCalibration(HandEye):
    """A calibrated hand-eye transform and what is known about it."""
    @property
    def is_usable(self) -> bool:
        """False for a rejected transform, which must not be used."""
    @property
    def findings(self) -> list[Finding]:
        """What was found, failures first; also what was mended in the poses."""
    @property
    def warnings(self) -> list[Finding]:
        """The findings that are warnings or failures."""
    @property
    def frames(self) -> list[HandEyeFrame]:
        """The images and their robot poses, by name of the image."""
    def save(self, path: _Path, format: str = "alidade", *, keep_untrustworthy: bool = False) -> None:
        """Writes the file as HandEye.save(). Error: the transform is rejected, unless keep_untrustworthy."""

def calibrate_hand_eye(views: Any, poses: Union[_Path, Mapping[Any, ArrayLike], Sequence[tuple[Any, ArrayLike]]], board: Union[Board, str, Sequence[Union[Board, str]], None] = None, *, pose_form: str = "", camera_on: Optional[str] = None, camera: Optional[Camera] = None, model: Optional[str] = None, tolerance: str = "1mm", image_size: Optional[_Size] = None, names: Optional[Sequence[str]] = None, sigma_px: Optional[ArrayLike] = None, color: str = "bgr", num_frames: int = 100, cache: Optional[_Path] = None, jobs: int = 0, progress: _Progress = None) -> HandEyeCalibration:
    """Finds where a camera is on a robot's hand, or beside a robot that carries the board.

    views, board, image_size, names, sigma_px, color, num_frames, cache, jobs, progress: as for calibrate().
    poses: base_from_gripper of each image, metres: {name: 4x4 matrix}, a list of (name, matrix), or the path of a table
    (docs/handeye.md). A name is that of the image, or its number or time.
    pose_form: what the numbers of a table without a header mean. camera_on: "hand", "base" or None: found from the poses.
    camera: a Camera whose lens is kept; None: calibrated in the same fit, with the model given or the one that fits best.
    tolerance: the error of a point at the boards' distance (95 %) that you accept.

    A poor result does not raise, nor does a mistake in the poses that was mended: see HandEyeCalibration.findings.
    InputError: as calibrate(), and poses that match no images or fewer than 3, or a table that cannot be read.
    """

def load_hand_eye(path: _Path) -> HandEye:
    """Reads a hand-eye file. InputError: a file that cannot be read or states something else than it should."""

class Check:
    """A question that was asked of a camera file, and the answer."""
    @property
    def camera(self) -> str:
        """The name of the camera in the file; empty for a check of the rig."""
    @property
    def id(self) -> str:
        """Stable in all versions, for programs: "focal_length"."""
    @property
    def severity(self) -> str:
        """"pass", "note", "warning" or "failure"."""
    @property
    def message(self) -> str:
        """The answer, with value and limit."""
    @property
    def values(self) -> dict[str, float]:
        """What the message says in numbers; names end in the unit."""

class FileValidation:
    """What was found out about a camera file. False if a check failed or the file cannot be read."""
    @property
    def file(self) -> str:
        """Its path."""
    @property
    def format(self) -> str:
        """The id of its format; empty if it cannot be read."""
    @property
    def error(self) -> str:
        """Why it cannot be read; empty if it can."""
    @property
    def severity(self) -> str:
        """The most severe of its checks."""
    @property
    def checks(self) -> list[Check]:
        """The checks of all cameras of the file."""

def validate(path: _Path, images: Any = None, board: Union[Board, str, Sequence[Union[Board, str]], None] = None, *, against: Union[Camera, _Path, None] = None, tolerance_px: float = 0.2, jobs: int = 0, progress: _Progress = None) -> list[FileValidation]:
    """Checks a camera file of any format, or all camera files in a folder.

    images, board: views as calibrate() takes them, which the cameras were not calibrated from: tests the cameras on them.
    against: a camera to compare with. tolerance_px: the largest accepted error for these two tests.
    A file that cannot be read does not raise: see FileValidation.error. InputError: the path does not exist, or
    images without a board.
    """

class Difference:
    """The projection difference of two cameras, on a grid of pixels of a. Lengths are in pixels of the finer image."""
    @property
    def pixels(self) -> _Floats:
        """The pixels of a, (rows, columns, 2)."""
    @property
    def difference_px(self) -> _Floats:
        """Projection by b minus projection by a, (rows, columns, 2); NaN where there is none."""
    @property
    def mean_px(self) -> float:
        """Mean length."""
    @property
    def rms_px(self) -> float:
        """RMS length."""
    @property
    def p95_px(self) -> float:
        """95 % of the lengths are at most this."""
    @property
    def max_px(self) -> float:
        """The largest length."""
    @property
    def num_compared(self) -> int:
        """Pixels that both cameras see."""
    @property
    def b_from_a(self) -> _Floats:
        """The alignment from a's camera frame to b's, 4x4."""
    @property
    def is_significant(self) -> Optional[bool]:
        """Whether it exceeds the uncertainty of the cameras; None if neither states a covariance."""
    def answer(self, tolerance_px: float = 0.2) -> str:
        """"same", "changed", or "cannot tell" if the uncertainty exceeds the tolerance, as of the command diff."""

def diff(a: Union[Camera, _Path], b: Union[Camera, _Path], *, distance_m: Optional[float] = None, same_frame: bool = False) -> Difference:
    """Compares two cameras of the same image, of any models and sizes, after alignment by the best rotation.

    distance_m: compare points at this distance, after alignment by the best pose. same_frame: do not align.
    InputError: images of different shape, or cameras with too little in common.
    """

class RigDifference:
    """By how much two rigs disagree. Angles are in radians, lengths in metres."""
    @property
    def distance_m(self) -> float:
        """The distance of the points of `transfers`."""
    @property
    def lenses(self) -> dict[str, Difference]:
        """The difference of each camera by itself, by its name."""
    @property
    def places(self) -> dict[str, tuple[float, float]]:
        """(distance_m, angle_rad) by which each camera's pose from the first camera differs."""
    @property
    def transfers(self) -> dict[str, Optional[dict[str, Any]]]:
        """What lenses and poses do together: pixels of from_camera as points, projected into each camera.

        from_camera, num_compared, rms_px, p95_px and max_px; None for a camera that sees too little of what others see.
        """

def diff_rigs(a: Union[RigCalibration, _Path], b: Union[RigCalibration, _Path], *, distance_m: Optional[float] = None) -> RigDifference:
    """Compares two rigs of the same cameras, matched by their names: each lens, the poses, and what both do together.

    distance_m: of the points that are projected from one camera into another; default: 10 times the largest distance
    between two cameras. InputError: other names or image sizes, or a file without poses.
    """

# For SE3 of poses.py: (..., N) numbers in a form (alidade pose --help) and (..., 4, 4) or (..., 16) matrices.
def _poses_from_numbers(form: str, numbers: ArrayLike) -> _Floats: ...
def _numbers_from_poses(form: str, matrices: ArrayLike) -> tuple[_Floats, bool]: ...
