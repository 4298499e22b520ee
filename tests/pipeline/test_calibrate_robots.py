"""`echelon calibrate robots`: what is found, what is refused, and when robots are stopped."""

import json
import tomllib
from dataclasses import replace
from itertools import pairwise
from math import hypot
from pathlib import Path

import pytest

from benchmarks.moving import BELIEVED, drawn_world, errors, measured
from control.command import RobotId
from control.unicycle import Twist
from pipeline.calibration.drive_figures import figures_of
from pipeline.calibration.drive_file import drives_text
from pipeline.calibration.moving import look_for_all
from pipeline.calibration.pairing import paired_spec
from pipeline.calibration.pattern import DRIVING, TURNING
from pipeline.calibration.watch import TICK, Circle, Interrupted, danger
from pipeline.config import Scenario
from pipeline.errors import CameraError, ConfigError, RadioError, SafetyStop
from pipeline.scenario import load_scenario, scenario_path
from tests.pipeline.commands import echelon
from tests.pipeline.moving import room

APART = (
    "robots.1.start={x_m=0.1, y_m=0.1}",
    "robots.2.start={x_m=0.6, y_m=0.7, theta_deg=130}",
    "robots.3.start={x_m=1.1, y_m=0.2, theta_deg=-70}",
)
ARENA = "safety.arena_m=[-0.6, -0.5, 1.7, 1.3]"
MOVING = 4.0  # by then radio 2 or 3 turns, and later somebody drives [s]
FRAME = 1.0 / 30.0  # between two pictures [s]
PAIRED = 7.0  # by then robot 1 drives [s]


def changed(*overrides: str) -> Scenario:
    """The paper's robots with room about them, and changes."""
    return load_scenario("paper", (*APART, ARENA, *overrides))


@pytest.mark.parametrize("seed", [1, 7])
def test_hidden_drives_and_latencies_are_found(seed: int) -> None:
    world = drawn_world(seed)
    found = tuple(errors(world, measured(world, seed)))
    assert len(found) == 3
    for error in found:
        assert abs(error.latency) < 0.005
        assert abs(error.lag) < 0.2
        assert abs(error.scale) < 0.02
        assert abs(error.track) < 0.03


def test_one_robot_moves_at_a_time_and_comes_back() -> None:
    with room(BELIEVED) as here:
        before = {r.robot_id: r.state for r in here.bench.rig.truth()}
        moved = here.move()
        after = {r.robot_id: r.state for r in here.bench.rig.truth()}
        assert here.speed_after(0.5) < 1e-3
    assert moved.pairing == {1: 1, 2: 2, 3: 3}
    for robot in (1, 2, 3):
        assert hypot(after[robot].x - before[robot].x, after[robot].y - before[robot].y) < 0.002
    told = [robot for _, robot, twist in here.wire.sent]
    turns = [robot for n, robot in enumerate(told) if n == 0 or told[n - 1] != robot]
    assert turns == [1, 2, 3, 1, 2, 3]
    assert len(here.wire.stops) == len(turns) + 1  # after every drive, and at the end
    assert here.wire.stops[-1] >= here.wire.sent[-1][0]
    gaps = [b[0] - a[0] for a, b in pairwise(here.wire.sent) if a[1] == b[1]]
    within = [gap for gap in gaps if gap < 0.2]  # the others are between two patterns
    assert max(within) < 0.08  # robots have timeouts of their own


def test_crossed_radios_are_paired_and_told() -> None:
    with room(BELIEVED, to={1: (3,), 3: (1,)}) as here:
        moved = here.move()
    assert moved.pairing == {1: 3, 2: 2, 3: 1}
    assert "radio 1 moves the tag of robot 3" in here.said
    gains = {robot: fit.gain.v for robot, fit in moved.fits.items()}
    assert gains[1] == pytest.approx(1.0, rel=0.02)  # robots 2 and 3 are 10 % too fast
    assert gains[3] == pytest.approx(1.1, rel=0.02)


def test_a_spec_is_given_its_right_tags() -> None:
    pairing = {1: 3, 2: 2, 3: 1}
    assert paired_spec("miabot:1=/dev/a,2=/dev/b, 3=/dev/c", pairing) == (
        "miabot:3=/dev/a,2=/dev/b,1=/dev/c"
    )
    assert paired_spec("simulated", pairing) == "simulated"


@pytest.mark.parametrize(
    ("to", "factor", "said"),
    [
        ({2: ()}, (1.0, 1.0), "radio 2: no tag turned"),
        ({2: (2, 3)}, (1.0, 1.0), "radio 2: the tags of robots 2 and 3 turned together"),
        ({2: (1,)}, (1.0, 1.0), "radio 2: it turned the tag of robot 1, as radio 1"),
        ({}, (1.0, -1.0), "radio 1: the tag of robot 1 turned to the right"),
    ],
)
def test_radios_that_cannot_be_paired_are_named(
    to: dict[RobotId, tuple[RobotId, ...]], factor: tuple[float, float], said: str
) -> None:
    with room(BELIEVED, to=to, factor=factor) as here:
        with pytest.raises(RadioError, match=said):
            here.move()
        assert here.speed_after(0.5) < 1e-3
    assert all(twist.v == 0.0 for _, _, twist in here.wire.sent)  # nobody has driven yet
    assert here.wire.stops


