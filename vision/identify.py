"""Hypotheses: pairs of blobs whose colours and distance fit two parts of a tag."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.eye import Eye
from vision.scene import Rejection
from vision.segment import Blobs
from vision.shapes import Shape

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_SAME_PLACE = 0.3  # candidates are one if they are nearer than this share of the tag's radius
_SAME_HEADING = 0.5  # and their headings differ by less than this [rad]
_MAX_REASONS = 32
_SLACK_PX = 1.0  # error of the distance of two blobs beside the relative one


@dataclass(frozen=True, slots=True)
class Candidates:
    """Poses at which a tag may be; their order is by agreement, best first.

    Attributes:
        shapes: shape (N,), geometry, an index of `eye.shapes`.
        poses: shape (N, 3), x, y, theta on the floor [m, m, rad].
        agreement: shape (N,), share of the sample points that show the right class.
    """

    shapes: Indices
    poses: Floats
    agreement: Floats

    def __len__(self) -> int:
        return len(self.agreement)

    def take(self, chosen: Indices) -> "Candidates":
        """Choose some candidates.

        Args:
            chosen: indices, shape (M,).

        Returns:
            These candidates.
        """
        return Candidates(self.shapes[chosen], self.poses[chosen], self.agreement[chosen])


def propose(
    blobs: Blobs, classes: NDArray[np.uint8], eye: Eye, wanted: tuple[int, ...]
) -> tuple[Candidates, tuple[Rejection, ...]]:
    """Find poses that explain pairs of blobs.

    Args:
        blobs: coloured regions.
        classes: the class image they were found in, shape (H, W).
        eye: tags and camera.
        wanted: indices of the tags to look for.

    Returns:
        Candidates, best first, at most `thresholds.max_candidates`; blobs and candidates that were
        left out, with the reason.
    """
    floor = eye.camera.to_floor(blobs.centers, eye.camera.tag_height)
    raw = [
        _scored(index, _pair_poses(blobs, floor, eye, shape, own), own, classes, eye)
        for index, shape in enumerate(eye.shapes)
        if len(own := _own(shape, wanted))
    ]
    found = _joined(raw)
    strong = int(np.count_nonzero(found.agreement >= eye.thresholds.agreement))
    best = _distinct(found.take(np.arange(strong)), eye)
    kept = best.take(np.arange(min(len(best), eye.thresholds.max_candidates)))
    weak = found.take(np.arange(strong, len(found)))
    reasons = _lonely(blobs, floor, eye, found) + _weak(weak, kept, eye)
    reasons += _cut(len(best) - len(kept), blobs.dropped, eye)
    return kept, reasons


def _own(shape: Shape, wanted: tuple[int, ...]) -> Indices:
    """Positions within a shape of the tags that are wanted."""
    own = [place for place, tag in enumerate(shape.tags.tolist()) if tag in wanted]
    return np.array(own, np.intp)


def _pair_poses(blobs: Blobs, floor: Floats, eye: Eye, shape: Shape, own: Indices) -> Floats:
    """Poses (N, 3) at which two blobs are the anchor parts of one of the tags."""
    poses = [np.zeros((0, 3))]
    colors = len(eye.palette.names) + 1
    for i, j in shape.anchors:
        match = np.zeros((colors, colors), bool)
        match[shape.part_classes[own, i], shape.part_classes[own, j]] = True
        first, second = np.nonzero(match[blobs.classes[:, None], blobs.classes])
        between = floor[second] - floor[first]
        expected = shape.centroids[j] - shape.centroids[i]
        length = float(np.hypot(*expected))
        slack = eye.thresholds.distance_share * length + _SLACK_PX / eye.templates.scales[0]
        near = np.abs(np.hypot(between[:, 0], between[:, 1]) - length) < slack
        dx, dy = between[near].T
        theta = np.arctan2(dy, dx) - np.arctan2(expected[1], expected[0])
        x, y = 0.5 * (floor[first[near]] + floor[second[near]]).T
        u, v = 0.5 * (shape.centroids[i] + shape.centroids[j])
        c, s = np.cos(theta), np.sin(theta)
        poses.append(np.column_stack((x - c * u + s * v, y - s * u - c * v, theta)))
    return np.concatenate(poses)


def _scored(
    index: int, poses: Floats, own: Indices, classes: NDArray[np.uint8], eye: Eye
) -> Candidates:
    """Look up the classes at the tags' sample points; the best of the tags counts."""
    shape = eye.shapes[index]
    shapes = np.full(len(poses), index, np.intp)
    if len(poses) == 0:
        return Candidates(shapes, poses, np.zeros(0))
    c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
    u, v = shape.samples.T
    points = np.full((len(poses), len(u), 3), eye.camera.tag_height)
    points[..., 0] = poses[:, :1] + c * u - s * v
    points[..., 1] = poses[:, 1:2] + s * u + c * v
    pixels = eye.camera.project(points.reshape(-1, 3))
    h, w = classes.shape
    columns, rows = np.rint(np.nan_to_num(pixels, nan=-1.0)).astype(np.intp).T
    inside = (columns >= 0) & (rows >= 0) & (columns < w) & (rows < h)
    seen = classes.reshape(-1).take(rows * w + columns, mode="clip") * inside
    wanted = shape.part_classes[own][:, shape.sample_parts]
    agreement = (seen.reshape(len(poses), 1, -1) == wanted).mean(axis=2).max(axis=1)
    return Candidates(shapes, poses, agreement)


