"""The whole outside world in a process of its own: robots, their radios, and a camera's stream.

    python -m tests.hardware.ring paper --stream udp --truth truth.json

prints one JSON line with the stream's URL and the `--radio` argument that reaches the robots. It
shares nothing with the program under test but the stream and the ptys. What is to happen
(`Outside.happen`) is typed, one event a line; each is answered by its time as a JSON line. `truth`
writes the truth so far.
"""

import argparse
import gc
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

from pipeline.scenario import load_scenario
from tests.hardware.outside import Outside

ROOT = Path(__file__).parents[2]
OPENING = 1.0  # from the first frame a program looks at to its first command, about [s]
Truth = dict[str, Any]


def lateness(truth: Truth) -> float:
    """How late the world was at worst while it was driven: the machine was busy elsewhere.

    Args:
        truth: see `Outside.truth`.

    Returns:
        From the moment a frame shows to the moment it was sent [s].
    """
    told = [command[0] for robot in truth["robots"] for command in robot["commands"]]
    begin, end = (min(told) - OPENING, max(told)) if told else (0.0, inf)
    frames = [frame for frame in truth["frames"] if begin <= frame["t"] <= end]
    return max((frame["published_t"] - frame["t"] for frame in frames), default=0.0)


@dataclass(frozen=True)
class Ring:
    """A running outside world, as its user sees it.

    Attributes:
        url: of the camera's stream.
        radio: the `--radio` argument.
        ports: serial port of each robot, by its id as text.
        process: the world.
        truth_file: where the truth will be.
    """

    url: str
    radio: str
    ports: dict[str, str]
    process: subprocess.Popen[str]
    truth_file: Path

    def happen(self, order: str) -> float:
        """Let something happen.

        Args:
            order: see `Outside.happen`.

        Returns:
            When it happened, on the world's clock [s].
        """
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        print(order, file=self.process.stdin, flush=True)
        return float(json.loads(self.process.stdout.readline())["t"])

    def truth(self) -> Truth:
        """What was true so far."""
        self.happen("truth")
        return self._written()

    def finish(self) -> Truth:
        """End the world and say what was true."""
        self.process.terminate()
        self.process.wait(10.0)
        return self._written()

    def _written(self) -> Truth:
        result: Truth = json.loads(self.truth_file.read_text())
        return result


@contextmanager
def ring(
    folder: Path,
    scenario: str = "paper",
    stream: str = "mjpeg",
    duration: float = 120.0,
    changes: Sequence[str] = (),
) -> Iterator[Ring]:
    """Start the outside world in its own process; it ends with the context.

    Args:
        folder: where it writes its truth.
        scenario: name or file.
        stream: "mjpeg" or "udp".
        duration: it ends by itself after this long [s].
        changes: of the scenario, as `--set` takes them.

    Yields:
        Where to reach it.
    """
    truth = folder / f"truth-{stream}.json"
    fixed = ("--stream", stream, "--duration", str(duration), "--truth", str(truth))
    options = (*fixed, *(part for change in changes for part in ("--set", change)))
    process = subprocess.Popen(
        (sys.executable, "-m", "tests.hardware.ring", scenario, *options),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        there = json.loads(process.stdout.readline())
        yield Ring(there["url"], there["radio"], there["ports"], process, truth)
    finally:
        process.terminate()
        process.wait(10.0)
        process.stdout.close()
        process.stdin.close()


def main() -> None:
    """Run until SIGTERM, Ctrl-C or the duration, and let happen what is typed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenario", nargs="?", default="paper")
    parser.add_argument("--stream", choices=("mjpeg", "udp"), default="mjpeg")
    parser.add_argument("--port", type=int, help="of the UDP stream")
    parser.add_argument("--duration", type=float, default=3600.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--truth", type=Path, help="JSON file for the truth")
    parser.add_argument("--set", action="append", default=[], help="section.key=value")
    args = parser.parse_args()
    outside = Outside(load_scenario(args.scenario, args.set), args.stream, args.port, args.seed)
    gc.freeze()  # to look for garbage among all that stops this world for 0.1 s

    def write() -> None:
        if args.truth:
            args.truth.write_text(json.dumps(outside.truth()))

    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: outside.stop())
    ports = dict(zip(map(str, outside.miabots), outside.ptys.paths, strict=True))
    _answer({"url": outside.streamer.url, "radio": outside.radio, "ports": ports})
    threading.Thread(target=_listen, args=(outside, write), daemon=True).start()
    outside.run(args.duration)
    write()
    outside.close()


def _listen(outside: Outside, write: Callable[[], None]) -> None:
    """Let happen what is typed, until nothing more is."""
    for line in sys.stdin:
        if line.strip() == "truth":
            write()
            _answer({"t": outside.now()})
        elif line.strip():
            _answer({"t": outside.happen(line)})


def _answer(message: dict[str, Any]) -> None:
    print(json.dumps(message), flush=True)  # noqa: T201 (its output)


if __name__ == "__main__":
    main()
