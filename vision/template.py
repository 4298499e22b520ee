"""What a camera sees of a tag's parts: finely sampled, blurred coverage in the tag's frame."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.errors import VisionError
from vision.optics import Optics
from vision.tags import Tag

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]

_FINE = 5  # coverage is counted on so many points along a cell's side
_PIXEL_VARIANCE = 1.0 / 12.0  # of the uniform sensitivity over a pixel [px^2]
_CELLS_PER_PX = 4  # sampling of the template
_MARGIN_PX = 2.5  # of a template around the tag
_FARTHEST = 1.0  # pixel of a window from the tag's centre, in sides of the window
_MOST_ROWS = 32767  # that OpenCV's remap can address


@dataclass(frozen=True, slots=True)
class Template:
    """Visible coverage of K parts and of everything outside the plate, and its derivatives.

    The channels of a cell: root of the weight; then, multiplied by it, the coverage of K + 1 parts
    (the last is the outside) and its derivatives with respect to a step forward, a step left [1/m]
    and a turn [1/rad] of the tag.

    Attributes:
        cells: shape (n, n, 1 + 4 * (K + 1)), over y (left) and x (forward).
        n: cells along one side.
        cell: side of a cell [m].
    """

    cells: Singles
    n: int
    cell: float


@dataclass(frozen=True, slots=True)
class Templates:
    """Templates of all shapes and scales, in one array.

    Attributes:
        cells: shape (2 * scales * shapes * pitch, n, 1 + 4 * (K + 1)), see `Template`: all
            templates below each other, first those of luma, then those of chroma, read-only.
        chroma_row: row at which those of chroma begin.
        n: cells along one side of a template.
        pitch: rows from one template to the next; the gap is empty.
        cell: side of a cell [m].
        scales: shape (L,), ascending, for which templates were made [px/m].
        shapes: number of shapes.
        side: of the largest tag [m].
        unit: shape (K + 1, K + 1), the unit matrix.
        parts: K, the largest number of parts.
    """

    cells: Singles
    chroma_row: int
    n: int
    pitch: int
    cell: float
    scales: Floats
    shapes: int
    side: float
    unit: Floats
    parts: int


def stack_templates(
    tags: tuple[Tag, ...], scales: Floats, optics: Optics, window_px: int
) -> tuple[Templates, list[Template]]:
    """Make the templates of all scales and shapes.

    Args:
        tags: one of every shape.
        scales: shape (L,), ascending [px/m].
        optics: blur of luma and chroma.
        window_px: side of the window in which the templates will be looked up [px].

    Returns:
        The templates; for every shape the one of luma at the largest scale.

    Raises:
        VisionError: if there are too many of them.
    """
    parts = max(len(tag.parts) for tag in tags)
    cell = 1.0 / (_CELLS_PER_PX * float(scales[-1]))
    reach = max(tag.outer_radius for tag in tags) + _MARGIN_PX / float(scales[0])
    luma_px = point_spread(optics.blur_px)
    chroma_px = point_spread(optics.blur_px, 2, optics.chroma.extra_blur_px)
    made = [
        [[make_template(tag, parts, reach, cell, px / scale) for tag in tags] for scale in scales]
        for px in (luma_px, chroma_px)
    ]
    sharp = made[0][-1]
    n = sharp[0].n
    farthest = int(np.ceil(_FARTHEST * window_px / float(scales[0]) / cell))
    gap = np.zeros((max(farthest - n // 2, 0), *sharp[0].cells.shape[1:]), np.float32)
    stacked = [piece for plane in made for row in plane for t in row for piece in (t.cells, gap)]
    cells = np.concatenate(stacked)
    if len(cells) > _MOST_ROWS:
        raise VisionError(f"{len(tags)} tag shapes at {len(scales)} scales need too many templates")
    cells.flags.writeable = False
    pitch = n + len(gap)
    side, unit = max(tag.side for tag in tags), np.eye(parts + 1)
    row = len(cells) // 2
    return Templates(cells, row, n, pitch, cell, scales, len(tags), side, unit, parts), sharp


def make_template(tag: Tag, parts: int, reach: float, cell: float, blur: float) -> Template:
    """Compute a template.

    Args:
        tag: whose parts to draw.
        parts: K, at least the tag's number of parts; the others stay empty.
        reach: half the side of the square that is sampled [m].
        cell: side of a cell [m].
        blur: standard deviation of the point spread, including the pixel's own size [m].

    Returns:
        The template.
    """
    n = 2 * int(np.ceil(reach / cell)) + 1
    axis = np.asarray((np.arange(n) - n // 2) * cell, np.float64)
    visible = np.zeros((parts + 1, n, n))
    for index, parent in enumerate(tag.parents):
        covered = _coverage(tag.parts[index].polygon, axis, cell)
        visible[index] += covered
        if parent >= 0:
            visible[parent] -= covered
    # Cells are means over squares and will be interpolated: both blur already, cell^2 / 4 together.
    sigma = np.sqrt(max((blur / cell) ** 2 - 0.25, 0.01))
    visible = np.stack([_blurred(image, sigma) for image in visible])
    visible[parts] = 1.0 - visible[:parts].sum(axis=0)
    slope_y, slope_x = np.asarray(np.gradient(visible, cell, axis=(1, 2)))
    turn = axis[:, None] * slope_x - axis[None, :] * slope_y
    root = np.sqrt(_weight(visible[parts]))
    stack = np.concatenate((root[None], root * np.concatenate((visible, -slope_x, -slope_y, turn))))
    return Template(np.ascontiguousarray(np.moveaxis(stack, 0, -1), np.float32), n, cell)


def point_spread(blur_px: float, pixels: int = 1, extra_px: float = 0.0) -> float:
    """Standard deviation of lens and pixel together.

    Args:
        blur_px: of the lens, standard deviation [px].
        pixels: side of the square of pixels that is averaged.
        extra_px: of anything else, standard deviation [px].

    Returns:
        The standard deviation [px].
    """
    return float(np.sqrt(blur_px**2 + extra_px**2 + _PIXEL_VARIANCE * pixels**2))


def sample_points(template: Template, part: int, count: int) -> Floats:
    """Pick points deep inside what is visible of a part.

    Args:
        template: of the tag.
        part: index of the part.
        count: at most so many points.

    Returns:
        Points in the tag's frame, shape (M, 2), 1 <= M <= count [m].
    """
    coverage = template.cells[..., 1 + part].reshape(-1)
    inside = np.flatnonzero(coverage >= 0.85 * coverage.max())
    chosen = inside[np.linspace(0, len(inside) - 1, 2 * count + 1).astype(int)[1::2]]
    y, x = np.divmod(chosen, template.n)
    points: Floats = np.column_stack((x, y)).astype(np.float64)
    points -= template.n // 2
    points *= template.cell
    return points


def _coverage(polygon: Floats, axis: Floats, cell: float) -> Floats:
    """Share of every cell that a polygon covers, shape (n, n)."""
    offsets = ((np.arange(_FINE) + 0.5) / _FINE - 0.5) * cell
    fine = (axis[:, None] + offsets).reshape(-1)
    inside = np.zeros((len(fine), len(fine)), bool)
    for (x0, y0), (x1, y1) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        rows = np.flatnonzero((y0 > fine) != (y1 > fine))
        crossing = x0 + (fine[rows] - y0) * (x1 - x0) / (y1 - y0 if y1 != y0 else 1.0)
        inside[rows] ^= fine < crossing[:, None]
    n = len(axis)
    share: Floats = inside.reshape(n, _FINE, n, _FINE).mean(axis=(1, 3))
    return share


def _blurred(image: Floats, sigma: float) -> Floats:
    """Gaussian blur, with nothing beyond the border; sigma in cells."""
    size = 2 * int(np.ceil(4.0 * sigma)) + 1
    return np.asarray(
        cv2.GaussianBlur(image, (size, size), sigma, borderType=cv2.BORDER_CONSTANT), np.float64
    )


def _weight(outside: Floats) -> Floats:
    """Weight of a pixel: 1 on the tag and its blurred edge, 0 where only the floor is seen."""
    return np.clip((0.999 - outside) / 0.03, 0.0, 1.0)
