"""What a camera sees of a tag's parts: finely sampled, blurred coverage in the tag's frame.

A template is made in the frequency domain, where everything is exact: the polygons, the Gaussian
lens, the square pixel (whose sides depend on how the tag is turned against the image), averaging
and mixing of colour samples. Only the last step, sampling, is numerical.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.optics import Optics
from vision.tags import Tag

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Bytes = NDArray[np.uint8]
Spectrum = NDArray[np.complex128]

TURNS = 4
"""Templates are made for so many headings on the screen within a quarter turn."""

_CELLS_PER_SAMPLE = (2.0, 4.0)  # sampling of a template: coarser where it would have
_MOST_CELLS = 150  # more cells along its side than this
_MARGIN_PX = 3.0  # of a template around the tag; of colour, 2 samples
_LEAST_BLUR_PX = 0.25  # a sharper lens cannot be sampled
_EDGE = 0.04  # change of a coverage from one sample to the next that tells something of the pose
_RING = 2  # samples around the tag that show the floor
_ALL = 1e9
_PIXELS = (
    (40.0, 140.0, _ALL),
    (120.0, 800.0, 950.0),
)  # coarsely, and fully: samples elsewhere, at
_COLORS = ((20.0, 60.0, _ALL), (60.0, 300.0, 400.0))  # edges, and when ever fewer of those are used
_MOST_STRIDE = 6
_COARSE_PAYS = 1.5  # so many times fewer samples make a coarse look first worth while


@dataclass(frozen=True, slots=True)
class Templates:
    """Templates of one kind of samples, for all shapes and scales.

    Attributes:
        cells: shape (L, shapes, TURNS, n, n, K), visible coverage of the K parts over scale, shape,
            heading on the screen, y (left) and x (forward), read-only.
        usage: shape (L, shapes, n, n), what a sample at a place of the tag's frame tells: 0
            nothing, 1 the brightness of a part, 2 also the pose, read-only.
        shares: shape (L, shapes, 2, 3), of the samples of each usage in the rows looked at this
            share is used, of 2^32 - 1, for a coarse and for the full look, read-only.
        strides: shape (L, shapes, 2, 2), of so many rows, and of so many samples of a row, one is
            looked at, for a coarse and for the full look, read-only.
        cell: side of a cell [m].
    """

    cells: Singles
    usage: Bytes
    shares: NDArray[np.uint32]
    strides: NDArray[np.intp]
    cell: float

    @property
    def coarse_pays(self) -> NDArray[np.bool_]:
        """Whether a coarse look spares many samples at edges, shape (L, shapes)."""
        used = self.shares[..., 2] / self.strides.prod(axis=3)
        return np.asarray(used[..., 1] > _COARSE_PAYS * used[..., 0])


def make_templates(
    tags: tuple[Tag, ...], scales: Floats, optics: Optics, sample_px: int
) -> Templates:
    """Make the templates of all scales and shapes.

    Args:
        tags: one of every shape.
        scales: shape (L,), ascending [px/m].
        optics: blur of luma and chroma.
        sample_px: 1 for pixels, 2 for colours as means of 2 x 2 pixels.

    Returns:
        The templates.
    """
    parts = max(len(tag.parts) for tag in tags)
    margin = (_MARGIN_PX + sample_px - 1.0) / float(scales[0])
    reach, sample = max(tag.outer_radius for tag in tags) + margin, sample_px / float(scales[-1])
    cell = sample / float(np.clip(_MOST_CELLS * sample / (2.0 * reach), *_CELLS_PER_SAMPLE))
    n = 2 * int(np.ceil(reach / cell)) + 1
    spectra = [_spectra(tag, n, cell) for tag in tags]
    cells = np.zeros((len(scales), len(tags), TURNS, n, n, parts), np.float32)
    for level, scale in enumerate(scales.tolist()):
        for turn in range(TURNS):
            spread = _point_spread(n, cell, sample_px / scale, turn, optics, sample_px)
            for shape, spectrum in enumerate(spectra):
                images = np.fft.irfft2(spectrum * spread, s=(n, n)) / cell**2
                images = np.roll(images, (n // 2, n // 2), axis=(1, 2))
                cells[level, shape, turn, :, :, : len(images)] = np.moveaxis(images, 0, -1)
    usage = np.array([[_usage(shape[0], sample / cell) for shape in level] for level in cells])
    looks = _PIXELS if sample_px == 1 else _COLORS
    parts_used = np.array(
        [[[_shares(u, sample / cell, most) for most in looks] for u in level] for level in usage]
    )
    strides = _strides(parts_used.max(axis=3))
    looked_at = strides.prod(axis=3, keepdims=True)
    shares = (0xFFFFFFFF * np.minimum(parts_used * looked_at, 1.0)).astype(np.uint32)
    for array in (cells, usage, shares, strides):
        array.flags.writeable = False
    return Templates(cells, usage, shares, strides, cell)


def sample_points(templates: Templates, shape: int, part: int, count: int) -> Floats:
    """Pick points deep inside what is visible of a part.

    Args:
        templates: of all shapes.
        shape: index of the geometry.
        part: index of the part.
        count: at most so many points.

    Returns:
        Points in the tag's frame, shape (M, 2), 1 <= M <= count [m].
    """
    coverage = templates.cells[-1, shape, 0, :, :, part]
    inside = np.flatnonzero(coverage >= 0.85 * coverage.max())
    chosen = inside[np.linspace(0, len(inside) - 1, 2 * count + 1).astype(int)[1::2]]
    y, x = np.divmod(chosen, coverage.shape[1])
    points: Floats = (np.column_stack((x, y)) - coverage.shape[0] // 2) * templates.cell
    return points


def _spectra(tag: Tag, n: int, cell: float) -> Spectrum:
    """Fourier transforms (K, n, n // 2 + 1) of what is visible of the parts."""
    kx, ky = _frequencies(n, cell)
    own = np.stack([_polygon_spectrum(part.polygon, kx, ky) for part in tag.parts])
    visible = own.copy()
    for index, parent in enumerate(tag.parents):
        if parent >= 0:
            visible[parent] -= own[index]
    return visible


def _frequencies(n: int, cell: float) -> tuple[Floats, Floats]:
    """Angular frequencies along x and y [rad/m], as `irfft2` orders them."""
    turns = 2.0 * np.pi / cell
    kx, ky = np.meshgrid(turns * np.fft.rfftfreq(n), turns * np.fft.fftfreq(n))
    return kx, ky


def _polygon_spectrum(polygon: Floats, kx: Floats, ky: Floats) -> Spectrum:
    """Fourier transform of a polygon's inside: by Gauss' theorem a sum over its edges."""
    total, area = np.zeros(kx.shape, np.complex128), 0.0
    for (x0, y0), (x1, y1) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        dx, dy = x1 - x0, y1 - y0
        middle = np.exp(-0.5j * (kx * (x0 + x1) + ky * (y0 + y1)))
        total += (kx * dy - ky * dx) * middle * np.sinc((kx * dx + ky * dy) / (2.0 * np.pi))
        area += 0.5 * (x0 * y1 - x1 * y0)
    square = kx * kx + ky * ky
    square[0, 0] = 1.0
    total *= 1j / square
    total[0, 0] = area
    return total if area > 0.0 else -total


def _point_spread(
    n: int, cell: float, width: float, turn: int, optics: Optics, sample_px: int
) -> Floats:
    """Transfer function of lens and samples (n, n // 2 + 1); width of a sample in m."""
    kx, ky = _frequencies(n, cell)
    blur = max(optics.blur_px, _LEAST_BLUR_PX) * width / sample_px
    lens = np.exp(-0.5 * blur**2 * (kx * kx + ky * ky))
    c, s = np.cos(turn * np.pi / 2.0 / TURNS), np.sin(turn * np.pi / 2.0 / TURNS)
    for k in (c * kx - s * ky, s * kx + c * ky):  # along the sides of the sample
        lens *= np.sinc(k * width / (2.0 * np.pi))
        if sample_px > 1 and optics.chroma.mixed:  # with its neighbours, 1 : 6 : 1
            lens *= 0.75 + 0.25 * np.cos(k * width)
    interpolated = np.sinc(kx * cell / (2.0 * np.pi)) * np.sinc(ky * cell / (2.0 * np.pi))
    return np.asarray(lens / interpolated**2, np.float64)


def _strides(shares: Floats) -> NDArray[np.intp]:
    """Rows, and samples of a row, of which one is looked at, so that enough are left (..., 2)."""
    rows = np.clip(np.ceil(np.sqrt(1.0 / shares) - 0.5), 1, _MOST_STRIDE)
    columns = np.clip(np.floor(1.0 / (shares * rows)), 1, _MOST_STRIDE)
    return np.stack((rows, columns), axis=-1).astype(np.intp)


def _usage(cells: Singles, step: float) -> Bytes:
    """Usage of every place of a template (n, n, K) with so many cells per sample."""
    change = np.zeros(cells.shape[:2], np.float32)
    for axis in (0, 1):
        slope = np.abs(np.gradient(cells, axis=axis)).max(axis=2) * step
        change = np.maximum(change, slope)
    width = 2 * round(_RING * step) + 1
    covered = (cells.sum(axis=2) > 0.5).astype(np.uint8)
    near = cv2.dilate(covered, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width, width)))
    return np.where(change > _EDGE, 2 * (near > 0), near > 0).astype(np.uint8)


def _shares(
    usage: Bytes, step: float, most: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Share of the samples of each usage that is used: many are thinned out."""
    flat, edges = (max(np.count_nonzero(usage == kind) / step**2, 1.0) for kind in (1, 2))
    share = (
        min(most[1] / edges, 1.0) * min(most[2] / edges, 1.0) ** 2
    )  # large tags are exact anyway
    return 0.0, min(most[0] / flat, 1.0), share
