"""From a radio's SPEC, as the command line writes it, to its adapter."""

from control.command import RobotId
from pipeline.errors import ConfigError
from pipeline.ports import Clock, CommandSink
from pipeline.radios.miabot import MiabotPort, MiabotRadio, MiabotSettings
from pipeline.radios.none import NoRadio

KINDS = "simulated, none, or miabot:ID=PORT,ID=PORT,..."
PLANNED = ("miabot-tcp-listen", "firasim", "vsss")


def open_radio(
    spec: str,
    clock: Clock,
    settings: MiabotSettings,
    robots: tuple[RobotId, ...] = (),
) -> CommandSink:
    """Open what a SPEC names; `simulated` is the caller's, who has the world.

    Args:
        spec: `none` or `miabot:ID=PORT,...`.
        clock: the run's clock.
        settings: of the links and robots.
        robots: who is to be reached; each needs a port, nobody else may have one; empty: anybody.

    Returns:
        The command sink, connected.

    Raises:
        ConfigError: if the SPEC names no kind of radio, one that is not supported yet, or the
            wrong robots.
        RadioError: if a link cannot be opened.
    """
    kind, _, rest = spec.partition(":")
    if kind == "none" and not rest:
        return NoRadio()
    if kind == "miabot":
        return MiabotRadio(_ports(spec, rest, robots), settings, clock)
    if kind in PLANNED:
        raise ConfigError(
            f"radio {spec!r}: {kind} is not yet supported; it comes with a later version; "
            f"now there are {KINDS}"
        )
    raise ConfigError(f"radio {spec!r}: need {KINDS}")


def _ports(spec: str, rest: str, robots: tuple[RobotId, ...]) -> tuple[MiabotPort, ...]:
    ports = tuple(_port(spec, item) for item in rest.split(","))
    ids, devices = [port.robot_id for port in ports], [port.port for port in ports]
    for kind, count in (("robot", len(set(ids))), ("port", len(set(devices)))):
        if count < len(ports):
            raise ConfigError(f"radio {spec!r}: one {kind} comes twice")
    missing = [robot for robot in robots if robot not in ids]
    if missing:
        raise ConfigError(f"radio {spec!r}: robot {missing[0]} of the scenario has no port")
    foreign = [robot for robot in ids if robots and robot not in robots]
    if foreign:
        raise ConfigError(f"radio {spec!r}: robot {foreign[0]} is not in the scenario")
    return ports


def _port(spec: str, item: str) -> MiabotPort:
    name, _, port = (part.strip() for part in item.partition("="))
    if not name or not port:
        raise ConfigError(f"radio {spec!r}: need ID=PORT, got {item!r}")
    return MiabotPort(int(name) if name.isdecimal() else name, port)
