"""What a scenario says of the camera: calibrated, ideal, or with an unknown floor."""

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.camera_config import CameraConfig, FloorConfig, LensConfig
from pipeline.errors import ConfigError
from vision.camera import CameraModel, overhead_camera


def make_camera(config: CameraConfig, tag_side: float = 0.075) -> CameraModel:
    """The camera of a scenario: calibrated, ideal, or with an unknown floor.

    Args:
        config: where it hangs and what it delivers.
        tag_side: side of a tag, which gives the scale where the floor is unknown [m].

    Returns:
        The camera. An unknown floor is taken as square to the view, at the height of the tags:
        right for the search of tags, of no meaning in metres.

    Raises:
        ConfigError: if the lens is calibrated for another resolution and may not be scaled, or
            the tags are not below the camera.
        VisionError: if the numbers make no camera.
    """
    size = (config.width_px, config.height_px)
    if not config.floor_known:
        return _unknown_floor(config, size, tag_side)
    if config.lens is None:
        return overhead_camera(
            size, config.field_width_m, config.center_m, config.mount_height_m,
            config.tag_height_m, config.distortion,
        )  # fmt: skip
    assert isinstance(config.floor, FloorConfig)
    rotation = np.asarray(cv2.Rodrigues(np.array(config.floor.rotation_rad))[0], np.float64)
    camera = _behind_lens(config.lens, rotation, config.floor.translation_m, config.tag_height_m)
    if camera.position[2] <= config.tag_height_m:
        raise ConfigError(
            f"camera.floor puts the camera {camera.position[2]:.3f} m above the floor, the tags "
            f"are at tag_height_m = {config.tag_height_m:g}"
        )
    return _of_size(camera, size, config.other_sizes)


def require_floor(config: CameraConfig, command: str) -> None:
    """Refuse work in metres where the floor is unknown.

    Args:
        config: of the camera.
        command: that needs the floor.

    Raises:
        ConfigError: if the floor is unknown, with the remedy.
    """
    if not config.floor_known:
        raise ConfigError(
            f"{command}: the camera's floor is unknown, so pixels give no metres; calibrate it "
            "(echelon calibrate camera --floor or --points) and include the file it writes"
        )


def _behind_lens(
    lens: LensConfig, rotation: NDArray[np.float64], translation: ArrayLike, tag_height: float
) -> CameraModel:
    """A camera with a calibrated lens."""
    (fx, fy), (cx, cy) = lens.focal_px, lens.center_px
    matrix = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
    distortion, place = np.array(lens.distortion), np.array(translation, np.float64)
    return CameraModel(lens.size_px, matrix, distortion, rotation, place, tag_height)


def _unknown_floor(config: CameraConfig, size: tuple[int, int], tag_side: float) -> CameraModel:
    """A camera that looks straight down at tags of about the right size."""
    width = config.field_width_m
    if config.tag_px is not None:
        width = size[0] * tag_side / config.tag_px
    if config.lens is None:
        return overhead_camera(size, width, (0.0, 0.0), width, 0.0, config.distortion)
    height = config.lens.focal_px[0] * width / config.lens.size_px[0]
    down = np.diag([1.0, -1.0, -1.0])
    camera = _behind_lens(config.lens, down, (0.0, 0.0, height), 0.0)
    return _of_size(camera, size, config.other_sizes)


def _of_size(camera: CameraModel, size: tuple[int, int], others: str) -> CameraModel:
    """The camera at the resolution the scenario asks for."""
    if camera.size_px == size:
        return camera
    if others != "scale":
        raise ConfigError(
            f"camera.lens is calibrated for {camera.size_px[0]} x {camera.size_px[1]} px, but the "
            f"camera delivers {size[0]} x {size[1]} px (width_px, height_px); if both show the "
            'same field, say camera.other_sizes = "scale"'
        )
    return camera.scaled_to(size)
