"""What the robots wear: tag layouts as data, shipped or the scenario's own, and printed markers."""

import tomllib
from importlib import resources
from math import pi, sin

import numpy as np
from numpy.typing import NDArray

from pipeline.config import LayoutConfig, PartConfig, RobotConfig, Scenario
from pipeline.errors import ConfigError
from vision.markers import WHITE, MarkerSet, fitting_side
from vision.tags import Layout, Part, TagSet, polygon_array

ARUCO = "aruco"
"""The layout that stands for printed markers and for the detector that finds them."""

PLATE = 0.075  # side of the plate on which markers are put if nobody says how large they are [m]
_CORNERS = 32  # of the polygon that stands for a dot
_SIDE_SLACK = 0.02  # share by which a plate may differ from the side that its layout states


def make_tags(scenario: Scenario) -> TagSet:
    """The tags of a scenario's robots.

    Args:
        scenario: layout, colours and robots.

    Returns:
        One tag per robot.

    Raises:
        ConfigError: if the layout, a pattern or a colour is unknown.
        VisionError: if tags cannot be told apart, or a robot lacks a colour of its own.
    """
    markers = make_markers(scenario)
    if markers is not None:
        return markers.tags
    name = scenario.tags.layout
    config = find_layout(scenario, name)
    for robot in scenario.robots:
        if robot.marker is not None:
            raise ConfigError(f'robot {robot.id}: only layout "{ARUCO}" has markers, not {name}')
    own = [_colors_of(robot, config, scenario) for robot in scenario.robots]
    layout = make_layout(name, config)
    _check_colors(layout, own, scenario)
    pairs = zip(scenario.robots, own, strict=True)
    tags = (layout.worn_by(robot.id, colors) for robot, colors in pairs)
    return TagSet(
        tuple(tags), mirror_twins=layout.mirror_twins, look_alikes=scenario.tags.look_alikes
    )


def make_markers(scenario: Scenario) -> MarkerSet | None:
    """The printed markers of a scenario's robots.

    Args:
        scenario: tags and robots.

    Returns:
        The markers, None if the robots wear colours.

    Raises:
        ConfigError: if a robot has no marker, or a colour or a pattern.
        VisionError: if the dictionary or a marker is unknown, or two robots wear the same.
    """
    if scenario.tags.layout != ARUCO:
        return None
    for robot in scenario.robots:
        if robot.marker is None or robot.pattern is not None or robot.colors:
            raise ConfigError(
                f'robot {robot.id}: layout "{ARUCO}" needs marker = NUMBER, no pattern, no colors'
            )
    dictionary = scenario.tags.dictionary
    side = scenario.tags.marker_m or fitting_side(dictionary, PLATE)
    return MarkerSet(dictionary, side, tuple((r.id, r.marker or 0) for r in scenario.robots))


def layout_names() -> list[str]:
    """Names of the shipped layouts, sorted.

    Returns:
        Names without the file ending.
    """
    folder = resources.files("datasets") / "layouts"
    return sorted(f.name.removesuffix(".toml") for f in folder.iterdir() if f.name[-5:] == ".toml")


def shipped_layout(name: str) -> LayoutConfig:
    """Read a shipped layout.

    Args:
        name: one of `layout_names`.

    Returns:
        The layout.
    """
    file = resources.files("datasets") / "layouts" / f"{name}.toml"
    return LayoutConfig.model_validate(tomllib.loads(file.read_text(encoding="utf-8")))


def find_layout(scenario: Scenario, name: str) -> LayoutConfig:
    """Find a layout: the scenario's own, or a shipped one.

    Args:
        scenario: may have layouts of its own; they come first.
        name: of the layout.

    Returns:
        The layout as data.

    Raises:
        ConfigError: if there is none of the name.
    """
    if name in scenario.layouts:
        return scenario.layouts[name]
    names = layout_names()
    if name not in names:
        known = ", ".join([*scenario.layouts, *names, ARUCO])
        raise ConfigError(f'scenario {scenario.name}: no tag layout "{name}"; there are: {known}')
    return shipped_layout(name)


def make_layout(name: str, config: LayoutConfig) -> Layout:
    """Build a layout from data.

    Args:
        name: of the layout.
        config: its data.

    Returns:
        The layout.

    Raises:
        ConfigError: if the plate has another size than the layout says.
        VisionError: if a polygon has no area.
    """
    parts = tuple(Part(part.name, _polygon(part), part.color) for part in config.parts)
    side = float(np.ptp(parts[0].polygon, axis=0).max())
    if abs(side - config.side_m) > _SIDE_SLACK * config.side_m:
        raise ConfigError(
            f"layout {name}: side_m = {config.side_m:g}, "
            f"but its first part, {parts[0].name}, is {side:g} m wide"
        )
    return Layout(name, parts, config.mirror_twins)


def nominal_colors(scenario: Scenario) -> dict[str, str]:
    """Every colour the scenario's tags may use, as "#rrggbb"; the scenario's own come first.

    Args:
        scenario: colours and layout.

    Returns:
        Colours by name; black, of plates and rims, is always there.

    Raises:
        ConfigError: if the layout is unknown.
    """
    name = scenario.tags.layout
    layout = {WHITE: "#ffffff"} if name == ARUCO else find_layout(scenario, name).colors
    return {"black": "#0c0c0c", **layout, **scenario.colors}


def _colors_of(
    robot: RobotConfig, config: LayoutConfig, scenario: Scenario
) -> tuple[tuple[str, str], ...]:
    """Colours of the placeholders: by default, for all robots, by pattern, for this robot."""
    pattern: dict[str, str] = {}
    if robot.pattern is not None:
        if str(robot.pattern) not in config.patterns:
            known = ", ".join(config.patterns) or "none"
            raise ConfigError(
                f"robot {robot.id}: layout {scenario.tags.layout} has no pattern {robot.pattern}; "
                f"there are: {known}"
            )
        pattern = config.patterns[str(robot.pattern)]
    given = {**config.defaults, **scenario.tags.colors, **pattern, **robot.colors}
    return tuple((f"${part}", color) for part, color in given.items())


def _polygon(part: PartConfig) -> NDArray[np.float64]:
    """The outline of a part; that of a dot has the dot's area."""
    if part.polygon_m is not None:
        return polygon_array(part.polygon_m)
    turns = 2.0 * pi * np.arange(_CORNERS) / _CORNERS
    share = (2.0 * pi / _CORNERS / sin(2.0 * pi / _CORNERS)) ** 0.5  # polygon of the same area
    radius = 0.5 * (part.diameter_m or 0.0) * share
    return polygon_array(part.center_m + radius * np.column_stack((np.cos(turns), np.sin(turns))))


def _check_colors(
    layout: Layout, own: list[tuple[tuple[str, str], ...]], scenario: Scenario
) -> None:
    """Refuse names that are not among the colours."""
    used = [
        (f'layout {layout.name}: {part.name} = "{part.color}"', part.color)
        for part in layout.parts
        if not part.color.startswith("$")
    ]
    used += [
        (f'robot {robot.id}: {part[1:]} = "{color}"', color)
        for robot, colors in zip(scenario.robots, own, strict=True)
        for part, color in colors
    ]
    known = nominal_colors(scenario)
    for where, color in used:
        if color not in known:
            names = ", ".join(known)
            raise ConfigError(f"{where} is not among the scenario's colours: {names}")
