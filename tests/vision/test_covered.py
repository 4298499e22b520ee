"""Robots partly under something, or beside somebody: rendered truth, in mm and degrees."""

from math import degrees

import numpy as np
import pytest
from numpy.typing import NDArray

from control.command import RobotId
from control.geometry import wrap_angle
from tests.vision.covers import KINDS, SIDE, Desk
from tests.vision.worlds import pose_of
from vision.frame import Frame
from vision.locate import Prediction, locate
from vision.scene import Scene

Floats = NDArray[np.float64]

SIZES = ((320, 240), (640, 480))
OFF = np.array([0.002, 0.002, 0.03])  # of predictions, standard deviations [m, m, rad]
COVERED = (  # size, covered share, seen at least, rms mm and deg, worst mm and deg, mean NEES
    ((320, 240), 0.1, 0.95, 0.7, 0.8, 2.0, 3.0, 14.0),
    ((320, 240), 0.2, 0.90, 0.5, 0.8, 3.0, 5.0, 6.0),
    ((320, 240), 0.3, 0.78, 0.8, 1.2, 3.0, 6.0, 7.0),
    ((320, 240), 0.4, 0.60, 0.8, 1.2, 3.0, 6.0, 8.0),
    ((640, 480), 0.1, 0.97, 0.12, 0.15, 0.5, 0.5, 5.0),
    ((640, 480), 0.2, 0.97, 0.12, 0.15, 0.5, 0.5, 5.0),
    ((640, 480), 0.3, 0.97, 0.15, 0.30, 0.8, 1.6, 5.0),
    ((640, 480), 0.4, 0.80, 0.20, 0.30, 0.8, 1.6, 6.0),
)


@pytest.fixture(scope="module", params=SIZES, ids=["320x240", "640x480"])
def desk(request: pytest.FixtureRequest) -> Desk:
    return Desk(request.param)


def placed(desk: Desk, rng: np.random.Generator) -> Floats:
    """A random pose (3,) wholly in the picture."""
    return np.array([*desk.world.scattered(rng)[0, :2], rng.uniform(-np.pi, np.pi)])


def followed(
    desk: Desk, frame: Frame, poses: dict[RobotId, Floats], rng: np.random.Generator
) -> Scene:
    """What is seen of robots that are expected near poses (3,)."""
    near = tuple(
        Prediction(robot, pose_of(pose + rng.normal(size=3) * OFF), np.diag(OFF**2))
        for robot, pose in poses.items()
    )
    return locate(frame, desk.eye, near)


def errors_in(scene: Scene, poses: dict[RobotId, Floats]) -> tuple[Floats, Floats]:
    """Errors (N, 3) of those found [mm, mm, deg], and their squares by their covariances."""
    rows, nees = [], []
    for d in scene.detections:
        away = np.array([d.pose.x, d.pose.y, d.pose.theta]) - poses[d.robot_id]
        away[2] = wrap_angle(away[2])
        rows.append((1e3 * away[0], 1e3 * away[1], degrees(away[2])))
        nees.append(away @ np.linalg.solve(d.covariance, away))
    return np.array(rows).reshape(-1, 3), np.array(nees)


@pytest.mark.parametrize(
    ("size", "share", "least", "mm", "deg", "worst_mm", "worst_deg", "nees"), COVERED
)
def test_a_partly_covered_robot_is_right_or_not_seen(
    size: tuple[int, int], share: float, least: float, mm: float, deg: float, worst_mm: float,
    worst_deg: float, nees: float,
) -> None:  # fmt: skip
    desk, rng = Desk(size), np.random.default_rng(int(100 * share))
    errors, doubts = [], []
    for number in range(60):
        robot: RobotId = desk.eye.tags.ids[number % 3]
        poses = {robot: placed(desk, rng)}
        cover = desk.cover(poses[robot], KINDS[number % 7 % 3], share, rng)
        scene = followed(desk, desk.frame(poses, number, cover), poses, rng)
        assert {d.robot_id for d in scene.detections} <= {robot}
        if scene.detections:
            off, square = errors_in(scene, poses)
            errors.append(off[0])
            doubts.append(square[0])
        else:
            reasons = [r.reason for r in scene.rejected]
            assert any(reason.startswith(("covered", "colours")) for reason in reasons), reasons
    off = np.array(errors)
    away, turn = np.hypot(off[:, 0], off[:, 1]), np.abs(off[:, 2])
    assert len(off) >= least * 60
    assert np.sqrt((away**2).mean()) <= mm
    assert np.sqrt((turn**2).mean()) <= deg
    assert away.max() <= worst_mm
    assert turn.max() <= worst_deg
    assert np.mean(doubts) <= nees


@pytest.mark.parametrize("gap", [0.0, 0.002, 0.005, 0.01, 0.02])
def test_a_neighbour_takes_nothing_from_a_robot(desk: Desk, gap: float) -> None:
    rng, errors = np.random.default_rng(77), []
    for number in range(30):
        a, b = rng.permutation(desk.eye.tags.ids)[:2].tolist()
        poses = {a: placed(desk, rng)}
        poses[b] = beside(poses[a], gap, rng)
        if not in_picture(desk, poses[b]):
            continue
        scene = followed(desk, desk.frame(poses, number), poses, rng)
        assert {d.robot_id for d in scene.detections} == {a, b}
        errors.append(errors_in(scene, poses)[0])
    off = np.concatenate(errors) * (desk.eye.camera.size_px[0] / 320)
    assert len(off) > 40
    assert np.hypot(off[:, 0], off[:, 1]).max() < 0.8
    assert np.abs(off[:, 2]).max() < 1.2
    assert np.sqrt((off[:, :2] ** 2).sum(axis=1).mean()) < 0.15


def beside(pose: Floats, gap: float, rng: np.random.Generator) -> Floats:
    """A pose beside a plate: any side, any heading, a gap between the two [m]."""
    out, turn = pose[2] + rng.integers(4) * np.pi / 2, rng.uniform(-np.pi, np.pi)
    reach = 0.5 * SIDE * (1.0 + abs(np.cos(turn - out)) + abs(np.sin(turn - out))) + gap
    slide = rng.uniform(-0.03, 0.03)
    c, s = np.cos(out), np.sin(out)
    return np.array([pose[0] + c * reach - s * slide, pose[1] + s * reach + c * slide, turn])


def in_picture(desk: Desk, pose: Floats) -> bool:
    """Whether a whole plate is in the picture."""
    pixel, (width, height) = desk.eye.camera.tag_pixels(pose[None])[0], desk.eye.camera.size_px
    rim = width / 32
    return bool((pixel > rim).all() and (pixel < (width - rim, height - rim)).all())
