"""The port behind which robots are found: by the colours of their tags, or by printed markers."""

from typing import Protocol

import numpy as np

from control.geometry import Pose2D
from vision.camera import CameraModel
from vision.eye import Eye
from vision.frame import Frame, as_frame
from vision.light import PALETTE_LIGHT, Light
from vision.locate import Prediction, locate
from vision.scene import Scene
from vision.tags import TagSet


class Detector(Protocol):
    """Finds robots in the frames of one camera at one size; without memory."""

    @property
    def camera(self) -> CameraModel:
        """The camera of the frames."""
        ...

    @property
    def tags(self) -> TagSet:
        """What the robots wear."""
        ...

    def locate(self, frame: Frame, predictions: tuple[Prediction, ...], light: Light) -> Scene:
        """Find the robots in a frame.

        Args:
            frame: what the camera saw.
            predictions: where robots are expected, empty where nobody knows.
            light: on the robots, as the scenes before showed it.

        Returns:
            The robots found, no id twice, and what was not accepted.

        Raises:
            VisionError: if the frame's size is not the camera's.
        """
        ...


def warm_up(detector: Detector) -> None:
    """Let a detector look at nothing, so that the first frame does not wait for the compiler.

    Args:
        detector: that will be used.
    """
    width, height = detector.camera.size_px
    frame = as_frame(np.zeros((height, width, 3), np.uint8), 0.0, 0)
    x, y = detector.camera.to_floor(np.array([[0.5 * width, 0.5 * height]]), 0.0)[0].tolist()
    pose = Pose2D(x, y, 0.0)
    somewhere = tuple(Prediction(robot_id, pose, np.eye(3)) for robot_id in detector.tags.ids)
    detector.locate(frame, somewhere, PALETTE_LIGHT)


class ColorDetector:
    """Finds coloured tags.

    Attributes:
        eye: all that is constant about how frames are looked at.
    """

    def __init__(self, eye: Eye) -> None:
        """Look through an eye.

        Args:
            eye: made by `make_eye`.
        """
        self.eye = eye

    @property
    def camera(self) -> CameraModel:
        """The camera of the frames."""
        return self.eye.camera

    @property
    def tags(self) -> TagSet:
        """What the robots wear."""
        return self.eye.tags

    def locate(self, frame: Frame, predictions: tuple[Prediction, ...], light: Light) -> Scene:
        """Find the robots in a frame, see `vision.locate.locate`.

        Args:
            frame: what the camera saw.
            predictions: where robots are expected.
            light: on the robots.

        Returns:
            The robots found, and what was not accepted.

        Raises:
            VisionError: if the frame's size is not the camera's.
        """
        return locate(frame, self.eye, predictions, light)
