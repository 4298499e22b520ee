"""Connecting a run: the rendered world, or real cameras and radios."""

from collections.abc import Callable
from math import radians

from control.command import Command, RobotId
from control.unicycle import UnicycleState
from datasets.cycle import RobotState
from datasets.render import Renderer
from datasets.sensor import SensorModel
from datasets.world import RobotPlant, World
from pipeline.cameras.device import CaptureFormat
from pipeline.cameras.open import CameraRequest, open_camera
from pipeline.cameras.rendered import RenderedCamera
from pipeline.clock import MonotonicClock, VirtualClock
from pipeline.config import RobotConfig, Scenario, SensorConfig, StartConfig
from pipeline.errors import ConfigError
from pipeline.live import Rig
from pipeline.ports import Clock, CommandSink
from pipeline.radios.miabot import MiabotSettings
from pipeline.radios.miabot_text import Drive
from pipeline.radios.none import NoRadio
from pipeline.radios.open import open_radio
from pipeline.radios.simulated import SimulatedRadio
from pipeline.seeing import make_camera, make_tags, named_colors, require_floor


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
    scenario: Scenario, camera: str, radio: str | None, seed: int = 0, fast: bool = False
) -> Rig:
    """Open what the two SPECs name.

    Args:
        scenario: camera, robots, radio settings.
        camera: SPEC of the camera.
        radio: SPEC of the radio; None: simulated with the rendered camera, none with others.
        seed: of the rendered world.
        fast: whether time jumps instead of passing; rendered camera only.

    Returns:
        The rig, everything open, without observers.

    Raises:
        ConfigError: if the SPECs do not fit each other.
        CameraError: if the camera cannot be opened.
        RadioError: if the radio cannot be opened.
    """
    if camera == "rendered":
        return _rendered(scenario, radio or "simulated", seed, fast)
    if fast:
        raise ConfigError("--fast needs the rendered camera: a real one has its own time")
    if radio == "simulated":
        raise ConfigError("simulated robots are seen by the rendered camera only; use --radio none")
    clock = MonotonicClock()
    c = scenario.camera
    request = CameraRequest(c.latency_s, CaptureFormat((c.width_px, c.height_px), c.fps))
    sink = _real_radio(scenario, radio or "none", clock)
    try:
        return Rig(open_camera(camera, clock, request), sink, clock)
    except Exception:
        sink.close()
        raise


def make_world(scenario: Scenario, seed: int = 0) -> World:
    """The simulated robots of a scenario.

    Args:
        scenario: with a start for every robot.
        seed: of the disturbances.

    Returns:
        The world at t = 0.

    Raises:
        ConfigError: if a robot has no start.
    """
    return World(tuple(_plant(robot) for robot in scenario.robots), seed)


def make_renderer(scenario: Scenario, seed: int = 0) -> Renderer:
    """The camera of a scenario, drawing.

    Args:
        scenario: camera, sensor, tags and colours.
        seed: of noise and floor.

    Returns:
        The renderer.

    Raises:
        ConfigError: if the camera's floor is unknown.
    """
    require_floor(scenario.camera, "the rendered camera")
    return Renderer(
        make_camera(scenario.camera),
        make_tags(scenario),
        named_colors(scenario),
        _sensor(scenario.sensor),
        seed,
    )


def _rendered(scenario: Scenario, radio: str, seed: int, fast: bool) -> Rig:
    world = make_world(scenario, seed)
    clock: Clock = VirtualClock() if fast else MonotonicClock()
    sink: CommandSink = _simulated_radio(scenario, world, seed)
    if radio == "none":
        sink = NoRadio()
    elif radio != "simulated":
        sink = Tee(sink, _real_radio(scenario, radio, clock))
    camera = RenderedCamera(
        world, make_renderer(scenario, seed), scenario.camera.fps, scenario.camera.latency_s
    )
    truth: Callable[[], tuple[RobotState, ...]] = world.truth
    return Rig(camera, sink, clock, truth)


def _simulated_radio(scenario: Scenario, world: World, seed: int) -> SimulatedRadio:
    r = scenario.radio
    return SimulatedRadio(world, r.delay_s, r.loss, r.bandwidth_bytes_per_s, seed)


def _real_radio(scenario: Scenario, spec: str, clock: Clock) -> CommandSink:
    if spec == "none":
        return NoRadio()
    r = scenario.radio
    drive = Drive(r.speed_scale_per_mps, r.track_width_m)
    robots = tuple(robot.id for robot in scenario.robots)
    return open_radio(spec, clock, MiabotSettings(drive, r.timeout_ms), robots)


def _plant(robot: RobotConfig) -> RobotPlant:
    if robot.start is None:
        raise ConfigError(f"robot {robot.id}: a rendered world needs its start (x_m, y_m)")
    return RobotPlant(
        robot.id, _state(robot.start), robot.lag_s, robot.mass_error, robot.inertia_error
    )


def _state(start: StartConfig) -> UnicycleState:
    return UnicycleState(
        start.x_m, start.y_m, radians(start.theta_deg), start.v_mps, start.omega_radps
    )


def _sensor(config: SensorConfig) -> SensorModel:
    return SensorModel(
        read_noise=config.read_noise,
        blur_px=config.blur_px,
        uneven_light=config.uneven_light,
        chroma=config.chroma,
        chroma_offset_px=config.chroma_offset_px,
        chroma_upsampling=config.chroma_upsampling,
        jpeg_quality=config.jpeg_quality,
    )
