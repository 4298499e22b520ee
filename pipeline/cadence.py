"""How a run kept its time: frames, loop and latency, in a table that a person can act on."""

from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from datasets.cycle import Moment

Row = tuple[str, float, float, float]

SLOW = 1.1  # times the period asked for from which frames come too slowly
GAP = 1.5  # times the period from which a frame is missing
LATE = 0.5  # of the command period from which a loop is late


def _numbers() -> "array[float]":
    return array("d")


@dataclass
class Cadence:
    """An observer that measures when things happen.

    Attributes:
        fps: that were asked of the camera [1/s].
        period: between two ticks [s].
        say: takes a line of a report that was asked for during the run.
    """

    fps: float
    period: float
    say: Callable[[str], None]
    _captures: "array[float]" = field(default_factory=_numbers)
    _arrivals: "array[float]" = field(default_factory=_numbers)
    _ages: "array[float]" = field(default_factory=_numbers)
    _work: "array[float]" = field(default_factory=_numbers)
    _late: "array[float]" = field(default_factory=_numbers)

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
        if moment.tick.orders.report:
            for line in self.lines():
                self.say(line)

    def close(self) -> None:
        """Release nothing. Safe to call twice."""

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
            One for each row, then the advice.
        """
        for name, middle, high, most in self.rows():
            yield f"{name}: median {middle:.2f} ms, 99 % {high:.2f} ms, most {most:.2f} ms"
        yield from self.advice()

    def _advice(self) -> Iterator[str]:
        between, wanted = np.diff(_array(self._captures)), 1.0 / self.fps
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


def _row(name: str, values: NDArray[np.float64]) -> Row:
    middle, high = np.percentile(values, (50, 99)).tolist()
    return name, 1e3 * middle, 1e3 * high, 1e3 * float(values.max())
