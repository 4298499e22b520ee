"""What a scenario says of the eye: camera, tags, colours, sharpness."""

import tomllib
from importlib import resources

import numpy as np

from pipeline.config import CameraConfig, LayoutConfig, Scenario
from pipeline.errors import ConfigError
from vision.calibration.learned import Print, palette_from_samples
from vision.camera import CameraModel, overhead_camera
from vision.eye import Eye, make_eye
from vision.optics import ChromaModel, Optics
from vision.palette import ColorSamples, NamedColor, Palette, palette_from_colors
from vision.tags import Layout, Part, TagSet, polygon_array


def make_camera(config: CameraConfig) -> CameraModel:
    """The camera of a scenario.

    Args:
        config: where it hangs and what it delivers.

    Returns:
        The calibrated camera.
    """
    return overhead_camera(
        (config.width_px, config.height_px),
        config.field_width_m,
        config.center_m,
        config.mount_height_m,
        config.tag_height_m,
        config.distortion,
    )


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

    Raises:
        ConfigError: if [palette] lacks a colour of the tags.
    """
    s = scenario.sensor
    chroma = ChromaModel(s.chroma, s.chroma_offset_px, s.chroma_upsampling)
    palette = scenario_palette(scenario, tags)
    return make_eye(camera, tags, palette, Optics(s.blur_px, s.read_noise, chroma))


def scenario_palette(scenario: Scenario, tags: TagSet) -> Palette:
    """The palette of the tags' colours: as measured, or else from the nominal colours.

    Args:
        scenario: its [palette] or its [colors].
        tags: worn by the robots.

    Returns:
        The palette.

    Raises:
        ConfigError: if [palette] lacks a colour of the tags.
    """
    config = scenario.palette
    if config is None:
        used = tuple(c for c in named_colors(scenario) if c.name in tags.colors)
        return palette_from_colors(used, noise=max(scenario.sensor.read_noise, 1.0))
    lacking = [name for name in tags.search_colors if name not in config.samples]
    if lacking:
        raise ConfigError(
            f"scenario {scenario.name}: palette.samples lacks {', '.join(lacking)}, which the tags "
            "need; run echelon calibrate colors with all robots in the picture"
        )
    used_names = {*tags.search_colors, "black", "floor"}
    samples = tuple(
        ColorSamples(name, np.array(pixels, np.uint8))
        for name, pixels in config.samples.items()
        if name in used_names
    )
    prints = tuple(Print(name, config.prints[name]) for name in tags.search_colors)
    return palette_from_samples(samples, prints, config.light)


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
