"""Robots that look alike, touch, or leave the picture: rendered truth, in mm and degrees."""

from dataclasses import replace
from math import degrees

import numpy as np
import pytest

from control.unicycle import UnicycleState
from datasets.cycle import RobotState
from tests.vision.worlds import TWO_PATCH, World, errors_of, make_world, pose_of
from vision.errors import VisionError
from vision.frame import Frame, as_frame
from vision.locate import Prediction, locate
from vision.scene import Detection, Scene
from vision.tags import TagSet

COVARIANCE = np.diag((0.003**2, 0.003**2, 0.05**2))
REARS = ("red", "red", "green", "red")


def alike_tags(count: int = 3) -> TagSet:
    """Robots 1, 2 and 4 wear the same tag."""
    worn = (TWO_PATCH.worn_by(n + 1, (("$rear", REARS[n]),)) for n in range(count))
    return TagSet(tuple(worn), look_alikes=True)


@pytest.fixture(scope="module")
def twins() -> World:
    return make_world(tags=alike_tags())


@pytest.fixture(scope="module")
def paper() -> World:
    return make_world()


def predicted(world: World, poses: np.ndarray, **marks: object) -> tuple[Prediction, ...]:
    pairs = zip(world.eye.tags.ids, poses, strict=True)
    return tuple(Prediction(r, pose_of(row), COVARIANCE, **marks) for r, row in pairs)  # type: ignore[arg-type]


def worst(scene: Scene, truth: np.ndarray, world: World) -> tuple[float, float]:
    """Largest errors of a scene [mm], [deg]."""
    errors = errors_of(scene.detections, dict(zip(world.eye.tags.ids, truth, strict=True)))
    return 1e3 * np.hypot(*errors[:, :2].T).max(), degrees(np.abs(errors[:, 2]).max())


def by_id(scene: Scene) -> dict[int | str, Detection]:
    return {d.robot_id: d for d in scene.detections}


def frame_without(world: World, truth: np.ndarray, hidden: tuple[int, ...]) -> Frame:
    """A picture in which some robots (by id) are not there."""
    states = tuple(
        RobotState(robot, UnicycleState(*row, 0.0, 0.0))
        for robot, row in zip(world.eye.tags.ids, truth.tolist(), strict=True)
        if robot not in hidden
    )
    return as_frame(world.renderer.render(states, 0.0), 0.0, 0)


def test_the_same_tag_twice_needs_the_users_word() -> None:
    with pytest.raises(VisionError, match=r"robots 1 and 2 wear the same tag.*look_alikes = true"):
        TagSet(alike_tags().tags)
    assert alike_tags().twins_of(1) == (2,)
    assert alike_tags(4).twins_of(2) == (1, 4)
    assert alike_tags().twins_of(3) == ()


def test_unknown_look_alikes_go_from_left_to_right_and_are_flagged(twins: World) -> None:
    truth = np.array([[0.1, 0.1, 0.3], [0.9, 0.7, 2.0], [0.5, 0.4, -1.0]])
    seen = by_id(locate(twins.frame(truth), twins.eye))
    assert [d.ambiguous for d in seen.values()] == [True, True, False]
    assert seen[1].pose.x < seen[2].pose.x


@pytest.mark.parametrize("gap", [0.0, 0.001, 0.02])
@pytest.mark.parametrize("turn", [0.0, np.pi, 1.2])
def test_look_alikes_that_pass_each_other_are_never_swapped(
    twins: World, gap: float, turn: float
) -> None:
    speed, rng = 0.02, np.random.default_rng(5)  # m per frame
    before = None
    for k in range(-6, 7):
        one = [0.5 + speed * k, 0.4, 0.0]
        other = [0.5 - speed * k, 0.4 + 0.075 + gap, turn if turn != 1.2 else 0.0]
        truth = np.array([one, other, [1.1, 0.1, k / 5]])
        near = truth if before is None else 2 * before[0] - before[1]
        near = near + rng.normal(0.0, 1.0, truth.shape) * (0.003, 0.003, 0.03)
        scene = locate(twins.frame(truth, k + 6), twins.eye, predicted(twins, near))
        assert len(scene.detections) == 3
        assert not any(d.ambiguous for d in scene.detections)
        position, heading = worst(scene, truth, twins)
        assert position < 0.8
        assert heading < 2.0
        before = (truth, truth if before is None else before[0])


def test_a_lost_look_alike_never_takes_the_others_place(twins: World) -> None:
    truth = np.array([[0.2, 0.2, 0.3], [0.5, 0.4, 2.0], [1.1, 0.1, 0.0]])
    near = truth.copy()
    near[0] = truth[1] + (0.012, -0.01, 0.05)  # lost, and expected where the other is
    near[1] += (-0.008, 0.004, 0.02)
    scene = locate(frame_without(twins, truth, (1,)), twins.eye, predicted(twins, near))
    assert list(by_id(scene)) == [2, 3]
    scene = locate(twins.frame(truth), twins.eye, predicted(twins, near))
    assert worst(scene, truth, twins)[0] < 1.0  # found elsewhere: by elimination
    assert not any(d.ambiguous for d in scene.detections)


