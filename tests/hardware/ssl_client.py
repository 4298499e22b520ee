"""A client of SSL-Vision as team software has one, reading the packets by hand.

Wrapper: detection = 1. Frame: frame_number = 1, t_capture = 2, t_sent = 3, camera_id = 4,
robots_yellow = 6, robots_blue = 7. Robot: confidence = 1, robot_id = 2, x = 3, y = 4 (mm),
orientation = 5 (rad), pixel_x = 6, pixel_y = 7. Speeds and times are doubles, the rest floats.
"""

from dataclasses import dataclass, field
from typing import Any

from tests.hardware.udp import UdpServer
from tests.hardware.wire import NotProtobuf, fields

FRAME = {1: "frame_number", 2: "t_capture", 3: "t_sent", 4: "camera_id"}
ROBOT = {1: "confidence", 2: "robot_id", 3: "x", 4: "y", 5: "orientation", 6: "pixel_x",
         7: "pixel_y"}  # fmt: skip
REQUIRED = {"confidence", "x", "y", "pixel_x", "pixel_y"}


@dataclass
class SslFrame:
    """What one packet says.

    Attributes:
        head: frame_number, t_capture, t_sent, camera_id.
        yellow: robots of the yellow team, fields by name.
        blue: robots of the blue team.
    """

    head: dict[str, Any] = field(default_factory=dict)
    yellow: list[dict[str, Any]] = field(default_factory=list)
    blue: list[dict[str, Any]] = field(default_factory=list)


class SslClient(UdpServer):
    """Listens.

    Attributes:
        frames: all that could be read.
        errors: packets that could not.
    """

    def __init__(self) -> None:
        """Listen on a free port."""
        self.frames: list[SslFrame] = []
        self.errors = 0
        super().__init__()

    def received(self, data: bytes) -> None:
        """Read one packet."""
        try:
            self.frames += [_frame(raw) for number, raw in fields(data) if number == 1]
        except (NotProtobuf, TypeError):
            self.errors += 1


def _frame(data: Any) -> SslFrame:
    frame = SslFrame()
    for number, value in fields(data):
        if number in FRAME:
            frame.head[FRAME[number]] = value
        elif number in (6, 7):
            (frame.yellow if number == 6 else frame.blue).append(_robot(value))
    if len(frame.head) != len(FRAME):
        raise NotProtobuf("a required field is missing")
    return frame


def _robot(data: Any) -> dict[str, Any]:
    robot = {ROBOT[number]: value for number, value in fields(data) if number in ROBOT}
    if not set(robot) >= REQUIRED:
        raise NotProtobuf("a required field is missing")
    return robot
