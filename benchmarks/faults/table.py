"""What was survived, as a table."""

from collections.abc import Sequence
from functools import reduce
from math import isnan

from benchmarks.faults.many import Mission
from benchmarks.faults.promises import COMES_RIGHT, RESUMES
from benchmarks.faults.script import CATCHES_UP, Kind
from benchmarks.faults.verdict import Outcome, Took

TWO = "two at once"
HEAD = (
    "| fault | injected | survived | wheels let go after (allowed), s | stands after (allowed), s "
    f"| moves again after, s ({RESUMES:g}) | in place again after (allowed), s "
    "| least clearance, mm |",
    "|---|---|---|---|---|---|---|---|",
)
EXPLANATION = (
    "wheels let go: from the fault until nothing drives the wheels of a robot that has to stand; "
    "stands: until it is slower than 5 mm/s and 3 deg/s; the time nearest to its limit is shown. "
    "moves, in place again: from when the promises let it move; "
    f"{COMES_RIGHT:g} s are allowed for that, and {CATCHES_UP:g} times as long as the leader "
    "drove on without some."
)


def table(missions: Sequence[Mission]) -> str:
    """A row for each kind of fault, in Markdown.

    Args:
        missions: all that were driven.

    Returns:
        Lines of text.
    """
    outcomes = [outcome for mission in missions for outcome in mission.verdict.outcomes]
    names = [*(kind.value for kind in Kind), TWO]
    rows = (_row(name, [o for o in outcomes if _name(o) == name]) for name in names)
    return "\n".join((*HEAD, *(row for row in rows if row)))


def summary(missions: Sequence[Mission]) -> str:
    """What there is to say of all missions together.

    Args:
        missions: all that were driven.

    Returns:
        A line of text.
    """
    hours = sum(mission.verdict.end for mission in missions) / 3600.0
    faults = sum(len(o.faults) for mission in missions for o in mission.verdict.outcomes)
    last = [m.verdict.last_error for m in missions if not isnan(m.verdict.last_error)]
    worst = 1e3 * max(last, default=0.0)
    return (
        f"{len(missions)} missions, {hours:.2f} h simulated, {faults} faults; worst distance error "
        f"of a follower at the end of {len(last)} finished missions: {worst:.1f} mm"
    )


def failures(missions: Sequence[Mission]) -> str:
    """Which promises were broken, and how to see it again.

    Args:
        missions: all that were driven.

    Returns:
        Lines of text; empty if all were kept.
    """
    return "\n".join(
        f"{mission.course}: {broken}\n    again: python -m benchmarks.faults --seed {mission.seed} "
        f"--mission {mission.number}"
        for mission in missions
        for broken in mission.broken
    )


def story(mission: Mission) -> str:
    """One mission in detail.

    Args:
        mission: that was driven.

    Returns:
        Lines of text.
    """
    lines = [f"{mission.course}: {mission.verdict.end:.2f} s, fingerprint {mission.verdict.digest}"]
    for o in mission.verdict.outcomes:
        for f in o.faults:
            who = "" if f.robot is None else f", robot {f.robot}"
            size = f", by {f.size:.2f} s" if f.size else ""
            lines.append(f"  {f.begin:.2f} s to {f.end:.2f} s: {f.kind.value}{who}{size}")
        lines.append(
            f"    wheels let go {_took(o.wheels)} s, stands {_took(o.stands)} s, moves again "
            f"{_time(o.moves)} s, in place {_took(o.right, 2)} s, "
            f"clearance {1e3 * o.clearance:.1f} mm"
        )
    return "\n".join(lines)


def _name(outcome: Outcome) -> str:
    return outcome.faults[0].kind.value if len(outcome.faults) == 1 else TWO


def _row(name: str, outcomes: Sequence[Outcome]) -> str:
    if not outcomes:
        return ""
    worst = [
        reduce(Took.or_worse, (getattr(o, what) for o in outcomes))
        for what in ("wheels", "stands", "moves", "right")
    ]
    survived = sum(not o.broken for o in outcomes)
    gap = 1e3 * min(o.clearance for o in outcomes)
    times = (_took(worst[0]), _took(worst[1]), _time(worst[2]), _took(worst[3], 2))
    return f"| {name} | {len(outcomes)} | {survived} | {' | '.join(times)} | {gap:.1f} |"


def _took(took: Took, digits: int = 3) -> str:
    return "-" if isnan(took.time) else f"{took.time:.{digits}f} ({took.allowed:.{digits}f})"


def _time(took: Took) -> str:
    return "-" if isnan(took.time) else f"{took.time:.2f}"
