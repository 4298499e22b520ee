"""From a scenario to the objects of a run: everything that stays constant while it runs."""

from collections.abc import Mapping
from dataclasses import dataclass

from control.actuation import Actuation
from control.channel import ChannelGains
from control.command import RobotId
from control.errors import ControlError
from control.follower import FollowerModel, SlidingGains
from control.formation import Formation
from control.keyed import KeyDrive
from control.laws import law_named, leader_law_named
from control.leader import LeaderGains
from control.obstacles import Obstacle
from control.plan import Plan
from control.plan_request import PlanRequest
from control.reaching import ReachingGains
from control.safety import Arena, Clearance
from control.twisting import TwistingGains
from control.unicycle import SpeedLimits
from datasets.truth import Scores
from pipeline.config import ControlConfig, Scenario
from pipeline.course import make_errand, make_path, worn_obstacles
from pipeline.errors import ConfigError
from pipeline.formation_config import FormationConfig
from pipeline.leader_config import LeaderConfig
from pipeline.lookout import Lookout, believed_lag, make_lookout
from pipeline.seeing import Seeing, make_seeing
from pipeline.shaping import make_formation

SHORT_HORIZON, LONG_HORIZON = 0.05, 0.1  # of the implicit twisting law [s]
RESERVE = 0.002  # of the clearance, for what poses and motors are off by [m]
SHORT_PERIOD = 0.02  # up to which the short horizon is right [s]


@dataclass(frozen=True, slots=True)
class Setup(Lookout):
    """All that is constant in a run; what is needed for looking comes from `Lookout`.

    Attributes:
        name: of the scenario.
        formation: who follows whom, in which shape.
        path: the leader's plan; None: a person moves it.
        keys: how a person drives it by keys; None: not so. Without path and keys a hand carries it.
        errand: what is asked of the planner, with obstacles where they are at the mission's start;
            None without a goal.
        worn: radius of the obstacle about each robot that is one, wherever it is seen [m].
        gains: law and gains by follower.
        follower: a follower's geometry and motors.
        leader_gains: of the leader's law.
        leader_commands_known: whether followers are told the accelerations their leaders are
            commanded; the paper tells them nothing.
        clearance: how far bodies are kept apart; None: they are not.
        arena: what no body may leave.
        period: between two ticks [s].
        radio_delay: from sending a command to its effect [s].
        command_validity: a command older than this is never sent [s].
        watch_time: how long moving robots are watched before the start; 0: they rest [s].
        duration: of the mission [s].
    """

    name: str
    formation: Formation
    path: Plan | None
    keys: KeyDrive | None
    errand: PlanRequest | None
    worn: Mapping[RobotId, float]
    gains: Mapping[RobotId, SlidingGains]
    follower: FollowerModel
    leader_gains: LeaderGains
    leader_commands_known: bool
    clearance: Clearance | None
    arena: Arena
    period: float
    radio_delay: float
    command_validity: float
    watch_time: float
    duration: float


def make_setup(scenario: Scenario, seeing: Seeing | None = None) -> Setup:
    """Build all that is constant in a run.

    Args:
        scenario: checked scenario.
        seeing: of a scenario with the same camera, tags and colours, where there is one.

    Returns:
        The setup.

    Raises:
        ConfigError: if the formation, the path, the tags or the camera are inconsistent, or a
            section that driving needs is missing.
    """
    formation, leader = _course(scenario)
    try:
        return _setup(scenario, seeing or make_seeing(scenario), formation, leader)
    except ControlError as error:
        raise ConfigError(f"scenario {scenario.name}: {error}") from None


def is_undriven(scenario: Scenario) -> bool:
    """Whether a scenario says nothing of driving: for looking and rendering only.

    Args:
        scenario: checked scenario.

    Returns:
        True if it has neither a formation nor a leader's path.
    """
    return scenario.formation is None and scenario.leader is None


def make_scores(setup: Setup) -> Scores:
    """An observer that scores a run.

    Args:
        setup: of the run.

    Returns:
        Scores without any cycle yet.
    """
    offset, side = setup.follower.camera_offset, setup.tags.tags[0].side
    driven = setup.formation.robots
    others = tuple(robot for robot in setup.tags.ids if robot not in driven)
    return Scores(setup.formation, offset, setup.camera, side, others)


