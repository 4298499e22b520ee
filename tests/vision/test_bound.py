"""The fit beside the Cramer-Rao bound: a small version of `python -m benchmarks bound`."""

import numpy as np
import pytest

from benchmarks.bound import Noise, best_estimate, information, left_over
from benchmarks.cases import PLAIN, Case, make_case_field
from benchmarks.field import COLORS, Field
from benchmarks.slopes import Slopes, Views, make_slopes
from benchmarks.spread import Spread, run, summed

POSE = np.array([0.47, 0.38, 0.7])


def spread(plate_px: int, codec: str) -> Spread:
    """Figures of 140 fits at noise 3 and blur 0.6."""
    return summed(run(Case(plate_px, 3.0, 0.6, codec), layouts=4))


def slopes_in(field: Field) -> Slopes:
    """Of the first robot at `POSE`."""
    tag = field.eye.tags.tags[0]
    worn = [part.color for part in tag.parts]
    return make_slopes(Views(tag, field.eye.camera, field.sensor), POSE, worn, COLORS, PLAIN.bgr)


# Plate [px], codec, limits of rms / bound for position and heading: 1.15 times what the fit
# reaches. Wanted: 1.3 without codec, 2.0 with one.
REACHED = [
    (8, "444", 1.17, 1.24),
    (10, "444", 1.17, 1.15),
    (16, "444", 1.15, 1.23),
    (24, "444", 1.19, 1.22),
    (10, "420", 1.20, 1.28),
    (16, "420", 1.29, 1.43),
    (10, "420 jpeg 85", 1.58, 1.79),
    (16, "420 jpeg 85", 1.45, 1.88),
]


@pytest.mark.parametrize(("plate_px", "codec", "position", "heading"), REACHED)
def test_fit_is_near_its_bound(plate_px: int, codec: str, position: float, heading: float) -> None:
    found = spread(plate_px, codec)
    assert found.recall == 1.0
    assert found.ratio < position
    assert found.heading_ratio < heading
    assert 2.2 < found.nees < 3.8  # 3 if the fit's covariance is honest
    # The same sums with the renderer's own model: the bound is right, and within reach.
    reach = 1.2 if codec != "420 jpeg 85" else 1.7
    assert 0.85 < found.exact_ratio < reach
    assert 0.85 < found.exact_heading_ratio < reach


def test_information_of_a_pixel() -> None:
    inside, saturated = information(np.array([128.3, 255.0]), 3.0)
    assert inside == pytest.approx(1.0 / (9.0 + 1.0 / 12.0), rel=1e-3)
    assert 0.5 * inside < saturated < 0.9 * inside  # half of the noise is cut off
    assert information(np.array([400.0]), 3.0)[0] == pytest.approx(0.0, abs=1e-12)


def test_slopes_belong_to_the_rendered_picture() -> None:
    noisefree = make_case_field(Case(10, 0.0, 0.6, "444"))
    poses = np.array([POSE, *np.tile((9.0, 9.0, 0.0), (6, 1))])  # the others are out of sight

    def seen(step: np.ndarray) -> np.ndarray:
        image = noisefree.picture(poses + step * np.eye(7, 1), 0).image
        return left_over([slopes], image, "444")[0]

    slopes = slopes_in(noisefree)
    assert np.abs(seen(np.zeros(3))).max() < 0.51  # rounding to 8 bit, and no more
    for axis, size in enumerate((5e-4, 5e-4, 0.02)):
        step = size * np.eye(3)[axis]
        change = 0.5 * (seen(step) - seen(-step))
        error = change - size * slopes.by_pose[..., axis].reshape(-1)
        assert np.sqrt((error**2).mean()) < 0.05 * np.sqrt((change**2).mean()) + 0.3


def test_laws_of_the_bound() -> None:
    field = make_case_field(Case(12, 3.0, 0.6, "444"))
    slopes = slopes_in(field)

    def deviations(sigma: float, chroma: str, known: bool = False) -> np.ndarray:
        return np.sqrt(np.diag(best_estimate(slopes, Noise(sigma, chroma), known)[0]))

    full = deviations(3.0, "444")
    np.testing.assert_allclose(deviations(6.0, "444") / full, 2.0, rtol=0.05)
    assert (deviations(3.0, "420") > full).all()  # colours were thrown away
    assert (deviations(3.0, "420") < 1.3 * full).all()
    assert (deviations(3.0, "444", known=True) < full).all()
