"""Whether tags can be told apart and are large enough in the picture; layouts not used as well."""

from collections.abc import Iterator

import numpy as np

from pipeline.config import LayoutConfig, RobotConfig, Scenario, TagsConfig
from pipeline.errors import ConfigError
from pipeline.finding import Finding
from pipeline.layouts import ARUCO, make_markers, make_tags
from pipeline.seeing import Seeing
from vision.errors import VisionError
from vision.markers import marker_dictionary
from vision.tags import TagSet
from vision.twins import ALIKE, likenesses

TAG_PX = 8.0  # width at which a coloured tag is found reliably
CELL_PX = 3.0  # and a cell of a marker


def check_tags(scenario: Scenario, seeing: Seeing) -> Iterator[Finding]:
    """Check the robots' tags, and the layouts that the scenario defines and does not use.

    Args:
        scenario: with tags, robots and layouts.
        seeing: of the scenario.

    Yields:
        One finding for the tags, one for their size in the picture, one for every further layout.
    """
    yield Finding("tags", True, f"layout {scenario.tags.layout}: {_told_apart(seeing.tags)}")
    yield _size(scenario, seeing)
    for name, config in scenario.layouts.items():
        if name != scenario.tags.layout:
            yield _layout(scenario, name, config)


def _told_apart(tags: TagSet) -> str:
    """How many tags, and which two are the most alike."""
    found = likenesses(tags.tags, tags.background, tags.mirror_twins)
    pairs = [like for like in found if like.one != like.other]
    if not pairs:
        return "one tag"
    nearest = min(pairs, key=lambda like: like.differs)
    one, other = tags.ids[nearest.one], tags.ids[nearest.other]
    how = f"{'mirrored and ' * nearest.mirrored}turned by {nearest.turn_deg} deg"
    mirror = "; mirror images count as different" if tags.mirror_twins else ""
    return (
        f"{len(tags.tags)} tags; most alike are robots {one} and {other}: {how} the second differs "
        f"from the first on {nearest.differs:.0%} of the coloured area ({ALIKE:.0%} needed){mirror}"
    )


def _size(scenario: Scenario, seeing: Seeing) -> Finding:
    """How large a tag appears in the middle of the picture."""
    camera, tag = seeing.camera, seeing.tags.tags[0]
    middle = 0.5 * (np.array([camera.size_px]) - 1.0)
    floor = camera.to_floor(middle, camera.tag_height)
    affine = camera.affine_at(np.column_stack((floor, [camera.tag_height])))[0]
    scale = float(np.sqrt(abs(np.linalg.det(affine))))
    size, needed, what = tag.side * scale, TAG_PX, "a tag"
    markers = make_markers(scenario)
    if markers is not None:
        cells = marker_dictionary(markers.dictionary).markerSize + 2
        size, needed, what = markers.side / cells * scale, CELL_PX, "a cell of a marker"
    return Finding(
        "robots in the picture",
        size >= needed,
        f"{camera.size_px[0]} x {camera.size_px[1]} px, {1e3 / scale:.1f} mm per pixel at tag "
        f"height: {what} is {size:.1f} px wide ({needed:g} px needed)",
    )


def _layout(scenario: Scenario, name: str, config: LayoutConfig) -> Finding:
    """A layout that is defined and not used: all its patterns together."""
    topic = f"layout {name}"
    if name == ARUCO:
        return Finding(topic, False, f'"{ARUCO}" stands for printed markers: choose another name')
    if not config.patterns:
        return Finding(topic, True, "not used; no patterns to check")
    robots = tuple(RobotConfig(id=pattern, pattern=pattern) for pattern in config.patterns)
    changes = {"tags": TagsConfig(layout=name), "robots": robots}
    try:
        return Finding(topic, True, _told_apart(make_tags(scenario.model_copy(update=changes))))
    except (ConfigError, VisionError) as error:
        return Finding(topic, False, str(error))
