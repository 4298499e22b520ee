"""The formation's leader driven by a person: velocities as wanted, within limits."""

from dataclasses import dataclass

from control.actuation import NOMINAL_GAIN, Actuation, DriveGain, require_finite
from control.errors import ControlError
from control.leader import LeaderMemory
from control.unicycle import Twist, UnicycleState

AT_ONCE = 0.1  # velocities that are less than a ramp away are reached in this time [s]


@dataclass(frozen=True, slots=True)
class KeyDrive:
    """How a person may drive the leader.

    Attributes:
        speed: greatest forward speed, either way, > 0 [m/s].
        turn: greatest angular speed, either way, > 0 [rad/s].
        ramp: from standstill to the greatest speeds, > 0 [s].

    Raises:
        ControlError: if one is not positive.
    """

    speed: float
    turn: float
    ramp: float

    def __post_init__(self) -> None:
        if not min(self.speed, self.turn, self.ramp) > 0.0:
            raise ControlError(f"driving by keys needs positive limits, got {self}")

    def limited(self, wanted: Twist) -> Twist:
        """What is driven instead of wanted velocities.

        Args:
            wanted: velocities [m/s, rad/s].

        Returns:
            Velocities within the limits [m/s, rad/s].
        """
        v = max(-self.speed, min(self.speed, wanted.v))
        return Twist(v, max(-self.turn, min(self.turn, wanted.omega)))


def keyed_step(
    state: UnicycleState,
    wanted: Twist,
    dt: float,
    drive: KeyDrive,
    actuation: Actuation,
    gain: DriveGain = NOMINAL_GAIN,
) -> tuple[LeaderMemory, Twist]:
    """One sample: towards the wanted velocities, with limited accelerations.

    Args:
        state: predicted state when the command takes effect.
        wanted: velocities [m/s, rad/s].
        dt: for which the command holds, > 0 [s].
        drive: limits.
        actuation: motor lag and limits.
        gain: the robot's drive gains.

    Returns:
        The accelerations given, as followers are told them, and the command [m/s, rad/s].

    Raises:
        ControlError: if a number is not finite or dt is not positive.
    """
    require_finite("leader", state.v, state.omega, wanted.v, wanted.omega)
    if not 0.0 < dt < float("inf"):
        raise ControlError(f"a step of the leader needs dt > 0 s, got {dt} s")
    aim, within = drive.limited(wanted), max(AT_ONCE, dt)
    v_rate, omega_rate = drive.speed / drive.ramp, drive.turn / drive.ramp
    u = (
        max(-v_rate, min(v_rate, (aim.v - state.v) / within)),
        max(-omega_rate, min(omega_rate, (aim.omega - state.omega) / within)),
    )
    command, given = actuation.command(state.twist, u, dt, gain)
    return LeaderMemory((0.0, 0.0), (0.0, 0.0), (0.0, 0.0), given, False), command
