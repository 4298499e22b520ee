"""Separation of turned squares: laws, and brute force along their outlines."""

from math import pi, sqrt

import numpy as np
import pytest

from datasets.bodies import pair_gaps, square_gaps

SIDES = np.array([0.075, 0.075])


def outline(pose: np.ndarray, side: float, count: int = 150) -> np.ndarray:
    """Points along a square's border, corners included."""
    along = np.linspace(-0.5, 0.5, count) * side
    half = np.full(count, 0.5 * side)
    local = np.vstack(
        [np.column_stack(c) for c in ((along, half), (along, -half), (half, along), (-half, along))]
    )
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return local @ np.array([[c, s], [-s, c]]) + pose[:2]


def test_aligned_squares() -> None:
    first, second = np.array([0.0, 0.0, 0.0]), np.array([0.1, 0.0, pi / 2])
    assert square_gaps(first, second, SIDES) == pytest.approx(0.025, abs=1e-12)
    assert square_gaps(first, np.array([0.065, 0.0, 0.0]), SIDES) == pytest.approx(-0.01, abs=1e-12)


def test_corner_to_corner_is_not_an_axis_distance() -> None:
    second = np.array([0.1, 0.1, 0.0])
    assert square_gaps(np.zeros(3), second, SIDES) == pytest.approx(0.025 * sqrt(2.0), abs=1e-12)


def test_agrees_with_outlines() -> None:
    rng = np.random.default_rng(1)
    apart = 0
    for _ in range(60):
        first = np.array([0.0, 0.0, rng.uniform(-pi, pi)])
        second = np.array([*rng.uniform(-0.15, 0.15, 2), rng.uniform(-pi, pi)])
        sides = rng.uniform(0.05, 0.1, 2)
        gap = float(square_gaps(first, second, sides))
        if gap > 0.0:
            apart += 1
            a, b = outline(first, sides[0]), outline(second, sides[1])
            nearest = np.hypot(*(a[:, None] - b[None]).transpose(2, 0, 1)).min()
            assert gap == pytest.approx(nearest, abs=3e-4)  # outlines are sampled every 0.5 mm
    assert apart > 20


def test_moving_apart_by_the_depth_ends_an_overlap() -> None:
    """Minus the gap is the shortest way out: that far in the best direction, no less in any."""
    rng = np.random.default_rng(2)
    directions = np.linspace(0.0, 2.0 * pi, 720)
    for _ in range(20):
        first = np.array([0.0, 0.0, rng.uniform(-pi, pi)])
        second = np.array([*rng.uniform(-0.03, 0.03, 2), rng.uniform(-pi, pi)])
        depth = -float(square_gaps(first, second, SIDES))
        assert depth > 0.0
        moved = np.tile(second, (720, 1))
        moved[:, :2] += 1.0005 * depth * np.column_stack((np.cos(directions), np.sin(directions)))
        gaps = square_gaps(np.tile(first, (720, 1)), moved, SIDES)
        assert gaps.max() == pytest.approx(0.0, abs=1e-4)


def test_symmetric_and_independent_of_the_frame() -> None:
    rng = np.random.default_rng(3)
    first = np.column_stack((rng.uniform(-0.1, 0.1, (50, 2)), rng.uniform(-pi, pi, 50)))
    second = np.column_stack((rng.uniform(-0.1, 0.1, (50, 2)), rng.uniform(-pi, pi, 50)))
    gaps = square_gaps(first, second, SIDES)
    np.testing.assert_allclose(square_gaps(second, first, SIDES), gaps, atol=1e-12)
    c, s, turn = np.cos(1.1), np.sin(1.1), np.array([[0.0, 0.0, 1.1]])
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    moved = square_gaps(first @ rotation.T + turn, second @ rotation.T + turn, SIDES)
    np.testing.assert_allclose(moved, gaps, atol=1e-12)


def test_pairs_of_many_robots_over_time() -> None:
    poses = np.zeros((5, 3, 3))
    poses[:, 1, 0], poses[:, 2, 0] = np.linspace(0.2, 0.1, 5), 0.5
    gaps = pair_gaps(poses, np.full(3, 0.075))
    assert gaps.shape == (5, 3)
    np.testing.assert_allclose(gaps[:, 0], np.linspace(0.125, 0.025, 5), atol=1e-12)
    np.testing.assert_allclose(gaps[:, 1], 0.425, atol=1e-12)
