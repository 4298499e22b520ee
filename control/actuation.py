"""From a wanted acceleration to a velocity command that motors with a lag can follow."""

from dataclasses import dataclass
from math import exp, isfinite

from control.compilable import compilable
from control.errors import ControlError
from control.relative import Vector2
from control.unicycle import SpeedLimits, Twist
from control.value import value


@value
@dataclass(frozen=True, slots=True)
class DriveGain:
    """Velocities a robot reaches per velocity commanded: 1 + Delta_k of (3) through its motors.

    Attributes:
        v: of the forward velocity [1].
        omega: of the angular velocity [1].
    """

    v: float = 1.0
    omega: float = 1.0


NOMINAL_GAIN = DriveGain()
"""A robot that does as it is told."""


@value
@dataclass(frozen=True, slots=True)
class Actuation:
    """What is known of a robot's motors, and what may be asked of them.

    Attributes:
        lag: time constant with which velocities follow commands, > 0 [s].
        limits: greatest commanded speeds [m/s, rad/s].
        v_rate_limit: greatest forward acceleration asked for, > 0 [m/s^2].
        omega_rate_limit: greatest angular acceleration asked for, > 0 [rad/s^2].

    Raises:
        ControlError: if the lag or a limit is not positive.
    """

    lag: float = 0.05
    limits: SpeedLimits = SpeedLimits(1.5, 15.0)  # noqa: RUF009 (immutable)
    v_rate_limit: float = 10.0
    omega_rate_limit: float = 200.0

    def __post_init__(self) -> None:
        if not (self.lag > 0.0 and self.v_rate_limit > 0.0 and self.omega_rate_limit > 0.0):
            raise ControlError(
                f"motor lag and acceleration limits must be > 0, got {self.lag} s, "
                f"{self.v_rate_limit} m/s^2, {self.omega_rate_limit} rad/s^2"
            )

    def command(
        self, own: Twist, acceleration: Vector2, dt: float, gain: DriveGain = NOMINAL_GAIN
    ) -> tuple[Twist, Vector2]:
        """The command under which the lagged velocities change by dt times the acceleration.

        Args:
            own: velocities when the command takes effect [m/s, rad/s].
            acceleration: wanted forward and angular acceleration [m/s^2, rad/s^2].
            dt: period for which the command holds [s].
            gain: drive gains, both > 0.

        Returns:
            The command within the limits, and the acceleration it really gives
            [m/s, rad/s; m/s^2, rad/s^2].
        """
        u1 = max(-self.v_rate_limit, min(self.v_rate_limit, acceleration[0]))
        u2 = max(-self.omega_rate_limit, min(self.omega_rate_limit, acceleration[1]))
        share = _share(self.lag, dt)
        v, omega = (own.v + u1 / share) / gain.v, (own.omega + u2 / share) / gain.omega
        command = self.limits.saturate(Twist(v, omega))
        return command, self.acceleration(own, command, dt, gain)

    def acceleration(
        self, own: Twist, command: Twist, dt: float, gain: DriveGain = NOMINAL_GAIN
    ) -> Vector2:
        """The mean acceleration that a command gives while it holds.

        Args:
            own: velocities when the command takes effect [m/s, rad/s].
            command: within the limits [m/s, rad/s].
            dt: period for which the command holds [s].
            gain: drive gains, both > 0.

        Returns:
            Forward and angular acceleration [m/s^2, rad/s^2].
        """
        share = _share(self.lag, dt)
        a1, a2 = gain.v * command.v - own.v, gain.omega * command.omega - own.omega
        return a1 * share, a2 * share

    def reachable(
        self, own: Twist, dt: float, gain: DriveGain = NOMINAL_GAIN
    ) -> tuple[Twist, Twist]:
        """The velocities that commands within all limits lead to.

        Args:
            own: velocities when the command takes effect [m/s, rad/s].
            dt: period for which the command holds [s].
            gain: drive gains, both > 0.

        Returns:
            The least and the greatest velocities at its end [m/s, rad/s].
        """
        v, omega, r1, r2 = (
            self.limits.v,
            self.limits.omega,
            self.v_rate_limit,
            self.omega_rate_limit,
        )
        a1, a2 = self.acceleration(own, Twist(-v, -omega), dt, gain)
        b1, b2 = self.acceleration(own, Twist(v, omega), dt, gain)
        return (
            Twist(own.v + dt * max(a1, -r1), own.omega + dt * max(a2, -r2)),
            Twist(own.v + dt * min(b1, r1), own.omega + dt * min(b2, r2)),
        )


@compilable
def _share(lag: float, dt: float) -> float:
    """Of the gap between velocity and command, closed per second [1/s]."""
    return (1.0 - exp(-dt / lag)) / dt


def require_finite(what: str, *values: float) -> None:
    """Refuse numbers that are no numbers, before a law spreads them.

    Args:
        what: name of the values for the message.
        *values: numbers to check.

    Raises:
        ControlError: if one of them is infinite or not a number.
    """
    if not isfinite(sum(values)) and not all(map(isfinite, values)):
        raise ControlError(f"{what}: not finite: {', '.join(f'{value:g}' for value in values)}")
