"""The floor behind every pixel, worked out once: exact for every camera, cheap in every frame."""

import numpy as np
from numpy.typing import NDArray

from vision.camera import CameraModel
from vision.errors import VisionError
from vision.optics import ChromaModel

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]

_SCALE_STEP = 1.1  # scales that differ by less than this factor are treated as one
_FAR = 1e3  # where a ray that misses the floor is said to meet it [m]


def image_scales(camera: CameraModel) -> Floats:
    """Find the scales at tag height that occur in the image.

    Args:
        camera: that takes the image.

    Returns:
        Ascending scales, each at most `_SCALE_STEP` times the one before, shape (L,) [px/m].

    Raises:
        VisionError: if no pixel sees the floor.
    """
    w, h = camera.size_px
    grid = np.stack(np.meshgrid(np.linspace(0, w - 1, 7), np.linspace(0, h - 1, 7)), -1)
    floor = camera.to_floor(grid.reshape(-1, 2), camera.tag_height)
    floor = floor[np.isfinite(floor).all(axis=1)]
    if len(floor) == 0:
        raise VisionError("no pixel of the camera sees the floor at tag height")
    affine = camera.affine_at(np.column_stack((floor, np.full(len(floor), camera.tag_height))))
    scale = np.sqrt(np.abs(np.linalg.det(affine)))
    low, high = max(float(scale.min()), float(np.median(scale)) / 3.0), float(scale.max())
    count = 1 + int(np.ceil(np.log(high / low) / np.log(_SCALE_STEP) - 1e-6))
    return np.geomspace(low, high, count) if count > 1 else np.array([high])


def floor_map(camera: CameraModel) -> Singles:
    """Find the floor point at tag height behind every pixel.

    Args:
        camera: that takes the image.

    Returns:
        Homogeneous points (x, y, 1), shape (H, W, 3), far away where there is none [m], read-only.
    """
    w, h = camera.size_px
    x, y = np.meshgrid(np.arange(w, dtype=np.float64), np.arange(h, dtype=np.float64))
    pixels = np.column_stack((x.reshape(-1), y.reshape(-1)))
    points = np.ones((w * h, 3), np.float32)
    points[:, :2] = np.nan_to_num(camera.to_floor(pixels, camera.tag_height), nan=_FAR)
    points.flags.writeable = False
    return points.reshape(h, w, 3)


def sample_map(floor: Singles, chroma: ChromaModel, chroma_row: int) -> Singles:
    """Arrange the floor points of the samples of all blocks of 2 x 2 pixels as the fit needs them.

    Args:
        floor: shape (H, W, 3), homogeneous floor points of the pixels [m].
        chroma: where colour is sampled.
        chroma_row: fourth coordinate of colour samples; that of brightness samples is 0.

    Returns:
        Shape (H // 2, W // 2, 5, 4): x, y, 1, row of the four pixels, row by row, and of the colour
        sample, read-only.
    """
    right, down = np.float32(0.5) - np.array(chroma.offset_px, np.float32)
    h, w = floor.shape[0] // 2 * 2, floor.shape[1] // 2 * 2
    blocks = floor[:h, :w].reshape(h // 2, 2, w // 2, 2, 3).transpose(0, 2, 1, 3, 4)
    blocks = blocks.reshape(h // 2, w // 2, 4, 3)
    across, along = blocks[:, :, 1] - blocks[:, :, 0], blocks[:, :, 2] - blocks[:, :, 0]
    samples = np.zeros((h // 2, w // 2, 5, 4), np.float32)
    samples[:, :, :4, :3] = blocks
    samples[:, :, 4, :3] = blocks[:, :, 0] + right * across + down * along
    samples[:, :, 4, 3] = chroma_row
    samples.flags.writeable = False
    return samples


def scale_levels(floor: Singles, scales: Floats) -> NDArray[np.uint8]:
    """Find the nearest of some scales for every pixel.

    Args:
        floor: shape (H, W, 3), homogeneous floor points of the pixels [m].
        scales: shape (L,), ascending, L <= 256 [px/m].

    Returns:
        Indices of scales, shape (H, W), read-only.
    """
    level = np.zeros(floor.shape[:2], np.uint8)
    if len(scales) > 1:
        slopes = np.gradient(floor[..., :2].astype(np.float64), axis=(0, 1))
        down, across = np.asarray(slopes)
        area = np.abs(across[..., 0] * down[..., 1] - across[..., 1] * down[..., 0])
        limits = 1.0 / (scales[1:] * scales[:-1])  # the area of a pixel between two scales [m^2]
        level = np.asarray((area[..., None] < limits).sum(axis=-1), np.uint8)
    level.flags.writeable = False
    return level
