"""What `echelon calibrate robots` does: connect, look, move, fit, write, tell."""

from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

import typer

from pipeline.calibration.drive_figures import common_figures, figures_of
from pipeline.calibration.drive_file import drives_text, write_drives
from pipeline.calibration.ground import Ground, make_ground, survey
from pipeline.calibration.moving import Moved, calibrate_by_moving, look_for_all
from pipeline.calibration.pairing import mistaken, paired_spec
from pipeline.calibration.pattern import DRIVING
from pipeline.calibration.watch import Bench, Interrupted
from pipeline.camera_model import require_floor
from pipeline.cli.output import Output
from pipeline.cli.robots_told import drives_json, tell_drives, tell_plan
from pipeline.config import Scenario
from pipeline.errors import ConfigError
from pipeline.interruption import interruption
from pipeline.lookout import make_lookout
from pipeline.readiness import ready_to_drive
from pipeline.rigs import connect
from pipeline.scenario import load_scenario

INTERRUPTED = 130


@dataclass(frozen=True, slots=True)
class RobotsRequest:
    """What `echelon calibrate robots` was asked for.

    Attributes:
        scenario: name or file.
        camera: SPEC.
        radio: SPEC, None for the camera's default.
        fast: whether time jumps.
        seed: of the rendered world.
        overrides: "section.key=value" texts.
    """

    scenario: str
    camera: str = "rendered"
    radio: str | None = None
    fast: bool = False
    seed: int = 0
    overrides: tuple[str, ...] = ()

    @property
    def spec(self) -> str:
        """SPEC of the radio."""
        return self.radio or ("simulated" if self.camera == "rendered" else "none")


def calibrate_robots(request: RobotsRequest, out: Path, output: Output) -> None:
    """Move the robots, and write what that tells.

    Args:
        request: scenario and devices.
        out: the TOML fragment.
        output: where to say it.

    Raises:
        ConfigError: if the scenario is wrong, the floor is not clear, or a robot is not seen.
        SafetyStop: if a robot is lost or leaves its circle, or the camera is silent.
        RadioError: if the radio fails, or radios and tags cannot be paired.
        CameraError: if the camera fails.
        Exit: with status 130 after Ctrl-C.
    """
    if request.spec == "none":
        raise ConfigError("calibrate robots: needs a radio: --radio SPEC")
    scenario = load_scenario(request.scenario, request.overrides)
    with _bench(scenario, request, request.spec, output) as (bench, ground):
        moved = calibrate_by_moving(bench, ground, scenario.commanded)
    figures = {tag: figures_of(fit, scenario.radio) for tag, fit in moved.fits.items()}
    common = common_figures(tuple(figures.values()))
    spec = paired_spec(request.spec, moved.pairing)
    notes = (f"Scenario {scenario.name}, camera {request.camera}.", *_radio_notes(moved, spec))
    write_drives(out, drives_text(common, figures, scenario.camera, notes))
    if output.as_json:
        output.object({"file": str(out), "radio": spec, **drives_json(moved, figures, common)})
    else:
        tell_drives(moved, figures, common, spec, output)
        output.say(f'{out}: include it in a scenario: include = ["{out.name}"]')


def plan_robots(request: RobotsRequest, output: Output) -> None:
    """Look, and say what would be done; no radio is opened.

    Args:
        request: scenario and camera.
        output: where to say it.

    Raises:
        ConfigError: if the scenario is wrong, the floor is not clear, or a robot is not seen.
        CameraError: if the camera fails.
        Exit: with status 130 after Ctrl-C.
    """
    scenario = load_scenario(request.scenario, request.overrides)
    robots = scenario.commanded
    with _bench(scenario, request, "none", output) as (bench, ground):
        surveyed = survey(bench, look_for_all(bench, robots), ground, DRIVING)
    each = {robot: surveyed[robot] for robot in robots if robot in surveyed}
    rows = [
        {"id": robot, "x_m": circle.x, "y_m": circle.y, "circle_m": circle.radius,
         "clear_floor_m": ground.needed(circle), "in_the_way": list(lines)}
        for robot, (circle, lines) in each.items()
    ]  # fmt: skip
    if output.as_json:
        output.object({"pattern_s": DRIVING.duration, "robots": rows})
    else:
        tell_plan(rows, output)
    refusals = [line for _, lines in each.values() for line in lines]
    if refusals:
        raise ConfigError(f"not clear: {'; '.join(refusals)}")


@contextmanager
def _bench(
    scenario: Scenario, request: RobotsRequest, radio: str, output: Output
) -> Iterator[tuple[Bench, Ground]]:
    """Open everything; Ctrl-C is told after stop was sent."""
    require_floor(scenario.camera, "calibrate robots")
    seeing = ready_to_drive(scenario)
    ground = make_ground(scenario, seeing.camera, max(tag.side for tag in seeing.tags.tags))
    spec = (request.camera, radio, request.seed, request.fast)
    with interruption() as interrupted, closing(connect(scenario, *spec, interrupted)) as rig:
        try:
            yield Bench(rig, make_lookout(scenario, seeing), interrupted, output.say), ground
        except Interrupted:
            output.say("interrupted: stop was sent to every robot three times")
            raise typer.Exit(INTERRUPTED) from None


def _radio_notes(moved: Moved, spec: str) -> tuple[str, ...]:
    """Which radio is whose, as the command line takes it."""
    wrong = mistaken(moved.pairing)
    return (*(f"{line}." for line in wrong), f"The radio that reaches them: --radio {spec}")
