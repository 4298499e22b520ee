"""What the sensor does to pixels: statistics and geometry of every effect."""

import cv2
import numpy as np
import pytest

from datasets.errors import SimulationError
from datasets.sensor import ChromaLoss, JpegLoss, ReadNoise, SensorModel

SIZE = (160, 120)
GREY = np.full((120, 160, 3), 120.0, np.float32)


def blob(x: float, y: float, channel: int) -> np.ndarray:
    """A soft spot on dark grey in one channel, uint8."""
    rows, columns = np.indices((120, 160))
    image = np.full((120, 160, 3), 60.0)
    image[..., channel] += 150.0 * np.exp(-((columns - x) ** 2 + (rows - y) ** 2) / (2 * 5.0**2))
    return np.rint(image).astype(np.uint8)


def center_of_red(image: np.ndarray) -> tuple[float, float]:
    """Centre of the red chroma [px]."""
    red = cv2.cvtColor(image, cv2.COLOR_BGR2YCrCb)[..., 1].astype(float)
    weight = np.where(np.abs(red - 128) > 2, red - 128, 0.0)
    rows, columns = np.indices(weight.shape)
    return float((weight * columns).sum() / weight.sum()), float(
        (weight * rows).sum() / weight.sum()
    )


def test_noise_has_the_declared_statistics() -> None:
    noise = ReadNoise(3.0, SIZE, seed=1)
    frames = np.stack([noise(GREY, k) for k in range(200)]).astype(float) - 120.0
    assert frames.mean() == pytest.approx(0.0, abs=0.01)
    # rounding adds 1/12 to the variance
    assert frames.std() == pytest.approx(np.sqrt(9.0 + 1.0 / 12.0), rel=2e-3)
    kurtosis = np.mean(frames**4) / np.mean(frames**2) ** 2
    assert kurtosis == pytest.approx(3.0, abs=0.02)  # Gaussian
    per_frame = frames.std(axis=(1, 2, 3))
    assert per_frame.min() > 2.9
    assert per_frame.max() < 3.15


def test_noise_is_independent_between_pixels_channels_and_frames() -> None:
    noise = ReadNoise(3.0, SIZE, seed=2)
    frames = np.stack([noise(GREY, k) for k in range(60)]).astype(float) - 120.0
    variance = frames.var()

    def correlation(a: np.ndarray, b: np.ndarray) -> float:
        return float(np.mean(a * b) / variance)

    limit = 6.0 / np.sqrt(frames.size)  # six standard deviations of a chance correlation
    assert abs(correlation(frames[:-1], frames[1:])) < limit
    assert abs(correlation(frames[..., :-1], frames[..., 1:])) < limit
    assert abs(correlation(frames[:, :, :-1], frames[:, :, 1:])) < limit
    assert abs(correlation(frames[:, :-1], frames[:, 1:])) < limit


def test_noise_repeats_by_seed_and_frame() -> None:
    one, same, other = (ReadNoise(3.0, SIZE, seed) for seed in (5, 5, 6))
    np.testing.assert_array_equal(one(GREY, 17), same(GREY, 17))
    assert (one(GREY, 17) != one(GREY, 18)).mean() > 0.8
    assert (one(GREY, 17) != other(GREY, 17)).mean() > 0.8


def test_digitising_rounds_and_clips() -> None:
    image = np.array([[[-3.0, 0.4, 0.6], [254.6, 255.4, 300.0]]], np.float32)
    expected = [[[0, 0, 1], [255, 255, 255]]]
    np.testing.assert_array_equal(ReadNoise(0.0, (2, 1), 0)(image, 0), expected)
    noisy = ReadNoise(2.0, (160, 120), 0)(np.zeros((120, 160, 3), np.float32), 0)
    assert (noisy == 0).mean() == pytest.approx(0.6, abs=0.02)  # P(2 n < 0.5): no wrap-around


@pytest.mark.parametrize("share", [0.0, 0.3, 0.8])
def test_light_falls_by_the_declared_share(share: float) -> None:
    light = SensorModel(uneven_light=share).light((320, 240), margin=5)
    assert light.shape == (250, 330)
    inner = light[5:-5, 5:-5]
    assert inner.max() == pytest.approx(1.0, abs=1e-6)
    assert inner.min() == pytest.approx(1.0 - share, abs=1e-6)


