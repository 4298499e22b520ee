"""The state machine of a run: who may move, and since when.

    idle      not every robot of the formation is in sight
    armed     all are: they are watched, or the start is waited for
    running   the laws drive
    holding   all stand: the leader or the camera is lost, the way is blocked, or motion waits to be
              armed again
    stopped   emergency stop, latched until it is armed again
    finished, given-up   the run ends

Whoever has to stand by the safety rules stands (`guard`), whatever the state is.
"""

from collections.abc import Mapping
from dataclasses import replace

from control.command import RobotId
from datasets.cycle import SafetyEvent, Tick
from pipeline.memory import Mission, Track
from pipeline.setup import Setup
from pipeline.watching import watched

DRIVING = ("running", "holding", "stopped")
"""States in which commands are sent, if the mission has begun; all but the first stand."""

ENDS = ("finished", "given-up")
"""States after which there is no further cycle."""

Shares = Mapping[RobotId, float]


def supervise(
    setup: Setup,
    mission: Mission,
    tracks: Mapping[RobotId, Track],
    shares: Shares,
    tick: Tick,
    dt: float,
) -> tuple[Mission, Shares, tuple[SafetyEvent, ...]]:
    """Move the mission on by one tick.

    Args:
        setup: formation, start-up rules, duration.
        mission: so far.
        tracks: robots seen so far.
        shares: of its speed that each robot may drive, from the safety rules.
        tick: the present inputs, orders among them.
        dt: since the last tick [s].

    Returns:
        The mission now, whose clock stands still while the formation must stand; the shares, all 0
        unless it runs; what orders have changed.
    """
    after = _next(setup, mission, tracks, shares, tick)
    if after.phase not in ("running", "finished") and after.t_start is not None:
        after = replace(after, t_start=after.t_start + dt)
    waited = min(dt, setup.rules.camera_silent)  # a host that slept has not been patient meanwhile
    after = replace(after, held=mission.held + waited if after.phase == "holding" else 0.0)
    if after.held >= setup.rules.give_up:
        after = replace(after, phase="given-up")
    if after.phase != "running":
        shares = dict.fromkeys(shares, 0.0)
    return after, shares, _events(mission, after, tick)


def _next(
    setup: Setup, mission: Mission, tracks: Mapping[RobotId, Track], shares: Shares, tick: Tick
) -> Mission:
    """The state after this tick, its clock and patience aside."""
    if tick.orders.halt:
        return replace(mission, phase="stopped", glimpses=())
    if mission.phase == "stopped" and not tick.orders.arm:
        return mission
    ordered = tick.orders.arm or not setup.rules.hold
    if mission.t_start is None:
        return _before_start(setup, mission, tracks, tick, ordered)
    if shares[setup.formation.root] == 0.0:
        return replace(mission, phase="holding")
    if mission.phase == "holding" and not ordered:
        return mission
    over = mission.phase == "running" and tick.t - mission.t_start >= setup.duration
    return replace(mission, phase="finished" if over else "running")


def _before_start(
    setup: Setup,
    mission: Mission,
    tracks: Mapping[RobotId, Track],
    tick: Tick,
    ordered: bool,
) -> Mission:
    """Wait until every robot of the formation is in sight and known, then watch, then start."""
    fresh = setup.rules.slow_after
    in_sight = all(
        robot in tracks
        and tick.t - tracks[robot].estimate.t < fresh
        and (setup.rules.drive_ambiguous or not tracks[robot].ambiguous)
        for robot in setup.formation.robots
    )
    if not in_sight:
        return Mission()
    waits = setup.watch_time > 0.0 or setup.rules.hold
    if waits and mission.phase != "armed":
        return Mission("armed")
    if not (ordered and watched(setup, mission, tick.t)):
        return mission
    return replace(mission, phase="running", t_start=tick.t)


def _events(before: Mission, after: Mission, tick: Tick) -> tuple[SafetyEvent, ...]:
    if after.phase == "stopped" and before.phase != "stopped":
        detail = "all robots stop and stay so until they are armed again"
        return (SafetyEvent(tick.t, "emergency-stop", None, detail),)
    if before.phase == "stopped" and after.phase != "stopped":
        return (SafetyEvent(tick.t, "armed", None, "motion may begin again"),)
    return ()
