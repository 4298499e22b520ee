"""Why a fitted camera is not to be trusted, in sentences with numbers and remedies."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.bundle import Fit, Problem, State
from vision.calibration.detect import BoardView
from vision.calibration.floor import FittedFloor, camera_of, floor_spread
from vision.calibration.views import LEAST_VIEWS, lacking_regions

Floats = NDArray[np.float64]

LEAST_TILT_DEG = 15.0  # largest angle between two boards, at least
MOST_RMS = 1e-3  # reprojection error, of the image's width
MOST_FOCAL = 0.01  # relative standard deviation of the focal length
MOST_FLOOR_PX = 1.0  # expected error on the floor, in pixels


def too_few(
    before: Sequence[BoardView],
    held: Sequence[BoardView],
    laid: Sequence[BoardView],
    said: Sequence[str],
    fit: Fit,
    least: int = LEAST_VIEWS,
) -> list[str]:
    """Complain when views that do not fit leave too few, or not the one that gives the floor frame.

    Args:
        before: views that were on the floor, the first one giving the frame.
        held: views left, in the hands.
        laid: views left, on the floor.
        said: what was left out.
        fit: of all views.
        least: views needed.

    Returns:
        Sentences; none if there are enough.
    """
    if before and (not laid or laid[0].name != before[0].name):
        return [f"{before[0].name} gives the floor frame, but does not fit: {'; '.join(said)}"]
    if len(held) + len(laid) >= least:
        return []
    return [
        f"the views do not fit one flat board and one camera (reprojection error {fit.rms:.2f} "
        f"px); without the worst, {len(held) + len(laid)} would be left: {'; '.join(said)}"
    ]


def lens_doubts(
    fit: Fit,
    problem: Problem,
    views: Sequence[BoardView],
    size_px: tuple[int, int],
) -> list[str]:
    """Say why a lens is not to be trusted.

    Args:
        fit: of the lens.
        problem: what was fitted.
        views: in the order of the fit.
        size_px: width and height of the image [px].

    Returns:
        Sentences; none if it is good.
    """
    found = too_large(fit, views, size_px)
    tilt = np.degrees(largest_tilt(problem, fit.state))
    if tilt < LEAST_TILT_DEG:
        found.append(
            f"all boards are nearly parallel (at most {tilt:.0f} deg apart, "
            f"{LEAST_TILT_DEG:.0f} needed): tilt the board differently in every picture"
        )
    spread = np.sqrt(np.diag(fit.covariance)[:2]) / fit.state.lens[:2]
    if not spread.max() < MOST_FOCAL:
        found.append(
            f"the focal length is known to {100 * spread.max():.1f} % only "
            f"({100 * MOST_FOCAL:.0f} % needed): tilt the board more, and show it closer"
        )
    if not found and not _sees_everywhere(fit.state.lens, size_px):
        lacking = ", ".join(lacking_regions(views, size_px)) or "the outermost corners"
        found.append(f"the lens model fails towards the border: show the board at {lacking}")
    return found


def too_large(fit: Fit, views: Sequence[BoardView], size_px: tuple[int, int]) -> list[str]:
    """Complain about the reprojection error, the worst views named.

    Args:
        fit: of lens or floor.
        views: in the order of the fit.
        size_px: width and height of the image [px].

    Returns:
        A sentence, or none.
    """
    limit = MOST_RMS * size_px[0]
    if fit.rms <= limit:
        return []
    each = [float(np.sqrt((r**2).sum(axis=1).mean())) for r in fit.residuals]
    worst = sorted(zip(each, (v.name for v in views), strict=True), reverse=True)[:3]
    named = ", ".join(f"{name} {error:.2f} px" for error, name in worst)
    return [
        f"reprojection error {fit.rms:.2f} px ({limit:.2f} px allowed), worst: {named}: is the "
        "board flat and the picture still?"
    ]


def largest_tilt(problem: Problem, state: State) -> float:
    """The largest angle between the faces of two boards.

    Args:
        problem: what was fitted.
        state: its poses.

    Returns:
        The angle [rad].
    """
    poses = [*state.held, *([state.floor] if problem.anchor is not None else [])]
    normals = np.array([cv2.Rodrigues(pose[:3])[0][:, 2] for pose in poses])
    return float(np.arccos(np.clip((normals @ normals.T).min(), -1.0, 1.0)))


def floor_doubts(
    size_px: tuple[int, int], lens: Floats, floor: FittedFloor, tag_height: float
) -> list[str]:
    """Say why a floor is not to be trusted.

    Args:
        size_px: width and height of the image [px].
        lens: shape (9,).
        floor: fitted.
        tag_height: of the tags [m].

    Returns:
        Sentences; none if it is good.
    """
    camera = camera_of(size_px, lens, floor.pose, tag_height)
    above = float(camera.position[2])
    if above <= tag_height:
        return [f"the camera would be {above:.3f} m above the floor, the tags at {tag_height:g} m"]
    grid, spread = floor_spread(size_px, lens, floor.pose, floor.covariance, tag_height)
    places = camera.to_floor(grid, tag_height)
    seen = np.isfinite(spread)
    points = np.column_stack((places[seen], np.full(int(seen.sum()), tag_height)))
    scale = np.sqrt(np.abs(np.linalg.det(camera.affine_at(points))))
    off_px = float(np.sqrt(np.mean((spread[seen] * scale) ** 2)))
    if off_px <= MOST_FLOOR_PX:
        return []
    off_mm = 1e3 * float(np.sqrt(np.mean(spread[seen] ** 2)))
    return [
        f"the floor is known to {off_mm:.1f} mm rms only, {off_px:.1f} px ({MOST_FLOOR_PX:g} px "
        "allowed): lay the board at more places (--floor again), or give more points, far apart"
    ]


def _sees_everywhere(lens: Floats, size_px: tuple[int, int]) -> bool:
    """Whether the lens model can be inverted all along the image's border."""
    ahead = camera_of(size_px, lens, np.array((np.pi, 0.0, 0.0, 0.0, 0.0, 1.0)), 0.0)
    w, h = size_px[0] - 0.5, size_px[1] - 0.5
    border = [(x, y) for x in np.linspace(-0.5, w, 9) for y in (-0.5, h)]
    border += [(x, y) for y in np.linspace(-0.5, h, 9) for x in (-0.5, w)]
    floor = ahead.to_floor(np.array(border), 0.0)
    again = ahead.project(np.column_stack((floor, np.zeros(len(floor)))))
    return bool((np.abs(again - border) < 1e-3).all() and _grows(lens, size_px))


def _grows(lens: Floats, size_px: tuple[int, int]) -> bool:
    """Whether the picture's radius grows with the ray's, out to the image's corners."""
    reach = np.hypot(*(np.array(size_px) / lens[:2])) * 0.55
    r = np.linspace(0.0, reach, 60)
    k1, k2, k3 = lens[4], lens[5], lens[8]
    distorted = r * (1.0 + r**2 * (k1 + r**2 * (k2 + r**2 * k3)))
    inside = distorted < np.hypot(*(np.array(size_px) / lens[:2])) * 0.5
    return bool((np.diff(distorted)[inside[1:]] > 0.0).all())
