"""Colours from a few pictures of the running scene: find the tags, name them, learn the palette.

A tag teaches only if its robot is beyond doubt, and nothing is learned if two colours might as well
be exchanged. Every failure says with numbers what was seen instead.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from vision.calibration.learned import Print
from vision.calibration.lessons import Collected, Lesson, collect, find_rivals
from vision.calibration.naming import UNSEEN, Naming, name_tags, renamed
from vision.calibration.part_costs import PartColors, part_colors
from vision.calibration.print_colors import print_model
from vision.calibration.rivals import Rival
from vision.calibration.sightings import Sightings, find_outlines
from vision.errors import VisionError
from vision.eye import Eye
from vision.palette import NamedColor

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]

_SURE = 2.0  # a tag teaches if every other robot would cost so much more there
_SURE_NAMES = 3.5  # and if exchanging any colours would cost so much more
_STRANGE = 2.2  # cost per degree of freedom above which these are not the scenario's colours
_GUESSED = 4  # of them: brightness, white balance (2), stray light


@dataclass(frozen=True, slots=True)
class LearnedColors:
    """What a few pictures taught.

    Attributes:
        colors: pixels of every colour, of "black" and of "floor".
        prints: the colours that are searched for, in a common light.
        rivals: all pairs of these, the closest first.
        lessons: the tags that taught.
        unsure: tags that were found, but did not teach.
        missing: robots found in no picture.
        margin: least cost of exchanging colours, inf if no exchange is consistent.
    """

    colors: tuple[Collected, ...]
    prints: tuple[Print, ...]
    rivals: tuple[Rival, ...]
    lessons: tuple[Lesson, ...]
    unsure: int
    missing: tuple[RobotId, ...]
    margin: float


def learn_colors(
    images: tuple[Pixels, ...], eye: Eye, nominal: tuple[NamedColor, ...]
) -> LearnedColors:
    """Learn what the colours of the tags look like.

    Args:
        images: pictures of one scene in one light, each (H, W, 3), BGR, of the camera's size.
        eye: camera and tags; its palette is only asked for names.
        nominal: the scenario's colours; they need not be near what the camera sees.

    Returns:
        Samples of all colours, and how far they can be trusted.

    Raises:
        VisionError: if there is no picture or one of another size, no tag is found, a colour is
            seen on none, or colours may be exchanged.
    """
    _check_sizes(images, eye)
    frames = tuple(find_outlines(image, eye) for image in images)
    names, given = eye.palette.names, {color.name: color.bgr for color in nominal}
    model = print_model(np.array([given[name] for name in names], np.float64))
    data = part_colors(frames, eye)
    best, *others = name_tags(data, model)
    sure = _sure(data, best)
    _check_found(frames, best, sure, eye)
    _check_colors(data, best, sure, eye)
    margin = _check_names(data, best, others, names)
    lessons = _lessons(frames, data, best, sure)
    own = data.frames[best.rows]
    places = tuple(data.poses[best.rows[own == k]] for k in range(len(images)))
    found = {eye.tags.ids[tag] for tag in best.tags}
    return LearnedColors(
        collect(images, lessons, places, eye),
        tuple(Print(n, _triple(p)) for n, p in zip(names, best.prints, strict=True)),
        find_rivals(lessons, eye),
        lessons,
        int(np.count_nonzero(~sure)),
        tuple(robot_id for robot_id in eye.tags.ids if robot_id not in found),
        margin,
    )


def _check_sizes(images: tuple[Pixels, ...], eye: Eye) -> None:
    """Refuse pictures the camera cannot have taken."""
    w, h = eye.camera.size_px
    if not images:
        raise VisionError("no picture to learn colours from")
    for number, image in enumerate(images):
        if image.shape != (h, w, 3) or image.dtype != np.uint8:
            raise VisionError(
                f"picture {number}: {image.dtype} {image.shape}, but the camera takes uint8 "
                f"({h}, {w}, 3)"
            )


def _triple(color: Floats) -> tuple[float, float, float]:
    return float(color[0]), float(color[1]), float(color[2])


def _lessons(
    frames: tuple[Sightings, ...], data: PartColors, best: Naming, sure: NDArray[np.bool_]
) -> tuple[Lesson, ...]:
    """The sure ones of the named tags."""
    colors = np.concatenate([seen.colors for seen in frames])
    return tuple(
        Lesson(
            int(data.frames[n]), int(best.tags[row]), data.poses[n].copy(),
            float(best.light[row]), colors[n], float(best.margins[row]),
        )
        for row in np.flatnonzero(sure)
        for n in [int(best.rows[row])]
    )  # fmt: skip


def _sure(data: PartColors, best: Naming) -> NDArray[np.bool_]:
    """Which of the named tags are beyond doubt."""
    parts = data.used[best.tags].sum(axis=1)
    sure: NDArray[np.bool_] = (best.margins >= _SURE) & (best.costs < 0.5 * UNSEEN * parts)
    return sure


def _check_found(
    frames: tuple[Sightings, ...], best: Naming, sure: NDArray[np.bool_], eye: Eye
) -> None:
    """Refuse pictures without tags, saying what is in them."""
    freedom = 3 * int(best.seen.sum()) - _GUESSED
    strange = best.strange / max(freedom, 1)
    if sure.any() and strange < _STRANGE:
        return
    places = sum(len(seen) for seen in frames)
    residual = min((float(s.residual_px[0]) for s in frames if len(s)), default=np.nan)
    wanted = ", ".join(eye.palette.names)
    if places == 0:
        what = "nothing in them has the geometry of a tag"
    elif len(best.rows) == 0:
        what = f"{places} poses have the geometry of one (best misfit {residual:.2f} px), but "
        what += f"never with colours that could be {wanted}"
    else:
        what = f"{places} poses have the geometry of one (best misfit {residual:.2f} px), the most "
        what += f"alike could be any robot (margin {best.margins.max():.1f}, needed {_SURE:.1f}; "
        what += f"colours off {wanted} by {strange:.1f}, limit {_STRANGE:.1f})"
    raise VisionError(f"no tag found in {len(frames)} pictures: {what}")


def _check_colors(data: PartColors, best: Naming, sure: NDArray[np.bool_], eye: Eye) -> None:
    """Refuse to go on while a colour was seen on no sure tag."""
    tags = best.tags[sure]
    shown = set(data.classes[tags][data.used[tags] > 0].tolist())
    lacking = [c for c in range(len(eye.palette.names)) if c not in shown]
    if lacking:
        names = ", ".join(eye.palette.names[c] for c in lacking)
        wearing = np.flatnonzero((np.isin(data.classes, lacking) & (data.used > 0)).any(axis=1))
        robots = ", ".join(str(eye.tags.ids[t]) for t in wearing)
        close = _too_close(data, best, sure, eye)
        advice = f"put one of the robots {robots} where the camera sees it well"
        raise VisionError(
            f"no tag shows {names} beyond doubt ({len(tags)} sure tags, {len(sure) - len(tags)} "
            f"unsure); {close or advice}"
        )


def _too_close(data: PartColors, best: Naming, sure: NDArray[np.bool_], eye: Eye) -> str:
    """What makes the most doubtful tag doubtful, if it is another robot's colours."""
    doubtful = np.flatnonzero(~sure & (best.rivals != best.tags) & (best.margins < _SURE))
    if len(doubtful) == 0:
        return ""
    row = int(doubtful[best.margins[doubtful].argmin()])
    tag, rival = int(best.tags[row]), int(best.rivals[row])
    names = np.array(eye.palette.names)
    differ = data.classes[tag] != data.classes[rival]
    pairs = zip(names[data.classes[tag][differ]], names[data.classes[rival][differ]], strict=True)
    text = ", ".join(f"{one} and {other}" for one, other in pairs)
    return (
        f"{text} are too close in this light: robot {eye.tags.ids[tag]} may be "
        f"{eye.tags.ids[rival]} (margin {best.margins[row]:.1f}, needed {_SURE:.1f})"
    )


def _check_names(
    data: PartColors, best: Naming, others: list[Naming], names: tuple[str, ...]
) -> float:
    """Refuse colours that might as well be exchanged; else the least cost of an exchange."""
    for other in others:
        pairs = renamed(data, best, other)
        margin = other.total - best.total
        if pairs and margin < _SURE_NAMES:
            text = ", ".join(f"{names[c]} may be {names[d]}" for c, d in pairs)
            raise VisionError(
                f"the colours cannot be named for sure: {text} (margin {margin:.1f}, needed "
                f"{_SURE_NAMES:.1f}); give [colors] that are nearer to what the camera shows"
            )
        if pairs:
            return margin
    return float("inf")
