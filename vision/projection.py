"""The pinhole with OpenCV's five distortion coefficients, point by point, compiled."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled

Floats = NDArray[np.float64]


class Lens(NamedTuple):
    """A camera's numbers, as compiled functions take them; see `CameraModel`.

    Attributes:
        matrix: shape (3, 3), intrinsics [px].
        distortion: shape (5,), k1, k2, p1, p2, k3.
        rotation: shape (3, 3), R_camera_floor.
        translation: shape (3,), t_camera_floor [m].
    """

    matrix: Floats
    distortion: Floats
    rotation: Floats
    translation: Floats


@compiled
def project_point(lens: Lens, x: float, y: float, z: float) -> tuple[float, float]:
    """Map a point of the floor frame to its pixel.

    Args:
        lens: of the camera.
        x: on the floor [m].
        y: on the floor [m].
        z: height [m].

    Returns:
        x, y of the pixel; NaN for a point behind the camera.
    """
    r, t = lens.rotation, lens.translation
    depth = r[2, 0] * x + r[2, 1] * y + r[2, 2] * z + t[2]
    if not depth > 0.0:
        return np.nan, np.nan
    u = (r[0, 0] * x + r[0, 1] * y + r[0, 2] * z + t[0]) / depth
    v = (r[1, 0] * x + r[1, 1] * y + r[1, 2] * z + t[1]) / depth
    k1, k2, p1, p2, k3 = lens.distortion
    square = u * u + v * v
    radial = 1.0 + square * (k1 + square * (k2 + square * k3))
    a = u * radial + 2.0 * p1 * u * v + p2 * (square + 2.0 * u * u)
    b = v * radial + p1 * (square + 2.0 * v * v) + 2.0 * p2 * u * v
    m = lens.matrix
    return m[0, 0] * a + m[0, 1] * b + m[0, 2], m[1, 0] * a + m[1, 1] * b + m[1, 2]


@compiled
def project_points(lens: Lens, points: Floats, pixels: Floats) -> None:
    """Map points of the floor frame to pixels.

    Args:
        lens: of the camera.
        points: shape (N, 3) [m].
        pixels: shape (N, 2), receives them; NaN for points behind the camera.
    """
    for n in range(len(points)):
        pixels[n, 0], pixels[n, 1] = project_point(lens, points[n, 0], points[n, 1], points[n, 2])
