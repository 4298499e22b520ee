"""The camera: a pinhole with lens distortion above the floor plane z = 0.

Frames: floor (x, y in the plane, z up) and camera (x right, y down, z along the optical axis).
Pixels: x right, y down, the centre of the top-left pixel is (0, 0).
"""

from dataclasses import dataclass, replace
from math import atan2, cos, sin

import numpy as np
from numpy.typing import ArrayLike, NDArray

from control.geometry import Pose2D
from vision.errors import VisionError
from vision.projection import Lens, project_points
from vision.scene import PixelPose

Floats = NDArray[np.float64]

_NEWTON_STEPS = 20
_NEWTON_TOLERANCE = 1e-13  # normalised coordinates; 1e-10 px at a focal length of 1000 px


@dataclass(frozen=True, slots=True)
class CameraModel:
    """Pinhole camera with OpenCV's five distortion coefficients, placed above the floor.

    Attributes:
        size_px: width and height of the image [px].
        matrix: shape (3, 3), intrinsics fx, skew, cx; fy, cy [px], read-only.
        distortion: shape (5,), k1, k2, p1, p2, k3 of OpenCV's model, read-only.
        rotation: shape (3, 3), R_camera_floor, read-only.
        translation: shape (3,), t_camera_floor: the floor's origin seen from the camera [m],
            read-only.
        tag_height: height of the tags above the floor [m].
    """

    size_px: tuple[int, int]
    matrix: Floats
    distortion: Floats
    rotation: Floats
    translation: Floats
    tag_height: float

    def __post_init__(self) -> None:
        for name, shape in _SHAPES:
            object.__setattr__(self, name, _read_only(name, getattr(self, name), shape))
        error = float(np.abs(self.rotation @ self.rotation.T - np.eye(3)).max())
        if error > 1e-6 or np.linalg.det(self.rotation) < 0.0:
            raise VisionError(f"camera rotation is not a rotation (R R^T off by {error:.2g})")
        if min(self.size_px) < 1 or self.matrix[0, 0] <= 0.0 or self.matrix[1, 1] <= 0.0:
            raise VisionError(
                f"camera of {self.size_px[0]} x {self.size_px[1]} px with focal lengths "
                f"{self.matrix[0, 0]:g}, {self.matrix[1, 1]:g} px"
            )

    @property
    def position(self) -> Floats:
        """Optical centre on the floor frame, shape (3,) [m]."""
        return -self.rotation.T @ self.translation

    @property
    def lens(self) -> Lens:
        """The camera's numbers, for compiled functions."""
        return Lens(self.matrix, self.distortion, self.rotation, self.translation)

    def project(self, points: Floats) -> Floats:
        """Map points of the floor frame to pixels.

        Args:
            points: shape (N, 3) [m].

        Returns:
            Pixels, shape (N, 2); NaN for points behind the camera.
        """
        pixels = np.empty((len(points), 2))
        project_points(self.lens, np.ascontiguousarray(points, np.float64), pixels)
        return pixels

    def tag_pixels(self, poses: Floats) -> Floats:
        """Map the centres of tags to pixels.

        Args:
            poses: shape (N, 3), x, y, theta on the floor [m, m, rad].

        Returns:
            Pixels, shape (N, 2); NaN for tags behind the camera.
        """
        points = poses.copy()
        points[:, 2] = self.tag_height
        return self.project(points)

    def to_floor(self, pixels: Floats, height: float) -> Floats:
        """Map pixels to a plane parallel to the floor.

        Args:
            pixels: shape (N, 2) [px].
            height: of the plane above the floor [m].

        Returns:
            Points x, y, shape (N, 2) [m]; NaN where the ray misses the plane or the lens model
            has no inverse.
        """
        offset = pixels - self.matrix[:2, 2]
        normalised = self._undistorted(offset @ np.linalg.inv(self.matrix[:2, :2]).T)
        rays = np.column_stack((normalised, np.ones(len(normalised)))) @ self.rotation
        center = self.position
        drop = height - center[2]
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = drop / rays[:, 2:]
        return center[:2] + np.where(reach > 0.0, reach, np.nan) * rays[:, :2]

    def affine_at(self, points: Floats) -> Floats:
        """Derivative of the pixel with respect to the floor coordinates.

        Args:
            points: shape (N, 3), in the floor frame [m].

        Returns:
            d pixel / d (x, y), shape (N, 2, 2) [px/m].
        """
        seen = points @ self.rotation.T + self.translation
        depth = seen[:, 2, None, None]
        normalised = seen[:, :2] / seen[:, 2:]
        slope: Floats = self.rotation[:2, :2] - normalised[:, :, None] * self.rotation[2, :2]
        return self.matrix[:2, :2] @ self._distortion_slope(normalised) @ slope / depth

    def local_affine(self, pose: Pose2D) -> Floats:
        """Derivative of the pixel with respect to the floor, at a tag.

        Args:
            pose: of the tag on the floor [m, m, rad].

        Returns:
            d pixel / d (x, y), shape (2, 2) [px/m].
        """
        affine: Floats = self.affine_at(np.array([[pose.x, pose.y, self.tag_height]]))[0]
        return affine

    def pixel_pose(self, pose: Pose2D) -> PixelPose:
        """Where a tag appears on the screen.

        Args:
            pose: of the tag on the floor [m, m, rad].

        Returns:
            Its centre and heading on the screen [px, px, rad].
        """
        x, y = self.project(np.array([[pose.x, pose.y, self.tag_height]]))[0]
        ahead = self.local_affine(pose) @ (cos(pose.theta), sin(pose.theta))
        return PixelPose(float(x), float(y), atan2(-ahead[1], ahead[0]))

    def floor_pose(self, pixel_pose: PixelPose) -> Pose2D:
        """Where a tag seen on the screen stands; the inverse of `pixel_pose`.

        Args:
            pixel_pose: centre and heading on the screen [px, px, rad].

        Returns:
            Its pose on the floor [m, m, rad].
        """
        x, y = self.to_floor(np.array([[pixel_pose.x, pixel_pose.y]]), self.tag_height)[0]
        affine = self.local_affine(Pose2D(float(x), float(y), 0.0))
        ahead = np.linalg.solve(affine, (cos(pixel_pose.heading), -sin(pixel_pose.heading)))
        return Pose2D(float(x), float(y), atan2(ahead[1], ahead[0]))

    def scaled_to(self, size_px: tuple[int, int]) -> "CameraModel":
        """Give the same camera with another resolution.

        Args:
            size_px: new width and height [px].

        Returns:
            The model of the resized image; pixel centres move as c' = (c + 0.5) s - 0.5.
        """
        scale = np.array([size_px[0] / self.size_px[0], size_px[1] / self.size_px[1]])
        matrix = self.matrix.copy()
        matrix[:2] *= scale[:, None]
        matrix[:2, 2] = (self.matrix[:2, 2] + 0.5) * scale - 0.5
        return replace(self, size_px=size_px, matrix=matrix)

    def _distorted(self, points: Floats) -> Floats:
        """Apply the lens to normalised points (N, 2)."""
        if not self.distortion.any():
            return points
        k1, k2, p1, p2, k3 = self.distortion
        x, y = points[:, 0], points[:, 1]
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        return np.column_stack(
            (
                x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
            )
        )

    def _distortion_slope(self, points: Floats) -> Floats:
        """Jacobian of `_distorted`, shape (N, 2, 2)."""
        k1, k2, p1, p2, k3 = self.distortion
        x, y = points[:, 0], points[:, 1]
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        growth = 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3))  # d radial / d r2, times 2
        cross = growth * x * y + 2.0 * (p1 * x + p2 * y)
        slope = np.empty((len(points), 2, 2))
        slope[:, 0, 0] = radial + growth * x * x + 2.0 * p1 * y + 6.0 * p2 * x
        slope[:, 1, 1] = radial + growth * y * y + 6.0 * p1 * y + 2.0 * p2 * x
        slope[:, 0, 1] = slope[:, 1, 0] = cross
        return slope

    def _undistorted(self, points: Floats) -> Floats:
        """Invert `_distorted` by Newton's method; NaN where it does not converge."""
        if not self.distortion.any():
            return points
        found = points.copy()
        with np.errstate(all="ignore"):
            for _ in range(_NEWTON_STEPS):
                step = _solved(self._distortion_slope(found), points - self._distorted(found))
                found = found + step
                if np.abs(step).max(initial=0.0) < _NEWTON_TOLERANCE:
                    break
            missed = np.abs(self._distorted(found) - points).max(axis=1) > 1e-9
        return np.where(missed[:, None], np.nan, found)


