"""Moments as Rerun's shapes. Rerun's y points down: the floor is drawn with y negated."""

from typing import TYPE_CHECKING, TypeAlias

import cv2
import numpy as np

from control.command import RobotId
from control.formation import by_follower
from datasets.cycle import Moment, RobotState
from pipeline.viewers.stage import Floats, Stage, circle, dashes, grid, name_of
from vision.frame import Frame
from vision.scene import Scene

if TYPE_CHECKING:
    import rerun

Color: TypeAlias = tuple[int, int, int]

_UP = np.array([1.0, -1.0])
_FAINT = (40, 45, 56)
_GREY = (96, 104, 122)
_RED = (255, 84, 84)
_ARROW = 0.1  # length of the heading's arrow [m]
_NAME_ABOVE = 0.16  # from a robot's centre to its name [m]
_RAW_BYTES = 640 * 480 * 3  # larger pictures are compressed on their way to a viewer
_JPEG = [cv2.IMWRITE_JPEG_QUALITY, 90]  # for looking only; sessions keep every pixel


class RerunScene:
    """Draws camera picture and floor into one recording."""

    def __init__(self, recording: "rerun.RecordingStream", stage: Stage, compressed: bool) -> None:
        """Draw what never changes.

        Args:
            recording: where to.
            stage: what is drawn on.
            compressed: whether pictures are stored as JPEG; large ones always are.
        """
        self._out = recording
        self._compressed = compressed
        self._stage = stage
        self._before: dict[RobotId, tuple[float, float]] = {}
        self._draw_ground()

    def draw(self, moment: Moment) -> None:
        """Draw one moment at the recording's present time.

        Args:
            moment: inputs, outcome, truth and cost of a cycle.
        """
        if moment.tick.frame is not None:
            self._draw_picture(moment.tick.frame)
        if moment.cycle.scene is not None:
            self._draw_scene(moment.cycle.scene)
        self._draw_robots(moment.cycle.robots)
        self._draw_track(moment.cycle.robots)
        self._draw_worn(moment.cycle.robots)
        self._draw_truth(moment.truth)
        self._draw_wanted(moment)

    def _draw_ground(self) -> None:
        """Field of view, grid, planned path, what it leads round."""
        field = self._stage.field()
        lines = grid(field.min(axis=0), field.max(axis=0))
        self._lines("floor/grid", lines, [_FAINT] * len(lines), width=1.0, static=True)
        self._lines("floor/field", [field * _UP], [_GREY], width=1.0, static=True)
        path = dashes(self._stage.path)
        self._lines("floor/path", path, [_GREY] * len(path), width=2.0, static=True)
        discs = [circle(x, -y, radius) for x, y, radius in self._stage.obstacles]
        self._lines("floor/obstacles", discs, [_GREY] * len(discs), width=2.0, static=True)

    def _draw_picture(self, frame: Frame) -> None:
        import rerun as rr

        if self._compressed or frame.image.size > _RAW_BYTES:
            data = cv2.imencode(".jpg", frame.image, _JPEG)[1].tobytes()
            encoded = rr.EncodedImage(contents=data, media_type="image/jpeg", draw_order=-20.0)
            self._out.log("camera/image", encoded)
        else:
            raw = rr.Image(frame.image, color_model="BGR", draw_order=-20.0)
            self._out.log("camera/image", raw)

    def _draw_scene(self, scene: Scene) -> None:
        """Outlines of accepted tags with their names, rings around what was rejected."""
        import rerun as rr

        stage, found = self._stage, scene.detections
        outlines = [stage.on_screen(stage.outline(d.robot_id, d.pose)) for d in found]
        colors = [stage.color(d.robot_id) for d in found]
        self._lines("camera/tags", outlines, colors, width=2.0)
        lift = 0.05 * stage.camera.size_px[1]
        tops = [(outline[:, 0].mean(), outline[:, 1].min() - lift) for outline in outlines]
        self._names("camera/names", np.array(tops), [name_of(d.robot_id) for d in found], colors)
        rings = [circle(r.x, r.y, 0.02 * stage.camera.size_px[0]) for r in scene.rejected]
        rejected = rr.LineStrips2D(
            rings,
            colors=[_RED],
            radii=rr.Radius.ui_points(1.0),
            labels=[rejection.reason for rejection in scene.rejected],
            show_labels=False,  # shown when pointed at
        )
        self._out.log("camera/rejected", rejected)

    def _draw_robots(self, robots: tuple[RobotState, ...]) -> None:
        """Outline, heading and name of every robot, where it will be when the command arrives."""
        import rerun as rr

        stage = self._stage
        colors = [stage.color(robot.robot_id) for robot in robots]
        outlines = [stage.outline(robot.robot_id, robot.state.pose) for robot in robots]
        self._lines("floor/robots", [o * _UP for o in outlines], colors, width=2.5)
        states = np.array([(r.state.x, r.state.y, r.state.theta) for r in robots]).reshape(-1, 3)
        ahead = np.column_stack((np.cos(states[:, 2]), np.sin(states[:, 2])))
        arrows = rr.Arrows2D(
            vectors=_ARROW * ahead * _UP,
            origins=states[:, :2] * _UP,
            colors=colors,
            radii=rr.Radius.ui_points(1.5),
        )
        self._out.log("floor/headings", arrows)
        above = (states[:, :2] + (0.0, _NAME_ABOVE)) * _UP
        self._names("floor/names", above, [name_of(r.robot_id) for r in robots], colors)

    def _draw_track(self, robots: tuple[RobotState, ...]) -> None:
        """The piece driven since the last moment; the layout shows all pieces up to now."""
        pieces, colors = [], []
        for robot in robots:
            here = (robot.state.x, robot.state.y)
            before = self._before.get(robot.robot_id, here)
            pieces.append(np.array([before, here]) * _UP)
            colors.append(dim(self._stage.color(robot.robot_id), 0.55))
            self._before[robot.robot_id] = here
        self._lines("floor/track", pieces, colors, width=1.5)

    def _draw_worn(self, robots: tuple[RobotState, ...]) -> None:
        """How much room each robot wants that is an obstacle."""
        worn = self._stage.worn
        discs = [
            circle(robot.state.x, -robot.state.y, worn[robot.robot_id])
            for robot in robots
            if robot.robot_id in worn
        ]
        self._lines("floor/worn", discs, [_GREY] * len(discs), width=2.0)

    def _draw_truth(self, truth: tuple[RobotState, ...]) -> None:
        outlines = [self._stage.outline(r.robot_id, r.state.pose) * _UP for r in truth]
        self._lines("floor/truth", outlines, [_GREY] * len(outlines), width=1.0)

    def _draw_wanted(self, moment: Moment) -> None:
        """The formation as it should be: a pale outline per follower, lines from its leaders."""
        stage, robots = self._stage, moment.cycle.robots
        shapes: list[Floats] = []
        colors: list[Color] = []
        places = {robot.robot_id: robot.state.pose for robot in robots}
        for follower, pairs in by_follower(moment.cycle.pairs).items():
            wanted, color = stage.wanted_pose(pairs, robots), dim(stage.color(follower), 0.6)
            if wanted is None:
                continue
            leaders = [places[pair.leader] for pair in pairs]
            links = [np.array([(one.x, one.y), (wanted.x, wanted.y)]) for one in leaders]
            lines = [stage.outline(follower, wanted), *links]
            shapes += [line * _UP for line in lines]
            colors += [color] * len(lines)
        self._lines("floor/wanted", shapes, colors, width=1.0)

    def _lines(
        self,
        path: str,
        lines: list[Floats],
        colors: list[Color],
        width: float,
        static: bool = False,
    ) -> None:
        """Log polylines of one width [screen points]."""
        import rerun as rr

        strips = rr.LineStrips2D(lines, colors=colors, radii=rr.Radius.ui_points(0.5 * width))
        self._out.log(path, strips, static=static)

    def _names(self, path: str, points: Floats, names: list[str], colors: list[Color]) -> None:
        """Log text at points."""
        import rerun as rr

        where = points.reshape(-1, 2)
        labels = rr.Points2D(where, labels=names, colors=colors, radii=0.0, show_labels=True)
        self._out.log(path, labels)


def dim(color: Color, share: float) -> Color:
    """A colour mixed with the dark ground.

    Args:
        color: red, green and blue, 0 to 255.
        share: of the colour in the mixture, 0 to 1.

    Returns:
        The mixture.
    """
    red, green, blue = (int(share * part + (1.0 - share) * 20.0) for part in color)
    return red, green, blue
