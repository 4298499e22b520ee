"""Shapes of scenarios: who takes which place, and driven through pixels."""

import re
from itertools import permutations
from math import dist, pi
from pathlib import Path

import pytest

from control.assignment import crossings, positions_about
from control.errors import ControlError
from control.relative import Vector2
from control.shapes import place_of, polar_of, wedge
from pipeline.errors import ConfigError
from pipeline.placing import place_followers
from pipeline.rigs import connect
from pipeline.scenario import load_scenario, scenario_path
from pipeline.seeing import make_seeing
from pipeline.setup import make_setup
from pipeline.shaping import starts_of
from tests.pipeline.commands import echelon
from tests.pipeline.runs import run_scenario


def test_places_are_given_so_that_no_two_ways_cross() -> None:
    scenario = load_scenario("shapes")
    setup = make_setup(scenario)
    starts = starts_of(scenario)
    positions = positions_about(starts[1], starts, setup.follower.camera_offset)
    places = {pair.follower: pair.shape.at(0.0) for pair in setup.formation.pairs}
    ends = [(p.distance, p.bearing) for p in places.values()]
    wanted = [polar_of(place) for place in wedge(4, 0.25)]
    assert {(round(r, 6), round(psi, 6)) for r, psi in ends} == {
        (round(r, 6), round(psi, 6)) for r, psi in wanted
    }
    froms = [positions[robot] for robot in places]
    tos = [place_of(end) for end in ends]
    assert crossings(froms, tos) == 0
    ways = [sum(map(squared_way, froms, order)) for order in permutations(tos)]
    assert sum(map(squared_way, froms, tos)) == pytest.approx(min(ways))


def squared_way(one: Vector2, other: Vector2) -> float:
    """Squared distance [m^2]."""
    return dist(one, other) ** 2


def test_named_followers_keep_their_order_through_every_shape() -> None:
    followers = "formation.followers=[2, 3, 4, 5]"
    formation = make_setup(load_scenario("shapes", [followers])).formation
    by_robot = {pair.follower: pair.shape for pair in formation.pairs}
    assert [by_robot[k].at(11.0).distance for k in (2, 3, 4, 5)] == pytest.approx(
        [0.2, 0.4, 0.6, 0.8]
    )


def test_neighbours_follow_each_other() -> None:
    changes = ["formation.followers=[2, 3, 4, 5]", "formation.changes=[]"]
    formation = make_setup(
        load_scenario("shapes", [*changes, "formation.follow=neighbour"])
    ).formation
    assert {(p.leader, p.follower) for p in formation.pairs} == {(1, 2), (1, 3), (2, 4), (3, 5)}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("formation.places_m=[[0.1, 0.1]]", "either shape and spacing_m, or places_m"),
        ("formation.shape=ring", "'line', 'column', 'wedge' or 'circle'"),
        ("formation.followers=[2, 3, 9, 4]", "names robot 9, which is not among the robots"),
        ("formation.followers=[2, 3, 3, 4]", "robot 3 follows 1, 1"),
        ("formation.spacing_m=-0.1", "greater than 0"),
        ("formation.changes=[{at_s = 1.0, duration_s = 2.0}]", "a change needs shape"),
        (
            "formation.changes=[{at_s = 1.0, shape = 'line'}]",
            "a shape goes with spacing_m",
        ),
        (
            "formation.changes=[{at_s = 1.0, places_m = [[0.0, 0.3]]}]",
            "1 places for 4 followers",
        ),
        (
            "formation.changes=[{at_s = 1.0, shape = 'line', spacing_m = 0.3}, "
            "{at_s = 2.0, shape = 'column', spacing_m = 0.3}]",
            "begins before the one at 1 s has ended at 3 s",
        ),
    ],
)
def test_what_is_refused(change: str, message: str) -> None:
    with pytest.raises((ConfigError, ControlError)) as told:
        make_setup(load_scenario("shapes", [change]))
    assert message in str(told.value)


def test_open_places_need_starts_where_nobody_looks(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="where robot 3 stands is unknown"):
        make_setup(load_scenario(str(without_starts(tmp_path, (3,)))))


def test_shapes_are_driven_in_order_and_apart() -> None:
    _, result, _ = run_scenario("shapes")
    worst = max(f.distance_rms_m or 9.0 for f in result.followers)
    assert worst < 0.002
    assert max(f.bearing_rms_rad or 9.0 for f in result.followers) < pi / 180.0
    assert (result.min_clearance_m or 0.0) > 0.05


def test_a_follower_of_two_keeps_both_distances() -> None:
    _, result, _ = run_scenario("diamond", overrides=("duration_s=5.0",))
    score = next(f for f in result.followers if f.follower == 4)
    assert score.leaders == (2, 3)
    assert (score.distance_max_m or 9.0) < 0.004
    assert score.bearing_rms_rad is None
    assert score.settled_at_s is not None
    assert result.to_json()["followers"]["4"]["second_leader"] == 3


def test_a_camera_shows_who_is_nearest_to_which_place(tmp_path: Path) -> None:
    film, said = tmp_path / "film.avi", list[str]()
    echelon("render", "shapes", "--out", str(film), "--duration", "0.2")
    scenario = load_scenario(str(without_starts(tmp_path, (1, 2, 3, 4, 5))))
    rig = connect(scenario, str(film), None, 0, False)
    try:
        placed = place_followers(scenario, make_seeing(scenario), rig, said.append, lambda: False)
    finally:
        rig.close()
    assert placed.formation is not None
    known = make_setup(load_scenario("shapes")).formation
    assert placed.formation.followers == tuple(pair.follower for pair in known.pairs)
    assert "order of their places: 3, 5, 4, 2" in said[-1]


def test_looking_for_robots_ends_when_somebody_says_so(tmp_path: Path) -> None:
    film = tmp_path / "film.avi"
    echelon("render", "shapes", "--out", str(film), "--duration", "0.2")
    scenario = load_scenario(str(without_starts(tmp_path, (2,))))
    rig = connect(scenario, str(film), None, 0, False)
    try:
        seeing = make_seeing(scenario)
        assert place_followers(scenario, seeing, rig, print, lambda: True) is scenario
    finally:
        rig.close()


def test_a_film_without_a_robot_says_which(tmp_path: Path) -> None:
    film = tmp_path / "film.avi"
    echelon("render", "paper", "--out", str(film), "--duration", "0.2")
    scenario = str(without_starts(tmp_path, (1, 2, 3, 4, 5)))
    done = echelon("live", scenario, "--camera", str(film), "--set", "camera.other_sizes=scale")
    assert done.returncode == 2
    assert "before every robot was seen" in done.stderr


def without_starts(folder: Path, robots: tuple[int, ...]) -> Path:
    """The shapes scenario in which nobody says where some robots stand."""
    text, path = scenario_path("shapes").read_text(), folder / "open.toml"
    for robot in robots:
        text = re.sub(rf"(id = {robot}\n.*\n)start = .*\n", r"\1", text)
    path.write_text(text)
    return path
