"""The floor from points at known places: fit, leave-one-out errors, and which point is wrong."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.bundle import LENS, Fit, Problem, Seen, State, adjust
from vision.calibration.floor import camera_of
from vision.calibration.lens import pose_of
from vision.errors import VisionError

Floats = NDArray[np.float64]

LEAST_POINTS = 4
MOST_MISFIT = 0.005  # rms distance of points from their predictions, of the image's width
LEAST_CLICK_PX = 0.3  # nobody gives pixels better than that, however well few of them fit
_FLAT = 0.03  # extent across the longest direction by that along it: less is a line
_BETTER = 0.3  # without the wrong point the rest fits so much better
_NO_TERMS = np.zeros(LENS, np.bool_)


@dataclass(frozen=True, slots=True)
class KnownPoint:
    """A point of the floor and the pixel that shows it.

    Attributes:
        name: for messages.
        floor: x, y, z in the floor frame; z is 0 but for tags on robots [m].
        pixel: x, y [px].
    """

    name: str
    floor: tuple[float, float, float]
    pixel: tuple[float, float]


def seen_points(points: Sequence[KnownPoint]) -> Seen:
    """Points as the fit takes them.

    Args:
        points: at least one.

    Returns:
        Places beside pixels.
    """
    return Seen(
        np.array([p.floor for p in points], np.float64),
        np.array([p.pixel for p in points], np.float64),
    )


def floor_of_points(
    points: Sequence[KnownPoint], lens: Floats, spread: Floats, size_px: tuple[int, int]
) -> tuple[Fit, Floats]:
    """Fit the floor to known points under a known lens.

    Args:
        points: at least four, not on one line.
        lens: shape (9,).
        spread: shape (9, 9), the lens's covariance; zeros if it is taken as exact.
        size_px: width and height of the image [px].

    Returns:
        The fit, its covariance taking in the lens's, and how far every point is from where a floor
        fitted without it puts it, shape (N,) [m].

    Raises:
        VisionError: if the points are too few, on one line, outside the image, mirrored, or if one
            of them is wrong: it is named, with what may have been meant.
    """
    _check(points, size_px)
    problem, fit = _fit(seen_points(points), lens)
    _check_fit(points, lens, fit, MOST_MISFIT * size_px[0])
    covariance = fit.covariance * max(1.0, (LEAST_CLICK_PX / max(fit.rms, 1e-9)) ** 2)
    by_lens = _floor_by_lens(problem, fit)
    covariance[:LENS, :LENS] = spread
    covariance[LENS:, :LENS] = by_lens @ spread
    covariance[:LENS, LENS:] = spread @ by_lens.T
    covariance[LENS:, LENS:] += by_lens @ spread @ by_lens.T
    errors = [_left_out(points, index, lens, size_px) for index in range(len(points))]
    return replace(fit, covariance=covariance), np.array(errors)


def _check(points: Sequence[KnownPoint], size_px: tuple[int, int]) -> None:
    """Refuse what cannot give a plane."""
    if len(points) < LEAST_POINTS:
        raise VisionError(
            f"{len(points)} points on the floor: {LEAST_POINTS} are needed, 6 or more show errors"
        )
    for p in points:
        if not np.isfinite((*p.floor, *p.pixel)).all():
            raise VisionError(f"point {p.name}: its numbers are not finite")
        x, y = p.pixel
        if not (-0.5 <= x <= size_px[0] - 0.5 and -0.5 <= y <= size_px[1] - 0.5):
            raise VisionError(
                f"point {p.name}: pixel ({x:g}, {y:g}) is outside the image of "
                f"{size_px[0]} x {size_px[1]} px"
            )
    _check_twice(points)
    for what, places in (("floor", [p.floor[:2] for p in points]),
                         ("image", [p.pixel for p in points])):  # fmt: skip
        _, extent, axes = np.linalg.svd(np.array(places) - np.mean(places, axis=0))
        if extent[1] < _FLAT * extent[0]:
            raise VisionError(
                f"the points lie on one line in the {what} (direction "
                f"{axes[0, 0]:.2f}, {axes[0, 1]:.2f}): add points beside it"
            )


def _check_twice(points: Sequence[KnownPoint]) -> None:
    """Refuse a place or pixel that is given twice."""
    for index, one in enumerate(points):
        for other in points[:index]:
            if np.hypot(*np.subtract(one.floor[:2], other.floor[:2])) < 1e-4:
                raise VisionError(f"points {other.name} and {one.name} are at the same place")
            if np.hypot(*np.subtract(one.pixel, other.pixel)) < 0.5:
                raise VisionError(f"points {other.name} and {one.name} are at the same pixel")


def _fit(seen: Seen, lens: Floats) -> tuple[Problem, Fit]:
    """The floor of points; those at several heights start from their mean height."""
    level = seen.points.copy()
    level[:, 2] = seen.points[:, 2].mean()
    start = State(lens, np.zeros((0, 6)), pose_of(replace(seen, points=level), lens), _NOWHERE)
    problem = Problem((), seen, (), _NO_TERMS)
    return problem, adjust(problem, start)


_NOWHERE = np.zeros((0, 3))


def _check_fit(points: Sequence[KnownPoint], lens: Floats, fit: Fit, limit: float) -> None:
    """Refuse points that do not fit, with the most likely mistake."""
    above = -cv2.Rodrigues(fit.state.floor[:3])[0][:, 2] @ fit.state.floor[3:] > 0.0
    if fit.rms <= limit and above:
        return
    mirrored = [replace(p, floor=(p.floor[1], p.floor[0], p.floor[2])) for p in points]
    if not above or _fit(seen_points(mirrored), lens)[1].rms < _BETTER * fit.rms:
        _, other = _fit(seen_points(mirrored), lens)
        if other.rms <= limit:
            raise VisionError(
                "the points are mirrored: seen from above, y is to the left of x; swap x and y, or "
                f"change the sign of one of them (misfit {fit.rms:.1f} px, then {other.rms:.1f} px)"
            )
    named = _wrong_point(points, lens, fit, limit)
    off = np.linalg.norm(fit.residuals[0], axis=1)
    worst = points[int(off.argmax())]
    raise VisionError(
        named
        or f"the points do not fit a floor ({fit.rms:.1f} px rms, {limit:.1f} px allowed); the "
        f"worst is point {worst.name}, off by {off.max():.1f} px: is it the right lens?"
    )


def _wrong_point(points: Sequence[KnownPoint], lens: Floats, fit: Fit, limit: float) -> str:
    """Name the one point without which the others agree; empty if there is none."""
    if len(points) <= LEAST_POINTS:
        return ""
    best, floor, which = fit.rms, fit.state.floor, -1
    for index in range(len(points)):
        rest = [p for i, p in enumerate(points) if i != index]
        try:
            _, less = _fit(seen_points(rest), lens)
        except VisionError:
            continue
        if less.rms < best:
            best, floor, which = less.rms, less.state.floor, index
    if which < 0 or best > min(limit, _BETTER * fit.rms):
        return ""
    wrong = points[which]
    camera = camera_of((1, 1), lens, floor, 0.0)
    x, y = camera.to_floor(np.array([wrong.pixel]), wrong.floor[2])[0]
    return (
        f"point {wrong.name} at ({wrong.floor[0]:g}, {wrong.floor[1]:g}) m is wrong: the others "
        f"({best:.1f} px rms) put its pixel at ({x:.3f}, {y:.3f}) m{_meant(wrong, x, y)}"
    )


def _meant(wrong: KnownPoint, x: float, y: float) -> str:
    """What may have been meant by a mistyped place."""
    a, b, _ = wrong.floor
    guesses = {
        "x and y swapped": (b, a), "the sign of x": (-a, b), "the sign of y": (a, -b),
        "both signs": (-a, -b), "the decimal point of x": (10 * a, b),
        "the decimal point of y": (a, 10 * b), "the decimal point of x ": (a / 10, b),
        "the decimal point of y ": (a, b / 10),
    }  # fmt: skip
    tolerance = 0.02 + 0.02 * np.hypot(x, y)
    near = [
        text for text, place in guesses.items() if np.hypot(*np.subtract(place, (x, y))) < tolerance
    ]
    return f" ({near[0].strip()}?)" if near else ""


def _floor_by_lens(problem: Problem, fit: Fit) -> Floats:
    """Derivatives of the floor's numbers by the lens's, shape (6, 9), by differences."""
    slopes = np.zeros((6, LENS))
    for index in range(LENS):
        step = 1e-5 * max(abs(fit.state.lens[index]), 1.0)
        ends = []
        for sign in (1.0, -1.0):
            lens = fit.state.lens.copy()
            lens[index] += sign * step
            ends.append(adjust(problem, replace(fit.state, lens=lens)).state.floor)
        slopes[:, index] = (ends[0] - ends[1]) / (2.0 * step)
    return slopes


def _left_out(
    points: Sequence[KnownPoint], index: int, lens: Floats, size_px: tuple[int, int]
) -> float:
    """How far a point is from where the others put its pixel [m]."""
    rest = seen_points([p for i, p in enumerate(points) if i != index])
    problem = Problem((), rest, (), _NO_TERMS)
    whole = _fit(seen_points(points), lens)[1].state
    floor = adjust(problem, whole).state.floor
    out = points[index]
    camera = camera_of(size_px, lens, floor, 0.0)
    place = camera.to_floor(np.array([out.pixel]), out.floor[2])[0]
    return float(np.hypot(*(place - out.floor[:2])))
