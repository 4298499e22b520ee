"""Light that jumps, drifts and comes back, on robots that are tracked; and who may teach it."""

from dataclasses import replace

import numpy as np
import pytest

from control.geometry import Pose2D
from datasets.render import Renderer
from datasets.sensor import Change
from tests.vision.worlds import (
    PAPER_SENSOR,
    REARS,
    TWO_PATCH,
    YELLOW,
    World,
    make_world,
    two_patch_tags,
)
from vision.light import BRIGHTNESSES, PALETTE_LIGHT
from vision.locate import Prediction, locate
from vision.scene import Scene
from vision.tags import TagSet

POSES = np.array([[0.1, 0.1, 0.3], [0.5, 0.7, 2.0], [1.2, 0.2, -1.0]])
MOTION = (0.002, 0.001, 0.01)  # from frame to frame
SHARP = np.diag((1e-6, 1e-6, 1e-4))
Gains = tuple[float, float, float]


def lamp(*steps: tuple[int, Gains], over: int = 0) -> World:
    """The paper's world; from a frame on, blue, green and red have gains, reached over frames."""
    changes = tuple(Change((frame - 0.5) / 30.0, gains, over / 30.0) for frame, gains in steps)
    if all(len(set(gains)) == 1 for _, gains in steps):
        return make_world(sensor=replace(PAPER_SENSOR, exposure_changes=changes))
    return make_world(sensor=replace(PAPER_SENSOR, white_balance_changes=changes))


def tracked(world: World, frames: int) -> list[Scene]:
    """Robots on their way, each expected where its last sighting leads, if there is one."""
    light, expected, scenes = PALETTE_LIGHT, (), []
    for number in range(frames):
        frame = world.frame(POSES + number * np.array(MOTION), number)
        scene = locate(frame, world.eye, expected, light)
        scenes.append(scene)
        light, (dx, dy, turn) = scene.light, MOTION
        expected = tuple(
            Prediction(d.robot_id, Pose2D(p.x + dx, p.y + dy, p.theta + turn), SHARP)
            for d in scene.detections
            for p in [d.pose]
        )
    return scenes


def longest_gap(scenes: list[Scene]) -> int:
    """Most frames in a row in which one robot was not seen."""
    worst = 0
    for robot_id in (1, 2, 3):
        gap = 0
        for scene in scenes:
            gap = 0 if any(d.robot_id == robot_id for d in scene.detections) else gap + 1
            worst = max(worst, gap)
    return worst


# The task allows 6 frames, 0.2 s; measured is 0.
LIGHTS = [(0.4, 0.4, 0.4), (1.6, 1.6, 1.6), (0.7, 1.0, 1.4)]  # blue, green, red


@pytest.mark.parametrize("gains", LIGHTS, ids=str)
@pytest.mark.parametrize("over", [0, 60])
def test_nobody_is_lost_when_the_light_jumps_or_drifts(gains: Gains, over: int) -> None:
    assert longest_gap(tracked(lamp((6, gains), over=over), 20 + over)) == 0


@pytest.mark.parametrize("gains", LIGHTS, ids=str)
def test_the_light_is_known_after_a_jump_and_returns_with_the_lamp(gains: Gains) -> None:
    scenes = tracked(lamp((4, gains), (12, (1.0, 1.0, 1.0))), 20)
    assert longest_gap(scenes) == 0
    np.testing.assert_allclose(scenes[10].light.gains, gains, rtol=0.03)
    np.testing.assert_allclose(scenes[-1].light.gains, 1.0, rtol=0.03)


def test_the_light_returns_slowly_too() -> None:
    scenes = tracked(lamp((4, (0.4, 0.4, 0.4)), (50, (1.0, 1.0, 1.0)), over=40), 100)
    assert longest_gap(scenes) == 0
    np.testing.assert_allclose(scenes[-1].light.gains, 1.0, rtol=0.1)


def expected_at(poses: np.ndarray) -> tuple[Prediction, ...]:
    """Robots 1 to 3, expected at poses."""
    return tuple(Prediction(n, Pose2D(*pose), SHARP) for n, pose in enumerate(poses.tolist(), 1))


def test_an_impostor_does_not_teach_the_light() -> None:
    right = make_world()
    others = TagSet(tuple(TWO_PATCH.worn_by(n, (("$rear", REARS[n + 2].name),)) for n in (1, 2, 3)))
    wrong = World(right.eye, Renderer(right.eye.camera, others, (YELLOW, *REARS), PAPER_SENSOR))
    light = PALETTE_LIGHT
    for number in range(20):
        scene = locate(wrong.frame(POSES, number), right.eye, expected_at(POSES), light)
        assert scene.detections == ()
        light = scene.light
    assert light.gains.tolist() == [1.0, 1.0, 1.0]


def test_robots_that_were_exchanged_do_not_teach_the_light() -> None:
    world, light = make_world(), PALETTE_LIGHT
    for number in range(20):
        scene = locate(world.frame(POSES[[1, 2, 0]], number), world.eye, expected_at(POSES), light)
        assert [d.robot_id for d in scene.detections] == [1, 2, 3]
        light = scene.light
    np.testing.assert_allclose(light.gains, 1.0, atol=0.02)


@pytest.mark.parametrize("factor", [0.3, 0.4, 0.55, 0.75, 1.4, 1.7])
def test_unknown_robots_are_found_in_any_light(factor: float) -> None:
    world = lamp((0, (factor,) * 3))
    scenes = tracked(world, len(BRIGHTNESSES) + 2)
    assert all(len(scene.detections) == 3 for scene in scenes[len(BRIGHTNESSES) - 1 :])


def test_brightnesses_are_supposed_in_turn_while_nobody_is_found() -> None:
    world, light = make_world(tags=two_patch_tags(3)), PALETTE_LIGHT
    away = np.array([[50.0, 50.0, 0.0]] * 3)
    told = []
    for number in range(2 * len(BRIGHTNESSES)):
        light = locate(world.frame(away, number), world.eye, (), light).light
        told.append(light.gains.tolist())
    wanted = np.repeat(np.roll(BRIGHTNESSES * 2, -1)[:, None], 3, axis=1)
    np.testing.assert_allclose(told, wanted, rtol=1e-9)
