"""Laws of the photosites: shot noise, hot pixels, colour mosaic."""

import numpy as np
import pytest

from datasets.sensor import HotPixels, Mosaic, SensorModel, ShotNoise

SIZE = (160, 120)


def flat(*bgr: float) -> np.ndarray:
    """A picture of one colour."""
    return np.broadcast_to(np.array(bgr, np.float32), (120, 160, 3)).copy()


@pytest.mark.parametrize("level", [10.0, 40.0, 160.0])
def test_shot_noise_has_a_variance_in_proportion_to_the_signal(level: float) -> None:
    noise = ShotNoise(4000.0, SIZE, seed=1)
    frames = np.stack([noise(flat(level, level, level), k) for k in range(40)])
    assert frames.mean() == pytest.approx(level, abs=0.01)
    assert frames.var() == pytest.approx(level * 255.0 / 4000.0, rel=0.01)  # N electrons: N


def test_a_full_well_takes_no_more() -> None:
    seen = ShotNoise(4000.0, SIZE, seed=1)(flat(400.0, 255.0, 0.0), 3)
    assert seen.max() <= 255.0
    assert (seen[..., 2] == 0.0).all()  # no light, no photons
    assert seen[..., 0].mean() == pytest.approx(seen[..., 1].mean(), abs=0.1)


def test_shot_and_read_noise_are_independent_and_repeat_by_seed_and_frame() -> None:
    shot = ShotNoise(1000.0, SIZE, seed=5)(flat(100.0, 100.0, 100.0), 7)
    same = ShotNoise(1000.0, SIZE, seed=5)(flat(100.0, 100.0, 100.0), 7)
    np.testing.assert_array_equal(shot, same)
    assert (ShotNoise(1000.0, SIZE, 5)(flat(100.0, 100.0, 100.0), 8) != shot).mean() > 0.9
    both = SensorModel(read_noise=4.0, chroma="444", full_well=1000.0).stages(SIZE, 5)
    image = flat(100.0, 100.0, 100.0)
    for stage in both:
        image = stage(image, 7)
    assert image.astype(float).var() == pytest.approx(25.5 + 16.0 + 1.0 / 12.0, rel=0.02)


def test_hot_pixels_are_few_and_always_the_same() -> None:
    hot = HotPixels(0.01, SIZE, seed=3)
    one, other = hot(flat(40.0, 40.0, 40.0), 0), hot(flat(40.0, 40.0, 40.0), 99)
    np.testing.assert_array_equal(one, other)
    changed = (one != 40.0).any(axis=2)
    assert changed.mean() == pytest.approx(0.01, abs=0.003)
    assert (one[changed] >= 104.0).all()


@pytest.mark.parametrize("bayer", ["RGGB", "BGGR", "GRBG", "GBRG"])
def test_a_mosaic_leaves_plain_colours_as_they_are(bayer: str) -> None:
    mosaic = Mosaic(bayer, SIZE)
    for color in ((90.0, 90.0, 90.0), (200.0, 40.0, 10.0), (10.0, 30.0, 220.0)):
        seen = mosaic(flat(*color), 0)
        np.testing.assert_allclose(seen, flat(*color), atol=0.01)  # 16 bits


def test_a_mosaic_sees_one_colour_a_pixel() -> None:
    image = flat(0.0, 0.0, 0.0)
    image[60, 80] = (0.0, 0.0, 200.0)  # row and column even: a red filter in RGGB
    assert Mosaic("RGGB", SIZE)(image.copy(), 0)[60, 80, 2] == pytest.approx(200.0, abs=0.01)
    assert Mosaic("BGGR", SIZE)(image.copy(), 0).max() == 0.0  # a blue filter: nothing
    colourless = np.random.default_rng(0).uniform(0.0, 255.0, (120, 160, 1))
    edges = Mosaic("RGGB", SIZE)(np.repeat(colourless, 3, axis=2).astype(np.float32), 0)
    assert np.ptp(edges, axis=2).max() > 50.0  # fine grey detail turns coloured, as it does


def test_mosaic_noise_is_correlated_as_demosaicing_makes_it() -> None:
    image = flat(100.0, 100.0, 100.0)
    for stage in SensorModel(read_noise=4.0, bayer="RGGB", chroma="444").stages(SIZE, 1):
        image = stage(image, 0)
    off = image.astype(float) - 100.0
    assert off.std() < 3.5  # mean of 2 or 4 neighbours where a colour is missing
    assert (off[:, 1:, 0] * off[:, :-1, 0]).mean() > 0.2 * off[..., 0].var()