def _joined(parts: list[Candidates]) -> Candidates:
    """Put candidates together, best first."""
    if not parts:
        return Candidates(np.zeros(0, np.intp), np.zeros((0, 3)), np.zeros(0))
    agreement = np.concatenate([part.agreement for part in parts])
    every = Candidates(
        np.concatenate([part.shapes for part in parts]),
        np.concatenate([part.poses for part in parts]),
        agreement,
    )
    return every.take(np.argsort(-agreement, kind="stable"))


def _distinct(candidates: Candidates, eye: Eye) -> Candidates:
    """Drop candidates that a better one repeats; looks at four times as many as will be kept."""
    if len(candidates) < 2:
        return candidates
    looked = candidates.take(np.arange(min(len(candidates), 4 * eye.thresholds.max_candidates)))
    away = looked.poses[:, None] - looked.poses
    near = np.hypot(away[..., 0], away[..., 1]) < _SAME_PLACE * eye.radius
    same = near & (np.cos(away[..., 2]) > np.cos(_SAME_HEADING))
    same &= looked.shapes[:, None] == looked.shapes
    kept: list[int] = []
    for index, row in enumerate(same):
        if not row[kept].any():
            kept.append(index)
    rest = range(len(looked), len(candidates))
    return candidates.take(np.array([*kept, *rest], np.intp))


def _lonely(blobs: Blobs, floor: Floats, eye: Eye, found: Candidates) -> tuple[Rejection, ...]:
    """Say of large blobs without a partner what was missing."""
    if len(blobs) == 0:
        return ()
    scale = float(eye.templates.scales[-1])
    away = floor[:, None] - found.poses[:, :2]
    near = np.hypot(away[..., 0], away[..., 1]).min(axis=1, initial=np.inf)
    alone = np.flatnonzero(~(near < eye.radius))
    reasons = []
    for index in alone[:_MAX_REASONS]:
        label, area = int(blobs.classes[index]), float(blobs.areas[index])
        missing = _missing_partner(eye, label, area, scale)
        if missing:
            reason = f"{eye.palette.names[label - 1]} blob of {area:.0f} px: {missing}"
            reasons.append(_at(blobs.centers[index], reason))
    return tuple(reasons)


def _missing_partner(eye: Eye, label: int, area: float, scale: float) -> str:
    """What a blob of a class would need to be part of a tag; empty if it is too small to matter."""
    for shape in eye.shapes:
        for i, j in shape.anchors:
            for part, other in ((i, j), (j, i)):
                large = area > 0.5 * shape.areas[part] * scale**2
                if large and (shape.part_classes[:, part] == label).any():
                    length = float(np.hypot(*(shape.centroids[i] - shape.centroids[j])))
                    reach = length * (1 + eye.thresholds.distance_share) * scale + _SLACK_PX
                    names = shape.names
                    return f"{names[part]} patch without {names[other]} patch within {reach:.1f} px"
    return ""


def _weak(weak: Candidates, kept: Candidates, eye: Eye) -> tuple[Rejection, ...]:
    """Say of pairs that disagree with the class image by how much, if nothing better is there."""
    if len(weak) == 0:
        return ()
    reasons: list[Rejection] = []
    told = kept.poses
    radius = eye.radius
    for index in range(len(weak)):
        pose = weak.poses[index]
        if (np.hypot(*(told[:, :2] - pose[:2]).T) < radius).any():
            continue
        told = np.vstack((told, pose))
        center = eye.camera.project(np.array([[pose[0], pose[1], eye.camera.tag_height]]))[0]
        shares = f"{weak.agreement[index]:.2f} < {eye.thresholds.agreement:.2f}"
        reasons.append(_at(center, f"colours agree at too few points: {shares}"))
        if len(reasons) == _MAX_REASONS:
            break
    return tuple(reasons)


def _cut(candidates: int, blobs: int, eye: Eye) -> tuple[Rejection, ...]:
    """Say that a limit was reached."""
    reasons = []
    if blobs:
        reasons.append(f"{blobs} smaller blobs beyond {eye.thresholds.max_blobs} not looked at")
    if candidates:
        limit = eye.thresholds.max_candidates
        reasons.append(f"{candidates} weaker candidates beyond {limit} not looked at")
    middle = 0.5 * (np.array(eye.camera.size_px) - 1.0)
    return tuple(_at(middle, reason) for reason in reasons)


def _at(pixel: Floats, reason: str) -> Rejection:
    return Rejection(float(pixel[0]), float(pixel[1]), reason)
