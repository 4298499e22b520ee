"""What may happen in a run, gone through once before it: no frame waits for the compiler.

Functions are compiled, or loaded from disk, when they are first called. Some are called only when
a robot is lost, covered or taken for another, or when the light jumps: just then nobody may wait.
"""

from importlib import import_module

import cv2
import numpy as np
from numpy.typing import NDArray

from control.geometry import Pose2D
from vision.detector import ColorDetector, Detector, warm_up
from vision.eye import Eye
from vision.frame import as_frame
from vision.light import PALETTE_LIGHT
from vision.locate import Prediction

Bytes = NDArray[np.uint8]
Floats = NDArray[np.float64]

_ROBOTS = 3  # that take part, at most
_GAP = 3.0  # between two of them, in radii of a tag
_FLOOR = 128  # grey level
_DIM = 0.8  # a jump of the light
_FINE = 4  # binary digits of a pixel in which polygons are painted


def rehearse(detector: Detector) -> None:
    """Let a detector look at robots that are lost, seen, dimmed, covered, and strangers.

    Args:
        detector: that will be used.
    """
    import_module("scipy.optimize")  # says who is who among rivals; half a second
    warm_up(detector)
    if not isinstance(detector, ColorDetector):
        return  # printed markers are found without compiled functions
    eye, light = detector.eye, PALETTE_LIGHT
    poses = _places(eye)
    expected = tuple(
        Prediction(robot_id, Pose2D(*pose), 1e-6 * np.eye(3))
        for robot_id, pose in zip(eye.tags.ids, poses.tolist(), strict=False)
    )
    seen, strangers = _painted(eye, poses), _painted(eye, poses, shift=1)
    dimmed = np.asarray(_DIM * seen, np.uint8)
    acts = ((seen, ()), (dimmed, expected), (_covered(eye, seen, poses), expected))
    for number, (image, known) in enumerate((*acts, (strangers, expected))):
        light = detector.locate(as_frame(image, 0.0, number), known, light).light


def _places(eye: Eye) -> Floats:
    """Poses (N, 3) in a row about what the middle of the image shows."""
    middle = 0.5 * np.array([eye.camera.size_px])
    x, y = eye.camera.to_floor(middle, eye.camera.tag_height)[0].tolist()
    count = min(len(eye.tags.tags), _ROBOTS)
    along = _GAP * eye.radius * (np.arange(count) - 0.5 * (count - 1))
    return np.column_stack((x + along, np.full(count, y), np.full(count, 0.5)))


def _painted(eye: Eye, poses: Floats, shift: int = 0) -> Bytes:
    """The first tags at poses (N, 3), their colour channels moved on by some."""
    width, height = eye.camera.size_px
    image = np.full((height, width, 3), _FLOOR, np.uint8)
    for n, (x, y, theta) in enumerate(poses.tolist()):
        turn = np.array(((np.cos(theta), -np.sin(theta)), (np.sin(theta), np.cos(theta))))
        for part, color in zip(eye.tags.tags[n].parts, eye.looks.typical[n], strict=False):
            floor = part.polygon @ turn.T + (x, y)
            corners = np.column_stack((floor, np.full(len(floor), eye.camera.tag_height)))
            _fill(image, eye.camera.project(corners), np.roll(color, shift))
    return image


def _covered(eye: Eye, image: Bytes, poses: Floats) -> Bytes:
    """The same with a stripe over the half of every tag."""
    image, reach = image.copy(), 0.5 * eye.radius
    for x, y, _ in poses.tolist():
        box = np.array(((0, -2), (2, -2), (2, 2), (0, 2))) * reach + (x, y)
        corners = np.column_stack((box, np.full(len(box), eye.camera.tag_height)))
        _fill(image, eye.camera.project(corners), np.full(3, 255.0))
    return image


def _fill(image: Bytes, corners: Floats, color: Floats) -> None:
    """Paint a polygon (N, 2)."""
    if np.isfinite(corners).all():
        fine = np.rint(np.clip(corners, -1e4, 1e4) * 2**_FINE).astype(np.int32)
        cv2.fillPoly(image, [fine], color.tolist(), cv2.LINE_AA, _FINE)
