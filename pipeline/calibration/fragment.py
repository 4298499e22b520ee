"""The TOML fragment that a scenario includes: written from a calibration, its lens read again."""

import tomllib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from pipeline.camera_config import LensConfig
from pipeline.errors import ConfigError
from vision.calibration.result import Calibration

Floats = NDArray[np.float64]


def write_fragment(
    path: Path, calibration: Calibration, tag_height: float | None, notes: Sequence[str]
) -> None:
    """Write a calibration as a part of a scenario.

    Args:
        path: of the TOML file.
        calibration: with or without a floor.
        tag_height: of the tags above the floor, None to leave it to the scenario [m].
        notes: sentences for the comment at the top.

    Raises:
        ConfigError: if the file cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(fragment_text(calibration, tag_height, notes), encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written ({error.strerror})") from None


def fragment_text(calibration: Calibration, tag_height: float | None, notes: Sequence[str]) -> str:
    """The text of a fragment.

    Args:
        calibration: with or without a floor.
        tag_height: of the tags above the floor, None to leave it to the scenario [m].
        notes: sentences for the comment at the top.

    Returns:
        TOML.
    """
    (width, height), lens = calibration.size_px, calibration.lens
    lines = [f"# {' '.join(note.split())}" for note in notes]
    lines += ["[camera]", f"width_px = {width}", f"height_px = {height}"]
    lines += [f"tag_height_m = {tag_height:g}"] if tag_height is not None else []
    lines += [] if calibration.floor else ['floor = "unknown"']
    lines += [
        "",
        "[camera.lens]",
        f"size_px = [{width}, {height}]",
        f"focal_px = {_list(lens[:2], 4)}",
        f"center_px = {_list(lens[2:4], 4)}",
        f"distortion = {_list(lens[4:], 8)}  # k1, k2, p1, p2, k3",
    ]
    if calibration.floor:
        lines += [
            "",
            "[camera.floor]",
            f"rotation_rad = {_list(calibration.floor.pose[:3], 8)}  # Rodrigues, camera_floor",
            f"translation_m = {_list(calibration.floor.pose[3:], 7)}",
        ]
    return "\n".join(lines) + "\n"


def read_lens(path: Path) -> tuple[Floats, tuple[int, int]]:
    """Read the lens of a fragment.

    Args:
        path: of the TOML file.

    Returns:
        fx, fy, cx, cy [px], k1, k2, p1, p2, k3, shape (9,); and the size of its pictures [px].

    Raises:
        ConfigError: if there is no lens in it.
    """
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
        lens = LensConfig.model_validate(table.get("camera", {}).get("lens", {}))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ConfigError(f"{path}: cannot be read: {error}") from None
    except (ValidationError, AttributeError):
        raise ConfigError(
            f"{path}: holds no [camera.lens] with size, focal lengths and centre"
        ) from None
    return np.array((*lens.focal_px, *lens.center_px, *lens.distortion)), lens.size_px


def _list(values: Floats, digits: int) -> str:
    """Numbers as a TOML array."""
    return "[" + ", ".join(f"{float(value) + 0.0:.{digits}f}" for value in values) + "]"
