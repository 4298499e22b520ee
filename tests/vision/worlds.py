"""What the tests of the vision share: tags, an eye and a rendered camera."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from control.geometry import Pose2D, wrap_angle
from control.unicycle import UnicycleState
from datasets.cycle import RobotState
from datasets.render import Renderer
from datasets.sensor import SensorModel
from vision.camera import CameraModel, overhead_camera
from vision.eye import ChromaModel, Eye, Optics, make_eye
from vision.frame import Frame, as_frame
from vision.palette import NamedColor, palette_from_colors
from vision.scene import Detection
from vision.tags import Layout, Part, TagSet, polygon_array

BLACK = NamedColor("black", (12, 12, 12))
YELLOW = NamedColor("yellow", (30, 225, 255))
REARS = (
    NamedColor("red", (40, 20, 190)),
    NamedColor("green", (40, 140, 15)),
    NamedColor("blue", (210, 70, 30)),
    NamedColor("magenta", (180, 30, 200)),
    NamedColor("cyan", (180, 155, 10)),
    NamedColor("orange", (10, 110, 235)),
    NamedColor("violet", (200, 40, 110)),
)
PAPER_SENSOR = SensorModel(read_noise=3.0, blur_px=0.6, uneven_light=0.3, chroma="420")


def rectangle(x0: float, x1: float, y0: float, y1: float) -> NDArray[np.float64]:
    """An axis-parallel rectangle in millimetres."""
    corners = np.array([[x1, y1], [x0, y1], [x0, y0], [x1, y0]])
    return polygon_array(corners * 1e-3)


TWO_PATCH = Layout(
    "two_patch",
    (
        Part("plate", rectangle(-37.5, 37.5, -37.5, 37.5), "black"),
        Part("front", rectangle(3, 32, -32, 32), "yellow"),
        Part("rear", rectangle(-32, -3, -32, 32), "$rear"),
    ),
)
_UPPER = polygon_array(np.array([[32.5, 32.5], [32.5, -32.5], [-32.5, -32.5]]) * 1e-3)
_LEFT = polygon_array(np.array([[32.5, 32.5], [0, 0], [-32.5, 32.5]]) * 1e-3)
_BACK = polygon_array(np.array([[-32.5, 32.5], [0, 0], [-32.5, -32.5]]) * 1e-3)
TRIANGLE = Layout(
    "triangle",
    (
        Part("plate", rectangle(-37.5, 37.5, -37.5, 37.5), "black"),
        Part("team", _UPPER, "yellow"),
        Part("left", _LEFT, "$left"),
        Part("back", _BACK, "$back"),
    ),
    mirror_twins=True,
)


@dataclass(frozen=True)
class World:
    """An eye and the rendered camera it looks through."""

    eye: Eye
    renderer: Renderer

    def frame(self, poses: NDArray[np.float64], number: int = 0) -> Frame:
        """A picture of the robots at poses (R, 3), in the order of the tag set."""
        states = tuple(
            RobotState(robot_id, UnicycleState(*pose, 0.0, 0.0))
            for robot_id, pose in zip(self.eye.tags.ids, poses.tolist(), strict=True)
        )
        return as_frame(self.renderer.render(states, number / 30), number / 30, number)

    def scattered(self, rng: np.random.Generator, gap: float = 0.13) -> NDArray[np.float64]:
        """Random poses (R, 3) that lie wholly in the picture, `gap` apart [m]."""
        camera, tags = self.eye.camera, self.eye.tags
        low, high = np.ones(2), np.array(camera.size_px) - 2.0
        while True:
            corners = rng.uniform(low, high, (len(tags.tags), 2))
            floor = camera.to_floor(corners, camera.tag_height)
            turns = rng.uniform(0, 2 * np.pi, 16)
            reach = tags.outer_radius * np.column_stack((np.cos(turns), np.sin(turns)))
            rim = (floor[:, None] + reach).reshape(-1, 2)
            rim = np.column_stack((rim, np.full(len(rim), camera.tag_height)))
            pixels = camera.project(rim)
            away = np.hypot(*(floor[:, None] - floor).transpose(2, 0, 1)) + 9 * np.eye(len(floor))
            if (pixels > low).all() and (pixels < high).all() and away.min() > gap:
                return np.column_stack((floor, rng.uniform(-np.pi, np.pi, len(floor))))


def paper_camera(size_px: tuple[int, int] = (320, 240)) -> CameraModel:
    """The scenario's camera: 7.5 mm per pixel at 320 x 240, off the floor's origin."""
    return overhead_camera(size_px, 2.4, (0.5, 0.4), 2.5, 0.075)


def two_patch_tags(count: int = 3) -> TagSet:
    """Robots 1 to `count`, told apart by the rear patch."""
    return TagSet(
        tuple(TWO_PATCH.worn_by(n + 1, (("$rear", REARS[n].name),)) for n in range(count))
    )


def make_world(
    camera: CameraModel | None = None,
    tags: TagSet | None = None,
    sensor: SensorModel = PAPER_SENSOR,
    colors: tuple[NamedColor, ...] = (YELLOW, *REARS),
) -> World:
    """An eye whose optics are the renderer's."""
    camera, tags = camera or paper_camera(), tags or two_patch_tags()
    used = tuple(color for color in (*colors, BLACK) if color.name in tags.colors)
    chroma = ChromaModel(sensor.chroma, sensor.chroma_offset_px, sensor.chroma_upsampling)
    optics = Optics(sensor.blur_px, sensor.read_noise, chroma)
    palette = palette_from_colors(used, noise=max(sensor.read_noise, 1.0))
    return World(make_eye(camera, tags, palette, optics), Renderer(camera, tags, colors, sensor))


def errors_of(
    detections: tuple[Detection, ...], truth: dict[RobotId, NDArray[np.float64]]
) -> NDArray[np.float64]:
    """Pose errors (N, 3) of detections [m, m, rad]."""
    rows = []
    for d in detections:
        x, y, theta = truth[d.robot_id]
        rows.append((d.pose.x - x, d.pose.y - y, wrap_angle(d.pose.theta - theta)))
    return np.array(rows).reshape(-1, 3)


def pose_of(row: NDArray[np.float64]) -> Pose2D:
    """A row x, y, theta as a pose."""
    return Pose2D(*row.tolist())
