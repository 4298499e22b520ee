"""Sub-pixel pose of black squares on a white rim: where brightness changes across the four edges.

Everything happens on the floor at tag height, in the square's own frame: profiles across the edges
are sampled through the camera model, each says how far its edge is off, and a step of least squares
over place, turn and size follows. Its matrix is the same for all squares.

R squares, P points along the edges, U samples across an edge.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.camera import CameraModel

Floats = NDArray[np.float64]
Gray = NDArray[np.uint8]
Indices = NDArray[np.intp]

_STEPS = 3  # of Gauss-Newton, profiles sampled anew
_ALONG = 10  # profiles on an edge
_SPARED = 0.1  # of an edge near its corners, where profiles see the next edge
_ACROSS = 9  # samples of a profile
_EDGE_PX = 0.04  # error of a profile's edge, standard deviation
_PRIOR_WEIGHT = 8.0  # profiles that it counts for, against the misfit found
_MODEL_PX = 0.015  # error of the place that profiles share: interpolation, blur across a cell
_CORNERS = np.array([[0.5, 0.5], [0.5, -0.5], [-0.5, -0.5], [-0.5, 0.5]])  # clockwise, as seen


@dataclass(frozen=True, slots=True)
class Squares:
    """Squares on the floor.

    Attributes:
        poses: shape (R, 3), x, y, theta [m, m, rad]; NaN where a corner does not see the floor.
        sizes: shape (R,), sides against the expected side.
        residual_px: shape (R,), rms misfit of the corners, or of the edges after the fit [px].
        covariances: shape (R, 3, 3), of the poses [m^2, m rad, rad^2]; zero before the fit.
    """

    poses: Floats
    sizes: Floats
    residual_px: Floats
    covariances: Floats

    def take(self, chosen: Indices) -> "Squares":
        """Choose some squares.

        Args:
            chosen: indices, shape (M,).

        Returns:
            These squares.
        """
        return Squares(
            self.poses[chosen],
            self.sizes[chosen],
            self.residual_px[chosen],
            self.covariances[chosen],
        )


def place_squares(quads: Floats, camera: CameraModel, side: float) -> Squares:
    """Put squares on the floor by their corners.

    Args:
        quads: shape (R, 4, 2), front left, front right, back right, back left [px].
        camera: that took the picture.
        side: expected [m].

    Returns:
        The squares, not yet fitted.
    """
    floor = camera.to_floor(quads.reshape(-1, 2), camera.tag_height).reshape(-1, 4, 2)
    middle = floor.mean(axis=1)
    # As complex numbers the best turn and size are one quotient.
    model = side * (_CORNERS[:, 0] + 1j * _CORNERS[:, 1])
    seen = (floor[..., 0] - middle[:, None, 0]) + 1j * (floor[..., 1] - middle[:, None, 1])
    turn = seen @ model.conj() / (model @ model.conj()).real
    misfit = np.sqrt((np.abs(seen - turn[:, None] * model) ** 2).mean(axis=1))
    poses = np.column_stack((middle, np.angle(turn)))
    scales = _scales(poses, camera)
    return Squares(poses, np.abs(turn), misfit * scales, np.zeros((len(poses), 3, 3)))


def fit_squares(
    gray: Gray, start: Squares, camera: CameraModel, side: float, cells: int
) -> Squares:
    """Fit squares to the picture.

    Args:
        gray: shape (H, W).
        start: poses and sizes, off by less than half a cell, finite.
        camera: that took the picture.
        side: of the black squares [m].
        cells: along a side; the rim is one cell wide, and so is the border of the square.

    Returns:
        The fitted squares.
    """
    points, normals = _edge_points()
    design = np.column_stack((normals, _turning(points, normals), (points * normals).sum(axis=1)))
    inverse = np.linalg.pinv(design)
    depths = np.linspace(-0.5, 0.5, _ACROSS) / cells
    unknown = np.column_stack((start.poses, start.sizes))
    for _ in range(_STEPS):
        offsets = _edge_offsets(gray, unknown, (points, normals, depths), camera, side)
        unknown = _moved(unknown, offsets @ inverse.T, side)
    offsets = _edge_offsets(gray, unknown, (points, normals, depths), camera, side)
    scales = _scales(unknown[:, :3], camera)
    misfit = side * scales[:, None] * (offsets - offsets @ inverse.T @ design.T)
    squares = (misfit**2).sum(axis=1)
    variances = (_PRIOR_WEIGHT * _EDGE_PX**2 + squares) / (_PRIOR_WEIGHT + len(points) - 4)
    covariances = _covariances(variances, scales, np.linalg.inv(design.T @ design)[:3, :3], side)
    residual = np.sqrt(squares / len(points))
    return Squares(unknown[:, :3], unknown[:, 3], residual, covariances)


def sample_square(
    gray: Gray, squares: Squares, n: int, steps: Floats, camera: CameraModel, side: float
) -> Floats:
    """Look up a lattice of points in a square.

    Args:
        gray: shape (H, W).
        squares: some squares.
        n: index of the one.
        steps: shape (M,), where rows and columns lie along x and y, in sides.
        camera: that took the picture.
        side: expected [m].

    Returns:
        Brightness, shape (M, M), over x and y.
    """
    x, y = np.meshgrid(steps, steps, indexing="ij")
    points = side * squares.sizes[n] * np.column_stack((x.reshape(-1), y.reshape(-1)))
    seen = _sampled(gray, squares.poses[n : n + 1], points[None], camera)
    return seen.reshape(len(steps), len(steps))


def _edge_points() -> tuple[Floats, Floats]:
    """Points along the edges of the unit square (P, 2), and the normals there that point inside."""
    share = np.linspace(_SPARED, 1.0 - _SPARED, _ALONG)[:, None]
    ends = np.roll(_CORNERS, -1, axis=0)
    points = [a + share * (b - a) for a, b in zip(_CORNERS, ends, strict=True)]
    normals = -(_CORNERS + ends)
    return np.concatenate(points), np.repeat(normals, _ALONG, axis=0)


def _turning(points: Floats, normals: Floats) -> Floats:
    """How far a turn of 1 rad moves each point along its normal."""
    return normals[:, 1] * points[:, 0] - normals[:, 0] * points[:, 1]


def _edge_offsets(
    gray: Gray,
    unknown: Floats,
    profiles: tuple[Floats, Floats, Floats],
    camera: CameraModel,
    side: float,
) -> Floats:
    """How far inside the expected edges the real ones lie, shape (R, P), in sides of a square."""
    points, normals, depths = profiles
    body = unknown[:, 3, None, None, None] * points[:, None] + depths[:, None] * normals[:, None]
    seen = _sampled(gray, unknown[:, :3], side * body.reshape(len(unknown), -1, 2), camera)
    seen = seen.reshape(len(unknown), 4, _ALONG, _ACROSS)
    white = np.median(seen[..., :1], axis=2, keepdims=True)
    black = np.median(seen[..., -1:], axis=2, keepdims=True)
    share = ((seen - black) / np.maximum(white - black, 1.0)).mean(axis=3)  # of the profile
    reach = depths[-1] * (1.0 + 1.0 / (_ACROSS - 1))  # samples stand for the middles of steps
    offsets: Floats = reach * np.clip(2.0 * share - 1.0, -1.0, 1.0)
    return offsets.reshape(len(unknown), -1)


def _sampled(gray: Gray, poses: Floats, points: Floats, camera: CameraModel) -> Floats:
    """Brightness (R, N) at points (R, N, 2) given in the frames of poses (R, 3) [m]."""
    c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
    where = np.full((*points.shape[:2], 3), camera.tag_height)
    where[..., 0] = poses[:, :1] + c * points[..., 0] - s * points[..., 1]
    where[..., 1] = poses[:, 1:2] + s * points[..., 0] + c * points[..., 1]
    pixels = camera.project(where.reshape(-1, 3)).astype(np.float32)
    x, y = (pixels[:, axis].reshape(points.shape[:2]) for axis in (0, 1))
    seen = cv2.remap(gray, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(seen, np.float64)


def _moved(unknown: Floats, step: Floats, side: float) -> Floats:
    """Apply steps (R, 4) given in the squares' own frames, in sides."""
    c, s = np.cos(unknown[:, 2]), np.sin(unknown[:, 2])
    x = unknown[:, 0] + side * (c * step[:, 0] - s * step[:, 1])
    y = unknown[:, 1] + side * (s * step[:, 0] + c * step[:, 1])
    turn = step[:, 2] / unknown[:, 3]
    return np.column_stack((x, y, unknown[:, 2] + turn, unknown[:, 3] + step[:, 3]))


def _scales(poses: Floats, camera: CameraModel) -> Floats:
    """Pixels per metre at poses (R, 3)."""
    points = np.column_stack((poses[:, :2], np.full(len(poses), camera.tag_height)))
    affine = camera.affine_at(points)
    area = affine[:, 0, 0] * affine[:, 1, 1] - affine[:, 0, 1] * affine[:, 1, 0]
    scales: Floats = np.sqrt(np.abs(area))
    return scales


def _covariances(variances: Floats, scales: Floats, unit: Floats, side: float) -> Floats:
    """Covariances (R, 3, 3) of poses; the unit one is alike along x and y, so no turn is needed."""
    lengths = np.diag((1.0, 1.0, 1.0 / side))
    model = _MODEL_PX**2 * np.diag((1.0, 1.0, 2.0 / side**2))
    unit = lengths @ unit @ lengths
    covariances: Floats = (variances[:, None, None] * unit + model) / scales[:, None, None] ** 2
    return covariances
