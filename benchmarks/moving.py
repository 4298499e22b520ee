"""`python -m benchmarks.moving 8`: robots with hidden drives, calibrated by moving; their errors.

Every world is the paper's, filmed with its sensor. Gains, track widths, lags and latencies are
drawn; the program believes the paper's values, and the pictures carry no times but that of their
arrival less the believed latency, as those of most cameras.
"""

import sys
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace

import numpy as np

from control.command import RobotId
from pipeline.calibration.drive_figures import figures_of
from pipeline.calibration.ground import make_ground
from pipeline.calibration.moving import Moved, calibrate_by_moving
from pipeline.calibration.watch import Bench
from pipeline.config import Scenario
from pipeline.lookout import make_lookout
from pipeline.ports import FrameSource
from pipeline.readiness import ready_to_drive
from pipeline.rigs import connect
from pipeline.scenario import load_scenario
from vision.frame import Frame

BELIEVED = load_scenario(
    "paper",
    (
        "robots.1.start={x_m=0.1, y_m=0.1}",
        "robots.2.start={x_m=0.6, y_m=0.7, theta_deg=130}",
        "robots.3.start={x_m=1.1, y_m=0.2, theta_deg=-70}",
        "safety.arena_m=[-0.6, -0.5, 1.7, 1.3]",
    ),
)
"""The paper's scenario with robots that have room about them."""


@dataclass(frozen=True, slots=True)
class Truth:
    """What is hidden of one robot.

    Attributes:
        scale: velocity it reaches per velocity commanded.
        track: its track width by the believed one.
        lag: of its motors [s].
    """

    scale: float
    track: float
    lag: float


@dataclass(frozen=True, slots=True)
class HiddenWorld:
    """What is hidden of a room.

    Attributes:
        robots: by id.
        camera_latency: from picture to arrival [s].
        radio_delay: from sending to the wheels [s].
    """

    robots: dict[RobotId, Truth]
    camera_latency: float
    radio_delay: float

    @property
    def latency(self) -> float:
        """From sending to the effect in a picture at hand, beside the motors' lag [s]."""
        return self.camera_latency + self.radio_delay


@dataclass(frozen=True, slots=True)
class Errors:
    """Of what was found about a robot.

    Attributes:
        latency: measured less true [s].
        lag: relative.
        scale: of the speed, relative.
        track: relative.
    """

    latency: float
    lag: float
    scale: float
    track: float


class Dated:
    """A camera whose pictures are dated by their arrival, as far as that can be believed."""

    def __init__(self, source: FrameSource, too_old: float) -> None:
        """Look through a camera that dates its pictures itself.

        Args:
            source: the camera.
            too_old: by how much the believed latency is too great [s].
        """
        self._source, self._too_old = source, too_old

    def latest(self, now: float) -> Frame | None:
        """The newest picture, dated anew.

        Args:
            now: the moment of the cycle [s].

        Returns:
            The picture, None if there is no new one.
        """
        frame = self._source.latest(now)
        return frame and replace(frame, t_capture=frame.t_capture - self._too_old)

    def close(self) -> None:
        """Release the camera."""
        self._source.close()


def drawn_world(seed: int) -> HiddenWorld:
    """Draw what is hidden.

    Args:
        seed: decides.

    Returns:
        Scales of 0.8 to 1.2, track widths 10 % off, lags of 0.03 to 0.15 s, 20 to 80 ms latency.
    """
    rng = np.random.default_rng((seed, 20081))
    robots: dict[RobotId, Truth] = {
        robot.id: Truth(*rng.uniform((0.8, 0.9, 0.03), (1.2, 1.1, 0.15)).tolist())
        for robot in BELIEVED.robots
    }
    latency, radio = rng.uniform((0.02, 0.1), (0.08, 0.5)).tolist()
    return HiddenWorld(robots, (1.0 - radio) * latency, radio * latency)


def measured(world: HiddenWorld, seed: int) -> Moved:
    """Calibrate by moving in a world that nobody knows.

    Args:
        world: what is hidden.
        seed: of the sensor's noise.

    Returns:
        What was found.
    """
    seeing = ready_to_drive(BELIEVED)
    ground = make_ground(BELIEVED, seeing.camera, seeing.tags.tags[0].side)
    with closing(connect(_true_scenario(world), "rendered", None, seed, True)) as rig:
        too_old = BELIEVED.camera.latency_s - world.camera_latency
        rig = replace(rig, source=Dated(rig.source, too_old))
        bench = Bench(rig, make_lookout(BELIEVED, seeing), lambda: False, lambda _: None)
        return calibrate_by_moving(bench, ground, tuple(world.robots))


def errors(world: HiddenWorld, moved: Moved) -> Iterator[Errors]:
    """Compare what was found with what was hidden.

    Args:
        world: what was hidden.
        moved: what was found.

    Yields:
        The errors of every robot.
    """
    radio = BELIEVED.radio
    for robot, fit in moved.fits.items():
        true, got = world.robots[robot], figures_of(fit, radio)
        scale, track = radio.speed_scale_per_mps / true.scale, radio.track_width_m * true.track
        yield Errors(
            moved.age + fit.delay - world.latency,
            got.lag.value / true.lag - 1.0,
            got.speed_scale.value / scale - 1.0,
            got.track_width.value / track - 1.0,
        )


def main() -> None:
    """Print a line per robot, and the worst of all."""
    print("world robot  scale  track  lag ms  latency ms | errors: scale %  track %  lag %  ms")
    found: list[Errors] = []
    for seed in range(int(sys.argv[1])):
        world = drawn_world(seed)
        for robot, error in zip(world.robots, errors(world, measured(world, seed)), strict=True):
            found.append(error)
            true = world.robots[robot]
            hidden = f"{true.scale:6.3f} {true.track:6.3f} {1e3 * true.lag:7.1f}"
            print(f"{seed:5} {robot:5} {hidden} {1e3 * world.latency:11.1f} | {_line(error)}")
    print(f"worst of {len(found)} robots:{'':21} | {_line(_worst(found))}")


def _worst(found: Sequence[Errors]) -> Errors:
    """The greatest error of each kind."""
    kinds = zip(*((e.latency, e.lag, e.scale, e.track) for e in found), strict=True)
    return Errors(*(max(map(abs, kind)) for kind in kinds))


def _line(e: Errors) -> str:
    scale, track, lag = 100.0 * e.scale, 100.0 * e.track, 100.0 * e.lag
    return f"{scale:15.2f} {track:8.2f} {lag:6.2f} {1e3 * e.latency:5.2f}"


def _true_scenario(world: HiddenWorld) -> Scenario:
    """The scenario that the rendered world obeys."""
    robots = tuple(
        robot.model_copy(update={
            "mass_error": t.scale - 1.0, "inertia_error": t.scale / t.track - 1.0, "lag_s": t.lag,
        })
        for robot in BELIEVED.robots for t in (world.robots[robot.id],)
    )  # fmt: skip
    camera = BELIEVED.camera.model_copy(update={"latency_s": world.camera_latency})
    radio = BELIEVED.radio.model_copy(update={"delay_s": world.radio_delay})
    return BELIEVED.model_copy(update={"robots": robots, "camera": camera, "radio": radio})


if __name__ == "__main__":
    main()
