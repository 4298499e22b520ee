"""What `echelon calibrate robots` says: tables for people, JSON for programs."""

from collections.abc import Mapping, Sequence
from math import degrees
from typing import Any

from control.command import RobotId
from control.drive_fit import DriveFit
from pipeline.calibration.drive_figures import DriveFigures, Figure
from pipeline.calibration.moving import Moved
from pipeline.calibration.pairing import mistaken
from pipeline.calibration.pattern import DRIVING
from pipeline.cli.output import Output


def tell_drives(
    moved: Moved,
    figures: Mapping[RobotId, DriveFigures],
    common: DriveFigures,
    spec: str,
    output: Output,
) -> None:
    """Print what was found.

    Args:
        moved: pairing and fits.
        figures: by robot.
        common: means of all robots.
        spec: the radio's right SPEC.
        output: where to say it.
    """
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


def tell_plan(rows: Sequence[Mapping[str, Any]], output: Output) -> None:
    """Print what would be done.

    Args:
        rows: one per robot, as JSON has them.
        output: where to say it.
    """
    output.say("1. every radio's robot turns left by 45 deg and back; the tag that turns is its")
    output.say(f"2. one after the other drives for {DRIVING.duration:.1f} s in its circle")
    header = ("robot", "x m", "y m", "circle m", "clear floor m", "in the way")
    numbers = ("x_m", "y_m", "circle_m", "clear_floor_m")
    cells = [
        (str(row["id"]), *(f"{row[key]:.2f}" for key in numbers), str(len(row["in_the_way"])))
        for row in rows
    ]
    output.table("Robots", header, cells)


def drives_json(
    moved: Moved, figures: Mapping[RobotId, DriveFigures], common: DriveFigures
) -> dict[str, Any]:
    """What was found, for programs.

    Args:
        moved: pairing and fits.
        figures: by robot.
        common: means of all robots.

    Returns:
        JSON-able.
    """
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
