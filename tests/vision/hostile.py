"""Cameras, pictures, predictions and lights that nobody would wish for; also a fuzz of its own.

Compiled functions do not check their indices. Once for every change to them:
`NUMBA_BOUNDSCHECK=1 NUMBA_CACHE_DIR=$(mktemp -d) python -m tests.vision.hostile 600`
"""

import sys
from time import perf_counter

import cv2
import numpy as np

from control.geometry import Pose2D
from control.unicycle import UnicycleState
from datasets.cycle import RobotState
from datasets.render import Renderer
from datasets.sensor import SensorModel
from pipeline.layouts import make_tags, shipped_layout
from pipeline.scenario import check_tables
from pipeline.seeing import named_colors, scenario_palette
from vision.camera import CameraModel, overhead_camera
from vision.eye import ChromaModel, Eye, Optics, Thresholds, make_eye
from vision.frame import as_frame
from vision.light import Light
from vision.locate import Prediction, locate
from vision.palette import NamedColor
from vision.scene import Scene
from vision.tags import TagSet

LAYOUTS = ("two_patch", "triangle", "quarters", "vsss", "vsss_corner", "ssl_butterfly")
ODD = (np.nan, np.inf, -np.inf, 1e6, -1e300, 1e17)
Rng = np.random.Generator


