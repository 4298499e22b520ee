"""Robots that talk nonsense: malformed replies and datagrams at radios that are driving meanwhile.

    python -m tests.hardware.noise --replies 200000 --datagrams 100000 --seed 0

sends them over real sockets and says what was counted and how long a command took at worst.
"""

import argparse
import random
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from control.command import Command
from control.unicycle import Twist
from pipeline.accounts import link_reports
from pipeline.clock import MonotonicClock
from pipeline.ports import CommandSink
from pipeline.radios.open import RadioSettings, open_radio
from pipeline.radios.report import RobotReport
from tests.hardware.firasim import FiraSim
from tests.hardware.miabot_robot import Miabot
from tests.hardware.miabot_tcp import TcpMiabot

SOUND = (
    b"<test#01>", b"<: +0000025000:-0000012500>", b"<Miabot PRO 1.0>", b"[=1,2]", b"<1,2,3>",
    b"\x0a\x04\x0a\x02\x08\x07",
)  # fmt: skip
TOKENS = (b"<", b">", b"<test#", b"<: +", b":", b"\x00", b"\xff\xfe", b"\r\n", b"<<", b">>", b"#",
          b"99999999999999999999", b"-", b"nan")  # fmt: skip
LAST = 1234567890  # ticks that no mutation tells
BURST = 100  # datagrams that fit into the system's buffer
LONGEST = 300  # of a mutated message [B]


def mutated(rng: random.Random) -> bytes:
    """Something that once was a message.

    Args:
        rng: decides.

    Returns:
        Up to about 300 bytes.
    """
    data = bytearray(rng.choice(SOUND))
    for _ in range(rng.randint(1, 6)):
        at = rng.randint(0, len(data))
        match rng.randrange(5):
            case 0:
                del data[at : at + rng.randint(1, 6)]
            case 1:
                data[at:at] = rng.choice(TOKENS)
            case 2:
                data[at:at] = rng.randbytes(rng.randint(1, 20))
            case 3:
                data += data[:at]
            case _ if data:
                data[min(at, len(data) - 1)] ^= 1 << rng.randrange(8)
    return bytes(data[:LONGEST])


@dataclass(frozen=True)
class Told:
    """What came of it.

    Attributes:
        sent: malformed messages.
        size: of all of them [B].
        slowest: `send` of a command while they came [s].
        report: of the radio, at the end.
        seconds: it took.
    """

    sent: int
    size: int
    slowest: float
    report: RobotReport
    seconds: float


def replies(count: int, seed: int) -> Told:
    """Let a Miabot on TCP send malformed replies while it is driven.

    Args:
        count: of replies.
        seed: of what is malformed.

    Returns:
        What came of it, when a sound reply behind all of them was understood.
    """
    rng, clock = random.Random(seed), MonotonicClock()
    with (
        TcpMiabot(Miabot(1), clock=clock.now) as robot,
        _opened(f"miabot-tcp:1={robot.place}", clock) as radio,
    ):

        def _say() -> Iterator[int]:
            for _ in range(count):
                data = mutated(rng)
                robot.say(data)
                yield len(data)
            robot.say(b"><: %+011d:+0000000001>" % LAST)
            _wait(lambda: (seen := link_reports(radio)[0].encoders) and seen.left == LAST)

        return _drive(radio, clock, count, _say())


def datagrams(count: int, seed: int) -> Told:
    """Let a simulator send malformed datagrams while its robots are driven.

    Args:
        count: of datagrams.
        seed: of what is malformed.

    Returns:
        What came of it, when all of them had been read.
    """
    rng, clock = random.Random(seed), MonotonicClock()
    with FiraSim() as simulator, _opened(f"firasim:{simulator.place}", clock) as radio:
        _wait(lambda: simulator.sender)

        def _say() -> Iterator[int]:
            size = 0
            for n in range(1, count + 1):
                data = mutated(rng)
                simulator.say(data)
                size += len(data)
                yield len(data)
                if n % BURST == 0 or n == count:  # else the system drops what it has no room for
                    _wait(lambda size=size: link_reports(radio)[0].garbage == size)

        return _drive(radio, clock, count, _say())


def readings(count: int, seed: int) -> tuple[int, int]:
    """Hand malformed datagrams to the hand-written readers of the emulated ends as well.

    Args:
        count: of datagrams.
        seed: of what is malformed.

    Returns:
        How many the emulated simulator could read, and how many not.
    """
    rng = random.Random(seed)
    with FiraSim() as simulator:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as talk:
            for n in range(count):
                talk.sendto(mutated(rng), ("127.0.0.1", simulator.port))
                if n % 100 == 0:
                    _wait(lambda n=n: simulator.packets + simulator.errors >= n)
        _wait(lambda: simulator.packets + simulator.errors == count)
        return simulator.packets, simulator.errors


def _drive(radio: CommandSink, clock: MonotonicClock, count: int, saying: Iterator[int]) -> Told:
    """Say all of it from another thread, and command at 100 Hz until it is said and heard."""
    said: list[int] = []
    thread = threading.Thread(target=lambda: said.extend((sum(saying),)), daemon=True)
    start, slowest = time.monotonic(), 0.0
    thread.start()
    while thread.is_alive():
        slowest = max(slowest, _command(radio, clock))
        time.sleep(0.01)
    if not said:
        raise AssertionError(f"stalled: {link_reports(radio)[0]}")
    seconds = time.monotonic() - start
    return Told(count, said[0], slowest, link_reports(radio)[0], seconds)


def _command(radio: CommandSink, clock: MonotonicClock) -> float:
    """Send one; how long that took [s]."""
    before, now = time.perf_counter(), clock.now()
    lost = radio.send((Command(1, Twist(0.1, 0.0), now, now + 0.1),), now)
    taken = time.perf_counter() - before
    if lost:
        raise AssertionError(f"the link broke: {link_reports(radio)[0].error}")
    return taken


def _wait(happened: Callable[[], object], patience: float = 60.0) -> None:
    end = time.monotonic() + patience
    while not happened():
        if time.monotonic() > end:
            raise AssertionError("stalled")
        time.sleep(0.002)


@contextmanager
def _opened(spec: str, clock: MonotonicClock) -> Iterator[CommandSink]:
    radio = open_radio(spec, clock, RadioSettings(), (1,))
    try:
        yield radio
    finally:
        radio.close()


def main() -> None:
    """Send it all and say what was counted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--replies", type=int, default=200_000)
    parser.add_argument("--datagrams", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    for name, told in (
        ("replies", replies(args.replies, args.seed)),
        ("datagrams", datagrams(args.datagrams, args.seed)),
    ):
        r = told.report
        print(  # noqa: T201
            f"{told.sent} malformed {name}, {told.size} B in {told.seconds:.1f} s: link up {r.up}, "
            f"{r.counts.failures} failures, {r.garbage} B of garbage, {r.foreign} foreign, "
            f"{r.counts.sent} commands sent, slowest send {1e3 * told.slowest:.2f} ms"
        )
    read, refused = readings(args.datagrams, args.seed)
    print(f"{args.datagrams} malformed datagrams at the emulated simulator: {read} read, "  # noqa: T201
          f"{refused} refused")  # fmt: skip


if __name__ == "__main__":
    main()
