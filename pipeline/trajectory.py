"""The trajectory as a CSV file: truth, estimates, commands and errors, one row a tick."""

import csv
from collections.abc import Iterator
from math import isnan, nan
from pathlib import Path
from typing import Any

from control.command import RobotId
from control.unicycle import UnicycleState
from datasets.cycle import Moment
from datasets.errors import RecordingError
from pipeline.setup import Setup

STATE = ("x_m", "y_m", "theta_rad", "v_mps", "omega_radps")


class TrajectoryFile:
    """An observer that writes one row per tick; cells nobody knows are empty."""

    def __init__(self, path: Path, setup: Setup) -> None:
        """Create the file and write its header.

        Args:
            path: of the CSV file.
            setup: robots and pairs.

        Raises:
            RecordingError: if the file cannot be created.
        """
        self._robots = setup.formation.robots
        self._pairs = setup.formation.pairs
        try:
            self._file = path.open("w", newline="", encoding="utf-8")
        except OSError as error:
            raise RecordingError(f"{path}: cannot be written ({error.strerror})") from None
        self._rows = csv.writer(self._file)
        self._rows.writerow(self._header())

    def observe(self, moment: Moment) -> None:
        """Write one row.

        Args:
            moment: the cycle.
        """
        cycle = moment.cycle
        row: list[Any] = [moment.tick.t]
        row += self._states({r.robot_id: r.state for r in moment.truth})
        row += self._states({r.robot_id: r.state for r in cycle.robots})
        commands = {c.robot_id: c.twist for c in cycle.commands}
        for robot in self._robots:
            twist = commands.get(robot)
            row += [twist.v, twist.omega] if twist else ["", ""]
        errors = {(pair.leader, pair.follower): pair.error for pair in cycle.pairs}
        for pair in self._pairs:
            error = errors.get((pair.leader, pair.follower), (nan, nan))
            known = error if pair.shape.bearing else error[:1]
            row += ["" if isnan(value) else value for value in known]
        self._rows.writerow(row)

    def close(self) -> None:
        """Finish the file. Safe to call twice."""
        self._file.close()

    def _header(self) -> list[str]:
        names = [
            f"{kind}{r}_{s}" for kind in ("true", "estimate") for r in self._robots for s in STATE
        ]
        names += [f"command{r}_{s}" for r in self._robots for s in ("v_mps", "omega_radps")]
        for pair in self._pairs:
            whose = f"estimate{pair.follower}"
            if pair.shape.bearing is None:  # it follows two
                names += [f"{whose}_from{pair.leader}_distance_error_m"]
            else:
                names += [f"{whose}_distance_error_m", f"{whose}_bearing_error_rad"]
        return ["t_s", *names]

    def _states(self, known: dict[RobotId, UnicycleState]) -> Iterator[Any]:
        for robot in self._robots:
            state = known.get(robot)
            if state is None:
                yield from [""] * len(STATE)
            else:
                yield from (state.x, state.y, state.theta, state.v, state.omega)
