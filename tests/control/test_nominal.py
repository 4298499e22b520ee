"""The sliding phase (23): closed form against a matrix exponential, extremes, Lambda."""

from math import inf, nan, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from control.channel import ChannelGains
from control.errors import ControlError
from control.nominal import greatest, half_width, nominal_error

GAINS = st.builds(
    lambda k, share: ChannelGains(k, share * 0.25 * k * k),  # share 1: a double pole
    st.floats(0.2, 10.0), st.just(1.0) | st.floats(0.05, 30.0),
)  # fmt: skip
ERROR, RATE = st.floats(-1.0, 1.0), st.floats(-2.0, 2.0)
BOUND = st.floats(0.05, 2.0)


@given(GAINS, ERROR, RATE, st.floats(0.0, 5.0))
def test_closed_form_is_the_matrix_exponential(
    gains: ChannelGains, error: float, rate: float, t: float
) -> None:
    matrix = np.array([[0.0, 1.0], [-gains.integral, -gains.proportional]])
    exact = expm(t * matrix) @ (error, rate)
    size = 1.0 + gains.proportional + gains.integral
    assert nominal_error(gains, error, rate, t) == pytest.approx(exact, abs=1e-7 * size)


@given(GAINS, ERROR, RATE)
def test_extremes_are_those_of_a_dense_path(gains: ChannelGains, error: float, rate: float) -> None:
    slowest = gains.proportional / gains.integral + 2.0 / gains.proportional
    times = np.linspace(0.0, 2.0 * slowest + pi / gains.integral**0.5, 20001)
    path = [float(np.abs(values).max()) for values in nominal_error(gains, error, rate, times)]
    top = greatest(gains, error, rate)
    size = abs(error) + abs(rate)
    for dense, found in zip(path, top, strict=True):
        assert dense <= found * (1.0 + 1e-9) + 1e-12
        assert found <= dense + 1e-3 * (1.0 + gains.integral) * size


@given(GAINS, ERROR, RATE, st.floats(0.0, 3.0))
def test_lambda_is_invariant(gains: ChannelGains, error: float, rate: float, t: float) -> None:
    later = (float(x) for x in nominal_error(gains, error, rate, t))
    assert greatest(gains, *later)[0] <= greatest(gains, error, rate)[0] * (1.0 + 1e-9) + 1e-12


@given(GAINS, BOUND, RATE, st.floats(-1.0, 1.0))
def test_inside_lambda_stays_and_outside_leaves(
    gains: ChannelGains, bound: float, rate: float, share: float
) -> None:
    width = half_width(gains, bound, rate)
    if width == 0.0:
        assert greatest(gains, 0.0, rate)[0] >= bound * (1.0 - 1e-9)
        return
    assert greatest(gains, share * width, rate)[0] <= bound * (1.0 + 1e-9)
    assert max(greatest(gains, sign * 1.001 * width, rate)[0] for sign in (1.0, -1.0)) > bound


@given(GAINS, BOUND)
def test_from_rest_lambda_is_all_of_omega(gains: ChannelGains, bound: float) -> None:
    assert half_width(gains, bound) == bound


@pytest.mark.parametrize(
    ("error", "bound", "message"),
    [(nan, 1.0, "not finite"), (0.1, 0.0, "bound"), (0.1, inf, "bound")],
)
def test_what_is_no_number_is_refused(error: float, bound: float, message: str) -> None:
    with pytest.raises(ControlError, match=message):
        half_width(ChannelGains(2.0, 1.0), bound, error)
