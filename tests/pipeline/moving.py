"""A bench for calibrations by moving: a rendered world on a virtual clock; much may go wrong."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

from control.command import Command, RobotId
from control.unicycle import Twist
from pipeline.calibration.ground import Ground, make_ground
from pipeline.calibration.moving import Moved, calibrate_by_moving
from pipeline.calibration.watch import Bench
from pipeline.config import Scenario
from pipeline.lookout import make_lookout
from pipeline.ports import CommandSink, FrameSource
from pipeline.rigs import connect
from pipeline.seeing import make_seeing
from vision.frame import Frame


@dataclass
class Wire:
    """A radio that notes what it is told and hands it on, perhaps to others or changed.

    Attributes:
        sink: the radio behind it.
        to: who is reached instead of whom; several are possible.
        factor: of all speeds.
        down: robots whose link is down.
        sent: (t, robot, twist) of all commands.
        stops: when stop was sent to all [s].
    """

    sink: CommandSink
    to: Mapping[RobotId, tuple[RobotId, ...]] = field(default_factory=dict)
    factor: tuple[float, float] = (1.0, 1.0)
    down: tuple[RobotId, ...] = ()
    sent: list[tuple[float, RobotId, Twist]] = field(default_factory=list)
    stops: list[float] = field(default_factory=list)
    min_period: float = 0.0

    def send(self, commands: tuple[Command, ...], now: float) -> tuple[RobotId, ...]:
        for command in commands:
            self.sent.append((now, command.robot_id, command.twist))
            twist = Twist(self.factor[0] * command.twist.v, self.factor[1] * command.twist.omega)
            for robot in self.to.get(command.robot_id, (command.robot_id,)):
                self.sink.send((replace(command, robot_id=robot, twist=twist),), now)
        return self.down

    def stop(self, now: float) -> None:
        self.stops.append(now)
        self.sink.stop(now)

    def close(self) -> None:
        self.sink.close()


@dataclass
class Blinds:
    """A camera that is blind from a moment on.

    Attributes:
        source: the camera behind it.
        blind_from: that moment [s].
    """

    source: FrameSource
    blind_from: float

    def latest(self, now: float) -> Frame | None:
        frame = self.source.latest(now)
        return frame if now < self.blind_from else None

    def close(self) -> None:
        self.source.close()


@dataclass(frozen=True)
class Room:
    """A bench and what can be looked at afterwards."""

    bench: Bench
    ground: Ground
    wire: Wire
    robots: tuple[RobotId, ...]
    said: list[str]

    def move(self) -> Moved:
        """Calibrate."""
        return calibrate_by_moving(self.bench, self.ground, self.robots)

    def speed_after(self, wait: float) -> float:
        """Greatest true speed of a robot a while later [m/s]; turning counts at 5 cm."""
        rig = self.bench.rig
        end = rig.clock.now() + wait
        rig.clock.wait_until(end)
        rig.source.latest(end)  # the world goes on when it is looked at
        return max(abs(r.state.v) + 0.05 * abs(r.state.omega) for r in rig.truth())


@contextmanager
def room(
    scenario: Scenario,
    blind_from: float | None = None,
    interrupted_at: float | None = None,
    seed: int = 0,
    **wiring: object,
) -> Iterator[Room]:
    """Open a rendered world.

    Args:
        scenario: with an arena.
        blind_from: when the camera falls silent [s].
        interrupted_at: when Ctrl-C is pressed [s].
        seed: of the sensor's noise.
        **wiring: see Wire.

    Yields:
        The room.
    """
    seeing = make_seeing(scenario)
    rig = connect(scenario, "rendered", None, seed, True)
    wire = Wire(rig.sink, **wiring)  # type: ignore[arg-type]
    source = rig.source if blind_from is None else Blinds(rig.source, blind_from)
    rig = replace(rig, sink=wire, source=source)
    said: list[str] = []
    ground = make_ground(scenario, seeing.camera, seeing.tags.tags[0].side)
    asked = _interruption(rig.clock.now, interrupted_at)
    bench = Bench(rig, make_lookout(scenario, seeing), asked, said.append)
    yield Room(bench, ground, wire, tuple(robot.id for robot in scenario.robots), said)
    rig.close()


def _interruption(now: Callable[[], float], at: float | None) -> Callable[[], bool]:
    return lambda: at is not None and now() >= at