class Room:
    """A camera and tags, drawn at random."""

    def __init__(self, rng: Rng, most_px: int = 320) -> None:
        """Draw a layout, some of its robots, a camera and thresholds."""
        layout = str(rng.choice(LAYOUTS))
        patterns = list(shipped_layout(layout).patterns)
        count = int(rng.integers(1, min(len(patterns), 6) + 1))
        robots = [{"id": n, "pattern": patterns[n]} for n in range(count)]
        tables = {"name": "hostile", "tags": {"layout": layout}, "robots": robots}
        scenario = check_tables(tables, "hostile")
        self.tags: TagSet = make_tags(scenario)
        self.colors: tuple[NamedColor, ...] = named_colors(scenario)
        self.camera = random_camera(rng, self.tags.tags[0].side, most_px)
        chroma = ChromaModel(
            str(rng.choice(["444", "422", "420"])), (float(rng.choice([0.0, -0.5, 3.0])), 0.0)
        )
        optics = Optics(float(rng.choice([0.0, 0.6, 3.0])), float(rng.choice([0, 3, 20])), chroma)
        limits = Thresholds(
            max_blobs=int(rng.choice([1, 400])), max_candidates=int(rng.choice([1, 64])),
            confidence=float(rng.choice([0.01, 0.5])), residual_px=float(rng.choice([0.8, 9.0])),
        )  # fmt: skip
        palette = scenario_palette(scenario, self.tags)
        self.eye: Eye = make_eye(self.camera, self.tags, palette, optics, limits)

    def picture(self, rng: Rng) -> np.ndarray:
        """Noise, confetti, one colour, or robots at the border in a strange light."""
        (w, h), kind = self.camera.size_px, rng.integers(0, 5)
        paints = np.array([color.bgr for color in self.colors], float)
        if kind == 0:
            return rng.integers(0, 256, (h, w, 3)).astype(np.uint8)
        if kind == 1:
            cell = int(rng.integers(1, 12))
            tiles = paints[rng.integers(0, len(paints), (h // cell + 1, w // cell + 1))]
            return np.repeat(np.repeat(tiles, cell, 0), cell, 1)[:h, :w].astype(np.uint8)
        if kind == 2:
            return np.full((h, w, 3), paints[rng.integers(len(paints))], np.uint8)
        return self._robots(rng)

    def _robots(self, rng: Rng) -> np.ndarray:
        (w, h), count = self.camera.size_px, len(self.tags.tags)
        pixels = rng.uniform(-10.0, (w + 10.0, h + 10.0), (count, 2))
        if rng.random() < 0.5:
            pixels[:, 0] = rng.choice([0.0, w - 1.0], count) + rng.normal(0.0, 3.0, count)
        floor = self.camera.to_floor(pixels, self.camera.tag_height)
        around = (floor[:, None] + 0.15 * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])).reshape(
            -1, 2
        )
        rim = self.camera.project(np.column_stack((around, np.full(len(around), 0.075))))
        if not (np.abs(rim) < 2000.0).all():  # the renderer is for tags in sight
            return np.zeros((h, w, 3), np.uint8)
        states = tuple(
            RobotState(robot_id, UnicycleState(*place, rng.uniform(-3.0, 3.0), 0.0, 0.0))
            for robot_id, place in zip(self.tags.ids, floor.tolist(), strict=True)
        )
        sensor = SensorModel(read_noise=3.0, blur_px=0.6, chroma="444")
        image = Renderer(self.camera, self.tags, self.colors, sensor).render(states, 0.0)
        gains = rng.uniform(0.1, 2.5, 3) if rng.random() < 0.3 else 1.0
        return np.clip(image * gains, 0, 255).astype(np.uint8)

    def predictions(self, rng: Rng) -> tuple[Prediction, ...]:
        """Near, at the border, far, infinite, or nowhere."""
        w, h = self.camera.size_px
        found = []
        for robot_id in self.tags.ids:
            pixel = rng.uniform((-20.0, -20.0), (w + 20.0, h + 20.0))
            if rng.random() < 0.4:
                pixel[rng.integers(2)] = rng.choice([-1.0, 0.0, w - 1.0, h - 1.0])
            x, y = self.camera.to_floor(pixel[None], self.camera.tag_height)[0].tolist()
            pose = [x, y, float(rng.uniform(-10.0, 10.0))]
            if rng.random() < 0.2:
                pose[rng.integers(3)] = float(rng.choice(ODD))
            covariance = np.diag(rng.choice([1e-6, 1e3, np.inf, np.nan], 3))
            found.append(Prediction(robot_id, Pose2D(*pose), covariance))
        return tuple(found)


def random_camera(rng: Rng, side: float, most_px: int) -> CameraModel:
    """Overhead or tilted by up to 50 degrees, with or without a bent lens, 1 pixel or many."""
    w, h = (int(n) for n in rng.integers(1, rng.choice([8, 40, most_px]) + 1, 2))
    bent = rng.normal(0.0, (0.1, 0.03, 0.005, 0.005, 0.01)) * rng.choice([0.0, 1.0])
    width = w * side / rng.uniform(5.0, 45.0)
    if rng.random() < 0.5:
        height = 0.2 + max(width, 0.2) * float(rng.uniform(0.3, 3.0))
        return overhead_camera((w, h), width, (0.3, -0.2), height, 0.075, tuple(bent.tolist()))
    focal = w * rng.uniform(0.5, 2.0)
    tilt = np.asarray(cv2.Rodrigues(np.array([rng.uniform(0.0, 0.9), 0.0, 0.0]))[0])
    turn = np.asarray(cv2.Rodrigues(np.array([0.0, 0.0, rng.uniform(-3.1, 3.1)]))[0])
    rotation = tilt @ np.diag([1.0, -1.0, -1.0]) @ turn
    place = np.array([0.3, -0.2, 0.1 + focal * width / w])
    matrix = np.array([[focal, 0.0, w / 2], [0.0, focal * rng.uniform(0.7, 1.4), h / 2], [0, 0, 1]])
    return CameraModel((w, h), matrix, bent, rotation, -rotation @ place, 0.075)


def random_light(rng: Rng) -> Light:
    """The palette's own, or nearly none, or far too much."""
    blue, green, red = rng.choice([1.0, 0.5, 0.01, 1e-9, 40.0], 3).tolist()
    return Light(blue, green, red) if rng.random() < 0.5 else Light()


def check_scene(scene: Scene) -> None:
    """Every number is finite and no id comes twice."""
    ids = [detection.robot_id for detection in scene.detections]
    assert len(set(ids)) == len(ids)
    for d in scene.detections:
        numbers = (d.pose.x, d.pose.y, d.pose.theta, d.pixel.x, d.pixel.y, d.pixel.heading)
        assert np.isfinite((*numbers, d.residual_px, d.confidence)).all()
        assert np.isfinite(d.covariance).all()
    assert all(np.isfinite((r.x, r.y)).all() for r in scene.rejected)
    assert np.isfinite(scene.light.gains).all()


def fuzz(seed: int, most_px: int = 320, pictures: int = 6) -> int:
    """Look at hostile pictures in one room, twice each; returns how many robots were seen."""
    rng = np.random.default_rng(seed)
    room, seen = Room(rng, most_px), 0
    for number in range(pictures):
        image = room.picture(rng)
        expected = room.predictions(rng) if rng.random() < 0.7 else ()
        scene = locate(as_frame(image, 0.0, number), room.eye, expected, random_light(rng))
        check_scene(scene)
        scene = locate(as_frame(image // 2, 0.1, number), room.eye, expected, scene.light)
        check_scene(scene)
        seen += len(scene.detections)
    return seen


def main() -> None:
    """Fuzz for some seconds, or in some small rooms (a number with an "x")."""
    text, seed, seen = sys.argv[1], 0, 0
    if text.endswith("x"):
        for seed in range(int(text[:-1])):
            seen += fuzz(seed, 24, 2)
    else:
        start = perf_counter()
        while perf_counter() - start < float(text):
            seed, seen = seed + 1, seen + fuzz(seed)
    print(f"{seed + 1} rooms, {seen} robots seen")  # noqa: T201 (what a run by hand tells)


if __name__ == "__main__":
    main()