def _course(scenario: Scenario) -> tuple[FormationConfig, LeaderConfig]:
    """The sections that driving needs and looking does not."""
    if scenario.formation is None or scenario.leader is None:
        section = "formation" if scenario.formation is None else "leader"
        raise ConfigError(
            f"scenario {scenario.name}: missing section [{section}]: without it robots can be "
            "located and rendered, but not driven"
        )
    return scenario.formation, scenario.leader


def _setup(
    scenario: Scenario, seeing: Seeing, formation: FormationConfig, leader: LeaderConfig
) -> Setup:
    period, side = scenario.control.command_period_s, seeing.tags.tags[0].side
    pairs = make_formation(scenario, formation)
    arena = Arena(*scenario.safety.arena_m) if scenario.safety.arena_m else Arena()
    resting = scenario.startup.initial_rates == "rest"
    lookout, worn = make_lookout(scenario, seeing), worn_obstacles(scenario)
    errand = make_errand(scenario, leader, pairs, arena, side)
    standing = (Obstacle(p.x, p.y, worn[r]) for r, p in lookout.starts.items() if r in worn)
    return Setup(
        seeing=lookout.seeing,
        motion=lookout.motion,
        free_motion=lookout.free_motion,
        pose_noise=lookout.pose_noise,
        rules=lookout.rules,
        starts=lookout.starts,
        name=scenario.name,
        formation=pairs,
        path=make_path(leader, errand, standing),
        keys=_keys(leader),
        errand=errand,
        worn=worn,
        gains=_gains(scenario, period),
        follower=_follower(scenario),
        leader_gains=_leader_gains(leader),
        leader_commands_known=scenario.control.leader_commands_known,
        clearance=_clearance(scenario, seeing.tags.tags[0].side),
        arena=arena,
        period=period,
        radio_delay=scenario.radio.delay_s,
        command_validity=max(2.0 * period, 0.1),
        watch_time=0.0 if resting else scenario.startup.watch_s,
        duration=scenario.duration_s,
    )


def _gains(scenario: Scenario, period: float) -> Mapping[RobotId, SlidingGains]:
    """Law and gains of every robot; a robot's own law comes before the scenario's."""
    c = scenario.control
    horizon = c.horizon_s or (SHORT_HORIZON if period <= SHORT_PERIOD else LONG_HORIZON)
    (k1, k2), (l1, l2) = c.proportional, c.integral
    channels = ChannelGains(k1, l1), ChannelGains(k2, l2)
    twisting = TwistingGains(c.mu, c.nu, horizon)
    return {
        robot.id: SlidingGains(law_named(robot.law or c.law), *channels, twisting, _reaching(c))
        for robot in scenario.robots
    }


def _reaching(c: ControlConfig) -> ReachingGains:
    disturbance = c.disturbance_mps2, c.turn_disturbance_radps2
    return ReachingGains(
        c.reaching_margin_mps2, c.model_error, disturbance, c.layer_mps, c.lipschitz_mps3
    )


def _follower(scenario: Scenario) -> FollowerModel:
    c = scenario.control
    limits = SpeedLimits(c.speed_limit_mps, c.turn_limit_radps)
    return FollowerModel(c.camera_offset_m, Actuation(believed_lag(scenario), limits))


def _leader_gains(config: LeaderConfig) -> LeaderGains:
    return LeaderGains(
        config.proportional, config.integral, config.reaching_mps2,
        point_offset=config.point_offset_m, law=leader_law_named(config.law),
    )  # fmt: skip


def _keys(config: LeaderConfig) -> KeyDrive | None:
    if config.driven_by != "keys":
        return None
    return KeyDrive(config.speed_mps, config.turn_radps, config.ramp_s)


def _clearance(scenario: Scenario, side: float) -> Clearance | None:
    """What the filter keeps between bodies as large as their tags."""
    s = scenario.safety
    if s.clearance_m == 0.0:
        return None
    return Clearance(s.clearance_m + RESERVE, s.approach_rate_per_s, half_side=0.5 * side)
