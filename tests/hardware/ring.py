"""The whole outside world in a process of its own: robots, their radios, and a camera's stream.

    python -m tests.hardware.ring paper --stream udp --truth truth.json

prints one JSON line with the stream's URL and the `--radio` argument that reaches the robots. It
shares nothing with the program under test but the stream and the ptys.
"""

import argparse
import gc
import json
import os
import resource
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from math import inf
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from control.command import RobotId
from control.unicycle import WheelSpeeds, twist_from_wheels
from pipeline.config import Scenario
from pipeline.filming import make_renderer
from pipeline.rigs import make_world
from pipeline.scenario import load_scenario
from tests.hardware.miabot_robot import Miabot, Ptys
from tests.hardware.streams import MjpegServer, Streamer, UdpSender

ROOT = Path(__file__).parents[2]
OPENING = 1.0  # from the first frame a program looks at to its first command, about [s]


class Outside:
    """A world that runs in real time, is filmed, and obeys the radio."""

    def __init__(self, scenario: Scenario, stream: str, port: int | None, seed: int) -> None:
        """Put the robots on the floor and switch everything on.

        Args:
            scenario: camera, sensor, tags and robots.
            stream: "mjpeg" or "udp".
            port: of the UDP stream; a free one if None.
            seed: of the sensor's noise.
        """
        self._scenario, self._lock = scenario, threading.Lock()
        self._origin = monotonic()
        self.world = make_world(scenario, seed)
        self._renderer = make_renderer(scenario, seed)
        size = (scenario.camera.width_px, scenario.camera.height_px)
        self.streamer: Streamer = (
            MjpegServer() if stream == "mjpeg" else UdpSender(size, scenario.camera.fps, port)
        )
        self.miabots = {
            robot.id: Miabot(
                number,
                scenario.radio.speed_scale_per_mps,
                partial(self._drive, robot.id, scenario.radio.track_width_m),
            )
            for number, robot in enumerate(scenario.robots, 1)
        }
        self.ptys = Ptys(tuple(self.miabots.values()), self.now)
        self._frames: list[dict[str, Any]] = []
        self._stopping = False

    @property
    def radio(self) -> str:
        """The `--radio` argument that reaches the robots."""
        pairs = zip(self.miabots, self.ptys.paths, strict=True)
        return "miabot:" + ",".join(f"{robot}={path}" for robot, path in pairs)

    def now(self) -> float:
        """Time of this world [s]."""
        return monotonic() - self._origin

    def run(self, duration: float) -> None:
        """Film, frame after frame, until the time is over or `stop` is called.

        Args:
            duration: how long [s].
        """
        number = int(self.now() * self._scenario.camera.fps) + 1
        while not self._stopping and (t := number / self._scenario.camera.fps) < duration:
            sleep(max(0.0, t - self.now()))
            self._film(t)
            number = max(number + 1, int(self.now() * self._scenario.camera.fps))

    def stop(self) -> None:
        """End after this frame."""
        self._stopping = True

    def close(self) -> None:
        """Switch everything off."""
        self.ptys.close()
        self.streamer.close()

    def truth(self) -> dict[str, Any]:
        """All that happened so far, as JSON takes it."""
        usage = resource.getrusage(resource.RUSAGE_SELF)
        return {
            "origin_monotonic_s": self._origin,
            "duration_s": self.now(),
            "cpu_s": usage.ru_utime + usage.ru_stime,
            "frames": list(self._frames),
            "robots": [
                {
                    "id": robot_id,
                    "commands": miabot.commands(),
                    "stops": [t for t, text in miabot.received if text == "s"],
                    "timeout_s": miabot.timeout,
                    "timeouts": miabot.timeouts,
                    "errors": miabot.errors,
                    "wheels": miabot.wheels,
                }
                for robot_id, miabot in self.miabots.items()
            ],
        }

    def _film(self, t: float) -> None:
        with self._lock:
            self.world.advance(max(t, self.world.t))
            states, clearance = self.world.states(t), self.world.clearance()
        image = self._renderer.render(states, t)
        rendered = self.now()
        self.streamer.publish(image, t)
        robots = [
            {"id": r.robot_id, "x_m": s.x, "y_m": s.y, "theta_rad": s.theta, "v_mps": s.v,
             "omega_radps": s.omega}
            for r in states for s in (r.state,)
        ]  # fmt: skip
        timing = {"t": t, "rendered_t": rendered, "published_t": self.now()}
        self._frames.append({**timing, "clearance_m": clearance, "robots": robots})

    def _drive(self, robot_id: RobotId, track: float, left: float, right: float, t: float) -> None:
        twist = twist_from_wheels(WheelSpeeds(left, right), track)
        with self._lock:
            self.world.advance(t)
            self.world.command(robot_id, twist, t + self._scenario.radio.delay_s)


def lateness(truth: dict[str, Any]) -> float:
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

    def finish(self) -> dict[str, Any]:
        """End the world and say what was true."""
        self.process.terminate()
        self.process.wait(10.0)
        result: dict[str, Any] = json.loads(self.truth_file.read_text())
        return result


@contextmanager
def ring(
    folder: Path, scenario: str = "paper", stream: str = "mjpeg", duration: float = 120.0
) -> Iterator[Ring]:
    """Start the outside world in its own process; it ends with the context.

    Args:
        folder: where it writes its truth.
        scenario: name or file.
        stream: "mjpeg" or "udp".
        duration: it ends by itself after this long [s].

    Yields:
        Where to reach it.
    """
    truth = folder / f"truth-{stream}.json"
    options = ("--stream", stream, "--duration", str(duration), "--truth", str(truth))
    process = subprocess.Popen(
        (sys.executable, "-m", "tests.hardware.ring", scenario, *options),
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert process.stdout is not None
    try:
        there = json.loads(process.stdout.readline())
        yield Ring(there["url"], there["radio"], there["ports"], process, truth)
    finally:
        process.terminate()
        process.wait(10.0)
        process.stdout.close()


def main() -> None:
    """Run until SIGTERM, Ctrl-C or the duration; SIGUSR1 writes the truth so far."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenario", nargs="?", default="paper")
    parser.add_argument("--stream", choices=("mjpeg", "udp"), default="mjpeg")
    parser.add_argument("--port", type=int, help="of the UDP stream")
    parser.add_argument("--duration", type=float, default=3600.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--truth", type=Path, help="JSON file for the truth")
    args = parser.parse_args()
    outside = Outside(load_scenario(args.scenario), args.stream, args.port, args.seed)
    gc.freeze()  # to look for garbage among all that stops this world for 0.1 s

    def write() -> None:
        if args.truth:
            args.truth.write_text(json.dumps(outside.truth()))

    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: outside.stop())
    signal.signal(signal.SIGUSR1, lambda *_: write())
    ports = dict(zip(map(str, outside.miabots), outside.ptys.paths, strict=True))
    print(json.dumps({"url": outside.streamer.url, "radio": outside.radio, "ports": ports}))  # noqa: T201
    sys.stdout.flush()
    outside.run(args.duration)
    write()
    outside.close()


if __name__ == "__main__":
    main()
