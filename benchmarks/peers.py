"""What others use: printed codes, and colours with typed ranges, as people write it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.field import COLORS, FRONTS, SIDE, TWO_PATCH
from benchmarks.markers import ARUCO, corners_to_poses
from control.command import RobotId
from vision.camera import CameraModel
from vision.tags import TagSet

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]
Sightings = Sequence[tuple[RobotId, Floats]]  # id and x, y, theta [m, m, rad]
Look = Callable[[Image], Sightings]

_SMALL_PX = 16.0  # plates below it: pictures are enlarged before codes are looked for
_ENLARGED = 3
_HUE, _SATURATION, _VALUE = 10, 80, 60  # ranges as they are typed: half width, least, least
_NEAR, _FAR = 0.6, 1.4  # of the distance of two patches


def aruco(camera: CameraModel, tuned: bool) -> Look:
    """OpenCV's ArUco detector, 4 x 4 bits.

    Args:
        camera: of the pictures.
        tuned: parameters chosen for the best recall and errors on such pictures, corners refined
            to sub-pixels, small plates enlarged 3 times.

    Returns:
        The detector.
    """
    small = tuned and SIDE * _scale(camera) < _SMALL_PX
    options = _tuned(camera, small) if tuned else cv2.aruco.DetectorParameters()
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(ARUCO), options)
    factor = _ENLARGED if small else 1

    def look(image: Image) -> Sightings:
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        if small:
            grey = cv2.resize(grey, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC)
        corners, ids, _ = detector.detectMarkers(grey)
        if ids is None:
            return ()
        pixels = (np.array(corners, float).reshape(-1, 4, 2) + 0.5) / factor - 0.5
        return _on_floor([int(number) for number in ids.ravel()], pixels, camera)

    return look


def apriltag(camera: CameraModel) -> Look:
    """The AprilTag 3 library, family 36h11, without decimation, one thread.

    Args:
        camera: of the pictures.

    Returns:
        The detector.

    Raises:
        ImportError: if pupil-apriltags is not installed.
    """
    from pupil_apriltags import Detector

    detector = Detector(families="tag36h11", nthreads=1, quad_decimate=1.0, refine_edges=1)
    detector.tag_families.clear()  # it would free them first and then use them once more

    def look(image: Image) -> Sightings:
        found = detector.detect(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
        if not found:
            return ()
        # Counter-clockwise from the rear left as OpenCV prints the codes; a pixel's centre is 0.5.
        corners = np.array([tag.corners for tag in found])[:, [1, 0, 3, 2]] - 0.5
        return _on_floor([tag.tag_id for tag in found], corners, camera)

    return look


@dataclass(frozen=True, slots=True)
class _Patch:
    """A coloured blob: its colour and its place on the floor [m]."""

    color: str
    place: Floats


def hsv(camera: CameraModel, tags: TagSet) -> Look:
    """Ranges of hue, contours, moments, pairs by distance, a homography: the usual script.

    Args:
        camera: of the pictures, without distortion.
        tags: two patches each.

    Returns:
        The detector.
    """
    ranges = {name: _range(bgr) for name, bgr in _bgr_of(tags)}
    ids = {(tag.parts[1].color, tag.parts[2].color): tag.robot_id for tag in tags.tags}
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float) * camera.size_px
    floor = camera.to_floor(corners, camera.tag_height)
    to_floor = cv2.getPerspectiveTransform(corners.astype(np.float32), floor.astype(np.float32))
    least = 0.2 * TWO_PATCH.parts[1].area * _scale(camera) ** 2

    def look(image: Image) -> Sightings:
        colors = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
        patches = []
        for name, bounds in ranges.items():
            mask = cv2.inRange(colors, *bounds[0])
            for low, high in bounds[1:]:
                mask = cv2.bitwise_or(mask, cv2.inRange(colors, low, high))
            outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
            for outline in outlines:
                moments = cv2.moments(outline)
                if moments["m00"] > least:
                    center = moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]
                    place = cv2.perspectiveTransform(np.array([[center]]), to_floor)[0, 0]
                    patches.append(_Patch(name, place))
        return _paired(patches, ids)

    return look


def _paired(patches: Sequence[_Patch], ids: dict[tuple[str, str], RobotId]) -> Sightings:
    """The nearest pair of patches of every robot whose distance is about right."""
    apart = float(TWO_PATCH.parts[1].centroid[0] - TWO_PATCH.parts[2].centroid[0])
    best: dict[RobotId, tuple[float, Floats]] = {}
    for front in patches:
        if front.color not in FRONTS:
            continue
        for rear in patches:
            robot_id = ids.get((front.color, rear.color))
            ahead = front.place - rear.place
            distance = float(np.hypot(*ahead))
            if robot_id is None or not _NEAR < distance / apart < _FAR:
                continue
            error = abs(distance - apart)
            if robot_id not in best or error < best[robot_id][0]:
                middle = 0.5 * (front.place + rear.place)
                best[robot_id] = error, np.array([*middle, np.arctan2(ahead[1], ahead[0])])
    return [(robot_id, pose) for robot_id, (_, pose) in best.items()]


def _tuned(camera: CameraModel, small: bool) -> cv2.aruco.DetectorParameters:
    """The best of dozens of combinations tried on such pictures."""
    options = cv2.aruco.DetectorParameters()
    options.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    options.cornerRefinementWinSize = 3 if camera.size_px[0] < 1000 else 5
    options.adaptiveThreshWinSizeMax, options.adaptiveThreshWinSizeStep = (15 if small else 9), 4
    options.polygonalApproxAccuracyRate = 0.05 if small else 0.03
    options.perspectiveRemoveIgnoredMarginPerCell = 0.25
    options.perspectiveRemovePixelPerCell = 8
    options.minMarkerPerimeterRate = options.minMarkerDistanceRate = 0.02
    options.minDistanceToBorder = 1
    return options


def _bgr_of(tags: TagSet) -> list[tuple[str, tuple[int, int, int]]]:
    return [(color.name, color.bgr) for color in COLORS if color.name in tags.search_colors]


def _range(bgr: tuple[int, int, int]) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """One range of hue, saturation and value, or two where the hue passes 180."""
    pixel = np.array([[bgr]], np.uint8)
    hue = int(cv2.cvtColor(pixel, cv2.COLOR_BGR2HSV)[0, 0, 0])
    spans = [(hue - _HUE, hue + _HUE)]
    spans += [(low + 180, 179) for low, _ in spans if low < 0]
    spans += [(0, high - 180) for _, high in spans[:1] if high > 179]
    return [((max(a, 0), _SATURATION, _VALUE), (min(b, 179), 255, 255)) for a, b in spans]


def _scale(camera: CameraModel) -> float:
    """Pixels per metre in the picture's middle, at the height of the tags."""
    middle = np.array([(*camera.position[:2], camera.tag_height)])
    return float(np.sqrt(abs(np.linalg.det(camera.affine_at(middle)[0]))))


def _on_floor(ids: Sequence[int], corners: Floats, camera: CameraModel) -> Sightings:
    """Corners (N, 4, 2) [px] as poses, the first sighting of every id."""
    floor = camera.to_floor(corners.reshape(-1, 2), camera.tag_height).reshape(-1, 4, 2)
    first: dict[int, Floats] = {}
    for robot_id, pose in zip(ids, corners_to_poses(floor), strict=True):
        first.setdefault(robot_id, pose)
    return list(first.items())
