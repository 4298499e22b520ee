"""What errors of mass and inertia do to the control of (28): bounds (13) and (29) in closed form.

With S = diag(1, 1/l), R the rotation by phi in G = S R diag(1, d), and Delta = diag(eps, eps'),

    G Delta G^-1 = S (R Delta R^T) S^-1
                 = [[eps c^2 + eps' s^2,     l (eps' - eps) c s ],
                    [(eps' - eps) c s / l,   eps s^2 + eps' c^2 ]],     c, s = cos, sin(phi):

the camera offset drops out.
"""

from dataclasses import dataclass
from math import ceil, cos, inf, pi, sqrt

import numpy as np

from control.errors import ControlError
from control.nominal import FloatArray
from control.relative import Vector2
from control.uncertainty import Interval, Motion


@dataclass(frozen=True, slots=True)
class GainBounds:
    """G Delta G^-1 channel by channel, a sound form of (29) for laws that act per channel.

    s_j'' = g v_j + m v_other - P_bar_j with g in [low, high] and |m| <= coupling.

    Attributes:
        low: delta_j = 1 - a_j of distance and bearing, a_j the greatest diagonal entry [1].
        high: delta_j' = 1 + a_j [1].
        coupling: greatest off-diagonal entries [m, 1/m].
    """

    low: Vector2
    high: Vector2
    coupling: Vector2


@dataclass(frozen=True, slots=True)
class NormBounds:
    """(13) and (29) with norms, as in the paper; the bearing counts ``scale`` metres per radian.

    Not enough for laws that act per channel; the lower bound is the least singular value, for a
    bound of the norm alone would allow a direction without any gain.

    Attributes:
        scale: length that makes an angle a length [m].
        gain_error: 1 - c_k of (13), the greatest norm of G Delta G^-1 [1].
        low: delta_k of (29), the least singular value of I + G Delta G^-1 [1].
        high: delta_k' of (29), its greatest [1].
    """

    scale: float
    gain_error: float
    low: float
    high: float


def gain_bounds(motion: Motion) -> GainBounds:
    """Bounds of G Delta G^-1 per channel, over the spacing, phi and the model errors.

    Args:
        motion: spacing, phi and model errors.

    Returns:
        Bounds, reached by some phi and model errors; no bound of the coupling where l may be 0.
    """
    eps, eps2 = motion.follower.mass_error, motion.follower.inertia_error
    low, high = _cos_range(2.0 * motion.heading[0], 2.0 * motion.heading[1])
    # eps c^2 + eps' s^2 = (eps + eps')/2 + (eps - eps')/2 cos(2 phi); the bearing's with -cos
    mean, half = 0.5 * (eps + eps2), 0.5 * (eps - eps2)
    a = mean + max(half * low, half * high), mean + max(-half * low, -half * high)
    near, far = motion.spacing
    cross = (eps + eps2) * sqrt(_greatest_cross(motion.heading))
    return GainBounds(
        (1.0 - a[0], 1.0 - a[1]),
        (1.0 + a[0], 1.0 + a[1]),
        (cross * far, cross / near if near > 0.0 else inf),
    )


def norm_bounds(motion: Motion, scale: float) -> NormBounds:
    """Bounds (13) and (29) of G Delta G^-1 as norms, over the spacing, phi and the model errors.

    Greatest at a corner of the model errors: the norms of G Delta G^-1 and I + G Delta G^-1 are
    convex in (eps, eps'), the norm of the inverse is in (1/(1 + eps), 1/(1 + eps')).

    Args:
        motion: spacing, phi and model errors.
        scale: metres that count as a radian; 1 is the paper's, units ignored [m].

    Returns:
        Bounds, reached by some spacing, phi and model errors; none where l may be 0.

    Raises:
        ControlError: if the scale is not positive and finite.
    """
    if not 0.0 < scale < inf:
        raise ControlError(f"the scale of the bearing must be > 0 m, got {scale} m")
    if not motion.spacing[0] > 0.0:
        return NormBounds(scale, inf, 0.0, inf)
    ratios = (l / scale for l in motion.spacing)  # noqa: E741 (the paper's l)
    skew = _greatest_cross(motion.heading) * max((r - 1.0 / r) ** 2 for r in ratios)
    eps, eps2 = motion.follower.mass_error, motion.follower.inertia_error
    corners = [(s * eps, t * eps2) for s in (-1.0, 1.0) for t in (-1.0, 1.0)]
    whole = [_singular_values(1.0 + a, 1.0 + b, skew) for a, b in corners]
    return NormBounds(
        scale,
        max(_singular_values(a, b, skew)[1] for a, b in corners),
        min(low for low, _ in whole),
        max(high for _, high in whole),
    )


def gain_error(
    distance: FloatArray, phi: FloatArray, mass_error: float, inertia_error: float
) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
    """G Delta G^-1 for given model errors.

    Args:
        distance: l, > 0 [m].
        phi: psi + theta_ik, of the same shape [rad].
        mass_error: eps [1].
        inertia_error: eps' [1].

    Returns:
        Rows [1, m] and [1/m, 1], each entry of the shape of l.
    """
    c, s = np.cos(phi), np.sin(phi)
    cross = (inertia_error - mass_error) * c * s
    return (
        (mass_error * c * c + inertia_error * s * s, distance * cross),
        (cross / distance, mass_error * s * s + inertia_error * c * c),
    )


def _singular_values(a: float, b: float, skew: float) -> tuple[float, float]:
    """Of diag(1, 1/r) R diag(a, b) R^T diag(1, r); skew = c^2 s^2 (r - 1/r)^2."""
    frobenius, determinant = a * a + b * b + skew * (a - b) ** 2, abs(a * b)
    total = sqrt(frobenius + 2.0 * determinant)  # of the two
    difference = sqrt(max(0.0, frobenius - 2.0 * determinant))
    high = 0.5 * (total + difference)
    return (determinant / high if high > 0.0 else 0.0), high


def _greatest_cross(heading: Interval) -> float:
    """Greatest cos^2 sin^2 = (1 - cos 4 phi)/8."""
    return 0.125 * (1.0 - _cos_range(4.0 * heading[0], 4.0 * heading[1])[0])


def _cos_range(low: float, high: float) -> Interval:
    """Exact range of the cosine over an interval [rad]."""
    ends = cos(low), cos(high)
    least = -1.0 if _passes(low - pi, high - pi) else min(ends)
    return least, (1.0 if _passes(low, high) else max(ends))


def _passes(low: float, high: float) -> bool:
    """Whether a multiple of 2 pi lies in the interval."""
    return ceil(low / (2.0 * pi)) * 2.0 * pi <= high
