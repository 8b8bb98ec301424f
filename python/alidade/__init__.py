# SPDX-License-Identifier: MIT
"""Camera calibration and projection: see docs/python.md."""
from enum import IntEnum as _IntEnum

from ._core import (AccuracyMap, Board, Calibration, CalibrationInfo, CalibrationView, Camera, Check, Detection,
                    Difference, Error, FileValidation, Finding, HandEye, HandEyeCalibration, HandEyeFrame, InputError,
                    RigCalibration, RigDifference, Survey, UsageError, __version__, calibrate, calibrate_hand_eye,
                    calibrate_rig, detect, diff, diff_rigs, load_camera, load_cameras, load_corners, load_hand_eye,
                    models, parameter_names, save_camera, validate)
from .poses import SE3


class Status(_IntEnum):
    """Whether a point has a pixel, or a pixel a ray: the numbers in the status arrays."""

    OK = 0
    BEHIND = 1  #: the point is not in front of a camera that sees only forward
    OUTSIDE = 2  #: beyond the fold of the lens or the domain of its model, not a finite point; a pixel without a ray


__all__ = ["__version__", "AccuracyMap", "Board", "calibrate", "calibrate_hand_eye", "calibrate_rig", "Calibration", "CalibrationInfo",
           "CalibrationView", "Camera", "Check", "detect", "Detection", "diff", "diff_rigs", "Difference", "Error",
           "FileValidation", "Finding", "HandEye", "HandEyeCalibration", "HandEyeFrame", "InputError", "load_camera", "load_cameras",
           "load_corners", "load_hand_eye", "models", "parameter_names",
           "RigCalibration", "RigDifference", "save_camera", "SE3", "Status", "Survey", "UsageError", "validate"]
