"""What looking for robots and following them takes, whoever drives them."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import radians

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from control.estimation import MotionModel
from control.geometry import Pose2D
from control.motion_model import UNCOMMANDED
from pipeline.config import Scenario
from pipeline.guard import SafetyRules
from pipeline.seeing import Seeing
from pipeline.shaping import starts_of
from vision.camera import CameraModel
from vision.tags import TagSet


@dataclass(frozen=True, slots=True)
class Lookout:
    """All that is constant about looking in a run.

    Attributes:
        seeing: finds the robots.
        motion: model of a robot that obeys the commands sent.
        free_motion: model of a robot nobody has commanded yet.
        pose_noise: covariance, shape (3, 3), added to that of the fit: what lens model, codec and
            printed tags do without the pixels telling [m^2, rad^2].
        rules: of safety.
        starts: where the scenario says that robots stand at first [m, m, rad].
    """

    seeing: Seeing
    motion: MotionModel
    free_motion: MotionModel
    pose_noise: NDArray[np.float64]
    rules: SafetyRules
    starts: Mapping[RobotId, Pose2D]

    @property
    def camera(self) -> CameraModel:
        """The calibrated camera."""
        return self.seeing.camera

    @property
    def tags(self) -> TagSet:
        """What the robots wear."""
        return self.seeing.tags


def make_lookout(scenario: Scenario, seeing: Seeing) -> Lookout:
    """Build all that is constant about looking in a run.

    Args:
        scenario: checked scenario.
        seeing: finds its robots.

    Returns:
        The lookout.
    """
    resting = scenario.startup.initial_rates == "rest"
    doubt = (0.03, 0.1) if resting else (0.5, 3.0)  # of a first velocity [m/s, rad/s]
    return Lookout(
        seeing=seeing,
        motion=_motion(scenario, believed_lag(scenario), doubt),
        free_motion=_motion(scenario, UNCOMMANDED, doubt),
        pose_noise=_pose_noise(scenario),
        rules=_rules(scenario),
        starts=starts_of(scenario),
    )


def believed_lag(scenario: Scenario) -> float:
    """The motor lag the host believes in: given, or the mean of the robots'.

    Args:
        scenario: checked scenario.

    Returns:
        Time constant of the motors [s].
    """
    lags = [robot.lag_s for robot in scenario.robots]
    return scenario.estimation.lag_s or sum(lags) / len(lags)


def _motion(scenario: Scenario, lag: float, doubt: tuple[float, float]) -> MotionModel:
    e = scenario.estimation
    accelerations = (e.acceleration_std_mps2, e.turn_acceleration_std_radps2)
    return MotionModel(lag, *accelerations, *doubt)


def _pose_noise(scenario: Scenario) -> NDArray[np.float64]:
    e = scenario.estimation
    return np.diag(np.square((e.pose_std_m, e.pose_std_m, radians(e.heading_std_deg))))


def _rules(scenario: Scenario) -> SafetyRules:
    s = scenario.safety
    return SafetyRules(
        s.slow_after_s, s.stop_after_s, s.camera_silent_s, s.good_frames_s, s.give_up_s,
        s.hold, s.drive_ambiguous, s.unmoved_m, s.together,
    )  # fmt: skip