def test_a_link_that_is_down_is_named() -> None:
    with room(BELIEVED, down=(1,)) as here, pytest.raises(RadioError, match="radio 1: its link"):
        here.move()


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        (("robots.2.start={x_m=0.3, y_m=0.1}",), "robot 1 needs .* robot 2 is 0.20 m away"),
        (("safety.arena_m=[-0.05, -0.5, 1.7, 1.3]",), "robot 1 needs .* border of safety.arena_m"),
        (("robots.3.start={x_m=1.63, y_m=0.2}",), "robot 3 needs .* picture ends"),
        (
            (
                'surroundings.things=[{ shape = "disc", color = "red", size_m = 0.06, '
                "points = [{ at_s = 0, x_m = 0.24, y_m = 0.1 }] }]",
            ),
            "robot 1 needs .* something is 0.15 m away",
        ),
        (
            (
                'surroundings.things=[{ shape = "disc", color = "blue", size_m = 0.2, '
                "height_m = 0.3, points = [{ at_s = 0, x_m = 1.1, y_m = 0.2 }] }]",
            ),
            "robot 3 is not seen, .* nothing was moved",
        ),
    ],
)
def test_nobody_moves_where_it_is_not_clear(overrides: tuple[str, ...], said: str) -> None:
    wide = ("safety.arena_m=[-2, -2, 2, 2]",) if "picture" in said else ()
    with room(changed(*wide, *overrides)) as here, pytest.raises(ConfigError, match=said):
        here.move()
    assert here.wire.sent == []
    assert here.wire.stops


def test_nobody_moves_without_an_arena() -> None:
    with (
        pytest.raises(ConfigError, match=r"missing key safety\.arena_m"),
        room(load_scenario("paper", APART)),
    ):
        pass


def test_a_camera_that_never_shows_anything_moves_nobody() -> None:
    with room(BELIEVED, blind_from=0.0) as here, pytest.raises(CameraError, match="no picture"):
        here.move()
    assert here.wire.sent == []


@pytest.mark.parametrize("t", [MOVING, PAIRED + 1.0])
def test_a_silent_camera_stops_all_within_its_time(t: float) -> None:
    with room(BELIEVED, blind_from=t) as here:
        with pytest.raises(SafetyStop, match=r"no picture for 0\.2"):
            here.move()
        assert t + 0.2 - FRAME < here.wire.stops[-1] < t + 0.2 + 2 * TICK
        assert here.wire.sent[-1][0] < here.wire.stops[-1]
        assert here.speed_after(0.5) < 1e-3


@pytest.mark.parametrize("robot", [1, 3])  # the one that drives, and one that stands
def test_a_robot_that_is_lost_stops_all(robot: int) -> None:
    x, y = {1: (0.1, 0.1), 3: (1.1, 0.2)}[robot]
    t = PAIRED + 1.0
    cover = (
        'surroundings.things=[{ shape = "disc", color = "green", size_m = 0.5, height_m = 0.3, '
        f"from_s = {t}, points = [{{ at_s = 0, x_m = {x}, y_m = {y} }}] }}]"
    )
    with room(changed(cover)) as here:
        with pytest.raises(SafetyStop, match=f"robot {robot} was last seen 0.3"):
            here.move()
        assert t + 0.3 - FRAME < here.wire.stops[-1] < t + 0.3 + 2 * TICK
        assert here.speed_after(0.5) < 1e-3


def test_a_robot_that_may_be_another_stops_all() -> None:
    with room(BELIEVED) as here:
        sight = look_for_all(here.bench, here.robots)
    rules, circles = here.bench.lookout.rules, {1: Circle(0.1, 0.1, 0.1)}
    assert danger(rules, sight, circles) is None
    doubted = {**sight.tracks, 1: replace(sight.tracks[1], ambiguous=True)}
    assert "may be another" in (danger(rules, replace(sight, tracks=doubted), circles) or "")


def test_a_robot_that_leaves_its_circle_stops_all() -> None:
    with room(BELIEVED, factor=(4.0, 1.0)) as here:
        with pytest.raises(SafetyStop, match=r"radio 1 was driving: robot 1 is 0\.1\d* m from"):
            here.move()
        away = [
            hypot(r.state.x - 0.1, r.state.y - 0.1)
            for r in here.bench.rig.truth()
            if r.robot_id == 1
        ]
        assert away[0] < 0.2
        assert here.speed_after(0.5) < 1e-3


