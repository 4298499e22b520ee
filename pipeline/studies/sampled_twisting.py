"""Where the law as published, (27) with (31), works: the paper's formation over the period.

The robots and shapes of the scenario `paper` behind a leader that drives straight on, without
model errors and with ideal measurements at every command. No camera: what fails here is the law.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from control.follower import FollowerMemory, FollowerSample
from control.formation import Pair
from control.laws import Law
from control.output import LeaderMotion, output_error, pair_output, wanted_output
from control.relative import Vector2, relative_state
from control.sliding import begin, follower_step
from control.unicycle import UnicycleState, advance_lagged
from pipeline.report.style import LEADER, new_figure
from pipeline.scenario import load_scenario
from pipeline.setup import Setup, make_setup
from pipeline.studies.drawing import draw_curve, law_color, legend_below, logarithmic, period_axis
from pipeline.studies.study import Progress, Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_AT_REST: Vector2 = (0.0, 0.0)
_LENGTH_MM = 75.0  # of a robot: one that is so far from its place is lost
_PARTS = 4  # in which a robot drives a period


@dataclass(frozen=True, slots=True)
class _Case:
    """A law, and whether it cancels what the follower's own velocities do to h''."""

    name: str
    law: Law
    own: bool


_CASES = (
    _Case("as published, (27) and (31)", Law.SAMPLED_TWISTING, False),
    _Case("sampled-twisting", Law.SAMPLED_TWISTING, True),
    _Case("implicit-twisting", Law.IMPLICIT_TWISTING, True),
)


@dataclass(frozen=True, slots=True)
class SampledTwisting:
    """Largest errors of the worst follower at the end of 8 s.

    Attributes:
        periods: sampling periods [ms].
        settled: when the formation should stand again after its change at 5.5 s; errors count from
            then on [s].
    """

    periods: tuple[float, ...] = (1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 12.0, 15.0, 20.0, 30.0, 45.0, 60.0)
    settled: float = 7.0
    name: str = "sampled-twisting"
    summary: str = "where the published law holds the paper's formation, over the period"

    def run(self, progress: Progress) -> Result:
        """Drive with each law at each period.

        Args:
            progress: is told the share that is done.

        Returns:
            Errors, one row a law and period.
        """
        errors: dict[tuple[_Case, float], tuple[float, float]] = {}
        for period in self.periods:
            for case in _CASES:
                progress(len(errors) / (len(self.periods) * len(_CASES)))
                distance, bearing = _largest_errors(case, 1e-3 * period, self.settled)
                errors[case, period] = 1e3 * distance, degrees(bearing)
        header = "law", "period_ms", "largest_distance_error_mm", "largest_bearing_error_deg"
        rows = tuple((case.name, period, *both) for (case, period), both in errors.items())
        return Result(header, rows, lambda: _figure(errors, self.periods))


def _largest_errors(case: _Case, period: float, since: float) -> tuple[float, float]:
    """Of distance [m] and bearing [rad], of any follower from a time on."""
    straight = "leader.segments=[{straight_m = 9.0}]"
    changes = f"control.law={case.law.title}", f"control.command_period_s={period}", straight
    setup = make_setup(load_scenario("paper", changes))
    errors = [_follow(setup, pair, case, period) for pair in setup.formation.pairs]
    distance, bearing = np.abs(errors)[:, round(since / period) :].max(axis=(0, 1))
    return float(distance), float(bearing)


def _follow(setup: Setup, pair: Pair, case: _Case, period: float) -> list[Vector2]:
    """Errors of a follower at its samples, (11)."""
    model, gains, start = setup.follower, setup.gains[pair.follower], setup.starts[pair.follower]
    state = UnicycleState(start.x, start.y, start.theta, 0.0, 0.0)
    memory: FollowerMemory | None = None
    errors = []
    assert setup.path, "the paper's scenario has a plan"
    for i in range(round(setup.duration / period)):
        leader = setup.path.at(i * period).state
        relative = relative_state(leader.pose, state.pose, model.camera_offset)
        motion = LeaderMotion(leader.twist, _AT_REST)
        output = pair_output(relative, state.twist, motion, model.camera_offset)
        output = output if case.own else replace(output, own=_AT_REST)
        wanted = wanted_output([pair.shape.at(i * period)])
        memory = memory or begin(output, wanted, _AT_REST, gains)
        sample = FollowerSample(output, wanted, state.twist)
        memory, command = follower_step(memory, sample, period, gains, model)
        for _ in range(_PARTS):
            state = advance_lagged(state, command, period / _PARTS, model.actuation.lag)
        errors.append(output_error(output, wanted))
    return errors


def _figure(
    errors: Mapping[tuple[_Case, float], tuple[float, float]], periods: Sequence[float]
) -> "Figure":
    """Distance above, bearing below."""
    figure, plots = new_figure(5.6, 2)
    distance, bearing = plots
    for column, axes in enumerate(plots):
        for case, mark in zip(_CASES, "sv^", strict=True):
            curve = [errors[case, period][column] for period in periods]
            color = law_color(case.law) if case.own else LEADER
            draw_curve(axes, periods, curve, (f"{mark}-", color, case.name))
        logarithmic(axes, "y")
    top = max(distance.get_ylim()[1], 3.0 * _LENGTH_MM)
    distance.axhspan(_LENGTH_MM, top, color="#eef1f5", lw=0, zorder=0.5)
    distance.set_ylim(top=top)
    lost = "lost: a robot's length off its place"
    distance.text(periods[0], 1.15 * _LENGTH_MM, lost, fontsize=8.5, color="#5a6068")
    distance.set_title("leader straight on at 0.5 m/s, K = 2, L = 1, μ = 20, ν = 4")
    distance.set_ylabel("largest distance error  [mm]")
    bearing.set_ylabel("largest bearing error  [deg]")
    period_axis(bearing, periods)
    legend_below(figure)
    return figure
