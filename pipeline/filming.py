"""What a scenario says of the rendered camera: its sensor, its surroundings, its timing."""

from collections.abc import Mapping
from math import inf, radians

import numpy as np

from datasets.clutter import Clutter
from datasets.lights import Glare, Shadow
from datasets.paths import Path, Wandering, Waypoints
from datasets.render import Renderer
from datasets.sensor import Change, Flicker, SensorModel
from datasets.surroundings import Surroundings
from datasets.things import HAND, Floats, Thing, cable_outline, outline_array, regular_outline
from pipeline.camera_config import CameraConfig
from pipeline.camera_model import make_camera, require_floor
from pipeline.cameras.delivery import Delivery
from pipeline.config import Scenario
from pipeline.errors import ConfigError
from pipeline.layouts import make_tags
from pipeline.seeing import named_colors
from pipeline.sensor_config import SensorConfig
from pipeline.surroundings_config import ClutterConfig, PathConfig, ThingConfig

Bgr = tuple[float, float, float]

_CORNERS = {"disc": 32, "square": 4, "triangle": 3}
_WANDER = 5  # a stream of randomness of its own


def make_renderer(scenario: Scenario, seed: int = 0) -> Renderer:
    """The camera of a scenario, drawing.

    Args:
        scenario: camera, sensor, surroundings, tags and colours.
        seed: of noise, floor, clutter and wandering things.

    Returns:
        The renderer.

    Raises:
        ConfigError: if a thing has a colour that is not among the scenario's, or the camera's floor
            is unknown.
    """
    require_floor(scenario.camera, "the rendered camera")
    return Renderer(
        make_camera(scenario.camera),
        make_tags(scenario),
        named_colors(scenario),
        sensor_model(scenario.sensor),
        seed,
        surroundings=make_surroundings(scenario, seed),
    )


def make_delivery(config: CameraConfig, seed: int = 0) -> Delivery:
    """How a scenario's frames arrive.

    Args:
        config: of the camera.
        seed: of what is lost, repeated and wrongly stamped.

    Returns:
        The delivery.
    """
    return Delivery(
        config.stamp_jitter_s, config.dropped_share, config.repeated_share, config.latency_s, seed
    )


def sensor_model(config: SensorConfig) -> SensorModel:
    """The sensor of a scenario.

    Args:
        config: its parameters.

    Returns:
        The model.
    """
    c = config
    return SensorModel(
        read_noise=c.read_noise,
        blur_px=c.blur_px,
        uneven_light=c.uneven_light,
        chroma=c.chroma,
        chroma_offset_px=c.chroma_offset_px,
        chroma_upsampling=c.chroma_upsampling,
        jpeg_quality=c.jpeg_quality,
        vignetting_power=c.vignetting_power,
        exposure_time=c.exposure_s,
        readout_time=c.readout_s,
        exposure_changes=tuple(
            Change(e.at_s, (e.factor, e.factor, e.factor), e.over_s) for e in c.exposure_changes
        ),
        flicker=Flicker(c.flicker_depth, c.flicker_hz),
        full_well=c.full_well_e,
        hot_pixels=c.hot_pixel_share,
        white_balance_changes=tuple(
            Change(w.at_s, (w.blue, w.green, w.red), w.over_s) for w in c.white_balance_changes
        ),
        bayer=c.bayer,
        gamma=c.gamma,
    )


def make_surroundings(scenario: Scenario, seed: int = 0) -> Surroundings:
    """What is around the robots of a scenario.

    Args:
        scenario: surroundings and colours.
        seed: of wandering things and shadows.

    Returns:
        The surroundings.

    Raises:
        ConfigError: if a thing has a colour that is not among the scenario's.
    """
    s, colors = scenario.surroundings, {c.name: c.bgr for c in named_colors(scenario)}
    shadows = tuple(
        Shadow(_path(shadow, (seed, _WANDER, 1, n)), shadow.radius_m, shadow.softness_m,
               shadow.darkness)
        for n, shadow in enumerate(s.shadows)
    )  # fmt: skip
    return Surroundings(
        tuple(_thing(t, colors, (seed, _WANDER, 0, n)) for n, t in enumerate(s.things)),
        None if s.clutter is None else _clutter(s.clutter, colors),
        shadows,
        tuple(Glare(g.x_m, g.y_m, g.width_m, g.strength) for g in s.glares),
    )


def _thing(config: ThingConfig, colors: Mapping[str, Bgr], seed: tuple[int, ...]) -> Thing:
    begin = -inf if config.from_s is None else config.from_s
    end = inf if config.until_s is None else config.until_s
    color = _color(config.color, colors, "things")
    return Thing(_outline(config), color, _path(config, seed), config.height_m, begin, end)


def _outline(config: ThingConfig) -> Floats:
    if config.shape == "hand":
        return HAND
    if config.shape == "cable":
        return cable_outline(config.line_m, config.size_m)
    if config.shape == "outline":
        return outline_array(config.outline_m)
    corners = _CORNERS[config.shape]
    return regular_outline(corners, 0.5 * config.size_m)


def _path(config: PathConfig, seed: tuple[int, ...]) -> Path:
    if config.wander is not None:
        w = config.wander
        return Wandering((w.x_m, w.y_m), w.reach_m, w.speed_mps, np.random.default_rng(seed))
    return Waypoints(
        tuple(p.at_s for p in config.points),
        tuple((p.x_m, p.y_m, radians(p.theta_deg)) for p in config.points),
    )


def _clutter(config: ClutterConfig, colors: Mapping[str, Bgr]) -> Clutter:
    found = tuple(_color(name, colors, "clutter") for name in config.colors)
    return Clutter(config.count, found, config.size_m, config.moving_share, config.speed_mps)


def _color(name: str, colors: Mapping[str, Bgr], where: str) -> Bgr:
    """A colour of the scenario."""
    if name not in colors:
        raise ConfigError(
            f'surroundings.{where}: "{name}" is not among the scenario\'s colours: '
            f"{', '.join(colors)}"
        )
    return colors[name]
