"""Things, clutter, shadows and glare: each covers, takes or adds exactly what it says."""

import numpy as np
import pytest

from datasets.clutter import Clutter
from datasets.coverage import polygon_coverage
from datasets.errors import SimulationError
from datasets.floor import Floor
from datasets.lights import Glare, Shadow
from datasets.paths import Wandering, Waypoints
from datasets.render import Renderer
from datasets.sensor import SensorModel
from datasets.surroundings import Surroundings
from datasets.things import HAND, Thing, cable_outline, outline_array, regular_outline
from tests.scenes.field import COLORS, SIDE, robot, two_patch_tags
from vision.camera import overhead_camera

CAMERA = overhead_camera((320, 240), 2.4, (0.5, 0.4), 2.5, SIDE)
CLEAN = SensorModel(read_noise=0.0, blur_px=0.0, chroma="444")
GREY = Floor(bgr=(100.0, 100.0, 100.0), texture=0.0, line_width=0.0)
BOX = outline_array([[0.2, 0.1], [-0.2, 0.1], [-0.2, -0.1], [0.2, -0.1]])
ROBOTS = (robot(1, 0.5, 0.4, 0.3), robot(2, 1.1, 0.9, -1.0))


def standing(x: float, y: float, theta: float = 0.0) -> Waypoints:
    """A place where something stays."""
    return Waypoints((0.0,), ((x, y, theta),))


def drawn(
    surroundings: Surroundings, t: float = 0.0, sensor: SensorModel = CLEAN, seed: int = 0
) -> np.ndarray:
    """Two robots in their surroundings."""
    renderer = Renderer(CAMERA, two_patch_tags(2), COLORS, sensor, seed, GREY, surroundings)
    return renderer.render(ROBOTS, t).astype(float)


def test_an_occluder_hides_exactly_its_polygon() -> None:
    path = standing(0.53, 0.42, 0.4)
    over = Thing(BOX, (10.0, 200.0, 30.0), path, height=0.3)
    without, seen = drawn(Surroundings()), drawn(Surroundings((over,)))
    c, s = np.cos(0.4), np.sin(0.4)
    corners = BOX @ np.array([[c, s], [-s, c]]) + (0.53, 0.42)
    pixels = CAMERA.project(np.column_stack((corners, np.full(4, 0.3)))) + 0.5
    covered = polygon_coverage(pixels, (240, 320))[..., None]
    expected = covered * (10.0, 200.0, 30.0) + (1.0 - covered) * without
    np.testing.assert_allclose(seen, expected, atol=1.01)  # 8 bits, twice


def test_what_lies_on_the_floor_is_hidden_by_robots() -> None:
    under = Thing(BOX, (10.0, 200.0, 30.0), standing(0.5, 0.4))
    without, seen = drawn(Surroundings()), drawn(Surroundings((under,)))
    robot_only = np.abs(without - 100.0).sum(axis=2) > 60.0
    inner = robot_only & np.roll(robot_only, 1, 0) & np.roll(robot_only, -1, 0)
    inner &= np.roll(robot_only, 1, 1) & np.roll(robot_only, -1, 1)
    np.testing.assert_array_equal(seen[inner], without[inner])
    assert (np.abs(seen - (10.0, 200.0, 30.0)).max(axis=2) < 1.0).sum() > 1000


def test_things_come_and_go_and_move() -> None:
    path = Waypoints((1.0, 3.0), ((0.0, 0.0, 0.0), (1.0, 0.5, 1.0)))
    np.testing.assert_allclose(path.at(np.array([0.0, 2.0, 9.0]))[1], (0.5, 0.25, 0.5))
    thing = Thing(BOX, (255.0, 255.0, 255.0), path, 0.3, begin=1.0, end=2.5)
    away = drawn(Surroundings())
    for t, there in ((0.99, False), (1.0, True), (2.49, True), (2.5, False)):
        assert (drawn(Surroundings((thing,)), t) != away).any() == there


def test_a_calm_and_a_busy_scene_are_the_same_picture() -> None:
    """Composing the whole scene gives what windows give, up to rounding."""
    sensor = SensorModel(read_noise=0.0, blur_px=0.8, uneven_light=0.4, chroma="444")
    idle = Thing(BOX, (0.0, 0.0, 0.0), standing(0.0, 0.0), 0.3, begin=5.0)
    calm, busy = (drawn(Surroundings(things), 0.0, sensor) for things in ((), (idle,)))
    np.testing.assert_allclose(busy, calm, atol=1.0)
    assert (busy != calm).mean() < 1e-3


