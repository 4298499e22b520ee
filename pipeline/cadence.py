"""How a run kept its time: frames, loop, latency and links, in tables a person can act on."""

from array import array
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from datasets.cycle import Moment
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


def _numbers() -> "array[float]":
    return array("d")


@dataclass
class Cadence:
    """An observer that measures when things happen.

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
    _captures: "array[float]" = field(default_factory=_numbers)
    _arrivals: "array[float]" = field(default_factory=_numbers)
    _ages: "array[float]" = field(default_factory=_numbers)
    _work: "array[float]" = field(default_factory=_numbers)
    _late: "array[float]" = field(default_factory=_numbers)
    _asked: Counter[RobotId] = field(default_factory=Counter)
    _driven: float = 0.0  # how long commands came [s]
    _t_driven: float | None = None  # when one came last, if it was in the last cycle [s]

    def observe(self, moment: Moment) -> None:
        """Take note of one cycle.

        Args:
            moment: its inputs, outcome, truth and cost.
        """
        frame = moment.tick.frame
        self._late.append(moment.timing.late)
        if frame is not None and moment.cycle.scene is not None:
            self._captures.append(frame.t_capture)
            self._ages.append(moment.tick.t - frame.t_capture)
            self._work.append(moment.timing.frame_to_command)
            if frame.t_arrival is not None:
                self._arrivals.append(frame.t_arrival - frame.t_capture)
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
            ("between two frames", np.diff(_array(self._captures))),
            ("capture to arrival", _array(self._arrivals)),
            ("capture to pose and law", _array(self._ages)),
            ("frame to command, computing", _array(self._work)),
            ("loop later than its beat", _array(self._late)),
        )
        return tuple(_row(name, values) for name, values in measured if len(values))

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
        between, wanted = np.diff(_array(self._captures)), max(1.0 / self.fps, self.period)
        if len(between) and (usual := float(np.median(between))) > SLOW * wanted:
            yield (
                f"the camera delivers {1.0 / usual:.1f} of {self.fps:g} frames/s: its exposure is "
                "too long, or cable, decoder or network carry no more"
            )
            wanted = usual
        if missing := int((between > GAP * wanted).sum()):
            yield f"{missing} of {len(between)} times a frame was missing between two others"
        late = _array(self._late)
        if len(late) and (high := float(np.percentile(late, 99))) > LATE * self.period:
            yield (
                f"1 % of the cycles begin more than {1e3 * high:.1f} ms late, every "
                f"{1e3 * self.period:g} ms: close other programs, --view none, or a longer "
                "--command-period"
            )
        work = _array(self._work)
        if len(work) and (high := float(np.percentile(work, 99))) > self.period:
            yield (
                f"computing takes up to {1e3 * high:.1f} ms of {1e3 * self.period:g} ms: a smaller "
                "picture, fewer things that look like tags, or a longer --command-period"
            )


def _array(numbers: "array[float]") -> NDArray[np.float64]:
    return np.array(numbers, dtype=np.float64)


def _rates(row: LinkRow) -> str:
    asked, carried, trip = row.asked_per_s, row.carried_per_s, row.round_trip_p50_s
    rate = "no commands" if asked is None else f"{carried:.1f} of {asked:.1f} commands/s carried"
    return rate if trip is None else f"{rate}, round trip {1e3 * trip:.1f} ms"


def _row(name: str, values: NDArray[np.float64]) -> Row:
    middle, high = np.percentile(values, (50, 99)).tolist()
    return name, 1e3 * middle, 1e3 * high, 1e3 * float(values.max())
