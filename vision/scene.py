"""What was seen in one frame."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from control.geometry import Pose2D
from vision.light import PALETTE_LIGHT, Light


@dataclass(frozen=True, slots=True)
class PixelPose:
    """A robot as it appears on the screen; the centre of the top-left pixel is (0, 0).

    Attributes:
        x: to the right [px].
        y: downwards [px].
        heading: 0 to the right, counter-clockwise as seen on the screen [rad].
    """

    x: float
    y: float
    heading: float


@dataclass(frozen=True, slots=True)
class Detection:
    """A robot that was recognised.

    Attributes:
        robot_id: whose tag it is.
        pose: on the floor [m, m, rad].
        pixel: where the tag's centre is in the image [px, px, rad].
        covariance: of pose, shape (3, 3) [m^2, m rad, rad^2], read-only.
        residual_px: rms misfit of the layout, as a displacement of its edges [px].
        confidence: 0 (a guess) to 1 (every part of the tag agrees).
        ambiguous: whether it may be another robot that wears the same tag.
    """

    robot_id: RobotId
    pose: Pose2D
    pixel: PixelPose
    covariance: NDArray[np.float64]
    residual_px: float
    confidence: float
    ambiguous: bool = False


@dataclass(frozen=True, slots=True)
class Rejection:
    """Something that looked like a tag and was not accepted.

    Attributes:
        x: to the right [px].
        y: downwards [px].
        reason: why, with the numbers that decided.
    """

    x: float
    y: float
    reason: str


@dataclass(frozen=True, slots=True)
class Scene:
    """All that was found in one frame.

    Attributes:
        t_capture: capture time of the frame [s].
        detections: one per recognised robot, no id twice.
        rejected: candidates that were not accepted, with the reason.
        light: as the accepted tags show it.
    """

    t_capture: float
    detections: tuple[Detection, ...]
    rejected: tuple[Rejection, ...] = ()
    light: Light = PALETTE_LIGHT
