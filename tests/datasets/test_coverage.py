"""Exact area coverage against analytic areas and brute-force supersampling."""

import numpy as np
import pytest
from numpy.typing import NDArray

from datasets.coverage import edge_coverage, polygon_coverage

Floats = NDArray[np.float64]

FINE = 40  # supersampling: points along a pixel's side


def area(polygon: Floats) -> float:
    """Area by the shoelace formula."""
    x, y = polygon.T
    return abs(float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))) / 2.0


def star(rng: np.random.Generator, center: Floats, largest: float) -> Floats:
    """A simple polygon of 3 to 8 corners, not convex."""
    count = int(rng.integers(3, 9))
    angles = (np.arange(count) + rng.uniform(0.0, 0.4, count)) * 2.0 * np.pi / count
    radii = rng.uniform(0.15, 1.0, count) * largest
    return center + radii[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))


def sampled(polygon: Floats, shape: tuple[int, int]) -> Floats:
    """Coverage by counting points, even-odd rule."""
    y, x = ((np.indices((shape[0] * FINE, shape[1] * FINE)) + 0.5) / FINE).reshape(2, -1)
    inside = np.zeros(x.shape, bool)
    for (x0, y0), (x1, y1) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if y0 != y1:
            crosses = ((y0 <= y) != (y1 <= y)) & (x < x0 + (y - y0) / (y1 - y0) * (x1 - x0))
            inside ^= crosses
    return inside.reshape(shape[0], FINE, shape[1], FINE).mean(axis=(1, 3))


def test_aligned_square_has_analytic_coverage() -> None:
    square = np.array([[1.25, 0.5], [3.5, 0.5], [3.5, 2.0], [1.25, 2.0]])
    expected = np.outer([0.5, 1.0, 0.0], [0.0, 0.75, 1.0, 0.5])
    np.testing.assert_allclose(polygon_coverage(square, (3, 4)), expected, atol=1e-15)


def test_triangle_has_analytic_coverage() -> None:
    triangle = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]])
    np.testing.assert_allclose(
        polygon_coverage(triangle, (3, 3)), [[1, 0.5, 0], [0.5, 0, 0], [0, 0, 0]], atol=1e-15
    )


def test_sum_is_area_and_values_are_shares() -> None:
    rng = np.random.default_rng(1)
    for _ in range(300):
        polygon = star(rng, rng.uniform(8.0, 12.0, 2), 7.9)
        covered = polygon_coverage(polygon, (20, 21))
        assert covered.sum() == pytest.approx(area(polygon), abs=1e-9)
        assert covered.min() >= -1e-12
        assert covered.max() <= 1.0 + 1e-12


def test_agrees_with_supersampling_also_across_the_border() -> None:
    rng = np.random.default_rng(2)
    for _ in range(20):
        polygon = star(rng, rng.uniform(-1.0, 10.0, 2), 6.0)
        covered = polygon_coverage(polygon, (9, 8))
        # every edge through a pixel misjudges at most about one row of points
        assert np.abs(covered - sampled(polygon, (9, 8))).max() < 4.0 / FINE
        assert covered.mean() == pytest.approx(sampled(polygon, (9, 8)).mean(), abs=2e-3)


def test_corners_on_pixel_corners() -> None:
    rng = np.random.default_rng(3)
    for _ in range(50):
        polygon = np.round(star(rng, np.array([10.0, 10.0]), 9.0))
        x, y = polygon.T
        if len(np.unique(polygon, axis=0)) == len(polygon) == 3:
            assert polygon_coverage(polygon, (20, 20)).sum() == pytest.approx(
                area(np.column_stack((x, y))), abs=1e-9
            )


def test_orientation_does_not_matter() -> None:
    polygon = star(np.random.default_rng(4), np.array([5.0, 5.0]), 4.0)
    np.testing.assert_allclose(
        polygon_coverage(polygon, (10, 10)), polygon_coverage(polygon[::-1], (10, 10)), atol=1e-14
    )


def test_layers_are_independent() -> None:
    rng = np.random.default_rng(5)
    polygons = [star(rng, rng.uniform(2.0, 8.0, 2), 5.0) for _ in range(6)]
    starts = np.vstack(polygons)
    ends = np.vstack([np.roll(polygon, -1, axis=0) for polygon in polygons])
    layers = np.repeat(np.arange(6), [len(polygon) for polygon in polygons])
    together = edge_coverage(starts, ends, layers, (6, 10, 9))
    for polygon, covered in zip(polygons, together, strict=True):
        np.testing.assert_allclose(covered, polygon_coverage(polygon, (10, 9)), atol=1e-14)


def test_quarters_tile_the_plane() -> None:
    """Polygons that share edges cover every pixel once: no seam, no overlap."""
    center, corners = (
        np.array([3.3, 4.7]),
        np.array([[0.0, 0.0], [8.0, 0.0], [8.0, 9.0], [0.0, 9.0]]),
    )
    parts = [np.array([corners[i], corners[(i + 1) % 4], center]) for i in range(4)]
    total = sum(polygon_coverage(part, (9, 8)) for part in parts)
    np.testing.assert_allclose(total, 1.0, atol=1e-13)
