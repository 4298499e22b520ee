"""Hypotheses: pairs of blobs whose colours and distance fit two parts of a tag."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.compiled import compiled, compiled_part
from vision.eye import Eye
from vision.floor_map import floor_at, pixel_slopes
from vision.leftovers import SLACK_PX, cut, feeble, lonely
from vision.scene import Rejection
from vision.segment import Blobs
from vision.shapes import Looks

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Bytes = NDArray[np.uint8]

_SAME_PLACE = 0.3  # candidates are one if they are nearer than this share of the tag's radius
_SAME_HEADING = 0.5  # and their headings differ by less than this [rad]
_MAX_PAIRS = 768  # of blobs that are looked at


@dataclass(frozen=True, slots=True)
class Candidates:
    """Poses at which a tag may be; their order is by agreement, best first.

    Attributes:
        shapes: shape (N,), geometry, an index of `eye.shapes`.
        poses: shape (N, 3), x, y, theta on the floor [m, m, rad].
        centers: shape (N, 2), where that is in the image [px].
        agreement: shape (N,), share of the sample points that show the right class.
    """

    shapes: Indices
    poses: Floats
    centers: Floats
    agreement: Floats

    def __len__(self) -> int:
        return len(self.agreement)

    def take(self, chosen: Indices | slice) -> "Candidates":
        """Choose some candidates.

        Args:
            chosen: indices, shape (M,), or a range of them.

        Returns:
            These candidates.
        """
        return Candidates(
            self.shapes[chosen], self.poses[chosen], self.centers[chosen], self.agreement[chosen]
        )


def propose(
    blobs: Blobs, classes: Bytes, eye: Eye, wanted: NDArray[np.bool_]
) -> tuple[Candidates, tuple[Rejection, ...]]:
    """Find poses that explain pairs of blobs.

    Args:
        blobs: coloured regions.
        classes: the class image they were found in, shape (H, W).
        eye: tags and camera.
        wanted: shape (T,), the tags to look for.

    Returns:
        Candidates, best first, at most `thresholds.max_candidates`; blobs and candidates that were
        left out, with the reason.
    """
    found, seen = _pairs(blobs, classes, eye, wanted)
    strong = int(np.count_nonzero(found.agreement >= eye.thresholds.agreement))
    best = _distinct(found.take(slice(strong)), eye)
    most = eye.thresholds.max_candidates
    kept = best.take(slice(most)) if len(best) > most else best
    weak = found.take(slice(strong, None))
    reasons = lonely(blobs, eye, found.centers)
    reasons += feeble(weak.centers, weak.agreement, kept.centers, eye)
    reasons += cut(len(best) - len(kept) + max(seen - _MAX_PAIRS, 0), blobs.dropped, eye)
    return kept, reasons


def _pairs(
    blobs: Blobs, classes: Bytes, eye: Eye, wanted: NDArray[np.bool_]
) -> tuple[Candidates, int]:
    """Pairs of blobs as candidates, best first; and how many there would be."""
    order = np.argsort(blobs.centers[:, 1], kind="stable")
    shapes, poses = np.empty(_MAX_PAIRS, np.intp), np.empty((_MAX_PAIRS, 3))
    centers, agreement = np.empty((_MAX_PAIRS, 2)), np.empty(_MAX_PAIRS)
    seen = _pair_up(
        blobs.classes[order], blobs.centers[order], classes, eye.gauge.nodes, eye.looks, wanted,
        eye.thresholds.distance_share, (float(eye.gauge.scales[0]), float(eye.gauge.scales[-1])),
        len(eye.palette.names) + 1, shapes, poses, centers, agreement,
    )  # fmt: skip
    count = min(seen, _MAX_PAIRS)
    best = np.argsort(-agreement[:count], kind="stable")
    return Candidates(shapes, poses, centers, agreement).take(best), seen


@compiled
def _pair_up(
    kinds: Indices, pixels: Floats, classes: Bytes, nodes: Floats, looks: Looks,
    wanted: NDArray[np.bool_], share: float, scales: tuple[float, float], colors: int,
    shapes: Indices, poses: Floats, centers: Floats, agreement: Floats,
) -> int:  # fmt: skip
    """Try every two blobs (in the order of y) as every two anchors; returns how many fit."""
    match, count = np.zeros((colors, colors), np.bool_), 0
    for shape in range(looks.anchors.shape[0]):
        for anchor in range(looks.anchors.shape[1]):
            parts = looks.anchors[shape, anchor]
            if not _match(looks, shape, anchor, wanted, match):
                continue
            one, two = looks.centroids[shape, parts[0]], looks.centroids[shape, parts[1]]
            length = np.hypot(two[0] - one[0], two[1] - one[1])
            slack = share * length + SLACK_PX / scales[0]
            reach = (length + slack) * scales[1]
            for a in range(len(kinds)):
                for b in range(a + 1, len(kinds)):
                    if pixels[b, 1] - pixels[a, 1] > reach:
                        break
                    if abs(pixels[b, 0] - pixels[a, 0]) > reach:
                        continue
                    for first, second in ((a, b), (b, a)):
                        slot = min(count, len(shapes) - 1)
                        if match[kinds[first], kinds[second]] and _pose_of_pair(
                            pixels[first], pixels[second], one, two, slack, nodes,
                            poses[slot], centers[slot],
                        ):  # fmt: skip
                            shapes[slot] = shape
                            agreement[slot] = agreement_at(
                                classes, nodes, looks, shape, wanted, poses[slot], centers[slot]
                            )
                            count += 1
    return count


@compiled_part
def _match(
    looks: Looks, shape: int, anchor: int, wanted: NDArray[np.bool_], match: NDArray[np.bool_]
) -> bool:
    """Find the pairs of classes that the anchors of wanted tags have; False if there are none."""
    match[:] = False
    i, j = looks.anchors[shape, anchor]
    for before in range(anchor):  # filled up with repetitions
        if looks.anchors[shape, before, 0] == i and looks.anchors[shape, before, 1] == j:
            return False
    some = False
    for tag in range(len(wanted)):
        if wanted[tag] and looks.shape_of[tag] == shape:
            match[looks.classes[tag, i], looks.classes[tag, j]] = some = True
    return some


@compiled_part
def _pose_of_pair(
    first: Floats, second: Floats, one: Floats, two: Floats, slack: float, nodes: Floats,
    pose: Floats, center: Floats,
) -> bool:  # fmt: skip
    """Pose at which two blobs are two parts' centres; False if their distance does not fit."""
    x0, y0 = floor_at(nodes, first[0], first[1])
    x1, y1 = floor_at(nodes, second[0], second[1])
    length = np.hypot(two[0] - one[0], two[1] - one[1])
    if not abs(np.hypot(x1 - x0, y1 - y0) - length) < slack:
        return False
    theta = np.arctan2(y1 - y0, x1 - x0) - np.arctan2(two[1] - one[1], two[0] - one[0])
    u, v = 0.5 * (one[0] + two[0]), 0.5 * (one[1] + two[1])
    c, s = np.cos(theta), np.sin(theta)
    dx, dy = s * v - c * u, -s * u - c * v
    pose[0], pose[1], pose[2] = 0.5 * (x0 + x1) + dx, 0.5 * (y0 + y1) + dy, theta
    center[0], center[1] = 0.5 * (first[0] + second[0]), 0.5 * (first[1] + second[1])
    slopes = pixel_slopes(nodes, center[0], center[1])
    center[0] += slopes[0] * dx + slopes[1] * dy
    center[1] += slopes[2] * dx + slopes[3] * dy
    return True


