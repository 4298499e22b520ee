"""A study's result as files: NAME.png and NAME.csv."""

import csv
from io import BytesIO
from pathlib import Path

from pipeline.errors import ConfigError
from pipeline.report.style import house_style
from pipeline.studies.study import Result

_COLORS = 128  # of a PNG


def make_folder(out: Path) -> None:
    """Make the folder for the files, before hours are spent on what nobody could keep.

    Args:
        out: the folder; may exist.

    Raises:
        ConfigError: if it cannot be made or nothing can be written there.
    """
    probe = out / ".echelon-study"
    try:
        out.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise _refused(out, error) from None


def write_result(result: Result, name: str, out: Path) -> tuple[Path, Path]:
    """Write table and figure.

    Args:
        result: of the study.
        name: of the study.
        out: an existing folder.

    Returns:
        The PNG and the CSV.

    Raises:
        ConfigError: if a file cannot be written.
    """
    picture, table = out / f"{name}.png", out / f"{name}.csv"
    try:
        with table.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows((result.header, *result.rows))  # None is an empty cell
        picture.write_bytes(_png(result))
    except OSError as error:
        raise _refused(out, error) from None
    return picture, table


def _png(result: Result) -> bytes:
    """The figure, in few colours: a third of the size, and nobody sees the difference."""
    from PIL import Image  # comes with matplotlib

    drawn, small = BytesIO(), BytesIO()
    with house_style():
        result.draw().savefig(drawn, format="png")
    few = Image.open(drawn).convert("RGB").quantize(_COLORS, dither=Image.Dither.NONE)
    few.save(small, format="png", optimize=True)
    return small.getvalue()


def _refused(out: Path, error: OSError) -> ConfigError:
    return ConfigError(f"--out {out}: cannot be written ({error.strerror}); give another folder")
