"""Tags found by their geometry alone, before anything is known of their colours.

The floor is looked at straight from above, on a raster of a few cells per tag. For every cell and
heading, the share of the picture's variation under the tag that is not explained by "every part has
one colour, whichever" is an exhaustive test (matched subspace detection, Scharf 1991): about two
dozen correlations. What explains its place best is then fitted to the pixels themselves.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibration.correlator import Correlator
from vision.calibration.floor_raster import Raster, floor_raster
from vision.eye import Eye
from vision.palette import YCC_FROM_BGR
from vision.pose import fit_poses
from vision.tags import Tag

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Indices = NDArray[np.intp]

_CELLS = 12  # of the raster along a tag's side
_TURNS = 24  # headings that are tried
_CHROMA = 1.5  # weight of chroma against luma: tags differ from most things by their colours
_DULL = 8.0  # variation below which nothing can be told [grey levels^2, weighted]
_UNEXPLAINED = 0.5  # largest share of the variation that may stay unexplained
_APART = 0.25  # hypotheses nearer than this share of a tag's side are one
_MOST = 500  # hypotheses that are fitted, the best ones
_STEPS = 8  # of Gauss-Newton
_FINE = 6  # coverage is counted on so many points along a cell's side
_MISFIT_PX, _MISFIT = 1.2, 0.06  # largest residual: pixels, or this share of a tag's side
_SAME_HEADING = 0.4  # [rad]


@dataclass(frozen=True, slots=True)
class Sightings:
    """Poses at which the picture has the geometry of a tag; some are the same place turned.

    Attributes:
        shapes: shape (N,), geometry, an index of `eye.shapes`.
        poses: shape (N, 3), x, y, theta on the floor [m, m, rad].
        residual_px: shape (N,), rms misfit as a displacement of edges [px].
        colors: shape (N, K, 3), BGR of every part as it would look without blur.
    """

    shapes: Indices
    poses: Floats
    residual_px: Floats
    colors: Floats

    def __len__(self) -> int:
        return len(self.shapes)

    def take(self, chosen: Indices) -> "Sightings":
        """Choose some.

        Args:
            chosen: indices, shape (M,).

        Returns:
            These sightings.
        """
        return Sightings(
            self.shapes[chosen], self.poses[chosen], self.residual_px[chosen], self.colors[chosen]
        )


def find_outlines(image: NDArray[np.uint8], eye: Eye) -> Sightings:
    """Find whatever has the geometry of a tag, in any colours.

    Args:
        image: shape (H, W, 3), BGR.
        eye: camera, tags and sharpness; its palette is not used.

    Returns:
        What was found in the field, the best fitting first.
    """
    shapes, starts = [np.zeros(0, np.intp)], [np.zeros((0, 3))]
    for index, shape in enumerate(eye.shapes):
        tag = eye.tags.tags[shape.tags[0]]
        raster = floor_raster(image, eye.camera, tag.side / _CELLS)
        found = _peaks(_unexplained(raster, tag, eye.optics.blur_px), raster)
        shapes.append(np.full(len(found), index, np.intp))
        starts.append(found)
    every = np.concatenate(starts)
    inside = eye.in_field(eye.camera.tag_pixels(every))
    return _fitted(image, eye, np.concatenate(shapes)[inside], every[inside])


def _unexplained(raster: Raster, tag: Tag, blur_px: float) -> Singles:
    """Share of the variation under a tag that its parts do not explain (turns, rows, columns)."""
    weights = np.array([[1.0], [_CHROMA], [_CHROMA]])
    channels = raster.colors @ np.asarray((weights * YCC_FROM_BGR).T, np.float32)
    channels -= channels.mean(axis=(0, 1))
    planes = np.concatenate((np.moveaxis(channels, -1, 0), [np.square(channels).sum(axis=-1)]))
    sigma = max(blur_px / raster.cell_px, 0.3)
    angles = 2.0 * np.pi / _TURNS * np.arange(_TURNS)
    turned = [_coverage(tag, float(angle), raster.cell, sigma) for angle in angles]
    correlated = Correlator(planes, turned[0].shape[1:])
    return np.stack([_share(correlated, parts) for parts in turned])


def _share(correlated: Correlator, parts: Singles) -> Singles:
    """One turn of `_unexplained`; parts (K, n, n), the planes are the channels and their energy."""
    window = np.clip(parts.sum(axis=0), 0.0, 1.0)
    weight = float(window.sum())
    gram = np.einsum("kij,lij,ij->kl", parts, parts, window, dtype=np.float64)
    root = np.linalg.inv(np.linalg.cholesky(gram + 1e-3 * weight * np.eye(len(parts))))
    axes = np.asarray(np.einsum("kl,lij->kij", root, parts * window), np.float32)
    *means, squares = correlated.with_kernel(window)
    whole = squares - np.square(means).sum(axis=0) / weight
    explained = sum(np.square(correlated.with_kernel(axis, 3)).sum(axis=0) for axis in axes)
    left = np.maximum(squares - explained, 0.0) + 0.5 * _DULL * weight
    share: Singles = left / (np.maximum(whole, 0.0) + _DULL * weight)
    return share


def _coverage(tag: Tag, theta: float, cell: float, sigma: float) -> Singles:
    """Blurred visible coverage of the parts of a turned tag, (K, n, n) over y and x."""
    c, s = np.cos(theta), np.sin(theta)
    half = int(np.ceil(tag.outer_radius / cell)) + 1
    n = 2 * half + 1
    labels = np.zeros((n * _FINE, n * _FINE), np.uint8)
    for index, part in enumerate(tag.parts):
        corners = (part.polygon @ [[c, s], [-s, c]] / cell + half + 0.5) * _FINE - 0.5
        cv2.fillPoly(labels, [np.rint(corners * 16.0).astype(np.int32)], (index + 1,), shift=4)
    masks = (np.asarray(labels == index + 1, np.float32) for index in range(len(tag.parts)))
    fine = (cv2.resize(mask, (n, n), interpolation=cv2.INTER_AREA) for mask in masks)
    return np.stack([np.asarray(cv2.GaussianBlur(f, (0, 0), sigma), np.float32) for f in fine])


def _peaks(share: Singles, raster: Raster) -> Floats:
    """Poses (N, 3) that explain more than their neighbours in place and heading, best first."""
    reach = round(_APART * _CELLS)
    around = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    least = np.stack([cv2.erode(plane, around) for plane in share])
    for shift in (-2, -1, 1, 2):
        least = np.minimum(least, np.roll(least, shift, axis=0))
    turn, row, column = np.nonzero((share <= least) & (share < _UNEXPLAINED) & raster.seen)
    order = np.argsort(share[turn, row, column], kind="stable")[:_MOST]
    x, y = raster.origin[0] + raster.cell * column, raster.origin[1] + raster.cell * row
    return np.column_stack((x, y, 2.0 * np.pi / _TURNS * turn))[order]


def _fitted(image: NDArray[np.uint8], eye: Eye, shapes: Indices, starts: Floats) -> Sightings:
    """Fit the layouts to the pixels, keep what fits, and of two that became one the better."""
    if len(starts) == 0:
        return Sightings(shapes, starts, np.zeros(0), np.zeros((0, eye.looks.classes.shape[1], 3)))
    centers = eye.camera.tag_pixels(starts)
    fit = fit_poses(image, eye.gauge, shapes, starts, centers, _STEPS)
    found = Sightings(shapes, fit.poses, fit.residual_px, fit.colors[:, :-1])
    sides = np.array([eye.tags.tags[shape.tags[0]].side for shape in eye.shapes])[shapes]
    moved = np.hypot(*(fit.poses - starts)[:, :2].T)
    limit = np.maximum(_MISFIT_PX, _MISFIT * sides * eye.gauge.scales[-1])
    good = (fit.residual_px < limit) & (moved < 0.5 * sides)
    order = np.argsort(fit.residual_px, kind="stable")
    kept: list[int] = []
    for n in order[good[order]].tolist():
        away = np.hypot(*(fit.poses[kept, :2] - fit.poses[n, :2]).T)
        turned = np.cos(fit.poses[kept, 2] - fit.poses[n, 2]) < np.cos(_SAME_HEADING)
        if not ((away < _APART * sides[n]) & ~turned & (shapes[kept] == shapes[n])).any():
            kept.append(n)
    return found.take(np.array(kept, np.intp))
