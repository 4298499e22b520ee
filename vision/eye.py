"""Everything about the seeing that stays the same from frame to frame, worked out once."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.camera import CameraModel
from vision.errors import VisionError
from vision.floor_map import floor_map, image_scales
from vision.gauge import Gauge, Plane
from vision.optics import ChromaModel, Optics
from vision.palette import YCC_FROM_BGR, Palette
from vision.shapes import Looks, Shape, make_looks, make_shapes
from vision.tags import TagSet
from vision.template import Templates, make_templates

__all__ = ["ChromaModel", "Eye", "Optics", "Thresholds", "make_eye"]

_REACH_PX = 3  # radius of the window around a tag beyond its own
_LEAST_NOISE = 0.5  # rounding and what the model leaves out [grey levels]


@dataclass(frozen=True, slots=True)
class Thresholds:
    """When a candidate counts as a tag.

    Attributes:
        blob_share: smallest blob, as a share of the smallest coloured part.
        distance_share: error of the distance of two blobs, as a share of the expected distance.
        agreement: share of sample points that must show the part's colour before the fit.
        light_spread: standard deviation of the logarithm of the light on the parts of one tag, as
            told by their brightness.
        confidence: probability of the tag's colours rather than any, after the fit.
        residual_px: largest rms misfit after the fit [px].
        residual_share: the same as a share of the tag's side, where that is more: nobody cuts and
            measures tags to a hundredth.
        max_blobs: larger numbers are cut, the largest blobs stay.
        max_candidates: larger numbers are cut, the best candidates stay.
    """

    blob_share: float = 0.2
    distance_share: float = 0.4
    agreement: float = 0.4
    light_spread: float = 0.25
    confidence: float = 0.5
    residual_px: float = 0.8
    residual_share: float = 0.02
    max_blobs: int = 400
    max_candidates: int = 64


@dataclass(frozen=True, slots=True, eq=False)
class Eye:
    """What `locate` needs besides the frame; made by `make_eye`.

    Attributes:
        camera: of the frames.
        tags: worn by the robots.
        palette: colour classes.
        optics: sharpness and noise.
        thresholds: of acceptance.
        radius: of the largest tag, see `TagSet.outer_radius` [m].
        shapes: geometries of the tags.
        gauge: what the fit needs.
        looks: what the search needs.
        min_blob_px: area of the smallest blob that counts [px].
        field_px: shape (N, 2), corners of the part of the image that is searched; None for all.
        mask: shape (H, W), 255 where the image is searched, 0 elsewhere, read-only; None for all.
    """

    camera: CameraModel
    tags: TagSet
    palette: Palette
    optics: Optics
    thresholds: Thresholds
    radius: float
    shapes: tuple[Shape, ...]
    gauge: Gauge
    looks: Looks
    min_blob_px: float
    field_px: NDArray[np.float64] | None = None
    mask: NDArray[np.uint8] | None = None

    @property
    def most_residual_px(self) -> float:
        """Largest rms misfit of a tag in this image [px]."""
        side_px = 2.0 * self.gauge.arm * float(self.gauge.scales[0])
        return max(self.thresholds.residual_px, self.thresholds.residual_share * side_px)

    def in_field(self, pixels: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether places lie where the image is searched.

        Args:
            pixels: shape (N, 2), finite.

        Returns:
            Shape (N,).
        """
        if self.mask is None:
            return np.ones(len(pixels), np.bool_)
        last = np.array(self.camera.size_px) - 1
        x, y = np.clip(np.rint(pixels), 0, last).astype(np.intp).T
        return np.asarray(self.mask[y, x] > 0)


def make_eye(
    camera: CameraModel,
    tags: TagSet,
    palette: Palette,
    optics: Optics | None = None,
    thresholds: Thresholds | None = None,
    field_px: NDArray[np.float64] | None = None,
) -> Eye:
    """Work out templates, sample points and the floor behind the picture.

    Args:
        camera: of the frames.
        tags: worn by the robots, at least one.
        palette: with every colour the tags search for.
        optics: sharpness and noise; the default if None.
        thresholds: of acceptance; the default if None.
        field_px: shape (N, 2), corners of the part of the image that is searched; None for all.

    Returns:
        The eye.

    Raises:
        VisionError: if there are no tags, the palette lacks a colour, no pixel sees the floor, or
            the field lies outside the image.
    """
    optics, thresholds = optics or Optics(), thresholds or Thresholds()
    lacking = [color for color in tags.search_colors if palette.class_of(color) == 0]
    if lacking or not tags.tags:
        raise VisionError(f"{len(tags.tags)} tags; the palette lacks {', '.join(lacking) or '-'}")
    scales, shapes = image_scales(camera), make_shapes(tags)
    worn = tuple(tags.tags[shape.tags[0]] for shape in shapes)
    pixels, colors = (make_templates(worn, scales, optics, sample_px) for sample_px in (1, 2))
    gauge = _gauge(camera, tags, optics, scales, (pixels, colors))
    looks = make_looks(tags, shapes, pixels, palette)
    smallest = min(float(shape.areas[list(shape.colored)].min()) for shape in shapes)
    least_px = max(2.0, thresholds.blob_share * smallest * float(scales[0]) ** 2)
    return Eye(
        camera, tags, palette, optics, thresholds, tags.outer_radius, shapes, gauge, looks,
        least_px, field_px, _mask(camera.size_px, field_px),
    )  # fmt: skip


def _mask(
    size_px: tuple[int, int], corners: NDArray[np.float64] | None
) -> NDArray[np.uint8] | None:
    """Paint the part of the image that is searched."""
    if corners is None:
        return None
    mask = np.zeros((size_px[1], size_px[0]), np.uint8)
    cv2.fillPoly(
        mask, [np.rint(np.clip(corners, -1e4, 1e4) * 16.0).astype(np.int32)], (255,), shift=4
    )
    if not mask.any():
        raise VisionError(f"field_px has no pixel of the {size_px[0]} x {size_px[1]} px image")
    mask.flags.writeable = False
    return mask


def _gauge(
    camera: CameraModel,
    tags: TagSet,
    optics: Optics,
    scales: NDArray[np.float64],
    templates: tuple[Templates, Templates],
) -> Gauge:
    """Put together what the fit needs."""
    floor, chroma = floor_map(camera, scales), optics.chroma
    noise = max(float(optics.noise), _LEAST_NOISE)
    of_luma, of_blue, of_red = (noise * np.hypot.reduce(YCC_FROM_BGR, axis=1)).tolist()
    separate = chroma.subsampling == "444" and not any(chroma.offset_px)
    pixels = _plane(0, templates[0], [noise] * 3 if separate else [of_luma], 1.0)
    colors = _plane(1, templates[1], [0.5 * of_blue, 0.5 * of_red], chroma.independence)
    radius = int(np.ceil(tags.outer_radius * float(scales[-1]))) + _REACH_PX
    side = max(tag.side for tag in tags.tags)
    return Gauge(
        pixels, colors, floor.nodes, floor.level, scales, templates[0].coarse_pays,
        np.array(chroma.offset_px),
        chroma.mixed_one_way, radius, 0.5 * side,
    )  # fmt: skip


def _plane(plane: int, templates: Templates, noise: list[float], independence: float) -> Plane:
    """Put together what is known of one kind of samples."""
    return Plane(
        plane, templates.cells, templates.usage, templates.shares, templates.strides,
        templates.cell, np.array(noise), independence,
    )  # fmt: skip
