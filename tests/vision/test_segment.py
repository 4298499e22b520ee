"""Blobs: as a slow, obvious labelling finds them."""

import cv2
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from vision.segment import find_blobs

IMAGES = arrays.arrays(
    np.uint8,
    st.tuples(st.integers(1, 23), st.integers(1, 29)),
    elements=st.sampled_from([0, 0, 0, 1, 2]),
)


@given(IMAGES)
@settings(max_examples=100)
def test_every_colour_is_labelled_as_opencv_does(classes: np.ndarray) -> None:
    blobs = find_blobs(classes, 1.0, 10_000)
    for label in (1, 2):
        one = (classes == label).astype(np.uint8)
        _, _, stats, centers = cv2.connectedComponentsWithStats(one, connectivity=4)
        own = blobs.classes == label
        np.testing.assert_array_equal(
            np.sort(blobs.areas[own]), np.sort(stats[1:, cv2.CC_STAT_AREA])
        )
        found, wanted = (np.round(c, 9) for c in (blobs.centers[own], centers[1:]))
        np.testing.assert_allclose(found[np.lexsort(found.T)], wanted[np.lexsort(wanted.T)])


def test_separate_blobs_have_exact_areas_and_centres() -> None:
    classes = np.zeros((40, 53), np.uint8)
    classes[3:9, 5:15] = 2
    classes[20:31, 30:33] = 1
    classes[39, 52] = 1
    blobs = find_blobs(classes, 2.0, 10)
    np.testing.assert_array_equal(blobs.classes, [2, 1])
    np.testing.assert_array_equal(blobs.areas, [60, 33])
    np.testing.assert_allclose(blobs.centers, [[9.5, 5.5], [31.0, 25.0]])


def test_touching_colours_stay_apart() -> None:
    classes = np.zeros((20, 30), np.uint8)
    classes[5:15, 5:15], classes[5:15, 15:25] = 1, 2
    blobs = find_blobs(classes, 5.0, 10)
    assert sorted(blobs.classes.tolist()) == [1, 2]
    np.testing.assert_allclose(np.sort(blobs.centers[:, 0]), [9.5, 19.5], atol=0.6)


def test_the_limit_keeps_the_largest_and_counts_the_rest() -> None:
    classes = np.zeros((10, 60), np.uint8)
    for n in range(6):
        classes[2 : 3 + n, 10 * n : 10 * n + 4] = 1
    blobs = find_blobs(classes, 1.0, 2)
    np.testing.assert_array_equal(blobs.areas, [24, 20])
    assert blobs.dropped == 4


def test_nothing_gives_nothing() -> None:
    assert len(find_blobs(np.zeros((7, 9), np.uint8), 1.0, 10)) == 0