@compiled_part
def agreement_at(
    classes: Bytes, nodes: Floats, looks: Looks, shape: int, wanted: NDArray[np.bool_],
    pose: Floats, center: Floats,
) -> float:  # fmt: skip
    """Find the share of the sample points that show the right class.

    Args:
        classes: shape (H, W), class image.
        nodes: of the floor map.
        looks: of the tags.
        shape: geometry.
        wanted: shape (T,), tags of which the largest share counts.
        pose: shape (3,), on the floor [m, m, rad].
        center: shape (2,), where that is in the image [px].

    Returns:
        The share.
    """
    height, width = classes.shape
    c, s = np.cos(pose[2]), np.sin(pose[2])
    slopes = pixel_slopes(nodes, center[0], center[1])
    points = looks.samples.shape[1]
    seen, used = np.zeros(points, np.uint8), 0
    for n in range(points):
        if looks.sample_parts[shape, n] < 0:
            break
        used += 1
        u, v = looks.samples[shape, n]
        dx, dy = c * u - s * v, s * u + c * v
        x = int(np.floor(center[0] + slopes[0] * dx + slopes[1] * dy + 0.5))
        y = int(np.floor(center[1] + slopes[2] * dx + slopes[3] * dy + 0.5))
        if 0 <= x < width and 0 <= y < height:
            seen[n] = classes[y, x]
    best = 0
    for tag in range(len(wanted)):
        if wanted[tag] and looks.shape_of[tag] == shape:
            hits = 0
            for n in range(used):
                hits += seen[n] == looks.classes[tag, looks.sample_parts[shape, n]]
            best = max(best, hits)
    return best / max(used, 1)


@compiled
def _keep_distinct(
    shapes: Indices, poses: Floats, place: float, turn: float, most: int, kept: Indices
) -> int:
    """Choose candidates, best first, that no better one repeats; returns their number."""
    count = 0
    for n in range(len(shapes)):
        alone = count < most
        for before in kept[:count]:
            dx, dy = poses[n, 0] - poses[before, 0], poses[n, 1] - poses[before, 1]
            if dx * dx + dy * dy < place * place and shapes[n] == shapes[before]:
                alone = alone and np.cos(poses[n, 2] - poses[before, 2]) <= turn
        if alone:
            kept[count] = n
            count += 1
    return count


def _distinct(candidates: Candidates, eye: Eye) -> Candidates:
    """Drop candidates that a better one repeats; one more than will be kept is left to be told."""
    most = eye.thresholds.max_candidates + 1
    kept = np.empty(most, np.intp)
    place, turn = _SAME_PLACE * eye.radius, float(np.cos(_SAME_HEADING))
    count = _keep_distinct(candidates.shapes, candidates.poses, place, turn, most, kept)
    return candidates.take(kept[:count])
