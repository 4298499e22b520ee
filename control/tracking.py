"""Two other laws of the formation's leader, beside the sliding mode of `control.leader`.

Both give the accelerations of a unicycle that tracks a planned motion of its axle's middle.
"""

from math import cos, sin, tanh

from control.compilable import compilable
from control.geometry import wrap_angle
from control.plan import PlannedMotion
from control.relative import Vector2
from control.unicycle import UnicycleState

LATERAL = 64.0
"""Turn per way and error aside, of saturated tracking [1/m^2]."""

RESERVE = 0.3
"""Speed that saturated tracking adds to the planned one at most [m/s]."""

SLOWEST = 0.15
"""Feedback linearisation divides by v, which is taken for at least this [m/s]."""


@compilable
def saturated_input(
    state: UnicycleState, planned: PlannedMotion, proportional: float, horizon: float
) -> Vector2:
    """Saturated tracking: velocities that stay bounded however far the robot is from its plan.

        v* = v_r cos e_th + a tanh(K e_x / a)
        w* = w_r + k v_r e_y (sin e_th / e_th) / (1 + e_x^2 + e_y^2) + K tanh(e_th)

    A stand-in for ref. [17] of the paper (T.-C. Lee et al., "Tracking control of unicycle-modeled
    mobile robots using a saturation feedback controller", IEEE Trans. Control Syst. Technol.,
    2001), whose law it is in kind, not to the letter.

    Args:
        state: predicted state [m, m, rad, m/s, rad/s].
        planned: wanted motion at that moment.
        proportional: K [1/s].
        horizon: in which the velocities are to be reached [s].

    Returns:
        Forward and angular acceleration [m/s^2, rad/s^2].
    """
    wanted = planned.state
    dx, dy = wanted.x - state.x, wanted.y - state.y
    c, s = cos(state.theta), sin(state.theta)
    ahead, aside, turn = c * dx + s * dy, c * dy - s * dx, wrap_angle(wanted.theta - state.theta)
    ratio = sin(turn) / turn if abs(turn) > 1e-6 else 1.0
    v = wanted.v * cos(turn) + RESERVE * tanh(proportional * ahead / RESERVE)
    pull = LATERAL * wanted.v * aside * ratio / (1.0 + ahead * ahead + aside * aside)
    omega = wanted.omega + pull + proportional * tanh(turn)
    return (
        planned.v_rate + (v - state.v) / horizon,
        planned.omega_rate + (omega - state.omega) / horizon,
    )


@compilable
def linearising_input(
    state: UnicycleState,
    planned: PlannedMotion,
    proportional: float,
    integral: float,
    horizon: float,
) -> Vector2:
    """Dynamic feedback linearisation: e'' + K e' + L e = 0 for the floor position, as in (23).

    With a = p_r'' + K (p_r' - p') + L (p_r - p) the robot gets v' = a.e(theta) and turns with
    a.n(theta) / v. Source: G. Oriolo, A. De Luca, M. Vendittelli, "WMR control via dynamic feedback
    linearization", IEEE Trans. Control Syst. Technol., 2002. It cannot turn at a standstill.

    Args:
        state: predicted state [m, m, rad, m/s, rad/s].
        planned: wanted motion at that moment.
        proportional: K [1/s].
        integral: L [1/s^2].
        horizon: in which the angular velocity is to be reached [s].

    Returns:
        Forward and angular acceleration [m/s^2, rad/s^2].
    """
    wanted = planned.state
    c, s, cr, sr = cos(state.theta), sin(state.theta), cos(wanted.theta), sin(wanted.theta)
    turning = wanted.v * wanted.omega
    ax = planned.v_rate * cr - turning * sr + proportional * (wanted.v * cr - state.v * c)
    ay = planned.v_rate * sr + turning * cr + proportional * (wanted.v * sr - state.v * s)
    ax += integral * (wanted.x - state.x)
    ay += integral * (wanted.y - state.y)
    v = max(state.v, SLOWEST) if state.v >= 0.0 else min(state.v, -SLOWEST)
    omega = (ay * c - ax * s) / v
    return ax * c + ay * s, planned.omega_rate + (omega - state.omega) / horizon
