"""What a session file holds: channels, header, and how a moment is split into messages."""

import platform
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any, get_type_hints

import cv2
import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from control.replanning import Answer
from datasets.cycle import NO_ORDERS, Cycle, Moment, Orders, RobotState, Tick, Timing
from datasets.session_codec import Plain, form
from vision.frame import Frame, as_frame

FORMAT_VERSION = "1"
HEADER_RECORD = "echelon.header"
END_RECORD = "echelon.end"
IMAGE_TOPIC = "/camera"
LAST_TOPIC = "/timing"  # written last: a moment without it was cut off
DROPS_TOPIC = "/recorder"


@dataclass(frozen=True, slots=True)
class SessionHeader:
    """What a session was recorded with.

    Attributes:
        name: of the scenario.
        scenario: its full resolved configuration, as text or JSON.
        seed: of every random generator, None where nothing was random.
        versions: pairs of name and version of the software.
    """

    name: str
    scenario: str
    seed: int | None
    versions: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class FrameStamp:
    """A frame without its picture, which is a message of its own.

    Attributes:
        t_capture: when the picture was taken [s].
        sequence: running number given by the source.
        camera_id: name of the source.
        t_arrival: when it was at hand [s], None if nobody knows (or in an older session).
        surely_new: whether the source vouched for a new picture.
    """

    t_capture: float
    sequence: int
    camera_id: str
    t_arrival: float | None = None
    surely_new: bool = False


@dataclass(frozen=True, slots=True)
class Inputs:
    """A tick whose frame is a stamp.

    Attributes:
        t: the moment of the cycle [s].
        frame: stamp of the frame it carried, or None.
        lost_links: robots whose radio link was down.
        orders: of a person; recordings of older versions have none.
        answer: of the planner; recordings of older versions have none.
    """

    t: float
    frame: FrameStamp | None
    lost_links: tuple[RobotId, ...]
    orders: Orders = NO_ORDERS
    answer: Answer | None = None


@dataclass(frozen=True, slots=True)
class Drops:
    """Moments the recorder could not keep.

    Attributes:
        t: of the next moment kept [s].
        dropped: how many were lost since the start.
    """

    t: float
    dropped: int


# Each part of a cycle has a channel of its own, so that a viewer can plot it alone.
_CYCLE = get_type_hints(Cycle)
_CHANNEL_OF_PART = {
    "scene": "/scene",
    "robots": "/estimates",
    "pairs": "/pairs",
    "planned": "/planned",
    "commands": "/commands",
    "events": "/events",
}
_STATUS = tuple(name for name in _CYCLE if name not in _CHANNEL_OF_PART)
_FIELDS_OF_CHANNEL: dict[str, dict[str, Any]] = {
    "/inputs": {"inputs": Inputs},
    "/cycle": {name: _CYCLE[name] for name in _STATUS},
    **{topic: {name: _CYCLE[name]} for name, topic in _CHANNEL_OF_PART.items()},
    "/truth": {"truth": tuple[RobotState, ...]},
    LAST_TOPIC: {"timing": Timing},
    DROPS_TOPIC: {"drops": Drops},
}


def software_versions() -> tuple[tuple[str, str], ...]:
    """Versions that decide whether a replay can be equal bit for bit.

    Returns:
        Pairs of name and version: python, numpy, opencv, echelon.
    """
    try:
        echelon = version("echelon-formation")
    except PackageNotFoundError:
        echelon = "not installed"
    return (
        ("python", platform.python_version()),
        ("numpy", np.__version__),
        ("opencv", cv2.__version__),
        ("echelon", echelon),
    )


def channel_schemas() -> dict[str, dict[str, Plain]]:
    """JSON schema of every JSON channel.

    Returns:
        Schemas by topic.
    """
    return {
        topic: {
            "type": "object",
            "properties": {
                "t": form(float).schema,
                **{name: form(hint).schema for name, hint in parts.items()},
            },
        }
        for topic, parts in _FIELDS_OF_CHANNEL.items()
    }


@cache
def _forms_of(topic: str) -> tuple[tuple[str, Any], ...]:
    return tuple((name, form(hint)) for name, hint in _FIELDS_OF_CHANNEL[topic].items())


def encode_part(topic: str, t: float, values: Mapping[str, Any]) -> Plain:
    """Make the JSON value of one message.

    Args:
        topic: channel.
        t: the moment of the cycle [s].
        values: fields of the channel by name.

    Returns:
        A plain object with ``t`` and the fields.
    """
    encoded = {name: part.encode(values[name]) for name, part in _forms_of(topic)}
    return {"t": t, **encoded}


def decode_part(topic: str, plain: Mapping[str, Any]) -> dict[str, Any]:
    """Read the JSON value of one message.

    Args:
        topic: channel.
        plain: parsed JSON.

    Returns:
        Fields of the channel by name, rebuilt.
    """
    return {name: part.decode(plain[name]) for name, part in _forms_of(topic)}


def split(moment: Moment) -> Iterator[tuple[str, Plain]]:
    """Split a moment into JSON messages; empty parts are left out.

    Args:
        moment: one cycle with its inputs, truth and cost.

    Yields:
        Topic and plain value, the timing last.
    """
    tick, cycle = moment.tick, moment.cycle
    stamp = None if tick.frame is None else _stamp(tick.frame)
    inputs = Inputs(tick.t, stamp, tick.lost_links, tick.orders, tick.answer)
    yield "/inputs", encode_part("/inputs", tick.t, {"inputs": inputs})
    yield "/cycle", encode_part("/cycle", tick.t, {n: getattr(cycle, n) for n in _STATUS})
    for name, topic in _CHANNEL_OF_PART.items():
        if part := getattr(cycle, name):
            yield topic, encode_part(topic, tick.t, {name: part})
    if moment.truth:
        yield "/truth", encode_part("/truth", tick.t, {"truth": moment.truth})
    yield LAST_TOPIC, encode_part(LAST_TOPIC, tick.t, {"timing": moment.timing})


def join(parts: Mapping[str, Any], image: NDArray[np.uint8] | None) -> Moment:
    """Rebuild a moment from its messages.

    Args:
        parts: decoded fields of all its messages, by name.
        image: the picture of its frame, shape (H, W, 3), BGR, or None.

    Returns:
        A moment equal to the one recorded.

    Raises:
        KeyError: if a message is missing.
        ValueError: if the picture is missing.
        VisionError: if the picture is not one.
    """
    inputs: Inputs = parts["inputs"]
    absent = {"scene": None, "planned": None}
    cycle = Cycle(
        **{name: parts.get(name, absent.get(name, ())) for name in _CHANNEL_OF_PART},
        **{name: parts[name] for name in _STATUS},
    )
    frame = _frame(inputs.frame, image)
    tick = Tick(inputs.t, frame, inputs.lost_links, inputs.orders, inputs.answer)
    return Moment(tick, cycle, parts.get("truth", ()), parts["timing"])


def _stamp(frame: Frame) -> FrameStamp:
    return FrameStamp(
        frame.t_capture, frame.sequence, frame.camera_id, frame.t_arrival, frame.surely_new
    )


def _frame(stamp: FrameStamp | None, image: NDArray[np.uint8] | None) -> Frame | None:
    if stamp is None:
        return None
    if image is None:
        raise ValueError(f"frame {stamp.sequence} has no picture that can be decoded")
    return as_frame(
        image, stamp.t_capture, stamp.sequence, stamp.camera_id, stamp.t_arrival, stamp.surely_new
    )
