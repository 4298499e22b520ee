"""SSL-Vision: what is seen goes out as the packets that software of RoboCup's teams listens to.

RoboCup Small Size League, messages_robocup_ssl_detection.proto and ..._wrapper.proto.
"""

import socket
from contextlib import suppress
from functools import cache
from time import time
from typing import Any

from datasets.cycle import Moment
from pipeline.errors import ConfigError
from pipeline.messages import message_class
from pipeline.radios.address import parse_address
from pipeline.radios.tcp import reason
from vision.scene import Detection, Scene

MULTICAST = "224.5.23.2:10006"
CAMERA_ID = 0
_UINT32 = 0xFFFFFFFF
_MESSAGES = {
    "SSL_DetectionRobot": (
        "required float confidence = 1",
        "optional uint32 robot_id = 2",
        "required float x = 3",
        "required float y = 4",
        "optional float orientation = 5",
        "required float pixel_x = 6",
        "required float pixel_y = 7",
    ),
    "SSL_DetectionFrame": (
        "required uint32 frame_number = 1",
        "required double t_capture = 2",
        "required double t_sent = 3",
        "required uint32 camera_id = 4",
        "repeated SSL_DetectionRobot robots_yellow = 6",
        "repeated SSL_DetectionRobot robots_blue = 7",
    ),
    "SSL_WrapperPacket": ("optional SSL_DetectionFrame detection = 1",),
}


@cache
def _packet_class() -> Any:
    return message_class("", "proto2", _MESSAGES, "SSL_WrapperPacket")


class SslVision:
    """An observer that sends the detections of every frame, one datagram each; it never waits.

    Attributes:
        sent: datagrams that the system took.
        failed: datagrams that it did not take.
    """

    def __init__(self, place: str = MULTICAST, yellow: bool = False) -> None:
        """Open a socket.

        Args:
            place: HOST:PORT, usually of a multicast group.
            yellow: whether the robots are the yellow team's.

        Raises:
            ConfigError: if it is no address or there is no such host.
        """
        self._place, self._yellow = place, yellow
        self.sent, self.failed, self._why = 0, 0, ""
        self._wall_from_run: float | None = None
        host, port = parse_address(place, "--publish ssl-vision:")
        try:
            family, kind, *_, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
            self._socket = socket.socket(family, kind)
        except (OSError, UnicodeError) as error:
            raise ConfigError(f"--publish ssl-vision: {place}: {reason(error)}") from error
        self._socket.setblocking(False)
        self._address: Any = address
        _packet_class()  # now, not in the first cycle

    @property
    def notes(self) -> tuple[str, ...]:
        """What could not be sent."""
        if not self.failed:
            return ()
        what = f"{self.failed} of {self.failed + self.sent} packets were not sent ({self._why})"
        return (f"ssl-vision {self._place}: {what}",)

    def observe(self, moment: Moment) -> None:
        """Send what was found in the cycle's frame, if it had one.

        Args:
            moment: the cycle.
        """
        scene, frame = moment.cycle.scene, moment.tick.frame
        if scene is None or frame is None:
            return
        sent_at = (
            moment.tick.t + moment.timing.frame_to_command
        )  # on the run's clock, if it jumps too
        try:
            self._socket.sendto(self._packet(scene, frame.sequence, sent_at), self._address)
            self.sent += 1
        except OSError as error:
            self.failed, self._why = self.failed + 1, reason(error)

    def close(self) -> None:
        """Release the socket. Safe to call twice."""
        with suppress(OSError):
            self._socket.close()

    def _packet(self, scene: Scene, sequence: int, sent_at: float) -> bytes:
        if self._wall_from_run is None:  # one offset for the run, so that intervals stay exact
            self._wall_from_run = time() - sent_at
        packet = _packet_class()()
        seen = packet.detection
        seen.frame_number, seen.camera_id = sequence & _UINT32, CAMERA_ID
        seen.t_capture = scene.t_capture + self._wall_from_run
        seen.t_sent = sent_at + self._wall_from_run
        robots = seen.robots_yellow if self._yellow else seen.robots_blue
        for detection in scene.detections:
            _fill(robots.add(), detection)
        return bytes(packet.SerializeToString())


def _fill(robot: Any, detection: Detection) -> None:
    """One robot: mm and rad on the floor, px in the picture; a name is no id and is left out."""
    if isinstance(detection.robot_id, int):
        robot.robot_id = detection.robot_id
    robot.confidence = detection.confidence
    robot.x, robot.y = 1e3 * detection.pose.x, 1e3 * detection.pose.y
    robot.orientation = detection.pose.theta
    robot.pixel_x, robot.pixel_y = detection.pixel.x, detection.pixel.y
