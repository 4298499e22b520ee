"""Where the real frames are, and what is known of them."""

import json
import os
from dataclasses import dataclass
from math import cos, hypot, radians
from pathlib import Path
from typing import Any

import pytest

REAL = Path(os.environ.get("ECHELON_REAL_FRAMES", "../shared/real"))
HERE = Path(__file__).parent
needs_frames = pytest.mark.skipif(
    not (REAL / "truth" / "agh_b").is_dir(),
    reason=f"{REAL}: no real frames there (ECHELON_REAL_FRAMES names their folder)",
)


def labels(folder: str, name: str) -> dict[str, Any]:
    """The labels of a frame."""
    found: dict[str, Any] = json.loads((REAL / "truth" / folder / f"{name}.json").read_text())
    return found


def names(folder: str) -> list[str]:
    """The frames of a folder."""
    return sorted(path.stem for path in (REAL / "truth" / folder).glob("*.json"))


@dataclass
class Tally:
    """How detections of `echelon locate --json` compare with the labels."""

    robots: int = 0
    right: int = 0
    wrong_ids: int = 0
    flips: int = 0
    false: int = 0

    def add(self, labelled: dict[str, Any], detections: list[dict[str, Any]]) -> None:
        """Count one frame; a detection within half a side of a robot is of that robot."""
        robots = list(labelled["robots"])
        self.robots += len(robots)
        for seen in detections:
            away = [hypot(r["x"] - seen["x_px"], r["y"] - seen["y_px"]) for r in robots]
            if not away or min(away) > 0.5 * robots[away.index(min(away))]["side_px"]:
                self.false += 1
                continue
            robot = robots.pop(away.index(min(away)))
            turned = cos(radians(robot["heading_deg"] - seen["heading_deg"]))
            self.wrong_ids += robot["id"] != seen["id"]
            self.flips += turned < 0.0
            self.right += robot["id"] == seen["id"] and turned > 0.9

    @property
    def recall(self) -> float:
        """Share of the robots that were found with their id and heading."""
        return self.right / self.robots
