"""What lies on tags or beside them in the tests: strips, hands, cables and other robots."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from control.unicycle import UnicycleState
from datasets.cycle import RobotState
from datasets.floor import Floor
from datasets.render import Renderer
from tests.vision.worlds import BLACK, PAPER_SENSOR, REARS, YELLOW, World, make_world, paper_camera
from vision.frame import Frame, as_frame

Floats = NDArray[np.float64]

SIDE = 0.075  # of a plate [m]
KINDS = ("strip", "hand", "cable")
COLORS = (
    (120.0, 150.0, 200.0),  # skin
    (42.0, 46.0, 48.0),  # the floor's grey
    (200.0, 200.0, 200.0),
    *(tuple(map(float, color.bgr)) for color in (BLACK, YELLOW, *REARS[:4])),
)
_DOTS = 4  # along a pixel's side


class _Covering(Renderer):
    """A camera before which something lies on the robots."""

    cover: tuple[NDArray[np.float32], tuple[float, float, float]] | None = None

    def light(self, states: tuple[RobotState, ...], t: float) -> NDArray[np.float32]:
        image = super().light(states, t)
        if self.cover is not None:
            mask, color = self.cover
            image += mask[..., None] * (np.array(color, np.float32) - image)
        return image


class Desk:
    """A world whose robots may be covered, or stand anywhere, also not in the picture."""

    def __init__(
        self, size: tuple[int, int], robots: World | None = None, floor: Floor | None = None
    ) -> None:
        self.world = robots or make_world(camera=paper_camera(size))
        self.eye = self.world.eye
        colors = (YELLOW, *REARS)
        self._renderer = _Covering(
            self.eye.camera, self.eye.tags, colors, PAPER_SENSOR, floor=floor
        )

    def frame(
        self,
        poses: dict[RobotId, Floats],
        number: int = 0,
        cover: tuple[NDArray[np.float32], tuple[float, float, float]] | None = None,
    ) -> Frame:
        """A picture of robots at poses (3,), and what lies on them: coverage (H, W), BGR."""
        self._renderer.cover = cover
        states = tuple(
            RobotState(robot, UnicycleState(*pose.tolist(), 0.0, 0.0))
            for robot, pose in poses.items()
        )
        t = number / 30
        return as_frame(self._renderer.render(states, t), t, number)

    def cover(
        self, pose: Floats, kind: str, share: float, rng: np.random.Generator
    ) -> tuple[NDArray[np.float32], tuple[float, float, float]]:
        """Something of a random colour over a share of a plate, from a random side."""
        u, v = np.meshgrid(*[np.linspace(-0.5 * SIDE, 0.5 * SIDE, 61)] * 2)
        field, c, s = _field(kind, rng), np.cos(pose[2]), np.sin(pose[2])
        limits = np.quantile(field(u, v), _range(kind, share, rng))
        middle = self.eye.camera.tag_pixels(pose[None])[0]
        first, w = np.floor(middle).astype(int) - 40, 81
        step = np.arange(w)[:, None] + (np.arange(_DOTS) + 0.5) / _DOTS - 0.5
        x, y = np.meshgrid(step.ravel() + first[0], step.ravel() + first[1])
        dots = np.column_stack((x.ravel(), y.ravel()))
        floor = self.eye.camera.to_floor(dots, self.eye.camera.tag_height) - pose[:2]
        seen = field(c * floor[:, 0] + s * floor[:, 1], c * floor[:, 1] - s * floor[:, 0])
        near = np.hypot(*floor.T) < 0.12
        inside = (near & (seen >= limits[0]) & (seen <= limits[1])).reshape(x.shape)
        small = cv2.resize(inside.astype(np.float32), (w, w), interpolation=cv2.INTER_AREA)
        width, height = self.eye.camera.size_px
        mask = np.zeros((height + 2 * w, width + 2 * w), np.float32)
        mask[first[1] + w : first[1] + 2 * w, first[0] + w : first[0] + 2 * w] = small
        mask = cv2.GaussianBlur(mask[w:-w, w:-w], (0, 0), 0.6)
        return mask, COLORS[rng.integers(len(COLORS))]


def _field(kind: str, rng: np.random.Generator) -> Callable[[Floats, Floats], Floats]:
    """A function of the plate's frame of which the cover is a range of values."""
    angle, radius = rng.uniform(-np.pi, np.pi), rng.uniform(0.03, 0.08)
    c, s, aside = np.cos(angle), np.sin(angle), rng.uniform(-0.025, 0.025)
    if kind == "strip":
        return lambda u, v: c * u + s * v
    if kind == "hand":  # a round palm from outside
        x, y = (0.03 + radius) * c - aside * s, (0.03 + radius) * s + aside * c
        return lambda u, v: np.hypot(u - x, v - y)
    x, y = (radius + aside) * c, (radius + aside) * s  # bent
    return lambda u, v: np.abs(np.hypot(u - x, v - y) - radius)


def _range(kind: str, share: float, rng: np.random.Generator) -> tuple[float, float]:
    """Quantiles between which the plate is covered."""
    if kind != "strip":
        return 0.0, share
    start = rng.uniform(0.0, 1.0 - share) if rng.random() < 0.5 else 1.0 - share
    return start, start + share