def test_a_robot_that_moves_untold_stops_all() -> None:
    world = changed("robots.2.start={x_m=0.6, y_m=0.7, v_mps=0.08}")
    with room(world) as here, pytest.raises(SafetyStop, match=r"radio 1 .*: robot 2 is 0\.03"):
        here.move()


def test_ctrl_c_stops_all() -> None:
    with room(BELIEVED, interrupted_at=PAIRED + 1.0) as here:
        with pytest.raises(Interrupted):
            here.move()
        assert here.wire.stops[-1] < PAIRED + 1.0 + 0.02
        assert here.speed_after(0.5) < 1e-3


def test_a_drive_that_is_no_robot_s_is_refused() -> None:
    pushed = changed("robots.2.disturbance_mps2=0.6", "robots.2.turn_disturbance_radps2=8.0")
    with room(pushed) as here, pytest.raises(ConfigError, match=r"robot 2: .* not explained"):
        here.move()


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, object]]:
    """What the command line writes and says in a world of its own."""
    out = tmp_path_factory.mktemp("robots") / "robots.toml"
    changes = [part for text in (*APART, ARENA, "radio.delay_s=0.03") for part in ("--set", text)]
    done = echelon("calibrate", "robots", "paper", "--fast", *changes, "--out", out, "--json")
    assert done.returncode == 0, done.stderr
    assert "robot 3 (3 of 3): drives" in done.stderr
    return out, json.loads(done.stdout)


def test_the_fragment_is_included_and_holds(
    told: tuple[Path, dict[str, object]], tmp_path: Path
) -> None:
    out, _ = told
    mine = tmp_path / "mine.toml"
    mine.write_text(f'include = ["{scenario_path("paper").resolve()}", "{out}"]\n')
    scenario = load_scenario(str(mine))
    assert scenario.radio.delay_s == pytest.approx(0.03, abs=0.001)
    assert scenario.estimation.lag_s == pytest.approx(0.05, rel=0.03)
    assert scenario.radio.speed_scale_per_mps == pytest.approx(1000 * (1 + 2 / 1.1) / 3, rel=0.01)
    track = 0.068 * (1 + 2 * 1.1 / 0.9) / 3
    assert scenario.radio.track_width_m == pytest.approx(track, rel=0.01)
    assert echelon("check", mine).returncode == 0
    assert "--radio simulated" in out.read_text()


def test_json_has_every_robot_with_its_errors(told: tuple[Path, dict[str, object]]) -> None:
    _, said = told
    assert said["pairing"] == [{"radio": n, "tag": n} for n in (1, 2, 3)]
    assert said["total_latency_s"] == pytest.approx(0.07, abs=0.005)
    assert said["picture_age_s"] == pytest.approx(0.04, abs=0.005)
    robots = said["robots"]
    assert isinstance(robots, list)
    for robot, gain in zip(robots, (1.0, 1.1, 1.1), strict=True):
        assert robot["forward_gain"] == pytest.approx(gain, rel=0.01)
        for key in ("speed_scale_per_mps", "track_width_m", "lag_s", "delay_s"):
            assert 0.0 < robot[key]["std"] < 0.02 * robot[key]["value"]


def test_a_plan_moves_nobody_and_says_what_is_in_the_way(tmp_path: Path) -> None:
    plan = ("calibrate", "robots", "--plan", "--fast", "--out", tmp_path / "r.toml", "--set", ARENA)
    clear = [part for text in APART for part in ("--set", text)]
    done = echelon(*plan, *clear)
    assert done.returncode == 0, done.stderr
    assert "clear floor m" in done.stdout
    done = echelon(*plan, "--json")  # the paper's robots 2 and 3 stand close
    assert done.returncode == 2
    assert "robot 3 is 0.10 m away" in done.stderr
    rows = json.loads(done.stdout)["robots"]
    assert [len(row["in_the_way"]) for row in rows] == [0, 1, 1]
    assert not (tmp_path / "r.toml").exists()


def test_a_negative_delay_corrects_the_camera_s_latency() -> None:
    with room(BELIEVED) as here:
        fit = here.move().fits[1]
    early = figures_of(replace(fit, delay=-0.012), BELIEVED.radio)
    table = tomllib.loads(drives_text(early, {1: early}, BELIEVED.camera, ()))
    assert table["camera"]["latency_s"] == pytest.approx(0.028)
    assert table["radio"]["delay_s"] == 0.0


def test_turning_stays_in_place_and_driving_in_a_hand_s_breadth() -> None:
    assert TURNING.reach() == 0.0
    assert 0.05 < DRIVING.reach() < 0.1
    assert TURNING.at(TURNING.duration + 1.0)[0] == DRIVING.at(0.0)[0] == Twist(0.0, 0.0)
