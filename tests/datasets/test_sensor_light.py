"""Laws of light before the codec: exposure, flicker, white balance, vignetting, gamma."""

import numpy as np
import pytest

from datasets.errors import SimulationError
from datasets.sensor import Change, Flicker, SensorModel, frame_number, linear_light
from vision.camera import overhead_camera

SIZE = (160, 120)
PLAIN = {"read_noise": 0.0, "blur_px": 0.0, "chroma": "444"}


def flat(level: float) -> np.ndarray:
    """A picture of one grey level."""
    return np.full((120, 160, 3), level, np.float32)


def through(sensor: SensorModel, image: np.ndarray, t: float = 0.0) -> np.ndarray:
    """What comes out of the stages."""
    for stage in sensor.stages(SIZE, 0):
        image = stage(image, frame_number(t))
    return image


@pytest.mark.parametrize("gamma", [1.0, 2.2])
def test_an_exposure_step_is_a_factor_in_linear_light(gamma: float) -> None:
    sensor = SensorModel(**PLAIN, gamma=gamma, exposure_changes=(Change(1.0, (0.4, 0.4, 0.4)),))
    before, after = (through(sensor, flat(180.0), t).astype(float) for t in (0.999, 1.0))
    light = linear_light(np.array([before.mean(), after.mean()]), gamma)
    assert light[1] / light[0] == pytest.approx(0.4, abs=0.01)  # 8 bits


def test_a_drift_is_linear_in_time_and_then_stays() -> None:
    sensor = SensorModel(**PLAIN, exposure_changes=(Change(1.0, (0.5, 0.5, 0.5), 2.0),))
    levels = [through(sensor, flat(200.0), t).mean() for t in (0.5, 1.0, 1.5, 2.0, 3.0, 9.0)]
    assert levels == pytest.approx([200.0, 200.0, 175.0, 150.0, 100.0, 100.0], abs=0.51)


def test_a_later_change_starts_from_the_earlier_one() -> None:
    changes = (Change(1.0, (0.5, 0.5, 0.5)), Change(2.0, (1.0, 1.0, 1.0), 1.0))
    sensor = SensorModel(**PLAIN, exposure_changes=changes)
    assert through(sensor, flat(200.0), 2.5).mean() == pytest.approx(150.0, abs=0.51)


def test_white_balance_scales_channels_and_colours_what_was_full() -> None:
    sensor = SensorModel(**PLAIN, white_balance_changes=(Change(1.0, (0.5, 1.0, 1.2)),))
    np.testing.assert_array_equal(through(sensor, flat(100.0), 2.0)[0, 0], (50, 100, 120))
    np.testing.assert_array_equal(through(sensor, flat(400.0), 2.0)[0, 0], (128, 255, 255))
    np.testing.assert_array_equal(through(sensor, flat(100.0), 0.5)[0, 0], (100, 100, 100))


def test_too_much_light_is_clipped() -> None:
    sensor = SensorModel(**PLAIN, exposure_changes=(Change(0.0, (3.0, 3.0, 3.0)),))
    assert (through(sensor, flat(100.0)) == 255).all()


def test_flicker_keeps_its_mean_and_fades_with_long_exposures() -> None:
    lamp, t = Flicker(0.4, 100.0), np.arange(1000) * 1e-5  # one period
    for exposure, left in ((0.0, 0.4), (0.005, 0.4 * 2.0 / np.pi), (0.010, 0.0)):
        light = lamp.mean(t, exposure)
        assert light.mean() == pytest.approx(1.0, abs=1e-9)
        assert light.max() - 1.0 == pytest.approx(left, abs=1e-6)
        fine = [np.mean(1.0 + 0.4 * np.cos(200 * np.pi * np.linspace(-0.5, 0.5, 2001) * exposure))]
        assert lamp.mean(np.zeros(1), exposure)[0] == pytest.approx(fine[0], abs=1e-3)


def test_flicker_under_a_rolling_shutter_is_bands() -> None:
    sensor = SensorModel(**PLAIN, flicker=Flicker(0.4, 100.0), readout_time=0.020)
    rows = through(sensor, flat(120.0)).mean(axis=(1, 2))
    row_times = (np.arange(120) / 119 - 0.5) * 0.020
    expected = 120.0 * (1.0 + 0.4 * np.cos(200.0 * np.pi * row_times))
    np.testing.assert_allclose(rows, expected, atol=0.51)  # 8 bits
    still = SensorModel(**PLAIN, flicker=Flicker(0.4, 100.0))
    assert np.ptp(through(still, flat(120.0), 0.0033)) == 0


def test_vignetting_is_symmetric_falls_outwards_and_follows_the_angle() -> None:
    camera = overhead_camera(SIZE, 2.4, (0.3, -0.2), 2.0, 0.075)
    (stage,) = SensorModel(vignetting_power=4.0).lens(camera)
    seen = stage(flat(200.0), 0)[..., 0] / 200.0
    np.testing.assert_allclose(seen, seen[::-1, ::-1], atol=1e-6)
    np.testing.assert_allclose(seen, seen[:, ::-1], atol=1e-6)
    assert (np.diff(seen[60, 80:]) < 0.0).all()
    assert (np.diff(seen[60:, 80]) < 0.0).all()
    # the ray of pixel (x, y) leaves the axis by atan(r / f), f = 160 px * 2.0 m / 2.4 m
    angle = np.arctan(np.hypot(79.5, 59.5) / (160 * 2.0 / 2.4))
    assert seen[0, 0] == pytest.approx(np.cos(angle) ** 4, abs=1e-5)
    assert SensorModel().lens(camera) == ()


@pytest.mark.parametrize("gamma", [0.45, 1.8, 2.2])
def test_gamma_encodes_and_linear_light_undoes_it(gamma: float) -> None:
    levels = np.arange(0.0, 256.0, 5.0)
    light = np.broadcast_to(linear_light(levels, gamma).astype(np.float32), (3, len(levels))).T
    image = light[None].copy()
    for stage in SensorModel(**PLAIN, gamma=gamma).stages((len(levels), 1), 0):
        image = stage(image, 0)
    np.testing.assert_allclose(image[0, :, 0], levels, atol=1.0)
    np.testing.assert_array_equal(linear_light(levels, 1.0), levels)


@pytest.mark.parametrize(
    "wrong",
    [
        {"exposure_time": -0.01},
        {"readout_time": float("nan")},
        {"gamma": 0.0},
        {"full_well": 0.0},
        {"bayer": "RGBG"},
        {"vignetting_power": -1.0},
        {"hot_pixels": 1.5},
        {"exposure_changes": (Change(1.0, (-1.0, 1.0, 1.0)),)},
        {"white_balance_changes": (Change(float("inf"), (1.0, 1.0, 1.0)),)},
    ],
    ids=str,
)
def test_parameters_out_of_range_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(SimulationError, match="out of range"):
        SensorModel(**wrong)  # type: ignore[arg-type]
