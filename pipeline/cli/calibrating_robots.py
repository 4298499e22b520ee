"""What `echelon calibrate robots` does: connect, look, move, fit, write, tell."""

from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from math import degrees
from pathlib import Path
from typing import Any

import typer

from control.command import RobotId
from control.drive_fit import DriveFit
from control.estimation import load_filter
from pipeline.calibration.drive_figures import DriveFigures, Figure, common_figures, figures_of
from pipeline.calibration.drive_file import drives_text, write_drives
from pipeline.calibration.ground import Ground, make_ground, survey
from pipeline.calibration.moving import Moved, calibrate_by_moving, look_for_all
from pipeline.calibration.pairing import mistaken, paired_spec
from pipeline.calibration.patrol import Bench, Interrupted
from pipeline.calibration.pattern import DRIVING
from pipeline.camera_model import require_floor
from pipeline.cli.output import Output
from pipeline.config import Scenario
from pipeline.errors import ConfigError
from pipeline.interruption import interruption
from pipeline.lookout import make_lookout
from pipeline.rigs import connect
from pipeline.scenario import load_scenario
from pipeline.seeing import make_seeing

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
        moved = calibrate_by_moving(bench, ground, tuple(robot.id for robot in scenario.robots))
    figures = {tag: figures_of(fit, scenario.radio) for tag, fit in moved.fits.items()}
    common = common_figures(tuple(figures.values()))
    spec = paired_spec(request.spec, moved.pairing)
    notes = (f"Scenario {scenario.name}, camera {request.camera}.", *_radio_notes(moved, spec))
    write_drives(out, drives_text(common, figures, scenario.camera, notes))
    if output.as_json:
        output.object({"file": str(out), "radio": spec, **_as_json(moved, figures, common)})
    else:
        _tell(moved, figures, common, spec, out, output)


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
    robots = tuple(robot.id for robot in scenario.robots)
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
        _tell_plan(rows, output)
    refusals = [line for _, lines in each.values() for line in lines]
    if refusals:
        raise ConfigError(f"not clear: {'; '.join(refusals)}")


@contextmanager
def _bench(
    scenario: Scenario, request: RobotsRequest, radio: str, output: Output
) -> Iterator[tuple[Bench, Ground]]:
    """Open everything; Ctrl-C is told after stop was sent."""
    require_floor(scenario.camera, "calibrate robots")
    seeing = make_seeing(scenario)
    ground = make_ground(scenario, seeing.camera, max(tag.side for tag in seeing.tags.tags))
    load_filter()
    spec = (request.camera, radio, request.seed, request.fast)
    with interruption() as interrupted, closing(connect(scenario, *spec)) as rig:
        try:
            yield Bench(rig, make_lookout(scenario, seeing), interrupted, output.say), ground
        except Interrupted:
            output.say("interrupted: stop was sent to every robot three times")
            raise typer.Exit(INTERRUPTED) from None


def _radio_notes(moved: Moved, spec: str) -> tuple[str, ...]:
    """Which radio is whose, as the command line takes it."""
    wrong = mistaken(moved.pairing)
    return (*(f"{line}." for line in wrong), f"The radio that reaches them: --radio {spec}")


def _tell(
    moved: Moved,
    figures: Mapping[RobotId, DriveFigures],
    common: DriveFigures,
    spec: str,
    out: Path,
    output: Output,
) -> None:
    header = (
        "robot", "radio", "units per m/s", "track mm", "lag ms", "delay ms", "left mm", "deg",
    )  # fmt: skip
    radios = {tag: radio for radio, tag in moved.pairing.items()}
    rows = [_row(tag, radios[tag], f, moved.fits[tag]) for tag, f in figures.items()]
    output.table("How the robots drive (value +- standard error)", header, rows)
    for line in mistaken(moved.pairing):
        output.say(f"{line}; say --radio {spec}")
    output.say(_latency_told(common.delay, moved.age))
    apart = common.speed_scale.apart / common.speed_scale.value
    output.say(
        f"scale: the robots differ from their mean by up to {100.0 * apart:.1f} %, which the "
        "filter learns while it runs"
    )
    output.say(f'{out}: include it in a scenario: include = ["{out.name}"]')


def _row(tag: RobotId, radio: RobotId, f: DriveFigures, fit: DriveFit) -> tuple[str, ...]:
    return (
        str(tag), str(radio), _cell(f.speed_scale, 1.0, 1), _cell(f.track_width, 1e3, 2),
        _cell(f.lag, 1e3, 1), _cell(f.delay, 1e3, 1), f"{1e3 * fit.position_rms:.2f}",
        f"{degrees(fit.heading_rms):.2f}",
    )  # fmt: skip


def _cell(figure: Figure, factor: float, digits: int) -> str:
    return f"{factor * figure.value:.{digits}f} +- {factor * figure.std:.{digits}f}"


def _latency_told(delay: Figure, age: float) -> str:
    """Total latency; what is known of its parts."""
    return (
        f"latency: {1e3 * (delay.value + age):.1f} +- {1e3 * delay.std:.1f} ms from a command to "
        f"a picture at hand that shows its effect: {1e3 * delay.value:.1f} ms by the pictures' "
        f"own times, and {1e3 * age:.1f} ms that a picture is old on arrival; where a camera gives "
        "no times the second part is camera.latency_s itself, and only the sum is measured"
    )


def _tell_plan(rows: list[dict[str, Any]], output: Output) -> None:
    output.say("1. every radio's robot turns left by about 45 deg and back; the tag that turns "
               "is its own")  # fmt: skip
    output.say(f"2. one after the other drives for {DRIVING.duration:.1f} s in its circle")
    header = ("robot", "x m", "y m", "circle m", "clear floor m", "in the way")
    numbers = ("x_m", "y_m", "circle_m", "clear_floor_m")
    cells = [
        (str(row["id"]), *(f"{row[key]:.2f}" for key in numbers), str(len(row["in_the_way"])))
        for row in rows
    ]
    output.table("Robots", header, cells)


def _as_json(
    moved: Moved, figures: Mapping[RobotId, DriveFigures], common: DriveFigures
) -> dict[str, Any]:
    return {
        "pairing": [{"radio": radio, "tag": tag} for radio, tag in moved.pairing.items()],
        "robots": [
            {"id": tag, "forward_gain": fit.gain.v, "turning_gain": fit.gain.omega,
             "tag_on_robot": {"x_m": fit.mount.x, "y_m": fit.mount.y, "theta_rad": fit.mount.theta},
             "poses": fit.poses, "position_rms_m": fit.position_rms,
             "heading_rms_rad": fit.heading_rms, **_json_figures(figures[tag])}
            for tag, fit in moved.fits.items()
        ],
        "common": _json_figures(common),
        "picture_age_s": moved.age,
        "total_latency_s": common.delay.value + moved.age,
    }  # fmt: skip


def _json_figures(f: DriveFigures) -> dict[str, Any]:
    each = {
        "speed_scale_per_mps": f.speed_scale, "track_width_m": f.track_width,
        "lag_s": f.lag, "delay_s": f.delay,
    }  # fmt: skip
    return {k: {"value": v.value, "std": v.std, "apart": v.apart} for k, v in each.items()}
