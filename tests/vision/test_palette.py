"""The palette: right under every light, nothing where there is nothing."""

import numpy as np
import pytest

from tests.vision.worlds import BLACK, REARS, YELLOW
from vision.errors import VisionError
from vision.palette import (
    BGR_FROM_YCC,
    LEVELS,
    YCC_FROM_BGR,
    ColorSamples,
    NamedColor,
    Palette,
    learn_palette,
    palette_from_colors,
)

ALL = (YELLOW, *REARS, BLACK)


@pytest.fixture(scope="module")
def palette() -> Palette:
    return palette_from_colors(ALL)


def noisy(color: NamedColor, gain: float, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    pixels = gain * np.array(color.bgr) + rng.normal(0.0, 3.0, (40, 50, 3))
    return np.clip(np.rint(pixels), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("color", [YELLOW, *REARS], ids=lambda color: color.name)
@pytest.mark.parametrize("gain", [0.55, 0.7, 1.0])
def test_colours_are_known_under_every_light(
    palette: Palette, color: NamedColor, gain: float
) -> None:
    classes = palette.classify(noisy(color, gain, 3))
    assert (classes == palette.class_of(color.name)).mean() > 0.99


@pytest.mark.parametrize("level", [0, 15, 45, 90, 140, 200, 255])
def test_greys_are_nothing(palette: Palette, level: int) -> None:
    classes = palette.classify(noisy(NamedColor("grey", (level,) * 3), 1.0, 4))
    assert (classes == 0).mean() > 0.99


def test_colours_far_from_all_samples_are_nothing() -> None:
    palette = palette_from_colors((YELLOW, REARS[0], BLACK))
    for bgr in ((220, 40, 30), (200, 40, 210), (60, 160, 20), (255, 255, 255)):
        assert (palette.classify(noisy(NamedColor("far", bgr), 1.0, 5)) == 0).all()


def test_background_is_not_searched_for(palette: Palette) -> None:
    assert "black" not in palette.names
    assert palette.class_of("black") == palette.class_of("nowhere") == 0


def test_probabilities_sum_to_one_and_agree_with_the_table(palette: Palette) -> None:
    np.testing.assert_allclose(palette.posterior.sum(axis=1), 1.0, rtol=1e-5)
    np.testing.assert_array_equal(palette.posterior.argmax(axis=1), palette.table)
    assert palette.table.shape == (LEVELS**3,)
    bgr = np.array([[YELLOW.bgr, (1e9, -1e9, np.nan)]], dtype=float)
    assert palette.probabilities(bgr)[0, 0, palette.class_of("yellow")] > 0.9


def test_the_table_is_opencvs_packing(palette: Palette) -> None:
    image = np.random.default_rng(0).integers(0, 256, (60, 70, 3)).astype(np.uint8)
    probable = palette.probabilities(image.astype(float)).argmax(axis=-1)
    np.testing.assert_array_equal(palette.classify(image), probable)


def test_learning_from_samples_separates_what_the_samples_separate() -> None:
    rng = np.random.default_rng(2)
    dull = rng.normal((90, 105, 100), 4.0, (400, 3)).astype(np.uint8)
    warm = rng.normal((60, 100, 150), 4.0, (400, 3)).astype(np.uint8)
    floor = rng.normal((95, 110, 125), 4.0, (400, 3)).astype(np.uint8)
    samples = (
        ColorSamples("dull", dull), ColorSamples("warm", warm), ColorSamples("floor", floor),
    )  # fmt: skip
    palette = learn_palette(samples)
    assert palette.names == ("dull", "warm")
    assert (palette.classify(warm[None]) == 2).mean() > 0.98
    assert (palette.classify(dull[None]) == 1).mean() > 0.9
    assert (palette.classify(floor[None]) == 0).mean() > 0.9


def test_luma_and_chroma_are_inverse_to_bgr() -> None:
    np.testing.assert_allclose(YCC_FROM_BGR @ BGR_FROM_YCC, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(YCC_FROM_BGR @ np.ones(3), [1.0, 0.0, 0.0], atol=1e-6)


def test_unusable_samples_are_refused() -> None:
    with pytest.raises(VisionError, match="colour red"):
        learn_palette((ColorSamples("red", np.zeros((0, 3), np.uint8)),))
    with pytest.raises(VisionError, match="1 to 255 colours, got 0"):
        learn_palette((ColorSamples("black", np.zeros((5, 3), np.uint8)),))
    with pytest.raises(VisionError, match=r"light range 0\.9 to 0\.5"):
        palette_from_colors((YELLOW,), light=(0.9, 0.5))