def test_two_lost_at_once_go_by_nearness_and_are_flagged(twins: World) -> None:
    truth = np.array([[0.2, 0.2, 0.3], [0.7, 0.4, 2.0], [1.1, 0.1, 0.0]])
    near = truth + np.array([0.1, 0.05, 0.3])
    lost = predicted(twins, near, reach=1.0)
    scene = locate(twins.frame(truth), twins.eye, lost)
    assert worst(scene, truth, twins)[0] < 1.0
    assert [d.ambiguous for d in scene.detections] == [True, True, False]
    soon = tuple(replace(p, reach=0.3) for p in lost)  # neither can have come so far
    assert not any(d.ambiguous for d in locate(twins.frame(truth), twins.eye, soon).detections)


def test_a_doubt_stays_while_they_are_followed(twins: World) -> None:
    truth = np.array([[0.2, 0.2, 0.3], [0.7, 0.4, 2.0], [1.1, 0.1, 0.0]])
    followed = predicted(twins, truth, ambiguous=True)[:2] + predicted(twins, truth)[2:]
    scene = locate(twins.frame(truth), twins.eye, followed)
    assert [d.ambiguous for d in scene.detections] == [True, True, False]


def test_of_two_with_one_id_the_expected_one_is_kept_and_the_other_named(paper: World) -> None:
    truth = [(2, (0.5, 0.7, 2.0)), (2, (0.1, 0.1, 0.0)), (3, (1.2, 0.2, -1.0))]
    for own, impostor in ((0, 1), (1, 0)):
        states = tuple(RobotState(r, UnicycleState(*p, 0.0, 0.0)) for r, p in truth)
        frame = as_frame(paper.renderer.render(states, 0.0), 0.0, 0)
        x, y, theta = truth[own][1]
        for off in (0.0, 0.12):  # followed; lost, and searched for
            place = pose_of(np.array([x + off, y, theta]))
            scene = locate(frame, paper.eye, (Prediction(2, place, COVARIANCE, off),))
            assert list(by_id(scene)) == [2, 3]
            assert by_id(scene)[2].pose.x == pytest.approx(x, abs=1e-3)
            there = paper.eye.camera.pixel_pose(pose_of(np.array(truth[impostor][1])))
            told = [r.reason for r in scene.rejected if np.hypot(r.x - there.x, r.y - there.y) < 5]
            assert any("2" in reason for reason in told), scene.rejected


SIDE = 0.075
TOUCHING = {
    "side by side": lambda g: [(0.0, 0.0, 0.4), (0.0, SIDE + g, 0.4), (0.0, -SIDE - g, 0.4)],
    "nose to tail": lambda g: [(0.0, 0.0, 0.4), (SIDE + g, 0.0, 0.4), (-SIDE - g, 0.0, 0.4)],
    "corner to corner": lambda g: [(0, 0, 0.4), (SIDE + g, SIDE + g, 0.4), (-SIDE - g, SIDE, 0.4)],
}


@pytest.mark.parametrize("how", TOUCHING)
@pytest.mark.parametrize("gap", [0.0, 0.001])
@pytest.mark.parametrize("follow", [False, True])
def test_touching_plates(paper: World, how: str, gap: float, follow: bool) -> None:
    rng = np.random.default_rng(8)
    c, s = np.cos(0.4), np.sin(0.4)
    for k in range(6):
        local = np.array(TOUCHING[how](gap))
        truth = local.copy()
        truth[:, 0] = 0.5 + 0.05 * k + c * local[:, 0] - s * local[:, 1]
        truth[:, 1] = 0.4 - 0.03 * k + s * local[:, 0] + c * local[:, 1]
        near = truth + rng.normal(0.0, 1.0, truth.shape) * (0.003, 0.003, 0.05)
        scene = locate(paper.frame(truth, k), paper.eye, predicted(paper, near) if follow else ())
        assert [d.robot_id for d in scene.detections] == [1, 2, 3]
        position, heading = worst(scene, truth, paper)
        assert position < 0.8
        assert heading < 1.5


def test_a_tag_at_the_border_is_never_wrong(paper: World) -> None:
    rng = np.random.default_rng(13)
    for number in range(30):
        cut = rng.uniform(-0.2, 0.3)
        edge = paper.eye.camera.to_floor(np.array([[-0.5, 60.0 + 4 * number]]), 0.075)[0]
        truth = np.array([[edge[0] + (0.5 - cut) * SIDE, edge[1], rng.choice((0.0, 1.57, 3.14))],
                          [0.5, 0.7, 2.0], [1.2, 0.2, -1.0]])  # fmt: skip
        near = truth + rng.normal(0.0, 1.0, truth.shape) * (0.002, 0.002, 0.03)
        scene = locate(paper.frame(truth, number), paper.eye, predicted(paper, near))
        position, heading = worst(scene, truth, paper)
        assert position < 1.0
        assert heading < 3.0
        if 1 not in by_id(scene):
            assert any("cut by the image border" in r.reason for r in scene.rejected)
