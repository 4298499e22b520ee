"""Faults in simulated driving: each once, judged in the true world; and the judge can find fault.

Hours of them: python -m benchmarks.faults
"""

from dataclasses import replace
from math import inf, isnan
from typing import Any

import numpy as np
import pytest

from benchmarks.faults import drive as driving
from benchmarks.faults.drive import drive_script
from benchmarks.faults.missions import COURSES, made
from benchmarks.faults.script import ENDS, LASTS, UNHEARD, Fault, Kind, Plot, Script, draw
from benchmarks.faults.verdict import judge

LAPS = "paper, in laps"
FIRST, APART = 2.0, 9.5  # the first fault, and from one to the next [s]
HALTS = [kind for kind in LASTS if kind is not Kind.CLOCK_STEP]
SIZES = {Kind.OLD_STAMPS: 0.6, Kind.CLOCK_STEP: -1000.0}
CONCERNS = {Kind.COVERED: 2, Kind.TAKEN: 3, Kind.CLOSED: 1, Kind.BLOCKED: 3, Kind.UNMOVED: 1}
LONG = {Kind.OLD_STAMPS: 2.0}


def one_after_the_other(kinds: list[Kind]) -> Script:
    """Every kind alone, a second long."""
    faults = [
        Fault(kind, begin, begin + LONG.get(kind, 1.0), CONCERNS.get(kind), SIZES.get(kind, 0.0))
        for kind, begin in zip(kinds, np.arange(len(kinds)) * APART + FIRST, strict=True)
    ]
    return Script(tuple((fault,) for fault in faults))


@pytest.mark.parametrize("half", [0, 1])
def test_every_fault_is_survived(half: int) -> None:
    kinds = list(LASTS)[half::2]
    driven = drive_script(LAPS, one_after_the_other(kinds), seed=5)
    verdict = judge(driven)
    assert driven.why == "finished"
    assert verdict.broken == ()
    assert [outcome.faults[0].kind for outcome in verdict.outcomes] == kinds
    for outcome in verdict.outcomes:
        assert outcome.broken == ()
        assert outcome.clearance > 0.02
        assert isnan(outcome.stands.time) == (outcome.faults[0].kind not in HALTS)


@pytest.mark.parametrize("kind", ENDS)
def test_every_end_leaves_all_robots_standing(kind: Kind) -> None:
    driven = drive_script("paper", Script(((Fault(kind, 2.0, inf),),)), seed=6)
    verdict = judge(driven)
    assert driven.why == {Kind.GONE: "given-up", Kind.SIGTERM: "interrupted"}.get(kind, "killed")
    assert (verdict.broken, verdict.outcomes[0].broken) == ((), ())
    assert verdict.outcomes[0].wheels.time > 0.0


def test_faults_at_the_same_time_are_survived_and_repeat_themselves_bit_for_bit() -> None:
    together = (Fault(Kind.COVERED, 2.0, 3.2, 1), Fault(Kind.STALLED, 2.15, 3.15))
    script = Script((together, (Fault(Kind.SIGTERM, 6.0, inf),)))
    once, again = (judge(drive_script("paper", script, seed=7)) for _ in range(2))
    assert once.digest == again.digest
    assert all(outcome.broken == () for outcome in once.outcomes)


@pytest.mark.parametrize(
    ("kind", "sloppy"),
    [
        (Kind.FROZEN, {"camera_silent": 0.26}),
        (Kind.COVERED, {"stop_after": 0.38}),
        (Kind.UNPLUGGED, {"good_frames": 0.8}),
        (Kind.UNPLUGGED, {"good_frames": 1.5}),
    ],
)
def test_a_broken_promise_is_found(
    kind: Kind, sloppy: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    base = made("paper")
    loose = replace(base.setup, rules=replace(base.setup.rules, **sloppy))
    monkeypatch.setattr(driving, "made", lambda _: replace(base, setup=loose))
    faults = Fault(kind, 2.0, 3.5, CONCERNS.get(kind)), Fault(Kind.SIGTERM, 6.0, inf)
    driven = drive_script("paper", Script(tuple((fault,) for fault in faults)), seed=8)
    assert judge(replace(driven, made=base)).outcomes[0].broken != ()


def test_a_script_is_the_same_for_the_same_seed_and_has_all_kinds() -> None:
    plot = Plot((1.0, 2.0), 3, 8.0, (1, 2, 3), (2, 3))
    scripts = [draw(plot, np.random.default_rng(seed)) for seed in range(100)]
    assert scripts[7] == draw(plot, np.random.default_rng(7))
    faults = [fault for script in scripts for fault in script.faults]
    assert {fault.kind for fault in faults} == set(Kind)
    assert all(f.robot in (2, 3) for f in faults if f.kind in (Kind.TAKEN, *UNHEARD))
    assert any(len(group) == 2 for script in scripts for group in script.groups)


def test_every_course_exists() -> None:
    assert set(driving.TURNS) == set(COURSES)
