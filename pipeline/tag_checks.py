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
from vision.tags import Tag, TagSet
from vision.twins import ALIKE, likenesses

TAG_PX = 8.0  # width of a tag that is found reliably
PART_PX = 2.4  # and of its smallest coloured part, as the root of its area
CELL_PX = 3.0  # and of a cell of a marker


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
    markers = make_markers(scenario)
    if markers is None:
        part, least, what = (
            _smallest_part(tag, seeing.tags.background),
            PART_PX,
            "its smallest part",
        )
    else:
        cells = marker_dictionary(markers.dictionary).markerSize + 2
        part, least, what = markers.side / cells, CELL_PX, "a cell of its marker"
    return Finding(
        "robots in the picture",
        tag.side * scale >= TAG_PX and part * scale >= least,
        f"{camera.size_px[0]} x {camera.size_px[1]} px, {1e3 / scale:.1f} mm per pixel at tag "
        f"height: a tag is {tag.side * scale:.1f} px wide ({TAG_PX:g} px needed), "
        f"{what} {part * scale:.1f} px ({least:g} px needed)",
    )


def _smallest_part(tag: Tag, background: tuple[str, ...]) -> float:
    """Root of the smallest visible area of a coloured part [m]."""
    colored = [n for n, part in enumerate(tag.parts) if part.color not in background]
    return float(np.sqrt(min(tag.visible_area(n) for n in colored)))


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
