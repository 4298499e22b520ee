"""A still picture with what was seen in it: accepted outlines, rejected candidates, reasons."""

from math import ceil, cos, sin
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from datasets.errors import RecordingError
from vision.camera import CameraModel
from vision.scene import Detection, Rejection, Scene
from vision.tags import TagSet

Image = NDArray[np.uint8]
Color = tuple[int, int, int]

ACCEPTED: Color = (80, 255, 80)  # BGR
REJECTED: Color = (60, 60, 255)
WIDTH = 1280  # small pictures are enlarged to about this [px]
FONT = cv2.FONT_HERSHEY_SIMPLEX
SUBPIXEL = 4  # bits of sub-pixel drawing


def draw_scene(image: Image, scene: Scene, tags: TagSet, camera: CameraModel) -> Image:
    """Draw a scene into an enlarged copy of its picture.

    Args:
        image: shape (H, W, 3), BGR.
        scene: what was found in it.
        tags: worn by the robots.
        camera: that took the picture.

    Returns:
        The enlarged picture, shape (k H, k W, 3).
    """
    k = max(1, ceil(WIDTH / image.shape[1]))
    size = image.shape[1] * k, image.shape[0] * k
    canvas: Image = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_NEAREST), np.uint8)
    for rejection in scene.rejected:
        _draw_rejection(canvas, rejection, k)
    for detection in scene.detections:
        _draw_detection(canvas, detection, tags, camera, k)
    return canvas


def write_picture(path: Path, image: Image) -> None:
    """Write a picture.

    Args:
        path: its suffix decides the format.
        image: shape (H, W, 3), BGR.

    Raises:
        RecordingError: if it cannot be written.
    """
    try:
        path.write_bytes(cv2.imencode(path.suffix, image)[1].tobytes())
    except (OSError, cv2.error) as error:
        raise RecordingError(f"{path}: cannot be written ({error})") from None


def _draw_detection(
    canvas: Image, seen: Detection, tags: TagSet, camera: CameraModel, k: int
) -> None:
    """The outlines of a tag's parts, its heading, its id."""
    tag = next(tag for tag in tags.tags if tag.robot_id == seen.robot_id)
    c, s = cos(seen.pose.theta), sin(seen.pose.theta)
    turn, place = np.array([[c, s], [-s, c]]), np.array([seen.pose.x, seen.pose.y])
    for part in tag.parts:
        floor = part.polygon @ turn + place
        points = camera.project(np.column_stack((floor, np.full(len(floor), camera.tag_height))))
        cv2.polylines(canvas, [_fixed(points, k)], True, ACCEPTED, 1, cv2.LINE_AA, SUBPIXEL)
    reach = 1.2 * k * tag.side * float(np.abs(camera.local_affine(seen.pose)).max())
    center = np.array([[seen.pixel.x, seen.pixel.y]])
    tip = center + reach / k * np.array([[cos(seen.pixel.heading), -sin(seen.pixel.heading)]])
    start, end = (tuple(map(int, _fixed(p, k)[0] >> SUBPIXEL)) for p in (center, tip))
    cv2.arrowedLine(canvas, start, end, ACCEPTED, 1, cv2.LINE_AA)
    corner = (start[0] + int(0.7 * reach), start[1] - int(0.5 * reach))
    _write(canvas, f"{seen.robot_id}{' ?' * seen.ambiguous}", corner, ACCEPTED, 0.7)


def _draw_rejection(canvas: Image, rejection: Rejection, k: int) -> None:
    """A cross, and why."""
    x, y = (round((value + 0.5) * k) for value in (rejection.x, rejection.y))
    cv2.drawMarker(canvas, (x, y), REJECTED, cv2.MARKER_TILTED_CROSS, 12, 1, cv2.LINE_AA)
    _write(canvas, rejection.reason[:60], (x + 9, y + 4), REJECTED, 0.4)


def _fixed(points: NDArray[np.float64], k: int) -> NDArray[np.int32]:
    """Pixel coordinates in the enlarged picture, with sub-pixel bits."""
    return np.rint(((points + 0.5) * k - 0.5) * (1 << SUBPIXEL)).astype(np.int32)


def _write(canvas: Image, text: str, at: tuple[int, int], color: Color, size: float) -> None:
    """Text with a dark rim, so that it can be read on any ground."""
    cv2.putText(canvas, text, at, FONT, size, (0, 0, 0), 3, cv2.LINE_AA)
    cv2.putText(canvas, text, at, FONT, size, color, 1, cv2.LINE_AA)
