"""From a radio's SPEC, as the command line writes it, to its adapter."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

from control.command import RobotId
from pipeline.errors import ConfigError
from pipeline.notice import told_after
from pipeline.ports import Clock, CommandSink
from pipeline.radios.address import parse_address
from pipeline.radios.broadcast import BroadcastRadio, Channel
from pipeline.radios.firasim import firasim_channel
from pipeline.radios.link import Link, SerialLink
from pipeline.radios.miabot import MiabotRadio
from pipeline.radios.miabot_line import MiabotPort, MiabotSettings
from pipeline.radios.none import NoRadio
from pipeline.radios.reception import Reception
from pipeline.radios.tcp import dial
from pipeline.radios.vsss import VsssFormat, vsss_channel
from pipeline.radios.wheels import Wheels

KINDS = (
    "simulated, none, miabot:ID=PORT,..., miabot-tcp:ID=HOST:PORT,..., "
    "miabot-tcp-listen:HOST:PORT, vsss:PORT, or firasim:HOST:PORT"
)
_QUIET = 1.0  # a wait this long is not worth a word [s]


@dataclass(frozen=True, slots=True)
class RadioSettings:
    """What all kinds of radio may have to know; see the `[radio]` section of a scenario.

    Attributes:
        miabot: of Miabots' links and drives; its timeout is that of the host for other robots.
        wheels: of robots that are told wheel speeds.
        vsss: how a VSSS firmware wants them.
        yellow: whether the robots are the yellow team's.
        patience: for robots that connect to the host [s].
    """

    miabot: MiabotSettings = field(default_factory=MiabotSettings)
    wheels: Wheels = field(default_factory=Wheels)
    vsss: VsssFormat = field(default_factory=VsssFormat)
    yellow: bool = False
    patience: float = 30.0


@dataclass(frozen=True, slots=True)
class _Wish:
    """What is to be opened, for whom and how."""

    spec: str
    rest: str
    clock: Clock
    settings: RadioSettings
    robots: tuple[RobotId, ...]
    interrupted: Callable[[], bool]


def open_radio(
    spec: str,
    clock: Clock,
    settings: RadioSettings,
    robots: tuple[RobotId, ...] = (),
    interrupted: Callable[[], bool] = lambda: False,
) -> CommandSink:
    """Open what a SPEC names; `simulated` is the caller's, who has the world.

    Args:
        spec: see KINDS.
        clock: the run's clock.
        settings: of the links and robots.
        robots: exactly who is to be reached; with miabot and miabot-tcp empty means: whoever the
            SPEC names.
        interrupted: asked while robots are waited for.

    Returns:
        The command sink, connected.

    Raises:
        ConfigError: if the SPEC names no kind of radio or the wrong robots.
        RadioError: if a link cannot be opened or a robot does not come.
        KeyboardInterrupt: if the wait was interrupted.
    """
    kind, _, rest = spec.partition(":")
    if kind not in _OPENERS or (kind == "none" and rest):
        raise ConfigError(f"radio {spec!r}: need {KINDS}")
    return _OPENERS[kind](_Wish(spec, rest, clock, settings, robots, interrupted))


def _none(_wish: _Wish) -> CommandSink:
    return NoRadio()


def _miabot(wish: _Wish, open_link: Callable[[str], Link], named: bool) -> CommandSink:
    ports = tuple(replace(port, open=open_link, named=named) for port in _ports(wish))
    if named:
        for port in ports:
            parse_address(port.port, f"radio {wish.spec!r}:")
    return MiabotRadio(ports, wish.settings.miabot, wish.clock, interrupted=wish.interrupted)


def _miabot_listen(wish: _Wish) -> CommandSink:
    parse_address(wish.rest, f"radio {wish.spec!r}:")
    _need_numbers(wish, "a robot that connects tells its number")
    settings, patience = wish.settings.miabot, wish.settings.patience
    reception = Reception(wish.rest, wish.robots, settings.timeout_ms)
    ports = tuple(MiabotPort(robot, wish.rest, reception.door_of(robot)) for robot in wish.robots)
    names = ", ".join(map(str, wish.robots))
    waiting = f"radio {wish.rest}: waiting up to {patience:g} s for robots {names} to connect"
    with told_after(_QUIET, waiting):
        return MiabotRadio(ports, settings, wish.clock, patience, wish.interrupted, reception)


def _vsss(wish: _Wish) -> CommandSink:
    if not wish.rest:
        raise ConfigError(f"radio {wish.spec!r}: need vsss:PORT, the ESP32's serial device")
    _need_numbers(wish, "the ESP32's robots have numbers")
    s = wish.settings
    return _broadcast(wish, vsss_channel(wish.rest, wish.robots, s.wheels, s.vsss))


def _firasim(wish: _Wish) -> CommandSink:
    parse_address(wish.rest, f"radio {wish.spec!r}:")
    _need_numbers(wish, "FIRASim's robots have numbers")
    s = wish.settings
    return _broadcast(wish, firasim_channel(wish.rest, wish.robots, s.wheels.radius, s.yellow))


def _broadcast(wish: _Wish, channel: Channel) -> CommandSink:
    s = wish.settings
    silence = s.miabot.timeout_ms / 1000.0
    return BroadcastRadio(wish.robots, channel, s.wheels, silence, wish.clock)


_OPENERS: dict[str, Callable[[_Wish], CommandSink]] = {
    "none": _none,
    "miabot": partial(_miabot, open_link=SerialLink, named=False),
    "miabot-tcp": partial(_miabot, open_link=dial, named=True),
    "miabot-tcp-listen": _miabot_listen,
    "vsss": _vsss,
    "firasim": _firasim,
}


def _need_numbers(wish: _Wish, why: str) -> None:
    wrong = [robot for robot in wish.robots if not isinstance(robot, int)]
    if wrong:
        raise ConfigError(f"radio {wish.spec!r}: {why}, so robot {wrong[0]!r} needs a whole one")
    if not wish.robots:
        raise ConfigError(f"radio {wish.spec!r}: no robots are to be reached")


def _ports(wish: _Wish) -> tuple[MiabotPort, ...]:
    spec, robots = wish.spec, wish.robots
    ports = tuple(_port(spec, item) for item in wish.rest.split(","))
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
