"""The TOML fragment that a scenario includes, written from a calibration by moving."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from control.command import RobotId
from pipeline.calibration.drive_figures import DriveFigures, Figure
from pipeline.camera_config import CameraConfig
from pipeline.errors import ConfigError


def write_drives(path: Path, text: str) -> None:
    """Write a fragment.

    Args:
        path: of the TOML file.
        text: its content.

    Raises:
        ConfigError: if the file cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written ({error.strerror})") from None


def drives_text(
    common: DriveFigures,
    robots: Mapping[RobotId, DriveFigures],
    camera: CameraConfig,
    notes: Sequence[str],
) -> str:
    """The text of a fragment.

    Args:
        common: what is believed of all robots.
        robots: figures of each, for the comment.
        camera: as it was while measuring.
        notes: sentences for the comment at the top.

    Returns:
        TOML.
    """
    lines = [
        "# How the robots drive, found by echelon calibrate robots.",
        "# A scenario includes this file by its name: include = [...].",
        *(f"# {' '.join(note.split())}" for note in notes),
        *(f"# robot {robot}: {figures_told(figures)}" for robot, figures in robots.items()),
        *_times(common.delay, camera),
        f"speed_scale_per_mps = {common.speed_scale.value:.1f}{_spread(common.speed_scale, 1.0)}",
        f"track_width_m = {common.track_width.value:.5f}{_spread(common.track_width, 1e3, ' mm')}",
        "",
        "[estimation]",
        f"lag_s = {max(common.lag.value, 1e-4):.4f}{_spread(common.lag, 1e3, ' ms')}",
    ]
    return "\n".join(lines) + "\n"


def figures_told(figures: DriveFigures) -> str:
    """A robot's figures in words.

    Args:
        figures: of one robot, or of all.

    Returns:
        Values with standard errors.
    """
    f = figures
    return (
        f"{f.speed_scale.value:.1f} +- {f.speed_scale.std:.1f} units per m/s, track width "
        f"{1e3 * f.track_width.value:.2f} +- {1e3 * f.track_width.std:.2f} mm, lag "
        f"{1e3 * f.lag.value:.1f} +- {1e3 * f.lag.std:.1f} ms, delay "
        f"{1e3 * f.delay.value:.1f} +- {1e3 * f.delay.std:.1f} ms"
    )


def _times(delay: Figure, camera: CameraConfig) -> tuple[str, ...]:
    """What makes the loop expect the effect of a command when it shows.

    A delay below 0 says that pictures are younger than `camera.latency_s` has dated them.
    """
    spread = _spread(delay, 1e3, " ms")
    if delay.value >= 0.0:
        return ("", "[radio]", f"delay_s = {delay.value:.4f}{spread}")
    latency = max(camera.latency_s + delay.value, 0.0)
    return (
        "", "[camera]", f"latency_s = {latency:.4f}{spread}",
        "", "[radio]", "delay_s = 0.0  # no part of it shows: see camera.latency_s",
    )  # fmt: skip


def _spread(figure: Figure, factor: float, unit: str = "") -> str:
    """A comment on how well a figure is known."""
    apart = f", robots up to {factor * figure.apart:.3g}{unit} apart" if figure.apart else ""
    return f"  # +- {factor * figure.std:.2g}{unit}{apart}"
