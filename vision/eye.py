"""Everything about the seeing that stays the same from frame to frame, worked out once."""

from dataclasses import dataclass
from math import gcd

import numpy as np
from numpy.typing import NDArray

from vision.camera import CameraModel
from vision.errors import VisionError
from vision.floor_map import floor_map, image_scales, sample_map, scale_levels
from vision.optics import ChromaModel, Optics
from vision.palette import Palette
from vision.shapes import Shape, group_tags, make_shape
from vision.tags import TagSet
from vision.template import Singles, Templates, stack_templates

__all__ = ["ChromaModel", "Eye", "Optics", "Thresholds", "make_eye"]

_REACH, _REACH_PX = 1.05, 0.3  # half the window's side: in radii of the tag, and pixels more
_MOST_BLOCKS = 100  # used of a window; larger windows are thinned out


@dataclass(frozen=True, slots=True)
class Thresholds:
    """When a candidate counts as a tag.

    Attributes:
        blob_share: smallest blob, as a share of the smallest coloured part.
        distance_share: error of the distance of two blobs, as a share of the expected distance.
        agreement: share of sample points that must show the part's colour before the fit.
        light_spread: standard deviation of the logarithm of the light on the parts of one tag, as
            told by their brightness.
        confidence: probability of the tag's colours, after the fit.
        residual_px: largest rms misfit after the fit [px].
        max_blobs: larger numbers are cut, the largest blobs stay.
        max_candidates: larger numbers are cut, the best candidates stay.
    """

    blob_share: float = 0.2
    distance_share: float = 0.4
    agreement: float = 0.4
    light_spread: float = 0.3
    confidence: float = 0.5
    residual_px: float = 0.8
    max_blobs: int = 400
    max_candidates: int = 64


@dataclass(frozen=True, slots=True)
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
        shape_of: shape (T,), index of every tag's geometry.
        templates: blurred coverages.
        samples: shape (H // 2, W // 2, 5, 4), floor points at tag height behind the samples of all
            2 x 2 blocks, see `sample_map` [m].
        level: shape (H, W), index of the scale nearest to every pixel's.
        window_px: side of the window around a tag, even [px].
        blocks: shape (B, 2), x, y of the 2 x 2 blocks of a window that are used [blocks].
        min_blob_px: area of the smallest blob that counts [px].
    """

    camera: CameraModel
    tags: TagSet
    palette: Palette
    optics: Optics
    thresholds: Thresholds
    radius: float
    shapes: tuple[Shape, ...]
    shape_of: NDArray[np.intp]
    templates: Templates
    samples: Singles
    level: NDArray[np.uint8]
    window_px: int
    blocks: NDArray[np.intp]
    min_blob_px: float


def make_eye(
    camera: CameraModel,
    tags: TagSet,
    palette: Palette,
    optics: Optics | None = None,
    thresholds: Thresholds | None = None,
) -> Eye:
    """Work out templates, sample points and the floor point of every pixel.

    Args:
        camera: of the frames.
        tags: worn by the robots, at least one.
        palette: with every colour the tags search for.
        optics: sharpness and noise; the default if None.
        thresholds: of acceptance; the default if None.

    Returns:
        The eye.

    Raises:
        VisionError: if there are no tags, the palette lacks a colour, or no pixel sees the floor.
    """
    optics, thresholds = optics or Optics(), thresholds or Thresholds()
    lacking = [color for color in tags.search_colors if palette.class_of(color) == 0]
    if lacking or not tags.tags:
        raise VisionError(f"{len(tags.tags)} tags; the palette lacks {', '.join(lacking) or '-'}")
    scales, groups = image_scales(camera), group_tags(tags.tags)
    half = int(np.ceil(_REACH * tags.outer_radius * float(scales[-1]) + _REACH_PX))
    window = min(2 * half + 2, min(camera.size_px) // 2 * 2)
    worn = tuple(tags.tags[group[0]] for group in groups)
    templates, sharp = stack_templates(worn, scales, optics, window)
    shapes = tuple(make_shape(tags, *pair, palette) for pair in zip(groups, sharp, strict=True))
    shape_of = np.argsort(np.concatenate(groups))  # where each tag stands in the list of groups
    shape_of = np.repeat(np.arange(len(groups)), [len(group) for group in groups])[shape_of]
    floor = floor_map(camera)
    smallest = min(float(s.areas[s.part_classes.any(axis=0)].min()) for s in shapes)
    least_px = max(2.0, thresholds.blob_share * smallest * float(scales[0]) ** 2)
    return Eye(
        camera, tags, palette, optics, thresholds, tags.outer_radius, shapes, shape_of, templates,
        sample_map(floor, optics.chroma, templates.chroma_row), scale_levels(floor, scales),
        window, _used_blocks(window), least_px,
    )  # fmt: skip


def _used_blocks(window_px: int) -> NDArray[np.intp]:
    """Blocks inside a circle; if there are many, a lattice of them that visits every row."""
    count = window_px // 2
    y, x = np.divmod(np.arange(count * count), count)
    middle = 0.5 * (count - 1)
    inside = np.hypot(x - middle, y - middle) <= 0.5 * count + 0.3
    stride = -(-int(np.count_nonzero(inside)) // _MOST_BLOCKS)
    turn = next(m for m in range(round(0.62 * stride), 2 * stride + 1) if gcd(m, stride) == 1)
    used = np.flatnonzero(inside & ((x + turn * y) % stride == 0))
    return np.column_stack((x[used], y[used]))
