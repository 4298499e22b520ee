"""From a scenario to the tables of a batch of runs: what is the same in all of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, inf, radians

import numpy as np

from control.follower import SlidingGains
from control.formation import Pair, by_follower
from control.output import wanted_output
from control.plan import Plan
from control.safety import Clearance
from datasets.scores import planned_before
from datasets.simulation.inputs import MOST_GAINS, Field, Floats, Gains, Goals, Host, Integers
from datasets.world import RobotPlant
from pipeline.config import Scenario
from pipeline.errors import ConfigError
from pipeline.restraint import FOLLOWER_FREEDOM, LEADER_FREEDOM
from pipeline.rigs import make_world
from pipeline.seeing import Seeing
from pipeline.setup import Setup, make_setup

PATIENCE = 10.0
"""How much longer than its mission a run may take, as robots may have to wait [s]."""


@dataclass(frozen=True, slots=True)
class Experiment:
    """A scenario for machine code.

    Attributes:
        scenario: as it was checked.
        setup: of the same scenario.
        plants: the robots of the formation as they really are, leaders first.
        host: what the host knows and wants.
        gains: the followers' laws and gains.
        field: robots and references.
        goals: what runs are judged by.
        ticks: of a run at most.
    """

    scenario: Scenario
    setup: Setup
    plants: tuple[RobotPlant, ...]
    host: Host
    gains: Gains
    field: Field
    goals: Goals
    ticks: int

    @property
    def pose_std(self) -> Floats:
        """Standard deviations of measured poses, (3,) [m, m, rad]."""
        return _pose_std(self.scenario)


def make_experiment(
    scenario: Scenario, duration: float | None = None, seeing: Seeing | None = None
) -> Experiment:
    """Tabulate a scenario.

    Args:
        scenario: checked scenario.
        duration: a run ends after this; None: when its mission is finished [s].
        seeing: of a scenario with the same camera, tags and colours, where there is one.

    Returns:
        The experiment.

    Raises:
        ConfigError: if the scenario is inconsistent, a robot has no start, or the followers' gains
            are of more kinds than fit.
    """
    setup = make_setup(scenario, seeing)
    path = _plan_of(scenario, setup)
    everybody = {plant.robot_id: plant for plant in make_world(scenario).plants}
    plants = tuple(everybody[robot] for robot in setup.formation.robots)
    last = duration if duration is not None else setup.duration + PATIENCE
    kinds = tuple(dict.fromkeys(setup.gains[robot] for robot in setup.formation.robots))
    host = Host(
        setup.period, setup.radio_delay, setup.follower, setup.leader_gains, setup.motion,
        setup.free_motion, setup.clearance or Clearance(), setup.arena,
    )  # fmt: skip
    field = _field(scenario, setup, path, plants, kinds)
    ticks = ceil(last / setup.period - 1e-9)
    return Experiment(
        scenario, setup, plants, host, _gains(setup, kinds), field, _goals(setup, path), ticks
    )


def _plan_of(scenario: Scenario, setup: Setup) -> Plan:
    carried = [robot.id for robot in scenario.robots if robot.carried]
    if setup.path is not None and not (carried or setup.worn or setup.rules.hold):
        return setup.path
    who = f"robot {carried[0]} is carried" if carried else "a person drives the leader"
    who = "the leader plans anew where obstacles move" if setup.worn else who
    who = "a person must arm it (safety.hold)" if setup.rules.hold else who
    raise ConfigError(
        f"scenario {setup.name}: {who}, and simulate knows laws and plans only; run it with "
        "echelon live"
    )


def _gains(setup: Setup, kinds: Sequence[SlidingGains]) -> Gains:
    if len(kinds) > MOST_GAINS:
        raise ConfigError(
            f"scenario {setup.name}: {len(kinds)} kinds of followers' gains, simulate takes "
            f"{MOST_GAINS}: let some robots have the same law and gains"
        )
    a, b, c, d, e, f, g, h = (*kinds, *(kinds[0],) * (MOST_GAINS - len(kinds)))
    return a, b, c, d, e, f, g, h


def _field(
    scenario: Scenario,
    setup: Setup,
    path: Plan,
    plants: Sequence[RobotPlant],
    kinds: Sequence[SlidingGains],
) -> Field:
    robots = setup.formation.robots
    measured = np.diag(_pose_std(scenario) ** 2)
    return Field(
        starts=np.array([_start(plant) for plant in plants]),
        plants=np.array([_plant(plant) for plant in plants]),
        leaders=_leaders(setup),
        gains=np.array([kinds.index(setup.gains[robot]) for robot in robots]),
        told=np.full(len(robots), setup.leader_commands_known),
        freedoms=_freedoms(setup),
        planned=_planned(setup, path),
        wanted=_wanted(setup),
        pose_noise=np.stack((measured, measured + setup.pose_noise)),
    )


def _freedoms(setup: Setup) -> Floats:
    followers = (FOLLOWER_FREEDOM,) * (len(setup.formation.robots) - 1)
    return np.array((LEADER_FREEDOM, *followers)) * (setup.clearance is not None)


def _goals(setup: Setup, path: Plan) -> Goals:
    groups = by_follower(setup.formation.pairs)
    times = _times(setup)
    wanted = np.full((len(times), len(setup.formation.robots), 2, 2), np.nan)
    settles_by = np.full(len(setup.formation.robots), inf)
    for robot, pairs in enumerate(groups.values(), 1):
        for which, pair in enumerate(pairs):
            shapes = [pair.shape.at(t) for t in times]
            wanted[:, robot, which] = [(shape.distance, shape.bearing) for shape in shapes]
        changes = [t for pair in pairs for t in pair.shape.changes]
        settles_by[robot] = min((t for t in changes if t > 0.0), default=inf)
    delay = setup.radio_delay
    poses = [planned_before(path.at(t + delay).state, delay) for t in times]
    planned = np.array([(pose.x, pose.y) for pose in poses])
    d, side = setup.follower.camera_offset, setup.tags.tags[0].side
    return Goals(setup.period, planned, wanted, _leaders(setup), settles_by, d, side)


def _times(setup: Setup) -> list[float]:
    """Of the ticks of the mission [s]."""
    return [tick * setup.period for tick in range(ceil(setup.duration / setup.period) + 2)]


def _leaders(setup: Setup) -> Integers:
    robots = setup.formation.robots
    leaders = np.full((len(robots), 2), -1)
    for robot, pairs in enumerate(by_follower(setup.formation.pairs).values(), 1):
        leaders[robot, : len(pairs)] = [robots.index(pair.leader) for pair in pairs]
    return leaders


def _planned(setup: Setup, path: Plan) -> Floats:
    """The leader's plan when commands take effect, (M, 7)."""
    rows = [path.at(t + setup.radio_delay) for t in _times(setup)]
    return np.array([
        (p.state.x, p.state.y, p.state.theta, p.state.v, p.state.omega, p.v_rate, p.omega_rate)
        for p in rows
    ])  # fmt: skip


def _wanted(setup: Setup) -> Floats:
    """The followers' references when commands take effect, (M, R, 6)."""
    groups = by_follower(setup.formation.pairs)
    wanted = np.zeros((len(_times(setup)), 1 + len(groups), 6))
    for row, t in enumerate(_times(setup)):
        for robot, pairs in enumerate(groups.values(), 1):
            wanted[row, robot] = _reference(pairs, t + setup.radio_delay)
    return wanted


def _reference(pairs: Sequence[Pair], t: float) -> tuple[float, ...]:
    wanted = wanted_output([pair.shape.at(t) for pair in pairs])
    return (*wanted.h, *wanted.rate, *wanted.acceleration)


def _start(plant: RobotPlant) -> tuple[float, ...]:
    s = plant.start
    return s.x, s.y, s.theta, s.v, s.omega


def _plant(plant: RobotPlant) -> tuple[float, ...]:
    most, push = plant.limits, plant.disturbance
    return (
        plant.lag, plant.mass_error, plant.inertia_error, most.v, most.omega, push.v, push.omega
    )  # fmt: skip


def _pose_std(scenario: Scenario) -> Floats:
    s = scenario.simulation
    return np.array((s.position_std_m, s.position_std_m, radians(s.heading_std_deg)))
