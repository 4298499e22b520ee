"""Errors of many detections against the truth, added up."""

from dataclasses import dataclass, field
from math import degrees

import numpy as np

from control.geometry import wrap_angle
from datasets.cycle import RobotState
from vision.scene import Scene


@dataclass
class Errors:
    """What was found, missed and imagined.

    Attributes:
        side: of the tags; a detection within half of it is right [m].
        robots: how many there were to be found.
        false_ids: detections elsewhere.
        off: dx, dy, turn of the right ones [m, m, rad].
    """

    side: float
    robots: int = 0
    false_ids: int = 0
    off: list[tuple[float, float, float]] = field(default_factory=list)

    def add(self, scene: Scene, truth: tuple[RobotState, ...]) -> None:
        """Compare one frame.

        Args:
            scene: what was seen.
            truth: robots wholly in the picture.
        """
        true = {robot.robot_id: robot.state for robot in truth}
        self.robots += len(true)
        for found in scene.detections:
            state = true.get(found.robot_id)
            if state is None:
                self.false_ids += 1
                continue
            dx, dy = found.pose.x - state.x, found.pose.y - state.y
            if np.hypot(dx, dy) < 0.5 * self.side:
                self.off.append((dx, dy, wrap_angle(found.pose.theta - state.theta)))
            else:
                self.false_ids += 1

    @property
    def recall(self) -> float:
        """Share of the robots found where they are."""
        return len(self.off) / max(self.robots, 1)

    @property
    def position_mm(self) -> float:
        """Rms distance of the right detections [mm]; NaN without any."""
        off = np.array(self.off).reshape(-1, 3)[:, :2]
        return 1e3 * float(np.sqrt((off**2).sum(axis=1).mean())) if len(off) else float("nan")

    @property
    def heading_deg(self) -> float:
        """Rms turn of the right detections [deg]; NaN without any."""
        off = np.array(self.off).reshape(-1, 3)[:, 2]
        return degrees(float(np.sqrt((off**2).mean()))) if len(off) else float("nan")
