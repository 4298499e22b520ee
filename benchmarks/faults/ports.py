"""Camera, radio, clock, person and process of a mission in which things go wrong."""

from math import inf

from benchmarks.faults.outside import Outside
from benchmarks.faults.script import Kind, Script
from control.command import Command, RobotId
from datasets.cycle import NO_ORDERS, Orders
from pipeline.cameras.rendered import RenderedCamera
from pipeline.cameras.sieve import Sieve, Verdict
from pipeline.cameras.timing import StreamTiming
from pipeline.clock import VirtualClock
from pipeline.radios.link import WRITE_TIMEOUT
from pipeline.radios.simulated import SimulatedRadio
from vision.frame import Frame, as_frame

AWAY = (Kind.UNPLUGGED, Kind.GONE)


class Killed(BaseException):
    """The process is gone: nothing of it runs any more."""


class Camera:
    """A camera that fails. Its frames are dated and judged as those of a stream are."""

    def __init__(self, inner: RenderedCamera, script: Script, latency: float) -> None:
        """Look through a rendered camera.

        Args:
            inner: takes the pictures.
            script: what goes wrong.
            latency: of the camera [s].
        """
        self._inner, self._script = inner, script
        self._sieve, self._timing = Sieve(), StreamTiming(latency)
        self._last: Frame | None = None

    def latest(self, now: float) -> Frame | None:
        """The newest picture, if it comes through and is news.

        Args:
            now: the moment of the cycle [s].

        Returns:
            The picture, None if there is no new one.
        """
        frame = self._inner.latest(now)
        if frame is None or self._script.on(AWAY, now):
            return None
        if self._script.on((Kind.FROZEN,), now) and self._last:
            frame = _with_time(frame, self._last, frame.t_capture)
        self._last = frame
        return self._judged(frame, now)

    def close(self) -> None:
        """Release it. Safe to call twice."""
        self._inner.close()

    def _judged(self, frame: Frame, now: float) -> Frame | None:
        step = self._script.on((Kind.CLOCK_STEP,), now)
        stamp = frame.t_capture + (step.size if step else 0.0)
        t = self._timing.capture_time(stamp, frame.t_arrival or now)
        old = self._script.on((Kind.OLD_STAMPS,), now)
        frame = _with_time(frame, frame, t - (old.size if old else 0.0))
        return frame if self._sieve.judge(frame, stamp) is Verdict.NEW else None


def _with_time(frame: Frame, shows: Frame, t: float) -> Frame:
    """A frame with a picture of its own, even where it shows another's."""
    return as_frame(shows.image.copy(), t, frame.sequence, frame.camera_id, frame.t_arrival)


class Radio(SimulatedRadio):
    """Links that fail; and what they were handed.

    Attributes:
        handed: all commands, with the moment [s].
        dead: the process is gone, nothing is sent any more.
    """

    def __init__(self, world: Outside, script: Script, delay: float, seed: int) -> None:
        """Connect.

        Args:
            world: its robots obey.
            script: what goes wrong.
            delay: from sending to the wheels [s].
            seed: of losses; there are none.
        """
        super().__init__(world, delay, seed=seed)
        self._script, self.dead = script, False
        self.handed: list[tuple[float, Command]] = []

    def send(self, commands: tuple[Command, ...], now: float) -> tuple[RobotId, ...]:
        """Send what the links take.

        Args:
            commands: at most one per robot.
            now: the moment of the cycle [s].

        Returns:
            Robots whose link is down: closed, or one that has taken nothing for too long.
        """
        self.handed += [(now, command) for command in commands]
        super().send(commands, now)
        return tuple(robot for robot in self._budgets if self._is_down(robot, now))

    def stop(self, now: float) -> None:
        """Send stop to every robot, three times.

        Args:
            now: the moment of the call [s].
        """
        if not self.dead:
            super().stop(now)

    def _free(self, robot_id: RobotId, now: float) -> bool:
        blocked = self._script.on((Kind.BLOCKED,), now, robot_id)
        return blocked is None and super()._free(robot_id, now)

    def _is_down(self, robot: RobotId, now: float) -> bool:
        blocked = self._script.on((Kind.BLOCKED,), now, robot)
        failed = blocked is not None and now - blocked.begin > WRITE_TIMEOUT
        return failed or self._script.on((Kind.CLOSED,), now, robot) is not None


class Clock(VirtualClock):
    """A clock that jumps while the host does nothing, and stops for good when it is killed."""

    def __init__(self, script: Script, radio: Radio) -> None:
        """Start at zero.

        Args:
            script: what goes wrong.
            radio: is silent after the end.
        """
        super().__init__()
        self._script, self._radio = script, radio

    def wait_until(self, t: float) -> float:
        """Jump to a moment, or over a stall.

        Args:
            t: where to jump [s].

        Returns:
            The slack jumped over [s]; negative, without a jump, if t had passed.

        Raises:
            Killed: if the process does not live to see it.
        """
        if self._script.on((Kind.SIGKILL,), t):
            self._radio.dead = True
            raise Killed
        stall = self._script.on((Kind.STALLED,), t)
        return super().wait_until(stall.end if stall else t)

    def interrupted(self) -> bool:
        """Whether SIGTERM has come.

        Returns:
            True from then on.
        """
        return self._script.on((Kind.SIGTERM,), self.now()) is not None


class Person:
    """Presses the emergency stop, and arms again."""

    def __init__(self, script: Script) -> None:
        """Take the controls.

        Args:
            script: what goes wrong.
        """
        self._script, self._asked, self._again = script, -inf, False

    def orders(self, now: float) -> Orders:
        """What is wanted since the last time.

        Args:
            now: the moment of the cycle [s].

        Returns:
            The orders; where a stop and its arming come together the stop counts, and whoever sees
            that arms again.
        """
        since, self._asked = self._asked, now
        pressed = [fault for fault in self._script.faults if fault.kind is Kind.HALTED]
        halt = any(since < fault.begin <= now for fault in pressed)
        arm = self._again or any(since < fault.end <= now for fault in pressed)
        self._again = halt and arm
        return Orders(halt=halt, arm=arm) if halt or arm else NO_ORDERS

    def close(self) -> None:
        """Let go. Safe to call twice."""
