"""From fits of single robots to what a scenario believes of all of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from control.drive_fit import DriveFit
from pipeline.radio_config import RadioConfig


@dataclass(frozen=True, slots=True)
class Figure:
    """A number with what is known of its error.

    Attributes:
        value: in the unit of its name.
        std: standard error.
        apart: by how much robots differ from it at most.
    """

    value: float
    std: float
    apart: float = 0.0


@dataclass(frozen=True, slots=True)
class DriveFigures:
    """What was measured, in the scenario's terms.

    Attributes:
        speed_scale: wheel units per m/s [s/m].
        track_width: between the wheels [m].
        lag: time constant of the motors [s].
        delay: from sending to the effect in the pictures, by their own time [s].
    """

    speed_scale: Figure
    track_width: Figure
    lag: Figure
    delay: Figure


def figures_of(fit: DriveFit, radio: RadioConfig) -> DriveFigures:
    """One robot's figures.

    A robot that reaches g_v and g_omega times the velocities commanded was told wheel speeds by a
    scale S and a track width b: its own are S / g_v and b g_v / g_omega.

    Args:
        fit: of the robot.
        radio: by which wheels were told while it was measured.

    Returns:
        The figures, each with its standard error.
    """
    v, omega = fit.gain.v, fit.gain.omega
    std_v, std_omega, std_lag, std_delay = fit.std
    ratio = (std_v / v) ** 2 + (std_omega / omega) ** 2
    ratio -= 2.0 * float(fit.covariance[0, 1]) / (v * omega)
    scale, track = radio.speed_scale_per_mps / v, radio.track_width_m * v / omega
    return DriveFigures(
        Figure(scale, scale * std_v / v),
        Figure(track, track * sqrt(max(ratio, 0.0))),
        Figure(fit.lag, std_lag),
        Figure(fit.delay, std_delay),
    )


def common_figures(robots: Sequence[DriveFigures]) -> DriveFigures:
    """What is believed of all robots: the means.

    Args:
        robots: figures of each, at least one.

    Returns:
        Means, their standard errors, and how far single robots are from them.
    """
    return DriveFigures(
        _mean([r.speed_scale for r in robots]),
        _mean([r.track_width for r in robots]),
        _mean([r.lag for r in robots]),
        _mean([r.delay for r in robots]),
    )


def _mean(figures: Sequence[Figure]) -> Figure:
    values = np.array([figure.value for figure in figures])
    stds = np.array([figure.std for figure in figures])
    mean = float(values.mean())
    std = float(np.sqrt((stds**2).sum())) / len(figures)
    return Figure(mean, std, float(np.abs(values - mean).max()))
