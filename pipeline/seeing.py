"""What a scenario says of the eye: camera, tags, colours, sharpness."""

import tomllib
from importlib import resources

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.config import CameraConfig, FloorConfig, LayoutConfig, LensConfig, Scenario
from pipeline.errors import ConfigError
from vision.camera import CameraModel, overhead_camera
from vision.eye import Eye, make_eye
from vision.optics import ChromaModel, Optics
from vision.palette import NamedColor, palette_from_colors
from vision.tags import Layout, Part, TagSet, polygon_array


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


def make_tags(scenario: Scenario) -> TagSet:
    """The tags of a scenario's robots.

    Args:
        scenario: layout, colours and robots.

    Returns:
        One tag per robot.

    Raises:
        ConfigError: if the layout or a colour is unknown.
        VisionError: if tags cannot be told apart, or a robot lacks a colour of its own.
    """
    layout = _layout(scenario)
    _check_colors(layout, scenario)
    own = [tuple((f"${k}", color) for k, color in r.colors.items()) for r in scenario.robots]
    pairs = zip(scenario.robots, own, strict=True)
    return TagSet(tuple(layout.worn_by(robot.id, colors) for robot, colors in pairs))


def named_colors(scenario: Scenario) -> tuple[NamedColor, ...]:
    """The scenario's colours as the camera sees them under full light.

    Args:
        scenario: with colours as "#rrggbb".

    Returns:
        The colours; black, of plates and rims, is always there.
    """
    texts = {"black": "#0c0c0c", **scenario.colors}
    return tuple(
        NamedColor(name, (int(c[5:7], 16), int(c[3:5], 16), int(c[1:3], 16)))
        for name, c in texts.items()
    )


def scenario_eye(scenario: Scenario, camera: CameraModel, tags: TagSet) -> Eye:
    """What `locate` needs: a palette of the tags' colours, the camera's sharpness and noise.

    Args:
        scenario: sensor and colours.
        camera: that takes the frames.
        tags: worn by the robots.

    Returns:
        The eye.
    """
    used = tuple(c for c in named_colors(scenario) if c.name in tags.colors)
    palette = palette_from_colors(used, noise=max(scenario.sensor.read_noise, 1.0))
    s = scenario.sensor
    chroma = ChromaModel(s.chroma, s.chroma_offset_px, s.chroma_upsampling)
    return make_eye(camera, tags, palette, Optics(s.blur_px, s.read_noise, chroma))


def _layout(scenario: Scenario) -> Layout:
    """The layout of the scenario's own, or a shipped one."""
    name = scenario.tags.layout
    config = scenario.layouts.get(name)
    if config is None:
        file = resources.files("datasets") / "layouts" / f"{name}.toml"
        if not file.is_file():
            raise ConfigError(f'scenario {scenario.name}: no tag layout "{name}"')
        config = LayoutConfig.model_validate(tomllib.loads(file.read_text(encoding="utf-8")))
    parts = (Part(part.name, polygon_array(part.polygon_m), part.color) for part in config.parts)
    return Layout(name, tuple(parts))


def _check_colors(layout: Layout, scenario: Scenario) -> None:
    """Refuse names that are not among the scenario's colours."""
    used = [
        (f'layout {layout.name}: {part.name} = "{part.color}"', part.color)
        for part in layout.parts
        if not part.color.startswith("$")
    ]
    used += [
        (f'robot {robot.id}: {part} = "{color}"', color)
        for robot in scenario.robots
        for part, color in robot.colors.items()
    ]
    for where, color in used:
        if color != "black" and color not in scenario.colors:
            names = ", ".join(scenario.colors)
            raise ConfigError(f"{where} is not among the scenario's colours: {names}")
