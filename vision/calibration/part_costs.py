"""How well the colours of a sighting's parts go with those of a robot's tag.

The colours of a tag's parts are the light on it times the colours of the print. Costs are squared
deviations in units of their spread (-2 log likelihood). N sightings, T tags, P coloured parts of a
tag at most, C colours.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.calibration.print_colors import unit
from vision.calibration.sightings import Sightings
from vision.eye import Eye

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_TURN = 0.12  # spread of the direction of one colour between robots [rad]
_NOISE = 6.0  # and of its BGR [grey levels]
_LIGHT = 0.25  # spread of the logarithm of the light between parts of a tag
_LIGHTS = 1.0  # and between tags
_MISFIT_PX = 0.7  # residual that costs 1: pixels, or a share of a tag's side
_MISFIT = 0.035
_PLATE = 0.25  # spread of the logarithm by which a black plate may seem brighter than a part
_FAINT = 15.0  # difference between a part and the black plate that costs 1 [grey levels]


@dataclass(frozen=True, slots=True)
class PartColors:
    """The colours of the parts of all sightings, arranged for comparison with all tags.

    Attributes:
        frames: shape (N,), picture of every sighting.
        poses: shape (N, 3) [m, m, rad].
        sides: shape (N,), of the plates [m].
        colors: shape (N, P, 3), BGR, at least 1.
        fixed: shape (N, T), costs that do not depend on colours; inf for tags of another shape.
        classes: shape (T, P), colour of every part.
        used: shape (T, P), 1 for parts the tag has, else 0.
    """

    frames: Indices
    poses: Floats
    sides: Floats
    colors: Floats
    fixed: Floats
    classes: Indices
    used: Floats

    def costs(self, prints: Floats) -> tuple[Floats, Floats]:
        """Compare with the colours of a print.

        Args:
            prints: shape (C, 3), colours in light 1, BGR.

        Returns:
            Costs, shape (N, T); logarithm of the light on the sighting if it wears the tag, (N, T).
        """
        length = np.linalg.norm(self.colors, axis=2)
        cosine = unit(self.colors) @ unit(prints).T  # (N, P, C)
        turn = np.arccos(np.clip(cosine, -1.0, 1.0)) / np.hypot(_TURN, _NOISE / length)[..., None]
        level = np.log(length)[..., None] - np.log(np.linalg.norm(prints, axis=1))
        part = np.arange(self.colors.shape[1])
        turn, level = (a[:, part, self.classes] for a in (turn, level))  # (N, T, P)
        count = self.used.sum(axis=1)
        light = (level * self.used).sum(axis=2) / count
        uneven = (level - light[..., None]) / _LIGHT
        apart = ((turn**2 + uneven**2) * self.used).sum(axis=2)
        return apart + (light / _LIGHTS) ** 2 + self.fixed, light


def part_colors(frames: tuple[Sightings, ...], eye: Eye) -> PartColors:
    """Arrange sightings for comparison.

    Args:
        frames: sightings of each picture.
        eye: tags.

    Returns:
        Their colours.
    """
    shapes = np.concatenate([seen.shapes for seen in frames])
    found = np.concatenate([seen.colors for seen in frames])
    residual = np.concatenate([seen.residual_px for seen in frames])
    most = max(len(shape.colored) for shape in eye.shapes)
    classes = np.zeros((len(eye.tags.tags), most), np.intp)
    used = np.zeros(classes.shape)
    colors = np.ones((len(shapes), most, 3))
    fixed = np.full((len(shapes), len(eye.tags.tags)), np.inf)
    sides = np.array([eye.tags.tags[shape.tags[0]].side for shape in eye.shapes])[shapes]
    spread = np.maximum(_MISFIT_PX, _MISFIT * sides * eye.gauge.scales[-1])
    for index, shape in enumerate(eye.shapes):
        rows, count = np.flatnonzero(shapes == index), len(shape.colored)
        tags = np.array(shape.tags)
        classes[tags, :count] = eye.looks.classes[tags][:, shape.colored] - 1
        used[tags, :count] = 1.0
        colors[rows, :count] = np.maximum(found[rows][:, shape.colored], 1.0)
        plate = np.setdiff1d(np.arange(len(shape.names)), shape.colored)
        bright = _brighter(found[rows][:, plate], colors[rows, :count]) / _PLATE
        faint = _FAINT / _contrast(found[rows][:, plate], colors[rows, :count])
        own = (residual[rows] / spread[rows]) ** 2 + bright**2 + faint**2
        fixed[rows[:, None], tags] = own[:, None]
    return PartColors(
        np.repeat(np.arange(len(frames)), [len(seen) for seen in frames]),
        np.concatenate([seen.poses for seen in frames]), sides, colors, fixed, classes, used,
    )  # fmt: skip


def _brighter(black: Floats, colored: Floats) -> Floats:
    """Logarithm by which the brightest black part exceeds the darkest coloured one, (N,); >= 0."""
    darkest = np.linalg.norm(colored, axis=2).min(axis=1)
    brightest = np.linalg.norm(np.maximum(black, 1.0), axis=2).max(axis=1, initial=1.0)
    excess: Floats = np.maximum(np.log(brightest / darkest), 0.0)
    return excess


def _contrast(black: Floats, colored: Floats) -> Floats:
    """Least difference between a coloured part and a black one, (N,) [grey levels]; at least 1.

    Where parts hardly differ, the geometry is that of noise. Infinite if no part is black.
    """
    between = np.linalg.norm(colored[:, :, None] - np.maximum(black[:, None], 1.0), axis=3)
    least: Floats = np.maximum(between.min(axis=(1, 2), initial=np.inf), 1.0)
    return least
