"""How a run kept its time: frames, loop, latency and links, in tables a person can act on."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from math import inf, isnan, nan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from datasets.cycle import Moment
from datasets.thinned import Thinned
from pipeline.links import LinkRow, link_advice, link_rows
from pipeline.radios.report import RobotReport

Row = tuple[str, float, float, float]

SLOW = 1.1  # times the period asked for from which frames come too slowly
GAP = 1.5  # times the period from which a frame is missing
LATE = 0.5  # of the command period from which a loop is late


def no_links() -> tuple[RobotReport, ...]:
    """The links of a run without radio.

    Returns:
        Nothing.
    """
    return ()


class _Times:
    """Durations: the greatest, and as many as memory is meant for."""

    def __init__(self) -> None:
        self._kept, self.greatest = Thinned(1), -inf

    def add(self, duration: float) -> None:
        """Take one [s]."""
        self._kept.add((duration,))
        self.greatest = max(self.greatest, duration)

    def kept(self) -> NDArray[np.float64]:
        """Those that were not let go, shape (N,) [s]."""
        return self._kept.table()[:, 0]


@dataclass
class Cadence:
    """An observer that measures when things happen; of very long runs a part that is even in time.

    Attributes:
        fps: that were asked of the camera [1/s].
        period: between two ticks [s].
        say: takes a line of a report that was asked for during the run.
        reports: asks the links how they are doing.
    """

    fps: float
    period: float
    say: Callable[[str], None]
    reports: Callable[[], tuple[RobotReport, ...]] = no_links
    _between: _Times = field(default_factory=_Times)
    _arrivals: _Times = field(default_factory=_Times)
    _ages: _Times = field(default_factory=_Times)
    _work: _Times = field(default_factory=_Times)
    _late: _Times = field(default_factory=_Times)
    _captured: float = nan  # when the last picture was taken [s]
    _asked: Counter[RobotId] = field(default_factory=Counter)
    _driven: float = 0.0  # how long commands came [s]
    _t_driven: float | None = None  # when one came last, if it was in the last cycle [s]

    def observe(self, moment: Moment) -> None:
        """Take note of one cycle.

        Args:
            moment: its inputs, outcome, truth and cost.
        """
        frame = moment.tick.frame
        self._late.add(moment.timing.late)
        if frame is not None and moment.cycle.scene is not None:
            if not isnan(self._captured):
                self._between.add(frame.t_capture - self._captured)
            self._captured = frame.t_capture
            self._ages.add(moment.tick.t - frame.t_capture)
            self._work.add(moment.timing.frame_to_command)
            if frame.t_arrival is not None:
                self._arrivals.add(frame.t_arrival - frame.t_capture)
        self._count_commands(moment)
        if moment.tick.orders.report:
            for line in self.lines():
                self.say(line)

    def close(self) -> None:
        """Release nothing. Safe to call twice."""

    def to_json(self, timed: bool) -> dict[str, Any]:
        """The tables for other programs.

        Args:
            timed: whether the run kept time at all.

        Returns:
            JSON-able rows of "cadence", None if it did not, and of "links".
        """
        names = ("what", "median_ms", "p99_ms", "most_ms")
        rows = [dict(zip(names, row, strict=True)) for row in self.rows()] if timed else None
        return {"cadence": rows, "links": [row.to_json() for row in self.links()]}

    def links(self) -> tuple[LinkRow, ...]:
        """How the links did.

        Returns:
            A row per robot and link that has something to tell.
        """
        return link_rows(self.reports(), self._asked, self._driven)

    def rows(self) -> tuple[Row, ...]:
        """What was measured.

        Returns:
            Name, median, 99th percentile and greatest [ms]; what nobody knows is left out.
        """
        measured = (
            ("between two frames", self._between),
            ("capture to arrival", self._arrivals),
            ("capture to pose and law", self._ages),
            ("frame to command, computing", self._work),
            ("loop later than its beat", self._late),
        )
        return tuple(_row(name, times) for name, times in measured if len(times.kept()))

    def advice(self) -> tuple[str, ...]:
        """What is not as it should be, and what helps.

        Returns:
            One line each; nothing where all is well.
        """
        return tuple(self._advice())

    def lines(self) -> Iterator[str]:
        """The report as plain lines.

        Yields:
            One for each row and link, then the advice.
        """
        for name, middle, high, most in self.rows():
            yield f"{name}: median {middle:.2f} ms, 99 % {high:.2f} ms, most {most:.2f} ms"
        for row in self.links():
            yield f"robot {row.robot_id} on {row.place}: {_rates(row)}"
        yield from self.advice()
        yield from link_advice(self.links())

    def _count_commands(self, moment: Moment) -> None:
        commands, t = moment.cycle.commands, moment.tick.t
        self._asked.update(command.robot_id for command in commands)
        if commands and self._t_driven is not None:
            self._driven += t - self._t_driven
        self._t_driven = t if commands else None

    def _advice(self) -> Iterator[str]:
        between, wanted = self._between.kept(), max(1.0 / self.fps, self.period)
        if len(between) and (usual := float(np.median(between))) > SLOW * wanted:
            yield (
                f"the camera delivers {1.0 / usual:.1f} of {self.fps:g} frames/s: its exposure is "
                "too long, or cable, decoder or network carry no more"
            )
            wanted = usual
        if missing := int((between > GAP * wanted).sum()):
            yield f"{missing} of {len(between)} times a frame was missing between two others"
        late = self._late.kept()
        if len(late) and (high := float(np.percentile(late, 99))) > LATE * self.period:
            yield (
                f"1 % of the cycles begin more than {1e3 * high:.1f} ms late, every "
                f"{1e3 * self.period:g} ms: close other programs, --view none, or a longer "
                "--command-period"
            )
        work = self._work.kept()
        if len(work) and (high := float(np.percentile(work, 99))) > self.period:
            yield (
                f"computing takes up to {1e3 * high:.1f} ms of {1e3 * self.period:g} ms: a smaller "
                "picture, fewer things that look like tags, or a longer --command-period"
            )


def _rates(row: LinkRow) -> str:
    asked, carried, trip = row.asked_per_s, row.carried_per_s, row.round_trip_p50_s
    rate = "no commands" if asked is None else f"{carried:.1f} of {asked:.1f} commands/s carried"
    return rate if trip is None else f"{rate}, round trip {1e3 * trip:.1f} ms"


def _row(name: str, times: _Times) -> Row:
    middle, high = np.percentile(times.kept(), (50, 99)).tolist()
    return name, 1e3 * middle, 1e3 * high, 1e3 * times.greatest
