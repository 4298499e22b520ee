"""The outside world: robots on a floor, their radios, a camera's stream, and what befalls them."""

import resource
import threading
from collections.abc import Callable
from functools import partial
from time import monotonic, sleep
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from control.command import RobotId
from control.unicycle import Twist, WheelSpeeds, twist_from_wheels
from datasets.cycle import RobotState
from pipeline.camera_model import make_camera
from pipeline.config import Scenario
from pipeline.filming import make_renderer
from pipeline.rigs import make_world
from tests.hardware.miabot_robot import Miabot
from tests.hardware.ptys import Ptys
from tests.hardware.streams import MjpegServer, Streamer, UdpSender

Image = NDArray[np.uint8]

HAND_BGR, HAND_RADIUS = (120, 150, 200), 0.08  # what covers a robot [m]
STANDSTILL = Twist(0.0, 0.0)


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
        self._camera, self._fps = make_camera(scenario.camera), scenario.camera.fps
        self.streamer: Streamer = (
            MjpegServer() if stream == "mjpeg" else UdpSender(self._camera.size_px, self._fps, port)
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
        self._covered, self._taken = set[RobotId](), set[RobotId]()
        self._frozen, self._shown, self._lead = False, np.zeros((1, 1, 3), np.uint8), 0.0
        self._frames: list[dict[str, Any]] = []
        self._events: list[dict[str, Any]] = []
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
        number = int(self.now() * self._fps) + 1
        while not self._stopping and (t := number / self._fps) < duration:
            sleep(max(0.0, t - self.now()))
            self._film(t)
            number = max(number + 1, int(self.now() * self._fps))

    def stop(self) -> None:
        """End after this frame."""
        self._stopping = True

    def close(self) -> None:
        """Switch everything off."""
        self.ptys.close()
        self.streamer.close()

    def happen(self, order: str) -> float:
        """Let something happen; any thread may call it.

            cover N, uncover N     something lies on robot N, in the pictures
            take N, put N          robot N is taken off the floor, and put back where it was
            close N, open N        the serial port of robot N goes, and comes back
            block N, unblock N     it takes nothing, and everything again
            deafen N, undeafen N   it takes all, but robot N reads nothing; and everything again
            freeze, thaw           the camera shows one picture over and over
            unplug, plug           the camera is gone, and comes back
            jump S                 times in the stream are S seconds ahead of the world's

        Args:
            order: one of these.

        Returns:
            When it began [s].
        """
        t, (verb, *objects) = self.now(), order.split()
        befall = self._of_robots if verb in _OF_ROBOTS else self._of_the_camera
        befall(verb, objects[0] if objects else "")
        self._events.append({"t": t, "order": order})
        return t

    def truth(self) -> dict[str, Any]:
        """All that happened so far, as JSON takes it."""
        usage = resource.getrusage(resource.RUSAGE_SELF)
        return {
            "origin_monotonic_s": self._origin,
            "duration_s": self.now(),
            "cpu_s": usage.ru_utime + usage.ru_stime,
            "events": list(self._events),
            "frames": list(self._frames),
            "robots": [_robot_truth(*robot) for robot in self.miabots.items()],
        }

    def _of_robots(self, verb: str, name: str) -> None:
        robot = next(robot for robot in self.miabots if str(robot) == name)
        index = list(self.miabots).index(robot)
        deeds: dict[str, Callable[[], object]] = {
            "cover": partial(self._covered.add, robot),
            "uncover": partial(self._covered.discard, robot),
            "take": partial(self._take, robot),
            "put": partial(self._taken.discard, robot),
            "close": partial(self.ptys.unplug, index),
            "open": partial(self.ptys.plug, index),
            "block": partial(self.ptys.deafen, index, True),
            "unblock": partial(self.ptys.listen, index),
            "deafen": partial(self.ptys.deafen, index, False),
            "undeafen": partial(self.ptys.listen, index),
        }
        deeds[verb]()

    def _of_the_camera(self, verb: str, value: str) -> None:
        deeds: dict[str, Callable[[], object]] = {
            "freeze": partial(setattr, self, "_frozen", True),
            "thaw": partial(setattr, self, "_frozen", False),
            "unplug": self.streamer.unplug,
            "plug": self.streamer.plug,
            "jump": partial(self._jump, value),
        }
        deeds[verb]()

    def _take(self, robot: RobotId) -> None:
        self._taken.add(robot)
        with self._lock:  # behind the commands that are on their way
            self.world.command(robot, STANDSTILL, self.now() + self._scenario.radio.delay_s)

    def _jump(self, seconds: str) -> None:
        """A stream cannot go back in time: the camera restarts with another clock."""
        self.streamer.unplug()
        self._lead = float(seconds)
        self.streamer.plug()

    def _film(self, t: float) -> None:
        with self._lock:
            self.world.advance(max(t, self.world.t))
            states, clearance = self.world.states(t), self.world.clearance()
        image = self._picture(states, t)
        rendered = self.now()
        self.streamer.publish(image, t + self._lead)
        robots = [
            {"id": r.robot_id, "x_m": s.x, "y_m": s.y, "theta_rad": s.theta, "v_mps": s.v,
             "omega_radps": s.omega}
            for r in states for s in (r.state,)
        ]  # fmt: skip
        timing = {"t": t, "rendered_t": rendered, "published_t": self.now()}
        self._frames.append({**timing, "clearance_m": clearance, "robots": robots})

    def _picture(self, states: tuple[RobotState, ...], t: float) -> Image:
        """What the camera shows now: all robots but the taken, hands on the covered."""
        if self._frozen:
            return self._shown
        there = tuple(state for state in states if state.robot_id not in self._taken)
        image = self._renderer.render(there, t).copy()
        for state in there:
            if state.robot_id in self._covered:
                self._cover(image, state.state.x, state.state.y)
        self._shown = image
        return image

    def _cover(self, image: Image, x: float, y: float) -> None:
        z = self._camera.tag_height
        (u, v), (rim, _) = self._camera.project(np.array([[x, y, z], [x + HAND_RADIUS, y, z]]))
        cv2.circle(image, (round(u), round(v)), round(abs(rim - u)), HAND_BGR, cv2.FILLED)

    def _drive(self, robot_id: RobotId, track: float, left: float, right: float, t: float) -> None:
        if robot_id in self._taken:  # its wheels turn in the air
            return
        twist = twist_from_wheels(WheelSpeeds(left, right), track)
        with self._lock:
            self.world.advance(t)
            self.world.command(robot_id, twist, t + self._scenario.radio.delay_s)


_OF_ROBOTS = (
    "cover", "uncover", "take", "put", "close", "open", "block", "unblock", "deafen", "undeafen",
)  # fmt: skip


def _robot_truth(robot_id: RobotId, miabot: Miabot) -> dict[str, Any]:
    return {
        "id": robot_id,
        "commands": miabot.commands(),
        "stops": [t for t, text in miabot.received if text == "s"],
        "greetings": [t for t, text in miabot.received if text.startswith(".vTO")],
        "timeout_s": miabot.timeout,
        "timeouts": miabot.timeouts,
        "errors": miabot.errors,
        "wheels": miabot.wheels,
    }
