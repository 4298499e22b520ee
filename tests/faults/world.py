"""The world outside the program, with faults: they act on what it sees, says and hears."""

import random
from collections.abc import Callable, Sequence
from math import hypot, pi
from typing import cast

from control.command import Command, RobotId
from control.geometry import Pose2D
from datasets.cycle import NO_ORDERS, Orders, RobotState
from datasets.world import World
from pipeline.clock import VirtualClock
from pipeline.config import Scenario
from pipeline.ports import CommandSink, FrameSource
from pipeline.rigs import make_rendered_camera, make_world
from tests.faults.schedule import Fault
from vision.frame import Frame, as_frame

AWAY = 0.12  # within which a robot is put down again [m]
ROOM = 0.13  # between its middle and those of others [m]
TRIES = 50


class Killed(BaseException):
    """The program is gone, without a word."""


class Floor:
    """The robots, and who of them can be seen from above."""

    def __init__(self, scenario: Scenario, faults: Sequence[Fault], seed: int) -> None:
        """Put the robots on the floor.

        Args:
            scenario: of the run.
            faults: what will go wrong.
            seed: of the disturbances, and of where robots are put down.
        """
        self.world, self._faults = make_world(scenario, seed), faults
        self._rng, self._lifted = random.Random(seed), set[RobotId]()
        x0, y0 = scenario.camera.center_m
        reach = 0.5 * scenario.camera.field_width_m
        tall = reach * scenario.camera.height_px / scenario.camera.width_px
        self._field = (x0 - reach + AWAY, y0 - tall + AWAY, x0 + reach - AWAY, y0 + tall - AWAY)

    @property
    def lifted(self) -> frozenset[RobotId]:
        """Robots that are in somebody's hand."""
        return frozenset(self._lifted)

    def advance(self, t: float) -> None:
        """Let time pass; who was taken away is put down when its time has come."""
        self.world.advance(t)
        taken = {f.robot for f in self._faults if f.kind == "robot taken away" and f.lasts(t)}
        for robot in sorted(self._lifted - taken, key=str):
            self._put_down(robot)
        self._lifted = {robot for robot in taken if robot is not None}

    def states(self, t: float) -> tuple[RobotState, ...]:
        """What the camera can see of the robots at a moment [s]."""
        hiding = ("robot covered", "robot taken away")
        hidden = {f.robot for f in self._faults if f.kind in hiding and f.lasts(t)}
        return tuple(s for s in self.world.states(t) if s.robot_id not in hidden)

    def truth(self) -> tuple[RobotState, ...]:
        """Where all robots are now."""
        return self.world.truth()

    def _put_down(self, robot: RobotId) -> None:
        """Near where it was taken, turned, not upon another one."""
        states = {s.robot_id: s.state for s in self.world.truth()}
        own, low_x, low_y, high_x, high_y = states.pop(robot), *self._field
        for _ in range(TRIES):
            x = own.x + self._rng.uniform(-AWAY, AWAY)
            y = own.y + self._rng.uniform(-AWAY, AWAY)
            far = all(hypot(x - s.x, y - s.y) > ROOM for s in states.values())
            if far and low_x < x < high_x and low_y < y < high_y:
                theta = own.theta + self._rng.uniform(-pi, pi)
                self.world.put_down(robot, Pose2D(x, y, theta))
                return
        self.world.put_down(robot, own.pose)


class FaultyCamera:
    """A camera that is unplugged, hangs, or has its clock stepped."""

    def __init__(
        self, scenario: Scenario, floor: Floor, faults: Sequence[Fault], seed: int
    ) -> None:
        """Look at the floor.

        Args:
            scenario: of the run.
            floor: what is seen.
            faults: what will go wrong.
            seed: of the pictures.
        """
        world = cast(World, floor)  # as far as a camera is concerned
        self._inner: FrameSource = make_rendered_camera(scenario, world, seed)
        self._faults = faults
        self._last: Frame | None = None

    def latest(self, now: float) -> Frame | None:
        """The newest frame, if one comes through."""
        frame = self._inner.latest(now)
        lasting = {f.kind: f for f in self._faults if f.lasts(now)}
        if frame is None or "camera unplugged" in lasting:
            return None
        if "camera frozen" in lasting and self._last is not None:
            return as_frame(self._last.image, frame.t_capture, frame.sequence, frame.camera_id)
        self._last = frame
        if stepped := lasting.get("camera's clock stepped"):
            t = frame.t_capture + stepped.amount
            return as_frame(frame.image, t, frame.sequence, frame.camera_id)
        return frame

    def close(self) -> None:
        """Close the camera."""
        self._inner.close()


class FaultyRadio:
    """Links that close, which is known, or block, which is not."""

    min_period = 0.0

    def __init__(self, inner: CommandSink, faults: Sequence[Fault]) -> None:
        """Wrap a radio.

        Args:
            inner: reaches the robots.
            faults: what will go wrong.
        """
        self._inner, self._faults = inner, faults
        self.sent: list[Command] = []
        self.stops, self.dead = 0, False

    def send(self, commands: tuple[Command, ...], now: float) -> tuple[RobotId, ...]:
        """Send what comes through; who is not reached, as far as anybody knows."""
        self.sent = list(commands)
        closed, blocked = (
            {f.robot for f in self._faults if f.kind == kind and f.lasts(now)}
            for kind in ("port closed", "port blocked")
        )
        through = tuple(c for c in commands if c.robot_id not in closed | blocked)
        down = tuple(robot for robot in closed if robot is not None)
        return (*self._inner.send(through, now), *down)

    def stop(self, now: float) -> None:
        """Stop all, unless the program is gone."""
        if not self.dead:
            self.stops += 1
            self._inner.stop(now)

    def close(self) -> None:
        """Close the radio."""
        self._inner.close()


class FaultyClock(VirtualClock):
    """The host stalls: from one tick to the next a second passes."""

    def __init__(self, faults: Sequence[Fault], die: Callable[[], None]) -> None:
        """Start at zero.

        Args:
            faults: what will go wrong.
            die: is called when the program is killed.
        """
        super().__init__()
        self._stalls = [f for f in faults if f.kind == "host stalled"]
        self._kill = min((f.begins for f in faults if f.kind == "SIGKILL"), default=float("inf"))
        self._die = die

    def wait_until(self, t: float) -> float:
        """Jump to a moment, or far beyond it."""
        slack = super().wait_until(t)
        if self.now() >= self._kill:
            self._die()
            raise Killed
        if self._stalls and self.now() >= self._stalls[0].begins:
            super().wait_until(self._stalls.pop(0).ends)
        return slack


class FaultyOperator:
    """Somebody who stops all in an emergency, and arms them again later."""

    def __init__(self, faults: Sequence[Fault]) -> None:
        """Stand by.

        Args:
            faults: what will go wrong.
        """
        stops = [f for f in faults if f.kind == "emergency stop"]
        self._halts = sorted(f.begins for f in stops)
        self._arms = sorted(f.ends for f in stops)

    def orders(self, now: float) -> Orders:
        """What is wanted now."""
        halt, arm = (bool(times and now >= times[0]) for times in (self._halts, self._arms))
        for times, due in ((self._halts, halt), (self._arms, arm)):
            if due:
                times.pop(0)
        return Orders(halt=halt, arm=arm) if halt or arm else NO_ORDERS

    def close(self) -> None:
        """Go home."""
