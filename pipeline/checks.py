"""What holds in a scenario and what does not, with numbers, before anything moves."""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from math import hypot, inf
from typing import TypeAlias

import numpy as np

from control.command import RobotId
from control.geometry import Pose2D, wrap_angle
from control.laws import Law
from control.plan import Plan
from pipeline.certificate_findings import certificate_findings
from pipeline.certificates import make_certificates, start_states
from pipeline.config import Scenario
from pipeline.course import wanted_places
from pipeline.errors import ConfigError
from pipeline.finding import Finding
from pipeline.radio_checks import check_radios
from pipeline.seeing import Seeing, make_seeing, named_colors
from pipeline.setup import Setup, is_undriven, make_setup
from pipeline.tag_checks import check_tags

BODY = 0.075  # side of a robot's body [m]
LONGEST = {Law.SAMPLED_TWISTING: 0.005, Law.SUBOPTIMAL: 0.010}  # periods seen to work [s]
GRID = 0.02  # of the walk along the plan, for speeds and gaps [s]
LOOKS = 0.1  # of the walk along the plan, for the picture [s]
Places: TypeAlias = Mapping[RobotId, Pose2D]


def check_scenario(scenario: Scenario) -> tuple[Finding, ...]:
    """Check a scenario.

    Args:
        scenario: read and typed.

    Returns:
        Findings in reading order; a scenario that cannot be built has one that says why.
    """
    try:
        if is_undriven(scenario):
            none = Finding("formation", True, "none: robots can be located and rendered")
            return (none, *_seeing(scenario, make_seeing(scenario)))
        setup = make_setup(scenario)
    except ConfigError as error:
        return (Finding("scenario", False, str(error)),)
    return (
        _formation(setup),
        *_gains(scenario, setup),
        *certificate_findings(make_certificates(setup, start_states(scenario, setup)), setup),
        *(_plan(scenario, setup, setup.path) if setup.path else _by_hand(scenario, setup)),
        *_seeing(scenario, setup.seeing),
        *check_radios(scenario, scenario.commanded),
        _safety(scenario),
    )


def plan_in_picture(setup: Setup) -> Finding | None:
    """Whether the camera will see the whole formation all along the plan.

    Args:
        setup: plan, formation and camera.

    Returns:
        The finding; None without a plan.
    """
    if setup.path is None:
        return None
    outside = [_outside(setup, places) for places in _wanted_course(setup, setup.path, LOOKS)]
    first = next((k * LOOKS for k, corner in enumerate(outside) if corner > 0.0), None)
    return Finding(
        "field of view",
        first is None,
        f"the plan stays {-max(outside):.0f} px inside the picture"
        if first is None
        else f"the plan leaves the picture after {first:.1f} s, by up to {max(outside):.0f} px: "
        "move or raise the camera",
    )


def _seeing(scenario: Scenario, seeing: Seeing) -> Iterator[Finding]:
    if not seeing.floor_known:
        detail = "unknown, so pixels give no metres: echelon calibrate camera --floor or --points"
        yield Finding("floor", False, detail)
    yield from check_tags(scenario, seeing)
    yield _colors(scenario, seeing)


def _formation(setup: Setup) -> Finding:
    formation = setup.formation
    pairs = ", ".join(f"{p.leader}<-{p.follower}" for p in formation.pairs)
    detail = f"{len(formation.robots)} robots, leader {formation.root}, pairs {pairs}"
    return Finding("formation", True, detail)


def _gains(scenario: Scenario, setup: Setup) -> Iterator[Finding]:
    """Poles of the sliding phase (23), and whether the laws survive their period."""
    c = scenario.control
    poles = [
        np.roots([1.0, k, l])
        for k, l in zip(c.proportional, c.integral, strict=True)  # noqa: E741 (the paper's L)
    ]
    slowest = -max(float(np.real(p).max()) for p in poles)
    yield Finding(
        "sliding phase",
        slowest > 0.0,
        f"e'' + K e' + L e = 0 with K = {c.proportional}, L = {c.integral}: "
        f"slowest pole {-slowest:.2f} 1/s, errors fall to 5 % in about {4.7 / slowest:.1f} s",
    )
    yield from _sampling(setup, c.command_period_s)


def _sampling(setup: Setup, period: float) -> Iterator[Finding]:
    """Each law that is used, by whom, and whether it survives its period."""
    followers: dict[Law, list[str]] = {}
    for robot in setup.formation.robots[1:]:
        followers.setdefault(setup.gains[robot].law, []).append(str(robot))
    for law, robots in followers.items():
        longest = LONGEST.get(law, inf)
        yield Finding(
            "sampling",
            period <= longest,
            f"{law.title} every {1e3 * period:g} ms for robot{'s' * (len(robots) > 1)} "
            f"{', '.join(robots)}"
            + (f"; it was seen to work up to {1e3 * longest:g} ms only" if law in LONGEST else ""),
        )


