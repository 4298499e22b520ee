"""What tests of real links share: a clock, commands, patience, and a radio that is closed."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

from control.command import Command, RobotId
from control.unicycle import Twist
from pipeline.clock import MonotonicClock
from pipeline.ports import CommandSink
from pipeline.radios.open import RadioSettings, open_radio

CLOCK = MonotonicClock()
DEFAULTS = RadioSettings()


def until(happened: Callable[[], object], patience: float = 5.0) -> bool:
    """Wait for something."""
    end = time.monotonic() + patience
    while not happened() and time.monotonic() < end:
        time.sleep(0.005)
    return bool(happened())


def command(robot_id: RobotId = 1, v: float = 0.1, omega: float = 0.0) -> Command:
    """A command that is valid for 0.1 s."""
    now = CLOCK.now()
    return Command(robot_id, Twist(v, omega), now, now + 0.1)


def kept_sending(sink: CommandSink, seconds: float, *robots: RobotId) -> set[RobotId]:
    """Command robots at 50 Hz for a while.

    Returns:
        Robots that were lost meanwhile.
    """
    lost: set[RobotId] = set()
    end = CLOCK.now() + seconds
    while CLOCK.now() < end:
        lost |= set(sink.send(tuple(command(robot) for robot in robots), CLOCK.now()))
        time.sleep(0.02)
    return lost


@contextmanager
def opened(
    spec: str, *robots: RobotId, settings: RadioSettings = DEFAULTS, patience: float = 5.0
) -> Iterator[CommandSink]:
    """A radio, open while the context lasts."""
    radio = open_radio(spec, CLOCK, replace(settings, patience=patience), robots)
    try:
        yield radio
    finally:
        radio.close()
