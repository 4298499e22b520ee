"""The fit's errors beside the Cramer-Rao bound, over size, noise, blur and codec."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.bound import Noise, best_estimate, left_over
from benchmarks.cases import ROBOTS, Case, make_case_field
from benchmarks.field import COLORS, SIDE, TAG_HEIGHT, Field, strewn
from benchmarks.slopes import Slopes, Views, make_slopes
from control.geometry import wrap_angle
from vision.frame import Frame
from vision.locate import locate

Floats = NDArray[np.float64]

_FREE_PX = 9  # of floor around every tag, as the bound takes it


@dataclass(frozen=True, slots=True)
class Trials:
    """All that was fitted in one case, T fits.

    Attributes:
        case: what the camera is like.
        missed: robots that were not found.
        poses: shape (T, 3), true [m, m, rad].
        places: shape (T, 2), of the tag's centre in the picture [px].
        errors: shape (T, 3) [m, m, rad].
        bounds: shape (T, 3, 3), Cramer-Rao [m^2, m rad, rad^2].
        nees: shape (T,), squared errors normalised by the fit's own covariance; 3 on average if
            it is honest.
        means: shape (P, 3), mean error of every pose over its noisy pictures [m, m, rad].
        repeats: pictures of every pose.
        exact: shape (T, 3), errors of an estimate with the renderer's own model [m, m, rad].
    """

    case: Case
    missed: int
    poses: Floats
    places: Floats
    errors: Floats
    bounds: Floats
    nees: Floats
    means: Floats
    repeats: int
    exact: Floats


@dataclass(frozen=True, slots=True)
class Spread:
    """One case in figures.

    Attributes:
        plate_px: side of a plate [px].
        noise: of 255.
        blur_px: of the lens [px].
        codec: one of `CODECS`.
        recall: share of the robots found.
        astray: share of the fits that ended more than a pixel off.
        rms_mm: position error in the plane, root mean square [mm].
        rms_deg: heading error [deg].
        bound_mm: what an unbiased method could reach at best [mm].
        bound_deg: the same for the heading [deg].
        ratio: rms to bound, of the position.
        heading_ratio: rms to bound, of the heading.
        bias_mm: systematic part of the position error, which depends on the pose [mm].
        bias_deg: systematic part of the heading error [deg].
        common_mm: mean error over all poses, in the plane [mm].
        nees: mean; 3 if the fit's covariance is honest.
        exact_ratio: rms to bound, of the position, with the renderer's own model: within reach.
        exact_heading_ratio: the same for the heading.
    """

    plate_px: float
    noise: float
    blur_px: float
    codec: str
    recall: float
    astray: float
    rms_mm: float
    rms_deg: float
    bound_mm: float
    bound_deg: float
    ratio: float
    heading_ratio: float
    bias_mm: float
    bias_deg: float
    common_mm: float
    nees: float
    exact_ratio: float
    exact_heading_ratio: float


def run(case: Case, layouts: int = 6, repeats: int = 5) -> Trials:
    """Fit robots in noisy pictures, tracked from predictions some millimetres off.

    Args:
        case: what the camera is like.
        layouts: sets of poses of 7 robots.
        repeats: noisy pictures of every set.

    Returns:
        Errors and bounds.
    """
    field, rng = make_case_field(case), np.random.default_rng(7)
    room = field.eye.tags.outer_radius + _FREE_PX * SIDE / case.plate_px
    sets = np.array([strewn(field.eye.camera, room, ROBOTS, rng) for _ in range(layouts)])
    shots = _shots(field, sets, repeats, rng)
    slopes = [[_slopes(field, case, n, pose) for n, pose in enumerate(poses)] for poses in sets]
    bounds, exact = _best(case, slopes, shots)
    errors = np.array([shot.errors for shot in shots])  # (layouts * repeats, R, 3)
    true, nees = sets.repeat(repeats, axis=0), np.array([shot.nees for shot in shots])
    found = ~np.isnan(nees)
    means = errors.reshape(layouts, repeats, -1, 3).mean(axis=1).reshape(-1, 3)
    return Trials(
        case,
        missed=int(np.count_nonzero(~found)),
        poses=true[found],
        places=_places(field, true[found]),
        errors=errors[found],
        bounds=bounds.repeat(repeats, axis=0)[found],
        nees=nees[found],
        means=means[~np.isnan(means[:, 0])],
        repeats=repeats,
        exact=exact,
    )


def summed(trials: Trials) -> Spread:
    """Put trials into figures.

    Args:
        trials: of one case.

    Returns:
        The figures.
    """
    case, errors = trials.case, trials.errors
    place, turn = _rms(errors[:, :2]), np.degrees(_rms(errors[:, 2:]))
    variances = np.diagonal(trials.bounds, axis1=1, axis2=2).mean(axis=0)
    least, least_turn = np.sqrt(variances[0] + variances[1]), np.degrees(np.sqrt(variances[2]))
    return Spread(
        case.plate_px,
        case.noise,
        case.blur_px,
        case.codec,
        recall=len(errors) / (len(errors) + trials.missed),
        astray=float((np.hypot(*errors[:, :2].T) > SIDE / case.plate_px).mean()),
        rms_mm=1e3 * place,
        rms_deg=float(turn),
        bound_mm=1e3 * float(least),
        bound_deg=float(least_turn),
        ratio=float(place / least),
        heading_ratio=float(turn / least_turn),
        bias_mm=1e3 * _bias(trials, slice(0, 2)),
        bias_deg=float(np.degrees(_bias(trials, slice(2, 3)))),
        common_mm=1e3 * float(np.hypot(*errors[:, :2].mean(axis=0))),
        nees=float(trials.nees.mean()),
        exact_ratio=float(_rms(trials.exact[:, :2]) / least),
        exact_heading_ratio=float(np.degrees(_rms(trials.exact[:, 2:])) / least_turn),
    )


@dataclass(frozen=True, slots=True)
class _Shot:
    """A picture of one set of poses: errors (R, 3) and NEES (R,), NaN for robots not found."""

    layout: int
    frame: Frame
    errors: Floats
    nees: Floats


def _shots(field: Field, sets: Floats, repeats: int, rng: np.random.Generator) -> list[_Shot]:
    """Draw every set of poses several times, with noise of its own, and fit the robots."""
    shots = []
    for number in range(len(sets) * repeats):
        layout = number // repeats
        frame = field.picture(sets[layout], number)
        shots.append(_Shot(layout, frame, *_fitted(field, sets[layout], frame, rng)))
    return shots


def _fitted(
    field: Field, poses: Floats, frame: Frame, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """Errors (R, 3) and their normalised squares (R,) in one picture; NaN for robots not found."""
    ids = field.eye.tags.ids
    errors, nees = np.full((len(ids), 3), np.nan), np.full(len(ids), np.nan)
    expected = field.predictions(poses, rng)
    for d in locate(frame, field.eye, expected).detections:
        n = ids.index(d.robot_id)
        error = np.array((d.pose.x, d.pose.y, d.pose.theta)) - poses[n]
        error[2] = wrap_angle(error[2])
        errors[n], nees[n] = error, error @ np.linalg.solve(d.covariance, error)
    return errors, nees


def _best(case: Case, slopes: list[list[Slopes]], shots: list[_Shot]) -> tuple[Floats, Floats]:
    """Bounds (layouts, R, 3, 3), and the errors (T, 3) of the estimate that reaches them."""
    seen = [left_over(slopes[shot.layout], shot.frame.image, case.kept) for shot in shots]
    noise = _noise(case, seen)
    best = [[best_estimate(s, noise) for s in row] for row in slopes]
    pairs = [
        zip(best[shot.layout], found, strict=True) for shot, found in zip(shots, seen, strict=True)
    ]
    exact = [gain @ found for every in pairs for (_, gain), found in every]
    bounds = [[covariance for covariance, _ in row] for row in best]
    return np.array(bounds), np.array(exact)


def _places(field: Field, poses: Floats) -> Floats:
    """Where the centres of tags at poses (T, 3) appear, (T, 2) [px]."""
    points = np.column_stack((poses[:, :2], np.full(len(poses), TAG_HEIGHT)))
    return field.eye.camera.project(points)


def _bias(trials: Trials, axes: slice) -> float:
    """Root mean square of the errors' systematic part, which the same pose gives every time."""
    n = trials.repeats
    means = (trials.means[:, axes] ** 2).sum(axis=1).mean()  # holds 1 / n of the noise, too
    every = (trials.errors[:, axes] ** 2).sum(axis=1).mean()
    return float(np.sqrt(max((n * means - every) / (n - 1), 0.0)))


