"""Render, locate, compare: errors of vision in mm and degrees on pictures with known truth."""

from dataclasses import dataclass
from math import degrees

import numpy as np
from numpy.typing import ArrayLike

from control.geometry import Pose2D, wrap_angle
from datasets.render import Renderer
from datasets.sensor import SensorModel
from tests.scenes.field import COLORS, SIDE, scattered, two_patch_tags
from vision.camera import CameraModel
from vision.eye import ChromaModel, Eye, Optics, make_eye
from vision.frame import as_frame
from vision.locate import Prediction, locate
from vision.palette import palette_from_colors
from vision.tags import TagSet


@dataclass(frozen=True)
class Measured:
    """Errors over many pictures.

    Attributes:
        recall: share of the robots found within half a side.
        false_ids: detections elsewhere.
        bias_mm: mean error x, y.
        position_mm: rms distance.
        heading_deg: rms turn.
    """

    recall: float
    false_ids: int
    bias_mm: tuple[float, float]
    position_mm: float
    heading_deg: float


def eye_for(camera: CameraModel, tags: TagSet, sensor: SensorModel) -> Eye:
    """An eye that knows the camera's sharpness, noise and chroma."""
    used = tuple(color for color in COLORS if color.name in tags.colors)
    chroma = ChromaModel(sensor.chroma, sensor.chroma_offset_px, sensor.chroma_upsampling)
    optics = Optics(sensor.blur_px, sensor.read_noise, chroma)
    return make_eye(
        camera, tags, palette_from_colors(used, noise=max(sensor.read_noise, 1.0)), optics
    )


def measure(
    camera: CameraModel,
    sensor: SensorModel,
    low: ArrayLike,
    high: ArrayLike,
    robots: int = 3,
    frames: int = 40,
    seed: int = 0,
    believed: CameraModel | None = None,
    predicted: bool = False,
) -> Measured:
    """Locate robots at random poses.

    Args:
        camera: that takes the pictures.
        sensor: what it does to them.
        low: least x, y of the robots [m].
        high: greatest x, y of the robots [m].
        robots: how many, up to 7.
        frames: how many pictures.
        seed: of poses and noise.
        believed: camera model of vision, if it is another.
        predicted: whether vision is told where the robots are, 4 mm and 3 deg wrong.

    Returns:
        The errors.
    """
    tags = two_patch_tags(robots)
    renderer = Renderer(camera, tags, COLORS, sensor, seed)
    eye = eye_for(believed or camera, tags, sensor)
    rng = np.random.default_rng(seed)
    errors: list[tuple[float, float, float]] = []
    false = 0
    for number in range(frames):
        states = scattered(rng, robots, low, high)
        true = {state.robot_id: state.state for state in states}
        told = tuple(_nearly(i, s.pose, rng) for i, s in true.items()) if predicted else ()
        frame = as_frame(renderer.render(states, number / 30.0), number / 30.0, number)
        for found in locate(frame, eye, told).detections:
            robot = true[found.robot_id]
            dx, dy = found.pose.x - robot.x, found.pose.y - robot.y
            if np.hypot(dx, dy) < 0.5 * SIDE:
                turn = degrees(wrap_angle(found.pose.theta - robot.theta))
                errors.append((1e3 * dx, 1e3 * dy, turn))
            else:
                false += 1
    off = np.array(errors).reshape(-1, 3)
    x, y, turn = np.sqrt(np.mean(off**2, axis=0)).tolist()
    bias = off.mean(axis=0).tolist()
    recall = len(off) / (robots * frames)
    return Measured(recall, false, (bias[0], bias[1]), float(np.hypot(x, y)), turn)


def _nearly(robot_id: int | str, pose: Pose2D, rng: np.random.Generator) -> Prediction:
    """A prediction with an error."""
    x, y, turn = rng.normal(0.0, (0.003, 0.003, 0.05))
    guess = Pose2D(pose.x + x, pose.y + y, pose.theta + turn)
    return Prediction(robot_id, guess, np.diag((0.003**2, 0.003**2, 0.05**2)))
