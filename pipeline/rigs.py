"""Connecting a run: the rendered world, or real cameras and radios."""

from collections.abc import Callable
from math import radians

from control.command import Command, RobotId
from control.unicycle import UnicycleState
from datasets.carried import CarriedWay, carried_way
from datasets.cycle import RobotState
from datasets.world import Disturbance, RobotPlant, World
from pipeline.camera_config import CameraConfig
from pipeline.cameras.capture_format import CaptureFormat
from pipeline.cameras.newest import Habits
from pipeline.cameras.open import CameraRequest, open_camera
from pipeline.cameras.options import DeviceOptions
from pipeline.cameras.rendered import RenderedCamera
from pipeline.clock import MonotonicClock, VirtualClock
from pipeline.config import RobotConfig, Scenario
from pipeline.course import path_of
from pipeline.errors import ConfigError
from pipeline.filming import make_delivery, make_renderer
from pipeline.leader_config import StartConfig
from pipeline.live import Rig
from pipeline.ports import Clock, CommandSink
from pipeline.radio_config import radio_settings
from pipeline.radios.none import NoRadio
from pipeline.radios.open import open_radio
from pipeline.radios.simulated import Copies, SimulatedRadio

Interrupted = Callable[[], bool]


class Tee:
    """Two radios that get the same commands: robots that are seen, and robots that turn.

    Attributes:
        parts: the two radios.
        min_period: of the slower one [s].
    """

    def __init__(self, first: CommandSink, second: CommandSink) -> None:
        """Join two radios.

        Args:
            first: for example the simulated one.
            second: for example a real one.
        """
        self.parts = first, second
        self.min_period = max(first.min_period, second.min_period)

    def send(self, commands: tuple[Command, ...], now: float) -> tuple[RobotId, ...]:
        """Send to both.

        Args:
            commands: at most one per robot.
            now: the moment of the cycle [s].

        Returns:
            Robots whose link is down on either.
        """
        lost = [sink.send(commands, now) for sink in self.parts]
        return tuple(dict.fromkeys((*lost[0], *lost[1])))

    def stop(self, now: float) -> None:
        """Stop the robots of both.

        Args:
            now: the moment of the call [s].
        """
        for sink in self.parts:
            sink.stop(now)

    def close(self) -> None:
        """Release both."""
        for sink in self.parts:
            sink.close()


def connect(
    scenario: Scenario,
    camera: str,
    radio: str | None,
    seed: int = 0,
    fast: bool = False,
    interrupted: Interrupted = lambda: False,
) -> Rig:
    """Open what the two SPECs name.

    Args:
        scenario: camera, robots, radio settings.
        camera: SPEC of the camera.
        radio: SPEC of the radio; None: simulated with the rendered camera, none with others.
        seed: of the rendered world.
        fast: whether time jumps instead of passing; rendered camera only.
        interrupted: asked while robots are waited for.

    Returns:
        The rig, everything open, without observers.

    Raises:
        ConfigError: if the SPECs do not fit each other.
        CameraError: if the camera cannot be opened.
        RadioError: if the radio cannot be opened.
        KeyboardInterrupt: if the wait for robots was interrupted.
    """
    if camera == "rendered":
        return _rendered(scenario, radio or "simulated", seed, fast, interrupted)
    if fast:
        raise ConfigError("--fast needs the rendered camera: a real one has its own time")
    if radio == "simulated":
        raise ConfigError("simulated robots are seen by the rendered camera only; use --radio none")
    clock = MonotonicClock()
    request = camera_request(scenario.camera)
    sink = _real_radio(scenario, radio or "none", clock, interrupted)
    try:
        return Rig(open_camera(camera, clock, request), sink, clock)
    except Exception:
        sink.close()
        raise


def camera_request(camera: CameraConfig) -> CameraRequest:
    """What a scenario asks of a real camera.

    Args:
        camera: its section.

    Returns:
        Latency, format, options and what is expected.
    """
    asked = camera.device.model_dump(exclude={"pixel_format"})
    return CameraRequest(
        camera.latency_s,
        CaptureFormat((camera.width_px, camera.height_px), camera.fps, camera.device.pixel_format),
        DeviceOptions(**asked),
        Habits(fps=camera.fps, repeats=camera.repeats),
    )


def make_world(scenario: Scenario, seed: int = 0) -> World:
    """The simulated robots of a scenario, which stop themselves as Miabots do.

    Args:
        scenario: with a start for every robot.
        seed: of the disturbances.

    Returns:
        The world at t = 0.

    Raises:
        ConfigError: if a robot has no start.
    """
    timeout = 1e-3 * scenario.radio.timeout_ms
    return World(tuple(_plant(robot, timeout) for robot in scenario.robots), seed)


def make_rendered_camera(
    scenario: Scenario, world: World, seed: int = 0, duration: float | None = None
) -> RenderedCamera:
    """The camera of a scenario, looking at a world.

    Args:
        scenario: camera, sensor, surroundings, tags and colours.
        world: what it looks at.
        seed: of all that is random in pictures and delivery.
        duration: no picture is taken from this time on [s]; None: without end.

    Returns:
        The camera.

    Raises:
        ConfigError: if the tags are inconsistent, or the camera's floor is unknown.
    """
    c, delivery = scenario.camera, make_delivery(scenario.camera, seed)
    renderer = make_renderer(scenario, seed)
    return RenderedCamera(world, renderer, c.fps, c.latency_s, duration, delivery)


def _rendered(
    scenario: Scenario, radio: str, seed: int, fast: bool, interrupted: Interrupted
) -> Rig:
    world = make_world(scenario, seed)
    clock: Clock = VirtualClock() if fast else MonotonicClock()
    sink: CommandSink = _simulated_radio(scenario, world, seed)
    if radio == "none":
        sink = NoRadio()
    elif radio != "simulated":
        sink = Tee(sink, _real_radio(scenario, radio, clock, interrupted))
    camera = make_rendered_camera(scenario, world, seed)
    truth: Callable[[], tuple[RobotState, ...]] = world.truth
    return Rig(camera, sink, clock, truth)


def _simulated_radio(scenario: Scenario, world: World, seed: int) -> SimulatedRadio:
    r = scenario.radio
    copies = Copies(r.duplication, r.duplicate_delay_s)
    return SimulatedRadio(world, r.delay_s, r.loss, r.bandwidth_bytes_per_s, seed, copies)


def _real_radio(
    scenario: Scenario, spec: str, clock: Clock, interrupted: Interrupted
) -> CommandSink:
    settings = radio_settings(scenario.radio)
    return open_radio(spec, clock, settings, scenario.commanded, interrupted)


def _plant(robot: RobotConfig, timeout: float) -> RobotPlant:
    if robot.start is None:
        raise ConfigError(f"robot {robot.id}: a rendered world needs its start (x_m, y_m)")
    return RobotPlant(
        robot.id, _state(robot.start), robot.lag_s, robot.mass_error, robot.inertia_error,
        disturbance=Disturbance(robot.disturbance_mps2, robot.turn_disturbance_radps2),
        carried=_carried(robot, robot.start), timeout=timeout,
    )  # fmt: skip


def _carried(robot: RobotConfig, start: StartConfig) -> CarriedWay | None:
    if robot.carried is None:
        return None
    way = robot.carried
    return carried_way(
        path_of(way.segments, start, 1.0, 0.0), way.speed_mps, way.ramp_s, way.begins_s
    )


def _state(start: StartConfig) -> UnicycleState:
    return UnicycleState(
        start.x_m, start.y_m, radians(start.theta_deg), start.v_mps, start.omega_radps
    )
