"""Shipped layouts: every id rendered and found; scenario files that use them, and mistakes."""

from math import hypot
from pathlib import Path

import numpy as np
import pytest

from control.geometry import wrap_angle
from control.unicycle import UnicycleState
from datasets.cycle import RobotState
from pipeline.checks import check_scenario
from pipeline.cli.tagging import tags_scenario
from pipeline.config import Scenario
from pipeline.errors import ConfigError
from pipeline.layouts import layout_names, make_tags
from pipeline.rigs import make_renderer
from pipeline.scenario import load_scenario
from pipeline.seeing import make_seeing
from vision.frame import as_frame
from vision.light import PALETTE_LIGHT
from vision.twins import likenesses

CAMERA = ("camera.width_px=640", "camera.height_px=480", "camera.field_width_m=2.0")
SENSOR = ("sensor.read_noise=3.0", "sensor.blur_px=0.6", 'sensor.chroma="420"')
IDS = {"two_patch": 7, "triangle": 5, "quarters": 10, "vsss": 9, "vsss_corner": 3,
       "ssl_butterfly": 16}  # fmt: skip


def grid(scenario: Scenario, rng: np.random.Generator) -> tuple[RobotState, ...]:
    """All robots near the points of a grid of 5 x 4, wholly in the picture."""
    ids, (w, h) = [robot.id for robot in scenario.robots], (1.94, 1.455)
    cells = rng.permutation(20)[: len(ids)]
    cell = np.array([w / 5, h / 4])
    places = (np.column_stack(np.divmod(cells, 4)) + 0.5) * cell - (w / 2, h / 2)
    places += rng.uniform(-0.08, 0.08, places.shape)
    headings = rng.uniform(-np.pi, np.pi, len(ids))
    return tuple(
        RobotState(robot, UnicycleState(*place, heading, 0.0, 0.0))
        for robot, place, heading in zip(ids, places.tolist(), headings, strict=True)
    )


def test_the_layouts_are_these() -> None:
    assert layout_names() == sorted(IDS)


@pytest.mark.parametrize(
    ("layout", "changes"),
    [(name, ()) for name in sorted(IDS)]
    + [(name, ("tags.colors.team=blue",)) for name in ("triangle", "vsss", "ssl_butterfly")],
)
def test_every_id_of_a_shipped_layout_is_found(layout: str, changes: tuple[str, ...]) -> None:
    scenario = tags_scenario(layout, (*CAMERA, *SENSOR, *changes))
    seeing, renderer, rng = make_seeing(scenario), make_renderer(scenario), np.random.default_rng(4)
    assert len(seeing.tags.ids) == IDS[layout]
    for number in range(2):
        states = grid(scenario, rng)
        frame = as_frame(renderer.render(states, number / 30), number / 30, number)
        scene = seeing.detector.locate(frame, (), PALETTE_LIGHT)
        truth = {state.robot_id: state.state for state in states}
        assert [d.robot_id for d in scene.detections] == list(seeing.tags.ids)
        for seen in scene.detections:
            true = truth[seen.robot_id]
            assert hypot(seen.pose.x - true.x, seen.pose.y - true.y) < 0.5e-3
            assert abs(wrap_angle(seen.pose.theta - true.theta)) < np.radians(0.7)


@pytest.mark.parametrize("layout", sorted(IDS))
def test_all_ids_of_a_layout_differ_clearly(layout: str) -> None:
    tags = make_tags(tags_scenario(layout))
    every = likenesses(tags.tags, tags.background, tags.mirror_twins)
    assert min(like.differs for like in every if like.one != like.other) >= 0.12


@pytest.mark.parametrize("layout", ["triangle", "vsss", "vsss_corner", "ssl_butterfly"])
def test_both_teams_can_play_on_one_field(layout: str) -> None:
    scenario = tags_scenario(layout)
    blue = tuple(
        robot.model_copy(update={"id": f"blue {robot.id}", "colors": {"team": "blue"}})
        for robot in scenario.robots
    )
    both = scenario.model_copy(update={"robots": scenario.robots + blue})
    assert len(make_tags(both).tags) == 2 * IDS[layout]


def test_the_butterfly_is_the_leagues() -> None:
    scenario = tags_scenario("ssl_butterfly")
    tag = make_tags(scenario).tags[0]
    areas = [part.area for part in tag.parts[1:]]
    np.testing.assert_allclose(areas, np.pi / 4 * np.square([0.05, *[0.04] * 4]), rtol=1e-9)
    away = [float(np.hypot(*part.centroid)) for part in tag.parts[2:]]
    np.testing.assert_allclose(away, 0.065, atol=1e-5)
    # number 0: pink but for the dot at the back left
    assert [part.color for part in tag.parts[1:]] == ["yellow", "pink", "green", "pink", "pink"]
    dots = {tuple(part.color for part in tag.parts[2:]) for tag in make_tags(scenario).tags}
    assert len(dots) == 16


