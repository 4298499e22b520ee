"""What a follower's law is made of: its gains, its robot, one sample, and its memory."""

from dataclasses import dataclass

from control.actuation import NOMINAL_GAIN, Actuation, DriveGain
from control.channel import ChannelGains, ChannelMemory
from control.errors import ControlError
from control.laws import Law
from control.output import FollowerOutput, WantedOutput
from control.reaching import ReachingGains
from control.relative import Vector2
from control.twisting import TwistingGains
from control.unicycle import Twist
from control.value import value

_TWISTING, _REACHING = TwistingGains(), ReachingGains()


@value
@dataclass(frozen=True, slots=True)
class SlidingGains:
    """The law and its gains; K, L, mu and nu of the paper by default.

    Attributes:
        law: which law.
        distance: K, L of the first channel.
        bearing: K, L of the second channel: the bearing, or the distance to a second leader.
        twisting: mu, nu and the horizon of all implicit laws.
        reaching: what the first-order laws assume.

    Raises:
        ControlError: if K or L is not positive.
    """

    law: Law = Law.IMPLICIT_TWISTING
    distance: ChannelGains = ChannelGains(2.0, 1.0)  # noqa: RUF009 (immutable)
    bearing: ChannelGains = ChannelGains(2.0, 1.0)  # noqa: RUF009 (immutable)
    twisting: TwistingGains = _TWISTING
    reaching: ReachingGains = _REACHING

    def __post_init__(self) -> None:
        for channel in (self.distance, self.bearing):
            if not min(channel.proportional, channel.integral) > 0.0:
                raise ControlError(f"K and L must be > 0, got {channel}")


@value
@dataclass(frozen=True, slots=True)
class FollowerModel:
    """What the law knows of its robot.

    Attributes:
        camera_offset: from the axle forward to the camera point, d > 0 [m].
        actuation: motor lag and limits.

    Raises:
        ControlError: if the camera offset is not positive.
    """

    camera_offset: float = 0.05
    actuation: Actuation = Actuation()  # noqa: RUF009 (immutable)

    def __post_init__(self) -> None:
        if not self.camera_offset > 0.0:
            raise ControlError(f"the camera offset must be > 0 m, got {self.camera_offset} m")


@value
@dataclass(frozen=True, slots=True)
class FollowerSample:
    """One sample: all at the moment the command will take effect.

    Attributes:
        output: predicted h and what changes it.
        wanted: h^d.
        own: the follower's predicted velocities [m/s, rad/s].
        gain: the follower's drive gains.
    """

    output: FollowerOutput
    wanted: WantedOutput
    own: Twist
    gain: DriveGain = NOMINAL_GAIN


@value
@dataclass(frozen=True, slots=True)
class FollowerMemory:
    """What the law carries from sample to sample.

    Attributes:
        distance: of the first channel.
        bearing: of the second channel.
        acceleration: forward and angular, that the last command gives [m/s^2, rad/s^2].
        fresh: True until the first step.
    """

    distance: ChannelMemory
    bearing: ChannelMemory
    acceleration: Vector2 = (0.0, 0.0)
    fresh: bool = True
