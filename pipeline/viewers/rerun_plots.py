"""Moments as Rerun's curves and log lines."""

from math import degrees, isfinite
from typing import TYPE_CHECKING

from datasets.cycle import Moment
from pipeline.viewers.rerun_scene import Color, dim
from pipeline.viewers.stage import Stage, name_of

if TYPE_CHECKING:
    import rerun

_VISION = (120, 200, 255)
_STEP = (255, 200, 90)
_AGE = (170, 170, 185)


class RerunPlots:
    """Draws errors, commands and latency, and logs events, into one recording."""

    def __init__(self, recording: "rerun.RecordingStream", stage: Stage) -> None:
        """Start with empty curves.

        Args:
            recording: where to.
            stage: gives the robots' colours.
        """
        self._out = recording
        self._stage = stage
        self._known: set[str] = set()
        self._phase = ""

    def draw(self, moment: Moment) -> None:
        """Draw one moment at the recording's present time.

        Args:
            moment: inputs, outcome, truth and cost of a cycle.
        """
        self._draw_errors(moment)
        self._draw_motion(moment)
        self._draw_latency(moment)
        self._tell(moment)

    def _draw_errors(self, moment: Moment) -> None:
        for pair in moment.cycle.pairs:
            name, color = name_of(pair.follower), self._stage.color(pair.follower)
            error = pair.error  # (11)
            if isfinite(error[1]):
                self._point("bearing_error", name, color, degrees(error[1]))
            else:  # it follows two
                name = f"{name} from {name_of(pair.leader)}"
            self._point("distance_error", name, color, 1e3 * error[0])

    def _draw_motion(self, moment: Moment) -> None:
        """What each robot is commanded, dim, and what it is thought to do, bright."""
        for command in moment.cycle.commands:
            name, color = name_of(command.robot_id), self._stage.color(command.robot_id)
            twist, faint = command.twist, dim(color, 0.4)
            self._point("speed", f"{name} command", faint, twist.v, width=1.0)
            self._point("turn_rate", f"{name} command", faint, twist.omega, width=1.0)
        for robot in moment.cycle.robots:
            name, color = name_of(robot.robot_id), self._stage.color(robot.robot_id)
            self._point("speed", name, color, robot.state.v)
            self._point("turn_rate", name, color, robot.state.omega)

    def _draw_latency(self, moment: Moment) -> None:
        self._point("latency", "whole cycle", _STEP, 1e3 * moment.timing.step)
        if moment.cycle.scene is not None:
            self._point("latency", "vision", _VISION, 1e3 * moment.timing.vision)
            age = moment.cycle.t_effective - moment.cycle.scene.t_capture
            self._point("latency", "picture to wheels", _AGE, 1e3 * age)

    def _point(self, plot: str, name: str, color: Color, value: float, width: float = 1.8) -> None:
        import rerun as rr

        path = f"plots/{plot}/{name}".replace(" ", "_")
        if path not in self._known:
            self._known.add(path)
            self._out.log(path, rr.SeriesLines(names=name, colors=color, widths=width), static=True)
        self._out.log(path, rr.Scalars(value))

    def _tell(self, moment: Moment) -> None:
        """Changes of phase, and what the safety rules did."""
        import rerun as rr

        if moment.cycle.phase != self._phase:
            self._phase = moment.cycle.phase
            self._out.log("events", rr.TextLog(self._phase, level="INFO"))
        for event in moment.cycle.events:
            who = "" if event.robot_id is None else f" {name_of(event.robot_id)}"
            text = f"{event.kind}{who}: {event.detail}"
            self._out.log("events", rr.TextLog(text, level="WARN"))