def test_a_shadow_takes_its_share_and_fades_at_its_rim() -> None:
    shadow = Shadow(standing(0.5, 0.4), radius=0.3, softness=0.1, darkness=0.6)
    share = drawn(Surroundings(shadows=(shadow,))) / np.maximum(drawn(Surroundings()), 1.0)
    x, y = CAMERA.project(np.array([[0.5, 0.6, 0.0], [0.5, 0.7, 0.0], [0.5, 0.76, 0.0]])).T.round()
    inside, rim, outside = (share[int(b), int(a)].mean() for a, b in zip(x, y, strict=True))
    assert inside == pytest.approx(0.4, abs=0.01)
    assert rim == pytest.approx(0.7, abs=0.05)
    assert outside == 1.0
    tag = CAMERA.pixel_pose(ROBOTS[0].state.pose)
    assert share[round(tag.y) - 2, round(tag.x)].mean() == pytest.approx(0.4, abs=0.05)


def test_glare_adds_white_light_and_is_clipped() -> None:
    glare = Glare(0.5, 0.4, width=0.05, strength=400.0)
    added = drawn(Surroundings(glares=(glare,))) - drawn(Surroundings())
    x, y = CAMERA.project(np.array([[0.5, 0.4, 0.0]]))[0].round().astype(int)
    assert drawn(Surroundings(glares=(glare,)))[y, x].min() == 255.0  # on the robot
    place = CAMERA.to_floor(np.array([[x, y - 14]], float), 0.0)[0]
    profile = np.exp(-0.5 * ((place - (0.5, 0.4)) ** 2).sum() / 0.05**2)
    assert added[y - 14, x] == pytest.approx(np.full(3, 400.0 * profile), abs=1.0)


def test_clutter_repeats_by_seed_and_lies_on_the_floor() -> None:
    clutter = Clutter(30, ((0.0, 0.0, 255.0), (255.0, 0.0, 0.0)), (0.02, 0.05), 0.3, 0.2)
    one, same, other = (drawn(Surroundings(clutter=clutter), 1.0, seed=s) for s in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert (one != other).any()
    later = drawn(Surroundings(clutter=clutter), 2.0, seed=1)
    moved = (later != one).any(axis=2).mean()
    assert 0.0 < moved < 0.02
    things = clutter.things(np.array((-1.0, -2.0)), np.array((1.0, 2.0)), 3)
    assert len(things) == 30
    widths = [np.hypot(*thing.outline.T).max() * 2.0 for thing in things]
    assert 0.02 <= min(widths) <= max(widths) <= 0.05


def test_wandering_keeps_to_its_reach_and_its_speed() -> None:
    path = Wandering((0.3, -0.2), (0.5, 0.2), 0.15, np.random.default_rng(1))
    t = np.arange(0.0, 400.0, 0.01)
    places = path.at(t)[:, :2]
    assert (np.abs(places - (0.3, -0.2)) <= (0.5, 0.2)).all()
    speed = np.sqrt(np.mean((np.diff(places, axis=0) / 0.01) ** 2, axis=0))
    np.testing.assert_allclose(speed, 0.15, rtol=0.1)


def test_moving_things_blur_over_the_exposure() -> None:
    path = Waypoints((0.0, 1.0), ((0.0, 0.4, 0.0), (1.0, 0.4, 0.0)))  # 1 m/s
    thing = Thing(BOX, (255.0, 255.0, 255.0), path, 0.3)
    masks = []
    for shutter in (CLEAN.shutter(240), SensorModel(exposure_time=0.05).shutter(240)):
        seen = thing.mask(CAMERA, shutter, 0.5, 0, (240, 320))
        assert seen is not None
        masks.append(seen[1])
    assert masks[0].sum() == pytest.approx(masks[1].sum(), rel=1e-3)
    way = 0.05 * 320 / 2.4 * 2.5 / 2.2
    assert masks[1].shape[1] - masks[0].shape[1] == pytest.approx(way, abs=2.0)  # whole pixels


def test_outlines() -> None:
    def area(points: np.ndarray) -> float:
        x, y = points.T
        return abs(0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))

    assert area(cable_outline([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]], 0.01)) == pytest.approx(0.01)
    assert area(regular_outline(4, 1.0)) == pytest.approx(2.0)
    assert 0.04 < area(HAND) < 0.08  # m^2: a hand, and a forearm of half a metre
    for wrong in (lambda: cable_outline([[0.0, 0.0]], 0.01),
                  lambda: cable_outline([[0.0, 0.0], [0.0, 0.0]], 0.01),
                  lambda: Thing(BOX[:2], (0.0, 0.0, 0.0), standing(0.0, 0.0)),
                  lambda: Waypoints((1.0, 1.0), ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))),
                  lambda: Clutter(3, ((0.0, 0.0, 0.0),), (0.05, 0.02)),
                  lambda: Shadow(standing(0.0, 0.0), -1.0),
                  lambda: Glare(0.0, 0.0, 0.0)):  # fmt: skip
        with pytest.raises(SimulationError):
            wrong()
