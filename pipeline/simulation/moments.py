"""A simulated run as observers know runs: moment after moment."""

from collections.abc import Iterator, Sequence

from control.command import Command
from control.relative import relative_state
from control.unicycle import Twist, UnicycleState
from datasets.cycle import Cycle, Moment, PairState, RobotState, Tick, Timing
from datasets.simulation.inputs import Floats
from pipeline.simulation.experiment import Experiment
from pipeline.simulation.runs import Batch
from pipeline.supervisor import DRIVING

_NO_TIME = Timing(0.0, 0.0, 0.0)


def moments_of(experiment: Experiment, batch: Batch) -> Iterator[Moment]:
    """Tell a single run.

    Args:
        experiment: of the run.
        batch: the run alone.

    Yields:
        One moment a tick, without frame and scene.
    """
    setup, (table,) = experiment.setup, batch.drawn.timetables
    states, ahead, commands, _ = (part[0] for part in batch.trace)
    first_seen = table.frames.ticks[0] if len(table.frames) else table.ticks
    for number, phase in enumerate(table.phases):
        t = number * setup.period
        t_effective, t_start = t + setup.radio_delay, None
        if table.mission[number] >= 0:
            t_start = t - int(table.mission[number]) * setup.period
        known = _robots(experiment, ahead[number]) if number >= first_seen else ()
        pairs = _pairs(experiment, known, t_effective - (t if t_start is None else t_start))
        sent = commands[number] if phase in DRIVING else ()
        orders = _commands(experiment, sent, t, t_effective)
        cycle = Cycle(t, t_effective, phase, t_start, None, known, pairs, None, orders)
        yield Moment(Tick(t), cycle, _robots(experiment, states[number]), _NO_TIME)


def _robots(experiment: Experiment, states: Floats) -> tuple[RobotState, ...]:
    ids = experiment.setup.formation.robots
    return tuple(
        RobotState(robot, UnicycleState(*state))
        for robot, state in zip(ids, states.tolist(), strict=True)
    )


def _pairs(
    experiment: Experiment, robots: Sequence[RobotState], t_mission: float
) -> tuple[PairState, ...]:
    poses = {robot.robot_id: robot.state.pose for robot in robots}
    d = experiment.setup.follower.camera_offset
    return tuple(
        PairState(
            pair.leader,
            pair.follower,
            relative_state(poses[pair.leader], poses[pair.follower], d),
            pair.shape.at(t_mission),
        )
        for pair in experiment.setup.formation.pairs
        if poses
    )


def _commands(
    experiment: Experiment, twists: Floats | tuple[()], t: float, t_effective: float
) -> tuple[Command, ...]:
    setup = experiment.setup
    until = t + setup.command_validity
    return tuple(
        Command(robot, Twist(*twist.tolist()), t_effective, until)
        for robot, twist in zip(setup.formation.robots, twists, strict=False)
    )