def _noise(case: Case, seen: list[list[Floats]]) -> Noise:
    """The sensor's noise; what JPEG adds is measured in the pictures themselves."""
    if "jpeg" not in case.codec:
        return Noise(case.noise, case.kept)
    blocks = np.concatenate([found for picture in seen for found in picture]).reshape(-1, 6)
    return Noise(case.noise, case.kept, blocks.T @ blocks / len(blocks))


_VIEWS: dict[tuple[float, float], Views] = {}
_SLOPES: dict[tuple[float, float, int, bytes], Slopes] = {}


def _slopes(field: Field, case: Case, n: int, pose: Floats) -> Slopes:
    """Slopes of robot n's picture, shared by cases that differ in noise and codec only."""
    lens = case.plate_px, case.blur_px
    key = *lens, n, pose.tobytes()
    if lens not in _VIEWS:  # the tags differ in their colours only
        _VIEWS[lens] = Views(field.eye.tags.tags[0], field.eye.camera, field.sensor)
    if key not in _SLOPES:
        worn = [part.color for part in field.eye.tags.tags[n].parts]
        _SLOPES[key] = make_slopes(_VIEWS[lens], pose, worn, COLORS, case.floor.bgr)
    return _SLOPES[key]


def _rms(errors: Floats) -> float:
    """Root mean square length of errors (T, D)."""
    return float(np.sqrt((errors**2).sum(axis=1).mean()))
