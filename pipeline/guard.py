"""The safety rules of a run: who may move, and how much, given what has been seen lately.

Promises (`docs/safety.md`): a robot without a pose, and all that follow it, slow down and stop; no
frame stops all until frames have come steadily again; a robot whose link is down, or that has to
stand for another reason (`identity`, `obedience`), counts as unseen.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from control.command import RobotId
from control.formation import Formation
from datasets.cycle import SafetyEvent, Tick

NOBODY: Mapping[RobotId, str] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class SafetyRules:
    """When robots are slowed and stopped.

    Attributes:
        slow_after: without a pose a robot slows down after this [s].
        stop_after: and stands after this [s].
        camera_silent: without a frame all stop after this [s].
        good_frames: frames must come steadily for this long before motion resumes [s].
        give_up: when the whole formation has stood for this long, the run ends [s].
        hold: motion begins, and resumes, only when a person arms it.
        drive_ambiguous: robots that may be another one with the same tag are driven, too.
        unmoved: a robot whose wheels were told to roll so far within a second and that is seen
            standing does not obey; 0: that is not watched [m].
        together: when one robot has to slow down or stand, all do: nobody is left behind.
    """

    slow_after: float = 0.2
    stop_after: float = 0.3
    camera_silent: float = 0.2
    good_frames: float = 1.0
    give_up: float = 10.0
    hold: bool = False
    drive_ambiguous: bool = False
    unmoved: float = 0.1
    together: bool = False


@dataclass(frozen=True, slots=True)
class GuardMemory:
    """What the rules remember.

    Attributes:
        t_frame: when the last frame arrived [s], None before the first.
        t_silent: when the camera last fell silent or was silent [s], None if it never did.
        stopped: robots that stand by these rules.
    """

    t_frame: float | None = None
    t_silent: float | None = None
    stopped: frozenset[RobotId] = frozenset()


def watch_over(
    rules: SafetyRules,
    memory: GuardMemory,
    formation: Formation,
    seen: Mapping[RobotId, float],
    tick: Tick,
    standing: Mapping[RobotId, str] = NOBODY,
) -> tuple[GuardMemory, Mapping[RobotId, float], tuple[SafetyEvent, ...]]:
    """Decide for every robot which share of its commanded speed it may drive.

    Args:
        rules: the times.
        memory: of the tick before.
        formation: who follows whom.
        seen: capture time of the last frame each known robot was seen in [s].
        tick: the present inputs.
        standing: robots that have to stand for another reason, and the reason.

    Returns:
        The new memory; 0 (stand) to 1 (free) for every robot of the formation; what changed.
    """
    t_frame = tick.t if tick.frame is not None else memory.t_frame
    since = memory.t_frame if memory.t_frame is not None else tick.t
    silent = tick.t - since > rules.camera_silent
    t_silent = tick.t if silent else memory.t_silent
    steady = t_silent is None or tick.t - t_silent >= rules.good_frames
    shares = (
        _shares(rules, formation, seen, tick, standing)
        if steady
        else dict.fromkeys(formation.robots, 0.0)
    )
    stopped = frozenset(robot for robot, share in shares.items() if share == 0.0 and robot in seen)
    events = (
        *_camera_events(memory, t_silent, steady, tick.t, rules),
        *_robot_events(rules, memory.stopped, stopped, seen, tick, standing),
    )
    return GuardMemory(t_frame, None if steady else t_silent, stopped), shares, events


def _shares(
    rules: SafetyRules,
    formation: Formation,
    seen: Mapping[RobotId, float],
    tick: Tick,
    standing: Mapping[RobotId, str],
) -> dict[RobotId, float]:
    """A robot's own share, limited by that of the robot it follows, or of all."""
    own = {
        robot: 0.0 if robot in standing else _own_share(rules, robot, seen, tick)
        for robot in formation.robots
    }
    for pair in formation.pairs:  # leaders first, so limits travel down the tree
        own[pair.follower] = min(own[pair.follower], own[pair.leader])
    return dict.fromkeys(own, min(own.values())) if rules.together else own


def _own_share(
    rules: SafetyRules, robot: RobotId, seen: Mapping[RobotId, float], tick: Tick
) -> float:
    """1 while freshly seen, falling to 0 between slow_after and stop_after."""
    if robot not in seen or robot in tick.lost_links:
        return 0.0
    left = rules.stop_after - (tick.t - seen[robot])
    return min(1.0, max(0.0, left / (rules.stop_after - rules.slow_after)))


def _camera_events(
    memory: GuardMemory, t_silent: float | None, steady: bool, t: float, rules: SafetyRules
) -> tuple[SafetyEvent, ...]:
    if t_silent is not None and memory.t_silent is None:
        detail = f"no frame for {rules.camera_silent:g} s: all robots stop"
        return (SafetyEvent(t, "camera-silent", None, detail),)
    if steady and memory.t_silent is not None:
        detail = f"frames have come steadily for {rules.good_frames:g} s: motion resumes"
        return (SafetyEvent(t, "camera-back", None, detail),)
    return ()


def _robot_events(
    rules: SafetyRules,
    before: frozenset[RobotId],
    after: frozenset[RobotId],
    seen: Mapping[RobotId, float],
    tick: Tick,
    standing: Mapping[RobotId, str],
) -> tuple[SafetyEvent, ...]:
    """Robots that have just been stopped, and those that may move again."""
    stopped = [
        SafetyEvent(tick.t, "robot-stopped", robot, _why(rules, robot, seen, tick, standing))
        for robot in sorted(after - before, key=str)
    ]
    freed = [
        SafetyEvent(tick.t, "robot-free", robot, "nothing holds it any more")
        for robot in sorted(before - after, key=str)
    ]
    return (*stopped, *freed)


def _why(
    rules: SafetyRules,
    robot: RobotId,
    seen: Mapping[RobotId, float],
    tick: Tick,
    standing: Mapping[RobotId, str],
) -> str:
    if robot in standing:
        return standing[robot]
    if robot in tick.lost_links:
        return "its radio link is down"
    unseen = tick.t - seen[robot]
    if unseen >= rules.slow_after:
        return f"last seen {unseen:.2f} s ago"
    return "another robot stands" if rules.together else "a robot that it follows stands"
