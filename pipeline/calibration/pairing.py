"""Which radio moves which tag: each radio's robot turns, and the tag that turned is its own."""

from collections.abc import Mapping, Sequence

import numpy as np

from control.command import RobotId
from control.drive_fit import SeenPose
from pipeline.calibration.patrol import Drive
from pipeline.errors import RadioError

TURNED = 0.2
"""A tag that turns by less stands still [rad]."""

Pairing = Mapping[RobotId, RobotId]


def tag_of(radio: RobotId, drive: Drive) -> RobotId:
    """The tag that turned when a radio said: left, and back.

    Args:
        radio: that was sent `pattern.TURNING`.
        drive: where all tags were seen meanwhile.

    Returns:
        The tag's robot.

    Raises:
        RadioError: if no tag has turned, several have, or it turned to the right.
    """
    swings = {robot: _swing(poses) for robot, poses in drive.seen.items()}
    turned = [robot for robot, swing in swings.items() if abs(swing) > TURNED]
    if not turned:
        raise RadioError(
            f"radio {radio}: no tag turned when its robot was told to (switched on? in the "
            "picture? the right port?)"
        )
    if len(turned) > 1:
        raise RadioError(
            f"radio {radio}: the tags of robots {_names(turned)} turned together (two robots on "
            "one channel, or one was moved by hand?)"
        )
    if swings[turned[0]] < 0.0:
        raise RadioError(
            f"radio {radio}: the tag of robot {turned[0]} turned to the right when told to turn "
            "to the left: exchange its motors' plugs"
        )
    return turned[0]


def paired(pairing: Pairing, radio: RobotId, tag: RobotId) -> Pairing:
    """Take a radio's tag down.

    Args:
        pairing: so far.
        radio: whose robot turned.
        tag: that turned.

    Returns:
        The pairing with this one.

    Raises:
        RadioError: if another radio moves the same tag.
    """
    for other, known in pairing.items():
        if known == tag:
            raise RadioError(f"radio {radio}: it turned the tag of robot {tag}, as radio {other}")
    return {**pairing, radio: tag}


def mistaken(pairing: Pairing) -> tuple[str, ...]:
    """Say which radios move another tag than the scenario says.

    Args:
        pairing: tag by radio.

    Returns:
        A line for each.
    """
    return tuple(
        f"radio {radio} moves the tag of robot {tag}"
        for radio, tag in pairing.items()
        if radio != tag
    )


def paired_spec(spec: str, pairing: Pairing) -> str:
    """The SPEC of a radio with its ports given to the tags they move.

    Args:
        spec: as it was given; KIND:ID=PORT,... or of a kind without ports.
        pairing: tag by radio.

    Returns:
        The right SPEC; unchanged if it names no ports.
    """
    kind, colon, rest = spec.partition(":")
    if "=" not in rest:
        return spec
    tags = {str(radio): str(tag) for radio, tag in pairing.items()}
    items = [item.partition("=") for item in rest.split(",")]
    ports = [f"{tags.get(name.strip(), name.strip())}={port}" for name, _, port in items]
    return f"{kind}{colon}{','.join(ports)}"


def _swing(poses: Sequence[SeenPose]) -> float:
    """How far a tag turned to the left, negative: to the right; some wrong poses do not matter.

    A robot that obeys looks aside for half of the time.
    """
    if not poses:
        return 0.0
    headings = np.unwrap([pose.pose.theta for pose in poses])
    quantiles = np.quantile(headings, (0.1, 0.5, 0.9))
    right, middle, left = quantiles.tolist()
    return float(left - middle if left - middle > middle - right else right - middle)


def _names(robots: Sequence[RobotId]) -> str:
    return " and ".join(map(str, robots))
