"""Moving robots are watched before the start, for the initial rates (Assumption 5, Remark 5)."""

from collections.abc import Mapping
from dataclasses import replace
from math import degrees

from control.command import RobotId
from control.differentiator import unwrapped
from control.formation import by_follower
from control.initial_rate import MIN_SAMPLES, InitialRate, initial_rate
from control.relative import Vector2, relative_state
from pipeline.memory import Glimpse, Mission
from pipeline.setup import Setup
from vision.scene import Scene

JERK, TURN_JERK = 1.0, 3.0  # bounds of the third derivatives while watching [m/s^3, rad/s^3]


def watch(setup: Setup, mission: Mission, scene: Scene | None) -> Mission:
    """Note the relative configurations of a frame while the robots are being watched.

    Args:
        setup: formation and camera offset.
        mission: so far.
        scene: what a new frame showed, None without one.

    Returns:
        The mission, with one more glimpse if it is watching and every robot was seen.
    """
    if mission.phase != "armed" or not setup.watch_time or scene is None:
        return mission
    seen = {d.robot_id: d.pose for d in scene.detections}
    if any(robot not in seen for robot in setup.formation.robots):
        return mission
    states = [
        relative_state(seen[pair.leader], seen[pair.follower], setup.follower.camera_offset)
        for pair in setup.formation.pairs
    ]
    distances, bearings = tuple(r.distance for r in states), tuple(r.bearing for r in states)
    glimpse = Glimpse(scene.t_capture, distances, bearings)
    return replace(mission, glimpses=(*mission.glimpses, glimpse))


def watched(setup: Setup, mission: Mission, t: float) -> bool:
    """Whether all robots were seen together often enough, for long enough, and until lately.

    Args:
        setup: start-up rules.
        mission: with the glimpses so far.
        t: now [s].

    Returns:
        True if the rates can be told; also where nobody is to be watched.
    """
    if not setup.watch_time:
        return True
    times = [glimpse.t for glimpse in mission.glimpses]
    if len(times) < MIN_SAMPLES:
        return False
    return t - times[0] >= setup.watch_time and t - times[-1] < setup.rules.slow_after


def initial_rates(
    setup: Setup, mission: Mission
) -> tuple[Mapping[RobotId, Vector2], tuple[str, ...]]:
    """h'(0) of every follower at the start of the mission (Assumption 5, Remark 5).

    Args:
        setup: formation and start-up rules.
        mission: with the glimpses of the watching phase.

    Returns:
        Rates by follower, empty for robots that start from rest (case 1); and notes that state
        the estimate and its spread (case 2).
    """
    if not mission.glimpses:
        return {}, ()
    rates: dict[RobotId, Vector2] = {}
    notes: list[str] = []
    for robot, pairs in by_follower(setup.formation.pairs).items():
        seen = [_rates(mission, setup.formation.pairs.index(pair)) for pair in pairs]
        one, two = seen[0] if len(seen) == 1 else (seen[0][0], seen[1][0])
        rates[robot] = one.rate, two.rate
        notes.append(f"robot {robot} starts with {_told(one, two, turns=len(seen) == 1)}")
    return rates, tuple(notes)


def forget_glimpses(mission: Mission) -> Mission:
    """Drop what was watched, once the initial rates have been taken from it.

    Args:
        mission: so far.

    Returns:
        The mission without glimpses.
    """
    return replace(mission, glimpses=()) if mission.glimpses else mission


def _rates(mission: Mission, index: int) -> tuple[InitialRate, InitialRate]:
    """Of distance and bearing of a pair."""
    times = [glimpse.t for glimpse in mission.glimpses]
    distances = [glimpse.distances[index] for glimpse in mission.glimpses]
    bearings = unwrapped([glimpse.bearings[index] for glimpse in mission.glimpses])
    return initial_rate(times, distances, JERK), initial_rate(times, bearings, TURN_JERK)


def _told(one: InitialRate, two: InitialRate, turns: bool) -> str:
    """The initial rates and their spread in words."""
    first = f"distance rate {1e3 * one.rate:.1f} +- {1e3 * one.spread:.1f} mm/s"
    if turns:
        return f"{first}, bearing rate {degrees(two.rate):.2f} +- {degrees(two.spread):.2f} deg/s"
    return f"{first}, {1e3 * two.rate:.1f} +- {1e3 * two.spread:.1f} mm/s from the second leader"
