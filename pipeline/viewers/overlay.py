"""A still picture with what was seen in it: outlines of accepted tags, rejected candidates."""

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
Box = tuple[int, int, int, int]  # left, top, right, bottom [px]

ACCEPTED: Color = (80, 255, 80)  # BGR
REJECTED: Color = (60, 60, 255)
MOST_LISTED = 30  # rejections with a number
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
        The enlarged picture, shape (k H, k W, 3): accepted tags with outlines of their parts,
        heading and id; crosses where something was rejected, numbered as `listed` does.
    """
    k = max(1, ceil(WIDTH / image.shape[1]))
    size = image.shape[1] * k, image.shape[0] * k
    canvas: Image = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_NEAREST), np.uint8)
    for number, rejection in listed(scene):
        _draw_rejection(canvas, rejection, number, k)
    taken = [_draw_detection(canvas, seen, tags, camera, k) for seen in scene.detections]
    for detection, plate in zip(scene.detections, tuple(taken), strict=True):
        text = f"{detection.robot_id}{' ?' * detection.ambiguous}"
        taken.append(_draw_name(canvas, text, plate, taken))
    return canvas


def listed(scene: Scene) -> list[tuple[int, Rejection]]:
    """Choose the rejections that are worth a reader's time, and number them.

    Args:
        scene: what was found.

    Returns:
        Numbers from 1, down the picture, of the `MOST_LISTED` that got furthest, which the search
        tells last; 0 for the others, which come first.
    """
    others, chosen = scene.rejected[:-MOST_LISTED], scene.rejected[-MOST_LISTED:]
    down = sorted(chosen, key=lambda r: (r.y, r.x))
    return [(0, r) for r in others] + list(enumerate(down, 1))


def write_text(canvas: Image, text: str, at: tuple[int, int], color: Color, size: float) -> None:
    """Write text with a dark rim, so that it can be read on any ground.

    Args:
        canvas: shape (H, W, 3), BGR, is drawn on.
        text: ASCII.
        at: left end of its base line [px].
        color: of the letters.
        size: of the font.
    """
    for dx, dy in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        place = (at[0] + dx, at[1] + dy)
        cv2.putText(canvas, text, place, FONT, size, (0, 0, 0), 1, cv2.LINE_AA)
    cv2.putText(canvas, text, at, FONT, size, color, 1, cv2.LINE_AA)


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
) -> Box:
    """The outlines of a tag's parts and its heading; returns what they cover."""
    tag = next(tag for tag in tags.tags if tag.robot_id == seen.robot_id)
    c, s = cos(seen.pose.theta), sin(seen.pose.theta)
    turn, place = np.array([[c, s], [-s, c]]), np.array([seen.pose.x, seen.pose.y])
    outlines = []
    for part in tag.parts:
        floor = part.polygon @ turn + place
        points = camera.project(np.column_stack((floor, np.full(len(floor), camera.tag_height))))
        outlines.append(_fixed(points, k))
    cv2.polylines(canvas, outlines, True, ACCEPTED, 1, cv2.LINE_AA, SUBPIXEL)
    reach = 0.9 * tag.side * float(np.abs(camera.local_affine(seen.pose)).max())
    center = np.array([[seen.pixel.x, seen.pixel.y]])
    tip = center + reach * np.array([[cos(seen.pixel.heading), -sin(seen.pixel.heading)]])
    start, end = (tuple(map(int, _fixed(p, k)[0] >> SUBPIXEL)) for p in (center, tip))
    cv2.arrowedLine(canvas, start, end, ACCEPTED, 1, cv2.LINE_AA, tipLength=0.25)
    every = np.concatenate(outlines) >> SUBPIXEL
    (x0, y0), (x1, y1) = every.min(axis=0).tolist(), every.max(axis=0).tolist()
    return x0, y0, x1, y1


def _draw_name(canvas: Image, text: str, plate: Box, taken: list[Box]) -> Box:
    """A robot's id beside its plate, where it covers the least; returns what it covers."""
    (width, height), _ = cv2.getTextSize(text, FONT, 0.6, 1)
    x0, y0, x1, y1 = plate
    whole, middle = (0, 0, canvas.shape[1], canvas.shape[0]), (x0 + x1 - width) // 2
    places = [(x1 + 4, y0 + height), (x0 - width - 4, y0 + height), (middle, y0 - 4),
              (middle, y1 + height + 4), (x1 + 4, y1), (x0 - width - 4, y1)]  # fmt: skip
    boxes = [(x, y - height, x + width, y) for x, y in places]
    cost = [sum(_overlap(box, other) for other in taken) - _overlap(box, whole) for box in boxes]
    best = boxes[cost.index(min(cost))]
    write_text(canvas, text, (best[0], best[3]), ACCEPTED, 0.6)
    return best


def _overlap(one: Box, other: Box) -> int:
    """Area that two boxes have in common [px]."""
    width = min(one[2], other[2]) - max(one[0], other[0])
    height = min(one[3], other[3]) - max(one[1], other[1])
    return max(width, 0) * max(height, 0)


def _draw_rejection(canvas: Image, rejection: Rejection, number: int, k: int) -> None:
    """A cross, and its number."""
    x, y = (round((value + 0.5) * k) for value in (rejection.x, rejection.y))
    size = 10 if number else 5
    cv2.drawMarker(canvas, (x, y), REJECTED, cv2.MARKER_TILTED_CROSS, size, 1, cv2.LINE_AA)
    if number:
        write_text(canvas, str(number), (x + 7, y + 4), REJECTED, 0.4)


def _fixed(points: NDArray[np.float64], k: int) -> NDArray[np.int32]:
    """Pixel coordinates in the enlarged picture, with sub-pixel bits."""
    return np.rint(((points + 0.5) * k - 0.5) * (1 << SUBPIXEL)).astype(np.int32)