HEAD = 'name = "mine"\n[tags]\n'
ROBOTS = "[[robots]]\nid = 1\npattern = 0\n[[robots]]\nid = 2\npattern = 2\n"
LAYOUT = """
[layouts.mine]
side_m = 0.08
parts = [
    { name = "plate", color = "black", polygon_m = [[0.04, 0.04], [-0.04, 0.04], [-0.04, -0.04], [0.04, -0.04]] },
    { name = "tip", color = "yellow", polygon_m = [[0.035, 0.0], [0.005, 0.03], [0.005, -0.03]] },
    { name = "tail", color = "$tail", center_m = [-0.02, 0.0], diameter_m = 0.03 },
]
[layouts.mine.colors]
yellow = "#ffdc1e"
red = "#d2282d"
blue = "#285ad2"
[layouts.mine.patterns]
0 = { tail = "red" }
2 = { tail = "blue" }
"""  # noqa: E501 (a scenario file as users write it)


def scenario_of(folder: Path, text: str) -> Scenario:
    path = folder / "mine.toml"
    path.write_text(text)
    return load_scenario(str(path))


def test_a_layout_of_ones_own(tmp_path: Path) -> None:
    scenario = scenario_of(tmp_path, HEAD + 'layout = "mine"\n' + ROBOTS + LAYOUT)
    tags = make_tags(scenario)
    assert [tag.parts[2].color for tag in tags.tags] == ["red", "blue"]
    assert tags.tags[0].parts[2].area == pytest.approx(np.pi / 4 * 0.03**2)


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("pattern = 2", "pattern = 5", "robot 2: layout mine has no pattern 5; there are: 0, 2"),
        ("pattern = 2", "pattern = 0", "robots 1 and 2 wear the same tag"),
        ("pattern = 2", "marker = 2", 'robot 2: only layout "aruco" has markers, not mine'),
        ("pattern = 2", "", "needs colours for"),
        ('tail = "blue"', 'tail = "azure"', 'robot 2: tail = "azure" is not among'),
        ('color = "yellow"', 'color = "yelow"', 'layout mine: tip = "yelow" is not among'),
        ("side_m = 0.08", "side_m = 0.8", "side_m = 0.8, but its first part, plate, is 0.08 m"),
        (", diameter_m = 0.03", "", "give either polygon_m, or center_m and diameter_m"),
        ("diameter_m = 0.03", "diameter_m = 0.06", "of part tail covers part"),
        ('layout = "mine"', 'layout = "mime"', "there are: mine, quarters"),
        ('layout = "mine"', 'layout = "aruco"', "robot 1: layout \"aruco\" needs marker = NUMBER"),
    ],
)  # fmt: skip
def test_mistakes_are_refused(tmp_path: Path, right: str, wrong: str, message: str) -> None:
    text = HEAD + 'layout = "mine"\n' + ROBOTS + LAYOUT
    assert right in text
    with pytest.raises(ConfigError) as error:
        make_seeing(scenario_of(tmp_path, text.replace(right, wrong)))
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_mirror_twins_need_consent(tmp_path: Path) -> None:
    shipped = tags_scenario("triangle")
    strict = (Path(__file__).parents[2] / "datasets" / "layouts" / "triangle.toml").read_text()
    assert len(make_tags(shipped).tags) == 5
    lines = strict.replace("mirror_twins = true", "").replace("[[parts]]", "[[layouts.own.parts]]")
    lines = lines.replace("[colors]", "[layouts.own.colors]")
    lines = lines.replace("[patterns]", "[layouts.own.patterns]")
    text = HEAD + 'layout = "own"\n' + ROBOTS + "[layouts.own]\n" + lines
    with pytest.raises(ConfigError, match=r"robots 1 and 2 cannot be told apart: .*mirrored"):
        make_seeing(scenario_of(tmp_path, text))


def test_check_tells_of_tags_and_of_layouts_that_are_not_used(tmp_path: Path) -> None:
    twins = LAYOUT.replace("mine", "spare").replace('"blue" }', '"red" }')
    text = HEAD + 'layout = "triangle"\n' + ROBOTS + LAYOUT + twins
    found = {finding.topic: finding for finding in check_scenario(scenario_of(tmp_path, text))}
    assert found["tags"].holds
    assert "most alike are robots 1 and 2" in found["tags"].detail
    assert found["layout mine"].holds
    assert not found["layout spare"].holds
    assert "0 and 2 wear the same tag" in found["layout spare"].detail
