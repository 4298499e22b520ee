"""Known points of the floor, from a TOML or CSV file."""

import csv
import tomllib
from pathlib import Path
from typing import Any

from pipeline.errors import ConfigError
from vision.calibration.points import KnownPoint

_KEYS = ("x_m", "y_m", "x_px", "y_px")
_OPTIONAL = ("z_m", "name")


def read_points(path: Path) -> tuple[KnownPoint, ...]:
    """Read points.

    Args:
        path: a CSV file whose first line names the columns x_m, y_m, x_px, y_px and perhaps z_m
            (height of a tag; 0 without it) and name; or a TOML file with the same keys in
            [[points]].

    Returns:
        The points in the order of the file.

    Raises:
        ConfigError: naming file, point and key.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
        rows = tomllib.loads(text).get("points", []) if path.suffix == ".toml" else _rows(text)
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError, csv.Error) as error:
        raise ConfigError(f"{path}: cannot be read: {error}") from None
    if not isinstance(rows, list) or not rows:
        raise ConfigError(f"{path}: holds no points; need {', '.join(_KEYS)} for each")
    return tuple(_point(path, number, row) for number, row in enumerate(rows, 1))


def _rows(text: str) -> list[dict[str, Any]]:
    """Lines of a CSV file by the names of their columns."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    semicolons = bool(lines) and lines[0].count(";") > lines[0].count(",")
    reader = csv.DictReader(lines, delimiter=";" if semicolons else ",", skipinitialspace=True)
    return list(reader)


def _point(path: Path, number: int, row: Any) -> KnownPoint:
    """One point."""
    where = f"{path}: point {number}"
    if not isinstance(row, dict):
        raise ConfigError(f"{where}: need {', '.join(_KEYS)}")
    row = {str(key).strip(): value for key, value in row.items() if key is not None}
    unknown = sorted(set(row) - set(_KEYS) - set(_OPTIONAL))
    if unknown:
        raise ConfigError(
            f'{where}: unknown key "{unknown[0]}"; keys are {", ".join(_KEYS)}, z_m, name'
        )
    x, y, u, v = (_number(where, row, key) for key in _KEYS)
    z = _number(where, row, "z_m") if row.get("z_m") not in (None, "") else 0.0
    return KnownPoint(str(row.get("name") or number), (x, y, z), (u, v))


def _number(where: str, row: dict[str, Any], key: str) -> float:
    """One finite number."""
    value = row.get(key)
    if value is None or value == "":
        raise ConfigError(f"{where}: {key} is missing")
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ConfigError(f'{where}: {key} = "{value}" is not a number') from None
    if not abs(number) < 1e6:
        raise ConfigError(f"{where}: {key} = {value} is not a sensible number")
    return number