def test_blur_has_the_declared_width_and_keeps_the_light() -> None:
    point = np.zeros((41, 41, 1), np.float32)
    point[20, 20] = 100.0
    spread = SensorModel(blur_px=1.5).blur(point).reshape(41, 41)
    offsets = np.arange(41) - 20
    assert spread.sum() == pytest.approx(100.0, rel=1e-5)
    assert (spread.sum(axis=0) * offsets**2).sum() / 100.0 == pytest.approx(1.5**2, rel=0.01)


@pytest.mark.parametrize("chroma", ["422", "420"])
@pytest.mark.parametrize("upsampling", ["linear", "nearest"])
def test_centred_subsampling_displaces_nothing(chroma: str, upsampling: str) -> None:
    loss = ChromaLoss(chroma, (0.0, 0.0), upsampling)
    for x, y in ((70.0, 50.0), (71.3, 50.6)):
        before = blob(x, y, 2)
        after = loss(before.copy(), 0)
        assert center_of_red(after) == pytest.approx(center_of_red(before), abs=0.03)
        luma = [cv2.cvtColor(i, cv2.COLOR_BGR2GRAY).astype(int) for i in (before, after)]
        assert np.abs(luma[0] - luma[1]).max() <= 2  # brightness is kept, up to rounding


@pytest.mark.parametrize("offset", [(0.5, 0.0), (0.0, -0.5), (-1.0, 0.5)])
def test_siting_displaces_the_colours_by_the_offset(offset: tuple[float, float]) -> None:
    before = blob(70.2, 50.7, 2)
    after = ChromaLoss("420", offset, "linear")(before.copy(), 0)
    moved = np.subtract(center_of_red(after), center_of_red(before))
    np.testing.assert_allclose(moved, offset, atol=0.04)


def test_subsampling_mixes_colours_of_neighbours() -> None:
    stripes = np.zeros((120, 160, 3), np.uint8)
    stripes[:, 0::2] = (0, 0, 200)
    stripes[:, 1::2] = (200, 0, 0)
    mixed = SensorModel(chroma="420").stages(SIZE, 0)[1](stripes, 0)
    chroma = cv2.cvtColor(mixed, cv2.COLOR_BGR2YCrCb)[10:-10, 10:-10, 1:]
    assert np.ptp(chroma.reshape(-1, 2).astype(int), axis=0).max() <= 40
    assert len(SensorModel(chroma="444").stages(SIZE, 0)) == 1


def test_odd_sizes_stay_odd() -> None:
    image = np.random.default_rng(0).integers(0, 255, (31, 45, 3), np.uint8)
    assert ChromaLoss("420", (0.0, 0.0), "linear")(image, 0).shape == (31, 45, 3)


def test_jpeg_is_real_and_better_with_quality() -> None:
    image = blob(70.2, 50.7, 1)
    errors = [
        np.abs(JpegLoss(quality, "420")(image, 0).astype(int) - image).mean()
        for quality in (20, 60, 95)
    ]
    assert errors[0] > errors[1] > errors[2] > 0.0
    assert center_of_red(JpegLoss(90, "420")(blob(70.2, 50.7, 2), 0)) == pytest.approx(
        center_of_red(blob(70.2, 50.7, 2)), abs=0.15
    )


def test_stages_turn_light_into_bytes() -> None:
    for sensor in (SensorModel(), SensorModel(jpeg_quality=80), SensorModel(chroma="444")):
        image = GREY.copy()
        for stage in sensor.stages(SIZE, 3):
            image = stage(image, 1)
        assert image.dtype == np.uint8
        assert image.shape == (120, 160, 3)


def test_parameters_out_of_range_are_refused() -> None:
    for wrong in (
        {"read_noise": -1.0},
        {"chroma": "411"},
        {"jpeg_quality": 0},
        {"uneven_light": 1.0},
    ):
        with pytest.raises(SimulationError, match="out of range"):
            SensorModel(**wrong)
