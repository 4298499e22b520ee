"""Courses: an ideal follower is where h is nominal, and jumps of a plan are found."""

import numpy as np
import pytest

from control.course import Motion, ideal_follower, jumps, pair_course, planned_motion
from control.errors import ControlError
from control.formation import ShapeReference
from control.geometry import Pose2D, wrap_angle
from control.plan import PathSegment, PlannedPath
from control.relative import RelativeState, relative_state
from control.unicycle import Twist, advance_pose
from tests.control.courses import GAINS, LEFT, slow_pair

D = 0.05


def follower_at(leader: Pose2D, relative: RelativeState) -> Pose2D:
    """The pose from which a relative state is seen, (6) and (7)."""
    theta = leader.theta - relative.heading
    angle = leader.theta + relative.bearing
    x = leader.x + relative.distance * np.cos(angle) - D * np.cos(theta)
    return Pose2D(x, leader.y + relative.distance * np.sin(angle) - D * np.sin(theta), theta)


def test_an_ideal_follower_drives_the_nominal_path() -> None:
    course, _ = slow_pair(0.0)
    ideal, dt, h = ideal_follower(course, 0.4, D), 0.01, course.output
    leader = Pose2D(0.0, 0.0, 0.0)
    own = follower_at(leader, RelativeState(h[0, 0, 0], h[0, 1, 0], 0.4))
    for k in range(len(course.times) - 1):
        middle = (0.5 * (m.twist[:, k] + m.twist[:, k + 1]) for m in (course.leader, ideal.motion))
        leader, own = (
            advance_pose(pose, Twist(*twist), dt)
            for pose, twist in zip((leader, own), middle, strict=True)
        )
        relative = relative_state(leader, own, D)
        assert relative.distance == pytest.approx(h[0, 0, k + 1], abs=2e-3)
        assert abs(wrap_angle(relative.bearing - h[0, 1, k + 1])) < 5e-3


def test_accelerations_are_rates_of_the_velocities() -> None:
    ideal = ideal_follower(slow_pair(0.0)[0], 0.0, D)
    for motion in (ideal.motion, slow_pair(0.0)[0].leader):
        rates = np.gradient(motion.twist, 0.01, axis=1)[:, 50:290]
        assert rates == pytest.approx(motion.acceleration[:, 50:290], abs=0.02)


def test_jumps_are_where_curvature_jumps() -> None:
    path = PlannedPath(
        Pose2D(0.0, 0.0, 0.0), (PathSegment(1.0025), PathSegment(1.0, 2.5)), 0.5, 0.0, 1.0
    )
    times = np.arange(0.0, 4.0, 0.01)
    found = jumps(planned_motion(path.at(t) for t in times.tolist()), times)
    assert found == pytest.approx(np.array([[2.51], [0.0], [1.25]]), abs=1e-6)


def test_a_path_into_the_leader_is_refused() -> None:
    times = np.array([0.0, 0.01, 0.02])
    still = Motion(np.zeros((2, 3)), np.zeros((2, 3)))
    shape = [ShapeReference(0.2, LEFT)] * 3
    course = pair_course(times, still, shape, ((0.16, 0.0), (0.0, 0.0)), GAINS)
    with pytest.raises(ControlError, match=r"within 0.040 m of the leader, 0.05 m is the least"):
        ideal_follower(course, 0.0, D)
    with pytest.raises(ControlError, match="at least 2 samples"):
        pair_course(times[:1], still, shape[:1], ((0.0, 0.0), (0.0, 0.0)), GAINS)
