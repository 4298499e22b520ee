"""The fit's errors beside the Cramer-Rao bound, over size, noise, blur and codec."""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from benchmarks.bound import Noise, Slopes, best_estimate, left_over, make_slopes
from benchmarks.field import (
    COLORS,
    MOUNT,
    SIDE,
    TAG_HEIGHT,
    Field,
    make_camera,
    make_field,
    strewn,
    two_patch,
)
from control.geometry import wrap_angle
from datasets.floor import Floor
from datasets.sensor import Chroma, SensorModel
from vision.frame import Frame
from vision.locate import locate

Floats = NDArray[np.float64]

PLATES_PX = (8, 10, 12, 16, 24, 32)
NOISES = (1.0, 3.0, 6.0)
BLURS_PX = (0.4, 0.6, 1.0)
CODECS = ("444", "420", "420 jpeg 85")
ROBOTS, SIZE_PX = 7, (400, 300)
_FREE_PX = 9  # of floor around every tag, as the bound takes it
PLAIN = Floor(texture=0.0, line_width=0.0)


@dataclass(frozen=True, slots=True)
class Case:
    """What the camera is like.

    Attributes:
        plate_px: side of a robot's plate in the picture [px].
        noise: of the sensor, of 255.
        blur_px: of the lens [px].
        codec: one of `CODECS`.
        floor: under the robots.
    """

    plate_px: float
    noise: float
    blur_px: float
    codec: str
    floor: Floor = PLAIN

    @property
    def sensor(self) -> SensorModel:
        """The camera's sensor, under even light."""
        quality = 85 if "jpeg" in self.codec else None
        plain = SensorModel(self.noise, self.blur_px, jpeg_quality=quality, chroma="444")
        return replace(plain, chroma=self.kept)

    @property
    def kept(self) -> Chroma:
        """What the codec keeps of the colours."""
        return "444" if self.codec == "444" else "420"


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


def cases(quick: bool) -> list[Case]:
    """What is measured.

    Args:
        quick: only some sizes and blurs at noise 3.

    Returns:
        The cases, those that share poses one after the other.
    """
    if quick:
        return [Case(p, 3.0, b, c) for p, b, c in product((8, 10, 16, 32), (0.6, 1.0), CODECS)]
    every = product(PLATES_PX, BLURS_PX, NOISES, CODECS)
    return [Case(p, n, b, c) for p, b, n, c in every]


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
    camera, shape = field.eye.camera, (layouts, repeats, ROBOTS)
    room = field.eye.tags.outer_radius + _FREE_PX * SIDE / case.plate_px
    sets = [strewn(camera, room, ROBOTS, rng) for _ in range(layouts)]
    slopes = [[_slopes(field, case, n, pose) for n, pose in enumerate(poses)] for poses in sets]
    every = [(k, k * repeats + again) for k in range(layouts) for again in range(repeats)]
    frames = [field.picture(sets[k], number) for k, number in every]
    fits = [_fitted(field, sets[k], frames[number], rng) for k, number in every]
    errors = np.array([fit[0] for fit in fits]).reshape(*shape, 3)
    nees = np.array([fit[1] for fit in fits]).reshape(shape)
    seen = [left_over(slopes[k], frames[number].image, case.kept) for k, number in every]
    noise = _noise(case, seen)
    best = [[best_estimate(s, noise) for s in row] for row in slopes]
    pairs = [pair for k, n in every for pair in zip(best[k], seen[n], strict=True)]
    exact = np.array([gain @ found for (_, gain), found in pairs])
    found = ~np.isnan(nees)
    true = np.repeat(np.array(sets)[:, None], repeats, axis=1)[found]
    bounds = np.array([[covariance for covariance, _ in row] for row in best])
    bounds = np.repeat(bounds[:, None], repeats, axis=1)[found]
    places = camera.project(np.column_stack((true[:, :2], np.full(len(true), TAG_HEIGHT))))
    means = errors.mean(axis=1).reshape(-1, 3)
    means = means[~np.isnan(means[:, 0])]
    missed = int(np.count_nonzero(~found))
    return Trials(
        case, missed, true, places, errors[found], bounds, nees[found], means, repeats, exact
    )


def make_case_field(case: Case) -> Field:
    """A field as a case wants it.

    Args:
        case: what the camera is like.

    Returns:
        The field, with 7 robots.
    """
    width = SIZE_PX[0] * SIDE / case.plate_px * MOUNT / (MOUNT - TAG_HEIGHT)
    return make_field(make_camera(SIZE_PX, width), two_patch(ROBOTS), case.sensor, case.floor)


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


_SLOPES: dict[tuple[float, float, int, bytes], Slopes] = {}


def _slopes(field: Field, case: Case, n: int, pose: Floats) -> Slopes:
    """Slopes of robot n's picture, shared by cases that differ in noise and codec only."""
    key = case.plate_px, case.blur_px, n, pose.tobytes()
    if key not in _SLOPES:
        tag, camera = field.eye.tags.tags[n], field.eye.camera
        _SLOPES[key] = make_slopes(tag, pose, camera, field.sensor, COLORS, case.floor.bgr)
    return _SLOPES[key]


def _rms(errors: Floats) -> float:
    """Root mean square length of errors (T, D)."""
    return float(np.sqrt((errors**2).sum(axis=1).mean()))