def _by_hand(scenario: Scenario, setup: Setup) -> Iterator[Finding]:
    """What a person who moves the leader must know."""
    if setup.keys is None:
        yield Finding("leader", True, "a hand carries it: anything with its tag may lead")
        return
    keys, limit = setup.keys, scenario.control.speed_limit_mps
    reach = max(pair.shape.at(0.0).distance for pair in setup.formation.pairs)
    fastest = keys.speed + reach * keys.turn
    yield Finding(
        "leader",
        fastest <= limit,
        f"driven by keys at most {keys.speed:g} m/s and {keys.turn:g} rad/s: the farthest camera "
        f"point, {reach:g} m from its leader, then drives {fastest:.2f} m/s of {limit:g} m/s",
    )


def _plan(scenario: Scenario, setup: Setup, path: Plan) -> Iterator[Finding]:
    """The wanted motion: inside the picture, within the wheels' reach, without contact."""
    if inside := plan_in_picture(setup):
        yield inside
    wanted = _wanted_course(setup, path, GRID)
    fastest, who = _fastest(setup, wanted)
    limit = scenario.control.speed_limit_mps
    yield Finding(
        "speeds",
        fastest <= limit,
        f"fastest camera point along the plan: robot {who}, {fastest:.2f} m/s of {limit:g} m/s",
    )
    gap = min(_smallest_gap(poses) for poses in wanted)
    yield Finding(
        "spacing",
        gap > 0.0,
        f"bodies of {1e3 * BODY:.0f} mm keep at least {1e3 * gap:.0f} mm in the wanted shape "
        "(circles around the bodies; the way into the shape is not covered)",
    )


def _wanted_course(setup: Setup, path: Plan, grid: float) -> list[Places]:
    """Where the plan wants every robot, every so many seconds of the mission."""
    course: list[Places] = []
    for t in np.arange(0.0, setup.duration + grid, grid).tolist():
        lead = path.at(t).state.pose
        course.append(_wanted_places(setup, lead, t, course[-1] if course else setup.starts))
    return course


def _wanted_places(setup: Setup, lead: Pose2D, t: float, before: Places) -> Places:
    """Every robot where the plan wants it, followers heading as their leaders do."""
    return wanted_places(setup.formation, lead, t, before, setup.follower.camera_offset)


def _outside(setup: Setup, places: Places) -> float:
    """By how many pixels a tag is outside the picture; negative: inside by as many."""
    camera, worst = setup.camera, -inf
    w, h = camera.size_px
    for pose in places.values():
        pixel, scale = camera.pixel_pose(pose), np.abs(camera.local_affine(pose)).max()
        half = 0.71 * BODY * float(scale)
        inside = min(pixel.x, w - 1 - pixel.x, pixel.y, h - 1 - pixel.y) - half
        worst = max(worst, -inside)
    return worst


def _fastest(setup: Setup, wanted: list[Places]) -> tuple[float, RobotId]:
    """Highest speed at which a wanted place moves, jumps of the shape included [m/s]."""
    best, who = 0.0, setup.formation.root
    for before, after in pairwise(wanted):
        for robot, pose in after.items():
            speed = hypot(pose.x - before[robot].x, pose.y - before[robot].y) / GRID
            turning = abs(wrap_angle(pose.theta - before[robot].theta)) / GRID
            if speed > best and turning < 1e3:
                best, who = speed, robot
    return best, who


def _smallest_gap(places: Places) -> float:
    """Smallest distance between circles around the bodies [m]."""
    poses = list(places.values())
    gaps = [
        hypot(one.x - other.x, one.y - other.y) - BODY * 2**0.5
        for index, one in enumerate(poses)
        for other in poses[index + 1 :]
    ]
    return min(gaps, default=inf)


def _colors(scenario: Scenario, seeing: Seeing) -> Finding:
    """The two searched colours that are nearest to each other."""
    colors = {color.name: color.bgr for color in named_colors(scenario)}
    names = seeing.tags.search_colors
    distances = [
        (_hue_distance(colors[a], colors[b]), a, b)
        for i, a in enumerate(names)
        for b in names[i + 1 :]
    ]
    if not distances:
        return Finding("colours", True, f"only {', '.join(names)} to tell from black")
    nearest, one, other = min(distances)
    return Finding(
        "colours",
        nearest >= 0.10,
        f"nearest of {len(names)} colours: {one} and {other}, {nearest:.2f} apart in chromaticity "
        "(0.10 needed)",
    )


def _hue_distance(one: tuple[int, int, int], other: tuple[int, int, int]) -> float:
    """Distance of two colours with their brightness taken out."""
    a, b = (np.array(c, float) / max(sum(c), 1) for c in (one, other))
    return float(np.linalg.norm(a - b))


def _safety(scenario: Scenario) -> Finding:
    """Whether a healthy frame can be older than the patience of the safety rules."""
    c, s = scenario.camera, scenario.safety
    oldest = c.latency_s + 2.0 / c.fps
    return Finding(
        "safety times",
        oldest < min(s.slow_after_s, s.camera_silent_s),
        f"with one frame lost the newest pose is {1e3 * oldest:.0f} ms old; robots slow down after "
        f"{1e3 * s.slow_after_s:.0f} ms and stand after {1e3 * s.stop_after_s:.0f} ms "
        f"(at 1 m/s: {s.stop_after_s:.2f} m)",
    )
