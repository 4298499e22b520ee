"""What model errors do to G u: closed forms against singular values of the factors."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from control.errors import ControlError
from control.model_errors import gain_bounds, norm_bounds
from control.relative import RelativeState, input_matrix, inverse_input_matrix
from control.uncertainty import FollowerBounds, LeaderBounds, Motion, ReferenceBounds
from tests.control.pairs import SLOW, motions, wide


def error_matrix(l: float, phi: float, eps: tuple[float, float], d: float) -> np.ndarray:  # noqa: E741
    """G Delta G^-1 from its factors."""
    relative = RelativeState(l, 0.0, phi)
    g = np.array(input_matrix(relative, d))
    return g @ np.diag(eps) @ np.array(inverse_input_matrix(relative, d))


@settings(max_examples=30)
@given(motions(), st.floats(0.1, 1.0))
def test_delta_bounds_are_never_violated_and_are_reached(motion: Motion, scale: float) -> None:
    gain, norm = gain_bounds(motion), norm_bounds(motion, scale)
    f, to_metres = motion.follower, np.diag([1.0, scale])
    seen: list[tuple[float, ...]] = []
    for l in motion.spacing:  # noqa: E741 (the paper's l)
        for phi in np.linspace(*motion.heading, 25):
            for sign in (1.0, -1.0):
                eps = f.mass_error, sign * f.inertia_error
                m = error_matrix(l, phi, eps, f.camera_offset)
                scaled = to_metres @ m @ np.linalg.inv(to_metres)
                sigma = [np.linalg.svd(np.eye(2) + s * scaled)[1] for s in (1.0, -1.0)]
                seen.append((
                    abs(m[0, 0]), abs(m[1, 1]), abs(m[0, 1]), abs(m[1, 0]),
                    np.linalg.norm(scaled, 2), -min(s[1] for s in sigma), max(s[0] for s in sigma),
                ))  # fmt: skip
    most = np.max(seen, axis=0)
    bounds = np.array([
        gain.high[0] - 1, gain.high[1] - 1, *gain.coupling, norm.gain_error, -norm.low, norm.high,
    ])  # fmt: skip
    assert (most <= bounds + 1e-9).all()
    assert (most >= bounds - 0.02 * np.abs(bounds) - 1e-9).all()
    assert gain.low == pytest.approx([2 - high for high in gain.high])


@given(st.floats(-0.99, 0.99), st.floats(-0.99, 0.99), st.floats(-pi, pi), st.floats(0.5, 2.0))
def test_no_error_inside_the_bounds_does_worse(
    share: float, share2: float, phi: float, ratio: float
) -> None:
    follower = FollowerBounds(0.05, 0.3, 0.2)
    reference = ReferenceBounds((0.1, 0.4), (pi, pi))
    norm = norm_bounds(Motion(LeaderBounds(0, 0), reference, follower), 0.2)
    m = error_matrix(0.2 * ratio, phi, (0.3 * share, 0.2 * share2), 0.05)
    scaled = np.diag([1.0, 0.2]) @ m @ np.diag([1.0, 5.0])
    high, low = np.linalg.svd(np.eye(2) + scaled)[1]
    assert np.linalg.norm(scaled, 2) <= norm.gain_error + 1e-9
    assert norm.low - 1e-9 <= low <= high <= norm.high + 1e-9


def test_a_scale_must_be_positive() -> None:
    with pytest.raises(ControlError, match="scale"):
        norm_bounds(wide(SLOW), 0.0)
