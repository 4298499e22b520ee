"""`--sweep KEY=A,B,C`: which keys a simulation reads, and all combinations of their values."""

import difflib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import product

from pipeline.errors import ConfigError

SIMULATED = (
    "duration_s", "camera.fps", "camera.latency_s", "camera.stamp_jitter_s",
    "camera.dropped_share", "camera.repeated_share", "robots.*.start", "robots.*.lag_s",
    "robots.*.law", "robots.*.mass_error", "robots.*.inertia_error", "robots.*.disturbance_mps2",
    "robots.*.turn_disturbance_radps2", "formation", "leader", "control", "estimation", "startup",
    "radio.delay_s", "radio.loss", "radio.bandwidth_bytes_per_s", "safety.slow_after_s",
    "safety.stop_after_s", "safety.camera_silent_s", "safety.good_frames_s", "safety.give_up_s",
    "safety.clearance_m", "safety.approach_rate_per_s", "safety.arena_m", "simulation", "obstacles",
)  # fmt: skip
"""What a simulation reads of a scenario: keys, and sections whole."""


@dataclass(frozen=True, slots=True)
class Axis:
    """A key with the values it takes in turn.

    Attributes:
        key: of the scenario.
        values: as `--set` takes them.
    """

    key: str
    values: tuple[str, ...]


def parse_axes(texts: Sequence[str]) -> tuple[Axis, ...]:
    """Read what is to be swept.

    Args:
        texts: each "section.key=A,B,C"; values may be lists in brackets.

    Returns:
        One axis a text.

    Raises:
        ConfigError: if a text is no such thing, its key is not simulated, or comes twice.
    """
    axes = tuple(_axis(text) for text in texts)
    keys = [axis.key for axis in axes]
    twice = sorted({key for key in keys if keys.count(key) > 1})
    if twice:
        raise ConfigError(f"--sweep {twice[0]}: given twice; write its values into one")
    return axes


def combinations(axes: Sequence[Axis]) -> Iterator[dict[str, str]]:
    """Every combination of the values, the last axis fastest.

    Args:
        axes: what is swept.

    Yields:
        One value by key.
    """
    for values in product(*(axis.values for axis in axes)):
        yield dict(zip((axis.key for axis in axes), values, strict=True))


def _axis(text: str) -> Axis:
    key, equals, values = text.partition("=")
    key, split = key.strip(), [value.strip() for value in _split(values)]
    if not (equals and key and all(split)):
        raise ConfigError(f'--sweep {text}: need "section.key=A,B,C"')
    if not any(_reads(pattern, key) for pattern in SIMULATED):
        close = difflib.get_close_matches(key, SIMULATED, n=1, cutoff=0.7)
        hint = f'; did you mean "{close[0]}"?' if close else ""
        raise ConfigError(f'--sweep {text}: a simulation reads no key "{key}"{hint}')
    return Axis(key, tuple(split))


def _reads(pattern: str, key: str) -> bool:
    """Whether a key is a pattern's, or in the section that it names."""
    wanted, found = pattern.split("."), key.split(".")
    return len(found) >= len(wanted) and all(map(fnmatchcase, found, wanted))


def _split(text: str) -> list[str]:
    """At the commas that are in no bracket."""
    parts, depth = [""], 0
    for letter in text:
        depth += (letter in "[{") - (letter in "]}")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return parts