_SHAPES: tuple[tuple[str, tuple[int, ...]], ...] = (
    ("matrix", (3, 3)),
    ("distortion", (5,)),
    ("rotation", (3, 3)),
    ("translation", (3,)),
)


def _read_only(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Floats:
    """Copy to a read-only float array of the wanted shape."""
    array = np.array(values, dtype=np.float64)
    if array.shape != shape or not np.isfinite(array).all():
        raise VisionError(f"camera {name}: need {shape} finite numbers, got shape {array.shape}")
    array.flags.writeable = False
    return array


def _solved(slope: Floats, right: Floats) -> Floats:
    """Solve N systems of two equations, (N, 2, 2) and (N, 2), without raising on singular ones."""
    a, b, c, d = slope[:, 0, 0], slope[:, 0, 1], slope[:, 1, 0], slope[:, 1, 1]
    u, v = right[:, 0], right[:, 1]
    return np.column_stack((d * u - b * v, a * v - c * u)) / (a * d - b * c)[:, None]


def overhead_camera(
    size_px: tuple[int, int],
    field_width: float,
    center: tuple[float, float],
    mount_height: float,
    tag_height: float,
    distortion: ArrayLike = (0.0, 0.0, 0.0, 0.0, 0.0),
) -> CameraModel:
    """Build a camera that looks straight down; floor +x is right, floor +y is up in the image.

    Args:
        size_px: width and height of the image [px].
        field_width: width of the floor seen by the image's width, lens distortion apart [m].
        center: x, y of the floor point in the middle of the image [m].
        mount_height: of the optical centre above the floor [m].
        tag_height: of the tags above the floor, below the camera [m].
        distortion: shape (5,), k1, k2, p1, p2, k3 of OpenCV's model.

    Returns:
        The camera, with square pixels.

    Raises:
        VisionError: if a length is not positive or the tags are not below the camera.
    """
    if not (field_width > 0.0 and 0.0 <= tag_height < mount_height):
        raise VisionError(
            f"overhead camera: field width {field_width} m, tags at {tag_height} m under a camera "
            f"at {mount_height} m"
        )
    width, height = size_px
    focal = width * mount_height / field_width
    matrix = [[focal, 0.0, (width - 1) / 2.0], [0.0, focal, (height - 1) / 2.0], [0.0, 0.0, 1.0]]
    rotation = np.diag([1.0, -1.0, -1.0])
    translation = -rotation @ (center[0], center[1], mount_height)
    return CameraModel(
        size_px, np.array(matrix), np.asarray(distortion, float), rotation, translation, tag_height
    )
