"""The TOML fragment with a learned palette, for a scenario to include."""

from collections.abc import Iterable
from pathlib import Path

from pipeline.errors import ConfigError
from vision.calibration.colors import LearnedColors
from vision.calibration.rivals import Rival
from vision.tags import TagSet

_PER_LINE = 6  # samples
LIGHT = (0.45, 1.8)  # how much darker and brighter than measured a colour may appear


def write_palette(path: Path, text: str) -> None:
    """Write a fragment.

    Args:
        path: of the file; its folder is made if need be.
        text: of the fragment.

    Raises:
        ConfigError: if it cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written ({error.strerror})") from None


def palette_text(learned: LearnedColors, tags: TagSet, scenario: str, frames: list[str]) -> str:
    """Write down what was learned.

    Args:
        learned: the colours.
        tags: worn by the robots.
        scenario: its name.
        frames: what the pictures are called.

    Returns:
        The fragment: comments that say where it comes from, then `[palette]`.
    """
    teachers = sorted({str(tags.ids[lesson.tag]) for lesson in learned.lessons})
    lines = [
        "# Colours as the camera shows them, found by echelon calibrate colors.",
        "# A scenario includes this file by its name: include = [...].",
        f"# Scenario {scenario}; frames {', '.join(frames)}.",
        f"# {len(learned.lessons)} tags taught: robots {', '.join(teachers)}.",
        *(f"# {line}" for line in rival_lines(learned.rivals)),
        "",
        "[palette]",
        f"light = [{LIGHT[0]}, {LIGHT[1]}]  # darker and brighter than measured, as factors",
        "",
        "[palette.prints]  # blue, green, red of the prints, all in the same light",
        *(f"{_key(p.name)} = [{', '.join(f'{v:.1f}' for v in p.bgr)}]" for p in learned.prints),
        "",
        "[palette.samples]  # blue, green, red of measured pixels",
    ]
    for collected in learned.colors:
        pixels = [f"[{b}, {g}, {r}]" for b, g, r in collected.samples.pixels.tolist()]
        rows = [", ".join(pixels[n : n + _PER_LINE]) for n in range(0, len(pixels), _PER_LINE)]
        lines += [f"{_key(collected.samples.name)} = [", *(f"    {row}," for row in rows), "]"]
    return "\n".join(lines) + "\n"


def rival_lines(rivals: Iterable[Rival]) -> list[str]:
    """Say which colours are close.

    Args:
        rivals: pairs of colours, the closest first.

    Returns:
        A line for every pair that is not far apart; one that says so if all are.
    """
    close = [rival for rival in rivals if rival.verdict != "far apart"]
    if not close:
        return ["All colours are far apart in this light."]
    return [_rival_line(rival) for rival in close]


def _rival_line(rival: Rival) -> str:
    pairs = ", ".join(f"{one} and {other}" for one, other in rival.confused)
    what = f"would confuse robots {pairs}" if pairs else "no two robots differ by these alone"
    return (
        f"{rival.one} and {rival.other} are {rival.verdict} in this light: up to "
        f"{100.0 * rival.error:.1f} % of parts taken for the other; {what}."
    )


def _key(name: str) -> str:
    """A TOML key."""
    plain = name.replace("_", "").replace("-", "").isalnum() and name.isascii()
    return name if plain else f'"{name}"'
