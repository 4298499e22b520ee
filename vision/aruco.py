"""Printed markers found by OpenCV, their poses on the floor by least squares of the edges."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from control.geometry import Pose2D, wrap_angle
from vision.camera import CameraModel
from vision.frame import Frame, check_size
from vision.light import Light
from vision.locate import Prediction
from vision.markers import MarkerSet, marker_cells, marker_dictionary
from vision.scene import Detection, Rejection, Scene
from vision.squares import Squares, fit_squares, place_squares, sample_square
from vision.tags import TagSet

Floats = NDArray[np.float64]
Gray = NDArray[np.uint8]

_MOST_PX = 0.3  # largest rms misfit of the edges, as a share of a cell
_LEAST_LIKENESS = 0.6  # correlation of the cells' brightness with the marker's
_SIZES = (0.8, 1.25)  # of a marker against the robots'
_ROUGH = 0.12  # largest misfit of corners before the fit, as a share of a side
_SMEARED = 0.3  # share of a cell, on every side, into which the lens smears its neighbours
_CELL_PX = 4  # pixels across a cell when the brightness of cells is measured
_MAX_REASONS = 32


class ArucoDetector:
    """Finds square markers; needs about 14 px per marker of 4 x 4 cells.

    Attributes:
        camera: of the frames.
        tags: the markers as tags.
    """

    def __init__(self, camera: CameraModel, markers: MarkerSet) -> None:
        """Prepare OpenCV's detector.

        Args:
            camera: of the frames.
            markers: which robot wears which marker.

        Raises:
            VisionError: if the dictionary or a marker is unknown.
        """
        self.camera: CameraModel = camera
        self.tags: TagSet = markers.tags
        self._markers = markers
        self._robots = {number: robot_id for robot_id, number in markers.worn}
        self._cells = {n: marker_cells(markers.dictionary, n) for n in self._robots}
        dictionary = marker_dictionary(markers.dictionary)
        self._count = dictionary.markerSize + 2
        parameters = cv2.aruco.DetectorParameters()
        parameters.perspectiveRemoveIgnoredMarginPerCell = _SMEARED
        self._finder = cv2.aruco.ArucoDetector(dictionary, parameters)

    def locate(self, frame: Frame, predictions: tuple[Prediction, ...], light: Light) -> Scene:
        """Find the markers in a frame.

        Args:
            frame: what the camera saw.
            predictions: where robots are expected; they decide between two markers of one number.
            light: not used: black and white look alike in any.

        Returns:
            The robots found, in the order of the tag set, and what was not accepted.

        Raises:
            VisionError: if the frame's size is not the camera's.
        """
        check_size(frame, self.camera.size_px)
        gray = np.asarray(cv2.cvtColor(frame.image, cv2.COLOR_BGR2GRAY), np.uint8)
        quads, numbers, others = self._finder.detectMarkers(gray)
        read = [] if numbers is None else [int(n) for n in numbers.reshape(-1)]
        seen = self._judged(gray, _stacked(quads), read)
        detections, twice = _each_once([s for s in seen if isinstance(s, Detection)], predictions)
        rejected = [s for s in seen if isinstance(s, Rejection)]
        rejected += twice + self._unread(_stacked(others))
        order = {robot_id: rank for rank, robot_id in enumerate(self.tags.ids)}
        ranked = sorted(detections, key=lambda detection: order[detection.robot_id])
        return Scene(frame.t_capture, tuple(ranked), tuple(rejected), light)

    def _judged(self, gray: Gray, quads: Floats, numbers: list[int]) -> list[Detection | Rejection]:
        """Decoded markers (R, 4, 2): accepted, or why not."""
        placed = place_squares(quads, self.camera, self._markers.side)
        reasons = [self._unfit(placed, n, number) for n, number in enumerate(numbers)]
        fit = [n for n, reason in enumerate(reasons) if not reason]
        judged: list[Detection | Rejection] = [
            _at(quad, reason) for quad, reason in zip(quads, reasons, strict=True) if reason
        ]
        if fit:
            start, side = placed.take(np.array(fit)), self._markers.side
            squares = fit_squares(gray, start, self.camera, side, self._count)
            judged += [self._accepted(gray, squares, n, numbers[fit[n]]) for n in range(len(fit))]
        return judged

    def _unfit(self, placed: Squares, n: int, number: int) -> str:
        """Why a decoded marker is not even fitted; empty if it is."""
        if number not in self._robots:
            return f"marker {number} is worn by no robot"
        if not np.isfinite(placed.poses[n]).all():
            return f"marker {number} lies beyond the horizon of the floor"
        if not self._has_size(placed, n):
            side, size = 1e3 * self._markers.side, float(placed.sizes[n])
            return f"marker {number} is {size * side:.0f} mm wide, the robots' are {side:.0f} mm"
        return ""

    def _has_size(self, placed: Squares, n: int) -> bool:
        return bool(_SIZES[0] < placed.sizes[n] < _SIZES[1])

    def _accepted(self, gray: Gray, squares: Squares, n: int, number: int) -> Detection | Rejection:
        """A fitted marker: accepted, or why not."""
        x, y, theta = squares.poses[n].tolist()
        pose, residual = Pose2D(x, y, wrap_angle(theta)), float(squares.residual_px[n])
        pixel = self.camera.pixel_pose(pose)
        likeness = self._likeness(gray, squares, n, number)
        cell = (
            self._markers.side / self._count * float(np.abs(self.camera.local_affine(pose)).max())
        )
        if not residual < _MOST_PX * cell:
            reason = f"marker {number}: misfit of {residual:.2f} px, limit {_MOST_PX * cell:.2f} px"
            return Rejection(pixel.x, pixel.y, reason)
        if likeness < _LEAST_LIKENESS:
            reason = f"marker {number}: cells agree to {likeness:.2f} < {_LEAST_LIKENESS:.2f}"
            return Rejection(pixel.x, pixel.y, reason)
        covariance = squares.covariances[n].copy()
        covariance.flags.writeable = False
        return Detection(self._robots[number], pose, pixel, covariance, residual, likeness)

    def _likeness(self, gray: Gray, squares: Squares, n: int, number: int) -> float:
        """Correlation of the brightness of the cells with what the marker says, 0 to 1."""
        cells = self._cells[number]
        steps = (np.arange(2 * self._count) - self._count + 0.5) / (2 * self._count)
        seen = sample_square(gray, squares, n, -steps, self.camera, self._markers.side)
        seen = seen.reshape(self._count, 2, self._count, 2).mean(axis=(1, 3))
        one, other = seen - seen.mean(), cells - cells.mean()
        scale = float(np.sqrt((one * one).sum() * (other * other).sum()))
        return float(np.clip((one * other).sum() / scale, 0.0, 1.0)) if scale > 0.0 else 0.0

    def _unread(self, quads: Floats) -> list[Rejection]:
        """Squares as large as a marker whose cells say nothing."""
        placed = place_squares(quads, self.camera, self._markers.side)
        reasons = []
        for n, quad in enumerate(quads):
            width = float(np.sqrt(cv2.contourArea(quad.astype(np.float32))))
            if self._has_size(placed, n) and placed.residual_px[n] < _ROUGH * width:
                what = f"a square of {width:.0f} px, but no marker of {self._markers.dictionary}"
                reasons.append(_at(quad, what))
        return reasons[:_MAX_REASONS]


def _each_once(
    detections: list[Detection], predictions: tuple[Prediction, ...]
) -> tuple[list[Detection], list[Rejection]]:
    """Of markers with one number keep the one nearest to where the robot is expected.

    Where it is not expected, none is kept: nobody knows which of them is the robot.
    """
    expected = {p.robot_id: p.pose for p in predictions}
    kept: list[Detection] = []
    rejected: list[Rejection] = []
    for robot_id in dict.fromkeys(d.robot_id for d in detections):
        same = [d for d in detections if d.robot_id == robot_id]
        place = expected.get(robot_id)
        best = same[0] if len(same) == 1 else None
        if place is not None and len(same) > 1:
            best = min(same, key=lambda d: _away(d, place))
        kept += [best] if best else []
        why = f"the marker of robot {robot_id} is seen {len(same)} times"
        rejected += [Rejection(d.pixel.x, d.pixel.y, why) for d in same if d is not best]
    return kept, rejected


def _away(detection: Detection, place: Pose2D) -> float:
    """Distance of a detection from a place [m]; infinite if that is not a number."""
    away = float(np.hypot(detection.pose.x - place.x, detection.pose.y - place.y))
    return away if away == away else np.inf


def _stacked(quads: Sequence[ArrayLike]) -> Floats:
    """OpenCV's quadrangles as one array, shape (R, 4, 2) [px]."""
    return np.array(quads, np.float64).reshape(-1, 4, 2)


def _at(quad: Floats, reason: str) -> Rejection:
    x, y = quad.mean(axis=0).tolist()
    return Rejection(x, y, reason)
