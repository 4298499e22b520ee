"""Under a picture of a scene: why each numbered candidate was not accepted."""

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.viewers.overlay import ACCEPTED, FONT, REJECTED, listed, write_text
from vision.scene import Scene

Image = NDArray[np.uint8]

_LINE = 17  # height of a line [px]
_SIZE = 0.42  # of the font
_GROUND = 24  # grey level


def with_reasons(canvas: Image, scene: Scene) -> Image:
    """Put the reasons under a picture.

    Args:
        canvas: shape (H, W, 3), from `draw_scene`.
        scene: the same.

    Returns:
        Shape (H + h, W, 3).
    """
    rows = [(_summary(scene), ACCEPTED)]
    rows += [(f"{n} ({r.x:.0f}, {r.y:.0f}): {r.reason}", REJECTED) for n, r in listed(scene) if n]
    hidden = sum(1 for number, _ in listed(scene) if not number)
    if hidden:
        text = f"small crosses: {hidden} more that were dropped earlier; --json has every reason"
        rows.append((text, REJECTED))
    width = canvas.shape[1]
    lines = [(line, color) for text, color in rows for line in _wrapped(text, width - 12)]
    panel: Image = np.full((_LINE * len(lines) + 10, width, 3), _GROUND, np.uint8)
    for number, (line, color) in enumerate(lines, 1):
        write_text(panel, line, (6, _LINE * number), color, _SIZE)
    return np.concatenate((canvas, panel))


def _summary(scene: Scene) -> str:
    """The first line."""
    robots = f"{len(scene.detections)} robots accepted: outlines of the parts, arrow forward, id"
    if not scene.rejected:
        return f"{robots}. Nothing else looked like a part of a tag"
    return f"{robots}. {len(scene.rejected)} other places rejected: number (x, y px): why"


def _wrapped(text: str, width: int) -> list[str]:
    """A text in lines of at most a width [px]; the next begin further right."""
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines[-1] else word
        if cv2.getTextSize(longer, FONT, _SIZE, 1)[0][0] > width and lines[-1].strip():
            lines.append(f"    {word}")
        else:
            lines[-1] = longer
    return lines
