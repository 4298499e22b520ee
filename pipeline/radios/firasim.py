"""FIRASim, the simulator of the IEEE VSSS league: wheel speeds in rad/s as protobuf over UDP.

It has no watchdog: robots keep the last speeds they were told.
"""

from functools import cache, partial
from math import inf
from typing import Any

from control.command import RobotId
from pipeline.messages import message_class
from pipeline.radios.broadcast import Channel, Speeds
from pipeline.radios.udp import UdpLink

REFUSAL = 0.05  # how long "nobody listens" takes to come back, if it comes [s]
# fira_message.sim_to_ref, as FIRASim's packet.proto and command.proto number them
_MESSAGES = {
    "Command": (
        "optional uint32 id = 1",
        "optional bool yellowteam = 2",
        "optional double wheel_left = 6",
        "optional double wheel_right = 7",
    ),
    "Commands": ("repeated Command robot_commands = 1",),
    "Packet": ("optional Commands cmd = 1",),
}


@cache
def _packet_class() -> Any:
    return message_class("fira_message.sim_to_ref", "proto3", _MESSAGES, "Packet")


def firasim_packet(speeds: Speeds, radius: float, yellow: bool) -> bytes:
    """Write one packet.

    Args:
        speeds: of the wheels of every robot it is for [m/s]; ids are whole numbers.
        radius: of a wheel [m].
        yellow: whether the robots are the yellow team's.

    Returns:
        A serialised Packet; speeds in it are in rad/s.
    """
    packet = _packet_class()()
    for robot, wheels in speeds.items():
        command = packet.cmd.robot_commands.add(id=robot, yellowteam=yellow)
        command.wheel_left, command.wheel_right = wheels.left / radius, wheels.right / radius
    return bytes(packet.SerializeToString())


def firasim_channel(
    place: str, robots: tuple[RobotId, ...], radius: float, yellow: bool
) -> Channel:
    """The way to the simulator.

    Args:
        place: HOST:PORT, its default port is 20011.
        robots: who is reached; ids are whole numbers.
        radius: of a wheel [m].
        yellow: whether the robots are the yellow team's.

    Returns:
        For a BroadcastRadio.
    """
    encode = partial(firasim_packet, radius=radius, yellow=yellow)
    return Channel(place, UdpLink, encode, inf, 32 * len(robots), REFUSAL)
